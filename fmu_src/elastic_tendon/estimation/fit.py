"""Fit a model's uncertain parameters to measurements.

Least squares on whitened errors with the exact sensitivities of the compiled library. The prior
of every parameter takes part, so that a direction which the data leave open stays where it was.

How the data weigh against the prior is decided by the errors themselves (`effective_sigma`). With
a sigma taken from the errors, minimising the sum of squares and renewing sigma in turn minimises
N_eff log(sum of squares) + prior, so the rounds below converge.
"""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from operator import itemgetter
from typing import TYPE_CHECKING, Any

import numpy as np

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.comparison.residuals import Array, InitialState, noise_floors, stack
from elastic_tendon.errors import SimulationError
from elastic_tendon.estimation.coordinates import Limits, free_parameters
from elastic_tendon.estimation.descent import descend
from elastic_tendon.estimation.determinability import Findings, findings
from elastic_tendon.estimation.problem import FINER, Problem, Sigmas, problem_of
from elastic_tendon.estimation.segments import COUNTS, in_segments, promise_less
from elastic_tendon.measurement import CLEARLY_LESS, Recordings, listed
from elastic_tendon.result import Result, plain
from elastic_tendon.simulation.work import worked

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

ShareProgress = Callable[[float], object]  # share of the work done, 0 to 1

SIGMA_TOLERANCE = 0.02  # sigmas that change less than this leave the optimum where it is
COST_TOLERANCE = 1e-8
# a start on a bound is moved inside so far, in prior sigmas: at its null an effect may have no
# derivative
START_MARGIN = 1e-6
# a parameter this close to its bound or its given value, in prior sigmas, is at it ...
BOUND_TOLERANCE = 1e-5
GIVEN_TOLERANCE = 1e-3
# ... if putting it there raises the cost by no more than this, and this share of it
SETTLING_COST = 1e-6
# a start that scouting leaves with so many times the least cost is not followed to the end
HOPELESS = 10.0
GLANCE = 8  # evaluations after which it shows whether a fit comes to anything


@dataclass(frozen=True)
class Effort:
    """How long a fit searches.

    `scouted` : so many starts, those of least cost first, are followed for `scouting` evaluations,
    enough to tell a good basin from a bad one; `polished` of them to the end beside the best.
    `evaluations` : of one descent. `rounds` : in which sigmas are renewed. `tolerance` : relative
    fall of the cost at which a descent ends. `most` : multiplications, see `work`, after which
    descents end where they are. `hopeless` : mean square error, in the noise's, from which a fit
    ends after `GLANCE` evaluations of its descent. `in_segments` : whether it begins once more from
    segments of the recordings where these promise less, see `segments`.
    """

    scouted: int
    scouting: int
    polished: int
    evaluations: int
    rounds: int
    tolerance: float = COST_TOLERANCE
    most: float = np.inf
    hopeless: float = np.inf
    in_segments: bool = False


THOROUGH = Effort(scouted=100, scouting=8, polished=2, evaluations=60, rounds=5, in_segments=True)
QUICK = Effort(scouted=3, scouting=6, polished=0, evaluations=20, rounds=2)
OF_SEGMENTS = Effort(scouted=2, scouting=4, polished=0, evaluations=8, rounds=0)
UNSEEN = 0.01  # share of the mean square error that the solver's own may have
REMEMBERED = 64  # vectors whose errors are kept
AT_NOISE = 1.05  # mean square, in the noise's, that leaves nothing for other inputs to explain


@dataclass(frozen=True, repr=False)
class FitResult(Result):
    """A fitted model and what the data say about its parameters.

    `model` carries the fitted values and still the given uncertainties; `given` is the model the
    prior is centred on. `initial_states` has one entry for each recording. `cost` is half the sum
    of squares of whitened errors and prior under `sigmas`, `start_cost` the least of it among the
    starts. `interrupted`: stopped by the user, holds the best so far.
    """

    given: Model
    model: Model
    problem: Problem
    vector: Array
    sigmas: Sigmas
    cost: float
    start_cost: float
    interrupted: bool

    @cached_property
    def derivatives(self) -> Array:
        """Of the residuals, errors and prior, by the vector, (N + m, m + s f).

        Raises
        ------
        SimulationError : the motion is unstable there
        """
        return self.problem.jacobian(self.vector, self.sigmas)

    def summary(self) -> str:
        """Every parameter as given and as fitted."""
        return f"{self.model.name}, fitted\n{self.findings.summary()}"

    def to_dataframe(self) -> "pd.DataFrame":
        """Every parameter as given and as fitted, with its 95 % interval, a row each, SI."""
        return self.findings.to_dataframe()

    def to_dict(self) -> dict[str, Any]:
        """Parameters as in the contract of a diagnosis, and the model."""
        found = self.findings
        return {
            "parameters": plain([asdict(estimate) for estimate in found.estimates]),
            "parameters_of_recordings": plain([asdict(part) for part in found.of_recordings]),
            "model": self.model.model_dump(mode="json", exclude_none=True),
        }

    def plot(self) -> "Figure":
        """Draw how far each parameter moved, with its 95 % interval, beside what was known."""
        from elastic_tendon.reports.estimates_figure import estimates_figure

        return estimates_figure(self)

    @cached_property
    def findings(self) -> Findings:
        """What the data say about each parameter; worked out when it is asked for."""
        return findings(self.problem, self.vector, self.sigmas)

    @property
    def initial_states(self) -> list[InitialState]:
        """Fitted state at the first sample of each recording, rad and rad/s."""
        return self.problem.initial_states(self.vector)


@dataclass(frozen=True)
class _Remembering(Problem):
    """A problem that does not simulate its starts anew each time that they are weighed."""

    known: dict[bytes, list[dict[str, Array]] | SimulationError] = field(
        default_factory=dict, compare=False
    )

    def errors(self, vector: Array) -> list[dict[str, Array]]:
        key = vector.tobytes()
        if key not in self.known:
            while len(self.known) >= REMEMBERED:
                del self.known[next(iter(self.known))]
            try:
                self.known[key] = super().errors(vector)
            except SimulationError as failure:
                self.known[key] = failure
        found = self.known[key]
        if isinstance(found, SimulationError):
            raise found
        return found


@dataclass
class _Search:
    """One run of the optimiser under given sigmas; remembers the best vector it has met."""

    problem: Problem
    sigmas: Sigmas
    best: Array
    end: float  # multiplications after which descents end
    best_cost: float = np.inf
    lower: Array = field(init=False)
    upper: Array = field(init=False)

    def __post_init__(self) -> None:
        self.lower, self.upper = self.problem.bounds()

    def residuals(self, vector: Array) -> Array:
        values = self.problem.residuals(vector, self.sigmas)
        cost = 0.5 * float(values @ values)
        if cost < self.best_cost:
            self.best, self.best_cost = vector.copy(), cost
        return values

    def jacobian(self, vector: Array) -> Array:
        if worked() > self.end:
            raise SimulationError("enough was simulated")
        return self.problem.jacobian(vector, self.sigmas)

    def cost(self, vector: Array) -> float:
        values = self.residuals(vector)
        return 0.5 * float(values @ values)

    def offer(self, vectors: Sequence[Array]) -> None:
        """Let these take part in the choice of the best."""
        for vector in vectors:
            self.cost(np.clip(vector, self.lower, self.upper))

    def renew(self) -> bool:
        """Take the sigmas that the best vector calls for; false if they are the same already."""
        sigmas = self.problem.sigmas(self.best)
        ratios = [
            new[name] / old[name]
            for new, old in zip(sigmas, self.sigmas, strict=True)
            for name in new
        ]
        self.sigmas = sigmas
        self.best_cost = np.inf
        self.cost(self.best)
        return max(abs(ratio - 1.0) for ratio in ratios) > SIGMA_TOLERANCE

    def descend(self, start: Array, evaluations: int, tolerance: float) -> tuple[Array, float]:
        """Local optimum near a start, or as far as this many evaluations lead."""
        margin = np.minimum(START_MARGIN, 0.1 * (self.upper - self.lower))
        inside = np.clip(start, self.lower + margin, self.upper - margin)
        if not np.isfinite(self.cost(inside)):
            return inside, np.inf
        try:
            return descend(
                self.residuals,
                self.jacobian,
                inside,
                (self.lower, self.upper),
                evaluations,
                tolerance,
            )
        except SimulationError:  # derivatives can fail where the trajectory itself does not
            return inside, np.inf

    def settle(self, vector: Array) -> Array:
        """Put parameters exactly to their bound or given value where that costs nothing."""
        coordinates = self.problem.coordinates
        count = len(coordinates.paths)
        variables = vector[:count].copy()
        for bound in (self.lower[:count], self.upper[:count]):
            near = np.abs(variables - bound) < BOUND_TOLERANCE
            variables[near] = bound[near]
        values = coordinates.values(variables)
        kept = np.abs(values - coordinates.centre) < GIVEN_TOLERANCE * coordinates.sigma
        values[kept] = coordinates.centre[kept]
        settled = np.concatenate([coordinates.variables(values), vector[count:]])
        allowed = self.cost(vector) * (1.0 + SETTLING_COST) + SETTLING_COST
        return settled if self.cost(settled) <= allowed else vector


def fit(
    given: Model,
    measurements: Recordings,
    *,
    free: Sequence[str] | None = None,
    starts: Sequence[Model] = (),
    limits: Limits | None = None,
    effort: Effort = THOROUGH,
    progress: ShareProgress = lambda _share: None,
) -> FitResult:
    """Fit free parameters and every recording's initial state.

    The result is never worse, in cost, than any start.

    Parameters
    ----------
    given : Model; centre of the prior and, unless limits shut it out, first start
    measurements : one or several, fitted together
    free : dotted paths of the parameters to fit; None: all that have an uncertainty
    starts : further models with the same effects to start from
    limits : bounds by dotted path, beside those of the quantities
    effort : how long to search
    progress : called with the share of the work done, 0 to 1

    Returns
    -------
    FitResult

    Raises
    ------
    SimulationError : not even the given model can be simulated
    """
    measurements = listed(measurements)
    paths = free_parameters(given) if free is None else tuple(free)
    problem = problem_of(given, measurements, paths, limits)
    if not any(part.has_assumed_curves for part in measurements):
        return _solved(problem, given, starts, effort, progress)
    found = _solved(problem, given, starts, effort, lambda share: progress(share / 2.0))
    left = found.problem.mean_square(found.vector)
    if found.interrupted or left <= AT_NOISE:
        progress(1.0)
        return found
    straight = [part.with_straight_inputs() for part in measurements]
    problem = problem_of(given, straight, paths, limits)
    starts = [*starts, found.model]
    again = _solved(problem, given, starts, effort, lambda share: progress(0.5 + share / 2.0))
    better = again.problem.mean_square(again.vector) < CLEARLY_LESS * left
    return again if better else found


def _solved(
    problem: Problem,
    given: Model,
    starts: Sequence[Model],
    effort: Effort,
    progress: ShareProgress,
) -> FitResult:
    """A fit; again under a finer solver where the solver errs visibly beside what remains."""
    end = worked() + effort.most
    found = _fitted(problem, given, starts, effort, end, progress)
    if not found.interrupted and effort.in_segments and promise_less(problem, found.vector):
        found = _from_segments(found, starts, effort, end, lambda _share: progress(1.0))
    if found.interrupted:
        return found
    finer = replace(problem, tolerance=FINER * problem.tolerance)
    if not _differs(found, finer):
        return found
    again = [*starts, found.model]
    try:
        return _fitted(finer, given, again, effort, end, lambda _share: progress(1.0))
    except SimulationError:  # it would take far too many steps wherever the fit may be
        return found


def _from_segments(
    found: FitResult,
    starts: Sequence[Model],
    effort: Effort,
    end: float,
    progress: ShareProgress,
) -> FitResult:
    """A fit, or a better one of the whole recordings from where segments of rising length lead."""
    problem, begun = found.problem, [*starts, found.model]
    try:
        for count in COUNTS:
            segments = in_segments(problem, count)
            part = _fitted(segments, found.given, begun, OF_SEGMENTS, end, progress)
            if part.interrupted:
                return replace(found, interrupted=True)
            begun = [part.model]
    except SimulationError:  # from where some segment begins
        return found
    return _fitted(problem, found.given, [found.model, *begun], effort, end, progress)


def _differs(found: FitResult, finer: Problem) -> bool:
    """Whether a finer solver shows visibly other errors, or cannot follow."""
    floors = tuple(noise_floors(measurement) for measurement in finer.measurements)
    try:
        coarse, fine = (stack(part.errors(found.vector), floors) for part in (found.problem, finer))
    except SimulationError:
        return True
    return bool(np.mean((coarse - fine) ** 2) > UNSEEN * np.mean(coarse**2))


def _fitted(
    problem: Problem,
    given: Model,
    starts: Sequence[Model],
    effort: Effort,
    end: float,
    progress: ShareProgress,
) -> FitResult:
    """A fit under one solver; `end` : multiplications after which descents end."""
    remembering = _Remembering(problem.coordinates, problem.measurements, problem.tolerance)
    vectors = _starting_vectors(problem, given, starts)
    search = _Search(remembering, _closest_sigmas(remembering, vectors), vectors[0], end)
    interrupted = False
    try:
        _run(search, vectors, effort, progress)
    except KeyboardInterrupt:
        interrupted = True
    vector = search.settle(search.best)
    return FitResult(
        given=given,
        model=problem.model_with_recordings(vector),
        problem=problem,
        vector=vector,
        sigmas=search.sigmas,
        cost=search.cost(vector),
        start_cost=min(search.cost(start) for start in vectors),
        interrupted=interrupted,
    )


def _starting_vectors(problem: Problem, given: Model, starts: Sequence[Model]) -> list[Array]:
    """Where a fit begins. The given model has no part in it where the limits shut it out and there
    are other starts: a mass of nothing, moved inside, would swing endlessly fast."""
    first = problem.start(given)
    vectors = []
    for model in starts:
        with suppress(SimulationError):  # a start that cannot be simulated is no start
            vectors.append(problem.start(model))
    lower, upper = problem.bounds()
    outside = bool(np.any((first < lower) | (first > upper)))
    return vectors if outside and vectors else [first, *vectors]


def _closest_sigmas(problem: Problem, vectors: Sequence[Array]) -> Sigmas:
    """Sigmas of the start that errs least: data weigh against the prior by what they can reach."""
    floors = tuple(noise_floors(measurement) for measurement in problem.measurements)
    return problem.sigmas(
        min(vectors, key=lambda vector: float(np.sum(problem.residuals(vector, floors) ** 2))),
        independent=True,
    )


def _run(search: _Search, starts: Sequence[Array], effort: Effort, progress: ShareProgress) -> None:
    """Scout under samples taken as independent, then settle under what they really tell.

    Scouting lets the data overrule the prior, so that a parameter that is far off is found; the
    rounds then weigh data and prior by the effective number of samples, and return what only the
    lack of fit had moved.
    """
    promising = sorted(starts, key=search.cost)[: effort.scouted]
    steps = len(promising) + effort.polished + 1 + effort.rounds
    done = 0

    def descend(start: Array, evaluations: int) -> tuple[Array, float]:
        nonlocal done
        found = search.descend(start, evaluations, effort.tolerance)
        done += 1
        progress(min(done / steps, 1.0))
        return found

    search.offer(starts)
    scouted = sorted((descend(start, effort.scouting) for start in promising), key=itemgetter(1))
    evaluations = effort.evaluations
    if np.isfinite(effort.hopeless) and evaluations > GLANCE:
        descend(search.best, GLANCE)
        evaluations -= GLANCE
        if search.problem.mean_square(search.best) > effort.hopeless:
            progress(1.0)
            return
    descend(search.best, evaluations)
    for index in range(effort.rounds):
        if not search.renew():
            break
        # under new sigmas another vector may be the best
        search.offer(starts)
        if index == 0:
            for vector, cost in scouted[: effort.polished]:
                if cost < HOPELESS * scouted[0][1]:
                    descend(vector, effort.evaluations)
        descend(search.best, effort.evaluations)
    progress(1.0)
