"""Score tests: which effects would explain what is left of the errors, without refitting any.

For each effect the derivative of the errors to its strength, where it vanishes, is compared with
the errors (Lagrange multiplier test). Free numbers and initial states are projected out
(efficient score); shapes, which mean nothing where the strength is zero, are tried on a small
grid (Davies 1987); a strength that cannot be negative is held there (Self & Liang 1987).
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import lsq_linear

from elastic_tendon import effects
from elastic_tendon.diagnosis.candidates import shapes
from elastic_tendon.diagnosis.linearised import Linearised
from elastic_tendon.effects.base import Effect, Parameter
from elastic_tendon.errors import ModelError, SimulationError
from elastic_tendon.identify.add import Report
from elastic_tendon.identify.fit import FitResult
from elastic_tendon.identify.residuals import (
    Array,
    InitialState,
    residuals_of,
    sensitivity,
    simulate_measurement,
    stack,
)
from elastic_tendon.identify.stretches import independent_facts
from elastic_tendon.measurement import Measurement
from elastic_tendon.parameters import Model, typical_value

# of the typical strength, where an effect has no derivative at its null
PROBES = (0.1, 1.0)
VISIBLE = 1e-9  # share of a column that nuisances leave, below which it is rounding


@dataclass(frozen=True)
class Score:
    """What the score test says of one effect.

    `gain` : share (0 to 1) of the squared error that it would explain. `score` : chi-squared,
    from as many facts as the errors hold about the best. `expected` : its parameters, by name.
    """

    effect_id: str
    gain: float
    score: float
    expected: Mapping[str, float]


def screen(
    result: FitResult, origin: Model, effect_ids: Sequence[str], report: Report
) -> tuple[Score, ...]:
    """Score effects against the errors of a fitted model, best first.

    Parameters
    ----------
    result : FitResult
    origin : the fitted model, or with fewer effects: what a further effect brings is nearly the
        same with and without those that came in before, and needs no library of its own
    effect_ids : that the model could take
    report : called with words and the share that is done

    Returns
    -------
    tuple of Score; an effect that cannot be simulated on this model or is invisible is left out

    Raises
    ------
    SimulationError : the fitted model itself cannot be simulated
    """
    linear = Linearised.of(result)
    found: list[_Gain] = []
    for index, effect_id in enumerate(effect_ids):
        report("screening effects", index / len(effect_ids))
        effect = effects.BY_ID[effect_id]
        tried = [_gain(linear, trial) for trial in _trials(result, origin, effect, linear)]
        if gains := [one for one in tried if one is not None]:
            found.append(max(gains, key=lambda one: one.gain))
    if not found:
        return ()
    found.sort(key=lambda one: -one.gain)
    products = (linear.errors[: linear.samples] + found[0].response) * found[0].response
    facts = independent_facts(result.model, result.problem.measurements, products)
    return tuple(
        Score(
            effect_id=one.effect_id,
            gain=one.gain,
            score=-facts * float(np.log(max(1.0 - one.gain, np.finfo(float).tiny))),
            expected=one.expected,
        )
        for one in found
    )


@dataclass(frozen=True)
class _Gain:
    """A `Score` before it is known how many facts there are.

    `response` (N,) : change of the errors that the effect would bring, whitened, nuisances
    following.
    """

    effect_id: str
    gain: float
    expected: Mapping[str, float]
    response: Array


@dataclass(frozen=True)
class _Trial:
    """Strengths of an effect at one shape: `columns` (N, k), change of the errors by each unit."""

    effect: Effect
    shape: Mapping[str, float]
    units: tuple[Mapping[str, float], ...]  # what one unit of each column is, name -> value
    lowest: Array  # of each column's number of units
    columns: Array


def _trials(
    result: FitResult, origin: Model, effect: Effect, linear: Linearised
) -> Iterator[_Trial]:
    probe = _finite if effect.singular_null else _derivative
    for shape in shapes(origin, effect, result.problem.measurements):
        try:
            yield from probe(result, origin, effect, shape, linear)
        except (SimulationError, ModelError):  # numbers that do not go together
            continue


def _strengths(effect: Effect) -> list[Parameter]:
    return [one for one in effect.parameters if not one.shape]


def _derivative(
    result: FitResult,
    origin: Model,
    effect: Effect,
    shape: Mapping[str, float],
    linear: Linearised,
) -> Iterator[_Trial]:
    strengths = _strengths(effect)
    start = {one.name: one.null for one in strengths}
    model = origin.with_effect(effect.id, {**start, **shape})
    paths = [f"effects.{effect.id}.{one.name}" for one in strengths]
    pairs = zip(result.problem.measurements, result.initial_states, strict=True)
    derivatives = [sensitivity(model, one, state, paths).derivatives for one, state in pairs]
    units = np.array([abs(typical_value(origin, one)) for one in strengths])
    columns = stack(
        [{name: value[:, : len(paths)] for name, value in part.items()} for part in derivatives],
        linear.sigmas,
    )
    yield _Trial(
        effect=effect,
        shape=shape,
        units=tuple({one.name: float(unit)} for one, unit in zip(strengths, units, strict=True)),
        lowest=np.array([one.lower - one.null for one in strengths]) / units,
        columns=columns * units,
    )


def _finite(
    result: FitResult,
    origin: Model,
    effect: Effect,
    shape: Mapping[str, float],
    linear: Linearised,
) -> Iterator[_Trial]:
    pairs = list(zip(result.problem.measurements, result.initial_states, strict=True))
    before = stack([_errors(origin, *pair) for pair in pairs], linear.sigmas)
    for multiple in PROBES:
        unit = {
            one.name: min(max(multiple * typical_value(origin, one), one.lower), one.upper)
            for one in _strengths(effect)
        }
        model = origin.with_effect(effect.id, {**unit, **shape})
        after = [_errors(model, *pair) for pair in pairs]
        columns = (stack(after, linear.sigmas) - before)[:, np.newaxis]
        yield _Trial(effect, shape, (unit,), np.zeros(1), columns)


def _errors(model: Model, measurement: Measurement, initial: InitialState) -> dict[str, Array]:
    return residuals_of(simulate_measurement(model, measurement, initial), measurement)


def _gain(linear: Linearised, trial: _Trial) -> _Gain | None:
    visible = linear.remaining(trial.columns)
    norms = np.linalg.norm(visible, axis=0)
    seen = norms > VISIBLE * np.maximum(np.linalg.norm(trial.columns, axis=0), 1.0)
    if not seen.any():
        return None
    scaled = visible[:, seen] / norms[seen]
    lowest = trial.lowest[seen] * norms[seen]
    # numbers in units of what each column alone does; a bound at zero needs room to start from
    solution = lsq_linear(scaled, -linear.errors, bounds=(np.minimum(lowest, 0.0) - 1e-12, np.inf))
    amounts = np.zeros(len(norms))
    amounts[seen] = np.maximum(solution.x, lowest) / norms[seen]
    response = visible @ amounts
    before = float(linear.errors @ linear.errors)
    left = linear.errors + response
    gain = 1.0 - float(left @ left) / before
    return _Gain(
        effect_id=trial.effect.id,
        gain=gain,
        expected={**_expected(trial, amounts), **trial.shape},
        response=response[: linear.samples],
    )


def _expected(trial: _Trial, amounts: Array) -> dict[str, float]:
    nulls = {one.name: one.null for one in trial.effect.parameters}
    values: dict[str, float] = {}
    for unit, amount in zip(trial.units, amounts, strict=True):
        for name, value in unit.items():
            values[name] = nulls[name] + float(amount) * value
    return values
