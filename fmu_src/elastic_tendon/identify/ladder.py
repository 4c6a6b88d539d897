"""The ladder of errors: one entry for each step from the model as given to the improved one."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import log
from typing import Any

import numpy as np
from scipy.stats import chi2

from elastic_tendon.identify.compare import Comparison
from elastic_tendon.identify.residuals import Array, autocorrelation_time, residuals_of

AS_GIVEN = "as given"
REFIT = "parameters refitted"
# simulated recordings can be met exactly; errors below this share of the noise count as this
LEAST_SHARE_OF_NOISE = 0.5


@dataclass(frozen=True)
class Step:
    """A model on its way and how it compares.

    `added` is the id of the effect that came in, with `parameters` numbers; `effective` counts
    the numbers that the data determine.
    """

    title: str
    added: str | None
    parameters: int
    effective: float
    comparison: Comparison
    heldout: Comparison | None


@dataclass(frozen=True)
class Rung:
    """One entry of the ladder.

    `rmse`, `heldout_rmse` : signal -> root mean square error in the signal's unit.
    `noise_ratio` : signal -> `rmse` over the noise floor.
    `bic` : lower is better, comparable within one ladder.
    `p_value` : probability of so large a gain over the step before if what was added were nothing;
    None where nothing was added.
    """

    title: str
    added: str | None
    rmse: dict[str, float]
    heldout_rmse: dict[str, float]
    noise_ratio: dict[str, float]
    bic: float
    p_value: float | None

    def to_json(self) -> dict[str, Any]:
        """Entry of ``ladder`` in the diagnosis contract, with a title for people."""
        return {
            "title": self.title,
            "added": self.added,
            "rmse": self.rmse,
            "heldout_rmse": self.heldout_rmse,
            "noise_ratio": self.noise_ratio,
            "bic": self.bic,
            "p_value": self.p_value,
        }


def climb(steps: Sequence[Step]) -> tuple[Rung, ...]:
    """Judge steps against one another.

    Errors that hang together count less: the samples of each signal are divided by the
    autocorrelation time of the last step's error, the whitest there is, and the same count
    N_eff serves every step, so that

    ``bic = sum over signals of N_eff log(mean square) + effective log(sum of N_eff)``.

    A number that stays with its prior costs nothing, as it explains nothing. The p value is that
    of the likelihood ratio, chi-squared with as many degrees of freedom as numbers came in;
    halved for a single one, which at zero lies on its bound (Self & Liang 1987).

    Parameters
    ----------
    steps : from the model as given to the last

    Returns
    -------
    tuple of Rung, one for each step
    """
    counts = _effective_counts(steps[-1].comparison)
    deviances = [_deviance(step.comparison, counts) for step in steps]
    rungs = []
    for index, step in enumerate(steps):
        p_value = None
        if step.added is not None:
            p_value = _p_value(deviances[index - 1] - deviances[index], step.parameters)
        rungs.append(
            Rung(
                title=step.title,
                added=step.added,
                rmse=step.comparison.rmse(),
                heldout_rmse={} if step.heldout is None else step.heldout.rmse(),
                noise_ratio=step.comparison.noise_ratio(),
                bic=deviances[index] + step.effective * log(sum(counts.values())),
                p_value=p_value,
            )
        )
    return tuple(rungs)


def _p_value(gain: float, freedom: int) -> float:
    if gain <= 0.0:
        return 1.0
    tail = float(chi2.sf(gain, freedom))
    return 0.5 * tail if freedom == 1 else tail


def _errors(comparison: Comparison) -> dict[str, list[Array]]:
    errors: dict[str, list[Array]] = {}
    for file in comparison.files:
        for name, error in residuals_of(file.trajectory, file.measurement).items():
            errors.setdefault(name, []).append(error)
    return errors


def _effective_counts(comparison: Comparison) -> dict[str, float]:
    return {
        name: sum(len(error) / autocorrelation_time(error) for error in errors)
        for name, errors in _errors(comparison).items()
    }


def _deviance(comparison: Comparison, counts: dict[str, float]) -> float:
    floors = comparison.pooled(lambda error: error.noise.sigma)
    deviance = 0.0
    for name, errors in _errors(comparison).items():
        mean_square = float(np.mean(np.concatenate(errors) ** 2))
        least = (LEAST_SHARE_OF_NOISE * floors[name]) ** 2
        deviance += counts[name] * log(max(mean_square, least))
    return deviance
