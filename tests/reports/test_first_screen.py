"""The answer in ten seconds: what is wrong and how surely, how far the error falls, what now."""

from dataclasses import replace

import pytest

from elastic_tendon.diagnosis.result import Diagnosis
from elastic_tendon.reports.first_screen import of_diagnosis
from hand_made_diagnosis import friction_found, nothing_missing, something_unknown


def undecided_no_more(**changed: object) -> Diagnosis:
    return friction_found(next_experiment=None, indistinguishable=(), **changed)


def test_it_begins_with_the_verdict_and_ends_with_what_to_do() -> None:
    found = friction_found()
    seen = of_diagnosis(found)
    assert seen.sentences[0] == found.sentence
    assert seen.sentences[-1].startswith("Next: ")


def test_errors_come_in_units_and_in_noise_also_on_unseen_data() -> None:
    found = friction_found()
    (error,) = of_diagnosis(found).errors
    given, last = found.ladder[0], found.ladder[-1]
    unseen = [1e3 * step.heldout_rmse["joint_position"] for step in (given, last)]
    noise = [step.heldout_noise_ratio["joint_position"] for step in (given, last)]
    assert error == (
        "The joint position error falls from 37.5 to 0.229 mrad, from 162 to 0.990 times the noise"
        f"; on data that no fit has seen from {unseen[0]:.3g} to {unseen[1]:.3g} mrad, "
        f"from {noise[0]:.0f} to {noise[1]:#.3g} times the noise."
    )


def test_noise_on_unseen_data_is_that_of_these_data() -> None:
    found = friction_found()
    heldout = found.steps[-1].heldout
    assert heldout is not None
    assert found.ladder[-1].heldout_noise_ratio == heldout.noise_ratio()


def test_an_adequate_model_has_one_error() -> None:
    (error,) = of_diagnosis(nothing_missing()).errors
    assert error.startswith(
        "The joint position error is 0.229 mrad, 0.990 times the noise; on data"
    )
    assert "from" not in error


def test_an_error_that_grows_is_not_said_to_fall() -> None:
    found = friction_found()
    (error,) = of_diagnosis(replace(found, ladder=found.ladder[::-1])).errors
    assert error.startswith("The joint position error goes from 0.229 to 37.5 mrad")


@pytest.mark.parametrize(
    ("found", "advice"),
    [
        (friction_found(), "run the proposed experiment of 4 s. With a chance of 91 %"),
        (something_unknown(), "look at the function that was learned"),
        (replace(something_unknown(), learned=None), "look where the error lies, and record"),
        (undecided_no_more(), "make sure of Coulomb friction on the machine. Hold the motor"),
        (undecided_no_more(verdict="wrong_parameter", added=()), "take the refitted model"),
        (nothing_missing(), "take the model as it is; nothing needs to be mended."),
        (friction_found(complete=False), "let the search come to its end"),
    ],
    ids=["experiment", "learned", "unexplained", "effect", "parameters", "adequate", "stopped"],
)
def test_what_to_do_follows_from_what_was_found(found: Diagnosis, advice: str) -> None:
    said = of_diagnosis(found).advice
    assert said.startswith(advice)
    assert said.endswith(".")
