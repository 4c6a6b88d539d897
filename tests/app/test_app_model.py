"""The step Model: what it says of a model, and why an upload is none."""

from base64 import b64encode

import pytest

pytest.importorskip("dash")

from dash import html

from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.app.document import new_document
from elastic_tendon.app.steps import model as step
from elastic_tendon.errors import ElasticTendonError, ModelError

MODEL = load_model("figure_7")


def sent(text: str) -> list[str]:
    return [f"data:;base64,{b64encode(text.encode()).decode()}"]


def test_an_upload_is_a_model_whatever_it_is_called() -> None:
    assert step._chosen(sent(MODEL.to_toml()), ["../../<b>.toml"], None) == MODEL


def test_all_that_is_wrong_with_an_upload_is_told_at_once() -> None:
    text = MODEL.to_toml().replace("inertia = 0.03", 'inertia = "x"') + "\n[spring]\n"
    with pytest.raises(ModelError) as caught:
        step._chosen(sent(text), ["mine.toml"], None)
    head, listed = step.refusal(caught.value.problems, caught.value.source)
    assert head == "mine.toml: 2 things keep it from being used:"
    assert isinstance(listed, html.Ul)
    assert sorted(problem.children.partition(":")[0] for problem in listed.children) == [
        "link.inertia",
        "spring",
    ]


def test_one_problem_is_one_sentence_and_two_files_are_one_too_many() -> None:
    assert step.refusal(["this is not valid TOML"], "a") == "a: this is not valid TOML"
    with pytest.raises(ElasticTendonError, match="choose one model"):
        step._chosen(sent("") * 2, ["a", "b"], None)


def test_only_bundled_models_are_taken_by_name() -> None:
    assert step._chosen(None, None, "figure_7") == MODEL
    assert step._chosen(None, None, "../../elsewhere") is None


def test_warnings_and_what_the_springs_come_to_are_shown() -> None:
    taut = MODEL.with_values({"transmission.pretension_force": 60.0})
    shown = str(step.design_numbers(taut.with_effect("coulomb_friction", None)))
    assert "above the recommended 48.9 N" in shown
    assert "of the springs alone" in shown
    assert "'99.84'" in shown
    assert "'N·m/rad'" in shown
    plain = str(step.design_numbers(MODEL))
    assert "recommended 48.9 N" not in plain
    assert "of the springs alone" not in plain


def test_fields_stay_while_numbers_of_one_model_are_edited() -> None:
    start = new_document(MODEL).version
    heavier = new_document(MODEL).edited(MODEL.with_values({"link.inertia": 0.04})).version
    assert step.machine(start) == step.machine(heavier)
    assert start.mark != heavier.mark
    assert "was 0.03 kg·m²" in str(step.notes(heavier, {})["link.inertia"])
    assert step.machine(start) != step.machine(new_document(load_model("bench_actuator")).version)
