"""Gains by chance are told from gains that last, whatever the noise."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from elastic_tendon.diagnosis.answer import bics, facts_between, refit
from elastic_tendon.diagnosis.confirm import (
    heldout_errors,
    heldout_significance,
    refuted,
    significance,
)
from recorded_machines import FRICTION

COULOMB = "coulomb_friction"


@pytest.fixture(scope="module")
def pair(sticking):
    """The sticking machine without and with friction, and the recording held out."""
    known, recording, heldout = sticking
    without = refit(known.model, (), [recording])
    start = without.result.model.with_effect(COULOMB, {"torque": FRICTION})
    return without, refit(known.model, (COULOMB,), [recording], [start]), heldout


def test_friction_that_is_there_is_no_chance(pair) -> None:
    without, with_friction, _ = pair
    assert significance(without, with_friction, COULOMB) < 1e-6
    assert bics([without, with_friction])[1] < bics([without, with_friction])[0] - 100.0


def test_held_out_errors_fall_to_the_noise(pair) -> None:
    without, with_friction, heldout = pair
    before, after = (heldout_errors(one, [heldout]) for one in (without, with_friction))
    assert np.mean(after**2) == pytest.approx(1.0, abs=0.3)
    assert heldout_significance(before, after, [heldout]) < 0.01
    assert refuted(before, after, [heldout])
    assert not refuted(after, before, [heldout])


def test_stretches_judge_each_other_where_nothing_is_held_out(pair) -> None:
    without, with_friction, _ = pair
    predicted = heldout_errors(with_friction, [])
    assert predicted.shape == with_friction.floored.shape
    # a prediction is worse than a fit, but not as bad as the wrong model
    assert np.mean(with_friction.floored**2) < np.mean(predicted**2)
    assert np.mean(predicted**2) < 0.01 * np.mean(without.floored**2)


@pytest.mark.parametrize("seed", range(6))
def test_coloured_noise_is_no_friction(frictionless, seed) -> None:
    known, recording = frictionless
    drive = np.random.default_rng(seed).standard_normal(len(recording.time))
    coloured = 1e-3 * lfilter([1.0], [1.0, -0.98], drive)
    position = recording.signals["joint_position"] + coloured
    noisy = replace(recording, signals={"joint_position": position})
    without = refit(known.model, (), [noisy])
    start = without.result.model.with_effect(COULOMB, {"torque": 0.01})
    with_friction = refit(known.model, (COULOMB,), [noisy], [start])
    taken = significance(without, with_friction, COULOMB) < 0.01
    own, other = bics([without, with_friction])
    assert not (taken and other < own - 10.0)
    assert facts_between(without, with_friction) < 0.2 * len(noisy.time)
