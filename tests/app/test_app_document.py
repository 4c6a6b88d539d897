"""The document of the app: a tree of versions that only grows unless the user says otherwise."""

import json

import pytest
from pydantic import ValidationError

from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.app.document import Document, Source, Version, from_browser, new_document
from elastic_tendon.errors import MeasurementError

MODEL = load_model("biorob_x4_joint_3")
HEAVIER = MODEL.with_values({"link.inertia": 0.04})


def grown() -> Document:
    """As given, refitted, and two branches on it."""
    document = new_document(MODEL, [Source(key="a", name="run.csv")])
    text = MODEL.to_toml()
    document = document.adding(Version(id="", parent="1", title="parameters refitted", model=text))
    for effect in ("coulomb_friction", "gravity_load"):
        document = document.at("2").adding(
            Version(id="", parent="2", title=f"+ {effect}", change=effect, model=text)
        )
    return document


def test_versions_form_a_tree() -> None:
    document = grown()
    assert [version.id for version in document.path()] == ["1", "2", "4"]
    assert [version.id for version in document.children("2")] == ["3", "4"]
    assert [version.id for version in document.at("3").path()] == ["1", "2", "3"]


def test_a_model_that_nothing_was_built_on_is_replaced_in_place() -> None:
    document = new_document(MODEL).with_model(HEAVIER)
    assert len(document.versions) == 1
    assert document.version.loaded().link.inertia == 0.04


def test_another_model_does_not_cost_what_was_reached() -> None:
    document = grown().with_model(HEAVIER, "edited by hand")
    assert len(document.versions) == 5
    assert document.version.parent is None
    assert document.version.title == "edited by hand"
    assert document.find("4").model == MODEL.to_toml()


def test_deleting_takes_what_was_made_from_it_and_looks_at_its_parent() -> None:
    document = grown().without("2")
    assert [version.id for version in document.versions] == ["1"]
    assert document.current == "1"
    assert document.without("1") == document  # one root always stays


def test_a_name_is_kept() -> None:
    assert grown().renamed("3", "with friction").find("3").title == "with friction"


def test_the_browser_brings_back_what_it_was_given() -> None:
    read = {"mapping": ("time=t",), "time_shift": {"joint_position": "auto"}, "resample": 0.01}
    document = grown().with_source("a", window=(1.0, None), role="split", split=3.0, **read)
    assert from_browser({"document": document.model_dump_json()}) == document


@pytest.mark.parametrize("change", [{"role": "judge"}, {"resample": -1.0}, {"path": "/etc"}])
def test_a_source_takes_nothing_unknown(change: dict[str, object]) -> None:
    document = grown()
    with pytest.raises((ValidationError, MeasurementError)):
        document.with_source("a", **change)


@pytest.mark.parametrize("change", [{"current": "9"}, {"versions": []}])
def test_a_document_holds_the_version_that_is_looked_at(change: dict[str, object]) -> None:
    damaged = json.loads(grown().model_dump_json()) | change
    with pytest.raises(ValidationError, match="there is no version"):
        from_browser({"document": json.dumps(damaged)})


def test_a_version_is_made_from_an_older_one() -> None:
    damaged = json.loads(grown().model_dump_json())
    damaged["versions"].reverse()
    with pytest.raises(ValidationError, match="is older than what it was made from"):
        from_browser({"document": json.dumps(damaged)})


def test_other_data_have_another_key_and_data_left_out_have_none() -> None:
    document = grown()
    assert document.with_source("a", window=(1.0, None)).data_key() != document.data_key()
    off = document.with_source("a", role="off")
    assert off.data_key() == off.with_source("a", window=(1.0, None)).data_key()
