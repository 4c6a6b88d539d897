"""The table of a model's parameters: what is edited is checked as the file of a model is."""

from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.app.document import EDITED, GIVEN, Document, new_document
from elastic_tendon.app.numbers import edited, parsed, sections, shown, with_minus

MODEL = load_model("biorob_x4_joint_3")
PRETENSION = "transmission.pretension_force"


def texts(model=MODEL) -> dict[str, str]:
    return {number.path: number.text for each in sections(model, model) for number in each.numbers}


def test_every_run_time_number_stands_in_the_section_of_its_part() -> None:
    model = MODEL.with_effect("coulomb_friction", {"torque": 0.2})
    listed = sections(model, model)
    titles = [section.title for section in listed]
    assert titles == ["Transmission", "Upper spring", "Lower spring", "Link", "Coulomb friction"]
    assert {number.path for each in listed for number in each.numbers} == model.values().keys()
    inertia = listed[3].numbers[0]
    assert (inertia.words, inertia.unit, inertia.bounds) == ("inertia", "kg·m²", "1e−9 to 10000")


def test_what_is_edited_is_marked_against_what_was_loaded() -> None:
    model, refused = edited(MODEL, texts() | {PRETENSION: "60"})
    assert refused == {}
    changed = [
        number for each in sections(model, MODEL) for number in each.numbers if number.changed
    ]
    assert [(number.path, number.text, number.was) for number in changed] == [
        (PRETENSION, "60", "80")
    ]


def test_what_is_not_allowed_is_told_and_the_last_good_number_kept() -> None:
    asked = {PRETENSION: "-1", "link.inertia": "heavy", "link.damping": "0.5"}
    model, refused = edited(MODEL, texts() | asked)
    assert model == MODEL.with_values({"link.damping": 0.5})
    assert refused == {
        PRETENSION: "−1 is outside 0 to 1e6 N; 80 is kept.",
        "link.inertia": "“heavy” is not a number; the last one is kept.",
    }


def test_a_number_refused_for_another_is_taken_once_that_one_allows_it() -> None:
    widest = "transmission.{}_spring.max_deflection"
    asked = texts() | {PRETENSION: "400"}
    model, refused = edited(MODEL, asked)
    assert model == MODEL
    assert "paper (27)" in refused[PRETENSION]
    model, refused = edited(
        model, asked | {widest.format(side): "0.03" for side in ("upper", "lower")}
    )
    assert refused == {}
    assert model.transmission.pretension_force == 400.0


def test_untouched_numbers_keep_all_their_digits() -> None:
    model = MODEL.with_values({"link.inertia": 0.0312345678901})
    after, refused = edited(model, texts(model) | {PRETENSION: "70"})
    assert after.link.inertia == 0.0312345678901
    assert refused == {}


def hand(document: Document, pretension: float) -> Document:
    return document.edited(document.version.loaded().with_values({PRETENSION: pretension}))


def test_edits_are_made_in_place_and_can_be_taken_back() -> None:
    start = new_document(MODEL)
    once = hand(hand(start, 60.0), 50.0)
    assert len(once.versions) == 1
    assert once.version.title == EDITED
    assert once.version.as_loaded() == MODEL
    assert once.edited(MODEL) == start
    assert start.version.title == GIVEN


def test_an_edited_model_is_not_lost_to_another_one() -> None:
    document = hand(new_document(MODEL), 60.0).with_model(load_model("figure_7"))
    assert [version.title for version in document.versions] == [EDITED, GIVEN]
    assert document.version.loaded().name == "figure_7"


def test_what_was_built_on_a_model_stays_when_that_is_edited() -> None:
    start = new_document(MODEL)
    refitted = start.version.model_copy(update={"parent": "1", "title": "parameters refitted"})
    document = hand(start.adding(refitted).at("1"), 60.0)
    assert [version.title for version in document.versions] == [
        GIVEN,
        "parameters refitted",
        EDITED,
    ]
    assert document.version.parent is None
    assert document.find("1").loaded() == MODEL


def test_numbers_are_written_one_way_and_read_again() -> None:
    assert shown(-1.5e-7) == "−1.5e−7"
    assert parsed(shown(-1.5e-7)) == -1.5e-7
    assert with_minus("-5.0 of 1e+06, run-2.csv, 2-3") == "−5.0 of 1e6, run-2.csv, 2-3"
