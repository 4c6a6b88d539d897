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

from elastic_tendon.compiled import Trajectory
from elastic_tendon.errors import MeasurementError, SimulationError
from elastic_tendon.identify.excerpt import liveliest
from elastic_tendon.identify.initial_state import estimate_initial_state
from elastic_tendon.identify.plausibility import implausible, static_suspicion
from elastic_tendon.identify.readings import (
    Reading,
    gear_reading,
    readings_of,
    time_readings,
    torque_readings,
)
from elastic_tendon.identify.residuals import simulate_measurement
from elastic_tendon.measurement import Measurement
from elastic_tendon.parameters import Model

SAMPLES = 2000  # of the excerpt; one simulation of it takes about a millisecond
# shares of the joint's spread that a simulation leaves unexplained
FINE = 0.02  # a recording that leaves no more as declared is not looked into
# shorter pieces are explained by their initial state under almost any reading
FEWEST, PERIODS = 100, 4.0  # samples, natural periods of the joint
LIKE = 1.5  # of readings this close the one that comes first in the table is told
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
    excerpt = liveliest(measurement, SAMPLES)
    declared = _unexplained(model, excerpt)
    found = _misread(model, excerpt, declared)
    if found is not None:
        return (_sentence(measurement, found, declared),)
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


def _misread(model: Model, excerpt: Measurement, declared: float) -> _Trial | None:
    """The reading that explains an excerpt far better than what is declared, if there is one."""
    if declared <= FINE:
        return None
    # a duration in a wrong unit says nothing, so readings of time are tried in any case
    table, gear = time_readings(excerpt), None
    if _is_long(model, excerpt):
        table, gear = readings_of(excerpt), gear_reading(model, excerpt)
    trials = [
        _Trial(reading, _unexplained(model, reading.apply(excerpt)))
        for reading in (table if gear is None else (*table, gear))
    ]
    good = [
        one
        for one in trials
        if one.unexplained <= one.reading.well and declared >= one.reading.gain * one.unexplained
    ]
    if not good:
        return None
    best = min(one.unexplained for one in good)
    return next(one for one in good if one.unexplained <= max(LIKE * best, FINE))


def _is_long(model: Model, excerpt: Measurement) -> bool:
    """Whether an excerpt, as declared, shows more than its initial state."""
    radii = model.transmission
    springs = radii.upper_spring.combined_stiffness + radii.lower_spring.combined_stiffness
    stiffness = radii.joint_pulley_radius**2 * springs
    period = 2.0 * math.pi * math.sqrt(model.link.inertia / stiffness)
    duration = float(excerpt.time[-1] - excerpt.time[0])
    return len(excerpt.time) >= FEWEST and duration >= PERIODS * period


def _unexplained(model: Model, excerpt: Measurement) -> float:
    """RMS of the error less its mean over that of the joint's motion; infinite without motion.

    A constant offset between the encoders is nobody's misreading, but it may throw the simulated
    joint far off at the start: the better counts of the recording as it stands and without the
    mean deflection.
    """
    radii = model.transmission
    ratio = radii.motor_pulley_radius / radii.joint_pulley_radius
    joint = excerpt.signals["joint_position"]
    spread = float(np.std(joint))
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
    moved = replace(excerpt, signals={"joint_position": joint})
    try:
        return simulate_measurement(model, moved, estimate_initial_state(model, moved))
    except SimulationError:
        return None


def _sentence(measurement: Measurement, found: _Trial, declared: float) -> str:
    cure = found.reading.cure(measurement.preparation)
    return (
        f"{measurement.name}: {found.reading.what}: as declared the model errs by {declared:.3g} "
        f"times the signal's spread, read so by {found.unexplained:.3g} times; read it with {cure}"
    )


# ---- torques measured beside the joint position ---------------------------------------------


def _torque_suspicions(model: Model, measurement: Measurement, excerpt: Measurement) -> list[str]:
    measured = [one for one in ("joint_torque", "motor_torque") if one in excerpt.signals]
    if not measured or not _is_long(model, excerpt):
        return []
    trajectory = _trajectory(model, excerpt, 0.0)
    if trajectory is None:
        return []
    found = (_torque_suspicion(one, trajectory, measurement, excerpt) for one in measured)
    return [one for one in found if one]


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
            return _sentence(measurement, _Trial(reading, read), declared)
    return ""
