"""Points of a sweep: each run has its own, however it is asked for."""

import itertools
import pickle
import time
import tracemalloc

import numpy as np
import pytest
from scipy import stats
from scipy.stats import qmc

from elastic_tendon.errors import SweepError
from elastic_tendon.sweeps import points as module
from elastic_tendon.sweeps.factors import Factor, Normal, Uniform, Values
from elastic_tendon.sweeps.points import BLOCK, LATIN_BLOCK, Points, points

DRAWN = ("monte-carlo", "latin-hypercube", "sobol")
FACTORS = (
    Factor("link.damping", Uniform(0.1, 0.3)),
    Factor("link.inertia", Normal(0.03, 0.01, 1e-9, 1e4)),
    Factor("transmission.upper_spring.parallel", Values((1.0, 2.0, 4.0))),
)
MANY = tuple(Factor(path, Values((0.0,) * 100_000)) for path in ("a", "b"))


@pytest.mark.parametrize("method", DRAWN)
def test_a_run_has_its_point_however_it_is_asked_for(method):
    drawn = points(FACTORS, method, 10_000, seed=7)
    whole = drawn.rows(0, 10_000)
    cuts = [0, 1, 17, BLOCK - 1, BLOCK, BLOCK + 1, 9_000, 10_000]
    slices = [drawn.rows(start, stop) for start, stop in itertools.pairwise(cuts)]
    np.testing.assert_array_equal(np.concatenate(slices), whole)
    again = pickle.loads(pickle.dumps(drawn))
    np.testing.assert_array_equal(again.rows(4_090, 4_100), whole[4_090:4_100])
    reseeded = points(FACTORS, method, 10_000, seed=8).rows(0, 10_000)
    assert not (reseeded[:, 0] == whole[:, 0]).any()


@pytest.mark.parametrize("method", DRAWN)
def test_points_are_distributed_as_the_factors_say(method):
    drawn = points(FACTORS, method, 8_192, seed=1).rows(0, 8_192)
    for column, law in ((0, stats.uniform(0.1, 0.2)), (1, stats.norm(0.03, 0.01))):
        assert stats.kstest(drawn[:, column], law.cdf).pvalue > 1e-3
    _, counts = np.unique(drawn[:, 2], return_counts=True)
    assert np.abs(counts / 8_192 - 1 / 3).max() < 0.02
    assert abs(np.corrcoef(drawn[:, 0], drawn[:, 1])[0, 1]) < 0.05


def _shares(method, count, seed=3):
    unit = tuple(Factor(f"{number}", Uniform(0.0, 1.0)) for number in range(3))
    return points(unit, method, count, seed).rows(0, count)


def test_latin_hypercube_has_one_point_in_each_row_of_each_block():
    count = LATIN_BLOCK + 1000
    drawn = _shares("latin-hypercube", count)
    for block in (drawn[:LATIN_BLOCK], drawn[LATIN_BLOCK:]):
        cells = np.floor(block * len(block)).astype(int)
        for column in range(3):
            assert np.unique(cells[:, column]).size == len(block)


def test_sobol_points_fill_space_more_evenly_than_random_ones():
    sobol, random = (qmc.discrepancy(_shares(method, 2048)) for method in ("sobol", "monte-carlo"))
    assert sobol < random / 20.0


def test_sobol_points_of_a_later_block_go_on_with_the_sequence():
    whole = qmc.Sobol(3, bits=30, seed=np.random.default_rng(3)).random(4 * BLOCK)
    drawn = _shares("sobol", 4 * BLOCK)
    np.testing.assert_allclose(drawn, whole, rtol=0.0, atol=2.0**-30)
    assert drawn.min() > 0.0


@pytest.mark.parametrize("method", ["monte-carlo", "sobol"])
def test_more_runs_go_on_where_fewer_ended(method):
    fewer, more = points(FACTORS, method, 100), points(FACTORS, method, 9_000)
    np.testing.assert_array_equal(fewer.rows(0, 100), more.rows(0, 100))


def test_grid_has_all_combinations_the_last_factor_fastest():
    grid = points(
        [
            Factor("a", Values((1.0, 2.0))),
            Factor("b", Values((5.0, 4.0, 3.0))),
            Factor("c", Values((0.0, 9.0))),
        ],
        "grid",
    )
    expected = list(itertools.product((1.0, 2.0), (5.0, 4.0, 3.0), (0.0, 9.0)))
    assert grid.count == 12
    assert grid.rows(0, 12).tolist() == [list(row) for row in expected]
    assert grid.rows(5, 8).tolist() == [list(row) for row in expected[5:8]]


@pytest.mark.parametrize("method", DRAWN)
def test_memory_does_not_grow_with_the_number_of_runs(method):
    peaks = []
    for count in (200_000, 3_000_000):
        drawn = points(FACTORS, method, count, seed=count)
        tracemalloc.start()
        drawn.rows(count - 5_000, count)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] < 1.5 * peaks[0] + 1e5
    assert peaks[1] < 20e6


def test_identity_tells_points_apart():
    base = points(FACTORS, "sobol", 100, 1)
    by_a_hair = Uniform(0.1, float(np.nextafter(0.3, 1.0)))
    others = [
        points(FACTORS, "sobol", 100, 2),
        points(FACTORS, "latin-hypercube", 100, 1),
        points(FACTORS, "monte-carlo", 100, 1),
        points(FACTORS[:2], "sobol", 100, 1),
        points((Factor("link.damping", by_a_hair), *FACTORS[1:]), "sobol", 100, 1),
    ]
    assert base.identity == points(FACTORS, "sobol", 100, 1).identity
    assert not any(changed.identity == base.identity for changed in others)


@pytest.mark.parametrize("method", ["monte-carlo", "sobol"])
def test_more_runs_of_the_same_draw_go_on(method):
    few, more = points(FACTORS, method, 100, 1), points(FACTORS, method, 101, 1)
    assert few.identity == more.identity
    np.testing.assert_array_equal(few.rows(0, 100), more.rows(0, 100))


def test_a_latin_hypercube_is_another_one_where_it_has_more_runs():
    few, more = (points(FACTORS, "latin-hypercube", count, 1) for count in (100, 101))
    assert few.identity != more.identity


@pytest.mark.parametrize("count", [1, 2, 4096, 3 * 4096, 1_048_576, 7_000_000])
def test_a_jump_in_sobols_sequence_is_the_steps_it_leaves_out(count):
    steps, jump = (qmc.Sobol(5, bits=30, **module._random(3)) for _ in range(2))
    steps.fast_forward(count)
    module._jump(jump, count)
    np.testing.assert_array_equal(jump.random(64), steps.random(64))


def test_a_jump_takes_no_time():
    times = [time.process_time()]
    points(FACTORS, "sobol", 10**9, 1).rows(9 * 10**8, 9 * 10**8 + 10)
    times.append(time.process_time())
    qmc.Sobol(5, bits=30).fast_forward(9 * 10**7)  # step by step, a tenth of the way
    times.append(time.process_time())
    assert times[1] - times[0] < times[2] - times[1]


@pytest.mark.parametrize(
    ("factors", "method", "count", "seed", "said"),
    [
        ((), "sobol", 10, 0, "nothing varies"),
        (FACTORS[:1] * 2, "sobol", 10, 0, "link.damping: varies twice"),
        (FACTORS, "dice", 10, 0, "choose one of grid, monte-carlo, latin-hypercube, sobol"),
        (FACTORS, "sobol", None, 0, "give their number"),
        (FACTORS, "sobol", 0, 0, "1 to 1000000000"),
        (FACTORS, "sobol", 10**9 + 1, 0, "1 to 1000000000"),
        (FACTORS, "sobol", 10, -1, "negative"),
        (FACTORS, "grid", None, 0, "write link.damping=LOW:HIGH:COUNT"),
        (FACTORS[2:], "grid", 5, 0, "has 3 runs, not 5"),
        (MANY, "grid", None, 0, "10000000000 runs cannot be done"),
    ],
)
def test_what_cannot_be_drawn_is_told_in_one_sentence(factors, method, count, seed, said):
    with pytest.raises(SweepError) as refused:
        points(factors, method, count, seed)
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)


def test_points_check_themselves_where_they_are_made_by_hand():
    with pytest.raises(SweepError, match="has 3 runs, not 4"):
        Points(FACTORS[2:], "grid", 4, 0)
