"""Whether one constant explains why a model errs on a recording: same machine, zero and load?

A machine that was zeroed anew, carries another tool or was recorded by another clock is not
another machine. Each constant is fitted alone, by Gauss and Newton's method on the joint position,
the model left as it is otherwise; what explains most of the error above the noise is told, the
plainest of those that do so about equally well.
"""

from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from elastic_tendon.actuator.parameters import Model, sizes_of
from elastic_tendon.comparison.initial_state import residuals_from_beginning
from elastic_tendon.comparison.residuals import (
    Array,
    noise_floors,
    rms,
)
from elastic_tendon.errors import ModelError, SimulationError
from elastic_tendon.measurement import Measurement
from elastic_tendon.misreadings.readings import readings_of

Kind = Literal["offset", "motor_offset", "load", "sign", "gain", "delay", "stiffness"]

POSITION = "joint_position"
STIFFNESSES = ("transmission.upper_spring.stiffness", "transmission.lower_spring.stiffness")
EXPLAINED = 0.75  # share of the squared error above the noise that a constant removes at least
VISIBLE = 1.5  # an error below this many times the noise needs no explanation
LIKE = 1.1  # of constants that leave errors this close, the plainest is reported
STEPS = 5  # of Gauss and Newton's method
SETTLED = 0.01  # a step that lowers the squared error by a smaller share is the last
PROBE = 0.02  # of what a constant may be at most, by which its derivative is taken
OF_MOTOR = {"offset", "motor_offset", "gain", "stiffness"}  # constants of motor and springs
MOST_LATE, MOST_OFF = 0.05, 0.9  # s; of a factor, beside 1


# kind, value, unit, RMS error that is left (rad), and a clause that says so
_Trial = tuple[Kind, float, str, float, str]


@dataclass(frozen=True)
class Explanation:
    """A constant that explains most of a recording's error in joint position.

    `value` is what it is, in `unit` ("1" for a factor); `rmse_before` and `rmse_after` are in rad.
    """

    kind: Kind
    value: float
    unit: str
    rmse_before: float
    rmse_after: float
    sentence: str


@dataclass(frozen=True)
class _Constant:
    """A constant to try: what it does to model and recording, and how it is told.

    `most` is how far from `null` it may be; `say` makes a clause of its value.
    """

    kind: Kind
    unit: str
    null: float
    most: Callable[[Model], float]
    change: Callable[[Model, Measurement, float], tuple[Model, Measurement]]
    say: str


def explained_by(model: Model, measurement: Measurement) -> Explanation | None:
    """The constant that explains most of the error of a model on a recording.

    Parameters
    ----------
    model : Model, fitted elsewhere
    measurement : Measurement, with ``joint_position``

    Returns
    -------
    Explanation, the plainest of those that leave about the same error; None where no constant
    removes three quarters of the squared error above the noise, or there is hardly any

    Raises
    ------
    SimulationError : the model cannot be simulated
    """
    floor = noise_floors(measurement)[POSITION]
    error = _error(model, measurement)
    before = rms(error)
    if before <= VISIBLE * floor:
        return None
    limit = floor**2 + (1.0 - EXPLAINED) * (before**2 - floor**2)
    explanations = []
    for kind, value, unit, after, clause in _trials(model, measurement, error):
        if after**2 <= limit:
            words = _sentence(measurement, clause, before, after)
            explanations.append(Explanation(kind, value, unit, before, after, words))
        if after <= LIKE * floor:
            break  # nothing explains more, and what follows is less plain
    best = min((cause.rmse_after for cause in explanations), default=0.0)
    return next(
        (cause for cause in explanations if cause.rmse_after <= max(LIKE * best, floor)), None
    )


def _trials(model: Model, measurement: Measurement, error: Array) -> Iterator[_Trial]:
    yield from _flips(model, measurement)
    for constant in _constants(measurement):
        yield _fitted(constant, model, measurement, error)


def _sentence(measurement: Measurement, clause: str, before: float, after: float) -> str:
    return (
        f"{measurement.name}: {clause}; the model then errs by {1e3 * after:.3g} mrad RMS instead "
        f"of {1e3 * before:.3g}"
    )


def _error(model: Model, measurement: Measurement) -> Array:
    """Error in joint position, rad; (n,)."""
    return residuals_from_beginning(model, measurement)[POSITION]


def _flips(model: Model, measurement: Measurement) -> Iterator[_Trial]:
    """What is left if one signal has the opposite sign."""
    for reading in readings_of(measurement):
        if set(reading.factors.values()) != {-1.0}:
            continue
        with suppress(SimulationError):
            yield "sign", -1.0, "1", rms(_error(model, reading.apply(measurement))), reading.what


def _fitted(constant: _Constant, model: Model, measurement: Measurement, error: Array) -> _Trial:
    """The value of a constant that leaves the least, from the error without it, (n,) rad."""

    def tried(value: float) -> Array:
        try:
            return _error(*constant.change(model, measurement, value))
        except (ModelError, SimulationError):
            return np.full_like(error, np.inf)

    most = constant.most(model)
    value, best = constant.null, error
    for _ in range(STEPS):
        slope = (tried(value + PROBE * most) - best) / (PROBE * most)
        information = float(slope @ slope)
        if not 0.0 < information < np.inf:
            break
        wanted = value - float(slope @ best) / information
        moved = float(np.clip(wanted, constant.null - most, constant.null + most))
        left = tried(moved)
        gain = 1.0 - (rms(left) / rms(best)) ** 2
        if not gain > 0.0:
            break
        value, best = moved, left
        if gain < SETTLED:
            break
    clause = constant.say.format(value=value, milli=1e3 * value)
    return constant.kind, value, constant.unit, rms(best), clause


def _constants(measurement: Measurement) -> list[_Constant]:
    """Constants that can show in a recording, the plainest first."""
    still = bool(np.ptp(measurement.motor_position) == 0.0)
    hidden = {"delay"} if measurement.static else set()
    hidden |= {"gain"} if still else set()
    hidden |= OF_MOTOR if not measurement.kind.has_springs else set()
    return [constant for constant in CONSTANTS if constant.kind not in hidden]


def _largest_deflection(model: Model) -> float:
    """Deflection to which the weaker spring can be loaded, rad."""
    sizes = sizes_of(model.transmission, model.link)
    return sizes.torque / sizes.joint_stiffness


def _zeroed_joint(
    model: Model, measurement: Measurement, offset: float
) -> tuple[Model, Measurement]:
    joint = measurement.signals[POSITION] - offset
    return model, replace(measurement, signals={**measurement.signals, POSITION: joint})


def _zeroed_motor(
    model: Model, measurement: Measurement, offset: float
) -> tuple[Model, Measurement]:
    return model, replace(measurement, motor_position=measurement.motor_position - offset)


def _loaded(model: Model, measurement: Measurement, torque: float) -> tuple[Model, Measurement]:
    known = measurement.load_torque
    load = np.full_like(measurement.time, torque) + (0.0 if known is None else known)
    return model, replace(measurement, load_torque=load)


def _late(model: Model, measurement: Measurement, delay: float) -> tuple[Model, Measurement]:
    """Inputs as they were when the joint was where it was recorded later.

    Before the first sample and after the last they are taken as held.
    """
    time, load = measurement.time, measurement.load_torque
    return model, replace(
        measurement,
        motor_position=np.interp(time - delay, time, measurement.motor_position),
        load_torque=None if load is None else np.interp(time - delay, time, load),
    )


def _scaled_motor(
    model: Model, measurement: Measurement, factor: float
) -> tuple[Model, Measurement]:
    return model, replace(measurement, motor_position=factor * measurement.motor_position)


def _other_springs(
    model: Model, measurement: Measurement, factor: float
) -> tuple[Model, Measurement]:
    values = model.values()
    return model.with_values({path: factor * values[path] for path in STIFFNESSES}), measurement


# the plainest first; `say` is given the value, and a thousand times the value
CONSTANTS = (
    _Constant(
        "offset",
        "rad",
        0.0,
        lambda model: 2.0 * _largest_deflection(model),
        _zeroed_joint,
        "the zeros of joint and motor encoder differ by {milli:.3g} mrad more at the joint than "
        "they did, or a constant load acts",
    ),
    _Constant(
        "motor_offset",
        "rad",
        0.0,
        lambda model: 2.0 * _largest_deflection(model) / model.transmission.motor_share,
        _zeroed_motor,
        "the zero of the motor encoder is off by {milli:.3g} mrad",
    ),
    _Constant(
        "load",
        "N·m",
        0.0,
        lambda model: sizes_of(model.transmission, model.link).torque,
        _loaded,
        "a constant load of {value:.3g} N·m acts beside what was recorded",
    ),
    _Constant(
        "delay",
        "s",
        0.0,
        lambda _model: MOST_LATE,
        _late,
        "the joint position is late by {milli:.3g} ms",
    ),
    _Constant(
        "gain",
        "1",
        1.0,
        lambda _model: MOST_OFF,
        _scaled_motor,
        "the motor position is to be multiplied by {value:.4g}",
    ),
    _Constant(
        "stiffness",
        "1",
        1.0,
        lambda _model: MOST_OFF,
        _other_springs,
        "both springs are {value:.3g} times as stiff as the model's",
    ),
)
