"""Refits of resampled errors: the same for the same seed, and as wide as the truth calls for."""

import pickle
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from elastic_tendon.actuator.parameters import Model, parse_model
from elastic_tendon.errors import ModelError, SimulationError, SweepError
from elastic_tendon.estimation.coordinates import Coordinates
from elastic_tendon.sweeps import bootstrap as subject
from elastic_tendon.sweeps.bootstrap import FEWEST_REFITS, bootstrap, intervals
from elastic_tendon.sweeps.task import FAILURE, RUN
from hidden_effect.cases import Order, generator, machine_in, machine_of, recording_of
from hidden_effect.machines import UNCERTAINTY, get, sigma_of, with_numbers
from hidden_effect.recordings import Noise

SIGMA = 2e-4  # rad, of the encoder
DURATION = 3.0  # s
DAMPING = "link.damping"


def recorded(seed, noise="white"):
    """A model with numbers off by what it says of them, a recording, and the true numbers."""
    order = Order("nothing", noise=noise, seed=seed, duration=DURATION)
    tree, lot = machine_of(order).tree, generator(order, "given")
    numbers = {
        path: get(tree, path) * (1.0 + 0.3 * UNCERTAINTY[path] * lot.standard_normal())
        for path in UNCERTAINTY
    }
    given = with_numbers(tree, numbers)
    machine = machine_in(order, tree, given, int(lot.integers(1 << 30)))
    shown = recording_of(order, machine, tree, Noise(noise, SIGMA), "fit")
    sigmas = {path: sigma_of(tree, path) / (get(given, path) or 1.0) for path in UNCERTAINTY}
    model = parse_model(given | {"uncertainty": sigmas}, "given")
    return model, shown.measurement, {path: get(tree, path) for path in UNCERTAINTY}


@pytest.fixture(scope="module")
def example():
    return recorded(3)


@pytest.fixture(scope="module")
def task(example):
    model, measurement, _ = example
    return bootstrap(model, [measurement], runs=4, seed=1)


def test_runs_depend_on_seed_and_number_alone(example, task):
    together = task.rows(0, 3)
    travelled = pickle.loads(pickle.dumps(task))
    alone = pd.concat([travelled.rows(run, run + 1) for run in range(3)], ignore_index=True)
    pd.testing.assert_frame_equal(together, alone, check_exact=True)
    assert together[RUN].tolist() == [0, 1, 2]
    assert together[DAMPING].nunique() == 3
    model, measurement, _ = example
    different = bootstrap(model, [measurement], runs=4, seed=2)
    assert not np.isclose(different.rows(0, 1)[DAMPING][0], together[DAMPING][0], rtol=1e-9)
    assert different.identity["data"] == task.identity["data"]
    assert different.identity != task.identity


def test_identity_knows_the_data(example, task):
    model, measurement, _ = example
    noisier = {name: 1.001 * values for name, values in measurement.signals.items()}
    different = bootstrap(model, [replace(measurement, signals=noisier)], runs=4, seed=1)
    assert different.identity["data"] != task.identity["data"]


def test_failed_runs_have_the_columns_of_good_ones(task):
    good, failed = task.rows(2, 3), task.failed(2, "the reason")
    assert list(failed.columns) == list(good.columns)
    assert list(failed.columns) == [RUN, *task.paths, FAILURE]
    assert failed.dtypes.equals(good.dtypes)
    assert failed[FAILURE][0] == "the reason"
    assert failed[list(task.paths)].isna().all(axis=None)


def test_only_what_is_free_is_refitted(example):
    model, measurement, _ = example
    task = bootstrap(model, [measurement], runs=1, seed=0, free=[DAMPING])
    assert list(task.rows(0, 1).columns) == [RUN, DAMPING, FAILURE]


@pytest.mark.parametrize(
    ("free", "words"),
    [
        (["link.dampng"], "did you mean link.damping?"),
        (["transmission.joint_pulley_radius"], "counts as known and cannot be fitted"),
        ([], "no parameter is free"),
    ],
)
def test_numbers_that_cannot_be_fitted_are_refused(example, free, words):
    model, measurement, _ = example
    with pytest.raises(ModelError) as caught:
        bootstrap(model, [measurement], runs=1, seed=0, free=free)
    assert words in str(caught.value)


@pytest.mark.parametrize(("runs", "seed"), [(0, 1), (3, -1)])
def test_no_refits_are_refused(example, runs, seed):
    model, measurement, _ = example
    with pytest.raises(SweepError, match="at least one"):
        bootstrap(model, [measurement], runs=runs, seed=seed)


def test_nothing_to_refit_is_refused(example):
    with pytest.raises(SweepError, match="at least one recording"):
        bootstrap(example[0], [], runs=1, seed=0)


def test_an_interrupt_leaves_no_half_refit(task, monkeypatch):
    def interrupted(*_arguments, **_options):
        raise KeyboardInterrupt

    monkeypatch.setattr("elastic_tendon.estimation.fit._run", interrupted)
    with pytest.raises(KeyboardInterrupt):
        task.rows(0, 1)


def test_a_refit_that_cannot_begin_says_so(task, monkeypatch):
    def refused(*_arguments, **_options):
        raise SimulationError("stuck")

    monkeypatch.setattr(subject, "fit", refused)
    with pytest.raises(SimulationError, match="stuck"):
        task.rows(0, 1)


# ---- what is resampled -------------------------------------------------------------------------


def test_blocks_are_pieces_of_the_errors():
    order = subject._order(1000, 7, np.random.default_rng(0))
    assert len(order) == 1000
    inside = np.arange(1, 1000) % 7 != 0
    assert np.all((np.diff(order)[inside] % 1000) == 1)
    # drawn anew, not shuffled
    assert 0.55 < len(np.unique(order)) / 1000 < 0.72


def test_every_sample_is_drawn_alike():
    lot = np.random.default_rng(1)
    counts = sum(np.bincount(subject._order(60, 13, lot), minlength=60) for _ in range(4000))
    assert np.ptp(counts) < 0.2 * counts.mean()


def test_blocks_grow_with_the_memory_of_the_errors(example, task):
    model, measurement, _ = recorded(3, "coloured")
    coloured = bootstrap(model, [measurement], runs=1, seed=0)
    # white: n^(1/3); of 0.9 from one sample to the next: some 19 samples say as much as one
    assert task.blocks == (round(len(example[1].time) ** (1 / 3)),)
    assert coloured.blocks[0] > 40


def test_signals_of_a_recording_keep_together(task):
    errors = task.errors[0]["joint_position"]
    both = {"joint_position": errors, "joint_torque": -2.0 * errors}
    two = replace(task.simulated[0], signals=dict.fromkeys(both, np.zeros(len(errors))))
    again = subject._recorded_again(two, both, 12, np.random.default_rng(5))
    assert np.std(again.signals["joint_position"]) > 0.0
    np.testing.assert_allclose(
        again.signals["joint_torque"], -2.0 * again.signals["joint_position"], rtol=1e-12
    )


def test_given_numbers_scatter_as_the_prior_does(task):
    fitted = task.fitted.model
    lot = np.random.default_rng(2)
    drawn = [subject._given_again(fitted, task.paths, lot) for _ in range(300)]
    path = "transmission.upper_spring.stiffness"
    sigma = Coordinates.of(fitted, [path]).sigma[0]
    values = np.array([refitted.values()[path] for refitted in drawn])
    assert np.std(values) == pytest.approx(sigma, rel=0.2)
    assert np.mean(values) == pytest.approx(fitted.values()[path], abs=0.3 * sigma)
    # their sigmas stay what they are, whatever the values
    assert {round(refitted.uncertainty_of(path) / sigma, 9) for refitted in drawn} == {1.0}
    assert all(isinstance(refitted, Model) for refitted in drawn)


def test_numbers_drawn_at_a_bound_lie_on_it(task):
    # far above a damping that cannot be negative, where rounding would lead below it
    path = "transmission.upper_spring.damping"
    for damping in np.random.default_rng(3).uniform(0.1, 8.0, 30):
        fitted = subject._with_sigmas(
            task.fitted.model.with_values({path: damping}), {path: 1e3 * damping}
        )
        drawn = [
            subject._given_again(fitted, [path], np.random.default_rng(number))
            for number in range(8)
        ]
        assert min(refitted.values()[path] for refitted in drawn) == 0.0


# ---- intervals ---------------------------------------------------------------------------------


def table_of(task, values):
    columns = dict.fromkeys(task.paths, values)
    return pd.DataFrame({RUN: np.arange(len(values)), **columns, FAILURE: ""})


def test_a_further_refit_lies_beyond_the_interval_with_five_per_cent(task):
    found = intervals(task, table_of(task, np.arange(1.0, 40.0)))
    assert {interval.bootstrap for interval in found} == {(1.0, 39.0)}
    found = intervals(task, table_of(task, np.arange(1.0, 1000.0)))
    assert [interval.path for interval in found] == list(task.paths)
    np.testing.assert_allclose(found[0].bootstrap, (25.0, 975.0))
    assert found[0].linear == task.estimates[0].interval
    assert found[0].fitted == task.estimates[0].fitted


def test_failed_refits_do_not_count(task):
    good = table_of(task, np.arange(1.0, 40.0))
    with_failure = pd.concat([good, task.failed(39, "x")], ignore_index=True)
    assert intervals(task, with_failure) == intervals(task, good)


def test_too_few_refits_have_no_interval(task):
    with pytest.raises(SweepError, match=f"38 of 38 .* needs {FEWEST_REFITS}"):
        intervals(task, table_of(task, np.arange(38.0)))


def test_intervals_hold_the_truth():
    """Two machines of the independent simulator; the study behind it counted far more."""
    offsets, held = [], []
    for seed in (11, 12):
        model, measurement, truth = recorded(seed)
        task = bootstrap(model, [measurement], runs=FEWEST_REFITS, seed=seed)
        table = task.rows(0, FEWEST_REFITS)
        for interval in intervals(task, table):
            held.append(interval.bootstrap[0] <= truth[interval.path] <= interval.bootstrap[1])
            offsets.append((interval.fitted - truth[interval.path]) / table[interval.path].std())
    assert len(held) == 14
    assert np.count_nonzero(held) >= 11
    assert 0.4 < np.sqrt(np.mean(np.square(offsets))) < 1.6
