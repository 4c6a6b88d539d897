"""What speaks against an answer, and what is the best then."""

from dataclasses import replace

import numpy as np
import pytest

from begun_search import COULOMB, DRAG, GRAVITY, NOISE, SHORT, begun
from elastic_tendon.diagnosis import doubts as doubting
from elastic_tendon.diagnosis.answer import refit
from elastic_tendon.diagnosis.data import data_of
from elastic_tendon.diagnosis.diagnose import BEGUN
from elastic_tendon.diagnosis.evidence import FADES_IN_TIME, MUCH
from elastic_tendon.diagnosis.options import Options
from elastic_tendon.diagnosis.search import Search
from elastic_tendon.progress import silent
from smooth_motion import GIVEN, played, typical_model

STRIBECK = ("stribeck_friction",)
ZEROS = ("joint_encoder_offset",), ("motor_encoder_offset",)


def test_what_is_not_found_on_stretches_left_out_is_refused(monkeypatch) -> None:
    search = begun(typical_model(*COULOMB, *GRAVITY), *COULOMB, *GRAVITY)
    search._refit([GRAVITY], "refitting")
    assert search.answer.added == GRAVITY
    assert search.answer.mean_square > MUCH
    monkeypatch.setattr(doubting, "BEYOND_CHANCE", np.inf)
    monkeypatch.setattr(
        doubting, "crossed_squares", lambda _given, answer, _at_once: np.full(4, answer.mean_square)
    )
    assert not search._fades_in_time()
    search._across.clear()
    monkeypatch.setattr(doubting, "crossed_squares", lambda *_asked: np.full(1, np.nan))
    assert not search._fades_in_time()  # too short to tell
    search._across.clear()
    monkeypatch.setattr(doubting, "crossed_squares", lambda *_asked: np.full(4, 100.0))
    assert search._fades_in_time()
    assert search.why_refused(GRAVITY) == FADES_IN_TIME
    assert search.answer.added == ()
    assert not search._fades_in_time()


def test_what_explains_nearly_all_is_no_chance_wherever_it_shows(monkeypatch) -> None:
    """A stop may be reached in one stretch only."""
    search = begun(typical_model(*COULOMB, *GRAVITY), *COULOMB, *GRAVITY)
    search._refit([GRAVITY], "refitting")
    gain = search._left(()) / search._left(GRAVITY)
    monkeypatch.setattr(doubting, "crossed_squares", lambda *_asked: np.full(4, 100.0))
    monkeypatch.setattr(doubting, "BEYOND_CHANCE", 0.99 * gain)
    assert not search._fades_in_time()
    monkeypatch.setattr(doubting, "BEYOND_CHANCE", 1.01 * gain)
    assert search._fades_in_time()


@pytest.mark.parametrize(("heldout", "doubted"), [(1.0, False), (2.0, True)])
def test_what_held_out_recordings_do_not_reach_is_judged_by_the_fitted_ones(
    monkeypatch, heldout: float, doubted: bool
) -> None:
    search = begun(typical_model(*GRAVITY), *GRAVITY)
    search._refit([GRAVITY], "refitting")
    answer = search.answers[GRAVITY]
    assert answer.mean_square < MUCH
    monkeypatch.setattr(search, "data", replace(search.data, heldout=search.data.fitted))
    monkeypatch.setattr(search.evidence, "heldout_square", lambda _answer: heldout)
    monkeypatch.setattr(search.evidence, "heldout_errors", lambda _answer: np.ones(9))
    monkeypatch.setattr(doubting, "significance", lambda *_asked: 0.4)
    monkeypatch.setattr(doubting, "heldout_significance", lambda *_asked: 0.5)
    monkeypatch.setattr(doubting, "heldout_worse", lambda *_asked: False)
    assert (search._doubt(answer, *GRAVITY) is not None) == doubted


def test_an_effect_that_the_screen_does_not_miss_is_refitted_without() -> None:
    search = begun(typical_model(*DRAG), *COULOMB, *DRAG)
    search._refit([(*COULOMB, *DRAG)], "")
    answer = search.answers[(*COULOMB, *DRAG)]
    assert search._close(DRAG, answer)
    assert not search._close(COULOMB, answer)


@pytest.mark.parametrize(
    ("options", "tried"),
    [
        (Options(only=STRIBECK), False),
        (Options(without=COULOMB), False),
        (Options(only=(*STRIBECK, *COULOMB)), True),
    ],
)
def test_a_simpler_law_is_tried_only_where_it_may_be_the_answer(options, tried: bool) -> None:
    recording = played(typical_model(*COULOMB), SHORT).recording(NOISE)
    search = Search.of(data_of(GIVEN, [recording], [], options), silent)
    search.base()
    search._refit([STRIBECK], "")
    search._better_as_simple()
    assert (COULOMB in search.answers) == tried


def test_gravity_is_held_against_a_constant_torque() -> None:
    search = begun(typical_model(*GRAVITY), *GRAVITY, "constant_torque")
    search._refit([GRAVITY], "")
    search._better_as_simple()
    assert ("constant_torque",) in search.answers


def test_what_errs_as_a_refused_answer_is_refused_too() -> None:
    truth = typical_model(*COULOMB, *ZEROS[0])
    search = begun(truth, *COULOMB, *ZEROS[0], *ZEROS[1])
    search._refit([*ZEROS, COULOMB], "refitting")
    assert search.answer.added == ZEROS[0]
    assert search.answer.mean_square > MUCH
    assert not search._errs_as_refused()
    search.refused[ZEROS[0]] = FADES_IN_TIME
    assert search.answer.added == ZEROS[1]
    assert search._errs_as_refused()
    assert search.why_refused(ZEROS[1]) == f"errs like Joint encoder offset: {FADES_IN_TIME}"
    assert search.answer.added not in ZEROS
    assert COULOMB not in search.refused
    assert not search._errs_as_refused()


def test_a_simpler_law_begins_at_the_richer_ones_parameters() -> None:
    search = begun(typical_model(*COULOMB), *COULOMB, *STRIBECK)
    search._refit([STRIBECK], "refitting")
    assert search.answer.added == STRIBECK
    assert search._better_as_simple()
    assert search.answer.added == COULOMB
    search.answers = {added: search.answers[added] for added in ((), STRIBECK)}
    assert not search._better_as_simple()  # once is enough


def test_what_led_a_refit_the_right_way_is_not_needed() -> None:
    search = begun(typical_model(*DRAG), *COULOMB, *DRAG)
    both = (*COULOMB, *DRAG)
    search._refit([both], "refitting")
    data = search.data
    for added in (COULOMB, DRAG):  # refits that went nowhere
        search.answers[added] = refit(data.given, added, data.fitted, effort=BEGUN)
    assert search.answer.added == both
    assert search._better_as_simple()
    assert search.answer.added == DRAG
    assert search._at_noise()


def test_numbers_that_an_effect_warns_of_do_not_stand_where_much_is_left(monkeypatch) -> None:
    search = begun(typical_model(*COULOMB, *GRAVITY), *COULOMB, *GRAVITY)
    search._refit([GRAVITY], "refitting")
    assert search.answer.mean_square > MUCH
    assert not search._warned_of()
    monkeypatch.setattr(doubting, "cautions", lambda _numbers, _present: ["it bends too far"])
    assert search._warned_of()
    assert search.why_refused(GRAVITY) == "it bends too far"
