"""MAT up to version 7, which can only be read as a whole; 7.3 is HDF5, see `hdf5`."""

import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.io import loadmat, whosmat
from scipy.sparse import csc_array, csc_matrix

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


def open_file(path: Path) -> "MatSource":
    """Open a MAT file of version 4 to 7.

    Variables of one length are columns of one `Group`, those of a struct of another with its
    name; a matrix has its samples along its longer axis. Simulink's "structure with time" is one
    group, its signals called by their labels. Such a file holds 2 GB at most for each variable
    and is kept in memory.

    Raises
    ------
    MeasurementError : the file is damaged or holds no usable array
    """
    with refusing_damage(path, "MAT file"):
        with warnings.catch_warnings():  # of the kind of sparse arrays, which are filled here
            warnings.filterwarnings("ignore", "The default value for `spmatrix`")
            content = loadmat(path, simplify_cells=True)
        logical = [name for name, _, kind in whosmat(path) if kind == "logical"]
    content |= {name: np.asarray(content[name]).astype(bool) for name in logical}
    variables = {name: value for name, value in content.items() if not name.startswith("__")}
    groups: list[Group] = []
    arrays: dict[str, Mapping[str, NDArray[Any]]] = {}
    for folder, columns in _folders("", variables):
        for group in grouped(folder, {name: len(a) for name, a in columns.items()}, {}):
            groups.append(group)
            arrays[group.name] = columns
    return MatSource(path, check_columns(path, groups), arrays)


def _folders(
    path: str, content: Mapping[str, Any]
) -> Iterator[tuple[str, Mapping[str, NDArray[Any]]]]:
    """A struct's own columns, then those of the structs in it."""
    if "time" in content and "signals" in content:
        content = {"time": content["time"], **_logged(content["signals"])}
    columns: dict[str, NDArray[Any]] = {}
    inner: dict[str, Mapping[str, Any]] = {}
    for name, held in content.items():
        value = _dense(held)
        if isinstance(value, Mapping):
            inner[name] = value
        elif isinstance(value, list | np.ndarray) and any(isinstance(v, Mapping) for v in value):
            inner |= {f"{name}[{i}]": v for i, v in enumerate(value) if isinstance(v, Mapping)}
        elif isinstance(value, np.ndarray) and value.dtype.kind in "buifcU":
            for column, _, across, part in series(name, value.shape):
                samples = value.T if across else value
                columns[column] = samples if part is None else samples[:, part]
    if columns:
        yield path, columns
    for name, struct in inner.items():
        yield from _folders(f"{path}/{name}" if path else name, struct)


def _dense(value: Any) -> Any:
    """A sparse vector as a plain one; a sparse matrix may be too large for it."""
    return (
        value.toarray() if isinstance(value, csc_array | csc_matrix) and 1 in value.shape else value
    )


def _logged(signals: Any) -> dict[str, Any]:
    """Values of Simulink's logged signals, by label, else by number."""
    several = [signals] if isinstance(signals, Mapping) else list(signals)
    labels = [signal.get("label") for signal in several]
    return {
        # an empty label is read as an empty array
        label if isinstance(label, str) and label else f"signals[{i}]": signal.get("values")
        for i, (label, signal) in enumerate(zip(labels, several, strict=True))
    }


@dataclass(frozen=True)
class MatSource(FileSource):
    """A `Source` with a group for the variables and one for each struct."""

    arrays: Mapping[str, Mapping[str, NDArray[Any]]]  # group -> column -> samples

    def read(self, group: str, columns: Sequence[str], progress: Progress) -> Iterator[Chunk]:
        """Read some columns in chunks, see `base.Source`."""
        arrays = self.arrays[group]
        rows = self.rows_of(group) or 0
        for some in row_ranges(rows, self.path, progress):
            yield {name: as_numbers(arrays[name][some]) for name in columns}
