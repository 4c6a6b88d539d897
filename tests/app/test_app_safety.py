"""Who may talk to the app: real requests to the real server."""

import http.client
import json
import socket
from collections.abc import Iterator
from contextlib import suppress
from urllib.parse import urlsplit

import pytest

from app_process import served
from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.app import safety
from elastic_tendon.app.document import new_document
from elastic_tendon.app.server import listen
from elastic_tendon.output import OutputError

MODEL = load_model("biorob_x4_joint_3")


@pytest.fixture(scope="module")
def app() -> Iterator[str]:
    with served() as url:
        yield url


def ask(
    app: str,
    path: str | None = None,
    *,
    method: str = "GET",
    body: bytes | None = None,
    **headers: str,
) -> tuple[int, str, http.client.HTTPMessage]:
    """Status, text and headers of the answer; the path is the app's own where none is given."""
    url = urlsplit(app)
    connection = http.client.HTTPConnection(str(url.hostname), url.port, timeout=20)
    named = {name.replace("_", "-"): value for name, value in headers.items()}
    connection.request(method, path or url.path, body, named)
    answer = connection.getresponse()
    text = answer.read().decode(errors="replace")
    connection.close()
    return answer.status, text, answer.headers


def test_the_printed_url_is_answered(app: str) -> None:
    status, text, headers = ask(app)
    assert status == 200
    assert "elastic-tendon" in text
    assert headers["X-Frame-Options"] == "DENY"
    assert headers["Referrer-Policy"] == "no-referrer"
    assert "default-src 'self'" in headers["Content-Security-Policy"]
    assert "unsafe-eval" not in headers["Content-Security-Policy"]


def test_what_is_no_question_of_the_sliders_gets_a_sentence(app: str) -> None:
    path = urlsplit(app).path + "moved"
    kind = {"Content_Type": "application/json"}
    for body in (b"", b"{}", b"[]", b'{"id": "", "key": "", "values": {"link.inertia": "x"}}'):
        status, told, _ = ask(app, path, method="POST", body=body, **kind)
        assert status == 400
        assert "no question of the page's sliders" in told
    unknown = b'{"id": "nobody", "key": "", "values": {"link.inertia": 1.0}}'
    assert ask(app, path, method="POST", body=unknown, **kind)[:2] == (204, "")
    assert ask(app, "/wrong/moved", method="POST", body=unknown, **kind)[0] == 404


def test_a_browser_keeps_scripts_and_nothing_of_the_user(app: str) -> None:
    own = urlsplit(app).path
    kept = {
        path: ask(app, own + path)[2]["Cache-Control"]
        for path in ("", "_dash-layout", "assets/session.js")
    }
    assert kept == {
        "": "no-store",
        "_dash-layout": "no-store",
        "assets/session.js": "private, max-age=86400",
    }


def test_it_listens_on_one_address_of_loopback_only(app: str) -> None:
    assert urlsplit(app).hostname == "127.0.0.1"
    with pytest.raises(ConnectionRefusedError):  # who listens on all addresses is heard here too
        socket.create_connection(("127.0.0.2", int(urlsplit(app).port or 0)), timeout=5.0)


@pytest.mark.parametrize("host", ["evil.example", "evil.example:80", "127.0.0.1", "localhost:1"])
def test_a_foreign_host_is_refused(app: str, host: str) -> None:
    status, text, _ = ask(app, Host=host)
    assert status == 403
    assert "<" not in text


@pytest.mark.parametrize("origin", ["http://evil.example", "null", "https://127.0.0.1"])
def test_a_foreign_origin_is_refused(app: str, origin: str) -> None:
    assert ask(app, Origin=origin)[0] == 403


def test_the_own_origin_is_answered(app: str) -> None:
    origin = app.split("/" + urlsplit(app).path.strip("/"))[0]
    assert ask(app, Origin=origin)[0] == 200


@pytest.mark.parametrize("site", ["cross-site", "same-site"])
def test_another_site_may_link_here_and_nothing_else(app: str, site: str) -> None:
    assert ask(app, Sec_Fetch_Site=site)[0] == 403
    linked = {"Sec_Fetch_Mode": "navigate", "Sec_Fetch_Dest": "document"}
    assert ask(app, Sec_Fetch_Site=site, **linked)[0] == 200
    assert ask(app, method="POST", Sec_Fetch_Site=site, **linked)[0] == 403


def test_without_the_token_there_is_nothing(app: str) -> None:
    own = urlsplit(app).path
    for path in ("/", "/_dash-layout", own[:-2] + "/", f"/{'0' * 32}/", "//", f"/x{own}"):
        status, text, _ = ask(app, path)
        assert (status, "Traceback" in text) == (404, False), path
    assert ask(app, f"{own}_dash-layout")[0] == 200


def test_two_apps_have_different_tokens(app: str) -> None:
    another = listen(new_document(MODEL), {})
    another.close()
    own, others = (urlsplit(url).path.strip("/") for url in (app, another.url))
    assert own != others
    assert len(own) >= 32


@pytest.mark.parametrize("claimed", [True, False])
def test_an_oversize_body_is_refused(app: str, claimed: bool) -> None:
    path = f"{urlsplit(app).path}_dash-update-component"
    if claimed:
        status, _, _ = ask(app, path, method="POST", Content_Length=str(safety.BODY + 1))
    else:  # in chunks, which say no length beforehand
        status = sent_in_chunks(app, path, safety.BODY + 1)
    assert status == 413


def sent_in_chunks(app: str, path: str, size: int) -> int:
    url = urlsplit(app)
    connection = http.client.HTTPConnection(str(url.hostname), url.port, timeout=60)
    chunk = b"0" * 2**20
    body = (chunk for _ in range(size // len(chunk) + 1))
    with suppress(BrokenPipeError, ConnectionResetError):  # it would not hear the rest
        connection.request("POST", path, body, encode_chunked=True)
    status = connection.getresponse().status
    connection.close()
    return status


CALLBACKS = "_dash-update-component"
JSON = "application/json"
PLACE = b'{"id": "session", "property": "data"}'
SEVERAL = "..effect-screen.children...effect-list.children.."  # outputs of one callback


@pytest.mark.parametrize(
    "body",
    [
        *(b"", b"{", b"\xff", b"{}", b"[]", b"null", b'"x"', b"1"),
        *(b'{"output": "x.y", "inputs": []}', b'{"output": 1, "inputs": []}'),
        b'{"output": "page.data-kept", "inputs": [%s, %s]}' % (PLACE, PLACE),  # of the browser's
        b'{"output": "%s", "inputs": [%s, %s]}' % (SEVERAL.encode(), PLACE, PLACE),
        *(b'{"output": "pulse.data", "inputs": 1}', b'{"output": "pulse.data", "inputs": []}'),
    ],
)
def test_what_calls_no_callback_is_told_in_a_sentence(app: str, body: bytes) -> None:
    path = f"{urlsplit(app).path}{CALLBACKS}"
    status, text, headers = ask(app, path, method="POST", body=body, Content_Type=JSON)
    assert status == 400
    assert text == "This is no call of the page's callbacks; reload the page.\n"
    assert headers["Content-Type"].startswith("text/plain")


@pytest.mark.parametrize(
    "kept", [{"id": "a"}, {"id": "a", "document": "{}"}, {"document": "{}"}, 5, "x", ["x"]]
)
def test_a_session_that_is_none_is_told_in_a_sentence(app: str, kept: object) -> None:
    outputs = [{"id": f"effect-{part}", "property": "children"} for part in ("screen", "list")]
    given = {
        "inputs": [{"id": "effect-session", "property": "data", "value": kept}],
        "state": [{"id": "open", "property": "data", "value": "effect"}],
    }
    body = json.dumps({"output": SEVERAL, "outputs": outputs, **given}).encode()
    path = f"{urlsplit(app).path}{CALLBACKS}"
    status, text, _ = ask(app, path, method="POST", body=body, Content_Type=JSON)
    assert status == 400
    told = "the browser's copy of this session is damaged; open the app in a new tab.\n"
    assert text == told


def test_an_address_that_is_not_here_is_told_in_a_sentence() -> None:
    with pytest.raises(OutputError, match=r"cannot listen on 192\.0\.2\.1"):
        listen(new_document(MODEL), {}, address="192.0.2.1")


def test_a_port_in_use_is_told_in_a_sentence() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        with pytest.raises(OutputError, match="in use"):
            listen(new_document(MODEL), {}, port=taken.getsockname()[1])
