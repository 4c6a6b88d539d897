"""Gains by chance are told from gains that last, whatever the noise."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from elastic_tendon.diagnosis.answer import facts_between, refit
from elastic_tendon.diagnosis.evidence import Evidence
from elastic_tendon.diagnosis.significance import (
    CHANCE,
    heldout_significance,
    heldout_worse,
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
    before, after = Evidence(()).of([without, with_friction])
    assert after < before - 100.0


def test_no_change_is_no_gain(pair) -> None:
    assert significance(pair[1], pair[1], COULOMB) == 1.0


def test_held_out_errors_fall_to_the_noise(pair) -> None:
    without, with_friction, heldout = pair
    judge = Evidence((heldout,))
    before, after = map(judge.heldout_errors, (without, with_friction))
    assert np.mean(after**2) == pytest.approx(1.0, abs=0.3)
    assert heldout_significance(before, after, [heldout]) < 0.01
    assert heldout_worse(before, after, [heldout])
    assert not heldout_worse(after, before, [heldout])


def test_a_single_bad_moment_on_held_out_data_refutes_nothing(pair) -> None:
    heldout = pair[2]
    before = np.random.default_rng(1).standard_normal(len(heldout.time))
    after = before.copy()
    after[:50] *= 6.0
    assert np.mean(after**2) > 1.2 * np.mean(before**2)
    assert not heldout_worse(after, before, [heldout])
    assert heldout_worse(1.2 * before, before, [heldout])


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
    likely = significance(without, with_friction, COULOMB) < CHANCE
    taken = Evidence(()).best([without, with_friction]) is with_friction
    assert not (likely and taken)
    assert facts_between(without, with_friction) < 0.2 * len(noisy.time)
