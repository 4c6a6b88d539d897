"""How far and how fast the inputs of a further experiment may go.

What the machine bears is known from its springs, (16), and what its drive and its load can do
from the recordings. A further experiment may go a little beyond what was recorded, because what
was recorded did not decide. Of a machine that a torque drives the motion is limited, and what
torque it takes.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf, isfinite, pi

import numpy as np

from elastic_tendon.actuator.design import design
from elastic_tendon.actuator.interfaces import InterfaceKind
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.sections import Link
from elastic_tendon.comparison.initial_state import estimate_initial_state
from elastic_tendon.comparison.residuals import Array, simulate_measurement
from elastic_tendon.diagnosis.driving import drive_of
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

    @property
    def frequency(self) -> float:
        """Of a sine over all of it that is as fast as it may be, Hz."""
        return self.rate / (pi * max(self.high - self.low, LEAST_DEFLECTION))


@dataclass(frozen=True)
class Springs:
    """What the springs bear, whichever of the models is right; nothing limits where there are none.

    `deflection` : lowest and highest, rad. `torque` : lowest and highest load at rest, N·m.
    `frequency` : natural, with both tendons taut, Hz; infinite where the model has no link.
    """

    deflection: tuple[float, float] = (-inf, inf)
    torque: tuple[float, float] = (-inf, inf)
    frequency: float = inf


@dataclass(frozen=True)
class Limits:
    """What a further experiment may do.

    `kind` : which side of the actuator is given. `motion` : of the motor; without springs, of the
    joint. `joint_side` : the load torque; where the joint's position is given, its deflection;
    None where no load was recorded. `drive` : largest torque that moves the motor, or a link
    without springs, N·m; infinite where a position is given. `step` s between samples, `duration`
    s. `frequency` : up to which the joint follows, Hz. `motor_was_held` : its reach is not from the
    recordings but from the springs.
    """

    kind: InterfaceKind
    motion: Reach
    joint_side: Reach | None
    springs: Springs
    drive: float
    step: float
    duration: float
    frequency: float
    motor_was_held: bool

    def widened(self) -> "Limits":
        """What a machine might do that can move further and faster, and bear a load at all."""
        middle = 0.5 * (self.motion.low + self.motion.high)
        half = 0.5 * WIDER * (self.motion.high - self.motion.low)
        motion = replace(
            self.motion, low=middle - half, high=middle + half, rate=WIDER * self.motion.rate
        )
        low, high = self.springs.torque if self.kind.has_link else self.springs.deflection
        joint_side = Reach(0.0, low, high, rate=(high - low) / LOADING_TIME, recorded=(0.0, 0.0))
        return replace(
            self,
            motion=motion,
            joint_side=joint_side if self.kind.has_springs else None,
            drive=WIDER * self.drive,
        )

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

    Raises
    ------
    SimulationError : a position was not measured and cannot be simulated
    """
    first = models[0]
    kind = first.kind
    times = [recording.time for recording in measurements if not recording.static]
    step = min((float(np.median(np.diff(time))) for time in times), default=1.0 / RATE)
    recorded = max((float(time[-1] - time[0]) for time in times), default=SHORTEST)
    longest = max(LONGEST, MOST_SAMPLES * step)
    moved = "motor_position" if kind.has_springs else "joint_position"
    positions = [_position(first, recording, moved) for recording in measurements]
    springs = _springs(models) if kind.has_springs else Springs()
    joint_side = _joint_side(first, measurements, springs)
    motion = _reach(measurements, positions, start=float(positions[0][0]))
    frequency = springs.frequency
    if not isfinite(frequency):  # unknown without a link: a joint follows as fast as it did
        frequency = (joint_side or motion).frequency
    span = float(np.ptp(springs.deflection)) / first.transmission.motor_share
    held = kind.has_springs and float(max(map(np.ptp, positions))) < HELD * span
    if held:
        motion = _held_motor(positions[0], span, frequency)
    return Limits(
        kind=kind,
        motion=motion,
        joint_side=joint_side,
        springs=springs,
        drive=_drive(kind, measurements),
        step=step,
        duration=float(np.clip(recorded, SHORTEST, longest)),
        frequency=frequency,
        motor_was_held=held,
    )


def _springs(models: Sequence[Model]) -> Springs:
    linked = models[0].link.inertia > 0.0
    bare = {} if linked else {"link": Link(inertia=1.0)}  # of which only the springs are asked
    tables = [design(model.model_copy(update=bare)) for model in models]
    deflection = (
        MARGIN * min(max(table.negative_max_deflection for table in tables), -LEAST_DEFLECTION),
        MARGIN * max(min(table.positive_max_deflection for table in tables), LEAST_DEFLECTION),
    )
    # a load on the joint pushes it the way it acts: its torque is against that of the tendons
    torque = (
        max(-abs(table.negative_max_torque) for table in tables),
        min(abs(table.positive_max_torque) for table in tables),
    )
    frequency = max(table.frequency_state_3 for table in tables) / (2.0 * pi)
    return Springs(deflection, torque, frequency if linked else inf)


def _position(model: Model, recording: Measurement, name: str) -> Array:
    """Position of the motor or the joint, measured or else as the model expects it, (n,) rad."""
    measured = {**recording.inputs, **recording.signals}
    if name in measured:
        return measured[name]
    initial = estimate_initial_state(model, recording)
    return np.asarray(simulate_measurement(model, recording, initial)[name])


def _held_motor(position: Array, span: float, frequency: float) -> Reach:
    start = float(position[0])
    return Reach(
        start=start,
        low=start - 0.5 * span,
        high=start + 0.5 * span,
        rate=HELD_SPEED * 2.0 * pi * frequency * span,
        recorded=(float(position.min()), float(position.max())),
    )


def _reach(recordings: Sequence[Measurement], courses: Sequence[Array], start: float) -> Reach:
    """A little beyond what was recorded, in both directions; static curves show no rate."""
    low = min(float(course.min()) for course in courses)
    high = max(float(course.max()) for course in courses)
    wider = 0.5 * (BEYOND_RECORDED - 1.0) * (high - low)
    rates = [
        _fastest(recording.time, course)
        for recording, course in zip(recordings, courses, strict=True)
        if not recording.static
    ]
    return Reach(
        start=start,
        low=low - wider,
        high=high + wider,
        rate=BEYOND_RECORDED * max(rates, default=0.0),
        recorded=(low, high),
    )


def _joint_side(model: Model, recordings: Sequence[Measurement], springs: Springs) -> Reach | None:
    if not model.kind.has_springs:
        return None
    if model.kind.has_link:
        return _load(recordings, springs)
    return _turned(model, recordings, springs)


def _turned(model: Model, recordings: Sequence[Measurement], springs: Springs) -> Reach:
    """Reach of the deflection of a joint whose position is given."""
    share = model.transmission.motor_share
    reach = _reach(
        recordings,
        [
            recording.joint_position - share * _position(model, recording, "motor_position")
            for recording in recordings
        ],
        start=0.0,
    )
    low, high = springs.deflection
    return replace(
        reach,
        low=float(np.clip(reach.low, low, 0.0)),
        high=float(np.clip(reach.high, 0.0, high)),
    )


def _load(recordings: Sequence[Measurement], springs: Springs) -> Reach | None:
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
        low=max(BEYOND_RECORDED * min(low, 0.0), springs.torque[0]),
        high=min(BEYOND_RECORDED * max(high, 0.0), springs.torque[1]),
        rate=BEYOND_RECORDED * max(rates) if rates else (high - low) / LOADING_TIME,
        recorded=(low, high),
    )


def _drive(kind: InterfaceKind, recordings: Sequence[Measurement]) -> float:
    """Largest torque of the drive, a little beyond what was recorded, N·m; where it never drove,
    none is known."""
    drive = drive_of(kind)
    if drive is None:
        return inf
    courses = [recording.inputs.get(drive.torque, np.zeros(1)) for recording in recordings]
    return BEYOND_RECORDED * max(float(np.max(np.abs(course))) for course in courses) or inf


def _fastest(time: Array, values: Array) -> float:
    """Largest rate of change over a short while, unit of the values per second."""
    later = np.searchsorted(time, time + SPEED_WINDOW)
    later = np.minimum(np.maximum(later, np.arange(len(time)) + 1), len(time) - 1)
    apart = time[later[:-1]] - time[:-1]
    return float(np.max(np.abs(values[later[:-1]] - values[:-1]) / apart))
