"""A quantity over a grid of two others."""

from dataclasses import dataclass

import numpy as np

from elastic_tendon.identify.residuals import Array

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
    count, *edges = np.histogram2d(vertical, horizontal, CELLS)
    total = np.histogram2d(vertical, horizontal, edges, weights=values)[0]
    filled = count >= MINIMUM_COUNT
    if not filled.any():
        return None
    means = np.full(count.shape, np.nan)
    means[filled] = total[filled] / count[filled]
    return CellMap(edges[1], edges[0], means)
