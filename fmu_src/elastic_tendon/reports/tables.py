"""Tables and sentences for the terminal; numbers come ready from `design` and `identify`."""

from collections.abc import Collection, Mapping, Sequence
from itertools import pairwise
from math import floor, log10, nan
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.table import Table

from elastic_tendon import effects
from elastic_tendon.actuator.design import DesignTable
from elastic_tendon.actuator.interfaces import InterfaceKind
from elastic_tendon.actuator.quantity import unit_text
from elastic_tendon.effects.base import Effect
from elastic_tendon.estimation.add import Addition
from elastic_tendon.estimation.determinability import Estimate, Findings
from elastic_tendon.estimation.ladder import Step
from elastic_tendon.reports.names import at_dots
from elastic_tendon.reports.units import Shown, noise_ratio, number, shown, times_noise

# relative change of a held-out error that is worth a word
NOTICEABLE = 1e-3
# of a number, the half width of its interval from which on its sixth digit is not sure
SURE = 1e-6

TIGHT: dict[str, Any] = {"box": SIMPLE_HEAD, "padding": (0, 1, 0, 0)}  # columns of a table

NEXT_AFTER_DEMO = """
Try next, with your own recording (columns time_s, motor_position_rad, joint_position_rad):
  elastic-tendon compare biorob_x4_joint_3 recording.csv
  elastic-tendon diagnose biorob_x4_joint_3 recording.csv
  elastic-tendon effects"""


def design_table(name: str, table: DesignTable) -> Table:
    """Design numbers with symbol, equation of the paper and unit."""
    shown_table = Table(title=f"{name}: design by the paper's equations")
    for heading, justify in (("quantity", "left"), ("symbol", "left"), ("equation", "left")):
        shown_table.add_column(heading, justify=justify)  # type: ignore[arg-type]
    shown_table.add_column("value", justify="right")
    shown_table.add_column("unit")
    for row in table.rows().values():
        value = f"{row.value:.4g}"
        shown_table.add_row(row.name, row.symbol, row.equation, value, unit_text(row.unit))
    return shown_table


def ladder_table(steps: Sequence[Step]) -> Table:
    """RMS error after each step, in words; one section for each signal."""
    heldout = any(step.heldout_rmse for step in steps)
    table = Table(title="The error after each step (RMS)", box=SIMPLE_HEAD)
    table.add_column("signal", no_wrap=True)
    table.add_column("step", no_wrap=True)
    table.add_column("fitted\ndata", justify="right", no_wrap=True)
    if heldout:
        table.add_column("held-out\ndata", justify="right", no_wrap=True)
    table.add_column("times\nnoise", justify="right")
    for name in steps[0].rmse:
        quantity = shown(name)
        for index, step in enumerate(steps):
            errors = [step.rmse[name]]
            if heldout:
                errors.append(step.heldout_rmse.get(name, nan))
            table.add_row(
                "" if index else quantity.words,
                step.title,
                *(quantity.error(error) for error in errors),
                noise_ratio(step.noise_ratio[name]),
            )
        table.add_section()
    return table


def estimates_table(findings: Findings) -> Table:
    """Estimated parameters with interval; those the data leave open are said to be so."""
    table = Table(title="What was fitted, with 95 % intervals", **TIGHT)
    table.add_column("parameter", overflow="fold")  # may break: a cut figure is wrong
    table.add_column("given", justify="right", no_wrap=True)
    table.add_column("fitted", no_wrap=True)
    table.add_column("unit", no_wrap=True)
    for estimate in findings.every:
        name, *numbers = estimate_cells(estimate)
        table.add_row(at_dots(name), *numbers)
    table.caption = open_note(findings) or None
    return table


def estimate_cells(estimate: Estimate) -> tuple[str, str, str, str]:
    """An estimated parameter: its name, as given, as fitted with its interval, and its unit."""
    fitted = with_interval(estimate.fitted, estimate.interval)
    return (
        estimate.name.removeprefix("transmission.").removeprefix("effects."),
        four_digits(estimate.given),
        fitted if estimate.determined else f"{four_digits(estimate.fitted)} (open)",
        unit_text(estimate.unit),
    )


def four_digits(value: float) -> str:
    """Four digits that count, without an exponent where the number is of everyday size."""
    everyday = value != 0.0 and 4 <= floor(log10(abs(value))) < 7
    return f"{value:.0f}" if everyday else f"{value:.4g}"


def open_note(findings: Findings) -> str:
    """What "open" means in a table of estimated parameters, "" where none is."""
    if all(estimate.determined for estimate in findings.every):
        return ""
    return "open: not determined by these data; any value near what was given would do"


def ratios_table(findings: Findings) -> Table:
    """What the data determine where they leave a common scale open; J is the link's inertia."""
    table = Table(title="Determined as ratios only, with 95 % intervals", **TIGHT)
    table.add_column("ratio", overflow="fold")
    table.add_column("fitted", no_wrap=True)
    table.add_column("unit", no_wrap=True)
    for ratio in findings.ratios:
        table.add_row(
            at_dots(ratio.name.removeprefix("transmission.")),
            with_interval(ratio.value, ratio.interval),
            unit_text(ratio.unit),
        )
    return table


def with_interval(value: float, interval: tuple[float, float]) -> str:
    """Value and half width with two digits of the latter; both ends where they differ in width.

    Of an interval that is narrower than the sixth digit, as of data without noise, only that is
    said.
    """
    below, above = value - interval[0], interval[1] - value
    if above <= 0.0 or abs(above - below) > 0.01 * above:
        return f"{value:.3g} ({interval[0]:.3g} to {interval[1]:.3g})"
    if above < SURE * abs(value):
        sixth = 10.0 ** (floor(log10(abs(value))) - 5)
        return f"{value:#.6g}".rstrip(".") + f" ± <{sixth:g}"
    decimals = max(0, 1 - floor(log10(above)))
    if decimals > 7:
        return f"{value:.4g} ± {above:.2g}"
    return f"{value:.{decimals}f} ± {above:.{decimals}f}"


def addition_sentences(addition: Addition) -> list[str]:
    """What adding the effects did, in words."""
    first, last = addition.ladder[0], addition.ladder[-1]
    sentences = fall_sentences(first, last)
    for before, after in pairwise(addition.ladder):
        if after.added is not None:
            sentences += distrust_sentences(before, after)
            sentences += alias_sentences(effects.BY_ID[after.added])
    fitted = [step.added for step in addition.ladder]
    if left := [effect_id for effect_id in addition.effect_ids if effect_id not in fitted]:
        verb = "was" if len(left) == 1 else "were"
        pronoun = "it is" if len(left) == 1 else "they are"
        names = " and ".join(left)
        sentences.append(f"Stopped before {names} {verb} fitted: {pronoun} not in the model.")
    return sentences


def fall_sentences(first: Step, last: Step, *, static: bool = False) -> list[str]:
    """How the error of each signal changed between two steps, in its unit and beside the noise.

    Parameters
    ----------
    first, last : Step, maybe the same
    static : of static curves
    """
    sentences = []
    for name in last.rmse:
        quantity = shown(name, static=static)
        pairs = [_pair(step.rmse, step.noise_ratio, name) for step in (first, last)]
        fell = pairs[1][0] < pairs[0][0]
        text = _change(quantity, *pairs)
        if name in last.heldout_rmse:
            unseen = [
                _pair(step.heldout_rmse, step.heldout_noise_ratio, name) for step in (first, last)
            ]
            fell = fell and unseen[1][0] < unseen[0][0]
            text += f"; on data that no fit has seen {_change(quantity, *unseen)}"
        verb = "is" if first is last else "falls" if fell else "goes"
        sentences.append(f"The {quantity.words} error {verb} {text}.")
    return sentences


def _pair(rmse: Mapping[str, float], ratio: Mapping[str, float], name: str) -> tuple[float, float]:
    return rmse[name], ratio[name]


def _change(quantity: Shown, before: tuple[float, float], after: tuple[float, float]) -> str:
    """As "from 37.5 to 0.229 mrad, from 162 to 0.99 times the noise"; one end where both agree."""
    if before == after:
        return f"{quantity.error(after[0])}, {times_noise(after[1])}"
    return (
        f"from {number(before[0] * quantity.small)} to {quantity.error(after[0])}, from "
        f"{noise_ratio(before[1])} to {times_noise(after[1])}"
    )


def alias_sentences(
    effect: Effect,
    refitted: Collection[str] = (),
    kind: InterfaceKind = InterfaceKind.POSITION,
) -> list[str]:
    """What no measurement of the joint can tell the effect from, but for what was judged by one,
    and what a link without springs cannot have."""
    return [
        f"{effect.title} cannot be distinguished from {' and '.join(alias.of)} as long as "
        f"{alias.when}."
        for alias in effects.BY_ID.aliases_of(effect)
        if not set(alias.of) <= set(refitted) and all(_has(kind, like) for like in alias.of)
    ]


def _has(kind: InterfaceKind, like: str) -> bool:
    """Whether an interface has what an alias names: an effect, or a number of model.toml."""
    effect = effects.BY_ID.find(like)
    return kind.has_quantity(like) if effect is None else kind.has_slot(effect.slot)


def distrust_sentences(before: Step, after: Step) -> list[str]:
    """Why a step that added an effect is not to be trusted; none where nothing speaks against it.

    Parameters
    ----------
    before : the step before
    after : with the effect
    """
    sentences = []
    title = effects.BY_ID[after.added].title if after.added else after.title
    if after.evidence >= before.evidence:
        sentences.append(
            f"These data do not ask for {title}: its gain over the step before is no more than "
            "its additional freedom explains."
        )
    worse = [
        shown(name).words
        for name, value in after.heldout_rmse.items()
        if value > (1.0 + NOTICEABLE) * before.heldout_rmse[name]
    ]
    if worse:
        sentences.append(
            f"On held-out data {title} makes the error of {', '.join(worse)} larger; do not "
            "trust it."
        )
    return sentences
