"""A quantity over a grid of two others."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from elastic_tendon.comparison.comparison import FileComparison
from elastic_tendon.comparison.locate import FileLocation
from elastic_tendon.comparison.residuals import Array, residuals_of

PAIRS = (("deflection", "joint_velocity"), ("time", "motor_position"))  # across and up
WITHOUT_SPRINGS = (("joint_position", "joint_velocity"), ("time", "load_torque"))
CELLS = 24  # along each side
MINIMUM_COUNT = 5  # samples in a cell; the mean of fewer says little


@dataclass(frozen=True)
class CellMap:
    """Means over cells: `values` (m, k), NaN where a cell holds too few samples; rows belong to
    `vertical` (m + 1,), columns to `horizontal` (k + 1,), the edges of the cells.
    """

    horizontal: Array
    vertical: Array
    values: Array


@dataclass(frozen=True)
class ErrorMap:
    """Error over two `variables`, across and up: the RMS of a `signal`, in its unit, and the mean
    of the missing torque, N·m; None where there is too little to tell.
    """

    signal: str
    variables: tuple[str, str]
    rms: CellMap | None
    torque: CellMap | None


def error_maps(file: FileComparison, location: FileLocation) -> tuple[ErrorMap, ...]:
    """Where the error of a recording lies, over each of `PAIRS`, or `WITHOUT_SPRINGS`: that of the
    joint position, or of the first signal where that is not compared.

    Parameters
    ----------
    file : FileComparison of a time series
    location : FileLocation of the same recording
    """
    signal = file.measurement.first_signal
    error = residuals_of(file.trajectory, file.measurement)[signal]
    missing = location.missing_torque
    maps = []
    for pair in PAIRS if file.measurement.kind.has_springs else WITHOUT_SPRINGS:
        across, up = (location.variables[variable] for variable in pair)
        squares = mean_by_cell(across, up, error**2)
        rms = squares and replace(squares, values=np.sqrt(squares.values))
        torque = mean_by_cell(across, up, missing.torque) if missing.known else None
        maps.append(ErrorMap(signal, pair, rms, torque))
    return tuple(maps)


def samples_in_cell(horizontal: Array, vertical: Array, column: int, row: int) -> NDArray[np.bool_]:
    """Which samples lie in a cell of `mean_by_cell`, (n,).

    Parameters
    ----------
    horizontal, vertical : (n,) arrays, those that the map is over
    column, row : of the cell, from 0 to `CELLS` - 1
    """
    inside = _places(_edges(horizontal), horizontal) == column
    return np.asarray(inside & (_places(_edges(vertical), vertical) == row))


def _edges(values: Array) -> Array:
    return np.linspace(np.min(values), np.max(values), CELLS + 1)


def _places(edges: Array, values: Array) -> NDArray[np.intp]:
    """Number of the part that holds each of (n,) values; the last part holds its upper edge."""
    return np.searchsorted(edges[1:-1], values, side="right")


def mean_by_cell(horizontal: Array, vertical: Array, values: Array) -> CellMap | None:
    """Mean of a quantity in each cell of a grid over two others.

    Parameters
    ----------
    horizontal, vertical : (n,) arrays, any unit
    values : (n,) array, any unit

    Returns
    -------
    CellMap with `values` in their unit; None where one of the two never changes, or where no cell
    holds `MINIMUM_COUNT` samples
    """
    if np.ptp(horizontal) == 0.0 or np.ptp(vertical) == 0.0:
        return None
    across, up = _edges(horizontal), _edges(vertical)
    cell = CELLS * _places(up, vertical) + _places(across, horizontal)
    count = np.bincount(cell, minlength=CELLS**2).reshape(CELLS, CELLS)
    total = np.bincount(cell, values, CELLS**2).reshape(CELLS, CELLS)
    filled = count >= MINIMUM_COUNT
    if not filled.any():
        return None
    means = np.full(count.shape, np.nan)
    means[filled] = total[filled] / count[filled]
    return CellMap(across, up, means)
