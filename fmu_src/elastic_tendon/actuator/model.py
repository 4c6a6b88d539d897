"""Base model plus effects as one hybrid system, in CasADi symbols.

The chain follows the slots of `effects.base`: motor, its pulley, two tendons, joint pulley, link.
"""

from collections.abc import Sequence

import casadi as ca

from elastic_tendon.actuator import transmission
from elastic_tendon.actuator.system import HybridSystem, Symbols, linear_root, total_jacobian
from elastic_tendon.actuator.tendon import TendonForces, tendon
from elastic_tendon.actuator.variables import JOINT_MOTION, SPRINGS, interface
from elastic_tendon.effects.base import (
    FrictionBounds,
    Joint,
    JointPulley,
    MotorAngle,
    Signal,
    Slot,
)
from elastic_tendon.effects.symbolic import Symbol, both, one_at_a_time, where

VELOCITY_SCALE = 1.0  # rad/s, by which the joint's velocity is judged to have crossed zero


@one_at_a_time
def build(effect_ids: tuple[str, ...]) -> HybridSystem:
    """Equations of the model with the given effects.

    Parameters
    ----------
    effect_ids : tuple of catalogue ids, in any order

    Returns
    -------
    HybridSystem
    """
    variables = interface(effect_ids)
    s = Symbols(variables)
    joint = Joint(s.state["joint_position"], s.state["joint_velocity"])
    motor_position = _motor_position(s)
    upper, lower = _tendons(s, joint)
    angle = _pulley_angle(s, motor_position, upper, lower)
    outputs = {
        **_link(s, joint, upper, lower),
        **_at_motor(s, joint, motor_position, upper, lower),
        "slack_state": _slack_state(s.mode["upper_spring.taut"], s.mode["lower_spring.taut"]),
        "overstretched": ca.logic_or(upper.overstretched, lower.overstretched),
    }
    delay = sum((answer.value for answer in s.fill(Slot.SIGNAL_DELAY, None)), ca.SX(0))
    if variables.reads_signals:
        outputs |= _readings(s, joint, motor_position, delay)
    exact_delay = where(s.as_measured, delay, 0)
    indicators, next_modes = s.relations.in_order()
    columns = {
        "rates": ca.vertcat(*(s.rate[name] for name in variables.state_names)),
        "outputs": ca.vertcat(*(outputs[name] for name in variables.output_names)),
        "indicators": indicators,
        "next_modes": next_modes,
        "reset": _reset(s),
        "starts": ca.vertcat(*(s.state | s.start).values()),
    }
    columns = _with_pulley(s, angle, columns | s.implicit_columns())
    # the guess of one unknown may stand in that of another: a free pulley in the springs' lengths
    columns["guesses"] = ca.substitute(columns["guesses"], s.unknowns, columns["guesses"])
    symbols = {"x": s.x, "u": s.u, "p": s.p, "r": s.r, "r_next": s.r_next, "w": s.unknowns}
    return HybridSystem(interface=variables, **symbols, delay=exact_delay, **columns)


# ---- motor and its pulley ------------------------------------------------------------------


def _motor_position(s: Symbols) -> Symbol:
    """True motor position, rad: in comparison the input is what the encoder reads."""
    given, true = s.input["motor_position"], ca.SX.sym("true")
    errors = s.fill(Slot.MOTOR_SIGNAL, Signal(true))
    if not errors:
        return given
    reading = true + sum(error.value for error in errors)
    return where(s.as_measured, s.root(reading - given, true, given), given)


def _pulley_angle(
    s: Symbols, motor_position: Symbol, upper: TendonForces, lower: TendonForces
) -> Symbol:
    """Angle of the motor pulley after every angle map, rad."""
    maps = list(s.in_slot(Slot.ANGLE_MAP))
    if not maps:
        return motor_position
    t = s.parameters("transmission")
    undeflected = s.state["joint_position"] * t.joint_pulley_radius / t.motor_pulley_radius
    free = _free_position(s, upper.unbounded - lower.unbounded, undeflected)
    angle = motor_position
    for effect in maps:
        answer = s.answer(effect, effect.id, MotorAngle(angle, free))
        s.take(effect.id, answer)
        angle = answer.value
    return angle


def _free_position(s: Symbols, pull: ca.SX, guess: Symbol) -> ca.SX:
    """Angle of the pulley at which the tendons pull it alike, rad.

    What is implicit in the tendons' pull is found anew, for this angle.
    """
    within = [equation for equation in s.implicit if ca.depends_on(pull, equation.unknown)]
    unknown = ca.vertcat(s.pulley_angle, *(equation.unknown for equation in within))
    residual = ca.vertcat(pull, *(equation.residual for equation in within))
    guesses = ca.vertcat(guess, *(equation.guess for equation in within))
    guesses = ca.substitute(guesses, s.pulley_angle, guess)
    return s.root(residual, unknown, guesses)[0]


def _with_pulley(s: Symbols, angle: Symbol, columns: dict[str, ca.SX]) -> dict[str, ca.SX]:
    """Put the pulley's angle and rate in their place.

    The rate is the time derivative of the angle; of a floating pulley it depends on the rates of
    states that depend on it in turn, linearly.
    """
    columns = _substitute(columns, s.pulley_angle, angle)
    along = ca.vertcat(s.input["motor_position"], s.x)
    rates = ca.vertcat(s.input["motor_velocity"], columns["rates"])
    by_along = total_jacobian(angle, along, s.unknowns, columns["residuals"])
    rate = linear_root(s.pulley_rate - by_along @ rates, s.pulley_rate)
    return _substitute(columns, s.pulley_rate, rate)


def _substitute(columns: dict[str, ca.SX], symbol: ca.SX, by: Symbol) -> dict[str, ca.SX]:
    placed = ca.substitute(list(columns.values()), [symbol], [ca.SX(by)])
    return dict(zip(columns, placed, strict=True))


# ---- tendons, joint pulley and link --------------------------------------------------------


def _tendons(s: Symbols, joint: Joint) -> tuple[TendonForces, TendonForces]:
    """The upper and the lower tendon between motor pulley and joint pulley, (11)."""
    t = s.parameters("transmission")
    radius = t.joint_pulley_radius
    pulley = [
        radius * transmission.reflected_motor_position(motion, radius, t.motor_pulley_radius)
        for motion in (s.pulley_angle, s.pulley_rate)
    ]
    link = [radius * motion for motion in (joint.position, joint.velocity)]
    upper, lower = (
        tendon(
            s,
            name,
            (sign * pulley[0], sign * pulley[1]),
            (sign * link[0], sign * link[1]),
        )
        for name, sign in zip(SPRINGS, (1, -1), strict=True)
    )
    return upper, lower


def _link(s: Symbols, joint: Joint, upper: TendonForces, lower: TendonForces) -> dict[str, Symbol]:
    """Motion of the link, ``J q'' = torque + friction``; outputs seen at the joint."""
    radius = s.parameter["transmission.joint_pulley_radius"]
    tendon_torque = transmission.joint_torque(upper.joint, lower.joint, radius)
    torque = tendon_torque + s.input["load_torque"] - s.parameter["link.damping"] * joint.velocity
    for added in s.fill(Slot.JOINT_TORQUE, joint):
        torque += added.value
    losses = s.fill(Slot.TENDON_LOSS, JointPulley(upper.joint, lower.joint, radius))
    loss = _bounds(losses)
    dry = _bounds(losses + s.fill(Slot.DRY_FRICTION, joint))
    friction = ca.SX(0)
    moving: Symbol = 1
    if JOINT_MOTION.name in s.mode:
        friction = _dry_friction(s, joint, torque, dry, radius * upper.largest)
        moving = s.mode[JOINT_MOTION.name]
    s.rate["joint_position"] = where(moving, joint.velocity, 0)
    s.rate["joint_velocity"] = where(moving, (torque + friction) / s.parameter["link.inertia"], 0)
    width = dry.upper - dry.lower
    share = (friction - dry.lower) / where(width > 0, width, 1)
    return {
        # while the joint sticks, what is lost on the tendons is their share of the friction
        "joint_torque": tendon_torque + loss.lower + share * (loss.upper - loss.lower),
        "joint_position": joint.position,
        "joint_velocity": joint.velocity,
        "upper_spring_force": upper.joint,
        "lower_spring_force": lower.joint,
    }


def _bounds(frictions: Sequence[FrictionBounds]) -> FrictionBounds:
    """Frictions that act together: their bounds add up."""
    return FrictionBounds(
        sum((friction.lower for friction in frictions), ca.SX(0)),
        sum((friction.upper for friction in frictions), ca.SX(0)),
    )


def _dry_friction(
    s: Symbols, joint: Joint, torque: Symbol, bounds: FrictionBounds, torque_scale: Symbol
) -> Symbol:
    """Dry friction torque: a bound while the joint slides, what holds it while it sticks."""
    at_rest = ca.substitute(
        ca.vertcat(torque + bounds.lower, torque + bounds.upper), joint.velocity, 0
    )
    s.relations.motion(
        JOINT_MOTION.name,
        joint.velocity / VELOCITY_SCALE,
        push_up=at_rest[0] / torque_scale,
        push_down=-at_rest[1] / torque_scale,
    )
    mode = s.mode[JOINT_MOTION.name]
    return where(mode, where(mode > 0, bounds.lower, bounds.upper), -torque)


def _slack_state(upper_taut: Symbol, lower_taut: Symbol) -> Symbol:
    """Fig. 4 by number: I lower slack, II upper slack, III none, 4 both."""
    states = transmission.SlackState
    return where(
        both(upper_taut, lower_taut),
        int(states.III),
        where(upper_taut, int(states.I), where(lower_taut, int(states.II), int(states.BOTH))),
    )


# ---- outputs at the motor, readings --------------------------------------------------------


def _at_motor(
    s: Symbols, joint: Joint, motor_position: Symbol, upper: TendonForces, lower: TendonForces
) -> dict[str, Symbol]:
    """Outputs that need the motor: deflection (11) and torque (8)."""
    t = s.parameters("transmission")
    radii = (t.joint_pulley_radius, t.motor_pulley_radius)
    pull = transmission.joint_torque(upper.motor, lower.motor, t.joint_pulley_radius)
    return {
        "deflection": joint.position
        - transmission.reflected_motor_position(motor_position, *radii),
        "motor_torque": transmission.motor_torque(pull, *radii),
    }


def _readings(s: Symbols, joint: Joint, motor_position: Symbol, delay: Symbol) -> dict[str, Symbol]:
    """What the encoders read. A delay is linearised, except in comparison, where it is exact."""
    late = joint.position - where(s.as_measured, 0, delay * joint.velocity)
    error = sum((answer.value for answer in s.fill(Slot.JOINT_SIGNAL, Signal(late))), ca.SX(0))
    motor = [
        s.answer(effect, effect.id, Signal(motor_position))
        for effect in s.in_slot(Slot.MOTOR_SIGNAL)
    ]
    return {
        "measured_joint_position": late + error,
        "measured_motor_position": motor_position
        + sum((answer.value for answer in motor), ca.SX(0)),
    }


# ---- jumps and starts ----------------------------------------------------------------------


def _reset(s: Symbols) -> ca.SX:
    """States after an event: a joint that now sticks has no velocity."""
    after = dict(s.state)
    if JOINT_MOTION.name in s.mode:
        after["joint_velocity"] = where(
            s.mode_next[JOINT_MOTION.name], s.state["joint_velocity"], 0
        )
    column: ca.SX = ca.vertcat(*after.values())
    return column
