"""What a fitted model errs on recordings that it was not fitted to."""

from collections.abc import Sequence
from contextlib import suppress

import numpy as np

from elastic_tendon.comparison.residuals import Array, noise_floors, stack
from elastic_tendon.errors import ElasticTendonError
from elastic_tendon.estimation.fit import FitResult
from elastic_tendon.estimation.problem import Problem, Sigmas
from elastic_tendon.measurement import Measurement

REACHES = (1.0, 0.3)  # shares of the step that are tried


def heldout_errors(result: FitResult, recordings: Sequence[Measurement]) -> Array:
    """Errors on held-out recordings, as the fit predicts them with what it leaves open.

    The fitted recordings may hardly show a parameter on which others depend; that is no failure of
    the law. So parameters move by one step of Gauss and Newton, with what the fit says of them as
    their prior, and the cost of the move counts as errors do: what the fit has determined stays.
    Each recording gives its initial state on its first 0.1 s.

    Parameters
    ----------
    result : of a fit to other recordings
    recordings : with the same signals

    Returns
    -------
    (n,) array in units of the noise; one infinite value where the model cannot follow
    """
    problem = Problem(result.problem.coordinates, tuple(recordings))
    floors = tuple(map(noise_floors, recordings))
    try:
        start = problem.start(result.model)
        best = stack(problem.errors(start), floors)
    except ElasticTendonError:
        return np.array([np.inf])
    unmoved = best
    for share in REACHES:
        with suppress(ElasticTendonError, np.linalg.LinAlgError):
            moved, costly = _moved(result, problem, start, share)
            best = min(best, costly * stack(problem.errors(moved), floors), key=_square)
        if best is not unmoved:
            break
    return best


def _moved(result: FitResult, problem: Problem, start: Array, share: float) -> tuple[Array, float]:
    """Vector of the held-out problem after a share of the step, and the factor by which errors
    there grow when the cost of the move is among them."""
    count = len(problem.coordinates.paths)
    sigmas = _sigmas(result, problem.measurements)
    errors = stack(problem.errors(start), sigmas)
    slopes = problem.data_jacobian(start, sigmas)[:, :count]
    slopes = slopes @ problem.coordinates.derivatives(start[:count])
    known = _information(result)
    step = np.linalg.solve(slopes.T @ slopes + known, slopes.T @ errors)
    lower, upper = problem.bounds()
    numbers = np.clip(start[:count] - share * step, lower[:count], upper[:count])
    moved = problem.start(problem.coordinates.model(numbers))
    left = _square(stack(problem.errors(moved), sigmas))
    move = numbers - start[:count]
    return moved, float(np.sqrt(1.0 + move @ known @ move / max(left, 1e-300)))


def _information(result: FitResult) -> Array:
    """What fit and prior say of the m parameters, (m, m), whatever the initial states."""
    count = len(result.problem.coordinates.paths)
    slopes = result.derivatives
    whole = slopes.T @ slopes
    beside = whole[:count, count:]
    inner = whole[count:, count:] + 1e-12 * np.trace(whole) * np.eye(len(whole) - count)
    return np.asarray(whole[:count, :count] - beside @ np.linalg.solve(inner, beside.T))


def _sigmas(result: FitResult, recordings: Sequence[Measurement]) -> Sigmas:
    """Of held-out recordings: as many times their noise as the fit gives the fitted ones."""
    fitted = [noise_floors(part) for part in result.problem.measurements]
    ratios = {
        name: float(np.mean([own[name] / floor[name] for own, floor in pairs]))
        for name in result.sigmas[0]
        for pairs in [[(s, f) for s, f in zip(result.sigmas, fitted, strict=True) if name in s]]
    }
    return tuple(
        {name: ratios.get(name, 1.0) * floor for name, floor in noise_floors(part).items()}
        for part in recordings
    )


def _square(errors: Array) -> float:
    return float(errors @ errors)
