"""The squared error of one signal, split by what the joint was doing."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Bin:
    """Error of one signal over the samples of one bin, simulated less measured.

    `by` is the variable and `bin` says in words which part of it; `lower` and `upper` are its
    edges in SI units (Hz for the frequency), None where it has none. `count` samples (values of
    the spectrum for a frequency); `rmse` and `bias` in the signal's unit; `share` of the signal's
    squared error, which add up to 1 over the bins of one variable. `significance`: by how many
    standard errors the mean square lies above the noise floor, None where the bin is too short to
    tell. `stands_out`: it does so with 5 % risk for all bins of the signal together.
    """

    by: str
    bin: str
    lower: float | None
    upper: float | None
    count: int
    rmse: float
    bias: float
    share: float
    significance: float | None
    stands_out: bool
