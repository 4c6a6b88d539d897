"""Springs that are stiffer in one direction of the deflection than in the other."""

from types import SimpleNamespace

from elastic_tendon.effects.base import Contribution, Effect, Parameter, Slot, Spring


def equations(
    at: Spring, p: SimpleNamespace, _state: SimpleNamespace, _mode: SimpleNamespace
) -> Contribution:
    """Force k2 e^2 beside the linear one, of the lower spring -k2 e^2."""
    return Contribution(at.sign * p.square_stiffness * at.elongation**2)


EFFECT = Effect(
    id="spring_asymmetry",
    title="Spring asymmetry",
    slot=Slot.SPRING_LAW,
    catalogue_order=195,
    on_request=True,
    common_without_slack=True,
    physics="Springs of the two sides that bend differently as they are stretched: the upper "
    "becomes stiffer and the lower softer, or the other way round. Of a shaft or a leaf spring, "
    "one that is stiffer in one direction than in the other, as by a curved leaf or a clamp on one "
    "side.",
    in_data="Load torque against deflection is a parabola beside its straight line: steeper on one "
    "side of zero and flatter on the other, without a loop and alike at every speed, with both "
    "tendons taut as where one is slack. A vibration has its mean beside the place of rest, the "
    "farther the larger it is, and twice its frequency in it.",
    law="added force of the upper spring: square_stiffness e²; of the lower: -square_stiffness e²",
    confused_with="Spring hardening: it is alike in both directions, and a vibration then has "
    "three times its frequency in it. Unequal stiffnesses of the two springs: two straight lines "
    "with a corner where a tendon becomes slack. Constant torque, an encoder's offset: they shift "
    "the curve and leave its shape.",
    confirm="Hold the motor, load the link slowly in both directions and plot the slope of load "
    "torque against deflection: it climbs in a straight line through zero. With the springs of the "
    "two sides exchanged it falls.",
    cure="Springs of one batch, clamped alike. In control take torque and stiffness from the "
    "measured curve.",
    magnitude="square_stiffness max_deflection / stiffness is the share of force added at the "
    "largest deflection: below 0.02 for coil springs of one batch, 0.05 to 0.3 for curved leaf "
    "springs and rubber.",
    parameters=(
        Parameter(
            name="square_stiffness",
            unit="N/m2",
            meaning="square stiffness k2 of one spring: force k e + k2 e^2 of the upper one, "
            "k e - k2 e^2 of the lower",
            null=0.0,
            lower=-1.0e10,
            upper=1.0e10,
            typical=lambda sizes: 0.15 * sizes.stiffness / sizes.max_deflection,
        ),
    ),
    equations=equations,
    reference="I. Kovacic, M. J. Brennan (editors), The Duffing Equation: Nonlinear Oscillators "
    "and their Behaviour, Wiley, 2011",
)
