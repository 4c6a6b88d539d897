"""Add named effects to a model, refit after each, and watch the error fall."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from functools import partial
from itertools import product
from typing import TYPE_CHECKING, Any

from threadpoolctl import threadpool_limits

from elastic_tendon import effects
from elastic_tendon.actuator import problems
from elastic_tendon.actuator.parameters import Model, parse_model, typical_value
from elastic_tendon.comparison.compare import compare
from elastic_tendon.comparison.comparison import Comparison
from elastic_tendon.effects.base import Effect, Parameter, Spread
from elastic_tendon.errors import MeasurementError, ModelError
from elastic_tendon.estimation.coordinates import sizes_in
from elastic_tendon.estimation.determinability import Estimate, Findings
from elastic_tendon.estimation.fit import FitResult, fit
from elastic_tendon.estimation.ladder import AS_GIVEN, REFIT, FittedStep, Step, climb, steps_text
from elastic_tendon.measurement import Measurement, Recordings, listed
from elastic_tendon.progress import Progress, silent
from elastic_tendon.result import Result, plain

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

SCHEMA = "elastic-tendon/addition/2"

# multiples of the typical values from which the strength of an effect starts
STRENGTHS = (0.1, 1.0, 3.0)
# ... and any other parameter, which says where or how fast the effect acts
SHAPES = (0.3, 0.6, 1.0)
# share of the work in the refit of the parameters alone; each effect has several starts
REFIT_SHARE = 0.2
REFITTING = "refitting the parameters"
# of its uncertainty, below which an estimate is zero: sigmas are relative to the value
NOTHING = 1e-9


@dataclass(frozen=True, repr=False)
class Addition(Result):
    """The improved model and the way to it.

    `effect_ids` : effects to be added, in this order. `steps` and `ladder` run from the model as
    given to `model`, which carries fitted values and their uncertainties. `fits` are the fits
    behind the steps after the first. `interrupted`: stopped by the user, holds the best so far.
    """

    effect_ids: tuple[str, ...]
    model: Model
    steps: tuple[FittedStep, ...]
    ladder: tuple[Step, ...]
    fits: tuple[FitResult, ...]
    interrupted: bool

    @property
    def findings(self) -> Findings:
        """What the last fit says about the parameters."""
        return self.fits[-1].findings

    def summary(self) -> str:
        """The error after each step, and every parameter as fitted."""
        return f"{steps_text(self.ladder, self.model.motion)}\n{self.findings.summary()}"

    def to_dataframe(self) -> "pd.DataFrame":
        """Every parameter as given and as fitted, with its 95 % interval, a row each, SI."""
        return self.findings.to_dataframe()

    def plot(self) -> "Figure":
        """Draw the error after each step, and measured beside simulated."""
        from elastic_tendon.reports.comparison_figures import story
        from elastic_tendon.reports.worded import worded_figure

        return worded_figure(story(self.steps, self.ladder), self.model.motion)

    def to_dict(self) -> dict[str, Any]:
        """Ladder and parameters as in the diagnosis contract, and the final model."""
        found = self.findings
        content: dict[str, Any] = plain(
            {
                "schema": SCHEMA,
                "effects": self.effect_ids,
                "interrupted": self.interrupted,
                "ladder": [step.to_dict() for step in self.ladder],
                "parameters": [asdict(estimate) for estimate in found.estimates],
                "parameters_of_recordings": [asdict(part) for part in found.of_recordings],
                "ratios": [asdict(ratio) for ratio in found.ratios],
                "undetermined": found.sentences,
                "model": self.model.model_dump(mode="json", exclude_none=True),
            }
        )
        return content


def add_typical(model: Model, effect_ids: str | Sequence[str]) -> Model:
    """Model with effects at their typical values, where there is no data to fit them to.

    Raises
    ------
    ModelError : no such effect, or one that the model has already or cannot take
    """
    extended = model
    for effect_id in _listed(effect_ids):
        check_welcome(extended, effect_id)
        parameters = effects.BY_ID[effect_id].parameters
        typical = {
            # without the last digits that arithmetic leaves: dialogs of importers show the number
            parameter.name: float(f"{_typical(extended, parameter):.12g}")
            for parameter in parameters
        }
        extended = extended.with_effect(effect_id, typical)
    return named_after(model, extended)


def add(
    model: Model,
    effect_ids: str | Sequence[str],
    measurements: Recordings,
    validate: Recordings = (),
    progress: Progress = silent,
) -> Addition:
    """Refit the model, add effects one after the other, refit after each, and compare each step.

    An effect starts from several strengths, on the model as given and on the refitted one, and
    from its null on the refitted one, so adding never increases the cost of the fit.

    Parameters
    ----------
    model : Model as given; its uncertainties are the prior of every step
    effect_ids : of the catalogue or of one's own, one or several, absent from the model
    measurements : fitted, one or several
    validate : held out, one or several: never fitted; gives its initial state on its first 0.1 s
        and nothing else
    progress : called with what is being done and the share of it that is done, 0 to 1

    Returns
    -------
    Addition

    Raises
    ------
    ModelError : no such effect, or one that the model has already or cannot take
    MeasurementError : a recording is both fitted and held out
    SimulationError : the model as given cannot be simulated
    """
    wanted = _listed(effect_ids)
    with_nulls = model
    for effect_id in wanted:
        check_welcome(with_nulls, effect_id)
        with_nulls = with_nulls.with_effect(effect_id, None)
    fitted, heldout = listed(measurements), listed(validate)
    check_apart(fitted, heldout)
    way = _Way(model, fitted, heldout)
    progress("comparing the model as given", 0.0)
    way.compare_as_given()
    fits: tuple[str | None, ...] = (None, *wanted)
    for done, added in enumerate(fits):
        words = REFITTING if added is None else f"adding {effects.BY_ID[added].title}"
        tell = partial(_tell, progress, words, done, len(wanted))
        tell(0.0)
        try:
            with threadpool_limits(1, user_api="blas"):  # see `diagnose`
                way.go(added, tell)
        except KeyboardInterrupt:  # before the fit had anything to keep
            if not way.fits:
                raise
            way.interrupted = True
        if way.interrupted:
            break
    return way.addition(wanted)


def _listed(effect_ids: str | Sequence[str]) -> tuple[str, ...]:
    return (effect_ids,) if isinstance(effect_ids, str) else tuple(effect_ids)


def _tell(progress: Progress, words: str, done: int, count: int, share: float) -> None:
    """Tell the share of all that is done, of the fit after `done` fits; `count` effects come in."""
    if done:
        share = (done - 1 + share) / count
        progress(words, REFIT_SHARE + (1.0 - REFIT_SHARE) * share)
    else:
        progress(words, REFIT_SHARE * share)


@dataclass
class _Way:
    """Steps from the model as given, so far."""

    given: Model
    measurements: Sequence[Measurement]
    validation: Sequence[Measurement]
    added: tuple[str, ...] = ()
    steps: list[FittedStep] = field(default_factory=list)
    fits: list[FitResult] = field(default_factory=list)
    interrupted: bool = False

    def compare_as_given(self) -> None:
        self._keep(AS_GIVEN, None, compare(self.given, self.measurements), 0.0)

    def go(self, effect_id: str | None, progress: Callable[[float], None]) -> None:
        """Refit with one more effect; None: with none."""
        added = self.added if effect_id is None else (*self.added, effect_id)
        start = self.given
        for added_id in added:
            start = start.with_effect(added_id, None)
        starts = []
        if effect_id is not None:
            refitted = self.fits[-1].model
            given = self.given
            for added_id in self.added:
                given = given.with_effect(added_id, refitted.effects[added_id])
            sizes = sizes_in(self.given, self.measurements)
            starts = list(_starts(given, refitted, effect_id, sizes))
        result = fit(start, self.measurements, starts=starts, progress=progress)
        self.added = added
        self.fits.append(result)
        self.interrupted = result.interrupted
        title = REFIT if effect_id is None else f"+ {effects.BY_ID[effect_id].title}"
        comparison = compare(result.model, self.measurements, result.initial_states)
        self._keep(title, effect_id, comparison, result.findings.effective)

    def _keep(
        self, title: str, added: str | None, comparison: Comparison, effective: float
    ) -> None:
        self.steps.append(
            FittedStep(
                title=title,
                added=added,
                parameters=0 if added is None else len(effects.BY_ID[added].parameters),
                effective=effective,
                comparison=comparison,
                heldout=compare(comparison.model, self.validation) if self.validation else None,
            )
        )

    def addition(self, wanted: tuple[str, ...]) -> Addition:
        """What came of it."""
        last = self.fits[-1]
        return Addition(
            effect_ids=wanted,
            model=named_after(self.given, with_estimates(last.model, last.findings.estimates)),
            steps=tuple(self.steps),
            ladder=climb(self.steps),
            fits=tuple(self.fits),
            interrupted=self.interrupted,
        )


def with_estimates(model: Model, estimates: Sequence[Estimate]) -> Model:
    """The model with the estimates' sigmas as its [uncertainty].

    A further fit to the *same* data would count them twice; they are the prior for new data.
    """
    zeros, sigmas = {}, {}
    for estimate in estimates:
        path, size = estimate.path, abs(estimate.fitted)
        if size <= NOTHING * estimate.sigma:
            zeros[path] = size = 0.0
        sigmas[path] = estimate.sigma / size if size else estimate.sigma
    tree = model.with_values(zeros).model_dump()
    return parse_model(tree | {"uncertainty": tree["uncertainty"] | sigmas}, model.name)


def named_after(given: Model, improved: Model) -> Model:
    """The improved model, called as the one given and by the effects that it has beyond that.

    With Coulomb friction added, "arm" becomes "arm + coulomb friction".
    """
    new_ids = [effect_id for effect_id in improved.effect_ids if effect_id not in given.effect_ids]
    name = " + ".join([given.name, *(effect_id.replace("_", " ") for effect_id in new_ids)])
    return improved.model_copy(update={"name": name})


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
    for held, measurement in product(heldout, fitted):
        if held.shares_samples(measurement):
            raise MeasurementError(
                f"{held.name}: it is held out but shares samples with {measurement.name}, which "
                "is fitted; give another recording, or windows that do not overlap"
            )


def _typical(
    model: Model, parameter: Parameter, multiple: float = 1.0, least: float = 0.0
) -> float:
    value = max(typical_value(model, parameter), least) * multiple
    return min(max(value, parameter.lower), parameter.upper)


def _starts(
    given: Model, refitted: Model, effect_id: str, sizes: Mapping[str, float]
) -> Iterator[Model]:
    """The null on the refitted model, then a grid of effects on both models."""
    yield refitted.with_effect(effect_id, None)
    for origin in (given, refitted):
        for values in _grid(origin, effect_id, sizes):
            with suppress(ModelError):  # the effect may refuse some values together
                yield origin.with_effect(effect_id, values)


def _grid(
    model: Model, effect_id: str, sizes: Mapping[str, float]
) -> Iterator[Mapping[str, float]]:
    """Parameters of an effect to start from: several strengths, at each several shapes.

    Parameters
    ----------
    sizes : by unit, of strengths that matter in the recordings, see `sizes_in`
    """
    parameters = effects.BY_ID[effect_id].parameters
    strengths = [parameter for parameter in parameters if not parameter.shape]
    shapes = [parameter for parameter in parameters if parameter.shape]
    names = [shape.name for shape in shapes]
    signed = any(parameter.lower < 0.0 for parameter in strengths)
    for multiple in _with_signs(STRENGTHS, signed):
        typical = {
            parameter.name: _typical(model, parameter, multiple, sizes.get(parameter.unit, 0.0))
            for parameter in strengths
        }
        for values in product(*(_tried(model, shape) for shape in shapes)):
            yield typical | dict(zip(names, values, strict=True))


def _tried(model: Model, shape: Parameter) -> tuple[float, ...]:
    """Values of a shape from which a search begins, in its unit."""
    if shape.spread is Spread.NULL:
        return (shape.null,)
    multiples = _with_signs(SHAPES, shape.null == 0.0 and shape.lower < 0.0)
    return tuple(_typical(model, shape, multiple) for multiple in multiples)


def _with_signs(multiples: Sequence[float], signed: bool) -> tuple[float, ...]:
    return (*multiples, *(-multiple for multiple in multiples)) if signed else tuple(multiples)
