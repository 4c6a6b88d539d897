"""What is done so far, on disk."""

import dataclasses
import json
from collections.abc import Sequence
from pathlib import Path

import pandas as pd
import pytest

from elastic_tendon.errors import SweepError
from elastic_tendon.output import OutputError
from elastic_tendon.sweeps import formats
from elastic_tendon.sweeps import parts as module
from elastic_tendon.sweeps.fingerprint import fingerprint
from elastic_tendon.sweeps.parts import (
    Parts,
    add,
    alone,
    check_output,
    done_before,
    finish,
    folder_of,
    missing,
    open_parts,
)
from elastic_tendon.sweeps.work import Order, Piece, finished
from sweep_tasks import Draws, read

TASK = Draws(12, raising=(7,))
PIECES = ((0, 5), (5, 10), (10, 12))


def _add(parts: Parts, start: int, stop: int) -> int:
    rows = [
        TASK.failed(run, "it is odd") if run in TASK.raising else TASK.rows(run, run + 1)
        for run in range(start, stop)
    ]
    order = Order(TASK, parts.output.suffix, fingerprint())
    return add(parts, finished(order, start, stop, pd.concat(rows, ignore_index=True)))


def _filled(output: Path, pieces: Sequence[Piece] = PIECES) -> Parts:
    parts = open_parts(TASK, output, force=False)
    for start, stop in reversed(pieces):
        _add(parts, start, stop)
    return parts


def _folder(parts: Parts) -> Path:
    return folder_of(parts.output)


def test_what_is_done_is_found_again(tmp_path: Path) -> None:
    parts = open_parts(TASK, tmp_path / "runs.csv", force=False)
    assert _add(parts, 5, 10) == 1
    again = open_parts(TASK, tmp_path / "runs.csv", force=False)
    assert again == parts
    assert done_before(again) == {(5, 10): 1}
    assert missing(again.share, done_before(again)) == [(0, 5), (10, 12)]


def test_numbers_are_read_as_they_were(tmp_path: Path) -> None:
    finish(_filled(tmp_path / "runs.csv"), force=False)
    table = read(tmp_path / "runs.csv")
    assert list(table.run) == list(range(12))
    assert table.value[3] == TASK.rows(3, 4).value[0]
    assert table.failure[7] == "it is odd"
    assert not (tmp_path / "runs.csv.parts").exists()


def test_parquet_has_the_same_table(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    monkeypatch.setattr(formats, "ROW_GROUP", 200)
    finish(_filled(tmp_path / "runs.csv"), force=False)
    finish(_filled(tmp_path / "runs.parquet"), force=False)
    finish(_filled(tmp_path / "cut.parquet", [(0, 1), (1, 11), (11, 12)]), force=False)
    assert (tmp_path / "cut.parquet").read_bytes() == (tmp_path / "runs.parquet").read_bytes()
    table = pd.read_parquet(tmp_path / "runs.parquet")
    pd.testing.assert_frame_equal(table, read(tmp_path / "runs.csv"), check_dtype=False)
    assert str(table.run.dtype) == "int64"
    assert 1 < parquet.ParquetFile(tmp_path / "runs.parquet").num_row_groups < 3


@pytest.mark.parametrize("left", [0, -3])
def test_a_damaged_part_does_not_count(tmp_path: Path, left: int) -> None:
    parts = _filled(tmp_path / "runs.csv")
    path = next(_folder(parts).glob("*-000000000010-*"))
    path.write_bytes(path.read_bytes()[:left])
    assert set(done_before(parts)) == {(0, 5), (10, 12)}
    with pytest.raises(SweepError, match="parts are missing"):
        finish(parts, force=False)


def test_a_part_is_never_half_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    parts = open_parts(TASK, tmp_path / "runs.csv", force=False)

    def full(path: Path, content: bytes) -> None:
        with path.open("wb") as file:
            file.write(content[:10])
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(OutputError, match=r"No space left on device.*is kept"):
        _add(parts, 0, 5)
    monkeypatch.undo()
    assert done_before(parts) == {}
    _add(parts, 0, 5)
    assert set(done_before(parts)) == {(0, 5)}


def test_parts_of_another_sweep_are_not_mixed_in(tmp_path: Path) -> None:
    parts = _filled(tmp_path / "runs.csv")
    another = dataclasses.replace(TASK, seed=2, runs=13)
    with pytest.raises(SweepError, match=r"another sweep \(different: runs, seed\).*--force"):
        open_parts(another, tmp_path / "runs.csv", force=False)
    assert len(done_before(parts)) == 3
    assert done_before(open_parts(another, tmp_path / "runs.csv", force=True)) == {}


def test_force_goes_on_with_the_same_sweep(tmp_path: Path) -> None:
    parts = _filled(tmp_path / "runs.csv")
    assert len(done_before(open_parts(TASK, tmp_path / "runs.csv", force=True))) == 3
    assert _folder(parts).is_dir()


def test_another_version_is_another_sweep(tmp_path: Path) -> None:
    path = _filled(tmp_path / "runs.csv").store.path / "sweep.json"
    path.write_text(json.dumps({**json.loads(path.read_text()), "elastic-tendon": "0.0.9"}))
    with pytest.raises(SweepError, match=r"\(different: elastic-tendon\)"):
        open_parts(TASK, tmp_path / "runs.csv", force=False)


@pytest.mark.parametrize("text", ["", "{", "[]", '{"identity": 3, "runs": 12}', None])
def test_parts_of_an_unknown_sweep_are_not_mixed_in(tmp_path: Path, text: str | None) -> None:
    path = _filled(tmp_path / "runs.csv").store.path / "sweep.json"
    path.unlink()
    if text is not None:
        path.write_text(text)
    with pytest.raises(SweepError, match="another sweep"):
        open_parts(TASK, tmp_path / "runs.csv", force=False)


def test_a_folder_left_before_its_description_was_written_is_used(tmp_path: Path) -> None:
    (tmp_path / "runs.csv.parts").mkdir()
    (tmp_path / "runs.csv.parts" / "sweep.json.unfinished").write_text("{")
    parts = open_parts(TASK, tmp_path / "runs.csv", force=False)
    assert done_before(parts) == {}


def test_files_that_no_sweep_wrote_are_not_removed(tmp_path: Path) -> None:
    (tmp_path / "runs.csv.parts").mkdir()
    (tmp_path / "runs.csv.parts" / "thesis.docx").write_text("all of it")
    with pytest.raises(OutputError, match="thesis"):
        open_parts(TASK, tmp_path / "runs.csv", force=True)
    assert (tmp_path / "runs.csv.parts" / "thesis.docx").exists()


def test_outputs_that_cannot_be_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(OutputError, match=r"\.csv or \.parquet"):
        check_output(tmp_path / "runs.xlsx", force=False)
    (tmp_path / "runs.csv").touch()
    with pytest.raises(OutputError, match="exists already"):
        check_output(tmp_path / "runs.csv", force=False)
    check_output(tmp_path / "runs.csv", force=True)
    monkeypatch.setattr(module, "find_spec", lambda _name: None)
    with pytest.raises(OutputError, match=r"elastic-tendon\[formats\]"):
        check_output(tmp_path / "runs.parquet", force=False)


def test_a_description_without_parts_holds_nobody_up(tmp_path: Path) -> None:
    open_parts(TASK, tmp_path / "runs.csv", force=False)
    another = dataclasses.replace(TASK, seed=2)
    parts = open_parts(another, tmp_path / "runs.csv", force=False)
    assert json.loads((_folder(parts) / "sweep.json").read_text())["identity"]["seed"] == "2"


def test_parts_of_other_batches_are_kept_but_no_run_twice(tmp_path: Path) -> None:
    parts = open_parts(TASK, tmp_path / "runs.csv", force=False)
    for piece in ((0, 4), (3, 5), (4, 6), (8, 12)):
        _add(parts, *piece)
    done = done_before(parts)
    assert list(done) == [(0, 4), (4, 6), (8, 12)]
    assert missing(parts.share, done) == [(6, 8)]
    assert len(list(_folder(parts).glob("*.csv"))) == 3


def test_one_output_has_one_sweep_at_a_time(tmp_path: Path) -> None:
    output = tmp_path / "runs.csv"
    with (
        alone(output),
        pytest.raises(SweepError, match="another sweep is writing it now"),
        alone(output),
    ):
        pass
    with alone(output):
        assert [path.name for path in tmp_path.iterdir()] == ["runs.csv.lock"]
    assert not list(tmp_path.iterdir())
