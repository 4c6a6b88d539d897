"""Add a named effect to a model, refit, and watch the error fall."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from itertools import product
from typing import Any

from elastic_tendon import effects, problems
from elastic_tendon.effects.base import Effect, Parameter
from elastic_tendon.errors import MeasurementError, ModelError
from elastic_tendon.identify.compare import compare
from elastic_tendon.identify.determinability import Estimate, Findings
from elastic_tendon.identify.fit import FitResult, fit
from elastic_tendon.identify.ladder import AS_GIVEN, REFIT, Rung, Step, climb
from elastic_tendon.measurement import Measurement
from elastic_tendon.parameters import Model, parse_model, typical_value

SCHEMA = "elastic-tendon/addition/1"

Report = Callable[[str, float], None]  # what is being done, and the share of all that is done

# multiples of the typical values from which the strength of an effect starts
STRENGTHS = (0.1, 1.0, 3.0)
# ... and any other number, which says where or how fast the effect acts
SHAPES = (0.3, 0.6, 1.0)
# share of the work in the refit of the parameters alone; the effect has several starts
REFIT_SHARE = 0.2
# of its uncertainty, below which a fitted number is zero: sigmas are relative to the value
NOTHING = 1e-9


@dataclass(frozen=True)
class Addition:
    """The improved model and the way to it.

    `steps` and `ladder` run from the model as given to `model`, which carries fitted values and
    their uncertainties. `fits` are the fits behind the steps after the first. `interrupted`:
    stopped by the user, holds the best so far.
    """

    effect_id: str
    model: Model
    steps: tuple[Step, ...]
    ladder: tuple[Rung, ...]
    fits: tuple[FitResult, ...]
    interrupted: bool

    @property
    def findings(self) -> Findings:
        """What the last fit says about the numbers."""
        return self.fits[-1].findings

    def to_json(self) -> dict[str, Any]:
        """Ladder and parameters as in the diagnosis contract, and the final model."""
        found = self.findings
        return {
            "schema": SCHEMA,
            "effect": self.effect_id,
            "interrupted": self.interrupted,
            "ladder": [rung.to_json() for rung in self.ladder],
            "parameters": [asdict(estimate) for estimate in found.estimates],
            "ratios": [asdict(ratio) for ratio in found.ratios],
            "undetermined": list(found.sentences),
            "model": self.model.model_dump(mode="json", exclude_none=True),
        }


def add_typical(model: Model, effect_id: str) -> Model:
    """Model with the effect at its typical values, where there is no data to fit it to.

    Raises
    ------
    ModelError : no such effect, or one that the model has already or cannot take
    """
    check_welcome(model, effect_id)
    return model.with_effect(
        effect_id, {one.name: _typical(model, one) for one in effects.BY_ID[effect_id].parameters}
    )


def add(
    model: Model,
    effect_id: str,
    measurements: Sequence[Measurement],
    validation: Sequence[Measurement] = (),
    report: Report = lambda _text, _share: None,
) -> Addition:
    """Refit the model, add an effect, refit both, and compare each step.

    The effect starts from several strengths, on the model as given and on the refitted one, and
    from its null on the refitted one, so adding never increases the cost of the fit.

    Parameters
    ----------
    model : Model as given; its uncertainties are the prior of every step
    effect_id : of the catalogue or of one's own, absent from the model
    measurements : fitted
    validation : never fitted; gives its initial state on its first 0.1 s and nothing else
    report : called with words and the share of the work done, 0 to 1

    Returns
    -------
    Addition

    Raises
    ------
    ModelError : no such effect, or one that the model has already or cannot take
    MeasurementError : a recording is both fitted and held out
    SimulationError : the model as given cannot be simulated
    """
    check_welcome(model, effect_id)
    check_apart(measurements, validation)

    def step(title: str, added: str | None, result: FitResult | None) -> Step:
        reached = model if result is None else result.model
        return Step(
            title=title,
            added=added,
            parameters=0 if added is None else len(effects.BY_ID[added].parameters),
            effective=0.0 if result is None else result.findings.effective,
            comparison=compare(reached, measurements),
            heldout=compare(reached, validation) if validation else None,
        )

    report("comparing the model as given", 0.0)
    steps = [step(AS_GIVEN, None, None)]
    report("refitting the parameters", 0.0)
    refit = fit(
        model,
        measurements,
        progress=lambda share: report("refitting the parameters", REFIT_SHARE * share),
    )
    fits = [refit]
    steps.append(step(REFIT, None, refit))
    interrupted = refit.interrupted
    if not interrupted:
        words = f"adding {effects.BY_ID[effect_id].title}"
        try:
            fitted = fit(
                model.with_effect(effect_id, None),
                measurements,
                starts=list(_starts(model, refit.model, effect_id)),
                progress=lambda share: report(words, REFIT_SHARE + (1.0 - REFIT_SHARE) * share),
            )
        except KeyboardInterrupt:  # before the fit had anything to keep
            interrupted = True
        else:
            interrupted = fitted.interrupted
            fits.append(fitted)
            steps.append(step(f"+ {effects.BY_ID[effect_id].title}", effect_id, fitted))
    return Addition(
        effect_id=effect_id,
        model=with_estimates(fits[-1].model, fits[-1].findings.estimates),
        steps=tuple(steps),
        ladder=climb(steps),
        fits=tuple(fits),
        interrupted=interrupted,
    )


def with_estimates(model: Model, estimates: Sequence[Estimate]) -> Model:
    """The model with the estimates' sigmas as its [uncertainty].

    A further fit to the *same* data would count them twice; they are the prior for new data.
    """
    nothing = {one.path for one in estimates if abs(one.fitted) <= NOTHING * one.sigma}
    model = model.with_values(dict.fromkeys(nothing, 0.0))
    updated = {
        one.path: one.sigma
        if one.path in nothing or not one.fitted
        else one.sigma / abs(one.fitted)
        for one in estimates
    }
    tree = model.model_dump()
    return parse_model(tree | {"uncertainty": tree["uncertainty"] | updated}, model.name)


def effect_by_id(effect_id: str) -> Effect:
    """The effect with this id, of the catalogue, loaded or of an installed package.

    Raises
    ------
    ModelError : there is none
    EffectError : that of an installed package cannot be used
    """
    effect = effects.BY_ID.find(effect_id)
    if effect is None:
        raise ModelError("effects", [problems.unknown_effect(effect_id, effects.BY_ID.ids())])
    return effect


def check_welcome(model: Model, effect_id: str) -> None:
    """Refuse an effect that a model cannot take, before anything is fitted.

    Raises
    ------
    ModelError : no such effect, or one that the model has already or cannot take
    """
    if effect_by_id(effect_id).id in model.effect_ids:
        raise ModelError(
            model.name,
            [f"it has the effect {effect_id} already; name another one, or the model without it"],
        )
    model.with_effect(effect_id, None)


def check_apart(fitted: Sequence[Measurement], heldout: Sequence[Measurement]) -> None:
    """Refuse to judge with what was fitted.

    Raises
    ------
    MeasurementError : a sample is both fitted and held out
    """
    for judge in heldout:
        for one in fitted:
            if judge.shares_samples(one):
                raise MeasurementError(
                    f"{judge.name}: it is held out but shares samples with {one.name}, which is "
                    "fitted; give another recording, or windows that do not overlap"
                )


def _typical(model: Model, parameter: Parameter) -> float:
    value = typical_value(model, parameter)
    return min(max(value, parameter.lower), parameter.upper)


def _starts(given: Model, refitted: Model, effect_id: str) -> Iterator[Model]:
    """The null on the refitted model, then a grid of effects on both models."""
    yield refitted.with_effect(effect_id, None)
    for origin in (given, refitted):
        for values in _grid(origin, effect_id):
            with suppress(ModelError):  # the effect may refuse some numbers together
                yield origin.with_effect(effect_id, values)


def _grid(model: Model, effect_id: str) -> Iterator[Mapping[str, float]]:
    """Numbers of an effect to start from: several strengths, at each several shapes."""
    parameters = effects.BY_ID[effect_id].parameters
    strengths = [one for one in parameters if not one.shape]
    shapes = [one for one in parameters if one.shape]
    signed = any(one.lower < 0.0 for one in strengths)
    for strength in _with_signs(STRENGTHS, signed):
        for multiples in product(
            *(_with_signs(SHAPES, one.null == 0.0 and one.lower < 0.0) for one in shapes)
        ):
            pairs = [*((one, strength) for one in strengths), *zip(shapes, multiples, strict=True)]
            yield {
                one.name: min(max(typical_value(model, one) * multiple, one.lower), one.upper)
                for one, multiple in pairs
            }


def _with_signs(multiples: Sequence[float], signed: bool) -> tuple[float, ...]:
    return (*multiples, *(-one for one in multiples)) if signed else tuple(multiples)
