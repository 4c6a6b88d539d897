"""Which column of a file is which signal, and how its unit becomes SI."""

import difflib
import re
import shlex
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from elastic_tendon.actuator.motion_kind import MotionKind
from elastic_tendon.errors import MeasurementError
from elastic_tendon.measurement.formats.base import Group, label
from elastic_tendon.measurement.preparation import DIMENSIONS, Preparation, SignalColumn
from elastic_tendon.measurement.units import EXAMPLES, LINEAR, USUAL, parse_unit, usual_name

STATIC = ("joint_deflection", "joint_torque")
RUN = "run"
# read by nobody: the motor position is differentiated instead
_UNUSED = "motor_velocity"
_MOST_NAMES = 12  # columns that a sentence names

_NAMED = re.compile(
    rf"(?P<measured>measured_)?(?P<signal>{'|'.join(DIMENSIONS)})"
    r"(?:_(?P<suffix>\S+)|\s*[\[(](?P<bracket>[^\[\]()]*)[\])])?"
)
_BRACKET = re.compile(r".*[\[(](?P<unit>[^\[\]()]*)[\])]\s*")
_SUFFIX = re.compile(r".*?_(?P<unit>[A-Za-z]+(?:_per_[A-Za-z]+)?)")
# what may be a unit in a name: "cmd_Nm" is more than one
_UNIT_SUFFIX = re.compile(r"[A-Za-z]+(?:_per_[A-Za-z]+)?")


@dataclass(frozen=True)
class Column:
    """A column of a file and its way to SI: ``signal = column * factor + offset``."""

    signal: str
    group: str
    name: str
    prepared: SignalColumn
    factor: float
    assumed: bool  # neither the preparation nor the name nor the file says the unit

    @property
    def motion(self) -> MotionKind | None:
        """Of a machine that has signals in such units; None where they do not say."""
        unit = None if self.assumed else parse_unit(self.prepared.unit or "")
        if unit is None or DIMENSIONS[self.signal] not in LINEAR:
            return None
        return MotionKind.LINEAR if unit.dimension in LINEAR.values() else MotionKind.ROTARY

    @property
    def label(self) -> str:
        """Name by which a preparation finds the column."""
        return label(self.group, self.name)

    def note(self) -> str | None:
        """What was done to the column, None where it is taken as it stands."""
        done = self.prepared
        measured = LINEAR if self.motion is MotionKind.LINEAR else {}
        dimension = DIMENSIONS[self.signal]
        usual = next(iter(USUAL[measured.get(dimension, dimension)]))
        steps = [f" in {done.unit}"] if done.unit != usual else []
        if self.assumed:
            steps = [f" in {done.unit}, assumed"]
        if done.sign * done.scale != 1.0:
            steps.append(f", times {done.sign * done.scale:g}")
        if done.offset != 0.0:
            steps.append(f", plus {done.offset:g}")
        if not steps and self.name in (f"{self.signal}_{usual}", f"measured_{self.signal}_{usual}"):
            return None
        return f"{self.signal} was read from {self.label}{''.join(steps)}"


@dataclass(frozen=True)
class Layout:
    """What is read of a file.

    Parameters
    ----------
    signals : one column for each signal but the time
    times : group -> its time; empty for a static curve
    runs : groups with a column ``run``
    notes : what is not used, and what is converted
    """

    signals: tuple[Column, ...]
    times: Mapping[str, Column]
    runs: frozenset[str]
    notes: tuple[str, ...]

    @property
    def motion(self) -> MotionKind | None:
        """Of the machine, as the units tell."""
        return next((column.motion for column in self.signals if column.motion), None)

    @property
    def static(self) -> bool:
        """Whether it is a static curve: deflection and torque without time."""
        return not self.times

    def of_group(self, group: str) -> tuple[Column, ...]:
        """Signals that one group holds."""
        return tuple(column for column in self.signals if column.group == group)


def find_layout(
    groups: Sequence[Group], preparation: Preparation, source: str, *, joint_required: bool = True
) -> Layout:
    """Decide which column of a file is which signal.

    A signal that the preparation names takes its column; any other is found by its own name with
    a unit, such as ``time_s``, ``joint_position_deg`` or ``joint_position [deg]``. A column that
    says it is measured, such as ``measured_joint_position_rad``, comes before one that does not.

    Parameters
    ----------
    groups : what the file holds
    preparation : Preparation
    source : str; name of the file for messages
    joint_required : false where only the motor's motion and the load are wanted

    Returns
    -------
    Layout

    Raises
    ------
    MeasurementError : a signal is missing or comes twice, or its unit is not known
    """
    search = _Search(groups, preparation, source)
    if search.is_static():
        columns = [search.column(signal, required=True) for signal in STATIC]
        times = {}
    else:
        read, unread = search.joint_signals()
        joint = search.joint_required(read) if joint_required else ()
        required = [*search.motor_signals(read), *joint]
        search.check_time()
        columns = [
            search.column(signal, required=signal in required)
            for signal in DIMENSIONS
            if signal not in ("time", unread)
        ]
        search.check_load(columns)
        used = {column.group for column in columns if column is not None}
        times = {group: search.time(group) for group in sorted(used)}
    signals = tuple(column for column in columns if column is not None and column.signal != _UNUSED)
    _check_distinct([*times.values(), *signals], source)
    _check_one_motion(signals, source)
    runs = frozenset(
        group.name
        for group in groups
        if RUN in group.columns and any(column.group == group.name for column in signals)
    )
    notes = _notes(groups, [*times.values(), *signals], runs)
    if times and joint_required and read not in {column.signal for column in signals}:
        notes += (f"there is no column {read}_rad: what moves the joint is seen by torques alone",)
    idle = preparation.columns.keys() - {
        "time",
        *(column.signal for column in columns if column is not None),
    }
    if idle:
        kind = "a time series" if times else "a static curve"
        notes += (f"said of columns and not used, as this is {kind}: {', '.join(sorted(idle))}",)
    return Layout(signals, times, runs, notes)


def signal_named(column: str) -> str | None:
    """Signal that a column says it is by its own name, None where it says none."""
    match = _NAMED.fullmatch(column.strip())
    return match["signal"] if match else None


class _Search:
    """Columns of a file by the signal that they say they are."""

    def __init__(self, groups: Sequence[Group], preparation: Preparation, source: str) -> None:
        self.groups = {group.name: group for group in groups}
        self.preparation = preparation
        self.source = source
        self.named: dict[tuple[str, bool], list[tuple[str, str, str | None]]] = {}
        for group in groups:
            for name in group.columns:
                if match := _NAMED.fullmatch(name.strip()):
                    key = match["signal"], match["measured"] is not None
                    place = (group.name, name, match["suffix"])
                    self.named.setdefault(key, []).append(place)

    def is_static(self) -> bool:
        """Whether there are a deflection and a torque, and neither time nor motor."""
        return all(map(self._mentioned, STATIC)) and not any(
            map(self._mentioned, ("time", "motor_position"))
        )

    def joint_signals(self) -> tuple[str, str]:
        """What says where the joint is, and what does not: its deflection only where that is all
        there is."""
        position, deflection = "joint_position", "joint_deflection"
        if self._mentioned(deflection) and not self._mentioned(position):
            return deflection, position
        return position, deflection

    def motor_signals(self, read: str) -> tuple[str, ...]:
        """What has to be there of the motor: nothing where a load drives the joint or a torque the
        motor, and the joint's own position is read."""
        driven = self._mentioned("load_torque") or self._mentioned("motor_torque")
        alone = driven and read == "joint_position" and self._mentioned(read)
        return () if alone else ("motor_position",)

    def joint_required(self, read: str) -> tuple[str, ...]:
        """What has to be there of the joint: nothing where the motor's position is read, a torque
        beside it shows what the joint does, and no column may be meant."""
        shown = self._mentioned("joint_torque") or self._mentioned("motor_torque")
        meant = self._mentioned(read) or self._near(read, f"{read}_rad") is not None
        return () if shown and self._mentioned("motor_position") and not meant else (read,)

    def check_time(self) -> None:
        """Refuse a file without time, and a static curve that has one."""
        if not self._mentioned("time"):
            raise self._missing("time")
        if all(map(self._mentioned, STATIC)) and not self._mentioned("motor_position"):
            raise MeasurementError(
                f"{self.source}: there are a deflection and a torque beside the time, but no "
                f"motor position; name it with {_advice('motor_position')}, or, where the motor "
                "was held, save the file without the time to have it read as a static curve"
            )

    def column(self, signal: str, *, required: bool) -> Column | None:
        """Find the column of a signal.

        Raises
        ------
        MeasurementError : it is required and missing, comes twice, or in no known unit
        """
        mapped = self.preparation.columns.get(signal)
        if mapped is not None and mapped.column is not None:
            columns = self._mapped(signal, mapped, mapped.column)
        elif signal == _UNUSED:
            return None
        else:
            columns = self._by_name(signal, self.groups, mapped, required=required)
        if len(columns) > 1:
            names = " and ".join(column.label for column in columns)
            raise MeasurementError(
                f"{self.source}: {signal} comes twice, as {names}; choose with {_advice(signal)}"
            )
        if not columns and (required or mapped is not None):
            raise self._missing(signal)
        return columns[0] if columns else None

    def time(self, group: str) -> Column:
        """Find the time of a group.

        Raises
        ------
        MeasurementError : it is missing, comes twice, or in no known unit
        """
        mapped = self.preparation.columns.get("time")
        columns = []
        if mapped is not None and mapped.column is not None:
            everywhere = self._mapped("time", mapped, mapped.column)
            columns = [column for column in everywhere if column.group == group]
            mapped = None  # what holds for that column need not hold for one of another name
        columns = columns or self._by_name("time", [group], mapped, required=True)
        if len(columns) == 1:
            return columns[0]
        if not columns and not group:
            raise self._missing("time")
        names = " and ".join(column.label for column in columns)
        fault = (
            f"time comes twice, as {names}" if columns else f"group {group} has no column time_s"
        )
        raise MeasurementError(f"{self.source}: {fault}; name the right one with {_advice('time')}")

    def _mentioned(self, signal: str) -> bool:
        mapped = self.preparation.columns.get(signal)
        named = (signal, False) in self.named or (signal, True) in self.named
        return named or (mapped is not None and mapped.column is not None)

    def _places(self, wanted: str) -> list[tuple[str, str]]:
        """Group and name of the columns that a label may mean."""
        exact = [(key, wanted) for key, group in self.groups.items() if wanted in group.columns]
        return exact or [
            (key, wanted.removeprefix(f"{key}/"))
            for key, group in self.groups.items()
            if wanted.startswith(f"{key}/") and wanted.removeprefix(f"{key}/") in group.columns
        ]

    def _mapped(self, signal: str, mapped: SignalColumn, wanted: str) -> list[Column]:
        places = self._places(wanted)
        if not places:
            raise self._missing(signal)
        return [self._column(signal, group, name, mapped) for group, name in places]

    def check_load(self, columns: Sequence[Column | None]) -> None:
        """Refuse a file that seems to have a load which is not found.

        Without it the model would be simulated without load, which nobody asked for.
        """
        if any(column is not None and column.signal == "load_torque" for column in columns):
            return
        used = {(column.group, column.name) for column in columns if column is not None}
        for group in self.groups.values():
            for name in group.columns:
                letters = re.sub(r"[^a-z]", "", name.lower())
                if "loadtorque" in letters and (group.name, name) not in used:
                    raise MeasurementError(
                        f"{self.source}: column {label(group.name, name)} seems to be the load "
                        "torque, without which the model would be simulated without load; name it "
                        f"with {self._advice_for('load_torque', group, name)}, or rename it in the "
                        "file if it is something else"
                    )

    def _by_name(
        self, signal: str, groups: Iterable[str], mapped: SignalColumn | None, *, required: bool
    ) -> list[Column]:
        """Columns called by the signal, those that say they are measured first.

        Behind the name of a signal that need not be there, what is no unit of it makes another
        quantity, such as motor_torque_in, which is no inch.
        """
        dimension = None if required else DIMENSIONS[signal]
        fault: MeasurementError | None = None
        for measured in (True, False):
            columns = []
            for group, name, suffix in self.named.get((signal, measured), ()):
                if group not in groups or (suffix and not _is_unit(suffix, dimension)):
                    continue  # such as joint_position_filtered: another quantity
                try:
                    columns.append(self._column(signal, group, name, mapped or SignalColumn()))
                except MeasurementError as error:
                    fault = fault or error
            if columns:
                return columns
        if fault is not None:
            raise fault
        return []

    def _column(self, signal: str, group: str, name: str, prepared: SignalColumn) -> Column:
        """Settle the unit: the preparation's, else the name's, else the file's.

        Raises
        ------
        MeasurementError : name and file contradict each other, or the unit does not fit
        """
        own = self._unit_in(self.groups[group], name, signal)
        declared = self.groups[group].units.get(name, "").strip()
        called = label(group, name)
        unit = prepared.unit or own or declared
        if not prepared.unit and own and declared:
            said, written = parse_unit(declared), parse_unit(own)
            if said is not None and said.dimension and said != written:
                raise MeasurementError(
                    f"{self.source}: column {called} is in {own} by its name and in {declared} by "
                    f"the file; say which with {_advice(signal, called, usual_name(declared))}"
                )
        if not unit and prepared.column is None:
            example = EXAMPLES[DIMENSIONS[signal]].split(" ")[-1]
            raise MeasurementError(
                f"{self.source}: column {called} does not say in which unit it is; say it with "
                f"{_advice(signal, called, example)} or the like"
            )
        assumed = not unit
        unit = usual_name(unit) if unit else next(iter(USUAL[DIMENSIONS[signal]]))
        factor = _factor(unit, signal, called, self.source)
        resolved = prepared.model_copy(update={"column": called, "unit": unit})
        factor *= prepared.sign * prepared.scale
        return Column(signal, group, name, resolved, factor, assumed)

    def _missing(self, signal: str) -> MeasurementError:
        mapped = self.preparation.columns.get(signal)
        wanted = mapped.column if mapped is not None else None
        wanted = wanted or f"{signal}_{next(iter(USUAL[DIMENSIONS[signal]]))}"
        labels = [
            label(group.name, name) for group in self.groups.values() for name in group.columns
        ]
        advice = self._near(signal, wanted) or _advice(signal)
        shown = ", ".join(labels[:_MOST_NAMES]) + (", ..." if len(labels) > _MOST_NAMES else "")
        return MeasurementError(
            f"{self.source}: there is no column {wanted} (found: {shown}); name the right one "
            f"with {advice}"
        )

    def _near(self, signal: str, wanted: str) -> str | None:
        """Advice with the column most likely meant, never one named as another signal."""
        free: dict[str, tuple[Group, str]] = {}
        for group in self.groups.values():
            for name in group.columns:
                own = _NAMED.fullmatch(name.strip().lower())
                if own is not None and own["signal"] == signal and name not in (wanted, signal):
                    return self._advice_for(signal, group, name)
                if own is None:
                    free[label(group.name, name).lower()] = group, name
        near = difflib.get_close_matches(wanted.lower(), list(free), n=1, cutoff=0.8)
        return self._advice_for(signal, *free[near[0]]) if near else None

    def _advice_for(self, signal: str, group: Group, name: str) -> str:
        """How to say that a column is the signal, with a unit where it would not be found."""
        said = parse_unit(self._unit_in(group, name, signal) or group.units.get(name, ""))
        dimension = DIMENSIONS[signal]
        known = said is not None and said.dimension in (dimension, LINEAR.get(dimension))
        words = re.split(r"[\W_]+", name)
        usual = [word for word in map(usual_name, words) if word in USUAL[DIMENSIONS[signal]]]
        unit = "" if known else next(iter(usual), "UNIT")
        return _advice(signal, label(group.name, name), unit)

    def _unit_in(self, group: Group, name: str, signal: str) -> str | None:
        """Unit that a column's name carries.

        A signal's own name may carry any unit; behind another name only the usual ones are taken
        for units, as ``enc_deg``, and in capitals only where they are no other's: ``T_MS`` is
        refused as not known.
        """
        if match := _BRACKET.fullmatch(name):
            text = match["unit"].strip()
            # data[1] is a place
            return None if not text or text.isdecimal() or not group.bracketed_units else text
        own = _NAMED.fullmatch(name)
        if own is not None and own["suffix"] and _is_unit(own["suffix"]):
            return own["suffix"]
        match = _SUFFIX.fullmatch(name)
        dimension = DIMENSIONS[signal]
        sliding = USUAL[LINEAR[dimension]] if dimension in LINEAR else {}
        linear = [unit for unit in sliding if len(unit) > 1]  # one letter may mean anything
        usual = {unit.lower() for unit in (*USUAL[dimension], *linear)}
        return match["unit"] if match and usual_name(match["unit"]).lower() in usual else None


def _advice(signal: str, column: str = "COLUMN", unit: str = "") -> str:
    """The option that names a signal's column, quoted where a shell needs it."""
    item = f"{column}:{unit}" if unit else column
    if not re.fullmatch(r"[\w./:+-]+", item):
        # double quotes also serve where there are no single ones
        item = shlex.quote(item) if re.search(r'["$`\\!]', item) else f'"{item}"'
    return f"--map {signal}={item}"


def _check_distinct(columns: Sequence[Column], source: str) -> None:
    """Refuse a column that is read as two signals."""
    signals: dict[tuple[str, str], str] = {}
    for column in columns:
        first = signals.setdefault((column.group, column.name), column.signal)
        if first != column.signal:
            raise MeasurementError(
                f"{source}: column {column.label} is read as {first} and as {column.signal}; map "
                "each signal to a column of its own"
            )


def _check_one_motion(columns: Sequence[Column], source: str) -> None:
    """Refuse columns of which some are of a machine that turns and some of one that slides."""
    first = next((column for column in columns if column.motion), None)
    for column in columns:
        if first is not None and column.motion not in (None, first.motion):
            raise MeasurementError(
                f"{source}: column {first.label} is in {first.prepared.unit}, as of a "
                f"{first.motion} machine, and {column.label} in {column.prepared.unit}, as of a "
                f"{column.motion} one; give both in units of one kind, such as rad and Nm or m and "
                f"N, with {_advice(column.signal, column.label, 'UNIT')}"
            )


def _is_unit(suffix: str, dimension: str | None = None) -> bool:
    """Whether it is a unit, of this dimension where one is given."""
    if _UNIT_SUFFIX.fullmatch(suffix) is None or (unit := parse_unit(suffix)) is None:
        return False
    return dimension in (None, unit.dimension) or LINEAR.get(dimension or "") == unit.dimension


def _factor(unit: str, signal: str, called: str, source: str) -> float:
    dimension = DIMENSIONS[signal]
    parsed = parse_unit(unit)
    if parsed is not None and parsed.dimension in (dimension, LINEAR.get(dimension)):
        return parsed.factor
    known = "which is not known" if parsed is None else f"which is no unit of {dimension}"
    raise MeasurementError(
        f"{source}: column {called} is given in {unit!r}, {known}; {signal} needs a unit of "
        f"{dimension} such as {EXAMPLES[dimension]}, say it with {_advice(signal, called, 'UNIT')}"
    )


def _notes(
    groups: Sequence[Group], columns: Sequence[Column], runs: frozenset[str]
) -> tuple[str, ...]:
    used = {(column.group, column.name) for column in columns}
    used |= {(group, RUN) for group in runs}
    extra = [
        label(group.name, name)
        for group in groups
        for name in group.columns
        if (group.name, name) not in used
    ]
    notes = [note for column in columns if (note := column.note()) is not None]
    if extra:
        shown = ", ".join(extra[:_MOST_NAMES])
        more = len(extra) - _MOST_NAMES
        notes.append(f"not used: {shown}{f' and {more} more' if more > 0 else ''}")
    if any(name.split("/")[-1].startswith(_UNUSED) for name in extra):
        notes.append("motor_velocity is not used: the motor position is differentiated instead")
    return tuple(notes)
