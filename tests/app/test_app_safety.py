"""Who may talk to the app: real requests to the real server."""

import http.client
import socket
from collections.abc import Iterator
from contextlib import suppress
from threading import Thread
from urllib.parse import urlsplit

import pytest

from elastic_tendon.app import safety
from elastic_tendon.app.document import new_document
from elastic_tendon.app.server import Served, listen
from elastic_tendon.output import OutputError
from elastic_tendon.parameters import load_model

MODEL = load_model("biorob_x4_joint_3")


@pytest.fixture(scope="module")
def served() -> Iterator[Served]:
    app = listen(new_document(MODEL), {})
    thread = Thread(target=app.run, daemon=True)
    thread.start()
    yield app
    app.close()
    thread.join(10.0)


def ask(
    served: Served,
    path: str | None = None,
    *,
    method: str = "GET",
    body: bytes | None = None,
    **headers: str,
) -> tuple[int, str, http.client.HTTPMessage]:
    """Status, text and headers of the answer; the path is the app's own where none is given."""
    url = urlsplit(served.url)
    connection = http.client.HTTPConnection(str(url.hostname), url.port, timeout=20)
    named = {name.replace("_", "-"): value for name, value in headers.items()}
    connection.request(method, path or url.path, body, named)
    answer = connection.getresponse()
    text = answer.read().decode(errors="replace")
    connection.close()
    return answer.status, text, answer.headers


def test_the_printed_url_is_answered(served: Served) -> None:
    status, text, headers = ask(served)
    assert status == 200
    assert "elastic-tendon" in text
    assert headers["X-Frame-Options"] == "DENY"
    assert headers["Referrer-Policy"] == "no-referrer"
    assert "default-src 'self'" in headers["Content-Security-Policy"]
    assert "unsafe-eval" not in headers["Content-Security-Policy"]


def test_it_listens_on_loopback_only(served: Served) -> None:
    assert urlsplit(served.url).hostname == "127.0.0.1"
    with socket.socket() as own:
        own.connect(("127.0.0.1", int(urlsplit(served.url).port or 0)))
        assert own.getpeername()[0] == "127.0.0.1"


@pytest.mark.parametrize("host", ["evil.example", "evil.example:80", "127.0.0.1", "localhost:1"])
def test_a_foreign_host_is_refused(served: Served, host: str) -> None:
    status, text, _ = ask(served, Host=host)
    assert status == 403
    assert "<" not in text


@pytest.mark.parametrize("origin", ["http://evil.example", "null", "https://127.0.0.1"])
def test_a_foreign_origin_is_refused(served: Served, origin: str) -> None:
    assert ask(served, Origin=origin)[0] == 403


def test_the_own_origin_is_answered(served: Served) -> None:
    origin = served.url.split("/" + urlsplit(served.url).path.strip("/"))[0]
    assert ask(served, Origin=origin)[0] == 200


@pytest.mark.parametrize("site", ["cross-site", "same-site"])
def test_another_site_may_link_here_and_nothing_else(served: Served, site: str) -> None:
    assert ask(served, Sec_Fetch_Site=site)[0] == 403
    linked = {"Sec_Fetch_Mode": "navigate", "Sec_Fetch_Dest": "document"}
    assert ask(served, Sec_Fetch_Site=site, **linked)[0] == 200
    assert ask(served, method="POST", Sec_Fetch_Site=site, **linked)[0] == 403


def test_without_the_token_there_is_nothing(served: Served) -> None:
    own = urlsplit(served.url).path
    for path in ("/", "/_dash-layout", own[:-2] + "/", f"/{'0' * 32}/", "//", f"/x{own}"):
        status, text, _ = ask(served, path)
        assert (status, "Traceback" in text) == (404, False), path
    assert ask(served, f"{own}_dash-layout")[0] == 200


def test_two_apps_have_different_tokens(served: Served) -> None:
    other = listen(new_document(MODEL), {})
    other.close()
    own, others = (urlsplit(one.url).path.strip("/") for one in (served, other))
    assert own != others
    assert len(own) >= 32


@pytest.mark.parametrize("claimed", [True, False])
def test_an_oversize_body_is_refused(served: Served, claimed: bool) -> None:
    path = f"{urlsplit(served.url).path}_dash-update-component"
    if claimed:
        status, _, _ = ask(served, path, method="POST", Content_Length=str(safety.BODY + 1))
    else:  # in chunks, which say no length beforehand
        status = sent_in_chunks(served, path, safety.BODY + 1)
    assert status == 413


def sent_in_chunks(served: Served, path: str, size: int) -> int:
    url = urlsplit(served.url)
    connection = http.client.HTTPConnection(str(url.hostname), url.port, timeout=60)
    chunk = b"0" * 2**20
    body = (chunk for _ in range(size // len(chunk) + 1))
    with suppress(BrokenPipeError, ConnectionResetError):  # it would not hear the rest
        connection.request("POST", path, body, encode_chunked=True)
    status = connection.getresponse().status
    connection.close()
    return status


def test_an_address_that_is_not_here_is_told_in_a_sentence() -> None:
    with pytest.raises(OutputError, match=r"cannot listen on 192\.0\.2\.1"):
        listen(new_document(MODEL), {}, address="192.0.2.1")


def test_a_port_in_use_is_told_in_a_sentence() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        with pytest.raises(OutputError, match="in use"):
            listen(new_document(MODEL), {}, port=taken.getsockname()[1])
