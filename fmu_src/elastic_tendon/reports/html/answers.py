"""What a diagnosis leaves: the improved model's parameters, what was added, its linear models."""

import tomllib
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import tomli_w

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.quantity import unit_text
from elastic_tendon.diagnosis.learned import learned_effect
from elastic_tendon.diagnosis.result import Diagnosis
from elastic_tendon.effects import BY_ID
from elastic_tendon.effects.base import LAW_SYMBOLS, Effect
from elastic_tendon.errors import LinearisationError
from elastic_tendon.estimation.determinability import Findings
from elastic_tendon.linear.linearise import linearise
from elastic_tendon.linear.result import Drive, LinearModel
from elastic_tendon.reports.comparison_tables import STATES
from elastic_tendon.reports.html.blocks import (
    Block,
    Code,
    Heading,
    Listing,
    Paragraphs,
    as_table,
    plot,
)
from elastic_tendon.reports.interactive.bode import bode
from elastic_tendon.reports.linear_tables import linear_table, remarks
from elastic_tendon.reports.tables import estimates_table, ratios_table


def numbers(diagnosis: Diagnosis) -> Iterator[Block]:
    """What was fitted, with intervals and units; then the whole model."""
    findings = diagnosis.findings
    if findings.estimates:
        yield as_table(estimates_table(findings))
    if findings.ratios:
        yield as_table(ratios_table(findings))
    text = tomli_w.dumps(_rounded(tomllib.loads(diagnosis.model.to_toml())))
    yield Code(f"The improved model, {diagnosis.model.name}, as model.toml, to six digits", text)


def _rounded(tree: Any) -> Any:
    """The same tree with numbers that people can read."""
    if isinstance(tree, dict):
        return {key: _rounded(value) for key, value in tree.items()}
    if isinstance(tree, list):
        return [_rounded(value) for value in tree]
    return float(f"{tree:.6g}") if isinstance(tree, float) else tree


# ---- what was added ----------------------------------------------------------------------------


def equations(diagnosis: Diagnosis) -> Iterator[Block]:
    """Each effect that was added, and the term that is offered: law, numbers, how to make sure."""
    if not diagnosis.added and diagnosis.learned is None:
        yield Paragraphs(("No effect was added: the equations are those of the model as given.",))
        return
    yield Paragraphs((LAW_SYMBOLS,))
    for effect_id in diagnosis.added:
        yield from _effect(BY_ID[effect_id])
        own = _of_effect(diagnosis.findings, effect_id)
        if own.estimates:
            yield as_table(estimates_table(own), f"{BY_ID[effect_id].title}: estimated parameters")
    if (term := diagnosis.learned) is not None:
        effect = learned_effect(term)
        yield from _effect(effect)
        yield Paragraphs(("It was learned from these data and is offered, not added.",))
        yield Listing(tuple((name, f"{value:g}") for name, value in term.values.items()))


def _of_effect(findings: Findings, effect_id: str) -> Findings:
    estimates, of_recordings = (
        tuple(part for part in parts if part.path.startswith(f"effects.{effect_id}."))
        for parts in (findings.estimates, findings.of_recordings)
    )
    return replace(findings, estimates=estimates, of_recordings=of_recordings)


def _effect(effect: Effect) -> Iterator[Block]:
    yield Heading(f"{effect.title} ({effect.id})")
    if effect.law:
        yield Code("Law", effect.law)
    facts = (
        ("What it is", effect.physics),
        *(
            (f"{parameter.name} ({unit_text(parameter.unit)})", parameter.meaning)
            for parameter in effect.parameters
        ),
        ("How it shows in data", effect.in_data),
        ("Easily confused with", effect.confused_with),
        ("How to make sure", effect.confirm),
        ("Cure", effect.cure),
        ("Reference", effect.reference),
    )
    yield Listing(tuple(item for item in facts if item[1]))


# ---- linear models -----------------------------------------------------------------------------


def linear_models(diagnosis: Diagnosis) -> Iterator[Block]:
    """Poles, stiffness and damping in each slack state, and the response to the motor."""
    runs = [("as given", diagnosis.given), ("improved", diagnosis.model)]
    if not _differ(diagnosis.given, diagnosis.model):
        runs = [("as given", diagnosis.given)]
    tables: list[Block] = []
    responses = []
    for label, model in runs:
        by_state, faults = _in_states(model, Drive.SOURCE)
        if by_state:
            models = list(by_state.values())
            tables += [
                as_table(linear_table(model.name, models), f"{model.name}, {label}"),
                Paragraphs(tuple(remarks(models)), "faint"),
            ]
        tables += [Paragraphs(faults)] if faults else []
        responses.append((label, _in_states(model, Drive.POSITION)[0]))
    if any(models for _, models in responses):
        yield plot(
            lambda theme: bode(responses, theme=theme),
            "Response of the joint's position to that of the motor in each slack state: magnitude "
            "above, phase below.",
        )
    yield from tables


def _differ(first: Model, second: Model) -> bool:
    """Whether two models move differently; names and uncertainties aside."""
    plain = [model.model_dump(exclude={"name", "uncertainty"}) for model in (first, second)]
    return plain[0] != plain[1]


def _in_states(model: Model, drive: Drive) -> tuple[dict[str, LinearModel], tuple[str, ...]]:
    """Linear models by slack state, and a sentence for each state that has none."""
    models: dict[str, LinearModel] = {}
    faults = []
    for state in STATES:
        try:
            models[state] = linearise(model, state, drive=drive)
        except LinearisationError as error:
            faults.append(f"There is no linear model of state {state}: {error}.")
    return models, tuple(faults)
