"""A Dask scheduler and its workers as processes of their own, on this computer."""

import json
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import elastic_tendon

TESTS = Path(__file__).parent


@dataclass
class DaskCluster:
    """A scheduler, which workers join by `add`."""

    folder: Path
    scheduler: subprocess.Popen[bytes]
    address: str
    workers: list[subprocess.Popen[bytes]] = field(default_factory=list)

    def add(self, *, nanny: bool = False, **settings: str) -> subprocess.Popen[bytes]:
        """Begin a worker with one thread; a nanny would begin another one where it ends.

        `settings` : of its environment
        """
        keep = "--nanny" if nanny else "--no-nanny"
        options = ["--nthreads", "1", keep, "--no-dashboard", "--local-directory", str(self.folder)]
        worker = _start("dask_worker", self.folder, [self.address, *options], **settings)
        self.workers.append(worker)
        return worker

    def end(self) -> None:
        """End all processes, workers of nannies with them, and wait until they have ended."""
        for processes in (self.workers, [self.scheduler]):
            for process in processes:
                process.terminate()
            for process in processes:
                try:
                    process.wait(timeout=10)
                except subprocess.TimeoutExpired:
                    process.kill()
                    process.wait()


@contextmanager
def dask_cluster(folder: Path, allowed_failures: int = 1) -> Iterator[DaskCluster]:
    """A scheduler, which cannot import the package or the tasks; it and its workers end with the
    context.

    Parameters
    ----------
    folder : for its files and logs
    allowed_failures : workers that a piece may end before the scheduler gives it up, less one
    """
    file = folder / "scheduler.json"
    options = ["--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--scheduler-file"]
    scheduler = _start(
        "dask_scheduler",
        folder,
        [*options, str(file)],
        DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES=str(allowed_failures),
        PYTHONPATH=str(_nothing_of_ours(folder)),
    )
    cluster = DaskCluster(folder, scheduler, "")
    try:
        deadline = time.monotonic() + 30
        while not (file.exists() and file.read_text()):
            assert scheduler.poll() is None, (folder / "dask_scheduler.log").read_text()
            assert time.monotonic() < deadline
            time.sleep(0.05)
        cluster.address = json.loads(file.read_text())["address"]
        yield cluster
    finally:
        cluster.end()


def _start(
    program: str, folder: Path, options: list[str], **settings: str
) -> subprocess.Popen[bytes]:
    # what was on the path before comes last: another version of distributed, say
    first = settings.get("PYTHONPATH", _search_path())
    path = os.pathsep.join(filter(None, [first, os.environ.get("PYTHONPATH")]))
    with (folder / f"{program}.log").open("ab") as log:
        return subprocess.Popen(
            [sys.executable, "-m", f"distributed.cli.{program}", *options],
            env=os.environ | settings | {"PYTHONPATH": path},
            cwd=folder,
            stdout=log,
            stderr=log,
        )


def _search_path() -> str:
    """Where workers find the tasks of tests, and the package that is tested."""
    package = Path(elastic_tendon.__path__[0]).parent
    return os.pathsep.join((str(TESTS), str(package)))


def _nothing_of_ours(folder: Path) -> Path:
    """Where Python finds only ruins under our names."""
    ruins = folder / "ruins"
    for name in ("elastic_tendon", "sweep_tasks"):
        (ruins / name).mkdir(parents=True)
        (ruins / name / "__init__.py").write_text("raise ImportError(__name__)")
    return ruins


def changed_package(folder: Path) -> str:
    """PYTHONPATH of a worker whose package has the same version and other code."""
    copy = folder / "changed"
    package = Path(elastic_tendon.__path__[0])
    shutil.copytree(package, copy / package.name, ignore=shutil.ignore_patterns("__pycache__"))
    with (copy / package.name / "sweeps" / "task.py").open("a") as source:
        source.write("# one more line\n")
    return os.pathsep.join((str(TESTS), str(copy)))
