"""Springs that creep under load and relax when held."""

from types import SimpleNamespace

from elastic_tendon.effects.base import Contribution, Effect, Parameter, Slot, Spring, State


def equations(
    at: Spring, p: SimpleNamespace, state: SimpleNamespace, _mode: SimpleNamespace
) -> Contribution:
    """A Maxwell branch beside the spring: standard linear solid."""
    stretch = at.elongation - state.creep
    return Contribution(
        value=p.stiffness * stretch,
        rates={"creep": stretch / p.time_constant},
        starts={"creep": at.elongation},
    )


EFFECT = Effect(
    id="spring_relaxation",
    title="Spring relaxation",
    slot=Slot.SPRING_LAW,
    catalogue_order=100,
    physics="Viscoelastic material, as of polymer ropes and rubber: a fast change meets an "
    "additional stiffness, which relaxes with a time constant.",
    in_data="After a step of the load the joint yields by a part at once and creeps on in the same "
    "direction; taken off, it creeps back. The joint is stiffer at high frequency than at low, "
    "with most damping in between, near 1 / time_constant in rad/s. Slow motions agree with the "
    "model; both directions are alike; only springs that are taut take part.",
    law="added force of one spring: stiffness (e - c), c' = (e - c) / time_constant; c starts at e",
    confused_with="Spring damping: it loses energy too, but does not stiffen the joint; at a "
    "single frequency the two look alike. Tendon compliance in series with damped springs: the "
    "same law in other numbers while the tendons are taut. Spring hysteresis: its loop stays in "
    "slow motion. Spring mass: it has a resonance of its own, relaxation only stiffens the joint "
    "in fast motion.",
    confirm="Hold the motor, hang a weight on the link and record for several time constants: when "
    "the swinging has died out the joint still creeps. Then load it by a slow and by a fast sine: "
    "the fast one finds a stiffer joint and a loop, the slow one no loop.",
    cure="Steel instead of polymer; ropes stretched for a day before use and tensioned again after "
    "they have settled. In control close the loop over the joint encoder.",
    magnitude="stiffness is 1 to 5 % of the spring's for steel ropes that still settle, 10 to 50 % "
    "for polymer ropes and rubber. Materials have many time constants, from milliseconds to days; "
    "a recording finds those between its sample time and its length. Warmth shortens them.",
    parameters=(
        Parameter(
            name="stiffness",
            unit="N/m",
            meaning="stiffness that one spring adds for fast motions",
            null=0.0,
            lower=0.0,
            upper=1.0e8,
            typical=lambda sizes: 0.2 * sizes.stiffness,
        ),
        Parameter(
            name="time_constant",
            unit="s",
            meaning="time in which the additional force falls to 1/e at constant elongation",
            null=1.0,
            lower=1.0e-5,
            upper=1.0e5,
            typical=lambda sizes: 3.0 / sizes.frequency,
            shape=True,
        ),
    ),
    equations=equations,
    reference="W. N. Findley, J. S. Lai, K. Onaran, Creep and Relaxation of Nonlinear Viscoelastic "
    "Materials, North-Holland, 1976",
    states=(State("creep", "m", "elongation of the relaxing damper", 1e-2, start=None),),
)
