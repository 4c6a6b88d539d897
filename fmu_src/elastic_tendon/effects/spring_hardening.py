"""Springs that become stiffer the further they are stretched."""

from types import SimpleNamespace

from elastic_tendon.effects.base import Contribution, Effect, Parameter, Slot, Spring


def equations(
    at: Spring, p: SimpleNamespace, _state: SimpleNamespace, _mode: SimpleNamespace
) -> Contribution:
    """Force k3 e^3 beside the linear one."""
    return Contribution(p.cubic_stiffness * at.elongation**3)


EFFECT = Effect(
    id="spring_hardening",
    title="Spring hardening",
    slot=Slot.SPRING_LAW,
    catalogue_order=80,
    physics="A spring whose stiffness grows with its elongation, as of rubber, conical or "
    "progressively wound springs.",
    in_data="The torque-deflection curve bends where one tendon is slack (states I and II) instead "
    "of being straight: the joint is stiffer than the model the further it is deflected, alike in "
    "both directions where the springs are alike. There is no loop, and speed does not matter. The "
    "natural frequency rises with pretension, and large swings slow down less than slackening "
    "alone would make them.",
    law="added force of one spring: cubic_stiffness e³",
    confused_with="Overstretch protection: it has a corner, with level slopes before and after. A "
    "larger spring stiffness: the slope is then wrong by the same share at every deflection. Joint "
    "stop: it stands at one angle of the joint, hardening moves with the motor. Spring asymmetry: "
    "stiffer in one direction, softer in the other.",
    confirm="Hold the motor, load the link slowly and plot the slope of load torque against "
    "deflection: it climbs steadily beyond the slack boundaries. Or change the pretension: with "
    "linear springs the stiffness with both tendons taut stays the same. A single spring under "
    "weights shows it best.",
    cure="Cylindrical steel springs, used well inside their range. In control take torque and "
    "stiffness from the measured curve instead of one number, and schedule gains by deflection.",
    magnitude="cubic_stiffness max_deflection² / stiffness is the share of force added at the "
    "largest deflection: below 0.03 for steel coil springs, 0.2 to 2 for conical springs and for "
    "rubber near its limit.",
    parameters=(
        Parameter(
            name="cubic_stiffness",
            unit="N/m3",
            meaning="cubic stiffness k3 of one spring: force k e + k3 e^3",
            null=0.0,
            lower=0.0,
            upper=1.0e13,
            typical=lambda sizes: 0.3 * sizes.stiffness / sizes.max_deflection**2,
        ),
    ),
    equations=equations,
    reference="I. Kovacic, M. J. Brennan (editors), The Duffing Equation: Nonlinear Oscillators "
    "and their Behaviour, Wiley, 2011",
)
