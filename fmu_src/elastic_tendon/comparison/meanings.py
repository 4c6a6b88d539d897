"""What is said of each pattern: its number, and what in the machine would do this."""

from elastic_tendon.comparison import patterns, springs
from elastic_tendon.comparison.patterns import Pattern

# whose words say where they hold, or that it is everywhere
SELF_EVIDENT = (
    *("offset", "delay", "constant", "event"),
    *("direction", "direction and load", "held", "unknown torque"),
)
# one number each, none of a group simpler than another; in slow motion a load has a like share
EQUALLY_SIMPLE = (("pretension", "springs", "stiffness"), ("upper spring", "lower spring"))
OF_SPRINGS = (*EQUALLY_SIMPLE[0], *EQUALLY_SIMPLE[1], "deflection")
OF_THE_ERROR = ("offset", "delay")  # patterns of the error itself
OF_THE_UNKNOWN = ("held", "unknown torque", "event")  # whose words name an unknown torque
OF_MOTION = ("direction", "direction and load", "velocity")  # loads seldom oppose every motion
_TORQUE_OF_TIME = "a torque of about {size} N·m that the model does not know acted "
_EVENT_WORDS = {
    1: _TORQUE_OF_TIME + "on the joint in the positive direction from {start} to {end} s",
    -1: _TORQUE_OF_TIME + "on the joint in the negative direction from {start} to {end} s",
}
_OFFSET = (
    "a constant error of {milli} mrad, everywhere alike: an offset between the encoders would do "
    "this"
)


def _springs(name: str, sides: tuple[str, ...], words: str) -> Pattern:
    stiffer, softer = (
        f"the joint is {{0}} than the model, as if {words} were {{0}} by "
        "about {{percent}} %{{alike}}".format(way)
        for way in ("stiffer", "softer")
    )
    return Pattern(name, "deflection", springs.spring_stiffness(*sides), {1: stiffer, -1: softer})


# the simpler before the less simple
TORQUE_PATTERNS = (
    Pattern("offset", "", patterns.constant_error, {1: _OFFSET, -1: _OFFSET}),
    Pattern(
        "delay",
        "joint_velocity",
        patterns.late,
        {
            1: "the error is proportional to the velocity: the joint position was recorded later "
            "than the motor's, by about {milli} ms",
            -1: "the error is proportional to the velocity: the joint position was recorded "
            "earlier than the motor's, by about {milli} ms",
        },
    ),
    Pattern(
        "constant",
        "",
        patterns.constant,
        {
            1: "a constant torque of about {size} N·m is missing",
            -1: "a constant torque of about -{size} N·m is missing",
        },
    ),
    Pattern(
        "direction",
        "velocity_sign",
        patterns.direction,
        {
            -1: "the missing torque opposes the direction of motion: the joint resists motion "
            "more than the model, by about {size} N·m{speed}",
            1: "the missing torque has the direction of motion: the joint resists motion less "
            "than the model, by about {size} N·m{speed}",
        },
    ),
    Pattern(
        "direction and load",
        "velocity_sign",
        patterns.direction_and_load,
        {
            -1: "the missing torque opposes the direction of motion and grows with the load: the "
            "joint resists motion more than the model, by about {percent} % of the load",
            1: "the missing torque has the direction of motion and grows with the load: the joint "
            "resists motion less than the model, by about {percent} % of the load",
        },
    ),
    Pattern(
        "velocity",
        "joint_velocity",
        patterns.velocity,
        {
            -1: "the missing torque opposes the velocity in proportion: the joint is damped more "
            "than the model, by about {size} N·m·s/rad",
            1: "the missing torque grows with the velocity in proportion: the joint is damped "
            "less than the model, by about {size} N·m·s/rad",
        },
    ),
    Pattern(
        "acceleration",
        "joint_acceleration",
        patterns.acceleration,
        {
            -1: "the missing torque opposes the acceleration in proportion: the link is more "
            "inert than the model's, by about {size} kg·m²{alike}",
            1: "the missing torque grows with the acceleration in proportion: the link is less "
            "inert than the model's, by about {size} kg·m²{alike}",
        },
    ),
    Pattern(
        "pretension",
        "deflection",
        springs.pretension,
        {
            1: "the missing torque is of one sign on each side and the same beyond the slack "
            "boundaries, as if the pretension were {percent} % higher, about {pretension} N "
            "instead of {model_pretension} N{alike}",
            -1: "the missing torque is of one sign on each side and the same beyond the slack "
            "boundaries, as if the pretension were {percent} % lower, about {pretension} N "
            "instead of {model_pretension} N{alike}",
        },
    ),
    _springs("springs", ("upper_spring", "lower_spring"), "both springs"),
    _springs("upper spring", ("upper_spring",), "the upper spring"),
    _springs("lower spring", ("lower_spring",), "the lower spring"),
    Pattern(
        "stiffness",
        "deflection",
        springs.stiffness,
        {
            -1: "the joint is stiffer than the model, by about {size} N·m/rad{alike}",
            1: "the joint is softer than the model, by about {size} N·m/rad{alike}",
        },
    ),
    Pattern(
        "beyond",
        "deflection",
        springs.beyond,
        {
            -1: "the joint is stiffer{there} than the model, by about {size} N·m/rad",
            1: "the joint is softer{there} than the model, by about {size} N·m/rad",
        },
    ),
    Pattern(
        "deflection",
        "deflection",
        springs.stiffness_curve,
        {
            -1: "the joint is stiffer than the model, by about {size} N·m/rad on average over "
            "all deflections{alike}",
            1: "the joint is softer than the model, by about {size} N·m/rad on average over "
            "all deflections{alike}",
            0: "the missing torque is a curve over the deflection{alike}",
        },
    ),
    Pattern(
        "load",
        "load_torque",
        patterns.load,
        {
            1: "the missing torque is proportional to the load: the load acts more strongly "
            "than recorded, by about {percent} %",
            -1: "the missing torque is proportional to the load: the load acts less strongly "
            "than recorded, by about {percent} %",
        },
    ),
    Pattern(
        "held",
        "motor_position",
        patterns.held,
        {
            1: "the motor moves and the joint stays: a torque of about {size} N·m RMS that the "
            "model does not know holds it",
        },
    ),
    Pattern(
        "joint position",
        "joint_position",
        patterns.position_curve,
        dict.fromkeys(
            (-1, 0, 1),
            "the missing torque is a curve over the joint position{alike}, as gravity, a stop or "
            "an eccentric pulley would give",
        ),
    ),
    Pattern(
        "motor position",
        "motor_position",
        patterns.curve,
        dict.fromkeys(
            (-1, 0, 1),
            "the missing torque is a curve over the motor position, as an eccentric pulley would "
            "give",
        ),
    ),
    Pattern("event", "time", patterns.event, _EVENT_WORDS),
)
# true of whatever the model does not know, hence reported only where no other pattern is
LAST_PATTERNS = (
    Pattern(
        "unknown torque",
        "deflection",
        patterns.unknown_torque,
        {
            1: "load and inertia hardly account for the deflection, so that stiffness cannot be "
            "its cause: a torque of about {size} N·m RMS that the model does not know deflects "
            "the joint, as friction, a hand or an unmeasured load would",
        },
    ),
)


def _follows(name: str, by: str, words: str) -> Pattern:
    fit = patterns.curve if by != "velocity_sign" else patterns.direction
    return Pattern(name, by, fit, dict.fromkeys((-1, 0, 1), f"the error follows the {words}"))


SIGNAL_PATTERNS = (
    Pattern(
        "offset",
        "",
        patterns.constant_error,
        dict.fromkeys(
            (-1, 1),
            "a constant error of {milli} mN·m, everywhere alike, as an offset of the sensor",
        ),
    ),
    _follows("direction", "velocity_sign", "direction of motion"),
    _follows("deflection", "deflection", "deflection"),
    _follows("velocity", "joint_velocity", "velocity"),
    _follows("acceleration", "joint_acceleration", "acceleration"),
    _follows("joint position", "joint_position", "joint position"),
    _follows("load", "load_torque", "load"),
    _follows("motor position", "motor_position", "motor position"),
)
