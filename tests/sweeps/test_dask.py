"""Sweeps on a real Dask cluster, parts of which are lost."""

import importlib.util
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from dask_cluster import DaskCluster, dask_cluster
from elastic_tendon.errors import SweepError
from elastic_tendon.sweeps.sweep import Swept, sweep
from sweep_tasks import Draws, read, runs_in

pytestmark = pytest.mark.skipif(
    importlib.util.find_spec("distributed") is None, reason="needs Dask"
)


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[DaskCluster]:
    (tmp_path / "dask").mkdir()
    with dask_cluster(tmp_path / "dask") as cluster:
        yield cluster


def _once(act: Callable[[], None], after: float) -> Callable[[str, float], None]:
    """A progress callback that acts when this share is reached."""
    acted = False

    def progress(_text: str, share: float) -> None:
        nonlocal acted
        if share >= after and not acted:
            acted = True
            act()

    return progress


def _expect_table(output: Path, task: Draws) -> None:
    local = output.with_name("local.csv")
    sweep(task, local, workers=1, batch=7)
    assert output.read_bytes() == local.read_bytes()


@pytest.mark.parametrize("ballast", [b"", bytes(3_000_000)])
def test_one_of_two_workers_is_killed(cluster: DaskCluster, tmp_path: Path, ballast: bytes) -> None:
    first, _ = cluster.add(), cluster.add()
    output, journal = tmp_path / "runs.csv", tmp_path / "journal"
    task = Draws(100, str(journal), seconds=0.01, ballast=ballast)
    swept = sweep(task, output, scheduler=cluster.address, progress=_once(first.kill, 0.3))
    assert first.wait(timeout=10) != 0
    assert swept == Swept(task, output, 0, 0)
    assert len(runs_in(journal)) < 200  # only what was under way is done again
    _expect_table(output, Draws(100))


def test_a_run_that_ends_every_worker_is_recorded(tmp_path: Path) -> None:
    (tmp_path / "dask").mkdir()
    output = tmp_path / "runs.csv"
    with dask_cluster(tmp_path / "dask", allowed_failures=0) as cluster:
        cluster.add(nanny=True)
        swept = sweep(Draws(12, killing=(4,)), output, scheduler=cluster.address, batch=3)
    assert swept.failed == 1
    table = read(output)
    assert list(table.run) == list(range(12))
    assert "ended 2 times" in table.failure[4]


def test_a_sweep_whose_scheduler_is_killed_goes_on_without(
    cluster: DaskCluster, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    cluster.add()
    output = tmp_path / "runs.csv"
    task = Draws(60, seconds=0.01)
    with pytest.raises(SweepError, match=r"scheduler ended .* repeat the command"):
        sweep(task, output, scheduler=cluster.address, progress=_once(cluster.scheduler.kill, 0.3))
    assert capfd.readouterr().err == ""
    swept = sweep(task, output, workers=1)
    assert 0 < swept.resumed < 60
    _expect_table(output, Draws(60))


def test_an_interrupt_drops_what_is_under_way(cluster: DaskCluster, tmp_path: Path) -> None:
    cluster.add()
    output, journal = tmp_path / "runs.csv", tmp_path / "journal"
    task = Draws(100, str(journal), seconds=0.02)

    def interrupt() -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        sweep(task, output, scheduler=cluster.address, progress=_once(interrupt, 0.1))
    time.sleep(1.0)
    assert len(runs_in(journal)) < 40
    assert sweep(Draws(100), output, workers=1).resumed >= 10


def test_workers_that_are_all_lost_are_waited_for_as_long_as_told(
    cluster: DaskCluster, tmp_path: Path
) -> None:
    worker = cluster.add()
    with pytest.raises(SweepError, match=r"no worker.*dask worker tcp://127"):
        sweep(
            Draws(100, seconds=0.01),
            tmp_path / "runs.csv",
            scheduler=cluster.address,
            wait=1.0,
            progress=_once(worker.kill, 0.3),
        )


def test_a_scheduler_without_workers_is_told(cluster: DaskCluster, tmp_path: Path) -> None:
    with pytest.raises(SweepError, match=r"no worker.*dask worker tcp://127"):
        sweep(Draws(10), tmp_path / "runs.csv", scheduler=cluster.address, wait=0.5)
    assert not list(tmp_path.glob("runs*"))  # nothing is left behind


class _OnlyHere(Draws):
    """What a worker cannot import, as this module is not where it looks."""


@pytest.fixture
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Workers that can do nothing are not waited for."""
    monkeypatch.setattr("elastic_tendon.sweeps.cluster.GRACE_SECONDS", 0.1)


@pytest.mark.usefixtures("impatient")
def test_a_worker_that_lacks_a_package_is_told(cluster: DaskCluster, tmp_path: Path) -> None:
    cluster.add()
    with pytest.raises(SweepError, match="lacks the package test_dask"):
        sweep(_OnlyHere(10), tmp_path / "runs.csv", scheduler=cluster.address)


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:1", "127.0.0.1", "foo://bar:2", "no such"])
def test_an_address_where_nobody_answers_is_told(
    tmp_path: Path, address: str, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("elastic_tendon.sweeps.cluster.CONNECT_SECONDS", 1.0)
    what = "no Dask scheduler answers|no address of a Dask scheduler"
    with pytest.raises(SweepError, match=what) as told:
        sweep(Draws(10), tmp_path / "runs.csv", scheduler=address)
    assert "\n" not in str(told.value)
    assert capfd.readouterr().err == ""
