"""Text for others to read: without paths, and without names of the user and of the machine."""

import getpass
import re
import socket
from contextlib import suppress
from pathlib import Path
from typing import Any

# from a root, a home or a folder that is told by dots, up to the last part; "N/m" is no path
_PATH = re.compile(
    r"(?<![\w.)])(?:~\w*|\.{1,2}|[A-Za-z]:)?[/\\](?:[^\s'\"=,;\[\]/\\]+[/\\])*(?=[^\s/\\])"
)
_SHORTEST = 3  # letters of a name that is looked for: shorter ones stand in many words
_LEFT_OUT = "\N{HORIZONTAL ELLIPSIS}"


def without_names(content: Any) -> Any:
    """Plain data, at any depth: of paths the last part is left, names become an ellipsis.

    Keys stay: they are words of ours, which a user or a machine may be called by too.
    """
    if isinstance(content, dict):
        return {key: without_names(value) for key, value in content.items()}
    if isinstance(content, (list, tuple)):
        return [without_names(value) for value in content]
    return _text(content) if isinstance(content, str) else content


def _text(text: str) -> str:
    text = _PATH.sub("", text)
    for name in _names():
        text = re.sub(rf"(?<![^\W_]){re.escape(name)}(?![^\W_])", _LEFT_OUT, text, flags=re.I)
    return text


def _names() -> list[str]:
    """Names of the user and of the machine, the longest first."""
    host = socket.gethostname()
    found = {host, host.split(".")[0], Path.home().name}
    with suppress(OSError, KeyError):  # a user without a name
        found.add(getpass.getuser())
    return sorted((name for name in found if len(name) >= _SHORTEST), key=len, reverse=True)
