"""Drag of air or liquid on the link, proportional to the square of its speed."""

from types import SimpleNamespace

from elastic_tendon.effects.base import Contribution, Effect, Joint, Parameter, Slot
from elastic_tendon.effects.symbolic import absolute


def equations(
    at: Joint, p: SimpleNamespace, _state: SimpleNamespace, _mode: SimpleNamespace
) -> Contribution:
    """Torque -c v |v|."""
    return Contribution(-p.coefficient * at.velocity * absolute(at.velocity))


EFFECT = Effect(
    id="quadratic_drag",
    title="Quadratic drag",
    slot=Slot.JOINT_TORQUE,
    catalogue_order=40,
    physics="Resistance of the air or liquid that the link moves through, or that its gear churns: "
    "it grows with the square of the velocity.",
    in_data="A torque against the velocity, alike in both directions and in every slack state. "
    "Large oscillations are damped more, in proportion, than small ones, and slow motions agree "
    "with the model. It shows in fast slews and near the natural frequency, where the joint is "
    "fastest.",
    law="-coefficient v |v|",
    confused_with="Coulomb friction: it damps small oscillations most, drag large ones; within a "
    "narrow range of speeds they look alike. Viscous damping (link.damping): the same at one "
    "amplitude; oscillations of several amplitudes distinguish them. Cubic damping: it rises more "
    "steeply, and in slow motion is nothing. Directional damping: it pushes the same way in both "
    "directions.",
    confirm="Hold the motor, pluck the link from several angles and plot the logarithmic decrement "
    "of the swings against their amplitude: it is level with viscous damping, rises with drag and "
    "falls with Coulomb friction. A sheet of cardboard on the link makes drag larger and nothing "
    "else.",
    cure="A slimmer link; thinner or less oil in the gear. Often it is welcome, because it damps "
    "large motions. In control lead the motor by coefficient v |v| over joint stiffness.",
    magnitude="A bar of length L and width b that turns about its end has about ρ c_d b L⁴ / 8: "
    "4e-4 N·m·s²/rad² in air for 0.4 m by 0.08 m, and some 800 times that in water. It grows with "
    "the fourth power of the length.",
    parameters=(
        Parameter(
            name="coefficient",
            unit="N.m.s2/rad2",
            meaning="drag torque at 1 rad/s",
            null=0.0,
            lower=0.0,
            upper=1.0e4,
            typical=lambda sizes: 0.1 * sizes.inertia,
        ),
    ),
    equations=equations,
    reference="S. F. Hoerner, Fluid-Dynamic Drag, published by the author, 1965",
)
