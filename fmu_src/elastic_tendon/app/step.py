"""What a step of the page is: a title, a place for errors, a layout, and its callbacks."""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from dash import Dash, Input, State, dcc, html
from dash.development.base_component import Component

from elastic_tendon.app.document import Document
from elastic_tendon.app.results import Files
from elastic_tendon.app.workspace import Result, Workspace


@dataclass(frozen=True)
class PageStep:
    """One step of the page.

    `id` : begins the ids of all its components. `title` : in the list of steps. `layout` : what it
    shows before its callbacks have run. `register` : connects its callbacks; they find a session's
    results in its cache and never wait for one. `needs` : results that it shows, in the order in
    which they are computed while the step is open; one that fails does not keep the others back.
    `tells_failures` : it says itself why they failed, where it shows them.
    """

    id: str
    title: str
    layout: Callable[[], Sequence[Component]]
    register: Callable[[Dash, Workspace], None]
    needs: Callable[[Document, Files], Sequence[Result[Any]]]
    tells_failures: bool = False


def aria(**attributes: str) -> dict[str, Any]:
    """Attributes ``aria-...`` for readers of the screen, as keywords of a component."""
    return {f"aria-{name}": value for name, value in attributes.items()}


def dom_id(component_id: Mapping[str, str]) -> str:
    """How the browser calls a component whose id is a table."""
    return json.dumps(component_id, sort_keys=True, separators=(",", ":"))


def while_open(step_id: str) -> tuple[Input, State]:
    """What callbacks of a step are given first: the session, and the id of the step that is open.

    They are asked when the step is opened, and then at all news of the session. Were it the session
    itself, all its news would be asked of every step, also of those that nobody sees.
    """
    return Input(f"{step_id}-session", "data"), State("open", "data")


def section(step: PageStep, following: PageStep | None, *, opened: bool) -> html.Section:
    """A step on the page: heading, way on, what went wrong in a sentence, and its own layout."""
    way_on = html.Button(
        f"Next: {following.title}" if following else "",
        id={"next": following.id if following else ""},
        className="plain",
        hidden=following is None,
    )
    return html.Section(
        [
            html.Div(
                [html.H2(step.title, id=f"{step.id}-heading", tabIndex=-1), way_on],
                className="head",
            ),
            html.P(id={"sentence": step.id}, className="sentence", role="alert"),
            dcc.Store(id=f"{step.id}-session"),  # as it was when the step was open last
            *step.layout(),
        ],
        id={"section": step.id},
        className="step",
        hidden=not opened,
        **aria(labelledby=f"{step.id}-heading"),
    )
