"""Curves that follow a slider while it moves, past the page's callbacks: a hand is faster."""

from base64 import b64encode
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any
from weakref import WeakKeyDictionary

from dash import Dash
from flask import Response, jsonify, make_response, request
from pydantic import BaseModel, ValidationError

from elastic_tendon.actuator.quantity import STRICT
from elastic_tendon.app.document import Version
from elastic_tendon.app.readings import Window
from elastic_tendon.app.requests import text
from elastic_tendon.app.sliders import moved_runs
from elastic_tendon.app.workspace import Session, Workspace
from elastic_tendon.comparison.comparison import FileComparison
from elastic_tendon.comparison.residuals import Array
from elastic_tendon.reports.interactive.overlay import Run, run_curves

BUCKETS = 800  # of curves; more than the page can distinguish
PATH = "moved"  # below the token


@dataclass(frozen=True)
class Seen:
    """What the curves beside the sliders show; `key` changes with any of it.

    `first` : place of the sliders' own curves in the figure.
    """

    key: str
    version: Version
    file: FileComparison
    signal: str
    window: Window | None
    first: int


class Asked(BaseModel):
    """A question of the page: `values` to which sliders were moved, SI, by dotted path."""

    model_config = STRICT

    id: str
    key: str
    values: dict[str, float]


_SEEN: WeakKeyDictionary[Session, Seen] = WeakKeyDictionary()


def note(session: Session, seen: Seen) -> None:
    """Remember what a session's page shows."""
    _SEEN[session] = seen


def moved_curves(run: Run, signal: str, window: Window | None) -> list[dict[str, Any]]:
    """What changes of the sliders' own curves, numbers as plotly's script takes them."""
    curves = run_curves(run, signal, window=window, buckets=BUCKETS)
    return [
        {name: part if isinstance(part, str) else _packed(part) for name, part in curve.items()}
        for curve in curves
    ]


def _packed(values: Array) -> dict[str, str]:
    """Numbers that are read faster than text."""
    return {"dtype": "f8", "bdata": b64encode(values.tobytes()).decode()}


def answer(seen: Seen | None, key: str, values: Mapping[str, float]) -> dict[str, Any] | None:
    """The sliders' curves and the place of the first; None where the page shows something else by
    now, or no such model can be simulated, which the page's callbacks tell."""
    if seen is None or seen.key != key:
        return None
    held = {"of": seen.version.mark, "values": values}
    runs, _ = moved_runs(seen.version, seen.file, held, seen.window)
    if not runs:
        return None
    return {"first": seen.first, "curves": moved_curves(runs[-1], seen.signal, seen.window)}


def serve(app: Dash, workspace: Workspace) -> None:
    """Answer the page's sliders."""

    @app.server.post(f"{app.config.url_base_pathname}{PATH}")
    def moved() -> Response:
        try:
            asked = Asked.model_validate(request.get_json(silent=True))
        except ValidationError:
            return text(400, "This is no question of the page's sliders; reload the page.")
        session = workspace.find(asked.id)
        found = session and answer(_SEEN.get(session), asked.key, asked.values)
        return jsonify(found) if found else make_response("", 204)
