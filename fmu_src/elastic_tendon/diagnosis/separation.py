"""How well one experiment tells rival answers apart.

If rival A is right, the recording will be what A simulates, and rival B will be refitted to it. The
refit is held by what B was fitted to already, data and prior together. What of the difference no
refit removes, squared in units of the noise, is the noncentrality of the difference in deviance
that the experiment will show (T-optimality: Atkinson & Fedorov 1975).
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular
from scipy.optimize import least_squares
from scipy.stats import ncx2

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.variables import moved_states
from elastic_tendon.comparison.residuals import (
    Array,
    InitialState,
    residuals_of,
    sensitivity,
    simulate_measurement,
    stack,
)
from elastic_tendon.diagnosis.driving import at_rest
from elastic_tendon.diagnosis.evidence import DECISIVE_IN_PLACE
from elastic_tendon.errors import ModelError, SimulationError
from elastic_tendon.estimation.coordinates import Coordinates
from elastic_tendon.estimation.fit import FitResult
from elastic_tendon.estimation.problem import Problem
from elastic_tendon.measurement import Measurement

EVALUATIONS = 15  # of a refit that checks a prediction
SEED, DRAWS = 20130507, 24  # parameters of a rival that its data leave likely
TINY = 1e-12  # noncentrality of what does not differ at all
FREE = 1e-12  # information on a state that no data determine: next to none
ALIKE = 10.0  # times as surely as the prior says it, rivals have what their data leave open alike


@dataclass(frozen=True)
class Rival:
    """An answer and the model fitted to the data at hand with it."""

    id: str
    fit: FitResult


@dataclass(frozen=True)
class Known:
    """A rival with what the data at hand say about it.

    `root` (m + k, m + k) : its square is the information on the fit's variables, then on the k
    numbers of an initial state yet unknown. `variables` (m,) : of its fit, what the data leave open
    as another rival has it; `model` : of these. `initial` : at rest at the start of the experiment.
    """

    rival: Rival
    root: Array
    variables: Array
    model: Model
    initial: InitialState

    @property
    def coordinates(self) -> Coordinates:
        """Of its fit."""
        return self.rival.fit.problem.coordinates


@dataclass(frozen=True)
class Prediction:
    """What a rival expects of an experiment, divided by the noise.

    `signals` (N,), all signals one after the other; `jacobian` (N, m + k) to the fit's variables
    and the initial state.
    """

    signals: Array
    jacobian: Array


def known(rival: Rival, start: float, like: Known | None = None) -> Known:
    """Gather what the data at hand say about a rival.

    Parameters
    ----------
    rival : Rival
    start : where the motor rests, or a link without springs, before an experiment, rad
    like : another, whose parameters it takes where its own data leave them open: two that differ
        there, as in a scale that nothing has told yet, say nothing different by that

    Returns
    -------
    Known

    Raises
    ------
    SimulationError : the rival cannot be simulated from there
    """
    fit = rival.fit
    count = len(fit.problem.coordinates.paths)
    jacobian = fit.problem.jacobian(fit.vector, fit.sigmas)
    # the states of the recordings come first, so that what is left below them is free of them
    ordered = np.hstack([jacobian[:, count:], jacobian[:, :count]])
    own = jacobian.shape[1] - count
    upper = np.asarray(np.linalg.qr(ordered, mode="r"))
    root = np.sqrt(FREE) * np.eye(count + len(moved_states(fit.model.kind)))
    root[:count, :count] = upper[own:, own:]
    variables, model = fit.problem.numbers(fit.vector), fit.model
    if like is not None:
        with suppress(ModelError):
            moved = _alike(fit.problem.coordinates, variables, root[:count, :count], like)
            variables, model = moved, fit.problem.coordinates.model(moved)
    return Known(rival, root, variables, model, at_rest(model, start))


def _alike(coordinates: Coordinates, variables: Array, root: Array, like: Known) -> Array:
    """Variables (m,) moved towards those of another rival as far as the data leave them open."""
    theirs = dict(zip(like.coordinates.paths, like.variables.tolist(), strict=True))
    goal = np.array([theirs.get(path, np.nan) for path in coordinates.paths])
    shared = np.flatnonzero(np.isfinite(goal))
    columns = np.vstack([root, ALIKE * np.eye(len(goal))[shared]])
    wanted = np.concatenate([np.zeros(len(root)), ALIKE * (goal - variables)[shared]])
    step = np.linalg.lstsq(columns, wanted, rcond=None)[0]
    return np.asarray(np.clip(variables + step, *coordinates.bounds()))


def predict(rival: Known, experiment: Measurement, sigmas: dict[str, float]) -> Prediction:
    """Signals that a rival expects, and how a refit could change them.

    Parameters
    ----------
    rival : Known
    experiment : its signals are zero
    sigmas : signal -> noise of one sample, the signal's unit

    Returns
    -------
    Prediction

    Raises
    ------
    SimulationError : the solver could not go on
    """
    coordinates, variables = rival.coordinates, rival.variables
    paths = coordinates.of_model
    found = sensitivity(rival.model, experiment, rival.initial, paths)
    slopes = stack([found.derivatives], [sigmas])
    by_parameter = coordinates.columns(slopes[:, : len(paths)], experiment.name)
    moved = by_parameter @ coordinates.derivatives(variables)
    jacobian = np.hstack([moved, slopes[:, len(paths) :]])
    return Prediction(stack([found.residuals], [sigmas]), jacobian)


def plausible(rival: Known, experiment: Measurement, sigmas: dict[str, float]) -> list[Array]:
    """Signals that a rival expects with other parameters that the data at hand leave likely.

    A weak effect is fitted too strong as often as too weak; what a fit promises is then not what
    an experiment shows.

    Parameters
    ----------
    rival, experiment, sigmas : as in `predict`

    Returns
    -------
    list of (N,) arrays, divided by the noise; one for each draw that can be simulated
    """
    coordinates, variables = rival.coordinates, rival.variables
    count = len(variables)
    lower, upper = coordinates.bounds()
    drawn = np.random.default_rng(SEED).standard_normal((count, DRAWS))
    # away from the optimum by what has this information
    away = solve_triangular(rival.root[:count, :count], drawn)
    found = []
    for column in away.T:
        with suppress(ModelError, SimulationError):
            model = coordinates.model(np.clip(variables + column, lower, upper))
            trajectory = simulate_measurement(model, experiment, rival.initial)
            found.append(stack([residuals_of(trajectory, experiment)], [sigmas]))
    return found


def left_over(right: Array, wrong: Prediction, known_of_wrong: Known) -> float:
    """Squared difference, in units of the noise, that a linear refit of the wrong leaves.

    Parameters
    ----------
    right : (N,) array, signals divided by the noise
    wrong, known_of_wrong : of the rival that is refitted to them
    """
    difference = right - wrong.signals
    gradient = wrong.jacobian.T @ difference
    root = known_of_wrong.root
    information = wrong.jacobian.T @ wrong.jacobian + root.T @ root
    removed = float(gradient @ np.linalg.lstsq(information, gradient, rcond=None)[0])
    return max(float(difference @ difference) - removed, 0.0)


@dataclass(frozen=True)
class Refit:
    """A rival refitted to what another one predicts.

    `noncentrality` : what is left, that held by the data at hand included. `difference` (N,) :
    what is left of the signals, in units of the noise of one sample.
    """

    noncentrality: float
    difference: Array


def refit(
    right: Prediction, wrong: Known, experiment: Measurement, sigmas: dict[str, float]
) -> Refit:
    """Refit the wrong rival, in full, to what the right one predicts.

    Parameters
    ----------
    right : Prediction for the experiment
    wrong : Known
    experiment : its signals are zero
    sigmas : signal -> noise of one sample, the signal's unit

    Returns
    -------
    Refit
    """
    problem = Problem(wrong.coordinates, (experiment,))
    initial = wrong.initial.as_dict(wrong.model.kind)
    start = np.append(wrong.variables, list(initial.values()))

    def residuals(vector: Array) -> Array:
        try:
            signals = stack(problem.errors(vector), [sigmas])
        except (ModelError, SimulationError):
            signals = np.full(len(right.signals), np.inf)
        return np.concatenate([signals - right.signals, wrong.root @ (vector - start)])

    def jacobian(vector: Array) -> Array:
        data = problem.jacobian(vector, (sigmas,))[: len(right.signals)]
        return np.vstack([data, wrong.root])

    lower, upper = problem.bounds()
    inside = np.clip(start, lower + 1e-9, upper - 1e-9)
    try:
        solution = least_squares(
            *(residuals, inside, jacobian),
            bounds=(lower, upper),
            x_scale="jac",
            max_nfev=EVALUATIONS,
        )
        values = solution.fun
    except SimulationError:  # derivatives can fail where the trajectory itself does not
        values = residuals(inside)
    return Refit(float(values @ values), values[: len(right.signals)])


def power(noncentrality: float) -> float:
    """Probability that the deviance will differ by more than what decides, 0 to 1."""
    return float(ncx2.sf(DECISIVE_IN_PLACE, 1, noncentrality))


def expected_power(
    right: Sequence[Array], fitted: Array, wrong: Prediction, known_of_wrong: Known, full: float
) -> float:
    """Power over all that the right rival may expect, never more than as it is fitted.

    The draws follow a prior that is wide for an effect, so strong effects would flatter the mean.

    Parameters
    ----------
    right : (N,) arrays, see `plausible`
    fitted : (N,) array, what it expects as fitted
    wrong, known_of_wrong : of the rival that is wrong
    full : noncentrality that a full refit leaves of `fitted`; the linear ones are scaled to it

    Returns
    -------
    float, 0 to 1
    """
    scale = full / max(left_over(fitted, wrong, known_of_wrong), TINY)
    powers = [power(scale * left_over(signals, wrong, known_of_wrong)) for signals in right]
    return min(power(full), float(np.mean(powers or [1.0])))


def noise(rivals: Sequence[Rival]) -> dict[str, float]:
    """Noise of one sample of each signal in all recordings, its unit.

    The least of what the rivals' errors call for: the right one leaves no more than noise. It
    holds the noise's autocorrelation, see `effective_sigma`.
    """
    found: list[dict[str, float]] = []
    for rival in rivals:
        sigmas = rival.fit.sigmas
        shared = set.intersection(*map(set, sigmas))
        names = [name for name in sigmas[0] if name in shared]
        found.append(
            {name: float(np.sqrt(np.mean([part[name] ** 2 for part in sigmas]))) for name in names}
        )
    return {name: min(part[name] for part in found) for name in found[0]}
