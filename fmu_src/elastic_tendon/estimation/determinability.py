"""What the data say about each parameter, and which combinations they leave open.

The whitened derivatives of the errors, with initial states projected out and every parameter in
units of its prior's one sigma, are split by singular values. A direction whose singular value is
far below one moves the errors less than their own uncertainty while the prior is used up: the
data leave it open, and what the fit returns along it is the prior.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.quantity import unit_text
from elastic_tendon.comparison.residuals import Array, autocorrelation_time, stack
from elastic_tendon.effects.units import quotient
from elastic_tendon.estimation.coordinates import SPRINGS, declared_quantities, owner_of
from elastic_tendon.estimation.problem import Problem, Sigmas
from elastic_tendon.estimation.stretches import (
    FEWEST_STRETCHES,
    left_out,
    settling_samples,
    stretch_numbers,
)

if TYPE_CHECKING:
    import pandas as pd

INERTIA = "link.inertia"
CONFIDENCE = 1.959963984540054  # 95 % of a normal distribution lie within so many sigmas
# a direction along which data narrow the prior by less than half a percent is open
OPEN_SINGULAR_VALUE = 0.1
# a parameter is determined when the data at least halve its uncertainty, which is at most that of
# a uniform distribution over its bounds
DETERMINED_RATIO = 0.5
# share of an open direction, in logarithms, above which a parameter takes part in it
MEMBER = 0.05


@dataclass(frozen=True)
class Estimate:
    """One fitted parameter; `given`, `fitted`, `sigma` and `interval` (95 %) in its `unit`.

    `determined` is false where the data leave it, alone or in a combination, to the prior.
    `recording` : whose it is, where each of several has its own; the model's is the first's.
    """

    path: str
    unit: str
    given: float
    fitted: float
    sigma: float
    interval: tuple[float, float]
    determined: bool
    recording: str | None = None

    @property
    def name(self) -> str:
        """Its path, and whose it is."""
        return self.path if self.recording is None else f"{self.path} of {self.recording}"


@dataclass(frozen=True)
class Ratio:
    """A ratio that the data determine although they leave a common scale open; SI `unit`."""

    name: str
    unit: str
    value: float
    interval: tuple[float, float]


@dataclass(frozen=True)
class Findings:
    """Estimates of all free parameters, ratios where only these are determined, and sentences.

    `estimates` are the model's; `of_recordings` those that each of several recordings has of its
    own, as the zero of an encoder, the first's among them. `effective` is the count of parameters
    that the data determine, the rest staying with the prior: sum of s^2 / (s^2 + 1) over the
    singular values s.
    """

    effective: float
    estimates: tuple[Estimate, ...]
    ratios: tuple[Ratio, ...]
    sentences: tuple[str, ...]
    of_recordings: tuple[Estimate, ...] = ()

    @property
    def every(self) -> tuple[Estimate, ...]:
        """All estimates: of what each recording has of its own one for each, else the model's."""
        own = {estimate.path for estimate in self.of_recordings}
        shared = (estimate for estimate in self.estimates if estimate.path not in own)
        return (*shared, *sorted(self.of_recordings, key=lambda estimate: estimate.path))

    def summary(self) -> str:
        """Every parameter as given and as fitted, a line each."""
        width = max((len(estimate.name) for estimate in self.every), default=0)
        return "\n".join(
            f"{estimate.name:{width}} {estimate.given:.4g} → {estimate.fitted:.4g} "
            + unit_text(estimate.unit)
            + ("" if estimate.determined else " (open)")
            for estimate in self.every
        )

    def to_dataframe(self) -> "pd.DataFrame":
        """Every parameter as given and as fitted, with its 95 % interval, a row each, SI."""
        import pandas as pd

        return pd.DataFrame([asdict(estimate) for estimate in self.every])


@dataclass(frozen=True)
class OpenDirections:
    """Parameters that the data leave open, by dotted path.

    `silent`: each has no influence of its own. `scaled`: these may all grow by one common factor.
    `traded`: within each group one may grow where another falls.
    """

    silent: tuple[str, ...]
    scaled: tuple[str, ...]
    traded: tuple[tuple[str, ...], ...]

    def all(self) -> set[str]:
        """Every path that takes part in an open direction."""
        return {*self.silent, *self.scaled, *(path for group in self.traded for path in group)}


def findings(problem: Problem, vector: Array, sigmas: Sigmas) -> Findings:
    """Judge a fitted vector.

    How far the data let each estimate scatter is seen by leaving out stretches of time, which
    holds for noise of any colour; what the prior adds is known. With too few stretches the sigmas
    of the errors, which hold their size and their autocorrelation, stand in.

    Parameters
    ----------
    problem : Problem with m free parameters
    vector : (m + s f,) array, the optimum
    sigmas : weights of the errors at the optimum

    Returns
    -------
    Findings
    """
    coordinates = problem.coordinates
    count = len(coordinates.paths)
    jacobian = problem.data_jacobian(vector, sigmas)
    data = _project_out(jacobian[:, :count] * coordinates.sigma, jacobian[:, count:])
    values = coordinates.values(problem.numbers(vector))
    covariance, quantile = _covariance(problem, vector, sigmas, data, jacobian)
    open_directions = find_open_directions(data, values / coordinates.sigma, coordinates.paths)
    shrinkage = np.sqrt(np.diag(covariance))
    every = _estimates(problem, values, shrinkage, quantile, open_directions)
    own = len(coordinates.of_model)
    estimates = every[:own]
    information = np.linalg.svd(data, compute_uv=False) ** 2
    return Findings(
        effective=float(np.sum(information / (information + 1.0))),
        estimates=estimates,
        ratios=_ratios(
            problem.model(problem.numbers(vector)),
            estimates,
            (covariance * np.outer(coordinates.sigma, coordinates.sigma))[:own, :own],
            open_directions,
        ),
        sentences=_sentences(problem, open_directions),
        of_recordings=tuple(part for part in every if part.recording is not None),
    )


def _covariance(
    problem: Problem, vector: Array, sigmas: Sigmas, data: Array, jacobian: Array
) -> tuple[Array, float]:
    """Covariance (m, m) in prior sigmas, and how many of its roots hold 95 % to either side.

    `data` (N, m) are the derivatives to the parameters with the initial states projected out.
    """
    count = data.shape[1]
    whole = _inverse(data)
    # what is at a bound does not follow the others: it might have to go beyond it
    free = problem.off_bounds(vector)
    kept = free[:count]
    whole[np.ix_(kept, kept)] = _inverse(data[:, kept])
    errors = problem.errors(vector)
    memory = max(
        min(autocorrelation_time(error), settling_samples(problem.model(vector), measurement))
        for measurement, of_signals in zip(problem.measurements, errors, strict=True)
        for error in of_signals.values()
    )
    numbers = stretch_numbers(problem.measurements, memory)
    if numbers.max() + 1 < FEWEST_STRETCHES // 2:
        return whole, CONFIDENCE
    prior = np.eye(jacobian.shape[1])[:count]
    columns = np.vstack([jacobian, prior])
    columns[: len(jacobian), :count] *= problem.coordinates.sigma
    values = problem.coordinates.values(problem.numbers(vector))
    shift = (values - problem.coordinates.centre) / problem.coordinates.sigma
    whitened = np.concatenate([stack(errors, sigmas), shift])
    moves = left_out(columns, whitened, numbers)
    moves[:, free] = left_out(columns[:, free], whitened, numbers)
    moves = moves[:, :count]
    blocks = len(moves)
    scattered = moves.T @ moves * ((blocks - 1) / blocks) + whole @ whole
    return scattered, float(student.ppf(0.975, blocks - 1))


def _inverse(data: Array) -> Array:
    """(data' data + 1)^-1, of data (N, m) and the prior; whatever the size of the data.

    From singular values: in the product of data without noise the prior would be lost.
    """
    with_prior = np.vstack([data, np.eye(data.shape[1])])
    _, singular, rows = np.linalg.svd(with_prior, full_matrices=False)
    return np.asarray((rows.T / singular**2) @ rows)


def _project_out(columns: Array, nuisance: Array) -> Array:
    """Part of each column (N, m) that no combination of the nuisance columns can imitate."""
    basis, singular, _ = np.linalg.svd(nuisance, full_matrices=False)
    basis = basis[:, singular > 1e-10 * singular.max(initial=1e-300)]
    return columns - basis @ (basis.T @ columns)


def find_open_directions(data: Array, relative: Array, paths: Sequence[str]) -> OpenDirections:
    """Name the combinations of parameters that the data do not determine.

    Parameters
    ----------
    data : (N, m) array, whitened derivatives of the errors to the parameters in prior sigmas
    relative : (m,) array, value of each parameter in its prior sigmas
    paths : names of the m parameters

    Returns
    -------
    OpenDirections
    """
    norms = np.linalg.norm(data, axis=0)
    silent = norms < OPEN_SINGULAR_VALUE
    # logarithms need a value; a parameter at zero keeps out of the combinations
    loud = np.flatnonzero(~silent & (relative != 0.0))
    basis = _open_basis(data[:, loud], relative[loud])
    members = loud[np.linalg.norm(basis, axis=1) > MEMBER] if len(loud) else loud
    scaled: Array = np.zeros(len(paths), dtype=bool)
    groups: list[tuple[str, ...]] = []
    if len(members) > 1 and _is_open(data[:, members] @ relative[members], relative[members]):
        # one common factor on all of them changes nothing
        scaled[members] = True
        common = np.isin(loud, members) / np.sqrt(len(members))
        rest = basis - np.outer(common, common @ basis)
        basis = np.linalg.svd(rest, full_matrices=False)[0][:, : basis.shape[1] - 1]
    for column in _sparse(basis).T:
        group = loud[np.abs(column) > MEMBER]
        if len(group) > 1:
            groups.append(_at(paths, group))
    return OpenDirections(
        silent=_at(paths, np.flatnonzero(silent)),
        scaled=_at(paths, np.flatnonzero(scaled)),
        traded=tuple(groups),
    )


def _at(paths: Sequence[str], indices: NDArray[np.int_]) -> tuple[str, ...]:
    return tuple(paths[int(index)] for index in indices)


def _open_basis(data: Array, relative: Array) -> Array:
    """Orthonormal basis (m, k), in logarithms of the parameters, of what the data leave open."""
    if data.shape[1] == 0:
        return np.zeros((0, 0))
    _, singular, rows = np.linalg.svd(data, full_matrices=False)
    directions = rows[singular < OPEN_SINGULAR_VALUE].T
    return _orthonormal(directions / relative[:, np.newaxis])


def _is_open(effect: Array, direction: Array) -> bool:
    return bool(np.linalg.norm(effect) < OPEN_SINGULAR_VALUE * np.linalg.norm(direction))


def _orthonormal(columns: Array) -> Array:
    if columns.size == 0:
        return columns
    basis, singular, _ = np.linalg.svd(columns, full_matrices=False)
    return basis[:, singular > 1e-6 * max(float(singular[0]), 1.0)]


def _sparse(basis: Array) -> Array:
    """The same space by vectors with few members: Gauss-Jordan on the largest entries."""
    reduced = basis.T.copy()
    for row in range(len(reduced)):
        pivot = int(np.argmax(np.abs(reduced[row])))
        if reduced[row, pivot] == 0.0:
            continue
        reduced[row] /= reduced[row, pivot]
        rest = np.arange(len(reduced)) != row
        reduced[rest] -= np.outer(reduced[rest, pivot], reduced[row])
    scale = np.max(np.abs(reduced), axis=1, keepdims=True, initial=0.0)
    return (reduced / np.where(scale > 0.0, scale, 1.0)).T


def _estimates(
    problem: Problem,
    values: Array,
    shrinkage: Array,
    quantile: float,
    open_directions: OpenDirections,
) -> tuple[Estimate, ...]:
    coordinates = problem.coordinates
    declared = declared_quantities(coordinates.given)
    open_paths = open_directions.all()
    estimates = []
    for index, path in enumerate(coordinates.paths):
        parameter, name = owner_of(path)
        first = coordinates.recordings[0] if parameter in coordinates.of_recording else None
        quantity = declared[parameter]
        allowed = (quantity.upper - quantity.lower) / np.sqrt(12.0)
        before = min(float(coordinates.sigma[index]), allowed)
        sigma = float(shrinkage[index] * coordinates.sigma[index])
        fitted = float(values[index])
        low = max(fitted - quantile * sigma, quantity.lower)
        high = min(fitted + quantile * sigma, quantity.upper)
        estimates.append(
            Estimate(
                path=parameter,
                unit=quantity.unit,
                given=float(coordinates.centre[index]),
                fitted=fitted,
                sigma=sigma,
                interval=(low, high),
                determined=path not in open_paths and bool(sigma < DETERMINED_RATIO * before),
                recording=name or first,
            )
        )
    return tuple(estimates)


def _ratios(
    model: Model, estimates: Sequence[Estimate], covariance: Array, found: OpenDirections
) -> tuple[Ratio, ...]:
    """What remains of parameters with a common scale: each over the inertia J.

    The stiffnesses appear as that of the joint with both tendons taut, K = R^2 (k_1 + k_2), (25).
    """
    paths = [estimate.path for estimate in estimates]
    if INERTIA not in found.scaled:
        return ()
    values = model.values()
    square = model.transmission.joint_pulley_radius**2
    stiffness = {
        f"{spring}.stiffness": square * values[f"{spring}.parallel"]
        for spring in SPRINGS
        if model.kind.has_springs
    }
    declared = declared_quantities(model)
    numerators = [("K/J", "1/s2", stiffness)] if stiffness else []
    traded = {path for group in found.traded for path in group}
    for estimate in estimates:
        path = estimate.path
        if path in found.scaled and path not in {INERTIA, *stiffness, *traded}:
            unit = quotient(estimate.unit, declared[INERTIA].unit)
            numerators.append((f"{path}/J", unit, {path: 1.0}))
    ratios = []
    for name, unit, weights in numerators:
        value = sum(weight * values[path] for path, weight in weights.items()) / values[INERTIA]
        gradient = np.array([weights.get(path, 0.0) for path in paths])
        gradient[paths.index(INERTIA)] = -value
        gradient /= values[INERTIA]
        half = CONFIDENCE * float(np.sqrt(gradient @ covariance @ gradient))
        # bounds at zero of the numerator are bounds of the ratio, as J is positive
        low = 0.0 if all(declared[path].lower >= 0.0 for path in weights) else -np.inf
        high = 0.0 if all(declared[path].upper <= 0.0 for path in weights) else np.inf
        interval = (max(value - half, low), min(value + half, high))
        ratios.append(Ratio(name, unit, value, interval))
    return tuple(ratios)


def _sentences(problem: Problem, found: OpenDirections) -> tuple[str, ...]:
    sentences = []
    if found.scaled:
        blind = all(
            measurement.load_torque is None and set(measurement.signals) == {"joint_position"}
            for measurement in problem.measurements
        )
        reason = "Without a known load or torque the" if blind else "The"
        sentences.append(
            f"{reason} data determine only ratios: {', '.join(found.scaled)} share one free scale."
        )
    sentences += [
        f"The data cannot tell {' and '.join(group)} apart: one may change against the other."
        for group in found.traded
    ]
    if found.silent:
        sentences.append(
            f"The data say nothing of {', '.join(found.silent)}; any value near what was given "
            "would do."
        )
    return tuple(sentences)
