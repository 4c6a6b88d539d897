"""The experiment that decides: said, drawn, handed out as a file, and its recording taken back."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from threading import Thread

import numpy as np
import pytest

pytest.importorskip("dash")

from elastic_tendon import demo
from elastic_tendon.app import ranking, walk
from elastic_tendon.app.document import Document, Source, Version, new_document
from elastic_tendon.app.server import Served, listen
from elastic_tendon.app.session_file import SessionFile, open_session
from elastic_tendon.diagnosis.by_hand import LeftOpen, Proposed, Ranked
from elastic_tendon.diagnosis.experiment import experiment_csv
from hand_made_diagnosis import COULOMB, friction_found, next_experiment

LUGRE = "lugre_friction"
OPEN = LeftOpen(((COULOMB,), (LUGRE,)), complete=True)
FILES = {"fit": demo.DATA / "demo_fit.csv"}


def searched() -> Document:
    """The parameters refitted, and searched from."""
    found = friction_found()
    document = new_document(found.given, [Source(key="fit", name="demo_fit.csv")])
    key = document.data_key()
    refitted = Version(
        id="",
        parent="1",
        title="parameters refitted",
        model=found.steps[1].comparison.model.to_toml(),
        fitted_to=key,
        searched=key,
    )
    return document.adding(refitted)


# ---- words ---------------------------------------------------------------------------------------


def test_before_it_is_sought_the_page_says_what_cannot_be_told_apart() -> None:
    words = ranking.experiment_words(OPEN, None)
    assert words.startswith("These data cannot distinguish: Coulomb friction and LuGre friction.")


@pytest.mark.parametrize(
    ("found", "words"),
    [
        (Proposed(next_experiment(), ""), next_experiment().text),
        (Proposed(None, "No motion tells the two apart."), "No motion tells the two apart."),
    ],
)
def test_what_came_of_it_is_said_as_the_result_says_it(found: Proposed, words: str) -> None:
    assert ranking.experiment_words(OPEN, found) == words


@pytest.mark.parametrize(
    ("complete", "words"), [(True, "no other answer explains"), (False, "was stopped")]
)
def test_where_nothing_is_left_open_the_reason_is_told(complete: bool, words: str) -> None:
    assert words in ranking.experiment_words(LeftOpen((), complete=complete), None)


def test_the_first_screen_names_the_rival_and_leads_to_the_experiment() -> None:
    found = friction_found()
    seen = ranking.screen(found.rounds[0], found.ladder, found.ladder[-1], left_open=OPEN)
    assert ", or else LuGre friction, which these data do not tell apart." in seen.verdict
    assert "which experiment decides between Coulomb friction and LuGre friction" in seen.advice


# ---- where its recording is searched from --------------------------------------------------------


def test_both_rivals_are_candidates_again_before_the_choice_between_them() -> None:
    document = searched()
    chosen = document.adding(
        document.version.model_copy(update={"parent": "2", "added": (COULOMB,), "change": COULOMB})
    )
    assert walk.before_the_choice(chosen, OPEN).current == "2"
    shared = LeftOpen(((COULOMB, "gravity_load"), (COULOMB, LUGRE)), complete=True)
    assert walk.before_the_choice(chosen, shared).current == chosen.current


# ---- on disk and on the page ---------------------------------------------------------------------


@pytest.fixture
def file(tmp_path: Path) -> SessionFile:
    """A session in which the experiment was found."""
    document, found = searched(), friction_found()
    made = open_session(tmp_path / "night.session")
    made.begin(document, FILES)
    models = {effect_id: found.model.to_toml() for effect_id in (COULOMB, LUGRE)}
    first = found.rounds[0]
    singles = tuple(candidate for candidate in first.candidates if len(candidate.ids) == 1)
    by_hand = replace(first, candidates=singles)
    for result, value in (
        (walk.ranked(document, document.version, FILES), Ranked(by_hand, models)),
        (walk.left_open(document, FILES), OPEN),
        (walk.proposed(document, FILES), Proposed(next_experiment(), "")),
    ):
        made.keep(result.key, value)
    return made


def test_a_session_keeps_the_experiment(file: SessionFile) -> None:
    kept = file.find(walk.proposed(searched(), FILES).key, Proposed)
    file.close()
    assert kept is not None
    assert kept.experiment is not None
    assert experiment_csv(kept.experiment) == experiment_csv(next_experiment())
    for name, predicted in next_experiment().predictions.items():
        np.testing.assert_array_equal(kept.experiment.predictions[name], predicted)


@pytest.fixture
def app(file: SessionFile) -> Iterator[Served]:
    before = file.reopen()
    assert before is not None
    served = listen(before.document, before.files, kept=file)
    Thread(target=served.run, daemon=True).start()
    yield served
    served.close()


def test_it_is_played_and_its_recording_searched_with_the_others(
    app: Served, tmp_path: Path
) -> None:
    pytest.importorskip("playwright")
    from app_driver import CHROMIUM, Walk, browser

    if CHROMIUM is None:
        pytest.skip("chromium is not installed")
    with browser() as chromium:
        tab = Walk(chromium, app.url)
        tab.step("Which effect")
        tab.page.get_by_text("Small reversals of the motor for 4 s").wait_for()
        tab.settle()
        last = tab.page.locator("#effect-experiment-figure .y3title")
        assert "difference" in (last.text_content() or "")
        handed_out = tab.save(tab.button("Download the experiment"), tmp_path)
        assert handed_out.name == "demo_actuator_experiment.csv"
        assert handed_out.read_text() == experiment_csv(next_experiment())

        recording = (demo.DATA / "demo_validate.csv").read_bytes()
        played = {"name": "played.csv", "mimeType": "text/csv", "buffer": recording}
        tab.page.locator("#effect-recording input[type=file]").set_input_files([played])
        tab.page.get_by_text("played.csv is fitted together with the other").wait_for()
        tab.settle()
        assert tab.page.locator("#effect-experiment").is_hidden()
        kept = app.workspace.open(None).document
        assert [(one.name, one.role) for one in kept.sources] == [
            ("demo_fit.csv", "fit"),
            ("played.csv", "fit"),
        ]
        tab.button("Find which effect is missing").wait_for()
        tab.button("Go to Compare").click()
        tab.heading("Compare").wait_for()
        tab.settle()
        tab.choose("Recording", "played.csv")
        tab.close()
        assert tab.faults == []
