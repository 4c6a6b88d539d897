"""Where batches are done: every run once, whatever becomes of its worker."""

from collections.abc import Iterator
from io import BytesIO

import pandas as pd
import pytest

from elastic_tendon.sweeps.execution import Local, _UnderWay, execute
from elastic_tendon.sweeps.fingerprint import fingerprint
from elastic_tendon.sweeps.work import Order, Piece
from sweep_tasks import Draws, read


def _pieces(runs: int, batch: int) -> list[Piece]:
    return [(start, min(start + batch, runs)) for start in range(0, runs, batch)]


def _order(task: Draws) -> Order:
    return Order(task, ".csv", fingerprint())


def _table(task: Draws, batch: int, place: Local, *, halved: bool = False) -> pd.DataFrame:
    results = execute(_order(task), _pieces(task.runs, batch), place)
    done = sorted(results, key=lambda piece: piece.start)
    assert halved or [(piece.start, piece.stop) for piece in done] == _pieces(task.runs, batch)
    return pd.concat([read(BytesIO(piece.content)) for piece in done], ignore_index=True)


@pytest.mark.parametrize("workers", [1, 2])
@pytest.mark.parametrize("threads", [True, False])
@pytest.mark.parametrize("batch", [1, 4, 100])
def test_the_place_changes_nothing(workers: int, threads: bool, batch: int) -> None:
    task = Draws(11, threads=threads)
    pd.testing.assert_frame_equal(
        _table(task, batch, Local(workers)), task.rows(0, 11), check_dtype=False, check_exact=True
    )


def test_a_run_that_raises_is_recorded_and_its_neighbours_are_done() -> None:
    table = _table(Draws(10, raising=(2, 7)), 5, Local(2))
    assert list(table.run[table.failure != ""]) == [2, 7]
    assert table.failure[2] == "ValueError: run 2 is odd"
    assert table.value.isna().sum() == 2


@pytest.mark.parametrize("workers", [1, 2])
def test_a_run_that_ends_its_process_is_recorded_and_its_neighbours_are_done(workers: int) -> None:
    table = _table(Draws(24, killing=(5,), seconds=0.005), 3, Local(workers), halved=True)
    assert list(table.run) == list(range(24))
    assert list(table.run[table.failure != ""]) == [5]
    assert "ended 2 times" in table.failure[5]


def test_two_that_end_their_processes_at_once_are_told_from_the_others() -> None:
    table = _table(Draws(8, killing=(0, 1)), 1, Local(2))
    assert list(table.run[table.failure != ""]) == [0, 1]


@pytest.mark.parametrize("threads", [True, False])
def test_pieces_wait_for_those_who_take_results_away(threads: bool) -> None:
    taken = 0

    def pieces() -> Iterator[Piece]:
        nonlocal taken
        for run in range(1000):
            taken += 1
            yield run, run + 1

    given = ahead = 0
    for _ in execute(_order(Draws(1000, threads=threads)), pieces(), Local(2)):
        given += 1
        ahead = max(ahead, taken - given)
    assert given == 1000
    assert 2 <= ahead <= 4 * 2 + 32


def test_a_pool_that_was_given_up_takes_no_more_pieces() -> None:
    under_way = _UnderWay(iter(_pieces(9, 3)), limit=2)
    given_up = under_way.take()
    assert next(given_up) == (0, 3)
    assert under_way.take_back() == [(0, 3)]
    assert list(given_up) == []
    assert list(under_way.take()) == [(3, 6), (6, 9)]  # and then the limit


def test_results_may_be_left() -> None:
    results = execute(_order(Draws(100, seconds=0.01)), _pieces(100, 1), Local(2))
    assert next(results).stop >= 1
    results.close()  # pytest would raise what joblib warns of


class _Wrong(Draws):
    def rows(self, start: int, stop: int) -> pd.DataFrame:
        return super().rows(start, stop).astype({"value": "int64"})


def test_a_table_that_breaks_the_promise_is_refused() -> None:
    with pytest.raises(ValueError, match=r"rows\(\) gives the columns"):
        list(execute(_order(_Wrong(2, threads=True)), [(0, 2)], Local(1)))
