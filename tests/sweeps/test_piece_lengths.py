"""How a sweep on a cluster is cut into pieces: few enough to be dealt out, the last ones short."""

import pytest

from elastic_tendon.sweeps.cluster import PIECE_BYTES, PIECE_SECONDS, PIECES, Lengths
from elastic_tendon.sweeps.work import Ranges

DEALT = 0.005  # s of client and scheduler for a piece, as build_scripts/benchmark_cluster.py finds


def cut(runs: int, seconds: float, workers: int, bytes_of_run: int = 0) -> list[float]:
    """Time that each piece of a sweep takes, s; its runs are all alike."""
    pieces, lengths, taken = Ranges([(0, runs)], 1, tuned=True), Lengths(), []
    for start, stop in pieces:
        taken.append((stop - start) * seconds)
        lengths.learn((start, stop), (0, bytes((stop - start) * bytes_of_run), 0, taken[-1]))
        lengths.tune(pieces, workers)
    return taken[1:]  # nothing is known before the first


@pytest.mark.parametrize("workers", [2, 50, 1000])
@pytest.mark.parametrize("seconds", [0.001, 0.02, 1.0])
def test_dealing_out_takes_less_time_than_the_work(seconds: float, workers: int) -> None:
    work = 60.0  # s of each worker
    taken = cut(round(work * workers / seconds), seconds, workers)
    assert sum(taken) == pytest.approx(work * workers - seconds)
    assert len(taken) * DEALT < work


def test_pieces_grow_shorter_towards_the_end_alone() -> None:
    taken = cut(200_000, 0.1, workers=10)
    assert taken == sorted(taken, reverse=True)
    assert taken[0] == pytest.approx(PIECE_SECONDS[0], rel=0.02)
    assert taken[-1] <= 0.1 + 1e-9
    assert sum(taken[-20:]) < PIECE_SECONDS[0]  # who is last has little left to wait for


def test_more_work_makes_longer_pieces_up_to_a_bound() -> None:
    seconds, workers = 1.0, 2
    first = [cut(runs, seconds, workers)[0] for runs in (1_000, 30_000, 200_000)]
    expected = [PIECE_SECONDS[0], 30_000 / (workers * PIECES), PIECE_SECONDS[1]]
    assert first == pytest.approx(expected, abs=seconds)  # whole runs


def test_much_that_comes_back_makes_pieces_short() -> None:
    taken = cut(1000, 0.1, workers=2, bytes_of_run=PIECE_BYTES // 10)
    assert max(taken) == pytest.approx(10 * 0.1)
