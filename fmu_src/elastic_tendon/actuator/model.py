"""Base model plus effects as one hybrid system, in CasADi symbols.

The chain follows the slots of `effects.base`: motor, its pulley, two tendons, joint pulley, link.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import casadi as ca

from elastic_tendon.actuator import transmission
from elastic_tendon.actuator.interfaces import InterfaceKind
from elastic_tendon.actuator.system import (
    HybridSystem,
    Symbols,
    derivative_of_unknowns,
    linear_root,
    total_jacobian,
)
from elastic_tendon.actuator.tendon import TendonForces, tendon
from elastic_tendon.actuator.variables import (
    FORCE_READINGS,
    LINK,
    POSITION_OF,
    ROTOR,
    SPRINGS,
    Body,
    interface,
)
from elastic_tendon.effects.base import (
    Contribution,
    FrictionBounds,
    Joint,
    JointPulley,
    Motor,
    MotorAngle,
    Signal,
    Slot,
)
from elastic_tendon.effects.symbolic import Symbol, both, one_at_a_time, where

VELOCITY_SCALE = 1.0  # rad/s, by which a velocity is judged to have crossed zero
ACCELERATION_SCALE = 1.0  # rad/s², by which a link without springs is judged to be pushed


@dataclass(frozen=True)
class _Ends:
    """Symbols of the angles and rates at both ends: true ones, given or computed."""

    motor_position: Symbol
    motor_velocity: Symbol
    joint: Joint


@one_at_a_time
def build(
    effect_ids: tuple[str, ...], kind: InterfaceKind = InterfaceKind.POSITION
) -> HybridSystem:
    """Equations of the model with the given effects.

    Parameters
    ----------
    effect_ids : tuple of catalogue ids, in any order
    kind : what is given and what is computed

    Returns
    -------
    HybridSystem
    """
    variables = interface(effect_ids, kind)
    s = Symbols(variables)
    ends = _ends(s, kind)
    angle: Symbol = ca.SX(0)
    if kind.has_springs:
        upper, lower = _tendons(s, ends.joint)
        angle = _pulley_angle(s, ends, upper, lower)
        outputs = {**s.state, **_outputs(s, kind, ends, angle, upper, lower)}
        outputs |= _force_readings(s, outputs)
    else:
        _free_link(s, ends.joint)
        outputs = dict(s.state)
    delay = sum((answer.value for answer in s.fill(Slot.SIGNAL_DELAY, None)), ca.SX(0))
    if variables.reads_signals:
        outputs |= _readings(s, ends, delay)
    exact_delay = where(s.as_measured, delay, 0)
    indicators, next_modes = s.relations.in_order()
    columns = {
        "rates": _column(s.rate[name] for name in variables.state_names),
        "outputs": _column(outputs[name] for name in variables.output_names),
        "indicators": indicators,
        "next_modes": next_modes,
        "reset": _reset(s),
        "starts": _column((s.state | s.start).values()),
    }
    columns = _with_pulley(s, angle, columns | s.implicit_columns())
    # the guess of one unknown may stand in that of another: a free pulley in the springs' lengths
    columns["guesses"] = ca.substitute(columns["guesses"], s.unknowns, columns["guesses"])
    symbols = {"x": s.x, "u": s.u, "p": s.p, "r": s.r, "r_next": s.r_next, "w": s.unknowns}
    return HybridSystem(interface=variables, **symbols, delay=exact_delay, **columns)


def _outputs(
    s: Symbols,
    kind: InterfaceKind,
    ends: _Ends,
    angle: Symbol,
    upper: TendonForces,
    lower: TendonForces,
) -> dict[str, Symbol]:
    """Outputs that tendons have, by name; sets the rates of what they move."""
    joint = _link(s, ends.joint, upper, lower) if kind.has_link else _held_joint(s, upper, lower)
    motor = _at_motor(s, ends, angle, upper, lower)
    if kind.has_rotor:
        _rotor(s, ends, motor["motor_torque"], upper)
    return {
        **joint,
        **motor,
        "slack_state": _slack_state(s.mode["upper_spring.taut"], s.mode["lower_spring.taut"]),
        "overstretched": ca.logic_or(upper.overstretched, lower.overstretched),
    }


def _column(symbols: Iterable[Symbol]) -> ca.SX:
    return ca.vertcat(ca.SX(0, 1), *symbols)


# ---- both ends -----------------------------------------------------------------------------


def _ends(s: Symbols, kind: InterfaceKind) -> _Ends:
    known = s.input | s.state
    joint = known["joint_position"], known["joint_velocity"]
    if not kind.has_springs:  # there is no motor
        return _Ends(0.0, 0.0, Joint(*joint))
    motor = known["motor_position"], known["motor_velocity"]
    if not kind.has_rotor:
        true = ca.SX.sym("true")
        errors = s.fill(Slot.MOTOR_SIGNAL, Signal(true))
        motor = _true_angle(s, motor[0], true, errors), motor[1]
    if not kind.has_link:
        true = ca.SX.sym("true")
        angle = _true_angle(s, joint[0], true, _joint_errors(s, true, motor[0]))
        joint = angle, _rate(s, angle)
    return _Ends(*motor, Joint(*joint))


def _true_angle(s: Symbols, given: Symbol, true: ca.SX, errors: Sequence[Contribution]) -> Symbol:
    """True angle, rad, where in comparison the input is what a sensor reads."""
    if not errors:
        return given
    reading = true + sum(error.value for error in errors)
    return where(s.as_measured, s.root(reading - given, true, given), given)


def _rate(s: Symbols, angle: Symbol) -> Symbol:
    """Time derivative, rad/s, of a true angle: not what is given where a reading is enlarged."""
    known = s.input | s.state
    velocities = [name for name in known if name in POSITION_OF]
    along = ca.vertcat(*(known[POSITION_OF[name]] for name in velocities))
    unknowns_by_along = derivative_of_unknowns(s.implicit_columns()["residuals"], s.unknowns, along)
    by_along = total_jacobian(angle, along, s.unknowns, unknowns_by_along)
    return by_along @ ca.vertcat(*(known[name] for name in velocities))


def _joint_errors(s: Symbols, joint: Symbol, motor: Symbol) -> list[Contribution]:
    """Errors of what is read at the joint, rad: of its position, and of a deflection in place of
    it."""
    of_position = s.fill(Slot.JOINT_SIGNAL, Signal(joint))
    if not any(s.in_slot(Slot.DEFLECTION_SIGNAL)):
        return of_position
    t = s.parameters("transmission")
    radii = (t.joint_pulley_radius, t.motor_pulley_radius)
    deflection = joint - transmission.reflected_motor_position(motor, *radii)
    return [*of_position, *s.fill(Slot.DEFLECTION_SIGNAL, Signal(deflection))]


# ---- motor and its pulley ------------------------------------------------------------------


def _rotor(s: Symbols, ends: _Ends, tendon_torque: Symbol, upper: TendonForces) -> None:
    """Motion of the rotor, ``J_m θ'' = motor torque - tendon torque + friction``."""
    motor = s.parameters("motor")
    t = s.parameters("transmission")
    given = s.input["motor_torque"]
    at = Motor(ends.motor_position, ends.motor_velocity, given, load=-tendon_torque)
    driving = given + sum(added.value for added in s.fill(Slot.MOTOR_TORQUE, at))
    torque = driving - motor.damping * ends.motor_velocity - tendon_torque
    dry = _bounds(s.fill(Slot.MOTOR_FRICTION, replace(at, torque=driving)))
    _accelerate(s, ROTOR, torque, dry, t.motor_pulley_radius * upper.largest)


def _pulley_angle(s: Symbols, ends: _Ends, upper: TendonForces, lower: TendonForces) -> Symbol:
    """Angle of the motor pulley after every angle map, rad."""
    maps = list(s.in_slot(Slot.ANGLE_MAP))
    if not maps:
        return ends.motor_position
    t = s.parameters("transmission")
    undeflected = ends.joint.position * t.joint_pulley_radius / t.motor_pulley_radius
    free = _free_position(s, upper.unbounded - lower.unbounded, undeflected)
    angle = ends.motor_position
    for effect in maps:
        answer = s.answer(effect, effect.id, MotorAngle(angle, free))
        s.take(effect.id, answer)
        angle = answer.value
    return angle


def _pulley_ratio(s: Symbols, ends: _Ends, angle: Symbol) -> Symbol:
    """By how much the pulley turns while the motor does; the torques are as the reverse."""
    if not any(s.in_slot(Slot.ANGLE_MAP)):
        return 1
    given = (s.input | s.state)["motor_position"]
    return ca.jacobian(angle, given) / ca.jacobian(ends.motor_position, given)


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
    velocities = [name for name in s.input if name in POSITION_OF]
    along = ca.vertcat(*(s.input[POSITION_OF[name]] for name in velocities), s.x)
    rates = ca.vertcat(*(s.input[name] for name in velocities), columns["rates"])
    unknowns_by_along = derivative_of_unknowns(columns["residuals"], s.unknowns, along)
    by_along = total_jacobian(angle, along, s.unknowns, unknowns_by_along)
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
    torque = _torque_on_link(s, joint, tendon_torque)
    losses = s.fill(Slot.TENDON_LOSS, JointPulley(upper.joint, lower.joint, radius))
    loss = _bounds(losses)
    dry = _bounds(losses + s.fill(Slot.DRY_FRICTION, joint))
    friction = _accelerate(s, LINK, torque, dry, radius * upper.largest)
    width = dry.upper - dry.lower
    share = (friction - dry.lower) / where(width > 0, width, 1)
    return {
        # while the joint sticks, what is lost on the tendons is their share of the friction
        "joint_torque": tendon_torque + loss.lower + share * (loss.upper - loss.lower),
        "upper_spring_force": upper.joint,
        "lower_spring_force": lower.joint,
    }


def _torque_on_link(s: Symbols, joint: Joint, tendon_torque: Symbol) -> Symbol:
    """All torque on the link but its dry friction, N·m."""
    damping = s.parameter["link.damping"]
    torque = tendon_torque + s.input["load_torque"] - damping * joint.velocity
    for added in s.fill(Slot.JOINT_TORQUE, joint):
        torque += added.value
    return torque


def _free_link(s: Symbols, joint: Joint) -> None:
    """Motion of a link without springs, ``J q'' = load + torque + friction``."""
    torque = _torque_on_link(s, joint, ca.SX(0))
    dry = _bounds(s.fill(Slot.DRY_FRICTION, joint))
    _accelerate(s, LINK, torque, dry, ACCELERATION_SCALE * s.parameter[LINK.inertia])


def _held_joint(s: Symbols, upper: TendonForces, lower: TendonForces) -> dict[str, Symbol]:
    """Outputs seen at a joint that another simulator moves."""
    radius = s.parameter["transmission.joint_pulley_radius"]
    torque = transmission.joint_torque(upper.joint, lower.joint, radius)
    return {
        "joint_torque": torque,
        "load_torque": -torque,
        "upper_spring_force": upper.joint,
        "lower_spring_force": lower.joint,
    }


# ---- motion under dry friction -------------------------------------------------------------


def _accelerate(
    s: Symbols,
    body: Body,
    torque: Symbol,
    dry: FrictionBounds,
    torque_scale: Symbol,
) -> Symbol:
    """Set the rates of what is moved by a torque (N·m); returns the dry friction on it, N·m."""
    velocity = s.state[body.velocity]
    friction = ca.SX(0)
    moving: Symbol = 1
    if body.motion in s.mode:
        friction = _dry_friction(s, body.motion, velocity, torque, dry, torque_scale)
        moving = s.mode[body.motion]
    s.rate[body.position] = where(moving, velocity, 0)
    s.rate[body.velocity] = where(moving, (torque + friction) / s.parameter[body.inertia], 0)
    return friction


def _bounds(frictions: Sequence[FrictionBounds]) -> FrictionBounds:
    """Frictions that act together: their bounds add up."""
    return FrictionBounds(
        sum((friction.lower for friction in frictions), ca.SX(0)),
        sum((friction.upper for friction in frictions), ca.SX(0)),
    )


def _dry_friction(
    s: Symbols,
    motion: str,
    velocity: Symbol,
    torque: Symbol,
    bounds: FrictionBounds,
    torque_scale: Symbol,
) -> Symbol:
    """Dry friction torque: a bound while it slides, what holds it while it sticks."""
    at_rest = ca.substitute(ca.vertcat(torque + bounds.lower, torque + bounds.upper), velocity, 0)
    s.relations.motion(
        motion,
        velocity / VELOCITY_SCALE,
        push_up=at_rest[0] / torque_scale,
        push_down=-at_rest[1] / torque_scale,
    )
    mode = s.mode[motion]
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
    s: Symbols, ends: _Ends, angle: Symbol, upper: TendonForces, lower: TendonForces
) -> dict[str, Symbol]:
    """Outputs that need the motor: deflection (11) and torque (8)."""
    t = s.parameters("transmission")
    radii = (t.joint_pulley_radius, t.motor_pulley_radius)
    pull = transmission.joint_torque(upper.motor, lower.motor, t.joint_pulley_radius)
    return {
        "deflection": ends.joint.position
        - transmission.reflected_motor_position(ends.motor_position, *radii),
        "motor_torque": transmission.motor_torque(pull, *radii) * _pulley_ratio(s, ends, angle),
    }


def _readings(s: Symbols, ends: _Ends, delay: Symbol) -> dict[str, Symbol]:
    """What the encoders read. A delay is linearised, except in comparison, where it is exact."""
    late = ends.joint.position - where(s.as_measured, 0, delay * ends.joint.velocity)
    joint = _joint_errors(s, late, ends.motor_position)
    motor = s.fill(Slot.MOTOR_SIGNAL, Signal(ends.motor_position))
    return {
        "measured_joint_position": late + sum((error.value for error in joint), ca.SX(0)),
        "measured_motor_position": ends.motor_position
        + sum((error.value for error in motor), ca.SX(0)),
    }


def _force_readings(s: Symbols, outputs: Mapping[str, Symbol]) -> dict[str, Symbol]:
    """What is measured of torques and forces, where effects make it other than the true one."""
    found = {}
    for slot, (name, reading) in FORCE_READINGS.items():
        if errors := s.fill(slot, Signal(outputs[name])):
            found[reading.name] = outputs[name] + sum(error.value for error in errors)
    return found


# ---- jumps and starts ----------------------------------------------------------------------


def _reset(s: Symbols) -> ca.SX:
    """States after an event: what now sticks has no velocity."""
    after = dict(s.state)
    for body in (LINK, ROTOR):
        if body.motion in s.mode:
            after[body.velocity] = where(s.mode_next[body.motion], s.state[body.velocity], 0)
    return _column(after.values())
