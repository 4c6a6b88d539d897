"""What a fitted model errs on recordings that it was not fitted to."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.comparison.residuals import Array, noise_floors, stack
from elastic_tendon.diagnosis.candidates import stops_shown
from elastic_tendon.errors import ElasticTendonError
from elastic_tendon.estimation.descent import descend
from elastic_tendon.estimation.fit import FitResult
from elastic_tendon.estimation.problem import Problem, Sigmas
from elastic_tendon.measurement import Measurement

# evaluations of the errors, and fall of the cost at which the move ends: what differs smoothly is
# met by a step or two; who goes on has to explain all, or it would only be fitted to these data
FEW, MANY, TOLERANCE = 3, 30, 1e-3
AT_NOISE = 1.02  # mean square that no move has to lower
EXPLAINED = 2.0  # ... and that a long one has to reach


def heldout_errors(result: FitResult, recordings: Sequence[Measurement]) -> Array:
    """Errors on held-out recordings, as the fit predicts them with what it leaves open.

    The fitted recordings may hardly show a parameter on which others depend; that is no failure of
    the law. So parameters are fitted again, with what the fit says of them as their prior, and the
    cost of the move counts as errors do: what the fit has determined stays. Each recording gives
    its initial state on its first 0.1 s.

    Parameters
    ----------
    result : of a fit to other recordings
    recordings : with the same signals

    Returns
    -------
    (n,) array in units of the noise; one infinite value where the model cannot follow
    """
    problem = replace(result.problem, measurements=tuple(recordings))
    floors = tuple(map(noise_floors, recordings))
    try:
        errors = stack(problem.errors(problem.start(result.model)), floors)
    except ElasticTendonError:
        return np.array([np.inf])
    if _square(errors) < AT_NOISE * len(errors):
        return errors
    shown = stops_shown(result.model, result.problem.measurements, recordings)
    ways = [({}, FEW), ({}, MANY), (shown, MANY)]
    if not _explains(result):
        ways = ways[:1]  # nor will it explain these
    for values, evaluations in ways:
        with suppress(ElasticTendonError, np.linalg.LinAlgError):
            start = result.model.with_values(values)
            moved, costly = _moved(result, problem, start, evaluations)
            found = costly * stack(problem.errors(moved), floors)
            if evaluations == FEW or _square(found) < EXPLAINED * len(found):
                errors = min(errors, found, key=_square)
        if _square(errors) < EXPLAINED * len(errors):
            break
    return errors


def _moved(
    result: FitResult, problem: Problem, model: Model, evaluations: int
) -> tuple[Array, float]:
    """Vector of the held-out problem with its parameters fitted again, from a model on, and the
    factor by which errors there grow when the cost of the move is among them."""
    count = len(problem.coordinates.paths)
    sigmas = _sigmas(result, problem.measurements)
    values, vectors = np.linalg.eigh(_information(result))
    known = (vectors * np.sqrt(np.maximum(values, 0.0))).T
    lower, upper = problem.bounds()
    fitted = result.problem.numbers(result.vector)

    def vector(numbers: Array) -> Array:
        return problem.start(problem.coordinates.model(numbers))

    def residuals(numbers: Array) -> Array:
        moved = known @ (numbers - fitted)
        try:
            return np.concatenate([stack(problem.errors(vector(numbers)), sigmas), moved])
        except ElasticTendonError:
            return np.array([np.inf])

    def jacobian(numbers: Array) -> Array:
        slopes = problem.data_jacobian(vector(numbers), sigmas)[:, :count]
        return np.vstack([slopes @ problem.coordinates.derivatives(numbers), known])

    start, bounds = problem.numbers(problem.start(model)), (lower[:count], upper[:count])
    numbers, _ = descend(residuals, jacobian, start, bounds, evaluations, TOLERANCE)
    move, left = known @ (numbers - fitted), _square(residuals(numbers)[:-count])
    return vector(numbers), float(np.sqrt(1.0 + move @ move / max(left, 1e-300)))


def _explains(result: FitResult) -> bool:
    """Whether a fit leaves little but noise of what it was fitted to."""
    floors = tuple(map(noise_floors, result.problem.measurements))
    errors = stack(result.problem.errors(result.vector), floors)
    return _square(errors) < EXPLAINED * len(errors)


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
