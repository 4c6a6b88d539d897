"""Answers to the page in the units and words of a machine that slides, see `reports.worded`.

Texts and figures of the app are made for a machine that turns. The step Data is left as it is: it
shows recordings in units of their own, which need not be those of the model.
"""

from collections.abc import Iterator, Mapping
from typing import Any

from dash import Dash
from flask import Response, request

from elastic_tendon.actuator.motion_kind import MotionKind
from elastic_tendon.app.requests import CALLBACKS
from elastic_tendon.app.workspace import Workspace
from elastic_tendon.reports.worded import worded_tree

_AS_IT_IS = ("Pre", "Textarea")  # components that hold code
# properties of components, and parts of options, in which people read
_READ = ("children", "label", "options", "placeholder", "props", "title", "aria-label")
_OWN_UNITS = ("data-", '{"data-')  # how ids of the step Data begin


def word_answers(app: Dash, workspace: Workspace) -> None:
    """Put what callbacks answer into the words of the model of the session that they are asked by.

    Parameters
    ----------
    app : with all its callbacks
    workspace : Workspace
    """

    @app.server.after_request
    def word(response: Response) -> Response:
        if not (request.path.endswith(f"/{CALLBACKS}") and response.is_json):
            return response
        motion = _motion(request.get_json(silent=True), workspace)
        if motion is not MotionKind.ROTARY:
            answer = response.get_json()
            answer["response"] = {
                place: told if place.startswith(_OWN_UNITS) else worded(told, motion)
                for place, told in answer.get("response", {}).items()
            }
            response.set_data(app.server.json.dumps(answer))
        return response


def worded(value: Any, motion: MotionKind) -> Any:
    """Properties, components and options, at any depth, in the words of this motion.

    Parameters
    ----------
    value : as Dash sends it to the browser
    motion : MotionKind
    """
    if isinstance(value, str):
        return motion.words(value)
    if isinstance(value, list):
        return [worded(item, motion) for item in value]
    if not isinstance(value, dict) or value.get("type") in _AS_IT_IS:
        return value
    read = {name: worded(value[name], motion) for name in _READ if name in value}
    drawn = {"figure": worded_tree(value["figure"], motion)} if "figure" in value else {}
    return {**value, **read, **drawn}


def _motion(call: Any, workspace: Workspace) -> MotionKind:
    """How the machine of the session moves that asks; where none does, nothing is told of one."""
    for stored in _sessions(call):
        return workspace.open(stored).document.version.loaded().motion
    return MotionKind.ROTARY


def _sessions(call: Any) -> Iterator[Mapping[str, Any]]:
    for asked in (*call["inputs"], *call.get("state", ())):
        value = asked.get("value") if isinstance(asked, dict) else None
        if isinstance(value, dict) and "document" in value:
            yield value
