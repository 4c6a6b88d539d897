"""What takes long to make, made by one worker of a test run and taken by all."""

import os
import tempfile
from collections.abc import Callable
from pathlib import Path

import pytest
from filelock import FileLock


def made_once(factory: pytest.TempPathFactory, name: str, make: Callable[[Path], object]) -> Path:
    """Folder with what `make` wrote into it, by whichever worker came first.

    Parameters
    ----------
    factory : pytest's tmp_path_factory
    name : of the folder
    make : called with an empty folder, once in a test run; the others wait for it
    """
    root = factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        root = root.parent  # of the test run, in which every worker has its own
    folder = root / f"once-{name}"
    with FileLock(f"{folder}.lock"):
        if not folder.is_dir():
            work = Path(tempfile.mkdtemp(dir=root))
            make(work)
            work.rename(folder)
    return folder
