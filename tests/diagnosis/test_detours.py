"""Ways to a better answer where no neighbour is, and when there is none."""

from dataclasses import replace

import numpy as np

from begun_search import (
    COULOMB,
    DRAG,
    ECCENTRIC,
    ECCENTRICITY,
    FEW,
    GRAVITY,
    MASS,
    NOISE,
    begun,
    run,
)
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.diagnosis import around, detours
from elastic_tendon.diagnosis.answer import refit
from elastic_tendon.diagnosis.data import data_of
from elastic_tendon.diagnosis.search import Search
from elastic_tendon.diagnosis.sets import (
    in_order,
)
from elastic_tendon.progress import silent
from elastic_tendon.simulation.simulate import simulate
from smooth_motion import DURATION, GIVEN, played, typical_model

STOP, OFFSET = ("joint_stop",), ("joint_encoder_offset",)


def test_where_much_is_left_every_effect_is_tried(monkeypatch) -> None:
    search = begun(typical_model(*DRAG), *COULOMB, *GRAVITY, *DRAG)
    assert search._better_single()
    assert set(search.answers) == {(), COULOMB, GRAVITY, DRAG}
    assert search.answer.added == DRAG
    monkeypatch.setattr(search, "_refit", None)  # nothing is, where nothing is left
    assert not search._better_single()


def test_where_much_is_left_sets_that_were_passed_by_are_grown(monkeypatch) -> None:
    search = begun(typical_model(*COULOMB, *GRAVITY), *COULOMB, *GRAVITY, *DRAG)
    search._refit([GRAVITY], "refitting")
    assert search.answer.added == GRAVITY
    search._better_detour()
    assert COULOMB in search.answers
    search.answers = {added: search.answers[added] for added in ((), GRAVITY)}
    assert not search._better_detour()  # once is enough
    assert COULOMB not in search.answers
    search._refit([in_order((*COULOMB, *GRAVITY))], "refitting")
    assert search._at_noise()
    search._passed.clear()
    monkeypatch.setattr(search, "_looks", None)  # no look, where nothing is left
    assert not search._better_detour()


def test_a_rare_effect_is_found_early_or_leaves_no_trace(monkeypatch) -> None:
    search = begun(typical_model(*GRAVITY).with_effect("cubic_damping", {"coefficient": 0.02}))
    search._refit([GRAVITY], "refitting")
    known = dict(search.answers)
    assert not search._at_noise()
    search._explained_at_once_by_rare()
    both = in_order((*GRAVITY, "cubic_damping"))
    assert search.answer.added == both
    assert search._at_noise()
    # where it leaves more than a rare one may, nothing is built upon it
    search.answers = known
    monkeypatch.setattr(detours, "HARDLY_MORE", 0.0)
    monkeypatch.setattr(detours, "AT_NOISE", 0.0)
    search._explained_at_once_by_rare()
    assert set(search.answers) == {(), GRAVITY}
    assert search.refused == {}


def test_two_effects_are_found_at_once() -> None:
    """An eccentricity whose error is not zero where the motor's position is zero."""
    truth = typical_model().with_effect("pulley_eccentricity", ECCENTRIC)
    offset = {"offset": -0.006}
    search = begun(truth.with_effect("joint_encoder_offset", offset), *ECCENTRICITY, *OFFSET, *DRAG)
    both = in_order((*ECCENTRICITY, *OFFSET))
    assert search._two_at_once((), [*ECCENTRICITY, *OFFSET, *DRAG]) == [both]
    assert search._better_with_two()
    assert search.answer.added == both
    assert search._at_noise()
    search.answers = {(): search.answers[()]}
    assert not search._better_with_two()  # once is enough


def disturbed(truth: Model) -> Search:
    """A search beside a random load of which nobody knows."""
    run = played(truth, DURATION)
    rng = np.random.default_rng(5)
    frequencies, phases = rng.uniform(0.3, 4.0, 30), rng.uniform(0.0, 2.0 * np.pi, 30)
    waves = np.cos(2.0 * np.pi * np.outer(run.time, frequencies) + phases).sum(axis=1)
    shaken = simulate(truth, run.time, run.motor, run.load + 0.01 * waves)
    recording = run.recording(NOISE)
    signals = {"joint_position": recording.signals["joint_position"]}
    signals["joint_position"] += shaken["joint_position"] - run.joint(run.time)
    data = data_of(GIVEN, [replace(recording, signals=signals)], [], FEW)
    search = Search.of(data, silent)
    search.base()
    return search


def test_where_only_a_disturbance_is_left_nothing_else_is_tried(monkeypatch) -> None:
    search = disturbed(GIVEN)
    assert search.answer.mean_square > 4.0
    assert search._disturbed()
    for later in ("_hop", "_better_single"):
        monkeypatch.setattr(search, later, None)
    run(search)
    assert not search._exhausted  # no addition was tried
    assert search.answer.added == ()
    assert not disturbed(typical_model(*COULOMB))._disturbed()


def test_what_is_expected_to_do_better_is_no_disturbance() -> None:
    search = disturbed(GIVEN)
    search.neighbours[()] = {GRAVITY: -50.0, DRAG: -20.0}
    assert not search._disturbed()
    search.failures[GRAVITY] = "the likeliest was tried, and did not do better"
    assert search._disturbed()


def test_what_swings_leaves_no_disturbance(monkeypatch) -> None:
    search = disturbed(GIVEN)
    assert search._disturbed()
    swinging = replace(search.answer, added=MASS)
    monkeypatch.setattr(Search, "answer", swinging)
    assert not search._disturbed()


def test_additions_race_from_many_places() -> None:
    search = begun(typical_model(*STOP), *STOP, *GRAVITY, *DRAG)
    search.estimates.clear()  # as where a joint sticks, and torques tell nothing
    (best, *others), base = search._raced(search.answer, [*GRAVITY, *STOP]), search.answer
    assert best == STOP
    assert set(others) <= {GRAVITY}
    (start,) = search.starts[STOP]
    scouted = refit(search.data.given, STOP, search.data.fitted, [start], around.SCOUTING)
    assert scouted.mean_square < 0.1 * base.mean_square


def test_where_simulations_are_dear_no_additions_race(monkeypatch) -> None:
    search = begun(typical_model(*DRAG), *GRAVITY, *DRAG)
    monkeypatch.setattr(search, "_raced", None)
    monkeypatch.setattr(search, "_dear", lambda _: True)
    assert search._better_addition()
    assert search.answer.added == DRAG


def test_only_a_peak_of_what_may_swing_tells_that_it_rings(heavy, monkeypatch) -> None:
    asked = []
    monkeypatch.setattr(
        detours, "frequencies", lambda effect_id, _: asked.append(effect_id) or [200.0]
    )
    assert heavy._rings(())
    assert asked == list(MASS)
    assert not begun(typical_model(*DRAG), *DRAG)._rings(())
