"""What a joint, its springs and its load can be, where no simulation could tell."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from math import copysign, log, pi

import numpy as np

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.transmission import characteristic_torque
from elastic_tendon.measurement import Measurement
from elastic_tendon.measurement.recording import Array
from elastic_tendon.misreadings.readings import (
    GAIN,
    TIMES,
    UNITS,
    WELL_IF_STRANGE,
    WORDS,
    Reading,
    declared_factor,
    gear_reading,
    gear_slope,
    positions_of,
    unit_readings,
)

MOST_TURNS = 2.0  # of a joint that tendons move
# by how much largest deflection and load of the springs (16) are passed at most: they are often
# assumed, and overstretched springs go on
FAR_DEFLECTION, FAR_LOAD = 4.0, 20.0
MOST_SPEED = 500.0  # rad/s, 80 turns a second
# a recording of a moving joint this long in steps this long is rare, unless the model explains it
LONG_STEP, LONG_DURATION = 0.5, 900.0  # s
SPEED_STRETCHES = 200  # over which a speed is a mean, so that no noise makes one
# by how much the stiffness of a static curve may be off; the closest misreading counts then
FAR_STIFFNESS = 20.0
CLOSE_STIFFNESS = 4.0
JUMPY = 1.0  # ratio of von Neumann above which rows are in no order
STRAIGHT = 0.7  # least correlation of torque and deflection of a static curve


def implausible(model: Model, measurement: Measurement, *, explained: bool) -> tuple[str, ...]:
    """What hardly any actuator of this model does.

    Parameters
    ----------
    model : Model
    measurement : Measurement; SI units
    explained : whether the model explains the joint's motion as declared

    Returns
    -------
    tuple of at most one sentence
    """
    # without springs a wheel may turn as far and as fast as it likes
    rules = (_travel, _deflection, _load, _speed) if model.kind.has_springs else ()
    doubts = (
        *(rule(model, measurement) for rule in rules),
        "" if explained or measurement.static else _duration(measurement),
    )
    # columns in a wrong unit break several rules; the first is the plainest
    return tuple(f"{measurement.name}: {fault}" for fault in doubts if fault)[:1]


def _travel(model: Model, measurement: Measurement) -> str:
    turns = float(np.ptp(measurement.signals["joint_position"])) / (2.0 * pi)
    if turns <= MOST_TURNS:
        return ""
    return (
        f"the joint position travels {turns:.3g} turns; {_angle_advice(turns, model, measurement)}"
    )


def _deflection(model: Model, measurement: Measurement) -> str:
    joint = measurement.signals["joint_position"]
    travel = float(np.ptp(joint - model.transmission.motor_share * measurement.motor_position))
    times = travel / _largest_travel(model)
    if times <= FAR_DEFLECTION:
        return ""
    return (
        f"the deflection between motor and joint spans {travel:.3g} rad, {times:.3g} times what "
        f"the springs bear; {_angle_advice(times, model, measurement)}"
    )


def _largest_travel(model: Model) -> float:
    """Deflection that the springs bear from one end to the other, rad."""
    radii = model.transmission
    springs = radii.upper_spring.max_deflection + radii.lower_spring.max_deflection
    return springs / radii.joint_pulley_radius


def _angle_advice(times: float, model: Model, measurement: Measurement) -> str:
    """Advice on unit and gear of the positions, which span `times` what is usual."""
    positions = ("joint_deflection",) if measurement.static else positions_of(measurement)
    # what is far off even in degrees is in the smaller unit
    unit = "deg" if times <= FAR_DEFLECTION / UNITS["joint_position"]["deg"] else "mrad"
    advice = f"if it is in {WORDS[unit]} {_read_in(unit, positions, measurement)}"
    of_joint = measurement.motor_share is None and not measurement.static
    slope = gear_slope(model, measurement) if of_joint else None
    if slope is None:
        return advice
    gear = gear_reading(float(f"{max(abs(slope), 1.0 / abs(slope)):.2g}"), slope)
    return f"{advice}; or {gear.what}: then {gear.cure(measurement.preparation)}"


def _read_in(unit: str, signals: Sequence[str], measurement: Measurement) -> str:
    """Advice to read columns in a unit."""
    for reading in unit_readings(measurement, signals):
        if reading.unit == unit:
            return reading.cure(measurement.preparation)
    return "give another unit with --map"


def _load(model: Model, measurement: Measurement) -> str:
    if measurement.load_torque is None:
        return ""
    radii = model.transmission
    largest = radii.joint_pulley_radius * max(
        spring.largest_force for spring in (radii.upper_spring, radii.lower_spring)
    )
    load = float(np.max(np.abs(measurement.load_torque)))
    if load <= FAR_LOAD * largest:
        return ""
    signals = ("joint_torque",) if measurement.static else ("load_torque",)
    advice = ", ".join(
        f"if it is in {WORDS[unit]} {_read_in(unit, signals, measurement)}"
        for unit in ("mNm", "Ncm")
    )
    return (
        f"the load torque reaches {load:.3g} N·m, {load / largest:.3g} times what the springs "
        f"bear; {advice}"
    )


def _speed(_model: Model, measurement: Measurement) -> str:
    stride = max(len(measurement.time) // SPEED_STRETCHES, 1)
    steps = np.diff(measurement.time[::stride])
    travels = np.abs(np.diff(measurement.signals["joint_position"][::stride]))
    speed = float(np.quantile(travels / steps, 0.95))
    if speed <= MOST_SPEED:
        return ""
    return (
        f"the joint moves at {speed:.3g} rad/s; if the time is in seconds "
        f"{_read_in('s', ('time',), measurement)}"
    )


def _duration(measurement: Measurement) -> str:
    duration = float(measurement.time[-1] - measurement.time[0])
    step = float(np.median(np.diff(measurement.time)))
    if duration <= LONG_DURATION or step < LONG_STEP:
        return ""
    shorter = ("ms", "us", "ns")
    unit = next((name for name in shorter if step * TIMES[name] < LONG_STEP), shorter[-1])
    return (
        f"the recording lasts {duration / 60.0:.3g} minutes in steps of {step:.3g} s, and the "
        f"model does not explain it; if the time is in {WORDS[unit]} "
        + _read_in(unit, ("time",), measurement)
    )


# ---- static curves --------------------------------------------------------------------------


def static_suspicion(model: Model, measurement: Measurement) -> tuple[str, ...]:
    """Judge the stiffness of a static curve against the model's.

    Parameters
    ----------
    model : Model
    measurement : Measurement; a static curve: motor held, load against the torque on the joint

    Returns
    -------
    tuple of at most one sentence: order of the rows, columns, sign or unit look wrong
    """
    deflection, load = measurement.signals["joint_position"], measurement.load_torque
    if load is None or np.ptp(deflection) == 0.0 or np.ptp(load) == 0.0:
        return ()
    if min(_jumpiness(deflection), _jumpiness(load)) > JUMPY:
        return (
            f"{measurement.name}: the rows of the static curve jump to and fro; as they are taken "
            "in the order in which they were measured, sort them by the deflection or bring them "
            "into that order",
        )
    correlation = float(np.corrcoef(deflection, load)[0, 1])
    if abs(correlation) < STRAIGHT:
        return ()
    radii = model.transmission
    springs = radii.upper_spring.combined_stiffness + radii.lower_spring.combined_stiffness
    expected = radii.joint_pulley_radius**2 * springs
    stiffness = float(np.std(load) / np.std(deflection))
    swapped = _static_swapped(model, measurement, stiffness / expected)
    if swapped:
        return (f"{measurement.name}: {swapped}",)
    readings = _static_readings(measurement, stiffness / expected)
    if correlation < 0.0:
        readings = _with_opposite_torque(readings)
    if not readings:
        return ()
    cures = " ".join(reading.options(measurement.preparation) for reading in readings)
    explanations = " and ".join(reading.what for reading in readings)
    return (
        f"{measurement.name}: {explanations}: against the deflection "
        f"the joint torque falls by {copysign(stiffness, correlation):.3g} N·m/rad, the model's by "
        f"{expected:.3g} N·m/rad; read it with {cures}",
    )


def _jumpiness(values: Array) -> float:
    """Mean square of the steps over the variance, von Neumann's ratio: 2 where rows are shuffled.

    Eight rows for each cycle of a sweep have 0.6, more rows less.
    """
    return float(np.mean(np.diff(values) ** 2) / np.var(values))


def _static_swapped(model: Model, measurement: Measurement, stiffness_ratio: float) -> str:
    """Whether torque and deflection are in each other's place, by the model's own curve."""
    columns = ("joint_deflection", "joint_torque")
    si = all(declared_factor(measurement.preparation, column) == 1.0 for column in columns)
    deflection, load = measurement.signals["joint_position"], measurement.load_torque
    if not si or load is None or 1.0 / CLOSE_STIFFNESS <= stiffness_ratio <= CLOSE_STIFFNESS:
        return ""

    def unexplained(bent: Array, torque: Array) -> float:
        error = torque - characteristic_torque(bent, model.transmission)
        return float(np.std(error) / np.std(torque))

    declared, swapped = unexplained(deflection, -load), unexplained(-load, deflection)
    if swapped > WELL_IF_STRANGE or declared < GAIN * swapped:
        return ""
    if float(np.ptp(load)) > FAR_DEFLECTION * _largest_travel(model):
        return ""
    reading = Reading("deflection and torque look as if they were swapped", {}, swapped=columns)
    return (
        f"{reading.what}: as declared the model's torque errs by {declared:.3g} times its spread, "
        f"read so by {swapped:.3g} times; {reading.cure(measurement.preparation)}"
    )


def _static_readings(measurement: Measurement, stiffness_ratio: float) -> list[Reading]:
    """The fewest wrong units that bring the stiffness near the model's; none where it is near."""
    if 1.0 / FAR_STIFFNESS <= stiffness_ratio <= FAR_STIFFNESS:
        return []
    columns = ("joint_deflection", "joint_torque")
    choices = [(None, *unit_readings(measurement, (column,))) for column in columns]

    def distance(pair: tuple[Reading | None, ...]) -> float:
        bent, pulled = (
            1.0 if reading is None else reading.factors[column]
            for reading, column in zip(pair, columns, strict=True)
        )
        return abs(log(stiffness_ratio * pulled / bent))

    close = [pair for pair in product(*choices) if distance(pair) <= log(CLOSE_STIFFNESS)]
    close.sort(key=lambda pair: (sum(reading is not None for reading in pair), distance(pair)))
    return [reading for reading in close[0] if reading is not None] if close else []


def _with_opposite_torque(readings: list[Reading]) -> list[Reading]:
    """The readings, the torque's sign turned."""
    opposite = "the joint torque has the opposite sign"
    kept = [reading for reading in readings if "joint_torque" not in reading.factors]
    turned = [
        replace(reading, what=f"{reading.what}, and {opposite}", factors={"joint_torque": -factor})
        for reading in readings
        if (factor := reading.factors.get("joint_torque"))
    ]
    return kept + (turned or [Reading(opposite, {"joint_torque": -1.0})])
