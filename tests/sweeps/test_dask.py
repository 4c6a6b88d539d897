"""Sweeps on a real Dask cluster, parts of which are lost."""

import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path

import pytest

from dask_cluster import DaskCluster, changed_package, dask_cluster
from elastic_tendon.errors import SweepError
from elastic_tendon.sweeps.sweep import Swept, sweep
from sweep_tasks import Draws, processes_in, read, runs_in

Client = pytest.importorskip("distributed").Client


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


def test_the_address_of_dasks_dashboard_is_told(
    cluster: DaskCluster, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    link = "http://127.0.0.1:8787/status"
    monkeypatch.setattr(Client, "dashboard_link", property(lambda _client: link))
    cluster.add()
    told: list[str] = []
    sweep(
        *(Draws(4), tmp_path / "runs.csv"),
        scheduler=cluster.address,
        progress=lambda text, _share: told.append(text),
    )
    assert any(link in text for text in told)


def test_a_run_that_ends_every_worker_is_recorded(tmp_path: Path) -> None:
    (tmp_path / "dask").mkdir()
    output = tmp_path / "runs.csv"
    with dask_cluster(tmp_path / "dask", allowed_failures=0) as cluster:
        cluster.add(nanny=True)
        swept = sweep(Draws(12, killing=(4,)), output, scheduler=cluster.address, batch=2)
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
        sweep(task, output, scheduler=cluster.address, batch=5, progress=_once(interrupt, 0.1))
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


@pytest.mark.parametrize(
    "words", [b"", b"SSH-2.0-OpenSSH_9.2\r\n", b"HTTP/1.1 400 Bad Request\r\n\r\n"]
)
def test_a_port_that_is_no_scheduler_is_told_in_a_sentence(
    tmp_path: Path, words: bytes, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("elastic_tendon.sweeps.cluster.CONNECT_SECONDS", 1.0)
    with socket.create_server(("127.0.0.1", 0)) as stranger:
        threading.Thread(target=_greet, args=(stranger, words), daemon=True).start()
        address = f"tcp://127.0.0.1:{stranger.getsockname()[1]}"
        with pytest.raises(SweepError, match="no Dask scheduler answers") as told:
            sweep(Draws(10), tmp_path / "runs.csv", scheduler=address)
    assert "\n" not in str(told.value)
    assert capfd.readouterr().err == ""
    assert not list(tmp_path.iterdir())


def _greet(stranger: socket.socket, words: bytes) -> None:
    with suppress(OSError):
        while True:
            connection, _ = stranger.accept()
            connection.sendall(words)
            with connection:
                connection.recv(1)
                time.sleep(3.0)


def test_a_port_of_a_worker_is_told(cluster: DaskCluster, tmp_path: Path) -> None:
    cluster.add()
    with Client(cluster.address, set_as_default=False) as client:
        client.wait_for_workers(1, timeout=30)
        [address] = client.nthreads()
    with pytest.raises(SweepError, match="a Dask worker answers there"):
        sweep(Draws(10), tmp_path / "runs.csv", scheduler=address)


# ---- sick, wrong and late workers ----------------------------------------------------------------


def test_a_sick_worker_is_left_out_and_named(cluster: DaskCluster, tmp_path: Path) -> None:
    cluster.add(SICK="yes")
    cluster.add()
    output, said = tmp_path / "runs.csv", []
    task = Draws(60, sick="SICK", seconds=0.05)
    swept = sweep(
        *(task, output),
        scheduler=cluster.address,
        batch=2,
        progress=lambda text, _share: said.append(text),
    )
    assert swept.failed == 0
    [left_out] = {text.partition("; ")[2] for text in said if "left out" in text}
    assert "3 pieces in a row failed there: OSError: [Errno 28] No space left" in left_out
    assert "worker tcp://127.0.0.1:" in left_out
    _expect_table(output, Draws(60))


@pytest.mark.usefixtures("impatient")
def test_what_works_nowhere_is_no_result(cluster: DaskCluster, tmp_path: Path) -> None:
    output = tmp_path / "runs.csv"
    with pytest.raises(KeyboardInterrupt):
        sweep(Draws(60), output, workers=1, progress=_once(_interrupt, 0.3))
    cluster.add(SICK="yes")
    with pytest.raises(SweepError, match=r"No space left on device; what is done is kept"):
        sweep(Draws(60, sick="SICK"), output, scheduler=cluster.address)
    assert not output.exists()
    assert sweep(Draws(60), output, workers=1).resumed >= 20


def _interrupt() -> None:
    raise KeyboardInterrupt


def test_a_worker_that_joins_takes_part_and_one_with_other_code_does_not(
    cluster: DaskCluster, tmp_path: Path
) -> None:
    output, journal, said = tmp_path / "runs.csv", tmp_path / "journal", []
    other = changed_package(tmp_path)
    cluster.add()

    def join() -> None:
        cluster.add(PYTHONPATH=other)
        cluster.add()

    joining = _once(join, 0.02)

    def progress(text: str, share: float) -> None:
        said.append(text)
        joining(text, share)

    task = Draws(300, str(journal), seconds=0.05)
    sweep(task, output, scheduler=cluster.address, batch=2, progress=progress)
    assert len(set(processes_in(journal))) == 2  # of three that there were
    assert any("is left out: the code of elastic-tendon is another" in text for text in said)
    _expect_table(output, Draws(300))


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_local_cluster_and_shards_give_the_same_bytes(
    cluster: DaskCluster, tmp_path: Path, suffix: str
) -> None:
    cluster.add()
    task = Draws(50, raising=(7,))
    local, shared = tmp_path / f"local{suffix}", tmp_path / "shared"
    sweep(task, local, workers=1)
    shards = tmp_path / f"shards{suffix}"
    with Client(cluster.address, set_as_default=False) as client:
        ways = {
            "file": {"scheduler_file": tmp_path / "dask" / "scheduler.json"},
            "client": {"client": client},
            "parts": {"client": client, "parts": shared, "batch": 3},
            "url": {"client": client, "parts": shared.as_uri()},
        }
        for name, way in ways.items():
            output = tmp_path / f"{name}{suffix}"
            assert sweep(task, output, **way).failed == 1
            assert output.read_bytes() == local.read_bytes()
            assert not shared.exists()
        for number in (3, 1, 2):
            sweep(task, shards, client=client, shard=(number, 3))
        assert client.status == "running"
    assert sweep(task, shards, join=True).failed == 1
    assert shards.read_bytes() == local.read_bytes()
