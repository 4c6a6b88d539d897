"""Statistics of a table of results, read in pieces: memory does not grow with the number of runs.

Quantiles are those of at most 100 000 rows, fewer where there are over 50 columns, evenly spaced
over the table; all else is of all rows.
"""

import math
import re
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd

from elastic_tendon.errors import SweepError
from elastic_tendon.sweeps.factors import Array
from elastic_tendon.sweeps.results import pieces
from elastic_tendon.sweeps.task import FAILURE, RUN

QUANTILE_ROWS = 100_000
QUANTILES = (0.05, 0.5, 0.95)
MOST_SAMPLED = 5_000_000  # numbers in them
KINDS_OF_FAILURE = 1000  # distinguished; more differ in words that nobody would read
MOST_REASONS = 5
NUMBERS = re.compile(r"(?<![A-Za-z_])[-+]?\d+(\.\d*)?([eE][-+]?\d+)?")


@dataclass(frozen=True)
class ColumnSummary:
    """One column of numbers, in the unit of its name; rows without a finite
    number are left out.

    `deviation` : standard deviation (NaN of one row); `lowest_run`, `highest_run` : the first
    run with the minimum and the maximum; `quantiles` : of `QUANTILES`.
    """

    name: str
    count: int
    mean: float
    deviation: float
    minimum: float
    lowest_run: int
    maximum: float
    highest_run: int
    quantiles: tuple[float, ...]


@dataclass(frozen=True)
class Reason:
    """Runs that failed alike, but for the numbers in the message: `text` is that of `run`."""

    text: str
    run: int
    count: int


@dataclass(frozen=True)
class Summary:
    """What a table of results says as a whole.

    `reasons` : of failures, the most frequent first, at most five; `sampled` : rows of which the
    quantiles are, all `rows` where the table is not long.
    """

    runs: int
    failed: int
    rows: int
    sampled: int
    reasons: tuple[Reason, ...]
    columns: tuple[ColumnSummary, ...]


def summarise(path: Path) -> Summary:
    """Summarise a table that `sweep` has written.

    Parameters
    ----------
    path : a file of CSV, or of Parquet where it is called ``.parquet``

    Returns
    -------
    Summary; a column for each of the table's that holds numbers, but for `RUN`

    Raises
    ------
    SweepError
        where the file cannot be read, or is no table of results
    """
    table = _Table()
    try:
        for piece in pieces(path):
            table.add(piece)
    except OSError as error:
        raise SweepError(f"{path}: cannot be read: {error.strerror or error}") from None
    except (ValueError, ImportError) as error:  # what pandas and pyarrow say of damaged files
        reason = str(error).splitlines()[0]
        raise SweepError(f"{path}: is no table of results: {reason}") from None
    return table.summary()


# ---- what is known of the rows so far ------------------------------------------------------


@dataclass
class _Column:
    """Running moments by Chan, Golub and LeVeque (1983), and extremes."""

    count: int = 0
    mean: float = 0.0
    squares: float = 0.0
    minimum: float = math.inf
    lowest_run: int = -1
    maximum: float = -math.inf
    highest_run: int = -1

    def add(self, values: Array, runs: Array) -> None:
        there = np.isfinite(values)
        values, runs = values[there], runs[there]
        if not values.size:
            return
        count, mean = values.size, float(np.mean(values))
        total, apart = self.count + count, mean - self.mean
        self.squares += float(np.sum(np.square(values - mean)))
        self.squares += apart**2 * self.count * count / total
        self.mean += apart * count / total
        self.count = total
        low, high = int(np.argmin(values)), int(np.argmax(values))
        if values[low] < self.minimum:
            self.minimum, self.lowest_run = float(values[low]), int(runs[low])
        if values[high] > self.maximum:
            self.maximum, self.highest_run = float(values[high]), int(runs[high])

    def summary(self, name: str, sample: Array) -> ColumnSummary:
        there = sample[np.isfinite(sample)]
        quantiles = np.quantile(there, QUANTILES) if there.size else [math.nan] * len(QUANTILES)
        variance = self.squares / (self.count - 1) if self.count > 1 else math.nan
        return ColumnSummary(
            name,
            self.count,
            self.mean,
            math.sqrt(variance),
            self.minimum,
            self.lowest_run,
            self.maximum,
            self.highest_run,
            tuple(float(quantile) for quantile in quantiles),
        )


@dataclass
class _Failures:
    """Reasons by what they say apart from numbers, such as the time at which a solver stopped."""

    failed: int = 0
    counts: Counter[str] = field(default_factory=Counter)
    examples: dict[str, tuple[str, int]] = field(default_factory=dict)

    def add(self, reasons: pd.Series, runs: Array) -> None:
        for text, run in zip(reasons, runs, strict=True):
            self.failed += 1
            kind = NUMBERS.sub("#", text)
            if kind in self.examples or len(self.examples) < KINDS_OF_FAILURE:
                self.counts[kind] += 1
                self.examples.setdefault(kind, (text, int(run)))

    def most_frequent(self) -> tuple[Reason, ...]:
        return tuple(
            Reason(*self.examples[kind], count)
            for kind, count in self.counts.most_common(MOST_REASONS)
        )


@dataclass
class _Table:
    runs: int = 0
    rows: int = 0
    last_run: int = -1
    stride: int = 1  # every how many rows one is kept for the quantiles
    sample: pd.DataFrame | None = None
    columns: dict[str, _Column] | None = None
    failures: _Failures = field(default_factory=_Failures)

    def add(self, piece: pd.DataFrame) -> None:
        """Add the next rows; those of a run stand together."""
        if piece.empty:
            return
        runs = piece[RUN].to_numpy()
        self.runs += int(np.count_nonzero(np.diff(runs, prepend=self.last_run)))
        self.last_run = int(runs[-1])
        bad = (piece[FAILURE] != "").to_numpy()
        self.failures.add(piece.loc[bad, FAILURE], runs[bad])
        numbers = piece.drop(columns=[RUN, FAILURE]).select_dtypes("number").astype(float)
        if self.columns is None:
            self.columns = {name: _Column() for name in numbers.columns}
        # text that is empty in one piece and not in another is text
        self.columns = {name: known for name, known in self.columns.items() if name in numbers}
        for name, column in self.columns.items():
            column.add(numbers[name].to_numpy(), runs)
        self._keep(numbers)
        self.rows += len(piece)

    def _keep(self, numbers: pd.DataFrame) -> None:
        """Keep every `stride`-th row of the table; half of them once they are too many."""
        kept = numbers.iloc[-self.rows % self.stride :: self.stride]
        self.sample = kept if self.sample is None else pd.concat([self.sample, kept])
        most = min(QUANTILE_ROWS, MOST_SAMPLED // max(numbers.shape[1], 1))
        while len(self.sample) > most:
            self.sample = self.sample.iloc[::2]
            self.stride *= 2

    def summary(self) -> Summary:
        if self.sample is None or self.columns is None:
            raise SweepError("the table of results has no rows; repeat the sweep")
        return Summary(
            runs=self.runs,
            failed=self.failures.failed,
            rows=self.rows,
            sampled=len(self.sample),
            reasons=self.failures.most_frequent(),
            columns=tuple(
                column.summary(str(name), self.sample[name].to_numpy())
                for name, column in self.columns.items()
                if column.count  # else its rows are empty, numbers or not
            ),
        )
