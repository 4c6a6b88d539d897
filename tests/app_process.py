"""The app as a process of its own, started as a user starts it."""

import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

ENDING = 30.0  # s that the app is given to end


@contextmanager
def served(*words: str | Path, folder: Path | None = None) -> Iterator[str]:
    """The app as a process of its own; its URL.

    Parameters
    ----------
    words : after ``elastic-tendon app --no-browser``
    folder : in which it is started
    """
    command = [sys.executable, "-m", "elastic_tendon", "app", "--no-browser", *map(str, words)]
    process = subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout is not None
        line = process.stdout.readline()
        found = re.search(r"http\S+", line)
        assert found is not None, f"the app did not start: {line}{process.stdout.read()}"
        yield found.group()
    finally:
        process.send_signal(signal.SIGINT)  # so that it deletes what was uploaded
        try:
            process.communicate(timeout=ENDING)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()
