"""What Compare and Where say in numbers: errors, values at cursors, chosen samples."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from math import isnan
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastic_tendon.app.tables import Exact
from elastic_tendon.comparison.bins import Bin
from elastic_tendon.comparison.comparison import ErrorFigures, FileComparison
from elastic_tendon.comparison.locate import FileLocation
from elastic_tendon.comparison.partition import range_text
from elastic_tendon.comparison.residuals import rms
from elastic_tendon.measurement.recording import Measurement
from elastic_tendon.reports.comparison_tables import STATES, sample_shares, strongest
from elastic_tendon.reports.interactive.overlay import Reading, Run, values_at
from elastic_tendon.reports.interactive.places import Mark, samples_of
from elastic_tendon.reports.units import Shown, noise_ratio, number, shown, with_unit

Window = tuple[float, float]
Cursors = Mapping[str, float | None]  # "A" and "B", s
NO_CURSORS: Cursors = {"A": None, "B": None}
FORMULAS = (
    "Error: simulated less measured. RMS: root of the mean of the squared error. Bias: mean of the "
    "error. Fit: 100 % less the RMS error in percent of the standard deviation of what was "
    "measured; 100 % is perfect, and a model that stays at the mean has 0 %. Times the noise: RMS "
    "error over the standard deviation of the noise of this signal; 1 is as good as can be seen."
)


# ---- errors --------------------------------------------------------------------------------


def error_heads(quantity: Shown) -> list[str]:
    """Heads of the table of `error_rows`."""
    unit = quantity.small_unit
    return [
        "",
        "samples",
        f"RMS ({unit})",
        f"largest ({unit})",
        f"bias ({unit})",
        "fit (%)",
        "times the noise",
    ]


def error_rows(runs: Sequence[Run], signal: str) -> Iterator[list[str | Exact]]:
    """Error of every run over all samples; of the last also by slack state.

    Where there are several, the rows of all samples begin with the names of their models.

    Parameters
    ----------
    runs : models beside the same recording, at least one
    signal : of the recording
    """
    quantity = _quantity(runs[-1].file, signal)
    for run in runs:
        name = "all" if len(runs) == 1 else f"{run.label}, all"
        yield [name, *_figures(run.file.signals[signal], quantity)]
    for state, part in runs[-1].file.signals[signal].slack_states.items():
        yield [STATES.get(state, state), *_figures(part, quantity)]


def _figures(error: ErrorFigures, quantity: Shown) -> list[str | Exact]:
    sizes = [quantity.small * size for size in (error.rmse, error.max_abs, error.bias)]
    fit = error.fit_percent
    return [
        str(error.count),
        *(Exact(number(size), size) for size in sizes),
        "–" if fit is None else Exact(f"{fit:.1f}", fit),
        Exact(noise_ratio(error.noise_ratio), error.noise_ratio),
    ]


def _quantity(file: FileComparison, signal: str) -> Shown:
    return shown(signal, static=file.measurement.static)


# ---- cursors -------------------------------------------------------------------------------


def cursor_rows(runs: Sequence[Run], signal: str, cursors: Cursors) -> list[list[str | Exact]]:
    """Values at the cursors and what lies between them; columns A, B, B - A.

    Parameters
    ----------
    runs : models beside the same recording, at least one
    signal : of the recording
    cursors : s, None where one is not set
    """
    quantity = _quantity(runs[0].file, signal)
    read = [None if time is None else values_at(runs, signal, time) for time in in_order(cursors)]
    if read == [None, None]:
        return []
    names = ["measured", *(run.label for run in runs)]

    def row(name: str, take: Callable[[Reading], float], digits: str = "#.5g") -> list[str | Exact]:
        first, second = (None if reading is None else take(reading) for reading in read)
        both = None if first is None or second is None else second - first
        cells = (
            "–" if value is None or isnan(value) else Exact(format(value, digits), value)
            for value in (first, second, both)
        )
        return [name, *cells]

    rows = [row("time (s)", lambda reading: reading.time, ".4f")]
    for index, name in enumerate(names):
        rows.append(row(f"{name} ({quantity.unit})", partial(_value, index)))
    for index, name in enumerate(names[1:], start=1):
        rows.append(row(f"error, {name} ({quantity.small_unit})", partial(_error, index, quantity)))
    return rows


def _value(index: int, reading: Reading) -> float:
    return reading.values[index][1]


def _error(index: int, quantity: Shown, reading: Reading) -> float:
    return quantity.small * (_value(index, reading) - _value(0, reading))


def in_order(cursors: Cursors) -> tuple[float | None, float | None]:
    """Times of the cursors A and B, s, None where one is not set."""
    return cursors.get("A"), cursors.get("B")


def with_cursor(cursors: Cursors, time: float) -> dict[str, float | None]:
    """The cursors after a click: the free one goes there; where both are set, the older one.

    They are kept in the order in which they were set.

    Parameters
    ----------
    cursors : s
    time : float, s, of the click
    """
    free = [name for name, value in cursors.items() if value is None]
    moved = min(free) if free else next(iter(cursors))
    return {name: value for name, value in cursors.items() if name != moved} | {moved: time}


# ---- zoom ----------------------------------------------------------------------------------


def span(recording: str, measurement: Measurement) -> dict[str, Any] | None:
    """What the page has to know of a recording to zoom into it; None where it has no time.

    Parameters
    ----------
    recording : its key of `view.recordings`
    measurement : Measurement
    """
    if measurement.static:
        return None
    digits = decimals(measurement.time)
    first, last = (round(float(measurement.time[end]), digits) for end in (0, -1))
    return {"recording": recording, "first": first, "last": last, "decimals": digits}


def decimals(time: NDArray[np.float64]) -> int:
    """How many tell the samples of a recording apart; three at least.

    Parameters
    ----------
    time : (n,) s, rising
    """
    step = float(np.min(np.diff(time), initial=1.0))
    return max(3, int(np.ceil(-np.log10(step) - 1e-9)))


def beyond(chosen: NDArray[np.bool_], time: NDArray[np.float64], window: Window | None) -> bool:
    """Whether samples are chosen, and none of them lies in the stretch of time that is seen.

    Parameters
    ----------
    chosen : (n,)
    time : (n,) s
    window : s, None for all of it
    """
    if window is None or not chosen.any():
        return False
    return not (chosen & (time >= window[0]) & (time <= window[1])).any()


# ---- chosen samples ------------------------------------------------------------------------


def chosen_samples(location: FileLocation, mark: Mark | None) -> NDArray[np.bool_] | None:
    """Samples of a bin or cell; None where nothing is chosen, or what is no longer there."""
    if not mark:
        return None
    try:
        return samples_of(location, mark)
    except (KeyError, TypeError, ValueError):
        return None


def chosen_words(
    run: Run, signal: str, location: FileLocation, mark: Mark, chosen: NDArray[np.bool_]
) -> str:
    """How many samples a bin or cell holds, and how large the error is there.

    Parameters
    ----------
    run : the model beside the recording
    signal : of the recording
    location : FileLocation of it
    mark : of `places`
    chosen : (n,) samples of the mark
    """
    where = place_words(location, mark, chosen)
    count = int(np.count_nonzero(chosen))
    if count == 0:
        return f"{where}: no samples of its own that could be shown."
    quantity = _quantity(run.file, signal)
    error = run.error(signal)
    there, overall = rms(error[chosen]), rms(error)
    share = count * there**2 / (len(error) * overall**2) if overall else 0.0
    return (
        f"{where}: {count} of {len(error)} samples ({number(100.0 * count / len(error))} %), "
        f"RMS error of the {quantity.words} {quantity.error(there)} "
        f"(over all samples {quantity.error(overall)}), "
        f"{number(100.0 * share)} % of the squared error."
    )


def place_words(location: FileLocation, mark: Mark, chosen: NDArray[np.bool_]) -> str:
    """Which bin or cell it is."""
    if len(mark) == len(("variable", "bin")):
        by, words = map(str, mark)
        return _sentence_case(f"{by.replace('_', ' ')} {words}")
    parts = []
    for variable in map(str, mark[:2]):
        values = location.variables[variable][chosen]
        ends = f" {range_text(values.min(), values.max())}" if len(values) else ""
        name, unit = with_unit(variable).rstrip(")").split(" (")
        parts.append(f"{name}{ends} {unit}")
    return _sentence_case(" and ".join(parts))


def _sentence_case(words: str) -> str:
    return words[0].upper() + words[1:]  # units and slack states keep their letters


def strongest_bins(bins: Sequence[Bin]) -> list[Bin]:
    """Bins that stand out and say most of where the error lies; the densest first."""
    shares = sample_shares(bins)
    strong = strongest([error_bin for error_bin in bins if error_bin.stands_out], shares)
    return sorted(strong, key=lambda error_bin: shares[error_bin] - error_bin.share)
