"""Drives Firefox by Marionette, the protocol that every Firefox speaks without another program.

Playwright drives a Firefox of its own alone, and geckodriver is no package of Debian.
"""

import json
import shutil
import socket
import subprocess
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

FIREFOX = shutil.which("firefox-esr") or shutil.which("firefox")
PATIENCE = 180.0  # s that a condition is waited for; machines of CI are slow and busy
# what the page says that went wrong, from now on
LISTEN = """
  window.faults = [];
  window.addEventListener("error", one => window.faults.push(String(one.message)));
  window.addEventListener("unhandledrejection", one => window.faults.push(String(one.reason)));
  const ask = window.fetch;
  window.fetch = (...all) => ask(...all).then(answer => {
    if (!answer.ok) window.faults.push(`${answer.status} of ${answer.url}`);
    return answer;
  });
"""


class Firefox:
    """One tab of a Firefox that runs; messages are ``length:[kind, number, ...]`` in JSON."""

    def __init__(self, port: int) -> None:
        self._socket = _connected(port)
        self._number = 0
        self._receive()  # how it introduces itself
        self.ask("WebDriver:NewSession", {})

    def ask(self, command: str, parameters: dict[str, Any]) -> Any:
        """The answer to a command of WebDriver.

        Raises
        ------
        RuntimeError : it cannot be done
        """
        self._number += 1
        text = json.dumps([0, self._number, command, parameters]).encode()
        self._socket.sendall(b"%d:%s" % (len(text), text))
        _, _, error, result = self._receive()
        if error is not None:
            raise RuntimeError(f"{command}: {error['message']}")
        return result["value"] if isinstance(result, dict) and "value" in result else result

    def _receive(self) -> Any:
        length = b""
        while (digit := self._socket.recv(1)) != b":":
            assert digit, "Firefox has ended"
            length += digit
        text = b""
        while len(text) < int(length):
            text += self._socket.recv(int(length) - len(text))
        return json.loads(text)

    def close(self) -> None:
        """Speak no more with it."""
        self._socket.close()

    def open(self, url: str) -> None:
        """Open a page, and hear from then on what goes wrong there."""
        self.ask("WebDriver:Navigate", {"url": url})
        self.run(LISTEN)

    def run(self, script: str, *values: Any) -> Any:
        """What a script of the page returns; `values` are its ``arguments``."""
        # not in a sandbox: the page's own objects are changed and seen
        given = {"script": script, "args": list(values), "sandbox": None}
        return self.ask("WebDriver:ExecuteScript", given)

    def until(self, condition: str, *values: Any) -> Any:
        """Wait until an expression of the page is true; what it is."""
        end = time.monotonic() + PATIENCE
        while not (value := self.run(f"return {condition}", *values)):
            assert time.monotonic() < end, f"{condition} {values} was waited for in vain"
            time.sleep(0.1)
        return value

    def click(self, selector: str, words: str = "") -> None:
        """Click what can be seen and begins with some words, as soon as it may be clicked."""
        found = (
            "Array.from(document.querySelectorAll(arguments[0])).find(one => one.offsetParent"
            " && !one.disabled && one.innerText.trim().startsWith(arguments[1]))"
        )
        element = self.until(found, selector, words)
        self.ask("WebDriver:ElementClick", {"id": next(iter(element.values()))})


def _connected(port: int) -> socket.socket:
    end = time.monotonic() + PATIENCE
    while True:
        try:
            return socket.create_connection(("127.0.0.1", port), timeout=PATIENCE)
        except OSError:
            assert time.monotonic() < end, "Firefox did not begin"
            time.sleep(0.2)


@contextmanager
def firefox(profile: Path) -> Iterator[Firefox]:
    """A headless Firefox with a profile of its own, in an empty folder."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    (profile / "user.js").write_text(f'user_pref("marionette.port", {port});\n')
    command = [str(FIREFOX), "--headless", "--marionette", "--no-remote", "--profile", str(profile)]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        with closing(Firefox(port)) as started:
            yield started
    finally:
        process.terminate()
        process.wait()
