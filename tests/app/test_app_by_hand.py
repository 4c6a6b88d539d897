"""The walk by hand in the app, on a part of the demo's recordings."""

import json

import pytest

from elastic_tendon import demo
from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.app import ranking, results, walk
from elastic_tendon.app.document import Source, new_document
from elastic_tendon.app.steps.take_away import build, offered
from elastic_tendon.app.takeaway import Depot, FmuChoice
from elastic_tendon.app.workspace import Session, Stopped, Workspace
from elastic_tendon.diagnosis import by_hand
from elastic_tendon.diagnosis.answer import Answer
from elastic_tendon.diagnosis.result import Diagnosis
from elastic_tendon.progress import Enough

COULOMB = "coulomb_friction"
FILES = {role: demo.DATA / f"demo_{role}.csv" for role in ("fit", "validate")}
SOURCES = (
    Source(key="fit", name="fit.csv", window=(0.0, 4.0)),
    Source(key="validate", name="validate.csv", role="validate", window=(0.0, 4.0)),
)


def silent(_words: str, _share: float) -> None:
    pass


def begun() -> Session:
    return Session("1", new_document(load_model(demo.DATA / "demo_model.toml"), SOURCES), FILES)


@pytest.fixture(scope="module")
def walked() -> Session:
    """The search, its suggestion tried and added, and the search looking on."""
    session = begun()
    for make in (
        walk.searching,
        lambda session: walk.trying(session, COULOMB),
        lambda session: walk.adding(session, COULOMB),
        walk.searching,
    ):
        if (change := make(session)(silent)) is not None:
            session.change(change)
    return session


def test_each_step_is_a_version(walked: Session) -> None:
    path = walked.document.path()
    assert [version.title for version in path] == [
        "as given",
        "parameters refitted",
        "+ Coulomb friction",
    ]
    assert [version.change for version in path] == [None, None, COULOMB]
    assert path[-1].added == (COULOMB,)
    assert all(walk.was_searched(walked.document, version) for version in path[1:])


def test_the_search_finds_the_hidden_effect_and_then_no_more(walked: Session) -> None:
    document = walked.document
    first = walked.cache.find(walk.outcome(document, document.path()[1], FILES))
    assert first.round.chosen == (COULOMB,)
    found = walk.round_of(walked)
    assert found is not None
    assert found.chosen == ()


def test_a_try_shows_the_gain_and_adds_nothing(walked: Session) -> None:
    document = walked.document
    tried = walked.cache.find(walk.tried(document, document.path()[1], COULOMB, FILES))
    assert tried.after.rmse["joint_position"] < 0.1 * tried.before.rmse["joint_position"]
    assert len(document.versions) == 3


def test_uncertainties_stay_those_given(walked: Session) -> None:
    given = walked.document.path()[0].loaded().uncertainty
    found = walked.document.version.loaded().uncertainty
    assert {path: found[path] for path in given} == given


def test_the_way_amounts_to_a_diagnosis(walked: Session) -> None:
    result = walk.concluded(walked.document, FILES)
    found = walked.cache.obtain(result, silent)
    assert isinstance(found, Diagnosis)
    assert (found.verdict, found.added, found.complete) == ("missing_effect", (COULOMB,), True)


def test_what_the_server_lost_is_found_again(walked: Session) -> None:
    kept = walked.document
    session = Session("2", kept, FILES)
    answer = session.cache.obtain(walk.answer(kept, kept.version, FILES), silent)
    assert isinstance(answer, Answer)
    torque = kept.version.loaded().effects[COULOMB]["torque"]
    assert answer.values(COULOMB)["torque"] == pytest.approx(torque, rel=1e-3)


def test_an_effect_added_at_once_comes_after_a_refit() -> None:
    session = begun()
    change = walk.adding(session, "gravity_load")(silent)
    session.change(change)
    titles = [version.title for version in session.document.path()]
    assert titles == ["as given", "parameters refitted", "+ Gravity load"]


def test_what_was_deleted_meanwhile_gets_no_child(walked: Session) -> None:
    change = walk.refitting(walked)(silent)
    assert change is not None
    without = walked.document.without(walked.document.current)
    assert change(without) == without
    assert len(change(walked.document).versions) == 4


def test_other_data_make_another_fit(walked: Session) -> None:
    document = walked.document.with_source("fit", window=(0.0, 3.0))
    assert not walk.is_fitted(document, document.version)
    session = Session("3", document, FILES)
    session.change(walk.refitting(session)(silent))
    assert session.document.version.title == walk.REFITTED_AGAIN
    assert session.document.version.added == (COULOMB,)
    assert walk.is_fitted(session.document, session.document.version)


def test_a_bad_file_changes_nothing_of_what_was_found(walked: Session) -> None:
    bad = Source(key="gone", name="gone.csv")
    document = walked.document.with_sources([*SOURCES, bad])
    session = Session("4", document, FILES)
    session.change(walk.refitting(session)(silent))
    _, refitted, *_, again = session.document.versions
    assert "gone.csv is left out" in session.document.sources[-1].left_out
    assert again.fitted_to == refitted.fitted_to == walked.document.data_key()
    assert all(walk.was_searched(session.document, one) for one in document.path()[1:])


def test_a_bad_file_added_last_leaves_the_findings_those_of_the_diagnosis(walked: Session) -> None:
    bad = Source(key="gone", name="gone.csv")
    session = Session("5", walked.document.with_sources([*SOURCES, bad]), FILES)
    session.cache = walked.cache
    workspace = Workspace(session.document, FILES)
    choice, depot = FmuChoice(2, (), source=False), Depot(workspace)
    build(session, "findings", choice, depot, silent)
    findings = offered(session.document, FILES, choice, depot)["findings"]
    content = json.loads(session.cache.obtain(findings, silent).path.read_text())
    workspace.close()
    assert content["schema"].startswith("elastic-tendon/diagnosis/")
    assert "gone.csv is left out" in session.document.sources[-1].left_out


def test_the_refit_of_a_search_that_is_stopped_stays() -> None:
    session = begun()

    def stopping(words: str, _share: float) -> None:
        if words.startswith("screening"):
            raise Stopped

    with pytest.raises(Stopped):
        walk.searching(session)(stopping)
    titles = [version.title for version in session.document.path()]
    assert titles == ["as given", "parameters refitted"]
    assert not walk.was_searched(session.document, session.document.version)


def test_a_refit_of_which_somebody_has_enough_ends_the_search() -> None:
    session, told, ended = begun(), [], []

    def impatient(words: str, share: float) -> None:
        told.append(words)
        if words == by_hand.REFITTING and share > 0.0 and not ended:
            ended.append(True)
            raise Enough

    assert walk.searching(session)(impatient) is None
    assert session.document.version.title == "parameters refitted"
    assert not any(words.startswith("screening") for words in told)


def test_a_search_that_is_ended_early_says_so_and_can_be_made_to_the_end() -> None:
    session = begun()
    session.change(walk.refitting(session)(silent))

    def impatient(words: str, _share: float) -> None:
        if words.startswith("looking at what could do better"):
            raise Enough

    change = walk.searching(session)(impatient)
    assert change is not None
    session.change(change)
    found = walk.round_of(session)
    assert walk.ended_early(session)
    assert found is not None
    assert not any(candidate.fitted for candidate in found.candidates)
    name, words = ranking.search_words(session.document, ended_early=True)
    assert name == ranking.SEARCH_ON
    assert "ended early" in words
    document = session.document
    concluded = session.cache.obtain(walk.concluded(document, FILES), silent)
    assert not concluded.complete

    change = walk.searching(session)(silent)
    assert change is not None
    session.change(change)
    found = walk.round_of(session)
    assert not walk.ended_early(session)
    assert found is not None
    assert found.chosen == (COULOMB,)


def test_rounds_are_told_as_far_as_they_are_known() -> None:
    session, told, ladders = begun(), [], []

    def tell(so_far: walk.Interim) -> None:
        told.append(so_far)
        document = session.document
        ladders.append(session.cache.find(results.climbed(document, FILES)))
        assert so_far.version == document.current

    session.tell = tell  # type: ignore[method-assign, assignment]
    change = walk.searching(session)(silent)
    assert change is not None
    first, last = told[0], told[-1]
    assert any(candidate.ids == (COULOMB,) for candidate in first.round.candidates)
    before, refitted = ladders[0]  # the ladder has grown before the search has ended
    assert (before.title, refitted.title) == ("as given", "parameters refitted")
    assert last.round.chosen == (COULOMB,)
    session.change(change)
    document = session.document
    with_it = session.cache.obtain(walk.suggested(document, document.version, FILES), silent)
    assert last.best.rmse == with_it.rmse
