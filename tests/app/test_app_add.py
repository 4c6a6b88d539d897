"""What the step Add says and does to the tree of versions."""

from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.app import versions
from elastic_tendon.app.document import Document, Source, Version, new_document
from elastic_tendon.app.results import Compared
from elastic_tendon.app.steps import add
from elastic_tendon.reports.units import number
from hand_made_diagnosis import COULOMB, friction_found

MODEL = load_model("biorob_x4_joint_3")


def grown() -> Document:
    """As given, refitted, and two branches on it; another model as given beside."""
    document = new_document(MODEL, [Source(key="a", name="run.csv")])
    key, text = document.data_key(), MODEL.to_toml()
    document = document.adding(
        Version(id="", parent="1", title="refitted", model=text, fitted_to=key)
    )
    for title in ("first", "second"):
        document = document.adding(
            Version(id="", parent="2", title=title, model=text, fitted_to=key)
        )
    return document


def test_a_version_stands_below_what_it_was_made_from() -> None:
    rows = versions.tree(grown())
    assert [(row.version.id, row.depth, row.below) for row in rows] == [
        ("1", 0, 3),
        ("2", 1, 2),
        ("3", 2, 0),
        ("4", 2, 0),
    ]
    assert [row.version.id for row in rows if row.current] == ["4"]
    assert [row.deletable for row in rows] == [False, True, True, True]


def test_one_of_two_models_as_given_can_be_deleted() -> None:
    rows = versions.tree(grown().edited(MODEL.with_values({"link.inertia": 0.04})))
    assert [row.deletable for row in rows if row.depth == 0] == [True, True]


def test_undo_looks_at_what_was_before_and_keeps_the_rest() -> None:
    document = grown()
    undone = add._changed(document, "add-undo", "", "1")
    assert undone.current == "2"
    assert undone.versions == document.versions
    assert add._changed(undone, "add-look", "4", "1") == document


def test_titles_are_kept_short_and_never_empty() -> None:
    document = grown()
    named = add._changed(document, "add-title", "3", "  <b>my\n friction</b> ")
    assert named.find("3").title == "<b>my friction</b>"
    assert add._changed(document, "add-title", "3", "   ") == document
    assert len(add._changed(document, "add-title", "3", "x" * 500).find("3").title) == add.LONGEST


def test_a_version_that_is_gone_is_left_alone() -> None:
    document = grown()
    for what in ("add-look", "add-delete", "add-title"):
        assert add._changed(document, what, "17", "x") == document


def test_other_data_ask_for_another_refit() -> None:
    document = grown()
    assert versions.refit_words(document) == ""
    assert versions.refit_words(document.at("1")) == "Refit the parameters"
    changed = document.with_source("a", window=(0.0, 1.0))
    assert versions.refit_words(changed) == "Refit to the data chosen now"


def test_errors_are_told_in_the_small_unit() -> None:
    step = friction_found().steps[-1]
    found = Compared(step.comparison, step.heldout)
    assert versions.shown_signal(found) == "joint_position"
    fitted, heldout, ratio = versions.errors_of(found, "joint_position")
    assert fitted.copied == 1e3 * step.comparison.rmse()["joint_position"]
    assert heldout.shown == number(heldout.copied)
    assert 0.9 < ratio.copied < 1.1
    alone = versions.errors_of(Compared(step.comparison, None), "joint_position")
    assert alone[1] == versions.UNKNOWN


def test_what_comes_next_depends_on_what_is_left() -> None:
    document, steps = grown(), friction_found().ladder
    assert versions.what_next(document.at("1"), steps, None) is None
    fitted = versions.what_next(document.at("2"), steps[:-1], None)
    assert (fitted.search, fitted.done) == ("Search for what is missing", False)
    assert "times the noise" in fitted.words
    added = document.adding(
        document.version.model_copy(
            update={"title": "+ Coulomb friction", "change": COULOMB, "added": (COULOMB,)}
        )
    )
    done = versions.what_next(added, steps, None)
    assert done.words.startswith("Coulomb friction is in the model. What is left is about")
    assert (done.search, done.done) == ("Search again for what else is missing", True)
    searched = added.with_search(added.current, added.data_key())
    found = versions.what_next(searched, steps, friction_found().rounds[-1])
    assert (found.search, found.done) == ("", True)
    assert "go to Take away" in found.words


def test_a_model_as_given_is_told_by_its_name() -> None:
    assert [row.model for row in versions.tree(grown())] == [MODEL.name, "", "", ""]


def test_a_step_is_told_with_what_speaks_against_it() -> None:
    before, after = friction_found().ladder[-2:]
    assert after.added == COULOMB
    assert versions.step_sentences([before]) == []
    assert "error falls from" in versions.step_sentences([before, after])[0]
    told = versions.step_sentences([after, before.__class__(**{**vars(before), "added": COULOMB})])
    assert "error goes from" in told[0]
    assert any("do not ask for Coulomb friction" in sentence for sentence in told)
    assert any("do not trust it" in sentence for sentence in told)
