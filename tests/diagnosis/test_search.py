"""The search: sets, their names and starts, refits that fail, and what is taken and refused."""

from dataclasses import replace

import numpy as np
import pytest

from begun_search import (
    BELIEVED,
    COULOMB,
    DRAG,
    ECCENTRIC,
    ECCENTRICITY,
    FEW,
    GRAVITY,
    MASS,
    SHORT,
    begun,
    run,
    searched,
)
from elastic_tendon.diagnosis import looks as looking
from elastic_tendon.diagnosis import refits as refitting
from elastic_tendon.diagnosis import search as searching
from elastic_tendon.diagnosis.answer import Answer, refit
from elastic_tendon.diagnosis.data import data_of
from elastic_tendon.diagnosis.options import Options
from elastic_tendon.diagnosis.rounds import (
    TAKEN,
    answers_alike,
    neighbours_of,
    round_at,
)
from elastic_tendon.diagnosis.search import Search
from elastic_tendon.diagnosis.sets import (
    change_between,
    in_order,
    model_with,
)
from elastic_tendon.errors import BuildError, ModelError, SimulationError
from elastic_tendon.estimation.fit import QUICK
from elastic_tendon.progress import silent
from recorded_machines import FRICTION
from smooth_motion import typical_model

THREE = ("gear_backlash", "joint_encoder_offset", "constant_torque")


# ---- the loop ------------------------------------------------------------------------------------


def test_friction_is_found_and_what_leads_to_it_is_kept(ended) -> None:
    assert ended.answer.added == COULOMB
    assert ended.ladder(refit=False) == [COULOMB]
    torque = ended.answer.values("coulomb_friction")["torque"]
    assert torque == pytest.approx(FRICTION, rel=0.05)


def test_the_screen_has_seen_every_candidate_and_every_neighbour(ended) -> None:
    singles = {added for added in ended.estimates if len(added) == 1}
    assert singles == {COULOMB, GRAVITY, DRAG}
    changes = {change_between(COULOMB, added) for added in ended.neighbours[COULOMB]}
    assert {"+gravity_load", "+quadratic_drag", "-coulomb_friction"} <= changes
    assert "coulomb_friction -> gravity_load" in changes


def test_no_neighbour_that_was_refitted_is_better(ended) -> None:
    rows = neighbours_of(ended, ended.answer)
    refitted = [row for row in rows if row.refitted]
    assert refitted
    for row in refitted:
        assert row.rmse["joint_position"] > 0.0
    # without friction it is far worse
    less = next(row for row in rows if row.change == "-coulomb_friction")
    assert less.evidence > 100.0
    known = [row.evidence for row in rows if row.evidence is not None]
    assert known == sorted(known)


def test_a_round_says_what_was_taken_and_why_not_the_others(ended) -> None:
    first = round_at(ended, (), COULOMB)
    assert first.chosen == COULOMB
    assert first.candidates[0].ids == COULOMB
    assert first.candidates[0].reason == TAKEN
    assert first.candidates[0].gain > 0.5
    assert all(candidate.reason for candidate in first.candidates)
    assert {candidate.ids for candidate in first.candidates} >= {COULOMB, GRAVITY, DRAG}
    assert sum(candidate.probability for candidate in first.candidates) <= 1.0 + 1e-9
    assert "Coulomb friction explains" in first.reason


def test_neighbours_without_a_refit_promise_no_more_than_the_likeliest_gave(ended) -> None:
    rows = neighbours_of(ended, ended.answer)
    assert set(ended.neighbours[COULOMB]) & set(ended.answers)
    assert all(row.evidence >= 0.0 for row in rows if row.evidence is not None)


def test_sets_more_than_one_change_away_are_no_neighbours(ended) -> None:
    added = ended.answer.added
    farther = {(*GRAVITY, *DRAG): 1.0, (*COULOMB, *GRAVITY, *DRAG): 2.0}
    own = ended.neighbours[added]
    search = replace(ended, neighbours={added: {**own, **farther}})
    told = [row.change for row in neighbours_of(search, ended.answer)]
    known = {*ended.answers, *own} - {added}
    changes = [change_between(added, other) for other in known]
    assert sorted(told) == sorted(change for change in changes if change is not None)


def test_one_clear_answer_has_no_class(ended) -> None:
    assert answers_alike(ended, ended.answer) == ()


def test_progress_is_told_in_words_and_shares(sticking) -> None:
    told: list[tuple[str, float]] = []
    searched(sticking, lambda text, share: told.append((text, share)))
    assert all(0.0 <= share <= 1.0 for _, share in told)
    words = " ".join(text for text, _ in told)
    assert "screening: Coulomb friction" in words
    assert "refitting the parameters" in words


# ---- failures ------------------------------------------------------------------------------------


@pytest.fixture
def breaking(monkeypatch):
    """Makes refits with an effect, or its library, fail."""

    def breaks(effect_id: str, error: Exception, where: str = "refit") -> None:
        whole = refitting.refit if where == "refit" else refitting.library_path

        def refit(given, added, *rest) -> Answer:
            if effect_id in added:
                raise error
            return whole(given, added, *rest)

        def library_path(effect_ids, kind):
            if effect_id in effect_ids:
                raise error
            return whole(effect_ids, kind)

        if where == "refit":
            monkeypatch.setattr(refitting, "refit", refit)
        else:
            for module in (refitting, looking):
                monkeypatch.setattr(module, "library_path", library_path)

    return breaks


@pytest.mark.parametrize(
    ("error", "where"),
    [
        (SimulationError("it runs away"), "refit"),
        (FloatingPointError("a root of less than nothing"), "refit"),
        (BuildError("the compiler is out of words"), "library"),
    ],
    ids=["simulation", "arithmetic", "compiler"],
)
def test_a_candidate_that_fails_is_a_row_with_its_reason(sticking, breaking, error, where) -> None:
    breaking("coulomb_friction", error, where)
    search = searched(sticking, options=Options(only=(*COULOMB, *DRAG)))
    assert search.failures[COULOMB] == str(error)
    assert "coulomb_friction" not in search.answer.added
    row = next(row for row in neighbours_of(search, search.answers[()]) if COULOMB[0] in row.change)
    assert not row.refitted


def test_a_failure_is_told_in_the_table_of_its_round(sticking, breaking) -> None:
    breaking("coulomb_friction", SimulationError("it runs away"))
    search = searched(sticking, options=Options(only=COULOMB))
    row = next(row for row in round_at(search, (), ()).candidates if row.ids == COULOMB)
    assert not row.fitted
    assert "it runs away" in row.reason


def test_a_model_that_cannot_be_simulated_is_refused(sticking, monkeypatch) -> None:
    def refit(*_arguments) -> Answer:
        raise SimulationError("it runs away")

    monkeypatch.setattr(refitting, "refit", refit)
    known, recording, _ = sticking
    search = Search.of(data_of(known.model, [recording.window(None, SHORT)], [], FEW), silent)
    with pytest.raises(Exception, match="it runs away"):
        search.base()


def test_an_interrupt_within_refits_leaves_what_was_found(sticking) -> None:
    def report(text: str, _share: float) -> None:
        if text.startswith("looking at"):
            raise KeyboardInterrupt

    known, recording, _ = sticking
    search = Search.of(data_of(known.model, [recording.window(None, SHORT)], [], FEW), report)
    search.base()
    with pytest.raises(KeyboardInterrupt):
        run(search)
    assert search.answer.added == COULOMB
    assert set(search.answers) >= {(), COULOMB}


# ---- what only the whole motion shows ------------------------------------------------------------


def test_what_the_torque_screen_does_not_see_is_found_by_looks_at_the_motion(heavy) -> None:
    assert not heavy.screen.sees(*MASS)
    looks = heavy._looks((), MASS)
    true = typical_model(*MASS).effects["spring_mass"]
    begin = heavy.starts[MASS][0].effects["spring_mass"]
    assert begin["mass"] == pytest.approx(true["mass"], rel=0.3)  # the rest is refitted
    assert looks[MASS] < searching.WORTH
    run(heavy)
    assert MASS not in heavy.estimates
    assert heavy.answer.added == MASS
    assert heavy.answer.values("spring_mass")["mass"] == pytest.approx(true["mass"], rel=0.3)


def test_a_refit_begins_at_the_looks_beside_what_was_refitted_without(heavy) -> None:
    starts = heavy.starts_beside(heavy.answer, "spring_mass")
    assert starts[: len(heavy.starts[MASS])] == heavy.starts[MASS]
    refitted = heavy.answer.result.model.values()
    assert refitted["link.inertia"] != BELIEVED["link.inertia"]
    assert all(start.values()["link.inertia"] != BELIEVED["link.inertia"] for start in starts)


def test_what_is_as_small_as_noise_is_looked_for_along_the_trajectory() -> None:
    weak = typical_model().with_effect("gravity_load", {"torque": 0.003, "angle": 0.5})
    search = begun(weak, *COULOMB, *GRAVITY, *DRAG)
    assert search._at_noise()
    found = search._expected((), search._neighbours(()))
    assert min(found, key=found.__getitem__) == GRAVITY
    # its error hangs together: only beside it are samples facts of their own
    base = search.answers[()]
    assert search.evidence.facts([base]) < 0.2 * len(base.floored)
    assert search._facts_beside((), {GRAVITY: 0.9}) > 0.8 * len(base.floored)


def test_a_look_that_fails_is_told_and_gives_no_start(heavy, breaking) -> None:
    breaking("spring_mass", BuildError("the compiler is out of words"), "library")
    run(heavy)
    assert heavy.failures[MASS] == "the compiler is out of words"
    assert MASS not in heavy.starts
    assert heavy.answer.added == ()


# ---- refits that build upon each other -----------------------------------------------------------

# shrinks to nothing from the nulls, whose phase is wrong


@pytest.mark.parametrize(
    "misled",
    [
        pytest.param(False, id="no estimate"),
        pytest.param(
            True,
            id="a misleading estimate",
        ),
    ],
)
def test_a_larger_set_is_met_no_worse_than_the_smaller_at_which_its_refit_begins(misled) -> None:
    truth = typical_model(*COULOMB).with_effect(*ECCENTRICITY, ECCENTRIC)
    larger = (*COULOMB, *ECCENTRICITY)
    search = begun(truth, *larger)
    start = model_with(search.data.given, ECCENTRICITY, truth.values())
    smaller = refit(search.data.given, ECCENTRICITY, search.data.fitted, [start], QUICK)
    search.answers[ECCENTRICITY] = smaller
    if misled:
        far = {"coulomb_friction.torque": 9.0, "pulley_eccentricity.phase": -1.0}
        far = {f"effects.{name}": value for name, value in far.items()}
        search.estimates[larger] = search.screen.fit(larger, far, 0)
    search._refit([larger], "refitting")
    found = search.answers[larger]
    assert found.mean_square < 1.001 * smaller.mean_square
    assert found.mean_square < 1.2 < 100.0 < smaller.mean_square
    assert found.values(*ECCENTRICITY) == pytest.approx(ECCENTRIC, rel=0.05)


def test_what_is_not_there_explains_nothing_in_a_larger_set() -> None:
    search = begun(typical_model(*COULOMB), *COULOMB, *DRAG)
    search._refit([COULOMB], "refitting")
    search._refit([(*COULOMB, *DRAG)], "refitting")
    squares = [search.answers[added].mean_square for added in (COULOMB, (*COULOMB, *DRAG))]
    assert squares[1] == pytest.approx(squares[0], rel=1e-3)


# ---- how long, and what next ---------------------------------------------------------------------


def test_dear_derivatives_leave_room_for_fewer(heavy) -> None:
    typical = typical_model(*MASS)
    light = typical.with_values(
        {"effects.spring_mass.mass": 0.001, "effects.spring_mass.damping": 0.01}
    )
    base = heavy.answers[()].result.model
    cheap, dear = heavy._cost(base), heavy._cost(light)
    assert 0.0 < 5.0 * cheap < dear
    assert replace(heavy._effort([base]), hopeless=np.inf) == refitting.EFFORT
    assert heavy._effort([base, light]).evaluations < refitting.EFFORT.evaluations


def test_fewer_effects_are_no_other_answer(monkeypatch) -> None:
    search = begun(typical_model(*COULOMB, *GRAVITY), *COULOMB, *GRAVITY)
    both = in_order((*COULOMB, *GRAVITY))
    search._refit([COULOMB, GRAVITY, both], "refitting")
    # as where so much is unknown that nothing decides
    monkeypatch.setattr(search.evidence, "of", lambda answers, _among: [0.0] * len(answers))
    assert answers_alike(search, search.answers[both]) == ()


def test_where_nothing_is_left_only_fewer_parameters_could_win(ended, monkeypatch) -> None:
    assert ended.answer.added == COULOMB
    monkeypatch.setitem(vars(ended.answer), "mean_square", 1.0)
    assert ended._could_win(())
    assert not ended._could_win((*COULOMB, *DRAG))
    assert not ended._could_win(DRAG)


def test_where_much_is_left_many_parameters_could_win() -> None:
    search = begun(typical_model(*DRAG))
    assert search._could_win((*COULOMB, *GRAVITY, *DRAG))


def test_pairs_are_looked_at_beside_the_parameters_as_given_too(monkeypatch) -> None:
    search = begun(typical_model(*COULOMB, *GRAVITY), *COULOMB, *GRAVITY, *DRAG)
    ids = search._screened()
    search._screen_singles(ids, None)
    origins = []
    monkeypatch.setattr(
        search.screen, "combined", lambda origin, *_: origins.append(origin) or ({}, {})
    )
    search._pairs([GRAVITY], ids)
    search._pairs([GRAVITY], ids, as_given=True)
    estimated, as_given = origins
    assert estimated is search.estimates[GRAVITY]
    own = [path for path in estimated.values if path.startswith("effects.")]
    assert {path: as_given.values[path] for path in own} == pytest.approx(
        {path: estimated.values[path] for path in own}
    )
    given = search.data.given.values()
    assert {path: as_given.values[path] for path in given} == pytest.approx(given)
    assert estimated.values["link.inertia"] != pytest.approx(given["link.inertia"], rel=1e-4)


def test_three_effects_are_tried_where_no_two_of_them_begin_to_explain() -> None:
    search = begun(typical_model(*THREE), *THREE, *DRAG)
    search._screen_singles(search._screened(), None)
    assert search._best_three() == []  # without pairs nothing tells which three to try
    search._best_pair(search._screened())
    assert search._best_three() == [THREE]
    assert search._badness(THREE) < 2.0 < 100.0 < min(map(search._badness, search._sets(2)))


def test_a_neighbour_that_seems_a_little_worse_in_torque_is_refitted(monkeypatch) -> None:
    search = begun(typical_model(*COULOMB), *COULOMB, *GRAVITY, *DRAG)
    search._refit([GRAVITY], "")
    assert not search._at_noise()
    facts = search.evidence.facts([search.answers[GRAVITY]])
    monkeypatch.setattr(searching, "ABOUT", 0.0)
    search.neighbours[GRAVITY] = {DRAG: 0.1 * facts, COULOMB: 0.3 * facts}
    assert list(search._promising(GRAVITY)) == [DRAG]


def test_an_exchange_begins_at_the_best_answer() -> None:
    search = begun(typical_model(*DRAG), *COULOMB, *GRAVITY, *DRAG)
    search._screen_singles(search._screened(), None)
    search._refit([(*DRAG, *GRAVITY)], "")
    (start,) = search._exchanged((*COULOMB, *DRAG))
    answer = search.answers[(*DRAG, *GRAVITY)].result.model.values()
    known = {**search.estimates[COULOMB].values, **answer}
    assert start.values() == pytest.approx({path: known[path] for path in start.values()})
    assert not list(search._exchanged(DRAG))  # that is no exchange


def test_exchanges_that_torques_bear_are_looked_at_beside_what_they_do_not_show() -> None:
    heavy = begun(typical_model(*MASS), *MASS, *DRAG, *COULOMB, *GRAVITY)
    both = in_order((*MASS, *COULOMB))
    heavy._refit([MASS, both], "")
    assert heavy._exchanges_by_torque(both) == []  # nobody asked the screen for neighbours
    heavy._screen_singles(heavy._screened(), None)
    heavy.neighbours[COULOMB] = {DRAG: 30.0, GRAVITY: 300.0, (*COULOMB, *DRAG): -5.0, (): None}
    assert heavy._exchanges_by_torque(both) == [in_order((*MASS, *DRAG))]
    (start,) = heavy.starts[in_order((*MASS, *DRAG))]
    mass = heavy.answers[both].values("spring_mass")
    assert start.effects["spring_mass"] == pytest.approx(mass)
    assert in_order((*MASS, *DRAG)) in heavy._neighbours(both)


SCREENED, RINGING = "_promised", "_better_ringing"
TWO, ADDITION = "_better_with_two", "_affordable_addition"


@pytest.mark.parametrize(
    ("blind", "promises", "rings", "order"),
    [
        (False, False, False, (SCREENED, RINGING, TWO, ADDITION)),
        (False, False, True, (RINGING, SCREENED, TWO, ADDITION)),
        # a little that the torque screen promises is worth nothing where it errs far more than the
        # trajectory
        (True, False, False, (RINGING, TWO, ADDITION, SCREENED)),
        (True, True, False, (SCREENED, RINGING, TWO, ADDITION)),
    ],
)
def test_looks_at_what_swings_come_last(blind, promises, rings, order, monkeypatch) -> None:
    search = begun(typical_model(*DRAG), *COULOMB, *DRAG)
    tried = []

    def trying(name, result):
        monkeypatch.setattr(search, name, lambda *_: tried.append(name) or result)

    monkeypatch.setattr(search, "_blind", lambda _: blind)
    monkeypatch.setattr(search, "_promises", lambda _: promises)
    monkeypatch.setattr(search, "_rings", lambda _: rings)
    for name in ("_half_gone", *order):
        trying(name, result=False)
    trying("_swinging", result={})
    search._follow_neighbours()
    assert tried == ["_half_gone", *order, "_swinging", SCREENED]


def test_a_search_that_lasts_long_builds_on_nothing_that_fades(monkeypatch) -> None:
    search = begun(typical_model(*DRAG), *COULOMB, *DRAG)
    fades = iter([True, False, False])
    monkeypatch.setattr(search, "_fades_in_time", lambda: next(fades))
    search._follow_neighbours()
    assert len(list(fades)) == 3  # it has only begun
    fades = iter([True, False, False])
    search.work = 2.0 * searching.LONG
    monkeypatch.setattr(search, "_promised", lambda *_: False)
    search._follow_neighbours()
    assert len(list(fades)) == 1


def test_refits_of_one_list_begin_at_the_same_answers_whatever_their_timing(monkeypatch) -> None:
    search = begun(typical_model(*DRAG), *COULOMB, *GRAVITY, *DRAG)
    whole, known = search._refitted, []

    def noted(added, check):
        known.append(set(search.answers))
        return whole(added, check)

    monkeypatch.setattr(search, "_refitted", noted)
    monkeypatch.setattr(refitting, "AT_ONCE", 1)  # each has ended before the next begins
    search._refit([COULOMB, GRAVITY, DRAG], "refitting")
    assert known == [{()}] * 3
    assert set(search.answers) == {(), COULOMB, GRAVITY, DRAG}


def test_laws_that_exclude_each_other_are_never_together(ended) -> None:
    assert not ended.screen.goes(("coulomb_friction", "stribeck_friction"))
    with pytest.raises(ModelError):
        ended.screen.structure(("coulomb_friction", "lugre_friction"))
