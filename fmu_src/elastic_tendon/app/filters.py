"""Which samples Compare looks at: what the page offers, and the conditions that follow from it."""

from collections.abc import Sequence
from typing import Any

from dash import dcc, html
from dash.development.base_component import Component

from elastic_tendon.app.choice import choice
from elastic_tendon.comparison.conditions import DIMENSIONS
from elastic_tendon.reports.comparison_tables import STATES
from elastic_tendon.reports.units import with_unit

# fields by the ends of their ids, in the order of `conditions`
FIELDS = ("state", "moving", "quantity", "low", "high")
ALL = "all"  # what is chosen where nothing is asked for
_KEPT: Any = {"persistence": True, "persistence_type": "session"}  # for a reload
_STATES = {f"slack_state={state}": words for state, words in STATES.items()}
_MOVING = {
    f"{by}_velocity{sign}0": f"{by} velocity {words} 0"
    for by in ("joint", "motor")
    for sign, words in ((">", "above"), ("<", "below"))
}
_RANGES = {quantity: with_unit(quantity) for quantity in DIMENSIONS}
_CHOICES = {
    "state": ("Only slack state", _STATES),
    "moving": ("Only while", _MOVING),
    "quantity": ("Only a range of", _RANGES),
}


def filters(step: str) -> list[Component]:
    """Choices of samples; `step` begins their ids. Those of a range are filled in by `ranges`."""
    return [
        *(_choice(f"{step}-{field}", *offered) for field, offered in _CHOICES.items()),
        *(_end(f"{step}-{end}", words) for end, words in (("low", "from"), ("high", "to"))),
    ]


def ranges() -> list[dict[str, str]]:
    """Quantities of which a range can be chosen, with their units."""
    return _options(_RANGES)


def _options(offered: dict[str, str]) -> list[dict[str, str]]:
    labels = {ALL: "all samples", **offered}
    return [{"value": value, "label": label} for value, label in labels.items()]


def _choice(component_id: str, words: str, offered: dict[str, str]) -> Component:
    options = _options(offered)
    look = {"clearable": False, "searchable": False, "className": "chooser"}
    return choice(component_id, words, options=options, value=ALL, **look, **_KEPT)


def _end(component_id: str, words: str) -> Component:
    field = dcc.Input(id=component_id, type="number", step="any", debounce=True, **_KEPT)
    return html.Label([words, field], htmlFor=component_id, className="seconds")


def conditions(
    state: str,
    moving: str,
    quantity: str,
    low: float | str | None,
    high: float | str | None,
) -> Sequence[str]:
    """What the fields ask for, as `comparison.conditions.parse_condition` reads it.

    Parameters
    ----------
    state, moving : conditions, `ALL` where there is none
    quantity, low, high : a range, SI, `ALL` where there is none; an end that is empty is open
    """
    chosen = [condition for condition in (state, moving) if condition != ALL]
    ends = ["" if end in (None, "") else f"{end:.12g}" for end in (low, high)]
    if quantity != ALL and all(ends):
        chosen.append(f"{quantity}={ends[0]}..{ends[1]}")
    elif quantity != ALL:
        chosen += [
            f"{quantity}{sign}{end}" for sign, end in zip((">=", "<="), ends, strict=True) if end
        ]
    return chosen
