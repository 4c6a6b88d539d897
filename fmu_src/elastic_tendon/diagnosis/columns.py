"""What a curve adds while the actuator moves as it did, and what the error makes of it."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any, Literal

import numpy as np

from elastic_tendon.actuator.interfaces import InterfaceKind
from elastic_tendon.actuator.parameters import sizes_of
from elastic_tendon.comparison.residuals import Array, residuals_of, rms, simulate_measurement
from elastic_tendon.diagnosis.effect_text import law_text
from elastic_tendon.diagnosis.forms import FORMS, Curve, Grid, grid_over
from elastic_tendon.diagnosis.history import lagging, ringing, slipping
from elastic_tendon.diagnosis.motion import Motion, per_angle
from elastic_tendon.diagnosis.peaks import strongest
from elastic_tendon.diagnosis.splines import bump
from elastic_tendon.effects.base import (
    FrictionBounds,
    Joint,
    JointPulley,
    MotorAngle,
    Signal,
    Slot,
    Spring,
)
from elastic_tendon.errors import SimulationError

# what a column is added to: load torque (N·m), motor position (rad), read joint position (rad)
Acts = Literal["load", "motor", "reading"]
Answer = Callable[[Any], Any]  # equations of an effect for given coefficients: place -> answer

PROBE_PARTS, PATH_PARTS, MOMENTS = 3, 5, 20
WAVES = range(5, 31)  # in a turn: poles, teeth, balls; bumps show what is longer
SWINGS = 2  # frequencies, of the highest peaks of the errors
# of the actuator's sizes, the least change by which a response is found
LEAST_CHANGE = 1e-7


@dataclass(frozen=True)
class Term:
    """Something that the error may depend on.

    `variables` are told to users; `columns` gives what is added in a motion of n samples, (n, k);
    `curve` is None for what can be seen but not be learned.
    """

    variables: tuple[str, ...]
    acts: Acts
    columns: Callable[[Motion], Array]
    curve: Curve | None = None


def terms_for(motions: Sequence[Motion]) -> list[Term]:
    """Everything that the error is held against, over the ranges of these recordings.

    Parameters
    ----------
    motions : of all recordings

    Returns
    -------
    list of Term; what never changes is left out
    """
    found = []
    for form in FORMS:
        if not all(motion.model.kind.has_slot(form.slot) for motion in motions):
            continue
        grids = [
            _grid(motions, axis, parts) for axis, parts in zip(form.axes, form.parts, strict=True)
        ]
        if all(grids):
            found.append(_curve_term(Curve(form, tuple(grid for grid in grids if grid))))
    return found + _probes(motions)


def _grid(motions: Sequence[Motion], axis: str, parts: int) -> Grid | None:
    return grid_over(np.concatenate([getattr(motion, axis) for motion in motions]), parts)


def _curve_term(curve: Curve) -> Term:
    namespace: dict[str, Any] = {}
    exec(law_text(curve), namespace)
    acts, at_slot = _AT_SLOT[curve.form.slot]

    def columns(motion: Motion) -> Array:
        return at_slot(_answer(namespace["equations"], curve), motion).T

    return Term(curve.form.variables, acts, columns, curve)


def _answer(equations: Callable[..., Any], curve: Curve) -> Answer:
    """The equations with each of k coefficients 1 and the others 0, (k, n) at n places."""
    each = np.eye(len(curve.names))[..., np.newaxis]
    p = SimpleNamespace(**dict(zip(curve.names, each, strict=True)))
    return lambda at: equations(at, p, None, None)


# ---- what each slot adds -------------------------------------------------------------------


def _joint_torque(answer: Answer, motion: Motion) -> Array:
    return np.asarray(answer(Joint(motion.position, motion.velocity)).value)


def _friction(bounds: FrictionBounds, motion: Motion) -> Array:
    """The torque that opposes the motion; a joint at rest shows none."""
    sign = np.sign(motion.velocity)
    return np.asarray(np.where(sign > 0, bounds.lower, np.where(sign < 0, bounds.upper, 0.0)))


def _dry_friction(answer: Answer, motion: Motion) -> Array:
    return _friction(answer(Joint(motion.position, motion.velocity)), motion)


def _tendon_loss(answer: Answer, motion: Motion) -> Array:
    radius = motion.model.transmission.joint_pulley_radius
    return _friction(answer(JointPulley(*motion.tensions, radius)), motion)


def _spring_torque(answer: Answer, motion: Motion) -> Array:
    transmission = motion.model.transmission
    radius, torque = transmission.joint_pulley_radius, np.zeros(1)
    springs = (transmission.upper_spring, transmission.lower_spring)
    for sign, spring, length in zip((1.0, -1.0), springs, motion.elongations, strict=True):
        rate = -sign * radius * motion.deflection_rate
        place = Spring(length, rate, spring.stiffness, spring.max_deflection, sign)
        own = np.where(length > 0, answer(place).value, 0.0)
        torque = torque + sign * radius * spring.parallel * own
    return torque


def _angle(answer: Answer, motion: Motion) -> Array:
    return np.asarray(answer(MotorAngle(motion.motor_position, 0.0)).value - motion.motor_position)


def _reading(answer: Answer, motion: Motion) -> Array:
    return np.asarray(answer(Signal(motion.position)).value)


_AT_SLOT: Mapping[Slot, tuple[Acts, Callable[[Answer, Motion], Array]]] = {
    Slot.JOINT_TORQUE: ("load", _joint_torque),
    Slot.DRY_FRICTION: ("load", _dry_friction),
    Slot.TENDON_LOSS: ("load", _tendon_loss),
    Slot.SPRING_LAW: ("load", _spring_torque),
    Slot.ANGLE_MAP: ("motor", _angle),
    Slot.JOINT_SIGNAL: ("reading", _reading),
}


# ---- what can be seen but not be learned ---------------------------------------------------


def _probes(motions: Sequence[Motion]) -> list[Term]:
    """Drift, ageing, hysteresis, paths of tendons, errors of the measured load, a changing inertia,
    losses of springs, cogging, a motor that comes late, a part that swings on the link."""
    longest = max(float(motion.time[-1]) for motion in motions)

    def drift(motion: Motion) -> Array:
        share = motion.time / longest
        return np.column_stack([share, share**2])

    def ageing(motion: Motion) -> Array:
        torques = (motion.elastic_torque, motion.velocity, np.sign(motion.velocity))
        return np.hstack([drift(motion) * torque[:, np.newaxis] for torque in torques])

    acts: tuple[Acts, ...] = ("load", "reading")
    found = [Term(("time",), place, drift) for place in acts]
    found.append(Term(("time", "elastic_torque"), "load", ageing))
    if grid := _grid(motions, "position", PATH_PARTS):
        found.append(Term(("joint_position", "slack_state"), "load", _paths(grid)))
        found.append(Term(("joint_position", "history"), "load", _joint_history))
    if _grid(motions, "deflection", PROBE_PARTS):
        found.append(Term(("elongation", "history"), "load", _spring_history))
    along: tuple[tuple[tuple[str, ...], str, Callable[[Motion], Array]], ...] = (
        (("load_torque",), "load_torque", lambda motion: np.ones(len(motion.time))),
        (("joint_position", "joint_acceleration"), "position", lambda motion: motion.acceleration),
        (("deflection", "deflection_rate"), "deflection", _deflection_sign),
    )
    for variables, axis, factor in along:
        if grid := _grid(motions, axis, PROBE_PARTS):
            found.append(Term(variables, "load", _bumps(grid, axis, factor)))
    found += [Term(("joint_position",), "load", _waves(count)) for count in WAVES]
    return found + _late(motions) + _swings(motions)


def _late(motions: Sequence[Motion]) -> list[Term]:
    """A motor whose position, where that is given, is not yet there, or not there any more."""
    if any(motion.measurement.static or motion.model.kind.has_rotor for motion in motions):
        return []

    def columns(motion: Motion) -> Array:
        sizes = sizes_of(motion.model.transmission, motion.model.link)
        typical = (sizes.inertia / sizes.joint_stiffness) ** 0.5
        return lagging(motion.motor_position, motion.time, typical)

    return [Term(("motor_position", "history"), "motor", columns)]


def _swings(motions: Sequence[Motion]) -> list[Term]:
    """Parts on the link that swing at frequencies at which the errors do."""
    if not all(motion.model.kind.has_link for motion in motions):
        return []
    moving = [motion for motion in motions if not motion.measurement.static]
    errors = [(motion.time, error) for motion in moving for error in motion.errors.values()]

    def term(frequency: float) -> Term:
        def columns(motion: Motion) -> Array:
            return ringing(motion.acceleration, motion.time, frequency)

        return Term(("joint_acceleration", "history"), "load", columns)

    return [term(frequency) for frequency in strongest(errors, SWINGS)]


def _deflection_sign(motion: Motion) -> Array:
    return np.sign(motion.deflection_rate)


def _paths(grid: Grid) -> Callable[[Motion], Array]:
    """Tendons whose path is longer or shorter by the joint's position; each shows while taut."""

    def columns(motion: Motion) -> Array:
        each = [bump((motion.position - x) / grid.width) for x in grid.centres]
        return np.column_stack([part * (taut > 0) for taut in motion.tensions for part in each])

    return columns


def _joint_history(motion: Motion) -> Array:
    """Friction of the joint that yields before it slips."""
    transmission = motion.model.transmission
    longest = sizes_of(transmission, motion.model.link).max_deflection
    return slipping(motion.position, longest / transmission.joint_pulley_radius)


def _spring_history(motion: Motion) -> Array:
    """Hysteresis of the springs; a slack one shows none."""
    longest = sizes_of(motion.model.transmission, motion.model.link).max_deflection
    upper, lower = (
        slipping(elongation, longest) * (elongation > 0)[:, np.newaxis]
        for elongation in motion.elongations
    )
    return motion.model.transmission.joint_pulley_radius * (upper - lower)


def moments(only: Motion) -> Term:
    """A load at each moment of one recording."""
    grid = grid_over(only.time, MOMENTS)
    assert grid is not None
    columns = _bumps(grid, "time", lambda motion: np.full(len(motion.time), float(motion is only)))
    return Term(("time",), "load", columns)


def _waves(count: int) -> Callable[[Motion], Array]:
    """So many waves in a turn of the joint."""

    def columns(motion: Motion) -> Array:
        return np.column_stack([np.sin(count * motion.position), np.cos(count * motion.position)])

    return columns


def _bumps(grid: Grid, axis: str, factor: Callable[[Motion], Array]) -> Callable[[Motion], Array]:
    """Bumps over one variable, each times a factor that changes with the motion."""

    def columns(motion: Motion) -> Array:
        values = getattr(motion, axis)
        each = [bump((values - x) / grid.width) * factor(motion) for x in grid.centres]
        return np.column_stack(each)

    return columns


# ---- what the error makes of it ------------------------------------------------------------


def responses(motion: Motion, acts: Acts, columns: Array) -> dict[str, Array]:
    """What each column, added where it acts, does to the error of every signal.

    The model is simulated once for each column, moved by about as much as it errs. Where the joint
    is given, a load is one that the tendons lack: it shows in their torque, and turns the rotor.

    Parameters
    ----------
    motion : Motion of n samples
    acts : where the columns act
    columns : (n, k) array

    Returns
    -------
    dict, signal -> (n, k) array, its unit by that of the column; zero where the model cannot be
    simulated
    """
    found = {name: np.zeros(columns.shape) for name in motion.errors}
    kind, share = motion.model.kind, motion.model.transmission.motor_share
    if acts == "motor" and kind.has_rotor:  # a torque drives it wherever it goes
        return found
    if acts == "reading" and kind.has_link:
        found["joint_position"] = columns.copy()
        return found
    if acts == "load" and not kind.has_link:
        for name, part in (("joint_torque", columns), ("motor_torque", share * columns)):
            if name in found:
                found[name] += part
        if not kind.has_rotor:
            return found
    moving, factor = _input_moved(acts, kind, share)
    measurement = motion.measurement
    first = measurement.first_signal
    change = max(rms(motion.errors[first]) / per_angle(motion.model, measurement), LEAST_CHANGE)
    if acts == "load":
        change *= sizes_of(motion.model.transmission, motion.model.link).joint_stiffness
    given = measurement.inputs.get(moving, np.zeros(len(measurement.time)))
    for index, column in enumerate(columns.T):
        height = float(np.max(np.abs(column)))
        if height == 0.0:
            continue
        step = change / height
        moved = {moving: given + factor * step * column}
        try:
            after = residuals_of(
                simulate_measurement(motion.model, measurement, motion.initial, **moved),
                measurement,
            )
        except SimulationError:
            continue
        for name, values in after.items():
            found[name][:, index] += (values - motion.errors[name]) / step
    return found


def _input_moved(acts: Acts, kind: InterfaceKind, motor_share: float) -> tuple[str, float]:
    """The input that a column moves, and how many times it does."""
    if acts == "motor":
        return "motor_position", 1.0
    if acts == "reading":  # of a joint that is given: where it reads too much it is behind
        return "joint_position", -1.0
    return ("load_torque", 1.0) if kind.has_link else ("motor_torque", -motor_share)
