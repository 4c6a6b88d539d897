"""What a browser may send to the app's callbacks, and what it is told where it gets no answer."""

from typing import Annotated, Any

from dash import Dash
from flask import Response, abort, make_response, request
from pydantic import BaseModel, Field, ValidationError
from werkzeug.exceptions import HTTPException

from elastic_tendon.app.workspace import fault_sentence
from elastic_tendon.errors import ElasticTendonError

CALLBACKS = "_dash-update-component"  # last part of the path to which callbacks are posted


class Place(BaseModel):
    """A property of a component of the page."""

    id: str | dict[str, Any]
    property: str


Places = list[Place | list[Place]]  # a pattern stands for several


class Call(BaseModel):
    """The call of a callback, as the page's scripts post it."""

    output: str
    outputs: Place | Places | None = None
    inputs: Places
    state: Places = []
    changed: Annotated[list[str], Field(alias="changedPropIds")] = []


def check(app: Dash) -> None:
    """Answer what no callback can be called with, and every fault, by one plain sentence."""

    @app.server.before_request
    def refuse_malformed() -> None:
        called = request.method == "POST" and request.path.endswith(f"/{CALLBACKS}")
        if called and not _is_call(app, request.get_json(silent=True)):
            abort(text(400, "This is no call of the page's callbacks; reload the page."))

    @app.server.errorhandler(ElasticTendonError)
    def tell(error: ElasticTendonError) -> Response:
        return text(400, f"{error}.")

    @app.server.errorhandler(HTTPException)
    def tell_fault(error: HTTPException) -> Response:
        cause = getattr(error, "original_exception", None)
        fault = cause and f"{fault_sentence('this call', cause)}."
        return text(error.code or 500, fault or str(error.description))


def _is_call(app: Dash, body: object) -> bool:
    """Whether a callback of the page can be called with the body of a request."""
    try:
        call = Call.model_validate(body)
    except ValidationError:
        return False
    callback = app.callback_map.get(call.output)
    return (
        callback is not None
        and "callback" in callback  # others run in the browser
        and isinstance(call.outputs, list) == call.output.startswith("..")  # of several outputs
        and len(call.inputs) == len(callback["inputs"])
        and len(call.state) == len(callback["state"])
    )


def text(status: int, sentence: str) -> Response:
    """A sentence as an answer."""
    headers = {"Content-Type": "text/plain; charset=utf-8"}
    return make_response((f"{sentence}\n", status, headers))
