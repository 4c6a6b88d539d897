"""Sweeps that are stopped and gone on with give what they would have given at once."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from elastic_tendon.errors import SweepError
from elastic_tendon.output import OutputError
from elastic_tendon.sweeps import finished
from elastic_tendon.sweeps.sweep import Swept, sweep
from sweep_tasks import Draws, read, runs_in

TESTS = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def expected(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """The file of 40 runs."""
    path = tmp_path_factory.mktemp("expected") / "runs.csv"
    path.write_bytes(Draws(40).rows(0, 40).to_csv(index=False).encode())
    return path.read_bytes()


@pytest.mark.parametrize("threads", [True, False])
@pytest.mark.parametrize(("workers", "batch"), [(1, None), (2, 3), (2, 100)])
def test_workers_and_batches_change_no_byte(
    tmp_path: Path, expected: bytes, threads: bool, workers: int, batch: int | None
) -> None:
    output = tmp_path / "runs.csv"
    task = Draws(40, threads=threads)
    swept = sweep(task, output, workers=workers, batch=batch)
    assert swept == Swept(task, output, 0, 0)
    assert output.read_bytes() == expected
    assert list(tmp_path.iterdir()) == [output]


@pytest.mark.parametrize("threads", [True, False])
def test_an_interrupted_sweep_goes_on(tmp_path: Path, expected: bytes, threads: bool) -> None:
    journal, output = tmp_path / "journal", tmp_path / "runs.csv"
    task = Draws(40, str(journal), seconds=0.01, threads=threads)
    said: list[tuple[str, float]] = []

    def interrupt(text: str, share: float) -> None:
        said.append((text, share))
        if len(said) == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        sweep(task, output, workers=2, progress=interrupt)
    assert said[-1] == ("15 of 40 runs, 0 failed", 15 / 40)
    assert not output.exists()
    time.sleep(0.2)  # threads cannot be stopped: they end their batch
    journal.write_text("")
    swept = sweep(task, output, workers=1)
    assert swept == Swept(task, output, 0, 15)
    assert output.read_bytes() == expected
    assert len(runs_in(journal)) == 25  # what was done is not done again


@pytest.mark.parametrize("end", [signal.SIGKILL, signal.SIGINT])
def test_a_sweep_whose_process_is_ended_goes_on(
    tmp_path: Path, expected: bytes, end: signal.Signals
) -> None:
    journal, output = tmp_path / "journal", tmp_path / "runs.csv"
    task = Draws(40, str(journal), seconds=0.02)
    process = _start(task, output)
    try:
        while process.poll() is None and len(list(tmp_path.glob("*/*.csv"))) < 2:
            time.sleep(0.01)
        os.killpg(process.pid, end)  # as a terminal does: all processes hear of it
    finally:
        _, said = process.communicate(timeout=30)
    assert process.returncode not in (0, 1)
    assert said.count("Traceback") == (1 if end == signal.SIGINT else 0)  # none from workers
    kept = len(list(tmp_path.glob("*/*.csv")))
    assert 2 <= kept < 8
    journal.write_text("")
    assert sweep(task, output, workers=2).resumed == 5 * kept
    assert output.read_bytes() == expected
    assert len(runs_in(journal)) == 40 - 5 * kept


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="looks into /proc")
def test_workers_end_with_a_parent_that_is_killed(tmp_path: Path) -> None:
    process = _start(Draws(400, seconds=0.02), tmp_path / "runs.csv")
    while process.poll() is None and not list(tmp_path.glob("*/*.csv")):
        time.sleep(0.01)
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
    workers = [child for child in children if "LokyProcess" in _command(child)]
    process.kill()
    process.communicate(timeout=30)
    deadline = time.monotonic() + 20
    while any(_command(worker) for worker in workers) and time.monotonic() < deadline:
        time.sleep(0.1)
    assert len(workers) == 2
    assert [_command(worker) for worker in workers] == ["", ""]


def _start(task: Draws, output: Path) -> subprocess.Popen[str]:
    """A sweep in a process of its own, with two workers."""
    program = (
        "from sweep_tasks import *; from elastic_tendon.sweeps.sweep import sweep;"
        f"sweep({task!r}, {str(output)!r}, workers=2)"
    )
    return subprocess.Popen(
        [sys.executable, "-c", program],
        env={**os.environ, "PYTHONPATH": str(TESTS)},
        stderr=subprocess.PIPE,
        start_new_session=True,
        text=True,
    )


def _command(process: str) -> str:
    try:
        return Path(f"/proc/{process}/cmdline").read_text()
    except (FileNotFoundError, ProcessLookupError):
        return ""


def test_failures_are_counted_over_interruptions(tmp_path: Path) -> None:
    task, output = Draws(40, raising=(3, 33), seconds=0.002), tmp_path / "runs.csv"

    def interrupt(_text: str, share: float) -> None:
        if share > 0.6:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        sweep(task, output, workers=1, progress=interrupt)
    said: list[str] = []
    swept = sweep(task, output, workers=1, progress=lambda text, _: said.append(text))
    assert swept == Swept(task, output, 2, 25)
    assert said[-1] == "40 of 40 runs, 2 failed"
    table = read(output)
    assert list(table.run[table.failure != ""]) == [3, 33]


def test_an_output_that_exists_is_refused_before_any_run(tmp_path: Path) -> None:
    journal, output = tmp_path / "journal", tmp_path / "runs.csv"
    output.write_text("mine")
    with pytest.raises(OutputError, match="exists already"):
        sweep(Draws(3, str(journal)), output)
    assert not journal.exists()
    sweep(Draws(3, str(journal)), output, workers=1, force=True)
    assert output.read_bytes() != b"mine"


@pytest.mark.parametrize(
    ("task", "settings", "what"),
    [
        (Draws(0), {}, "no runs"),
        (Draws(1), {"workers": 0}, "workers is 0"),
        (Draws(1), {"batch": -1}, "in a batch is -1"),
    ],
)
def test_sweeps_of_nothing_are_refused(
    tmp_path: Path, task: Draws, settings: dict[str, int], what: str
) -> None:
    with pytest.raises(SweepError, match=what):
        sweep(task, tmp_path / "runs.csv", **settings)


def test_two_sweeps_begun_at_once_lose_nothing(tmp_path: Path, expected: bytes) -> None:
    output = tmp_path / "runs.csv"
    both = [_start(Draws(40, seconds=0.02), output) for _ in range(2)]
    for process in both:
        process.communicate(timeout=60)
    codes = [process.returncode for process in both]
    assert 0 in codes  # the other was refused, or found the output there
    assert output.read_bytes() == expected
    assert list(tmp_path.iterdir()) == [output]


# ---- more runs, failed runs, shards --------------------------------------------------------------


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_a_finished_sweep_takes_more_runs(
    tmp_path: Path, suffix: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(finished, "CHUNK", 300)
    output, whole = tmp_path / f"runs{suffix}", tmp_path / f"whole{suffix}"
    sweep(Draws(20, raising=(3,)), output, workers=1)
    swept = sweep(Draws(40, raising=(3,)), output, workers=1)
    assert (swept.failed, swept.resumed) == (1, 20)
    sweep(Draws(40, raising=(3,)), whole, workers=1)
    assert output.read_bytes() == whole.read_bytes()
    assert sorted(tmp_path.iterdir()) == [output, whole]


def test_runs_of_another_sweep_are_not_added_to(tmp_path: Path) -> None:
    output = tmp_path / "runs.csv"
    sweep(Draws(20), output, workers=1)
    before = output.read_bytes()
    with pytest.raises(SweepError, match=r"run 0 of this table is not what this sweep gives"):
        sweep(Draws(40, seed=2), output, workers=1)
    assert output.read_bytes() == before
    assert list(tmp_path.iterdir()) == [output]


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_failed_runs_are_done_again_where_that_is_asked_for(tmp_path: Path, suffix: str) -> None:
    output, whole = tmp_path / f"runs{suffix}", tmp_path / f"whole{suffix}"
    sweep(Draws(40, raising=(0, 13, 14, 39)), output, workers=1)
    journal = tmp_path / "journal"
    swept = sweep(Draws(40, str(journal)), output, workers=1, retry_failed=True)
    assert (swept.failed, swept.resumed) == (0, 36)
    assert sorted(set(runs_in(journal)) & {0, 13, 14, 39}) == [0, 13, 14, 39]
    assert len(runs_in(journal)) <= 4 + finished.SAMPLE
    sweep(Draws(40), whole, workers=1)
    assert output.read_bytes() == whole.read_bytes()


def test_failed_runs_of_a_stopped_sweep_are_done_again(tmp_path: Path, expected: bytes) -> None:
    def interrupt(_text: str, share: float) -> None:
        if share > 0.6:
            raise KeyboardInterrupt

    output = tmp_path / "runs.csv"
    with pytest.raises(KeyboardInterrupt):
        sweep(Draws(40, raising=(3,)), output, workers=1, progress=interrupt)
    swept = sweep(Draws(40), output, workers=1, retry_failed=True)
    assert (swept.failed, swept.resumed) == (0, 24)
    assert output.read_bytes() == expected


def test_shards_are_joined_when_all_are_done(tmp_path: Path, expected: bytes) -> None:
    output = tmp_path / "runs.csv"
    for number in (3, 1):
        assert sweep(Draws(40), output, workers=1, shard=(number, 3)).path is None
    with pytest.raises(SweepError, match="the first of them runs 13 to 25"):
        sweep(Draws(40), output, join=True)
    sweep(Draws(40), output, workers=1, shard=(2, 3))
    assert sweep(Draws(40), output, join=True).resumed == 40
    assert output.read_bytes() == expected
    assert list(tmp_path.iterdir()) == [output]


@pytest.mark.parametrize("shard", [(0, 3), (4, 3), (1, 41)])
def test_shards_that_are_none_are_refused(tmp_path: Path, shard: tuple[int, int]) -> None:
    with pytest.raises(SweepError, match="there is no shard"):
        sweep(Draws(40), tmp_path / "runs.csv", shard=shard)


@pytest.mark.parametrize("threads", [True, False])
def test_what_this_computer_lacks_is_no_result(
    tmp_path: Path, expected: bytes, threads: bool
) -> None:
    sick, output = tmp_path / "sick", tmp_path / "runs.csv"
    sick.touch()
    task = Draws(40, sick=str(sick), threads=threads)
    with pytest.raises(SweepError, match=r"cannot be done here: OSError: .*No space left"):
        sweep(task, output, workers=1)
    assert list(tmp_path.iterdir()) == [sick]
    sick.unlink()
    sweep(task, output, workers=1)
    assert output.read_bytes() == expected
