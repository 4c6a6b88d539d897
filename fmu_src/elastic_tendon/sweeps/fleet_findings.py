"""What the robots of a fleet show together: who has what, what they share, and what grows."""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy import stats

from elastic_tendon import effects
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.quantity import unit_suffix
from elastic_tendon.comparison.residuals import Array
from elastic_tendon.errors import MeasurementError
from elastic_tendon.estimation.coordinates import free_parameters
from elastic_tendon.estimation.determinability import CONFIDENCE
from elastic_tendon.result import Result, plain
from elastic_tendon.sweeps.fleet import HIGH, LOW, UNKNOWN, named, number, units_of
from elastic_tendon.sweeps.task import APPEARED, DRIFTED, FAILURE, ROBOT, VERDICT

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FEWEST, FEWEST_ALIKE = 3, 5  # robots for an average, and for what all but one have in common
CHANCE = 0.01  # of telling any trend, or any robot, that is none
KNOWN = 0.7  # of the prior's one sigma: who is not known better says nothing of the fleet
MAD = 1.4826  # median absolute deviation of a normal distribution, in standard deviations
MOST_COMPARED = 1000  # robots, evenly spread, whose pairs make a slope
MOST_NAMED = 8  # robots in a sentence


@dataclass(frozen=True)
class Affected:
    """Robots in which one thing is the same: an effect appeared, or a parameter drifted.

    `name` : id of the effect, or dotted path. `sizes` : dotted path -> lowest and highest estimate
    among them, SI.
    """

    name: str
    robots: tuple[str, ...]
    sizes: Mapping[str, tuple[float, float]]


@dataclass(frozen=True)
class Pooled:
    """A parameter over all robots whose recordings tell it, SI.

    `mean` with its 95 % `interval`, and `spread`, one sigma of the robots around it.
    """

    path: str
    robots: int
    mean: float
    interval: tuple[float, float]
    spread: float


@dataclass(frozen=True)
class Unlike:
    """A robot that contradicts its neighbours: its estimate, and where theirs let expect it, SI."""

    robot: str
    path: str
    estimate: float
    expected: tuple[float, float]


@dataclass(frozen=True)
class Trend:
    """A parameter that grows or falls with what is known about the robots.

    `change` over the `span` of the column `about`, and its 95 % `interval`, SI; `p` : of chance.
    """

    path: str
    about: str
    span: tuple[float, float]
    change: float
    interval: tuple[float, float]
    p: float


@dataclass(frozen=True)
class Onset:
    """An effect that robots with more, or less, in the column `about` have.

    `present` and `absent` : median of that column where it appeared, and elsewhere.
    """

    effect: str
    about: str
    present: float
    absent: float
    p: float


@dataclass(frozen=True, repr=False)
class FleetFindings(Result):
    """What a fleet shows together; names of robots in the order of the table.

    `failed` : robot -> why it could not be diagnosed; `units` : of each path.
    """

    appeared: tuple[Affected, ...]
    drifted: tuple[Affected, ...]
    adequate: tuple[str, ...]
    unexplained: tuple[str, ...]
    failed: Mapping[str, str]
    unlike: tuple[Unlike, ...]
    onsets: tuple[Onset, ...]
    trends: tuple[Trend, ...]
    pooled: tuple[Pooled, ...]
    units: Mapping[str, str]

    def summary(self) -> str:
        """A sentence a line, the most important first."""
        return "\n".join(self.sentences())

    def sentences(self) -> Iterator[str]:
        """The answer in words."""
        for effect in self.appeared:
            sizes = (
                f"{path.rpartition('.')[2]} {self._between(path, *ends)}"
                for path, ends in effect.sizes.items()
            )
            yield f"{effect.name} appeared: {', '.join([_robots(effect.robots), *sizes])}"
        for parameter in self.drifted:
            (ends,) = parameter.sizes.values()
            now = self._between(parameter.name, *ends)
            yield f"{parameter.name} drifted: {_robots(parameter.robots)}, now {now}"
        if self.unexplained:
            yield f"no known effect explains what is left: {_robots(self.unexplained)}"
        if self.adequate:
            yield f"adequate: {_robots(self.adequate)}"
        if self.failed:
            yield f"not diagnosed: {_robots(tuple(self.failed))}"
        for unlike in self.unlike:
            expected = self._between(unlike.path, *unlike.expected)
            yield (
                f"{unlike.robot} is unlike the others: {unlike.path} {number(unlike.estimate)}, "
                f"by theirs {expected}"
            )
        for onset in self.onsets:
            side = "more" if onset.present > onset.absent else "less"
            yield (
                f"{onset.effect} appeared where {onset.about} is {side}: its median is "
                f"{number(onset.present)} there and {number(onset.absent)} elsewhere"
            )
        for trend in self.trends:
            sign, verb = (1.0, "grows") if trend.change > 0.0 else (-1.0, "falls")
            low, high = sorted(sign * end for end in trend.interval)
            change = f"{number(abs(trend.change))}{self._unit(trend.path)}"
            yield (
                f"{trend.path.removeprefix('effects.')} {verb} with {trend.about}: by {change} "
                f"({number(low)} to {number(high)}) from "
                f"{number(trend.span[0])} to {number(trend.span[1])}"
            )

    def to_dict(self) -> dict[str, Any]:
        """As plain data, SI units."""
        return {"schema": "elastic-tendon/fleet/1", **plain(asdict(self))}

    def to_dataframe(self) -> pd.DataFrame:
        """Pooled estimates, a row for each parameter."""
        return pd.DataFrame(
            {
                "path": pooled.path,
                "unit": self.units[pooled.path],
                "robots": pooled.robots,
                "mean": pooled.mean,
                "low": pooled.interval[0],
                "high": pooled.interval[1],
                "spread": pooled.spread,
            }
            for pooled in self.pooled
        )

    def plot(self) -> "Figure":
        """Draw the pooled estimates: mean, its interval, and how the robots spread around it."""
        from elastic_tendon.reports.fleet_figure import pooled_figure

        return pooled_figure(self)

    def _between(self, path: str, low: float, high: float) -> str:
        ends = number(low) if low == high else f"{number(low)} to {number(high)}"
        return ends + self._unit(path)

    def _unit(self, path: str) -> str:
        return unit_suffix(self.units[path])


def _robots(names: Sequence[str]) -> str:
    listed = [*islice(names, MOST_NAMED), *(["..."] if len(names) > MOST_NAMED else [])]
    return f"{len(names)} robot{'s' if len(names) > 1 else ''} ({', '.join(listed)})"


def fleet_findings(
    model: Model, table: pd.DataFrame, about: pd.DataFrame | str | Path | None = None
) -> FleetFindings:
    """What the robots of a fleet show together.

    Parameters
    ----------
    model : Model that they were diagnosed against
    table : rows of a `Fleet`, as `Swept.to_dataframe` gives them
    about : what else is known of the robots, as a table or a CSV file: a column `robot`, and
        columns of numbers (hours of operation) or dates, of which trends are told

    Returns
    -------
    FleetFindings

    Raises
    ------
    MeasurementError : `about` cannot be read, lacks a robot, or names one twice
    """
    fleet = _Diagnosed(model, table)
    known = pd.DataFrame() if about is None else known_of(fleet.robots(), about)
    columns = {f"{column}": _numbers(known[column]) for column in known}
    return FleetFindings(
        appeared=tuple(fleet.affected(APPEARED)),
        drifted=tuple(fleet.affected(DRIFTED)),
        adequate=fleet.robots(fleet.column(VERDICT) == "adequate"),
        unexplained=fleet.robots(fleet.column(VERDICT) == "unexplained"),
        failed=dict(table.loc[table[FAILURE] != "", [ROBOT, FAILURE]].to_numpy().tolist()),
        unlike=tuple(fleet.unlike()),
        onsets=tuple(fleet.onsets(columns)),
        trends=tuple(fleet.trends(columns)),
        pooled=tuple(fleet.pooled()),
        units=fleet.units,
    )


@dataclass(frozen=True)
class _Diagnosed:
    """The robots that were diagnosed, of a table of all."""

    model: Model
    table: pd.DataFrame

    @cached_property
    def _rows(self) -> NDArray[np.intp]:
        return np.flatnonzero(self.table[FAILURE] == "")

    def column(self, name: str) -> pd.Series:
        """A column; one at a time, as all of them would be much memory."""
        return self.table[name].iloc[self._rows]

    def robots(self, which: Any = slice(None)) -> tuple[str, ...]:
        """Names of all, or of some."""
        return tuple(map(str, self.column(ROBOT).to_numpy()[which]))

    @cached_property
    def units(self) -> dict[str, str]:
        """Unit of each parameter that the table has, by dotted path."""
        return {path: unit for path, unit in units_of(self.model).items() if path in self.table}

    def affected(self, column: str) -> Iterator[Affected]:
        """Effects that appeared, or parameters that drifted, the most frequent first."""
        robots: dict[str, list[int]] = defaultdict(list)
        for row, text in enumerate(self.column(column)):
            for name in named(text):
                robots[name].append(row)
        robots.pop(UNKNOWN, None)
        for name, rows in sorted(robots.items(), key=lambda pair: -len(pair[1])):
            paths = [name] if column == DRIFTED else self._parameters(name)
            sizes = {path: _ends(self.column(path).iloc[rows]) for path in paths}
            yield Affected(name, self.robots(rows), sizes)

    def _parameters(self, effect_id: str) -> list[str]:
        return [path for path in self.units if path.startswith(f"effects.{effect_id}.")]

    def pooled(self) -> Iterator[Pooled]:
        """Averages of what the robots share, by a random-effects model.

        The robots differ by more than their intervals: the variance between them is estimated from
        moments (DerSimonian & Laird, Controlled Clinical Trials 7, 1986), the interval of the mean
        with Student's distribution (Hartung & Knapp, Statistics in Medicine 20, 2001).
        """
        for path, (_, values, errors) in self._known():
            if len(values) < FEWEST:
                continue
            mean, half, spread = pooled(values, errors)
            yield Pooled(path, len(values), mean, (mean - half, mean + half), spread)

    def unlike(self) -> Iterator[Unlike]:
        """Robots whose estimate their neighbours do not let expect."""
        for path, (rows, values, errors) in self._known():
            if len(values) < FEWEST_ALIKE:
                continue
            centre = np.median(values)
            scatter = (MAD * np.median(np.abs(values - centre))) ** 2
            between = max(scatter - np.median(errors**2), 0.0)
            chance = CHANCE / len(values) / len(free_parameters(self.model))
            sigmas = stats.t.ppf(1.0 - chance / 2.0, len(values) - 2)
            half = sigmas * np.sqrt(between + errors**2 + scatter / len(values))
            outside = np.flatnonzero(np.abs(values - centre) > half)
            for robot, i in zip(self.robots(rows[outside]), outside.tolist(), strict=True):
                expected = (float(centre - half[i]), float(centre + half[i]))
                yield Unlike(robot, path, float(values[i]), expected)

    def _known(self) -> Iterator[tuple[str, tuple[NDArray[np.intp], Array, Array]]]:
        """Parameters of the model: rows that tell them, estimates, standard errors; each (n,)."""
        explained = self.column(VERDICT).to_numpy() != "unexplained"
        for path in free_parameters(self.model):
            values, low, high = (
                self.column(path + end).to_numpy(np.float64) for end in ("", LOW, HIGH)
            )
            errors = (high - low) / (2.0 * CONFIDENCE)
            told = explained & (errors > 0.0) & (errors < KNOWN * self.model.uncertainty_of(path))
            yield path, (np.flatnonzero(told), values[told], errors[told])

    def onsets(self, columns: Mapping[str, Array]) -> Iterator[Onset]:
        """Effects that appeared where a column is larger or smaller, by Mann and Whitney's test
        with Bonferroni's correction for all that was looked at."""
        found = [named(text) for text in self.column(APPEARED)]
        for effect_id in effects.BY_ID:
            has = np.array([effect_id in ids for ids in found], dtype=bool)
            for column, numbers in columns.items():
                told = np.isfinite(numbers)
                present, absent = numbers[told & has], numbers[told & ~has]
                if min(len(present), len(absent)) < FEWEST:
                    continue
                p = stats.mannwhitneyu(present, absent).pvalue * len(effects.BY_ID) * len(columns)
                if p < CHANCE:
                    medians = float(np.median(present)), float(np.median(absent))
                    yield Onset(effect_id, column, *medians, float(p))

    def trends(self, columns: Mapping[str, Array]) -> Iterator[Trend]:
        """What grows or falls with a column, among the robots that have it.

        Kendall's rank correlation tells whether, with Bonferroni's correction for all that was
        looked at, and the median of the slopes of all pairs how much (Sen, Journal of the American
        Statistical Association 63, 1968).
        """
        for path in self.units:
            values = self.column(path).to_numpy(np.float64)
            for column, numbers in columns.items():
                told = np.flatnonzero(np.isfinite(numbers) & np.isfinite(values))
                told = told[:: max(-(-len(told) // MOST_COMPARED), 1)]
                x, y = numbers[told], values[told]
                if len(told) < FEWEST_ALIKE or np.ptp(x) == 0.0 or np.ptp(y) == 0.0:
                    continue
                p = stats.kendalltau(x, y).pvalue * len(self.units) * len(columns)
                if p < CHANCE:
                    span = (float(x.min()), float(x.max()))
                    slopes = stats.theilslopes(y, x)
                    change, low, high = (
                        (span[1] - span[0]) * float(slope)
                        for slope in (slopes.slope, slopes.low_slope, slopes.high_slope)
                    )
                    yield Trend(path, column, span, change, (low, high), float(p))


def _ends(numbers: pd.Series) -> tuple[float, float]:
    return float(numbers.min()), float(numbers.max())


def pooled(values: Array, errors: Array) -> tuple[float, float, float]:
    """Mean of what robots share, half its 95 % interval, and one sigma between the robots.

    Parameters
    ----------
    values, errors : (n,) estimates and their standard errors, n at least 2
    """
    weights = 1.0 / errors**2
    fixed = np.average(values, weights=weights)
    excess = weights @ (values - fixed) ** 2 - (len(values) - 1)
    between = max(excess / (weights.sum() - (weights @ weights) / weights.sum()), 0.0)
    weights = 1.0 / (errors**2 + between)
    mean = np.average(values, weights=weights)
    variance = weights @ (values - mean) ** 2 / (len(values) - 1) / weights.sum()
    # never narrower than the robots' own intervals allow
    error = np.sqrt(max(variance, 1.0 / weights.sum()))
    half = stats.t.ppf(0.975, len(values) - 1) * error
    return float(mean), float(half), float(np.sqrt(between))


def known_of(robots: Sequence[str], about: pd.DataFrame | str | Path) -> pd.DataFrame:
    """What is known of some robots, a row for each, in their order.

    Raises
    ------
    MeasurementError : `about` cannot be read, lacks a robot, or names one twice
    """
    table = about if isinstance(about, pd.DataFrame) else _read(Path(about))
    if ROBOT not in table:
        listed = ", ".join(map(str, table.columns))
        raise MeasurementError(
            f"what is known of the robots has no column {ROBOT} (found: {listed}); add it"
        )
    known = table.astype({ROBOT: str}).set_index(ROBOT)
    if known.index.has_duplicates:
        twice = known.index[known.index.duplicated()][0]
        raise MeasurementError(f"what is known of the robots has two rows for {twice}; keep one")
    if missing := set(robots) - set(known.index):
        raise MeasurementError(
            f"what is known of the robots has no row for {min(missing)}; add it, with empty cells "
            "where nothing is known"
        )
    return known.loc[list(robots)]


def _read(path: Path) -> pd.DataFrame:
    try:
        return pd.read_csv(path, dtype={ROBOT: str})
    except OSError as error:
        raise MeasurementError(f"{path}: {error.strerror}") from None
    except ValueError as error:
        raise MeasurementError(f"{path}: this is no CSV table ({error})") from None


def _numbers(column: pd.Series) -> Array:
    """A column as numbers, dates as days; NaN where it is neither."""
    numbers = pd.to_numeric(column, errors="coerce")
    if numbers.isna().all():
        dates = pd.to_datetime(column, errors="coerce", format="ISO8601", utc=True)
        numbers = (dates - pd.Timestamp(0, tz="UTC")) / pd.Timedelta(days=1)
    return numbers.to_numpy(np.float64)
