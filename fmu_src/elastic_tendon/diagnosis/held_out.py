"""What a fitted model errs on recordings that it was not fitted to."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from operator import is_not

import numpy as np

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.comparison.residuals import Array, noise_floors, rms, stack
from elastic_tendon.diagnosis.candidates import stops_shown
from elastic_tendon.errors import ElasticTendonError
from elastic_tendon.estimation.descent import descend
from elastic_tendon.estimation.fit import FitResult
from elastic_tendon.estimation.problem import Problem, Sigmas
from elastic_tendon.measurement import Measurement
from elastic_tendon.simulation.work import AFFORDABLE, Work, counted, worked

# evaluations of the errors, and fall of the cost at which the move ends: what differs smoothly is
# met by a step or two; who goes on has to explain all, or it would only be fitted to these data
FEW, MANY, TOLERANCE = 3, 30, 1e-3
ROUNDS = 10  # of few evaluations each, in which large errors come to count more and more
EXPLAINED = 2.0  # mean square that a long move has to reach, and that a dear one need not lower
TORN = 10.0  # rise of the fitted squares from which their initial states are fitted anew
# share of a mean square error of the joint that its median makes up where the machine was
# zeroed anew, and least median, in the noise's
OF_ZERO, SEEN = 0.9, 3.0


def heldout_errors(
    result: FitResult, recordings: Sequence[Measurement], hopeless: float = EXPLAINED
) -> Array:
    """Errors on held-out recordings, as the fit predicts them with what it leaves open.

    The fitted recordings may hardly show a parameter on which others depend; that is no failure of
    the law. So parameters are fitted again to all recordings, and what that costs on the fitted
    ones counts as errors do: what the fit has determined stays. Each recording gives its initial
    state on its first 0.1 s and, where the fitted ones are explained, another zero of the joint if
    that is most of what is erred.

    Parameters
    ----------
    result : of a fit to other recordings
    recordings : with the same signals
    hopeless : mean square of the fitted errors, in the noise's, from which no long move is made:
        who leaves so much there will not explain these either

    Returns
    -------
    (n,) array in units of the noise; one infinite value where the model cannot follow; no more than
    whoever expects the mean errs: beyond that, more says no more
    """
    with counted(Work()):  # how dear the refit was says nothing of what is judged
        errors = _judged(result, recordings, hopeless)
    return errors if np.isinf(errors).any() else min(errors, _about_mean(recordings), key=_square)


def _about_mean(recordings: Sequence[Measurement]) -> Array:
    signals = [
        {name: values - values.mean() for name, values in part.signals.items()}
        for part in recordings
    ]
    return stack(signals, tuple(map(noise_floors, recordings)))


def _judged(result: FitResult, recordings: Sequence[Measurement], hopeless: float) -> Array:
    fitted = result.problem
    coordinates = fitted.coordinates.with_recordings([part.recording for part in recordings])
    problem = replace(fitted, coordinates=coordinates, measurements=tuple(recordings))
    floors = tuple(map(noise_floors, recordings))
    left = fitted.mean_square(result.vector)
    try:
        first = problem.errors(problem.start(result.model))
        if left < EXPLAINED:  # else the fitted ones may err as much for their own zero
            zeroed = _as_zeroed(recordings, first)
            if any(map(is_not, zeroed, recordings)):
                problem = replace(problem, measurements=zeroed)
                first = problem.errors(problem.start(result.model))
        errors = stack(first, floors)
    except ElasticTendonError:
        return np.array([np.inf])

    def met(values: Mapping[str, float], rounds: int, evaluations: int) -> Array:
        """Errors after a move that begins with some values, the cost of the move among them."""
        try:
            start = result.model.with_values(values)
            moved, costly = _moved(result, problem, start, rounds, evaluations)
            return costly * stack(problem.errors(moved), floors)
        except (ElasticTendonError, np.linalg.LinAlgError):
            return np.full_like(errors, np.inf)

    best = min(errors, met({}, 1, FEW), key=_square)
    # thousands of samples tell a hundredth of the noise, so even these are met as well as can be
    dear = worked() * MANY / FEW > AFFORDABLE
    if left >= hopeless or (dear and _square(best) < EXPLAINED * len(best)):
        return best
    shown = stops_shown(result.model, result.problem.measurements, recordings)
    ways = [({}, 1, MANY), *((stops, 1, MANY) for stops in shown), ({}, ROUNDS, FEW)]
    for values, rounds, evaluations in ways:
        found = met(values, rounds, evaluations)
        if _square(found) < EXPLAINED * len(found):
            return min(best, found, key=_square)
    return best


def _as_zeroed(
    recordings: Sequence[Measurement], errors: Sequence[Mapping[str, Array]]
) -> tuple[Measurement, ...]:
    """Recordings as they would be with the joint's zero of the fitted ones, where little else is
    erred: a machine that was zeroed anew is the same machine."""
    names = [part.recording for part in recordings]
    found = []
    for part, error in zip(recordings, errors, strict=True):
        own = error.get("joint_position", np.zeros(1))
        zero, least = float(np.median(own)), SEEN * noise_floors(part).get("joint_position", np.inf)
        if names.count(part.recording) == 1 and abs(zero) > max(least, OF_ZERO**0.5 * rms(own)):
            position = {"joint_position": part.signals["joint_position"] + zero}
            part = replace(part, signals={**part.signals, **position})
        found.append(part)
    return tuple(found)


def _moved(
    result: FitResult, problem: Problem, model: Model, rounds: int, evaluations: int
) -> tuple[Array, float]:
    """Vector of the held-out problem with the parameters fitted to all recordings, from a model on,
    and the factor by which errors there grow when the cost of the move is among them."""
    fitted = result.problem
    coordinates = fitted.coordinates
    count = len(coordinates.paths)
    sigmas = _sigmas(result, problem.measurements)
    samples = sum(len(part.time) * len(part.signals) for part in problem.measurements)

    @lru_cache(maxsize=1)  # residuals and derivatives are asked for one after the other
    def beginning(*moved: float) -> Array:
        return problem.start(fitted.model(np.array(moved)))

    def vector(moved: Array) -> Array:
        return beginning(*moved)

    def residuals(moved: Array) -> Array:
        try:
            beyond = stack(problem.errors(vector(moved)), sigmas)
        except ElasticTendonError:
            beyond = np.full(samples, np.inf)
        return np.append(beyond, fitted.residuals(moved, result.sigmas))

    def jacobian(moved: Array) -> Array:
        own = fitted.jacobian(moved, result.sigmas)
        beyond = np.zeros((samples, own.shape[1]))
        slopes = problem.data_jacobian(vector(moved), sigmas)[:, :count]
        beyond[:, :count] = slopes @ coordinates.derivatives(fitted.numbers(moved))
        return np.vstack([beyond, own])

    moved = result.vector.copy()
    shared = len(coordinates.of_model)
    moved[:shared] = problem.start(model)[:shared]
    first = residuals(moved)
    weights = np.ones((len(first), 1))
    # a long move ends where it falls too slowly to explain all
    excess = max(_square(first[:samples]) / (EXPLAINED * samples), 1.0)
    least_fall = TOLERANCE if evaluations == FEW else max(1.0 - excess ** (-1 / MANY), TOLERANCE)

    def descended(start: Array, unit: float) -> Array:
        weights[:samples] = 1.0 / unit  # so large errors do not tear away what the fit determined
        return descend(
            lambda x: weights[:, 0] * residuals(x),
            lambda x: weights * jacobian(x),
            start, fitted.bounds(), evaluations, least_fall,
        )[0]  # fmt: skip

    def squares(moved: Array) -> tuple[float, float]:
        """Of the held-out errors, and by how much those of the fitted ones rose."""
        left, kept = np.split(residuals(moved), [samples])
        return max(_square(left), 1e-300), max(_square(kept) - 2.0 * result.cost, 0.0)

    for unit in np.geomspace(max(rms(first[:samples]), 1.0), 1.0, rounds + 1)[1:]:
        moved = descended(moved, unit)
    left, more = squares(moved)
    if more > TORN:  # large errors may have set a joint in motion that friction held
        back = np.concatenate([moved[:count], result.vector[count:]])
        if np.isfinite(residuals(back)).all():
            again = descended(back, 1.0)
            found = squares(again)
            if sum(found) < left + more:
                moved, (left, more) = again, found
    return vector(moved), float(np.sqrt(1.0 + more / left))


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
