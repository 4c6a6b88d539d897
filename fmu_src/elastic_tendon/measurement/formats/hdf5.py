"""HDF5, and MAT since version 7.3, which is HDF5 with MATLAB's conventions."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from elastic_tendon.errors import MeasurementError
from elastic_tendon.measurement.formats.arrays import grouped, series
from elastic_tendon.measurement.formats.base import (
    Chunk,
    FileSource,
    Group,
    as_numbers,
    check_columns,
    refusing_damage,
    row_ranges,
)
from elastic_tendon.progress import Progress

_KIND = "HDF5 file"
# where MATLAB keeps cells, objects and its own bookkeeping
_MATLAB_OWN = ("#refs#", "#subsystem#")


@dataclass(frozen=True)
class _Column:
    """Where in the file a column lies: a data set, and what of it."""

    dataset: str
    lies_across: bool  # its samples run along the second axis
    part: int | str | None  # column of a matrix, field of a table, None: all of a vector


def open_file(path: Path) -> "Hdf5Source":
    """Open a HDF5 file, or a MAT file of version 7.3.

    Arrays of one length in one group are columns of a `Group`; a matrix has its samples along the
    longer axis and one column for each of the other; a table of named fields is a group of its
    own. Attributes ``unit`` or ``units`` are read, and those by which NetCDF packs numbers. Single
    values are left out.

    Raises
    ------
    MeasurementError : the file is damaged or holds no usable array
    """
    lengths: dict[str, dict[str, int]] = {}
    places: dict[str, dict[str, _Column]] = {}
    units: dict[str, dict[str, str]] = {}
    objects: dict[str, str] = {}

    def visit(name: str, item: object) -> None:
        if not isinstance(item, h5py.Dataset) or name.startswith(_MATLAB_OWN):
            return
        if "MATLAB_object_decode" in item.attrs:
            objects[name] = _text(item.attrs.get("MATLAB_class")) or "object"
            return
        folder, _, last = name.rpartition("/")
        if item.dtype.names:
            folder, last = name, ""
        for column, (place, rows) in _columns(item, last).items():
            lengths.setdefault(folder, {})[column] = rows
            places.setdefault(folder, {})[column] = place
            if unit := _unit(item):
                units.setdefault(folder, {})[column] = unit

    with refusing_damage(path, _KIND), h5py.File(path, "r") as file:
        file.visititems(visit)
    if objects and not lengths:
        name, kind = next(iter(objects.items()))
        raise MeasurementError(
            f"{path.name}: {name} is a MATLAB {kind}, which only MATLAB can read; save its columns "
            "as vectors of numbers, times as seconds(...), or write the table as CSV"
        )
    groups: list[Group] = []
    columns: dict[str, Mapping[str, _Column]] = {}
    for folder, of_folder in lengths.items():
        for group in grouped(folder, of_folder, units.get(folder, {})):
            groups.append(group)
            columns[group.name] = places[folder]
    return Hdf5Source(path, check_columns(path, groups), columns)


def _columns(item: h5py.Dataset, name: str) -> dict[str, tuple[_Column, int]]:
    """Columns of a data set and how long they are; none where it holds something else."""
    if "MATLAB_empty" in item.attrs or item.attrs.get("MATLAB_class") in (b"char", b"cell"):
        return {}
    if item.dtype.names:
        fields = [field for field in item.dtype.names if item.dtype[field].kind in "buifcS"]
        usable = item.ndim == 1 and len(item) > 1
        return {f: (_Column(item.name, False, f), len(item)) for f in fields if usable}
    if item.dtype.kind not in "buifc" and h5py.check_string_dtype(item.dtype) is None:
        return {}
    return {
        column: (_Column(item.name, across, part), rows)
        for column, rows, across, part in series(name, item.shape)
    }


def _unit(item: h5py.Dataset) -> str | None:
    named = (_text(value) for key, value in item.attrs.items() if key.lower() in ("unit", "units"))
    return next((unit for unit in named if unit), None)


def _text(value: object) -> str | None:
    """Text of an attribute, which may be an array of one."""
    if isinstance(value, np.ndarray) and value.size == 1:
        value = value.item()
    if isinstance(value, bytes):
        return value.decode(errors="replace")
    return value if isinstance(value, str) else None


@dataclass(frozen=True)
class Hdf5Source(FileSource):
    """A `Source` with a group for each HDF5 group, by its path without the first slash."""

    places: Mapping[str, Mapping[str, _Column]]  # group -> column -> place

    def read(self, group: str, columns: Sequence[str], progress: Progress) -> Iterator[Chunk]:
        """Read some columns in chunks, see `base.Source`."""
        rows = self.rows_of(group) or 0
        places = self.places[group]
        with refusing_damage(self.path, _KIND), h5py.File(self.path, "r") as file:
            for some in row_ranges(rows, self.path, progress):
                yield {name: _values(file, places[name], some) for name in columns}


def _values(file: h5py.File, place: _Column, rows: slice) -> NDArray[Any]:
    item = file[place.dataset]
    if h5py.check_string_dtype(item.dtype) is not None:
        item = item.asstr(errors="replace")
    if isinstance(place.part, str):
        return as_numbers(item.fields(place.part)[rows])
    if place.part is None:
        raw = item[rows]
    else:
        raw = item[place.part, rows] if place.lies_across else item[rows, place.part]
    if _text(file[place.dataset].attrs.get("MATLAB_class")) == "logical":
        raw = raw.astype(bool)
    return _unpacked(as_numbers(raw), file[place.dataset].attrs)


def _unpacked(values: NDArray[Any], attributes: Mapping[str, Any]) -> NDArray[Any]:
    """Numbers that were packed by the conventions of NetCDF, blanks as NaN."""
    packed = {"scale_factor", "add_offset", "_FillValue", "missing_value"} & set(attributes)
    if not packed or values.dtype.kind != "f":
        return values
    blanks = [np.ravel(attributes[key]) for key in packed & {"_FillValue", "missing_value"}]
    blank = np.isin(values, np.concatenate(blanks)) if blanks else np.False_
    scale, offset = (
        float(np.ravel(attributes.get(key, usual))[0])
        for key, usual in (("scale_factor", 1.0), ("add_offset", 0.0))
    )
    return np.where(blank, np.nan, values * scale + offset)
