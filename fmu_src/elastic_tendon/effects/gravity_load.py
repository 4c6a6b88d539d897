"""Weight of a link that is not balanced about its joint."""

from types import SimpleNamespace

from elastic_tendon.effects.base import Contribution, Effect, Joint, Parameter, Slot, Spread
from elastic_tendon.effects.symbolic import sin


def equations(
    at: Joint, p: SimpleNamespace, _state: SimpleNamespace, _mode: SimpleNamespace
) -> Contribution:
    """Torque -T sin(q + angle)."""
    return Contribution(-p.torque * sin(at.position + p.angle))


EFFECT = Effect(
    id="gravity_load",
    title="Gravity load",
    slot=Slot.JOINT_TORQUE,
    limit="constant_torque",
    catalogue_order=50,
    physics="The weight of the link turns it towards where it hangs; the torque is largest where "
    "the link is horizontal.",
    in_data="The joint rests beside the motor's position by an angle that follows the sine of the "
    "joint's, is the same for both directions of motion and at any speed, and is larger where a "
    "tendon is slack. Load torque against deflection is shifted along the torque, so the tendon "
    "that the weight relieves goes slack earlier. The natural frequency is higher where the link "
    "hangs and lower where it stands up.",
    law="-torque sin(q + angle)",
    confused_with="Pulley eccentricity: a sine too, but of the motor's angle; and its error does "
    "not grow where a tendon is slack or with less pretension, while the sag of a weight does. "
    "Joint encoder offset and motor encoder offset: alike over a small range of angles. Constant "
    "torque: it does not follow the joint's angle.",
    confirm="Let the motor rest at angles over the whole range, each approached from both sides, "
    "and plot the deflection against the joint's angle: one sine, the same from both sides. Add a "
    "known mass at a known distance: the sine grows by its torque. With the joint's axis upright "
    "it vanishes.",
    cure="A counterweight or a balancing spring; the stiffer spring on the side that carries the "
    "weight (paper, section III.A). In control lead the motor by the weight's torque over joint "
    "stiffness.",
    magnitude="Mass times 9.81 m/s² times the distance of the centre of mass from the axis: 1 kg "
    "at 0.1 m makes 1 N·m. Arms spend some 5 to 50 % of their largest torque on it; payload adds.",
    parameters=(
        Parameter(
            name="torque",
            unit="N.m",
            meaning="largest torque of the weight, mass times gravity times distance",
            null=0.0,
            lower=0.0,
            upper=1.0e5,
            typical=lambda sizes: 0.1 * sizes.torque,
        ),
        Parameter(
            name="angle",
            unit="rad",
            meaning="angle of the link above its hanging position where the joint position is 0",
            null=0.0,
            lower=-3.141592653589793,
            upper=3.141592653589793,
            typical=0.8,
            shape=True,
            spread=Spread.TURN,
        ),
    ),
    equations=equations,
    reference="B. Siciliano, L. Sciavicco, L. Villani, G. Oriolo, Robotics: Modelling, Planning "
    "and Control, Springer, 2009, chapter 7 (Dynamics)",
)
