"""Signals of opposite sign, reported before any fit, from a model whose parameters may be wrong.

What the motor does to the joint and what the load does to it are simulated apart, and the measured
joint position is written as a sum of the two. Numbers that are wrong and effects that are missing
change by how much each counts, but hardly its sign: both negative, the joint's sign is wrong; one
negative, that of the motor or of the load. Torques measured beside are held against the torque of
the springs under the deflection that was measured.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.transmission import characteristic_torque
from elastic_tendon.comparison.residuals import (
    Array,
    InitialState,
    sensitivity,
    simulate_measurement,
)
from elastic_tendon.errors import SimulationError
from elastic_tendon.estimation.stretches import left_out
from elastic_tendon.measurement import Measurement
from elastic_tendon.measurement.excerpt import liveliest
from elastic_tendon.misreadings.readings import (
    GAIN,
    WELL,
    Reading,
    measured_of,
    name,
    positions_of,
)
from elastic_tendon.misreadings.suspicion import SAMPLES, unexplained_motion

POSITION = "joint_position"
LEAST, SURE = 0.25, 4.0  # share of what was expected; standard errors by which it is not 0
INERTIAS = (0.4, 0.63, 1.0, 1.6, 2.5)  # times the given one, under which answers are looked at
STRETCHES = 12  # left out in turn, for standard errors
BETTER = 0.9  # share of the unexplained motion that the right sign leaves at most
STRAIGHT = 0.5  # least correlation of a torque with the springs'
MOVES = 0.02  # share of the joint's spread that an input must move, to be judged by it


@dataclass(frozen=True)
class Finding:
    """Signals of one recording of which one has its sign turned, the plainest first."""

    recording: str
    signals: tuple[str, ...]
    sentence: str


def sign_errors(model: Model, measurements: Sequence[Measurement]) -> list[Finding]:
    """Recordings of which a signal has the opposite sign.

    Parameters
    ----------
    model : Model; its numbers may be wrong, and it may lack effects
    measurements : sequence of Measurement, with ``joint_position``

    Returns
    -------
    list of Finding, at most one for each recording: two signals where they cannot be distinguished
    """
    errors = []
    for measurement in measurements:
        signals = (
            _flipped_static(measurement) if measurement.static else _flipped(model, measurement)
        )
        if signals:
            errors.append(Finding(measurement.name, signals, _sentence(measurement, signals)))
    return errors


def _sentence(measurement: Measurement, signals: tuple[str, ...]) -> str:
    cures = " or ".join(
        Reading("", {signal: -1.0}).options(measurement.preparation) for signal in signals
    )
    subject = " or the ".join(name(signal) for signal in signals)
    return (
        f"{measurement.name}: the {subject} looks as if it had the opposite sign; read it with "
        f"{cures}"
    )


def _flipped_static(measurement: Measurement) -> tuple[str, ...]:
    """Torque and deflection of a static curve; turned about both, it cannot tell which."""
    deflection, load = measurement.signals[POSITION], measurement.load_torque
    if load is None or np.ptp(deflection) == 0.0 or np.ptp(load) == 0.0:
        return ()
    correlation = float(np.corrcoef(deflection, load)[0, 1])
    return ("joint_torque", "joint_deflection") if correlation <= -STRAIGHT else ()


def _flipped(model: Model, measurement: Measurement) -> tuple[str, ...]:
    if np.ptp(measurement.signals[POSITION]) == 0.0:
        return ()
    excerpt = liveliest(measurement, SAMPLES)
    try:
        signals = _flipped_motion(model, excerpt)
    except SimulationError:
        return ()
    return signals or _flipped_torque(model, excerpt)


def _flipped_motion(model: Model, excerpt: Measurement) -> tuple[str, ...]:
    """Of joint, motor and load, which has its sign turned."""
    model, signs = _signs(model, excerpt)
    motor, load = signs.get("motor_position", 0), signs.get("load_torque", 0)
    shown = positions_of(excerpt)[0]
    suspects = {
        (-1, -1): (shown,),
        (-1, 1): ("motor_position",),
        (1, -1): ("load_torque",),
        (-1, 0): (shown, "motor_position"),
        (0, -1): (shown, "load_torque"),
    }.get((motor, load))
    declared = unexplained_motion(model, excerpt)
    tried = suspects or tuple(excerpt.inputs)
    if not tried:  # a link without springs that no load drives
        return ()
    left = {
        signal: unexplained_motion(model, Reading("", {signal: -1.0}).apply(excerpt))
        for signal in tried
    }
    if suspects:
        return tuple(signal for signal in tried if left[signal] <= BETTER * declared)
    best = min(tried, key=left.__getitem__)
    return (best,) if left[best] <= min(WELL, declared / GAIN) else ()


def _signs(model: Model, excerpt: Measurement) -> tuple[Model, dict[str, int]]:
    """By input, 1 or -1 where the joint surely answers as, or against, what the model expects.

    An input that hardly moves is not among them, and 0 is one whose answer is not clear. Near the
    joint's resonance a wrong inertia turns the answer about, so that of several under which the
    answers explain most is taken, which no sign takes part in; the model with it is returned too.
    """
    inertia = model.link.inertia
    tried = [model.with_values({"link.inertia": by * inertia}) for by in INERTIAS]
    parts = [_parts(changed, excerpt) for changed in tried]
    joint = measured_of(excerpt, excerpt.signals[POSITION])
    left = [float(np.sum((columns @ _shares(columns, joint) - joint) ** 2)) for _, columns in parts]
    best = int(np.argmin(left))
    names, columns = parts[best]
    share, error = _fitted(columns, joint)
    return tried[best], {
        key: int(np.sign(share[i]))
        if abs(share[i]) >= LEAST and abs(share[i]) >= SURE * error[i]
        else 0
        for i, key in enumerate(names)
    }


def _parts(model: Model, excerpt: Measurement) -> tuple[tuple[str, ...], Array]:
    """Inputs that move the joint; (n, k) what each makes of it, then all that may hide it."""
    time = excerpt.time
    spread = float(np.std(measured_of(excerpt, excerpt.signals[POSITION])))
    moving = {
        key: answer
        for key, answer in _answers(model, excerpt).items()
        if np.std(answer) > MOVES * spread
    }
    start = InitialState(model.transmission.motor_share * float(excerpt.motor_position[0]), 0.0)
    free = sensitivity(model, replace(excerpt, load_torque=None), start, ()).derivatives[POSITION]
    late = [np.gradient(answer, time) for answer in moving.values()]
    return tuple(moving), np.column_stack([*moving.values(), *late, free, np.ones_like(time)])


def _answers(model: Model, excerpt: Measurement) -> Mapping[str, Array]:
    """What each input alone makes of what was measured at the joint, (n,) rad, as the model has
    it."""
    start = InitialState(model.transmission.motor_share * float(excerpt.motor_position[0]), 0.0)
    unloaded = simulate_measurement(model, replace(excerpt, load_torque=None), start)[POSITION]
    answers = {"motor_position": measured_of(excerpt, unloaded)}
    if excerpt.load_torque is not None:
        loaded = simulate_measurement(model, excerpt, start)[POSITION]
        answers["load_torque"] = loaded - unloaded
    return answers


def _shares(columns: Array, values: Array) -> Array:
    """Least-squares shares of columns (n, k) in values (n,)."""
    scale = np.linalg.norm(columns, axis=0)
    scale[scale == 0.0] = 1.0
    return np.asarray(np.linalg.lstsq(columns / scale, values, rcond=1e-9)[0] / scale)


def _fitted(columns: Array, values: Array) -> tuple[Array, Array]:
    """Shares of columns (n, k) in values (n,), and their standard errors; (k,) each."""
    share = _shares(columns, values)
    numbers = (np.arange(len(values)) * STRETCHES) // len(values)
    moves = left_out(columns, columns @ share - values, numbers)
    return share, np.sqrt((STRETCHES - 1) * np.var(moves, axis=0))


def _flipped_torque(model: Model, excerpt: Measurement) -> tuple[str, ...]:
    """Of the torques measured beside the joint position, the first whose sign is turned."""
    deflection = excerpt.signals[POSITION] - model.transmission.motor_share * excerpt.motor_position
    springs = characteristic_torque(deflection, model.transmission)
    for signal in ("joint_torque", "motor_torque"):
        torque = excerpt.signals.get(signal)
        if torque is None or np.ptp(torque) == 0.0 or np.ptp(springs) == 0.0:
            continue
        columns = np.column_stack([springs, np.ones_like(springs)])
        share, error = _fitted(columns, torque)
        correlation = float(np.corrcoef(springs, torque)[0, 1])
        if correlation <= -STRAIGHT and share[0] <= -SURE * error[0]:
            return (signal,)
    return ()
