"""The evidence of a ladder's steps: what they bring counts, and the rest is in the same scale."""

from dataclasses import replace

import pytest

from elastic_tendon.estimation.ladder import climb
from hand_made_diagnosis import friction_found

STEPS = friction_found().steps


def test_the_likeliest_step_has_the_least_evidence() -> None:
    steps = climb(STEPS)
    evidence = [step.evidence for step in steps]
    assert evidence == sorted(evidence, reverse=True)
    probabilities = [step.probability for step in steps]
    assert sum(probabilities) == pytest.approx(1.0)
    assert probabilities[-1] == pytest.approx(1.0)


def test_steps_may_bring_their_evidence() -> None:
    brought = [3.0, 1.0, 1.0]
    fitted = [replace(step, evidence=value) for step, value in zip(STEPS, brought, strict=True)]
    steps = climb(fitted)
    assert [step.evidence for step in steps] == brought
    assert steps[1].probability == pytest.approx(steps[2].probability)
    assert steps[0].probability == pytest.approx(steps[1].probability / 2.718281828)


def test_a_step_that_brings_none_keeps_its_distance_to_the_nearest_that_does() -> None:
    own = [step.evidence for step in climb(STEPS)]
    fitted = (STEPS[0], replace(STEPS[1], evidence=7.0), replace(STEPS[2], evidence=-9.0))
    first, *others = climb(fitted)
    assert [step.evidence for step in others] == [7.0, -9.0]
    assert first.evidence - 7.0 == pytest.approx(own[0] - own[1])
