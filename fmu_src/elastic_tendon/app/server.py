"""Serves the app to this machine's own browser."""

import logging
import secrets
import socket
from collections.abc import Mapping
from dataclasses import dataclass
from ipaddress import ip_address
from pathlib import Path
from typing import Any

import waitress
from dash import Dash

from elastic_tendon.app import requests, safety, shell
from elastic_tendon.app.document import Document
from elastic_tendon.app.session_file import SessionFile
from elastic_tendon.app.steps import STEPS
from elastic_tendon.app.worded import word_answers
from elastic_tendon.app.workspace import Workspace
from elastic_tendon.output import OutputError

LOOPBACK = "127.0.0.1"
THREADS = 12  # that answer requests; a browser has six under way at a time


@dataclass(frozen=True)
class Served:
    """An app that listens; `run` answers requests until it is interrupted."""

    url: str
    workspace: Workspace
    _server: Any

    def run(self) -> None:
        """Answer requests until `close` or an interrupt."""
        self._server.run()

    def close(self) -> None:
        """Stop listening and all work, and delete what was uploaded."""
        self._server.close()
        self.workspace.close()


def listen(
    start: Document,
    files: Mapping[str, Path],
    *,
    address: str = LOOPBACK,
    port: int = 0,
    kept: SessionFile | None = None,
) -> Served:
    """Make the app and listen.

    Parameters
    ----------
    start : what a new session begins with
    files : key -> path of the files that it may use
    address : of this machine, on which to listen; anything but loopback lets others in
    port : 0: a free one
    kept : file of the session; on loopback the page is where it was before, so that a page that is
        still open goes on when it is reloaded

    Returns
    -------
    Served

    Raises
    ------
    OutputError : the address or port cannot be used
    """
    listening, token = _place(address, port, kept)
    alone = ip_address(address).is_loopback
    workspace = Workspace(start, files, kept, shared=not alone)
    bound, reached = listening.getsockname()[1], _host(address)
    app = dash_app(workspace, token)
    names = {reached, "localhost", LOOPBACK} if alone else {reached}
    safety.protect(app.server, {f"{name}:{bound}" for name in names}, token, app.csp_hashes)
    requests.check(app)
    # that requests wait for each other while a step opens is nothing to tell
    logging.getLogger("waitress.queue").setLevel(logging.ERROR)
    server = waitress.create_server(
        app.server,
        sockets=[listening],
        threads=THREADS,
        ident=None,
        max_request_body_size=safety.BODY,
        clear_untrusted_proxy_headers=True,
    )
    return Served(f"http://{reached}:{bound}/{token}/", workspace, server)


def dash_app(workspace: Workspace, token: str) -> Dash:
    """The app itself, every path of which begins with the token."""
    app = Dash(
        __package__,
        title="elastic-tendon",
        update_title="",
        url_base_pathname=f"/{token}/",
        serve_locally=True,
        suppress_callback_exceptions=True,
        assets_folder=str(Path(__file__).parent / "assets"),
    )
    app.index_string = app.index_string.replace("<html>", '<html lang="en">')
    app.enable_dev_tools(debug=False)
    app.layout = lambda: shell.layout(STEPS, workspace.name)
    shell.register(app, workspace, STEPS)
    for step in STEPS:
        step.register(app, workspace)
    word_answers(app, workspace)
    return app


def _place(address: str, port: int, kept: SessionFile | None) -> tuple[socket.socket, str]:
    """Where to listen, and the secret part of the path: as before where it can be.

    What other machines may reach has another secret each time: a session's file may be passed on.
    """
    token = secrets.token_urlsafe(24)
    if kept is None or address != LOOPBACK:
        return _bound(address, port), token
    before, token = kept.get("port"), kept.get("token") or token
    try:
        listening = _bound(address, port or int(before or 0))
    except OutputError:
        if port or not before:
            raise
        listening = _bound(address, 0)
    kept.put("port", str(listening.getsockname()[1]))
    kept.put("token", token)
    return listening, token


def _bound(address: str, port: int) -> socket.socket:
    try:
        family = socket.AF_INET6 if ip_address(address).version == 6 else socket.AF_INET
        return socket.create_server((address, port), family=family)
    except (OSError, OverflowError, ValueError) as error:
        raise OutputError(
            f"cannot listen on {address}, port {port} ({error}); give another one"
        ) from None


def _host(address: str) -> str:
    return f"[{address}]" if ":" in address else address
