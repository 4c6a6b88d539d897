"""Recordings that look as if they were read wrongly: what is odd, and how to read them right.

Every way in which recordings are usually misread is a `Reading`: a change of the signals that
would put it right. Each is tried by simulation on an excerpt. One is suspected only where the
recording as declared is badly explained and the reading explains nearly all of it. What the
simulation cannot tell, as the model without load is linear between its slack states, is judged by
what a joint, its springs and a load can be (`plausibility`).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from elastic_tendon.actuator.parameters import Model, sizes_of
from elastic_tendon.comparison.initial_state import estimate_initial_state
from elastic_tendon.comparison.residuals import simulate_measurement
from elastic_tendon.errors import MeasurementError, SimulationError
from elastic_tendon.measurement import Measurement
from elastic_tendon.measurement.excerpt import liveliest
from elastic_tendon.misreadings.plausibility import implausible, static_suspicion
from elastic_tendon.misreadings.readings import (
    Reading,
    deflection_reading,
    gear_reading,
    gear_slope,
    is_gear,
    measured_of,
    readings_of,
    time_readings,
    torque_readings,
)
from elastic_tendon.simulation.simulate import Trajectory

SAMPLES = 2000  # of the excerpt; one simulation of it takes about a millisecond
# shares of the joint's spread that a simulation leaves unexplained
FINE = 0.02  # a recording that leaves no more as declared is not looked into
# shorter pieces are explained by their initial state under almost any reading
FEWEST, PERIODS = 100, 4.0  # samples, natural periods of the joint
SELDOM = 10.0  # natural periods between samples
LIKE = 1.5  # of readings this close the first of the table is reported
CLEARLY = 3.0  # a gear that leaves this much less unexplained than a unit is reported alone
# a gear's ratio is sought this far about what the motion's slope says, and to this share
FAR_RATIO, SHARP = 3.0, 1e-4
WHOLE = 0.03  # a ratio this close to a whole number or to a unit may be that
# the same for a measured torque, which holds friction as well
TORQUE_BADLY, TORQUE_WELL = 0.5, 0.3


@dataclass(frozen=True)
class _Trial:
    """A reading with the share of the joint's spread that it leaves unexplained."""

    reading: Reading
    unexplained: float


def suspicions(model: Model, measurement: Measurement) -> tuple[str, ...]:
    """What looks as if it was read wrongly, a sentence each, the likeliest first.

    Parameters
    ----------
    model : Model
    measurement : Measurement; SI units, with ``joint_position``

    Returns
    -------
    tuple of sentences; each says what was found, by what number, and how to read the file right
    """
    if measurement.static:
        return static_suspicion(model, measurement) or implausible(
            model, measurement, explained=False
        )
    if np.ptp(measurement.signals["joint_position"]) == 0.0:
        return implausible(model, measurement, explained=False)  # nothing moves, to be explained
    excerpt = liveliest(measurement, SAMPLES)
    declared = unexplained_motion(model, excerpt)
    trials = _misread(model, excerpt, declared)
    if trials:
        return (_sentence(measurement, trials, declared),)
    return (
        *implausible(model, measurement, explained=declared <= FINE),
        *_torque_suspicions(model, measurement, excerpt),
    )


def refuse_suspicious(model: Model, measurements: Sequence[Measurement]) -> None:
    """Refuse recordings that look as if they were read wrongly.

    Parameters
    ----------
    model : Model
    measurements : sequence of Measurement

    Raises
    ------
    MeasurementError : the first suspicion, and that ``--as-declared`` takes the data as they are
    """
    for measurement in measurements:
        for sentence in suspicions(model, measurement):
            raise MeasurementError(f"{sentence}; if the file is right, add --as-declared")


def _misread(model: Model, excerpt: Measurement, declared: float) -> tuple[_Trial, ...]:
    """The reading that explains an excerpt far better than what is declared, if there is one.

    Two where two units, or a unit and the ratio of a gear, cannot be distinguished.
    """
    if declared <= FINE:
        return ()
    # a duration in a wrong unit says nothing, so readings of time are tried in any case
    table, gear = time_readings(excerpt), None
    if _is_long(model, excerpt):
        table = readings_of(excerpt)
        if excerpt.motor_share is None and model.kind.has_springs:
            table, gear = (*table, deflection_reading(model)), _gear(model, excerpt)
    trials = [_Trial(reading, _left_by(model, excerpt, reading)) for reading in table]
    good = [trial for trial in trials if _explains(trial, declared)]
    explaining = [*good, gear] if gear is not None and _explains(gear, declared) else good
    if not explaining:
        return ()
    best = _first_of_best(explaining)
    likely = (best,) if gear is None else _beside_gear(best, gear, good)
    likely = likely if len(likely) > 1 else (*likely, *_other_unit(likely[0], good))
    return tuple(sorted(likely, key=lambda trial: trial.unexplained))


def _left_by(model: Model, excerpt: Measurement, reading: Reading) -> float:
    """What a reading leaves unexplained, a share of the spread of what it makes of the column."""
    read = reading.apply(excerpt)
    if "time" in reading.factors and not _is_long(model, read):
        return math.inf  # its initial state would explain it
    unexplained = unexplained_motion(model, read)
    if reading.motor_share:
        # a joint that is held shows no deflection of its own to explain
        spread = float(np.std(excerpt.signals["joint_position"]))
        unexplained *= float(np.std(read.signals["joint_position"])) / spread
    return unexplained


def _explains(trial: _Trial, declared: float) -> bool:
    reading = trial.reading
    return trial.unexplained <= reading.well and declared >= reading.gain * trial.unexplained


def _first_of_best(trials: Sequence[_Trial]) -> _Trial:
    best = min(trial.unexplained for trial in trials)
    return next(trial for trial in trials if trial.unexplained <= max(LIKE * best, FINE))


def _beside_gear(best: _Trial, gear: _Trial, others: Sequence[_Trial]) -> tuple[_Trial, ...]:
    """The best reading, beside the gear or a unit of the same column that may be meant as well."""
    ((signal, by_gear),) = gear.reading.factors.items()
    unit = (
        best
        if best is not gear
        else next(
            (
                trial
                for trial in others
                if set(trial.reading.factors) == {signal} and trial.reading.unit
            ),
            None,
        )
    )
    if unit is None or set(unit.reading.factors) != {signal} or unit.reading.unit is None:
        return (best,)
    if gear.unexplained <= unit.unexplained / CLEARLY:
        return (gear,)
    if abs(by_gear / unit.reading.factors[signal] - 1.0) <= WHOLE:
        return (unit,)
    return unit, gear


def _other_unit(best: _Trial, others: Sequence[_Trial]) -> tuple[_Trial, ...]:
    """Another unit of the same columns that explains nearly as much, if there is one."""
    columns = set(best.reading.factors)
    close = [
        trial
        for trial in others
        if trial is not best and trial.reading.unit and set(trial.reading.factors) == columns
        if best.reading.unit and trial.unexplained <= LIKE * best.unexplained
    ]
    return tuple(sorted(close, key=lambda trial: trial.unexplained)[:1])


def _gear(model: Model, excerpt: Measurement) -> _Trial | None:
    """The gear whose ratio explains an excerpt best; a whole number where that does as well."""
    from scipy.optimize import minimize_scalar

    slope = gear_slope(model, excerpt)
    if slope is None:
        return None

    def trial(ratio: float) -> _Trial:
        reading = gear_reading(ratio, slope)
        return _Trial(reading, unexplained_motion(model, reading.apply(excerpt)))

    start = max(abs(slope), 1.0 / abs(slope))
    # where the motor counts before the gear, what is left is nearly a parabola over 1 / ratio
    minimum = minimize_scalar(
        lambda inverse: min(trial(1.0 / inverse).unexplained ** 2, 1e9),
        bounds=(1.0 / (FAR_RATIO * start), 1.0 / max(start / FAR_RATIO, 1.0)),
        method="bounded",
        options={"xatol": SHARP / start},
    )
    ratio = 1.0 / float(minimum.x)
    if not is_gear(ratio):
        return None
    rounded = [float(f"{ratio:.4g}")]
    if abs(ratio / round(ratio) - 1.0) <= WHOLE:
        rounded.insert(0, float(round(ratio)))
    return _first_of_best([trial(candidate) for candidate in rounded])


def _is_long(model: Model, excerpt: Measurement) -> bool:
    """Whether an excerpt, as declared, shows more than its initial state."""
    duration = float(excerpt.time[-1] - excerpt.time[0])
    return len(excerpt.time) >= FEWEST and duration >= PERIODS * _period(model)


def _period(model: Model) -> float:
    """Natural period of the joint on both springs, s; without springs a usual one."""
    stiffness = sizes_of(model.transmission, model.link).joint_stiffness
    return 2.0 * math.pi * math.sqrt(model.link.inertia / stiffness)


def unexplained_motion(model: Model, excerpt: Measurement) -> float:
    """RMS of the error less its mean over that of what was measured; infinite without motion.

    A constant offset between the encoders is nobody's misreading, but it may throw the simulated
    joint far off at the start: the better counts of the recording as it stands and without the
    mean deflection.
    """
    ratio = model.transmission.motor_share
    joint = excerpt.signals["joint_position"]
    spread = float(np.std(measured_of(excerpt, joint)))
    if spread == 0.0:
        return math.inf
    offset = float(np.mean(joint - ratio * excerpt.motor_position))
    errors = [
        float(np.std(trajectory[trajectory.measured("joint_position")] - joint))
        for trajectory in (_trajectory(model, excerpt, offset) for offset in (0.0, offset))
        if trajectory is not None
    ]
    return min(errors, default=math.inf) / spread


def _trajectory(model: Model, excerpt: Measurement, offset: float) -> Trajectory | None:
    """Simulated excerpt whose joint position is less by an offset (rad); None where it fails."""
    joint = excerpt.signals["joint_position"] - offset
    # a joint seen that seldom rests at every sample; still slower would only take longer
    step = float(np.median(np.diff(excerpt.time)))
    faster = min(SELDOM * _period(model) / step, 1.0)
    moved = replace(excerpt, time=faster * excerpt.time, signals={"joint_position": joint})
    try:
        return simulate_measurement(model, moved, estimate_initial_state(model, moved))
    except SimulationError:
        return None


def _sentence(measurement: Measurement, trials: Sequence[_Trial], declared: float) -> str:
    clauses = [
        f"{trial.reading.what}: as declared the model errs by {declared:.3g} times the signal's "
        f"spread, read so by {trial.unexplained:.3g} times; "
        f"{trial.reading.cure(measurement.preparation)}"
        for trial in trials
    ]
    return f"{measurement.name}: " + "; or ".join(clauses)


# ---- torques measured beside the joint position ---------------------------------------------


def _torque_suspicions(model: Model, measurement: Measurement, excerpt: Measurement) -> list[str]:
    measured = [signal for signal in ("joint_torque", "motor_torque") if signal in excerpt.signals]
    if not measured or not _is_long(model, excerpt):
        return []
    trajectory = _trajectory(model, excerpt, 0.0)
    if trajectory is None:
        return []
    suspicions = (
        _torque_suspicion(signal, trajectory, measurement, excerpt) for signal in measured
    )
    return [suspicion for suspicion in suspicions if suspicion]


def _torque_suspicion(
    signal: str, trajectory: Trajectory, measurement: Measurement, excerpt: Measurement
) -> str:
    def unexplained(factor: float) -> float:
        torque = factor * excerpt.signals[signal]
        spread = float(np.std(torque))
        error = float(np.std(trajectory[trajectory.measured(signal)] - torque))
        return error / spread if spread > 0.0 else math.inf

    declared = unexplained(1.0)
    if declared < TORQUE_BADLY:
        return ""
    for reading in torque_readings(excerpt, signal):
        read = unexplained(reading.factors[signal])
        if read <= TORQUE_WELL:
            return _sentence(measurement, [_Trial(reading, read)], declared)
    return ""
