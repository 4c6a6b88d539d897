"""What is left of the error, in words: on what it depends, or when it comes."""

from collections.abc import Iterator, Mapping

import numpy as np

from elastic_tendon.comparison.compare import Comparison, FileComparison
from elastic_tendon.comparison.residuals import Array, residuals_of
from elastic_tendon.diagnosis.lack_of_fit import LackOfFit

# of the squared error beyond the noise, and of the time in which it comes at once
MOST, SHORT = 0.8, 0.25
WORDS = {
    "velocity_sign": "the direction of motion",
    "history": "how the machine moved before",
    "slack_state": "which tendon is slack",
}


def remaining_sentences(lack: Mapping[str, LackOfFit], comparison: Comparison) -> Iterator[str]:
    """For each signal of which more than chance is left, a sentence.

    Parameters
    ----------
    lack : by signal
    comparison : the answer beside the fitted recordings
    """
    for name, found in lack.items():
        left = f"what is left of {name.replace('_', ' ')}"
        if not found.significant:
            continue
        if found.variables != ("time",):
            of = " and ".join(WORDS.get(part, part.replace("_", " ")) for part in found.variables)
            yield (
                f"Of {left}, {100.0 * found.explains:.0f} % of the squared error can be predicted "
                f"from {of}, on stretches of time that were left out."
            )
        elif spans := dict(_spans(comparison, name)):
            worst = min(spans, key=lambda file: spans[file][1] - spans[file][0])
            start, end = spans[worst]
            yield f"Most of {left} comes at once, from {start:.3g} to {end:.3g} s of {worst}."


def _spans(comparison: Comparison, name: str) -> Iterator[tuple[str, tuple[float, float]]]:
    """Names of recordings whose error comes at once, with the time of its begin and end, s."""
    for file in comparison.files:
        if name in file.signals and not file.measurement.static:
            time, excess = file.measurement.time, _excess(file, name)
            start, end = _shortest(time, excess)
            if np.any(excess) and end - start < SHORT * (time[-1] - time[0]):
                yield file.measurement.name, (start, end)


def _excess(file: FileComparison, name: str) -> Array:
    """Squared error beyond the noise of a signal, (n,)."""
    error = residuals_of(file.trajectory, file.measurement)[name]
    return np.maximum(error**2 - file.signals[name].noise.sigma ** 2, 0.0)


def _shortest(time: Array, values: Array) -> tuple[float, float]:
    """The shortest stretch of time that holds most of the sum of some values, (n,) arrays."""
    before = np.concatenate([[0.0], np.cumsum(values)])
    last = np.searchsorted(before, before[:-1] + MOST * before[-1]) - 1
    first = np.flatnonzero(last < len(time))
    lengths = time[last[first]] - time[first]
    best = first[np.argmin(lengths)]
    return float(time[best]), float(time[last[best]])
