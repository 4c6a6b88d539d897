"""Tests of the residual in words and numbers: is it white, and does it follow the inputs?"""

from collections.abc import Iterator, Sequence

from elastic_tendon.comparison.correlations import Correlation
from elastic_tendon.comparison.locate import FileLocation
from elastic_tendon.reports.units import shown

BAND = "where 99 % of the values lie by chance"
LAG, CORRELATION = "lag of the residual (s)", "correlation (1)"
HEADS = (
    *("residual with", "strongest correlation", "at a lag of", "99 % bounds there"),
    *("lags beyond", "by chance", "more than chance"),
)


def partner(correlation: Correlation) -> str:
    """What a residual is correlated with."""
    signal = correlation.signal.replace("_", " ")
    return f"with the {signal}" if signal else "with itself"


def residual_sentences(location: FileLocation) -> list[str]:
    """Of each signal of a time series, whether what is left is white and which input it follows."""
    return [
        residual_sentence(signal, location.correlations[signal])
        for signal in location.in_words
        if signal in location.correlations
    ]


def residual_sentence(signal: str, correlations: Sequence[Correlation]) -> str:
    """Whether what is left of a signal is white, and which input it follows most.

    Parameters
    ----------
    signal : name of a compared signal
    correlations : of its residual, that with itself first
    """
    own, *with_inputs = correlations
    return f"What is left of the {shown(signal).words} {_whiteness(own)}. {_followed(with_inputs)}."


def _whiteness(own: Correlation) -> str:
    outside = int(own.beyond.sum())
    lie = "lies" if outside == 1 else "lie"
    counts = (
        f"{outside} of {len(own.lag)} lags {lie} beyond their 99 % bounds, "
        f"by chance {own.beyond_by_chance:.2g}"
    )
    sure = own.surely_beyond.nonzero()[0]
    if len(sure):
        least = "at least " if sure[-1] == len(own.lag) - 1 else ""
        return (
            f"is not white: it hangs together over {least}{_seconds(own.lag[sure[-1]])} ({counts})"
        )
    if own.expected.any():
        return f"hangs together no more than the noise of its sensor ({counts})"
    return f"is white as far as can be told ({counts})"


def _followed(with_inputs: Sequence[Correlation]) -> str:
    if not with_inputs:
        return "No input changes that it could follow"
    followed = sorted(
        (correlation for correlation in with_inputs if correlation.surely_beyond.any()),
        key=lambda correlation: -_size(correlation),
    )
    if not followed:
        return "It follows no input by more than chance"
    first, *others = followed
    at = first.strongest
    names = " and the ".join(correlation.signal.replace("_", " ") for correlation in others)
    also = f"; it follows the {names}, too" if others else ""
    return (
        f"It follows the {first.signal.replace('_', ' ')}: correlation "
        f"{first.values[at]:.2f} at a lag of {_seconds(first.lag[at])}, "
        f"99 % bound {first.bound[at]:.2g}{also}"
    )


def _size(correlation: Correlation) -> float:
    """Of the strongest correlation, in bounds."""
    at = correlation.strongest
    return float(abs(correlation.values[at]) / correlation.bound[at])


def residual_rows(correlations: Sequence[Correlation]) -> Iterator[list[str]]:
    """A row of `HEADS` for each correlation of a residual."""
    for correlation in correlations:
        at = correlation.strongest
        low, high = (
            correlation.expected[at] + sign * correlation.bound[at] for sign in (-1.0, 1.0)
        )
        yield [
            partner(correlation).removeprefix("with "),
            f"{correlation.values[at]:.3f}",
            _seconds(correlation.lag[at]),
            f"{low:.3f} to {high:.3f}",
            f"{int(correlation.beyond.sum())} of {len(correlation.lag)}",
            f"{correlation.beyond_by_chance:.2g}",
            "yes" if correlation.surely_beyond.any() else "no",
        ]


def _seconds(lag: float) -> str:
    return f"{lag:.3g} s" if abs(lag) >= 1.0 else f"{1e3 * lag:.3g} ms"
