"""Who may talk to the app: this machine's own browser, by the URL that was printed, no one else.

A page on another site can make a browser send requests to this machine, and can give its own name
this machine's address (DNS rebinding). Such requests carry a foreign Host, Origin or
Sec-Fetch-Site, and do not know the token in the path.
"""

from collections.abc import Callable, Collection
from hmac import compare_digest

from flask import Flask, Response, abort, request

from elastic_tendon.app.requests import text

UPLOAD = 25 * 1024 * 1024  # bytes of a file
# base64 makes four characters of three bytes; beside the file there is the session's document
BODY = UPLOAD * 4 // 3 + 4 * 1024 * 1024

_HEADERS = {
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",  # the URL holds the token
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
}
# scripts and styles are the same as long as the app runs; all else may hold a user's data
_KEPT = ("_dash-component-suites", "assets")


def policy(script_hashes: Collection[str]) -> str:
    """Content-Security-Policy: all from the app itself; nothing of what users write can run.

    Parameters
    ----------
    script_hashes : of the page's inline scripts, each in quotes as the policy wants it
    """
    scripts = " ".join(script_hashes)
    return (
        f"default-src 'self'; script-src 'self' {scripts}; style-src 'self' 'unsafe-inline'; "
        "img-src 'self' data: blob:; object-src 'none'; base-uri 'none'; form-action 'none'; "
        "frame-ancestors 'none'"
    )


def protect(
    server: Flask, hosts: Collection[str], token: str, script_hashes: Callable[[], Collection[str]]
) -> None:
    """Refuse foreign requests before the app sees them.

    Parameters
    ----------
    server : Flask
    hosts : values of the Host header by which the app is reached, with the port
    token : first part of every path
    script_hashes : hashes of the page's inline scripts, asked for once the page is complete
    """
    server.config["MAX_CONTENT_LENGTH"] = BODY
    allowed = frozenset(hosts)
    origins = frozenset(f"http://{host}" for host in hosts)

    @server.before_request
    def refuse_strangers() -> None:
        if request.host not in allowed:
            abort(text(403, "This name is not the app's; open the URL that it printed."))
        origin = request.headers.get("Origin")
        if origin is not None and origin not in origins:
            abort(text(403, "Another site sent this; open the URL that the app printed."))
        if request.headers.get("Sec-Fetch-Site") in ("cross-site", "same-site") and not _is_link():
            abort(text(403, "Another site sent this; open the URL that the app printed."))
        given = request.path.split("/")[1]
        if not compare_digest(given.encode(), token.encode()):
            abort(text(404, "There is nothing here; open the whole URL that the app printed."))
        if (request.content_length or 0) > BODY:
            abort(text(413, "This is too large; name the file on the command line instead."))

    @server.after_request
    def harden(response: Response) -> Response:
        response.headers.update(_HEADERS)
        _, _, part, *_ = f"{request.path}//".split("/")
        lasting = request.method == "GET" and part in _KEPT
        response.headers["Cache-Control"] = "private, max-age=86400" if lasting else "no-store"
        response.headers["Content-Security-Policy"] = policy(script_hashes())
        return response


def _is_link() -> bool:
    """Whether a link to the whole page was followed, which changes nothing."""
    mode = request.headers.get("Sec-Fetch-Mode"), request.headers.get("Sec-Fetch-Dest")
    return request.method == "GET" and mode == ("navigate", "document")
