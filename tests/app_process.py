"""The app as a process of its own, started as a user starts it."""

import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

ENDING = 30.0  # s that the app is given to end


def start(*words: str | Path, folder: Path | None = None) -> tuple[subprocess.Popen[str], str]:
    """Start the app as a process of its own; the process and its URL.

    Parameters
    ----------
    words : after ``elastic-tendon app --no-browser``
    folder : in which it is started
    """
    command = [sys.executable, "-m", "elastic_tendon", "app", "--no-browser", *map(str, words)]
    process = subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    line = process.stdout.readline()
    found = re.search(r"http\S+", line)
    if found is None:
        process.kill()
        raise AssertionError(f"the app did not start: {line}{process.communicate()[0]}")
    return process, found.group()


@contextmanager
def served(*words: str | Path, folder: Path | None = None) -> Iterator[str]:
    """The app as a process of its own, as `start` does, and its end; its URL."""
    process, url = start(*words, folder=folder)
    try:
        yield url
    finally:
        end(process)


def end(process: subprocess.Popen[str]) -> None:
    """End the app as a user does, so that it deletes what was uploaded."""
    process.send_signal(signal.SIGINT)
    try:
        process.communicate(timeout=ENDING)
    except subprocess.TimeoutExpired:
        process.kill()
        process.communicate()
