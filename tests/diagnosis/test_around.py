"""Answers refitted from places around them, at other frequencies, and on from where they ended."""

from dataclasses import replace
from itertools import islice

import numpy as np
import pytest

from begun_search import (
    COULOMB,
    DRAG,
    ECCENTRIC,
    ECCENTRICITY,
    GRAVITY,
    MASS,
    begun,
    run,
)
from elastic_tendon.diagnosis import around
from elastic_tendon.diagnosis import refits as refitting
from elastic_tendon.diagnosis import search as searching
from elastic_tendon.diagnosis.answer import Answer, refit
from elastic_tendon.diagnosis.search import Search
from elastic_tendon.errors import SimulationError
from elastic_tendon.estimation.fit import QUICK
from smooth_motion import GIVEN, typical_model


def ignore(_share: float) -> None:
    """Nobody wants to stop."""


@pytest.fixture(scope="module")
def stuck() -> tuple[Search, Answer]:
    """A search whose answer is a poor minimum, and that answer."""
    search = begun(GIVEN.with_effect(*ECCENTRICITY, ECCENTRIC), *ECCENTRICITY)
    poor = refit(search.data.given, ECCENTRICITY, search.data.fitted, effort=QUICK)
    assert poor.values(*ECCENTRICITY)["amplitude"] < 1e-4
    search.answers = {ECCENTRICITY: poor}
    assert search._hop()
    return search, poor


def test_hops_lead_out_of_a_poor_minimum(stuck) -> None:
    search, poor = stuck
    assert search.answers == {ECCENTRICITY: search.answer}
    assert search.answer.mean_square < 0.1 * poor.mean_square
    amplitude = search.answer.values(*ECCENTRICITY)["amplitude"]
    assert amplitude == pytest.approx(ECCENTRIC["amplitude"], rel=0.2)
    assert not search._hop()  # once is enough


def test_hops_lead_an_angle_beyond_half_a_turn(stuck) -> None:
    assert stuck[0].answer.values(*ECCENTRICITY) == pytest.approx(ECCENTRIC, rel=0.05)


def counted(search: Search, monkeypatch) -> list[Answer | None]:
    """What hops find, from now on; None where one fails."""
    hops: list[Answer | None] = []
    hop = search._from

    def counting(*arguments) -> Answer:
        number = len(hops)
        hops.append(None)
        hops[number] = hop(*arguments)
        return hops[number]

    monkeypatch.setattr(search, "_from", counting)
    return hops


def test_hops_leave_a_good_answer_as_it_is(monkeypatch) -> None:
    """Without the drag that is there much is left, and nothing better is near."""
    search = begun(typical_model(*DRAG))
    good = search.answer
    assert good.mean_square > refitting.AT_NOISE
    hops = counted(search, monkeypatch)
    assert not search._hop()
    assert len(hops) == around.FRUITLESS
    assert all(hop.mean_square > around.WORTH_HOPPING * good.mean_square for hop in hops)
    assert search.answers == {(): good}
    assert search.answer is good
    search._hop()
    assert len(hops) == around.FRUITLESS  # once is enough


def test_a_refit_that_ended_early_goes_on_where_little_is_left(monkeypatch) -> None:
    search = begun(typical_model(*COULOMB), *COULOMB)
    early = replace(refitting.EFFORT, evaluations=2, scouting=1)
    monkeypatch.setattr(refitting, "EFFORT", early)
    monkeypatch.setattr(search, "_from_other_minima", lambda answer, *_: answer)
    search._refit([COULOMB], "")
    before = search.answer
    monkeypatch.setattr(around, "MUCH", 0.99 * before.mean_square)
    search._refit_on()
    assert search.answer is before  # more than a refit that goes on explains
    monkeypatch.setattr(around, "MUCH", 1.01 * before.mean_square)
    search._refit_on()
    assert search.answer.mean_square < 0.9 * before.mean_square
    again = search.answer
    search._refit_on()
    assert search.answer is again


@pytest.mark.parametrize("near", [1e9, 1.0])
def test_where_a_refit_was_too_dear_other_frequencies_are_looked_at_later(
    heavy, monkeypatch, near
) -> None:
    true = typical_model(*MASS)
    path = "effects.spring_mass.mass"
    wrong = true.with_values({path: 1.2 * true.values()[path]})
    glance = replace(refitting.EFFORT, scouting=1, evaluations=1)
    heavy.answers = {MASS: refit(GIVEN, MASS, heavy.data.fitted, [wrong], glance)}
    before = heavy.answer
    monkeypatch.setattr(around, "NEAR", near)
    monkeypatch.setattr(heavy, "_dear", lambda _answer: True)
    heavy._tune()
    assert heavy.answer.mean_square < 1.1 < 2.0 < before.mean_square
    found = heavy.answer
    heavy._tune()
    assert heavy.answer is found  # nothing but noise is left


def test_nothing_hops_where_only_noise_is_left(ended, monkeypatch) -> None:
    monkeypatch.setattr(ended, "_hopped", {})
    hops = counted(ended, monkeypatch)
    answer = ended.answer
    assert not ended._hop()
    assert hops == []
    assert ended.answer is answer


def test_a_hop_that_fails_is_one_in_vain(monkeypatch) -> None:
    def broken(*_arguments) -> Answer:
        raise SimulationError("it runs away")

    search = begun(typical_model(*DRAG))
    good = search.answer
    monkeypatch.setattr(around, "refit", broken)
    hops = counted(search, monkeypatch)
    assert not search._hop()
    assert hops == [None] * around.FRUITLESS
    assert search.answer is good


def test_hops_begin_around_the_answer_and_not_at_the_nulls() -> None:
    search = begun(GIVEN.with_effect(*GRAVITY, {"torque": 1.0, "angle": 3.0}), *GRAVITY)
    poor = refit(search.data.given, GRAVITY, search.data.fitted, effort=QUICK)
    assert poor.values(*GRAVITY)["torque"] < 1e-4
    starts = list(islice(search._around(poor, np.random.default_rng(0)), 4))
    found = [search._from(GRAVITY, start, around.HOPPING, ignore) for start in starts]
    assert len({answer.mean_square for answer in found}) == len(starts) == 4


def test_hops_sweep_what_an_answer_leaves_to_the_prior_then_stay_near() -> None:
    search = begun(typical_model(*GRAVITY))
    answer = search.answers[()]
    problem, vector = answer.result.problem, answer.result.vector
    slopes = problem.jacobian(vector, answer.result.sigmas)
    left_open = int(np.sum(np.linalg.svd(slopes, compute_uv=False) < around.OPEN))
    swept = len(around.STEPS) * left_open
    starts = islice(search._around(answer, np.random.default_rng(0)), swept + 20)
    coordinates, count = problem.coordinates, len(problem.coordinates.paths)
    values = [np.array([model.values()[path] for path in coordinates.paths]) for model in starts]
    moves = [coordinates.variables(own) - vector[:count] for own in values]
    assert left_open > 0
    assert max(np.linalg.norm(move) for move in moves[:swept]) <= max(around.STEPS) + 1e-9
    assert max(np.linalg.norm(move) for move in moves[swept:]) < 5.0 * around.FARTHEST * count**0.5


def test_an_interrupt_while_it_hops_stops_the_search() -> None:
    def interrupted(words: str, _share: float) -> None:
        assert words == "refitting from places around"
        raise KeyboardInterrupt

    search = begun(typical_model(*DRAG))
    search.progress = interrupted
    with pytest.raises(KeyboardInterrupt):
        search._hop()


def test_whoever_has_simulated_enough_comes_to_an_end(monkeypatch) -> None:
    search = begun(typical_model(*DRAG), *COULOMB, *GRAVITY, *DRAG)
    assert 0.0 < search.work < refitting.CLIMBING < refitting.MOST_WORK
    search.limit = 0.0
    monkeypatch.setattr(searching, "MOST_WORK", 0.0)
    hops = counted(search, monkeypatch)
    run(search)
    assert hops == []
    assert search.answer.added == DRAG  # the likeliest is refitted whatever it takes
    assert len(search.answers) == 2
