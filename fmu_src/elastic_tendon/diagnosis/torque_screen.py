"""The screen: sets of effects estimated together with the model's own parameters, in torque.

Every candidate set is fitted to the weak form of the recordings (`weak_form`), where nothing is
integrated and the problem is nearly linear, so that a good start is not needed. The estimates are
where refits of whole trajectories start, and tell which sets deserve one.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import log
from operator import itemgetter

import numpy as np
from scipy.optimize import lsq_linear

from elastic_tendon import effects
from elastic_tendon.actuator.interfaces import InterfaceKind
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.variables import LINK
from elastic_tendon.comparison.residuals import Array, autocorrelation_time
from elastic_tendon.diagnosis.candidates import STIFFNESSES, sensible, starts
from elastic_tendon.diagnosis.evidence import DECISIVE
from elastic_tendon.diagnosis.sets import in_order
from elastic_tendon.diagnosis.torque_balance import Balance, Torques, torque_balance
from elastic_tendon.diagnosis.weak_form import Weak, weak_form
from elastic_tendon.errors import ModelError
from elastic_tendon.estimation.coordinates import (
    Coordinates,
    free_parameters,
    parameter_of,
)
from elastic_tendon.measurement import Measurement

# of the typical strength of an effect, from which its estimate begins; also the second where its
# null is singular, so that strengths far off look alike
STARTS = (0.1, 1.0)
SCOUTING, POLISHING = 3, 8  # steps with shapes held, and with all parameters free
SCOUTED, POLISHED = 3, 2  # starts of an effect that are followed, and those to the end ...
ALIKE = 2.0  # ... where their mean squares differ by less than this factor
# hops in vain that end a search around an estimate, how far they go, as logarithms of parameters,
# and which share of the mean square a better one has to leave
FRUITLESS, DISTANCES, BETTER = 20, (0.1, 0.2, 0.4), 0.95
KEPT = 3  # from which it is scored beside other effects
FITS = 1.3  # mean square up to which residuals are noise alone
LONGEST_MEMORY = 40.0  # residuals that count as one, at the most
ONE_SIDED = 1.645  # standard deviations that 95 % of a normal distribution lie below
CONVERGED = 1e-3  # relative fall of the cost
# share of the stiffness that an effect may take away before residuals count more, and the least
ORDINARY_STIFFNESS, LEAST_STIFFNESS = 0.5, 1e-3
DAMPINGS = 5  # tried in one step
REMEMBERED = 32  # evaluations


@dataclass(frozen=True)
class Structure:
    """A set of effects: where its parameters may go, and its equations."""

    added: tuple[str, ...]
    coordinates: Coordinates
    effect_ids: tuple[str, ...]  # those that the given model has among them
    kind: InterfaceKind
    lower: Array
    upper: Array
    shapes: tuple[bool, ...]
    shown: tuple[str, ...]  # torques that sensors show
    values: Mapping[str, float]  # of all parameters, those that are known among them

    @cached_property
    def balance(self) -> Balance:
        """Its equations, with derivatives by the free parameters."""
        return torque_balance(self.effect_ids, self.coordinates.of_model, self.shown, self.kind)

    @cached_property
    def plain(self) -> Balance:
        """Its equations without derivatives."""
        return torque_balance(self.effect_ids, (), self.shown, self.kind)

    def variables(self, values: Mapping[str, float]) -> Array:
        """Variables of the fit at parameters by path; those that are missing begin as given."""
        free = []
        for path in self.coordinates.paths:
            parameter = parameter_of(path)
            free.append(values.get(path, values.get(parameter, self.values[parameter])))
        return self.coordinates.variables(np.array(free))

    def parameters(self, x: Array) -> dict[str, float]:
        """Every parameter by its path, recordings' own among them."""
        free = zip(self.coordinates.paths, self.coordinates.values(x).tolist(), strict=True)
        return {**self.values, **dict(free)}


@dataclass(frozen=True)
class Estimate:
    """A set of effects fitted in torque.

    `values` : every parameter by its dotted path. `residuals` : whitened (N,).
    """

    added: tuple[str, ...]
    x: Array
    values: Mapping[str, float]
    residuals: Array

    @property
    def square(self) -> float:
        """Mean square of the whitened residuals; 1 is the noise."""
        with np.errstate(over="ignore"):  # infinite where an estimate has run away
            return float(np.mean(self.residuals**2))


@dataclass(frozen=True)
class Expected:
    """A set of effects before it is fitted: mean square expected, and parameters by path."""

    square: float
    start: Mapping[str, float]


@dataclass(frozen=True)
class Around:
    """An estimate and its derivatives, from where further effects are scored.

    `residuals` (N,), whitened; `derivatives` (N, m) by its parameters; `bare` (N,) : residuals of
    the same parameters without its effects; `weight`, `matrix`, `gradient` : normal equations;
    `changes` : what effects change in the residuals (N,), by their id and the values of a start.
    """

    residuals: Array
    derivatives: Array
    bare: Array
    weight: float
    matrix: Array
    gradient: Array
    changes: dict[tuple[object, ...], Array] = field(default_factory=dict, repr=False)

    def left(self, change: Array, *, signed: bool) -> tuple[float, float]:
        """Mean square that is left when a change (N,) comes in, all else free to follow; and how
        many times it comes in, less than none only where it is `signed`."""
        if not np.isfinite(change).all() or not change.any():
            return float(np.mean(self.residuals**2)), 1.0
        count = len(self.gradient)
        whole = np.empty((count + 1, count + 1))
        whole[:count, :count] = self.matrix
        whole[count, :count] = whole[:count, count] = self.derivatives.T @ change / self.weight
        whole[count, count] = change @ change / self.weight * (1.0 + 1e-9)
        score = np.append(self.gradient, change @ self.residuals / self.weight)
        step = -np.linalg.solve(whole, score)
        if step[count] < 0.0 and not signed:
            return float(np.mean(self.residuals**2)), 1.0
        after = self.residuals + self.derivatives @ step[:count] + change * step[count]
        return float(np.mean(after**2)), float(step[count])

    def told(self, change: Array) -> float:
        """What the residuals tell of a change (N,): its square, less what all else could do."""
        along = self.derivatives.T @ change / self.weight
        return float(change @ change / self.weight - along @ np.linalg.solve(self.matrix, along))


def revealing(samples: int) -> float:
    """How large a change is, in sigmas, that so many samples show decisively in 95 % of cases."""
    return float(np.sqrt(DECISIVE + log(samples))) + ONE_SIDED


class Screen:
    """Recordings in weak form, and estimates of sets of effects from them.

    Parameters
    ----------
    given : Model; centre of the prior
    measurements : recordings
    """

    def __init__(self, given: Model, measurements: Sequence[Measurement]) -> None:
        self.given = given
        self.measurements = tuple(measurements)
        self.recordings: list[Weak] = [weak_form(part) for part in measurements]
        self._shown = tuple(dict.fromkeys(name for part in self.recordings for name in part.shown))
        self._given = given.values()
        self._models: dict[tuple[str, ...], Model] = {(): given}
        self._structures: dict[tuple[str, ...], Structure] = {}
        base = self.structure(())
        values = base.parameters(np.zeros(len(base.coordinates.paths)))
        along = [base.balance.torques(values, part.motion) for part in self.recordings]
        self._slopes = self._slopes_of_link(along)
        self.whiteners = [
            part.whitener(values, torques)
            for part, torques in zip(self.recordings, along, strict=True)
        ]
        # residuals of the link, whose noise is the encoder's times the stiffness
        self._of_link = np.concatenate(
            [
                np.arange((len(part.bodies) + len(part.shown)) * part.test.shape[0])
                < part.test.shape[0] * given.kind.has_link
                for part in self.recordings
            ]
        )
        names = [part.recording for part in self.measurements]
        self._parts = list(zip(self.recordings, self.whiteners, names, strict=True))
        self._kept: dict[str, list[dict[str, float]]] = {}
        self._known: tuple[Estimate, Around] | None = None
        # where a fit begins at a start that was scored, the latest ones
        self._evaluated: dict[tuple[tuple[str, ...], bytes], tuple[Array, Array]] = {}

    # ---- structures --------------------------------------------------------------------------

    def structure(self, added: tuple[str, ...]) -> Structure:
        """Of a set of effects.

        Raises
        ------
        ModelError : they do not go together
        """
        if added not in self._structures:
            self._structures[added] = self._structure(added)
        return self._structures[added]

    def _model(self, added: tuple[str, ...]) -> Model:
        if added not in self._models:
            self._models[added] = self._model(added[:-1]).with_effect(added[-1], None)
        return self._models[added]

    def _structure(self, added: tuple[str, ...]) -> Structure:
        model = self._model(added)
        paths = free_parameters(model)
        limits = sensible(model, added, self.measurements)
        coordinates = Coordinates.of(model, paths, limits, self.measurements)
        lower, upper = coordinates.bounds()
        shape = {
            f"effects.{effect_id}.{parameter.name}": parameter.shape
            for effect_id in added
            for parameter in effects.BY_ID[effect_id].parameters
        }
        return Structure(
            added=added,
            coordinates=coordinates,
            effect_ids=model.effect_ids,
            kind=model.kind,
            lower=lower,
            upper=upper,
            shapes=tuple(shape.get(path, False) for path in coordinates.paths),
            shown=self._shown,
            values=coordinates.given.values(),
        )

    # ---- residuals ---------------------------------------------------------------------------

    def evaluate(self, structure: Structure, x: Array) -> tuple[Array, Array]:
        """Whitened residuals (N,) and their derivatives by x, (N, m)."""
        key = (structure.added, x.tobytes())
        if key not in self._evaluated:
            if len(self._evaluated) >= REMEMBERED:
                del self._evaluated[next(iter(self._evaluated))]
            self._evaluated[key] = self._evaluate(structure, x)
        return self._evaluated[key]

    def _evaluate(self, structure: Structure, x: Array) -> tuple[Array, Array]:
        values, coordinates = structure.parameters(x), structure.coordinates
        residuals, derivatives, along = [], [], []
        for part, whiten, recording in self._parts:
            own = {**values, **coordinates.own_among(values, recording)}
            torques = structure.balance.torques(own, part.motion)
            along.append(torques)
            residuals.append(whiten(part.residuals(own, torques)))
            by_model = whiten(part.jacobian(torques, coordinates.of_model))
            derivatives.append(coordinates.columns(by_model, recording))
        scale, slopes = self._scale(structure, values, self._slopes_of_link(along))
        whole, by_parameter = np.concatenate(residuals), np.vstack(derivatives)
        whole[self._of_link] /= scale
        by_parameter[self._of_link] /= scale
        with np.errstate(invalid="ignore"):  # of what has run away no derivative is finite
            by_parameter[self._of_link] -= np.outer(whole[self._of_link], slopes)
            return whole, by_parameter @ structure.coordinates.derivatives(x)

    def _slopes_of_link(self, along: Sequence[Torques]) -> Array:
        """Slopes of the torque on the link by its position, N·m/rad; none where it is given."""
        if not self.given.kind.has_link:
            return np.zeros(0)
        return np.concatenate([torques.moved[0].by_position for torques in along])

    def _scale(
        self, structure: Structure, values: Mapping[str, float], slopes: Array
    ) -> tuple[float, Array]:
        """Stiffness beside that of the given model, without springs inertia, and the slopes of its
        logarithm.

        It divides the residuals of the link: the noise of an encoder shows in torque in proportion
        to it. Without a known torque all parameters could else shrink together, and
        every residual with them; or play could take the stiffness away.
        """
        weights = _weights(self._given)
        joint, given = _weighed(values, weights), _weighed(self._given, weights)
        scale = joint / given
        share = 1.0
        if structure.added and self._slopes.any():
            left = float(np.mean(np.minimum(-slopes, -scale * self._slopes)))
            whole = float(np.mean(-scale * self._slopes))
            share = min(max(left / whole, LEAST_STIFFNESS) / ORDINARY_STIFFNESS, 1.0)
        columns = [weights.get(path, 0.0) / joint for path in structure.coordinates.paths]
        return scale * share, np.array(columns)

    # ---- one set -----------------------------------------------------------------------------

    def fit(
        self, added: tuple[str, ...], start: Mapping[str, float], steps: int, *, hold: bool = False
    ) -> Estimate:
        """Gauss-Newton with bounds and prior (Levenberg's damping).

        Parameters
        ----------
        added : set of effects
        start : parameters by path; those that are missing begin as given
        steps : at the most
        hold : shapes stay where they are
        """
        structure = self.structure(added)
        x = np.clip(structure.variables(start), structure.lower, structure.upper)
        free = np.array([not (hold and shape) for shape in structure.shapes])
        residuals, derivatives = self.evaluate(structure, x)
        damping = 1e-4
        for _ in range(steps):
            if not _finite(residuals, derivatives):
                break
            weight = _weight(residuals, independent=hold)
            cost = _cost(structure, x, residuals, weight)
            matrix, gradient = _normal(structure, x, residuals, derivatives, weight)
            for _ in range(DAMPINGS):
                step = _step(structure, x, matrix, gradient, free, damping)
                moved = self.evaluate(structure, x + step)
                following = _cost(structure, x + step, moved[0], weight)
                if following < cost:
                    damping = max(0.1 * damping, 1e-7)
                    break
                damping = max(30.0 * damping, 1e-3)
            else:
                break
            x, (residuals, derivatives) = x + step, moved
            if cost - following < CONVERGED * cost:
                break
        return Estimate(structure.added, x, structure.parameters(x), residuals)

    # ---- starts ------------------------------------------------------------------------------

    def sees(self, effect_id: str) -> bool:
        """Whether torques along the measured motion show an effect."""
        return self.structure((effect_id,)).balance.resolved

    def starts(self, effect_id: str) -> list[dict[str, float]]:
        """Parameters of an effect from which its estimate may begin, one for each shape."""
        effect = effects.BY_ID[effect_id]
        shares = STARTS if effect.singular_null else STARTS[:1]
        return [
            {f"effects.{effect_id}.{name}": value for name, value in start.items()}
            for start in starts(self.given, effect, self.measurements, shares, dampings=(1.0,))
        ]

    def single(self, effect_id: str, base: Mapping[str, float] | None = None) -> Estimate:
        """The best estimate of one effect; remembers the starts that came out best.

        Parameters
        ----------
        effect_id : what comes in
        base : parameters of the model by path, from which to begin; None: as given
        """
        starts = [{**(base or {}), **start} for start in self.starts(effect_id)]
        starts.sort(key=lambda start: self._promise(effect_id, start))
        scouted = [self.fit((effect_id,), start, SCOUTING, hold=True) for start in starts[:SCOUTED]]
        scouted.sort(key=badness)
        followed = [
            part for part in scouted[:POLISHED] if badness(part) <= ALIKE * badness(scouted[0])
        ]
        found = [self.fit((effect_id,), part.values, POLISHING) for part in followed]
        prefix = f"effects.{effect_id}."
        self._kept[effect_id] = [
            {path: value for path, value in part.values.items() if path.startswith(prefix)}
            for part in (*found, *scouted[:KEPT])
        ]
        return min(found, key=badness)

    def _promise(self, effect_id: str, start: Mapping[str, float]) -> float:
        """Mean square to which one step from a start would lead, to first order."""
        structure = self.structure((effect_id,))
        x = structure.variables(start)
        residuals, derivatives = self.evaluate(structure, x)
        if not _finite(residuals, derivatives):
            return np.inf
        weight = _weight(residuals, independent=True)
        free = np.array([not shape for shape in structure.shapes])
        step = _step(
            structure, x, *_normal(structure, x, residuals, derivatives, weight), free, 0.0
        )
        return float(np.mean((residuals + derivatives @ step) ** 2))

    def combined(
        self, estimate: Estimate, effect_ids: Iterable[str], most: int, *, anew: bool = False
    ) -> tuple[dict[tuple[str, ...], Estimate], dict[tuple[str, ...], Expected]]:
        """Estimates of sets with one more effect: all scored, the likeliest fitted.

        Parameters
        ----------
        estimate : of a set
        effect_ids : what may come in
        most : sets that are fitted
        anew : score all starts of each effect, not only those that were its best by itself

        Returns
        -------
        estimates of those that were fitted; what is expected of every set
        """
        effect_of = {in_order((*estimate.added, effect_id)): effect_id for effect_id in effect_ids}
        possible = [added for added in effect_of if self.goes(added)]
        around = self._around(estimate)
        expected = {
            added: self._extended(estimate, around, effect_of[added], anew=anew)
            for added in possible
        }
        likeliest = sorted(expected, key=lambda added: expected[added].square)[:most]
        found = {added: self.followed(added, expected[added].start) for added in likeliest}
        return found, expected

    def followed(self, added: tuple[str, ...], start: Mapping[str, float]) -> Estimate:
        """A set from one start: shapes held, then free."""
        return self.fit(added, self.fit(added, start, SCOUTING, hold=True).values, POLISHING)

    def hopped(
        self, estimate: Estimate, check: Callable[[float], object] = lambda _share: None
    ) -> Estimate:
        """The best estimate of the same set from places around it, and around what is better.

        Where contacts open and close, the sum of squares has many minima.

        Parameters
        ----------
        estimate : of a set
        check : called before each hop with the share that is done; may end the work
        """
        random, best, vain = np.random.default_rng(0), estimate, 0
        while vain < FRUITLESS and best.square > FITS:
            check(vain / FRUITLESS)
            start = self._beside(best, DISTANCES[vain % len(DISTANCES)], random)
            found = self.fit(estimate.added, start, POLISHING)
            better = badness(found) < BETTER * badness(best)
            best, vain = (found, 0) if better else (best, vain + 1)
        return best

    def _beside(
        self, estimate: Estimate, distance: float, random: np.random.Generator
    ) -> dict[str, float]:
        """Parameters some distance from an estimate's; those of effects that are at a bound, from
        one of the effect's starts."""
        structure = self.structure(estimate.added)
        start: dict[str, float] = {}
        for effect_id in estimate.added:
            starts = self.starts(effect_id)
            start |= starts[random.integers(len(starts))]
        inside = (structure.lower < estimate.x) & (estimate.x < structure.upper)
        times = np.exp(distance * random.standard_normal(len(inside)))
        for path, kept, time in zip(structure.coordinates.paths, inside, times, strict=True):
            own = estimate.values[path]
            start[path] = time * (own if kept else start.get(path, own))
        return start

    def goes(self, added: tuple[str, ...]) -> bool:
        """Whether a model can take these effects together."""
        try:
            self._model(added)
        except ModelError:
            return False
        return len(set(added)) == len(added)

    def _extended(
        self, estimate: Estimate, around: Around | None, effect_id: str, *, anew: bool
    ) -> Expected:
        """How well one more effect would do, to first order, and where its estimate begins."""
        kept = self._kept.get(effect_id, [])
        starts = [*kept, *(self.starts(effect_id) if anew or not kept else ())]
        if around is None:
            return Expected(np.inf, {**estimate.values, **starts[0]})
        changes = self._changes(estimate, around, effect_id, starts)
        signed = effects.BY_ID[effect_id].signed
        found = [
            (*around.left(change, signed=signed), start)
            for start, change in zip(starts, changes, strict=True)
        ]
        square, times, start = min(found, key=itemgetter(0))
        return Expected(
            square, {**estimate.values, **start, **scaled_strengths(effect_id, start, times)}
        )

    def _changes(
        self,
        estimate: Estimate,
        around: Around,
        effect_id: str,
        starts: Sequence[Mapping[str, float]],
    ) -> Iterator[Array]:
        """What one more effect changes in the residuals, from each of some starts.

        It is taken from the model with that effect alone, so that no new equations are needed.
        """
        alone = self.structure((effect_id,))
        for start in starts:
            key = (effect_id, *start.values())
            if key not in around.changes:
                values = {**alone.values, **estimate.values, **start}
                around.changes[key] = self._residuals_at(alone, values) - around.bare
            yield around.changes[key]

    def smallest(self, estimate: Estimate, effect_id: str) -> float | None:
        """Size of an effect's first strength that these recordings would have shown, 95 %.

        Parameters
        ----------
        estimate : of the answer, without the effect
        effect_id : what was not found

        Returns
        -------
        float, in the parameter's unit; None where no size would show
        """
        around = self._around(estimate)
        if around is None:
            return None
        path = f"effects.{effect_id}.{effects.BY_ID[effect_id].strength.name}"
        needed = revealing(len(around.residuals))
        begun = self.starts(effect_id)
        changes = self._changes(estimate, around, effect_id, begun)
        sizes = [
            needed * abs(start[path]) / float(np.sqrt(told))
            for start, change in zip(begun, changes, strict=True)
            if change.any() and 0.0 < (told := around.told(change)) < np.inf
        ]
        return float(np.median(sizes)) if sizes else None

    def _residuals_at(self, structure: Structure, values: Mapping[str, float]) -> Array:
        """Whitened residuals (N,) alone, in the scale of the given model's stiffness."""
        whole = np.concatenate(
            [
                whiten(part.residuals(own, structure.plain.torques(own, part.motion)))
                for part, whiten, recording in self._parts
                for own in [{**values, **structure.coordinates.own_among(values, recording)}]
            ]
        )
        weights = _weights(self._given)
        whole[self._of_link] /= _weighed(values, weights) / _weighed(self._given, weights)
        return whole

    def _around(self, estimate: Estimate) -> Around | None:
        """What further effects are scored from, the last remembered; None without derivatives."""
        if self._known is None or self._known[0] is not estimate:
            structure = self.structure(estimate.added)
            residuals, derivatives = self.evaluate(structure, estimate.x)
            if not np.isfinite(derivatives).all():
                return None
            bare = self._residuals_at(self.structure(()), estimate.values)
            weight = _weight(residuals, independent=False)
            normal = _normal(structure, estimate.x, residuals, derivatives, weight)
            self._known = estimate, Around(residuals, derivatives, bare, weight, *normal)
        return self._known[1]


def scaled_strengths(effect_id: str, start: Mapping[str, float], times: float) -> dict[str, float]:
    """Strengths of an effect, by path, so many times as large, none of one whose null is singular:
    where it is far stronger than a start, estimates that begin there end beside it."""
    effect = effects.BY_ID[effect_id]
    if effect.singular_null:
        return {}
    nulls = {
        f"effects.{effect_id}.{parameter.name}": parameter.null
        for parameter in effect.parameters
        if not parameter.shape
    }
    return {
        path: null + times * (value - null)
        for path, value in start.items()
        if (null := nulls.get(parameter_of(path))) is not None
    }


def _finite(*arrays: Array) -> bool:
    return all(np.isfinite(array).all() for array in arrays)


def badness(estimate: Estimate) -> float:
    """By which estimates of the same residuals are ordered."""
    square = estimate.square
    return square if np.isfinite(square) else np.inf


def _weights(values: Mapping[str, float]) -> dict[str, float]:
    """What adds up to the stiffness of all springs together, N/m, each times what; without springs
    the inertia."""
    if STIFFNESSES[0] not in values:
        return {LINK.inertia: 1.0}
    return {path: values[path.replace(".stiffness", ".parallel")] for path in STIFFNESSES}


def _weighed(values: Mapping[str, float], weights: Mapping[str, float]) -> float:
    return sum(weight * values[path] for path, weight in weights.items())


def _prior(structure: Structure, x: Array) -> Array:
    coordinates = structure.coordinates
    return np.asarray((coordinates.values(x) - coordinates.centre) / coordinates.sigma)


def _weight(residuals: Array, *, independent: bool) -> float:
    """Variance with which a residual counts: lack of fit, and its autocorrelation time."""
    square = max(float(np.mean(residuals**2)), 1.0)
    if independent or square < FITS:
        return square
    return square * min(autocorrelation_time(residuals), LONGEST_MEMORY)


def _cost(structure: Structure, x: Array, residuals: Array, weight: float) -> float:
    prior = _prior(structure, x)
    with np.errstate(over="ignore"):  # an estimate that has run away costs more than any other
        value = float(residuals @ residuals) / weight + float(prior @ prior)
    return value if np.isfinite(value) else np.inf


def _normal(
    structure: Structure, x: Array, residuals: Array, derivatives: Array, weight: float
) -> tuple[Array, Array]:
    """Normal equations of residuals and prior."""
    coordinates = structure.coordinates
    slopes = coordinates.derivatives(x) / coordinates.sigma[:, np.newaxis]
    matrix = derivatives.T @ derivatives / weight + slopes.T @ slopes
    gradient = derivatives.T @ residuals / weight + slopes.T @ _prior(structure, x)
    return matrix, gradient


def _step(
    structure: Structure, x: Array, matrix: Array, gradient: Array, free: Array, damping: float
) -> Array:
    """Best step of the free parameters within the bounds."""
    own = matrix[np.ix_(free, free)]
    factor = np.linalg.cholesky(own + damping * np.diag(np.diag(own)))
    room = (structure.lower - x)[free], (structure.upper - x)[free]
    tight = np.maximum(room[1] - room[0], 1e-300) <= 1e-12
    bounds = np.minimum(room[0], 0.0) - tight * 1e-12, np.maximum(room[1], 0.0) + 1e-12
    found = lsq_linear(factor.T, -np.linalg.solve(factor, gradient[free]), bounds, method="bvls")
    step = np.zeros(len(x))
    step[free] = found.x
    return np.clip(x + step, structure.lower, structure.upper) - x
