"""How bins stand side by side in a picture, whatever draws it."""

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from elastic_tendon.comparison.bins import Bin
from elastic_tendon.reports.units import with_unit

ROUND = 5e-4  # of the range of all bins; an edge as close to 0 as that is called so


@dataclass(frozen=True)
class BinAxis:
    """Ticks below bins that stand at 0, 1, ...: `places` and `labels`, and the `title` of all.

    `edges`: the labels are numbers between the bins, not words below them.
    """

    places: tuple[float, ...]
    labels: tuple[str, ...]
    title: str
    edges: bool


def by_variable(bins: Sequence[Bin]) -> dict[str, list[Bin]]:
    """Bins of each variable by which a recording is split in more than one."""
    split = Counter(bin_.by for bin_ in bins)
    several = [by for by, count in split.items() if count > 1]
    return {by: [bin_ for bin_ in bins if bin_.by == by] for by in several}


def axis_below(bins: Sequence[Bin]) -> BinAxis:
    """Edges between the bins of a range, names below others.

    Parameters
    ----------
    bins : those of one variable, in order
    """
    by = bins[0].by
    edges = [bins[0].lower, *(bin_.upper for bin_ in bins)]
    numbers = [edge for edge in edges if edge is not None]
    if len(numbers) == len(edges):
        places = tuple(index - 0.5 for index in range(len(edges)))
        span = numbers[-1] - numbers[0]
        labels = tuple(_edge(number, span) for number in numbers)
        return BinAxis(places, labels, with_unit(by), edges=True)
    names = tuple(re.split("[:,]", bin_.bin)[0] for bin_ in bins)
    return BinAxis(tuple(map(float, range(len(bins)))), names, by.replace("_", " "), edges=False)


def _edge(value: float, span: float) -> str:
    if abs(value) < ROUND * span:
        return "0"
    return f"{value:.0f}" if abs(value) >= 10.0 else f"{value:.2g}"
