"""The ladder of errors: one entry for each step from the model as given to the improved one."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from math import exp, log
from typing import Any

import numpy as np

from elastic_tendon.actuator.motion_kind import MotionKind
from elastic_tendon.actuator.variables import with_unit
from elastic_tendon.comparison.comparison import Comparison
from elastic_tendon.comparison.residuals import Array, autocorrelation_time, residuals_of

AS_GIVEN = "as given"
REFIT = "parameters refitted"
# simulated recordings can be met exactly; errors below this share of the noise count as this
LEAST_SHARE_OF_NOISE = 0.5


@dataclass(frozen=True)
class FittedStep:
    """A model on its way and how it compares.

    `added` is the id of the effect that came in, with so many `parameters`; `effective`
    counts those that the data determine. `evidence` : where it is known already, see `climb`.
    """

    title: str
    added: str | None
    parameters: int
    effective: float
    comparison: Comparison
    heldout: Comparison | None
    evidence: float | None = None


@dataclass(frozen=True)
class Step:
    """One entry of the ladder.

    `rmse`, `heldout_rmse` : signal -> root mean square error in the signal's unit.
    `noise_ratio`, `heldout_noise_ratio` : signal -> that over the noise floor.
    `evidence` : lower is better, comparable within one ladder; a difference of 10 decides.
    `probability` : weight among all steps of the ladder, from their evidence, 0 to 1.
    """

    title: str
    added: str | None
    rmse: dict[str, float]
    heldout_rmse: dict[str, float]
    noise_ratio: dict[str, float]
    evidence: float
    probability: float
    heldout_noise_ratio: dict[str, float] = field(default_factory=dict)

    def to_dict(self) -> dict[str, Any]:
        """Entry of ``ladder`` in the diagnosis contract, with a title for people."""
        entry = asdict(self)
        del entry["heldout_noise_ratio"]  # for people; the contract has not this key
        return entry


def steps_text(ladder: Sequence[Step], motion: MotionKind) -> str:
    """The error after each step, a line each, of a machine that turns or slides."""
    width = max(len(step.title) for step in ladder)
    return "\n".join(
        f"{step.title:{width}}  "
        + ", ".join(
            f"{name} {with_unit(name, rmse, motion)} ({step.noise_ratio[name]:.3g} times the noise)"
            for name, rmse in step.rmse.items()
        )
        for step in ladder
    )


def climb(fitted: Sequence[FittedStep]) -> tuple[Step, ...]:
    """Judge steps against one another.

    Where a step does not bring its evidence, it is found from its errors in units of the noise.
    Correlated errors count less: the samples of each signal are divided by the autocorrelation
    time of the last step's error, the whitest there is, and the same effective number of samples
    serves every step, so that

    ``evidence = sum over signals of samples log(mean square) + effective log(all samples)``.

    A parameter that stays with its prior costs nothing, as it explains nothing. Beside steps that
    bring their evidence, only the difference to the nearest of these is found so.

    Parameters
    ----------
    fitted : from the model as given to the last

    Returns
    -------
    tuple of Step, one for each step
    """
    evidence = _evidence(fitted)
    return tuple(
        Step(
            title=step.title,
            added=step.added,
            rmse=step.comparison.rmse(),
            heldout_rmse={} if step.heldout is None else step.heldout.rmse(),
            noise_ratio=step.comparison.noise_ratio(),
            evidence=value,
            probability=probability,
            heldout_noise_ratio={} if step.heldout is None else step.heldout.noise_ratio(),
        )
        for step, value, probability in zip(fitted, evidence, _probabilities(evidence), strict=True)
    )


def _evidence(fitted: Sequence[FittedStep]) -> list[float]:
    """Evidence of each step in one scale, that of the steps that bring theirs."""
    known = {index: step.evidence for index, step in enumerate(fitted) if step.evidence is not None}
    if len(known) == len(fitted):
        return list(known.values())
    counts = _effective_counts(fitted[-1].comparison)
    found = [
        _deviance(step.comparison, counts) + step.effective * log(sum(counts.values()))
        for step in fitted
    ]

    def shift(place: int) -> float:
        nearest = min(known, key=lambda index: (abs(index - place), -index))
        return known[nearest] - found[nearest]

    if not known:
        return found
    return [known.get(place, value + shift(place)) for place, value in enumerate(found)]


def _probabilities(evidence: Sequence[float]) -> list[float]:
    least = min(evidence)
    weights = [exp(-0.5 * min(value - least, 1400.0)) for value in evidence]
    return [weight / sum(weights) for weight in weights]


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
        mean_square = float(np.mean(np.concatenate(errors) ** 2)) / floors[name] ** 2
        deviance += counts[name] * log(max(mean_square, LEAST_SHARE_OF_NOISE**2))
    return deviance
