"""How far and how fast the inputs of a further experiment may go.

What the machine bears is known from its springs, (16), and what its drive and its load can do
from the recordings. A further experiment may go a little beyond what was recorded, because what
was recorded did not decide.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from elastic_tendon.actuator.design import design
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.comparison.residuals import Array
from elastic_tendon.measurement import Measurement
from elastic_tendon.simulation.excitation import RATE

BEYOND_RECORDED = 1.5  # times the range and the speed that were recorded
WIDER = 3.0  # times that, where nothing less decides
LOADING_TIME = 0.5  # s from the lowest to the highest load where no rate is known
MARGIN = 0.9  # share of the deflection (16) that is used; the springs' numbers are uncertain
SPEED_WINDOW = 0.05  # s over which a speed is taken, so that the encoder's noise is not one
SHORTEST, LONGEST = 6.0, 20.0  # s of an experiment, whatever was recorded
MOST_SAMPLES = 10_000  # ... but slow recordings may be longer, up to so many samples
LEAST_DEFLECTION = 1e-6  # rad; a spring that pretension alone stretches to its limit has none
HELD = 0.05  # a motor that moved by less than this share of the deflection range was held
HELD_SPEED = 0.05  # times natural frequency and deflection range: what such a motor may do


@dataclass(frozen=True)
class Reach:
    """Where one input starts (and ends), between which values it may go, and how fast.

    `start`, `low`, `high` in rad or N·m, `rate` in the same per second; `recorded` : lowest and
    highest value in the recordings.
    """

    start: float
    low: float
    high: float
    rate: float
    recorded: tuple[float, float]


@dataclass(frozen=True)
class Limits:
    """What a further experiment may do.

    `load` is None where no load was recorded. `deflection` : lowest and highest, rad. `step` s
    between samples, `duration` s. `frequency` : natural, with both tendons taut, Hz.
    `torque` : lowest and highest load that the springs bear at rest, N·m.
    `motor_was_held` : its reach is not from the recordings but from the springs.
    """

    motor: Reach
    load: Reach | None
    deflection: tuple[float, float]
    step: float
    duration: float
    frequency: float
    motor_was_held: bool
    torque: tuple[float, float]

    def widened(self) -> "Limits":
        """What a machine might do that can move further and faster, and bear a load at all."""
        middle = 0.5 * (self.motor.low + self.motor.high)
        half = 0.5 * WIDER * (self.motor.high - self.motor.low)
        low, high = self.torque
        motor = replace(
            self.motor, low=middle - half, high=middle + half, rate=WIDER * self.motor.rate
        )
        load = Reach(0.0, low, high, rate=(high - low) / LOADING_TIME, recorded=(0.0, 0.0))
        return replace(self, motor=motor, load=load)

    def sample_times(self) -> Array:
        """Times of the samples to record, (n,) s from 0."""
        return np.asarray(self.step * np.arange(round(self.duration / self.step) + 1))


def limits_of(models: Sequence[Model], measurements: Sequence[Measurement]) -> Limits:
    """Limits that hold whichever of the models is right.

    Parameters
    ----------
    models : at least one, each fitted to the recordings
    measurements : the recordings, at least one

    Returns
    -------
    Limits
    """
    tables = [design(model) for model in models]
    timed = [recording for recording in measurements if not recording.static]
    step = min(
        (float(np.median(np.diff(recording.time))) for recording in timed), default=1.0 / RATE
    )
    recorded = max(
        (float(recording.time[-1] - recording.time[0]) for recording in timed), default=SHORTEST
    )
    longest = max(LONGEST, MOST_SAMPLES * step)
    deflection = (
        MARGIN * min(max(table.negative_max_deflection for table in tables), -LEAST_DEFLECTION),
        MARGIN * max(min(table.positive_max_deflection for table in tables), LEAST_DEFLECTION),
    )
    # a load on the joint pushes it the way it acts: its torque is against that of the tendons
    torque = (
        max(-abs(table.negative_max_torque) for table in tables),
        min(abs(table.positive_max_torque) for table in tables),
    )
    transmission = models[0].transmission
    ratio = transmission.joint_pulley_radius / transmission.motor_pulley_radius  # n_t, (9)
    span = ratio * (deflection[1] - deflection[0])
    positions = [recording.motor_position for recording in measurements]
    held = max(float(np.ptp(position)) for position in positions) < HELD * span
    frequency = max(table.frequency_state_3 for table in tables)
    return Limits(
        motor=_held_motor(positions[0], span, frequency) if held else _moved_motor(timed),
        load=_load(measurements, torque),
        deflection=deflection,
        step=step,
        duration=float(np.clip(recorded, SHORTEST, longest)),
        frequency=frequency / (2.0 * np.pi),
        motor_was_held=held,
        torque=torque,
    )


def _held_motor(position: Array, span: float, frequency: float) -> Reach:
    start = float(position[0])
    return Reach(
        start=start,
        low=start - 0.5 * span,
        high=start + 0.5 * span,
        rate=HELD_SPEED * frequency * span,
        recorded=(float(position.min()), float(position.max())),
    )


def _moved_motor(recordings: Sequence[Measurement]) -> Reach:
    low = min(float(recording.motor_position.min()) for recording in recordings)
    high = max(float(recording.motor_position.max()) for recording in recordings)
    wider = 0.5 * (BEYOND_RECORDED - 1.0) * (high - low)
    return Reach(
        start=float(recordings[0].motor_position[0]),
        low=low - wider,
        high=high + wider,
        rate=BEYOND_RECORDED
        * max(_fastest(recording.time, recording.motor_position) for recording in recordings),
        recorded=(low, high),
    )


def _load(recordings: Sequence[Measurement], torque: tuple[float, float]) -> Reach | None:
    """Reach of the load: from none on, within the torque at the largest deflection."""
    loaded = [
        (recording, recording.load_torque)
        for recording in recordings
        if recording.load_torque is not None and np.ptp(recording.load_torque) > 0.0
    ]
    if not loaded:
        return None
    low = min(float(load.min()) for _, load in loaded)
    high = max(float(load.max()) for _, load in loaded)
    # static curves show no rate; then it is chosen as for a machine that bears any load
    rates = [_fastest(recording.time, load) for recording, load in loaded if not recording.static]
    return Reach(
        start=0.0,
        low=max(BEYOND_RECORDED * min(low, 0.0), torque[0]),
        high=min(BEYOND_RECORDED * max(high, 0.0), torque[1]),
        rate=BEYOND_RECORDED * max(rates) if rates else (high - low) / LOADING_TIME,
        recorded=(low, high),
    )


def _fastest(time: Array, values: Array) -> float:
    """Largest rate of change over a short while, unit of the values per second."""
    later = np.searchsorted(time, time + SPEED_WINDOW)
    later = np.minimum(np.maximum(later, np.arange(len(time)) + 1), len(time) - 1)
    apart = time[later[:-1]] - time[:-1]
    return float(np.max(np.abs(values[later[:-1]] - values[:-1]) / apart))
