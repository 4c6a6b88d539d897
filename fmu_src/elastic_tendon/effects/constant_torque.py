"""A constant torque on the joint that nobody told."""

from types import SimpleNamespace

from elastic_tendon.effects.base import Alias, Contribution, Effect, Joint, Parameter, Slot


def equations(
    _at: Joint, p: SimpleNamespace, _state: SimpleNamespace, _mode: SimpleNamespace
) -> Contribution:
    """The same torque everywhere."""
    return Contribution(p.torque)


EFFECT = Effect(
    id="constant_torque",
    title="Constant torque",
    slot=Slot.JOINT_TORQUE,
    catalogue_order=175,
    physics="A load that was not recorded: a hose or cable that pulls, a counterweight, the "
    "weight on a vertical axis, the zero of a load cell or of a drive's current.",
    in_data="The joint rests beside the motor's position by the same torque over its stiffness, so "
    "farther where a tendon is slack, at every angle, speed and direction. Load torque against "
    "deflection is shifted along the torque. With dry friction the joint sticks later in one "
    "direction than in the other.",
    law="torque",
    confused_with="Joint encoder offset: the same while both tendons are taut; a torque moves the "
    "joint farther where one is slack. Gravity load: its torque changes with the angle, and over a "
    "small range of angles the two are alike. Coulomb friction: it changes its sign with the "
    "velocity; a machine that moves in one direction only cannot distinguish the two. Directional "
    "damping: it vanishes at rest and in slow motion. Joint torque offset: the joint rests where "
    "it should, and only the measured torque is off. Spring asymmetry: it shifts what swings, and "
    "the farther the larger the swing is.",
    confirm="Hold the motor, push the joint gently to both sides and let it come to rest from "
    "each, at several angles and with another pretension: the mean of the two rest positions is "
    "beside the motor's by the torque over the stiffness, which changes with the pretension; the "
    "zero of an encoder does not.",
    cure="Record it, as load_torque. Set the zero of load cell or amplifier when they are warm, "
    "and lead hoses through the joint's axis. In control lead the motor by the torque over the "
    "joint's stiffness.",
    magnitude="Hoses and cables 1 to 10 % of the largest joint torque; a load cell's zero 0.1 to "
    "1 % of its range; the weight on a vertical axis up to all of it.",
    parameters=(
        Parameter(
            name="torque",
            unit="N.m",
            meaning="constant torque on the joint, in the direction of joint_position",
            null=0.0,
            lower=-1.0e5,
            upper=1.0e5,
            typical=lambda sizes: 0.03 * sizes.torque,
            of_recording=True,
        ),
    ),
    equations=equations,
    reference="J. Swevers, W. Verdonck, J. De Schutter, Dynamic model identification for "
    "industrial robots, IEEE Control Systems Magazine 27(5), 2007",
    aliases=(
        Alias(
            of=("joint_encoder_offset",),
            when="both tendons stay taut, springs are linear, and nothing depends on the angle "
            "itself, as gravity, stops and eccentricity do",
        ),
    ),
)
