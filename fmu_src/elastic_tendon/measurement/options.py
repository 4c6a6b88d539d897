"""How a user asks recordings to be read: made once, and passed whole to what reads them."""

from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass, field
from math import isfinite
from os.path import isfile
from pathlib import Path
from typing import Literal, get_args

from elastic_tendon.errors import MeasurementError
from elastic_tendon.measurement.preparation import (
    DIMENSIONS,
    SHIFTED,
    Preparation,
    SignalColumn,
    check_preparation,
    parse_map,
    preparation_json,
)
from elastic_tendon.native.interpolation import AskedInterpolation


class ReadOptionError(MeasurementError):
    """An option with which no file could be read; `option` is its name, `fault` the sentence."""

    def __init__(self, option: str, fault: str) -> None:
        self.option = option
        self.fault = fault
        super().__init__(f"{option}: {fault}")


@dataclass(frozen=True)
class ReadOptions:
    """How recordings are read; it goes before what is written down beside a file.

    Parameters
    ----------
    mapping : items ``signal=column[:unit][*scale][+offset]``, and at most one name of a
        preparation (TOML) or comparison (JSON)
    time_shift : signal -> s by which its sensor is late, or "auto": estimated by comparison
    resample : s between the samples, coarser than recorded; None: as recorded
    remove_offset : signals whose mean over the first 0.1 s becomes 0
    interpolation : of motor position and load between the samples; "cubic" suits smooth inputs,
        "linear" and "hold" those that step or are coarsely rounded; "auto" chooses cubic or linear
        by their spectra
    joint_required : false where only the motor's motion and the load are wanted
    as_declared : take data as they are, even if they look read wrongly

    Raises
    ------
    ReadOptionError : a signal is not known or comes twice, or a number has no meaning
    """

    mapping: tuple[str, ...] = ()
    time_shift: Mapping[str, float | Literal["auto"]] = field(default_factory=dict)
    resample: float | None = None
    remove_offset: tuple[str, ...] = ()
    interpolation: AskedInterpolation = "auto"
    joint_required: bool = True
    as_declared: bool = False

    def __post_init__(self) -> None:
        self._check_mapping()
        for signal, shift in self.time_shift.items():
            _check_known("time_shift", signal, SHIFTED)
            if shift != "auto" and not isfinite(shift):
                raise ReadOptionError("time_shift", f"give {signal} a time in s, or auto")
        if self.resample is not None and not (isfinite(self.resample) and self.resample > 0.0):
            raise ReadOptionError("resample", "give a step in s, above 0")
        for signal in self.remove_offset:
            _check_known("remove_offset", signal, [name for name in DIMENSIONS if name != "time"])
        _check_known("interpolation", self.interpolation, get_args(AskedInterpolation))

    def _check_mapping(self) -> None:
        try:
            signals = [parse_map(item)[0] for item in self.items]
        except MeasurementError as error:
            raise ReadOptionError("mapping", str(error).removeprefix("--map ")) from None
        if len(set(signals)) < len(signals):
            raise ReadOptionError("mapping", "a signal is mapped twice")
        if len(self.files) > 1:
            both = f"two preparations, {self.files[0]} and {self.files[1]}"
            raise ReadOptionError("mapping", f"it names {both}; put both in one file")

    @property
    def items(self) -> tuple[str, ...]:
        """The part of `mapping` that names the columns of single signals."""
        return tuple(item for item in self.mapping if not _is_file(item))

    @property
    def files(self) -> tuple[Path, ...]:
        """The part of `mapping` that names a file which says how to read."""
        return tuple(Path(item) for item in self.mapping if _is_file(item))

    def over(self, preparation: Preparation, labels: Container[str] = ()) -> Preparation:
        """Lay these options over a preparation.

        Parameters
        ----------
        preparation : what is written down
        labels : columns of the file, see `parse_map`
        """
        columns = preparation.columns | dict(parse_map(item, labels) for item in self.items)
        for signal in self.remove_offset:
            column = columns.get(signal, SignalColumn())
            columns[signal] = column.model_copy(update={"remove_offset": "start"})
        tree = preparation_json(preparation)
        tree["columns"] = {name: preparation_json(column) for name, column in columns.items()}
        tree["time_shift"] = preparation.time_shift | dict(self.time_shift)
        if self.resample is not None:
            tree["resample"] = self.resample
        return check_preparation(tree, "the command line")


def _is_file(item: str) -> bool:
    return "=" not in item or isfile(item)


def _check_known(option: str, name: str, known: Sequence[str]) -> None:
    if name not in known:
        raise ReadOptionError(option, f"{name!r} is none of {', '.join(known)}")


DEFAULT = ReadOptions()
