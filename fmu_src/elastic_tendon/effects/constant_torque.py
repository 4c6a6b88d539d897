"""A constant torque on the joint that nobody recorded."""

from types import SimpleNamespace

from elastic_tendon.effects.base import Contribution, Effect, Joint, Parameter, Slot


def equations(
    _at: Joint, p: SimpleNamespace, _state: SimpleNamespace, _mode: SimpleNamespace
) -> Contribution:
    """Torque that is always there."""
    return Contribution(p.torque)


EFFECT = Effect(
    id="constant_torque",
    title="Constant torque",
    slot=Slot.JOINT_TORQUE,
    catalogue_order=175,
    physics="A torque that always acts alike: a weight on a string, a spring of constant force, "
    "a preloaded cable or hose, friction that is larger in one direction than in the other, or a "
    "load sensor that does not show 0 without load.",
    in_data="The joint rests beside the motor's position by the same angle wherever it is, and by "
    "more where a tendon is slack. Load torque against deflection is shifted along the torque. "
    "Speed and direction do not matter. A link that springs hardly hold drifts to one side.",
    law="torque",
    confused_with="Gravity load: alike over a small part of a turn, or where the link stays near "
    "the horizontal. Joint encoder offset and motor encoder offset: alike while both tendons are "
    "taut; only where one is slack, or with another pretension, does the error change. Coulomb "
    "friction of two sizes: its mean over both directions is this torque, half their difference.",
    confirm="Let the joint rest without load at several angles, each approached from both sides: "
    "the mean deflection times the stiffness is the same everywhere. With more pretension the "
    "deflection of state III stays, and shrinks where one tendon was slack. Read the load sensor "
    "with nothing attached.",
    cure="Zero the load sensor, route cables along the joint's axis. In control lead the motor by "
    "the torque over the joint stiffness; integral action removes what is left.",
    magnitude="1 to 5 % of the largest joint torque for cables and sensors; whatever a weight on a "
    "drum weighs. A sensor's zero drifts with temperature.",
    parameters=(
        Parameter(
            name="torque",
            unit="N.m",
            meaning="torque on the joint, in the direction of its position",
            null=0.0,
            lower=-1.0e4,
            upper=1.0e4,
            typical=lambda sizes: 0.03 * sizes.torque,
        ),
    ),
    equations=equations,
    reference="A. Janot, P.-O. Vandanjon, M. Gautier, A generic instrumental variable approach "
    "for industrial robot identification, IEEE Transactions on Control Systems Technology 22(1), "
    "2014 (the offset of a joint's friction)",
)
