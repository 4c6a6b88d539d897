"""Springs with a mass of their own: with the link they are two masses (paper, section II)."""

from types import SimpleNamespace

from elastic_tendon.effects.base import (
    Effect,
    HalfTensions,
    Parameter,
    Slot,
    SpringHalves,
    State,
)
from elastic_tendon.effects.symbolic import where


def equations(
    at: SpringHalves, p: SimpleNamespace, state: SimpleNamespace, _mode: SimpleNamespace
) -> HalfTensions:
    """A mass in the middle of each spring; without mass the middle follows both ends."""
    heavy = p.mass > 0
    middle = 0.5 * (at.motor_end + at.joint_end)
    middle_rate = 0.5 * (at.motor_rate + at.joint_rate)
    position = where(heavy, state.position, middle)
    velocity = where(heavy, state.velocity, middle_rate)
    motor = at.motor_half(position, velocity)
    joint = at.joint_half(position, velocity)
    drag = at.parallel * p.damping * (velocity - middle_rate)
    mass = at.parallel * where(heavy, p.mass, 1.0)
    return HalfTensions(
        motor=motor,
        joint=joint,
        rates={
            "position": where(heavy, velocity, 0.0),
            "velocity": where(heavy, (motor - joint - drag) / mass, 0.0),
        },
        starts={"position": middle, "velocity": middle_rate},
    )


EFFECT = Effect(
    id="spring_mass",
    title="Spring mass",
    slot=Slot.SPRING_MASS,
    catalogue_order=110,
    physics="The springs' own mass, thought of as concentrated in the middle of each: it has to be "
    "accelerated too and can swing between motor and joint, so spring and link are two masses.",
    in_data="A second resonance, far above the first, near sqrt(4 stiffness / mass) in rad/s of "
    "one spring, and a slightly lower first one. In fast motions the tendon's force at the joint "
    "lags behind that at the motor and rings, most of all after impacts and where a slack tendon "
    "(states I and II) is jerked taut. Slow motions agree with the model.",
    law="mass s'' = F_motor - F_joint - damping (s' - mean velocity of the spring's ends); s place "
    "of the mass, F_motor and F_joint forces of the two halves, each of twice the spring's "
    "stiffness and only pulling",
    confused_with="A larger inertia of the link: a quarter of each spring's mass seems to sit on "
    "the joint pulley, which explains the lower first resonance but not the second. Measurement "
    "delay: the joint answers late too, but nothing rings. Spring relaxation: it changes the "
    "stiffness at high frequency without a resonance.",
    confirm="Let the motor tremble with a rising frequency, up to ten times the natural one, or "
    "tap the link, and look for a second peak in the spectrum of the joint's position or torque. A "
    "small known weight in the middle of the spring moves that peak down.",
    cure="Lighter springs: at most a tenth of the effective link mass J / R² (paper, section II). "
    "Foam or a sleeve in the spring damps it. In control keep steps and jerks from the motor, and "
    "notch the second resonance.",
    magnitude="0.4 times the mass of a uniform coil spring gives its first resonance between two "
    "held ends; hooks and rope ends in the middle count in full. Damping ratios of steel springs "
    "are 0.001 to 0.02, with a sleeve up to 0.2.",
    parameters=(
        Parameter(
            name="mass",
            unit="kg",
            meaning="mass of one spring that moves with its middle",
            null=0.0,
            lower=0.0,
            upper=1.0e3,
            typical=lambda sizes: 0.02 * sizes.inertia / sizes.radius**2 / sizes.parallel,
            at_frequency=lambda sizes, frequency: 4.0 * sizes.stiffness / frequency**2,
        ),
        Parameter(
            name="damping",
            unit="N.s/m",
            meaning="damping of one mass's velocity relative to the mean of the spring's ends",
            null=0.0,
            lower=0.0,
            upper=1.0e6,
            typical=lambda sizes: (
                0.01 * sizes.inertia / sizes.radius**2 / sizes.parallel * sizes.frequency
            ),
        ),
    ),
    equations=equations,
    reference="Dynamic Modeling of Elastic Tendon Actuators with Tendon Slackening (the paper), "
    "section II; J. P. Den Hartog, Mechanical Vibrations, 4th edition, McGraw-Hill, 1956",
    states=(
        State("position", "m", "place of the mass along the tendon, towards the motor", 1e-2, None),
        State("velocity", "m/s", "velocity of the mass along the tendon", 1e-1, None),
    ),
    law_of="the springs' mass",
    singular_null=True,
)
