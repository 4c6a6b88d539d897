"""Damping of the joint that grows with the third power of its speed."""

from types import SimpleNamespace

from elastic_tendon.effects.base import Contribution, Effect, Joint, Parameter, Slot


def equations(
    at: Joint, p: SimpleNamespace, _state: SimpleNamespace, _mode: SimpleNamespace
) -> Contribution:
    """Torque -c v^3."""
    return Contribution(-p.coefficient * at.velocity**3)


EFFECT = Effect(
    id="cubic_damping",
    title="Cubic damping",
    slot=Slot.JOINT_TORQUE,
    catalogue_order=196,
    on_request=True,
    physics="Damping that grows faster than the square of the velocity: a damper whose valves "
    "narrow, a bearing that churns its grease at high speed, the first term by which any damping "
    "that is alike in both directions departs from a viscous one.",
    in_data="A torque against the velocity, alike in both directions and in every slack state. It "
    "is nothing in slow motion and rises steeply in the fastest. Resonance peaks become flatter "
    "as the excitation grows, and a vibration has three times its frequency in it.",
    law="-coefficient v³",
    confused_with="Quadratic drag: it rises less steeply; motions of which one is at least twice "
    "as fast as the other distinguish them. Viscous damping (link.damping): the same at one "
    "amplitude.",
    confirm="Move the joint at several constant speeds and plot the torque, less that of Coulomb "
    "and viscous friction, over the speed, both logarithmic: a slope of three, where drag has two.",
    cure="Less or thinner grease; slower motion. A damper that is meant to be so protects at large "
    "motions and leaves small ones alone. In control lead the motor by coefficient v³ over joint "
    "stiffness.",
    magnitude="coefficient v² / link.damping is its share beside viscous damping at the speed v: "
    "0.1 to 1 at the largest speed of dampers and of grease-lubricated gears.",
    parameters=(
        Parameter(
            name="coefficient",
            unit="N.m.s3/rad3",
            meaning="damping torque at 1 rad/s",
            null=0.0,
            lower=0.0,
            upper=1.0e4,
            typical=lambda sizes: 0.1 * sizes.inertia / sizes.frequency,
        ),
    ),
    equations=equations,
    reference="S. J. Elliott, M. Ghandchi Tehrani, R. S. Langley, Nonlinear damping and "
    "quasi-linear modelling, Philosophical Transactions of the Royal Society A 373, 2015",
)
