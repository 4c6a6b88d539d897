"""The ways in which recordings are usually misread, and what would put each of them right."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import copysign, isclose, pi

import numpy as np

from elastic_tendon.actuator.motion_kind import MotionKind
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.measurement import Measurement
from elastic_tendon.measurement.preparation import Preparation, SignalColumn
from elastic_tendon.measurement.recording import Array
from elastic_tendon.measurement.units import parse_unit

# by how much less a reading must leave unexplained than what is declared
GAIN = 3.0
# share of the joint's spread that a reading may leave unexplained; a gear's ratio is fitted, and
# whatever moves with the motor a little would be called a gear; a joint that is held would be
# called a deflection
WELL, WELL_IF_STRANGE = 0.5, 0.2
# a recording that is taken for a thousand times too slow has the joint at rest on the motor, and
# where the load is small that explains it rather well; so less is asked, but only of steps that
# no sampling in ms would have as seconds
TIME_GAIN, LONG_STEP = 1.5, 0.1  # 1, s

# what a column may be in, as people write it, and that in SI
ANGLES = {"deg": pi / 180.0, "mrad": 1e-3, "rad": 1.0}
TORQUES = {"mNm": 1e-3, "Ncm": 1e-2, "Nm": 1.0}
LENGTHS = {"mm": 1e-3, "m": 1.0}  # the same of a machine that slides
FORCES = {"mN": 1e-3, "N": 1.0, "kN": 1e3}
TIMES = {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1.0}
UNITS: Mapping[str, Mapping[str, float]] = {
    "motor_position": ANGLES,
    "joint_position": ANGLES,
    "joint_deflection": ANGLES,
    "load_torque": TORQUES,
    "joint_torque": TORQUES,
    "motor_torque": TORQUES,
    "time": TIMES,
}
# units of what a static curve's columns are where they are swapped
SI = {"joint_deflection": "rad", "joint_torque": "Nm"}
WORDS = {
    "deg": "degrees",
    "mrad": "mrad",
    "rad": "radians",
    "mNm": "mN·m",
    "Ncm": "N·cm",
    "Nm": "N·m",
    "mm": "millimetres",
    "m": "metres",
    "mN": "mN",
    "N": "N",
    "kN": "kN",
    "ns": "nanoseconds",
    "us": "microseconds",
    "ms": "milliseconds",
    "s": "seconds",
}
POSITIONS = ("joint_position", "motor_position")
LEAST_GEAR = 1.5  # pulleys that differ less from the model's are no gear


@dataclass(frozen=True)
class Reading:
    """Another way to read a recording.

    `what` says in a clause what looks wrong; `factors` (signal -> factor), `swapped` (two
    signals) and `motor_share` (of the motor position, which the joint position lacks) make
    the recording that it would be; `unit` is what the columns are in then, None: as declared. It
    is suspected where it leaves `gain` times less unexplained, and no more than `well` of the
    joint's spread.
    """

    what: str
    factors: Mapping[str, float]
    unit: str | None = None
    swapped: tuple[str, ...] = ()
    motor_share: float = 0.0
    gain: float = GAIN
    well: float = WELL

    def apply(self, measurement: Measurement) -> Measurement:
        """The recording, read like this."""

        def factor(signal: str) -> float:
            return self.factors.get(signal, 1.0)

        load, signals = measurement.load_torque, dict(measurement.signals)
        motor, joint = measurement.motor_position, signals["joint_position"]
        if self.swapped:
            motor, joint = joint, motor
        signals |= {name: factor(name) * values for name, values in signals.items()}
        read_motor = factor("motor_position") * motor
        share = measurement.motor_share
        if share is None:
            joint = factor("joint_position") * joint + self.motor_share * motor
        else:
            joint = factor("joint_deflection") * (joint - share * motor) + share * read_motor
        signals["joint_position"] = joint
        return replace(
            measurement,
            time=factor("time") * measurement.time,
            motor_position=read_motor,
            load_torque=None if load is None else factor("load_torque") * load,
            signals=signals,
        )

    def cure(self, preparation: Preparation) -> str:
        """What to do to read it so, given how it was read."""
        if self.motor_share:
            share = f"{self.motor_share:.4g} times " if self.motor_share != 1.0 else ""
            return f"add {share}the motor position to that column in the file"
        return f"read it with {self.options(preparation)}"

    def options(self, preparation: Preparation) -> str:
        """Options of the command line that read it so, given how it was read."""
        if self.swapped:
            columns = [preparation.columns.get(column, SignalColumn()) for column in self.swapped]
            units = [SI.get(column) for column in self.swapped]
            items = [
                _item(signal, column, 1.0, unit)
                for signal, column, unit in zip(self.swapped, columns[::-1], units, strict=True)
            ]
        else:
            items = [
                _item(signal, preparation.columns.get(signal, SignalColumn()), factor, self.unit)
                for signal, factor in self.factors.items()
            ]
        return " ".join(f"--map {item}" for item in items)


def _item(signal: str, column: SignalColumn, factor: float, unit: str | None) -> str:
    """``signal=column[:unit][*scale][+offset]`` by which what was read is read times a factor."""
    scale = column.sign * column.scale * (factor if unit is None else copysign(1.0, factor))
    unit = column.unit if unit is None else unit
    offset = factor * column.offset
    return (
        f"{signal}={column.column or 'COLUMN'}"
        + (f":{unit}" if unit else "")
        + (f"*{scale:g}" if scale != 1.0 else "")
        + (f"{offset:+g}" if offset else "")
    )


def readings_of(measurement: Measurement) -> tuple[Reading, ...]:
    """Readings of positions, load and time to try, the plainest first."""
    loads = () if measurement.load_torque is None else ("load_torque",)
    positions = positions_of(measurement)
    signs = [
        Reading(f"the {name(signal)} looks as if it had the opposite sign", {signal: -1.0})
        for signal in (*positions, *loads)
    ]
    swapped = "motor and joint position look as if they were swapped"
    return (
        *([Reading(swapped, {}, swapped=POSITIONS)] if positions == POSITIONS else []),
        *signs,
        *(reading for signal in positions for reading in unit_readings(measurement, (signal,))),
        *(unit_readings(measurement, positions) if len(positions) > 1 else []),
        *(reading for load in loads for reading in unit_readings(measurement, (load,))),
        *time_readings(measurement),
    )


def positions_of(measurement: Measurement) -> tuple[str, ...]:
    """What was measured of the joint, its position or deflection, and the motor's position, where
    there is one."""
    if not measurement.kind.has_springs:
        return ("joint_position",)
    return POSITIONS if measurement.motor_share is None else ("joint_deflection", "motor_position")


def measured_of(measurement: Measurement, joint: Array) -> Array:
    """What a sensor like the recording's shows of a joint position, (n,) rad: that, or its
    deflection."""
    share = measurement.motor_share
    return joint if share is None else joint - share * measurement.motor_position


def torque_readings(measurement: Measurement, signal: str) -> tuple[Reading, ...]:
    """Readings to try of a torque that was measured beside the joint position."""
    units = unit_readings(measurement, (signal,))
    opposite = f"the {name(signal)} looks as if it had the opposite sign"
    return (
        Reading(opposite, {signal: -1.0}),
        *units,
        *(
            replace(
                reading,
                what=f"{reading.what} and had the opposite sign",
                factors={signal: -reading.factors[signal]},
            )
            for reading in units
        ),
    )


def name(signal: str) -> str:
    """A signal in words."""
    return signal.replace("_", " ")


def unit_readings(measurement: Measurement, signals: Sequence[str]) -> list[Reading]:
    """Readings in which some columns of one dimension are in another unit than declared.

    Parameters
    ----------
    measurement : Measurement
    signals : names of signals that are in that unit together

    Returns
    -------
    list of Reading; empty where the declared units differ or are none of `UNITS`
    """
    units = _units(measurement, signals[0])
    declared = {signal: _declared(measurement.preparation, signal, units) for signal in signals}
    factors = {signal: factor for signal, factor in declared.items() if factor is not None}
    if len(set(factors.values())) != 1 or len(factors) < len(signals):
        return []
    (factor,) = set(factors.values())
    subject = " and ".join(name(signal) for signal in signals)
    verb = "looks as if it were" if len(signals) == 1 else "look as if they were"
    now = next(WORDS[unit] for unit, value in units.items() if value == factor)
    return [
        Reading(
            f"the {subject} {verb} in {WORDS[unit]}, not in {now} as declared",
            dict.fromkeys(signals, value / factor),
            unit,
        )
        for unit, value in units.items()
        if value != factor
    ]


def time_readings(measurement: Measurement) -> tuple[Reading, ...]:
    """Readings in which the time is in another unit than declared."""
    step = float(np.median(np.diff(measurement.time)))
    return tuple(
        replace(reading, gain=TIME_GAIN)
        for reading in unit_readings(measurement, ("time",))
        if reading.factors["time"] > 1.0 or step >= LONG_STEP
    )


def _units(measurement: Measurement, signal: str) -> Mapping[str, float]:
    """What a column may be in, at a machine that turns or slides as this one."""
    of_rotary = UNITS[signal]
    if measurement.motion is not MotionKind.LINEAR or of_rotary is TIMES:
        return of_rotary
    return LENGTHS if of_rotary is ANGLES else FORCES


def declared_factor(preparation: Preparation, signal: str) -> float | None:
    """What a signal's unit is in SI, as it was read: 1 where nothing is said; None: unusual."""
    return _declared(preparation, signal, UNITS[signal])


def _declared(preparation: Preparation, signal: str, units: Mapping[str, float]) -> float | None:
    unit = preparation.columns.get(signal, SignalColumn()).unit
    parsed = None if unit is None else parse_unit(unit)
    factor = 1.0 if parsed is None else parsed.factor
    return next((known for known in units.values() if isclose(known, factor)), None)


def deflection_reading(model: Model) -> Reading:
    """The reading in which the joint position was recorded as seen from the motor."""
    return Reading(
        "the joint position looks as if it were the deflection, joint less motor",
        {},
        motor_share=model.transmission.motor_share,
        well=WELL_IF_STRANGE,
    )


def gear_slope(model: Model, measurement: Measurement) -> float | None:
    """How far the joint turns for what the pulleys make of the motor's motion.

    Parameters
    ----------
    model : Model
    measurement : Measurement

    Returns
    -------
    float, least squares beside the load; None where that is no gear, or nothing moves
    """
    reflected = measurement.motor_position * model.transmission.motor_share
    if np.ptp(reflected) == 0.0:
        return None
    load = measurement.load_torque
    columns = [reflected, np.ones_like(reflected), *([] if load is None else [load])]
    joint = measurement.signals["joint_position"]
    slope = float(np.linalg.lstsq(np.column_stack(columns), joint)[0][0])
    return slope if is_gear(slope) else None


def is_gear(slope: float) -> bool:
    """Whether a joint that turns so far for what the pulleys make of the motor has a gear."""
    return slope != 0.0 and max(abs(slope), 1.0 / abs(slope)) >= LEAST_GEAR


def gear_reading(ratio: float, slope: float) -> Reading:
    """The reading in which a gear between motor and joint was not taken into account.

    Parameters
    ----------
    ratio : at least 1
    slope : see `gear_slope`; says the sign, and that what moves farther counts before the gear
    """
    signal = "joint_position" if abs(slope) > 1.0 else "motor_position"
    return Reading(
        f"the {name(signal)} looks as if a gear ratio of {ratio:g} was not taken into account"
        + (" and its sign were opposite" if slope < 0.0 else ""),
        {signal: copysign(1.0 / ratio, slope)},
        well=WELL_IF_STRANGE,
    )
