"""Score tests against recordings of the independent simulator."""

import pytest

from elastic_tendon.diagnosis.answer import Answer, refit
from elastic_tendon.diagnosis.candidates import candidates
from elastic_tendon.diagnosis.screen import screen
from recorded_machines import FRICTION


def silent(_text: str, _share: float) -> None:
    """Nobody asked."""


@pytest.fixture(scope="module")
def stuck(sticking) -> Answer:
    known, recording, _ = sticking
    return refit(known.model, (), [recording])


@pytest.fixture(scope="module")
def scores(stuck):
    model = stuck.result.model
    known = candidates(model, stuck.result.problem.measurements)
    return screen(stuck.result, model, known, silent)


def test_friction_is_among_the_first(scores) -> None:
    assert "coulomb_friction" in [one.effect_id for one in scores[:4]]


def test_expected_friction_is_near_the_true_one(scores) -> None:
    found = next(one for one in scores if one.effect_id == "coulomb_friction")
    assert found.expected["torque"] == pytest.approx(FRICTION, rel=0.4)
    assert found.score > 100.0


def test_gains_are_shares(scores) -> None:
    assert all(-1e-6 <= one.gain <= 1.0 for one in scores)
    gains = [one.gain for one in scores]
    assert gains == sorted(gains, reverse=True)


def test_scores_follow_gains(scores) -> None:
    values = [one.score for one in scores]
    assert values == sorted(values, reverse=True)


def test_nothing_scores_where_nothing_is_missing(frictionless) -> None:
    known, recording = frictionless
    answer = refit(known.model, (), [recording])
    model = answer.result.model
    found = screen(answer.result, model, candidates(model, [recording]), silent)
    assert max(one.score for one in found) < 25.0
