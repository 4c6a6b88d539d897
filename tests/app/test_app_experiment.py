"""The experiment that decides: said, drawn, handed out as a file, and its recording taken back."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

pytest.importorskip("dash")

from diagnosis.test_experiment_driven import case_of, proposed
from diagnosis.test_interfaces_diagnosed import GIVEN
from elastic_tendon import demo
from elastic_tendon.app import ranking, results, walk
from elastic_tendon.app.document import Source, new_document
from elastic_tendon.app.server import Served
from elastic_tendon.app.session_file import SessionFile
from elastic_tendon.diagnosis.by_hand import LeftOpen, Proposed, Ranked
from elastic_tendon.diagnosis.experiment import experiment_csv
from elastic_tendon.diagnosis.result import Experiment, Round
from elastic_tendon.measurement import Measurement
from hand_made_diagnosis import COULOMB, friction_found, next_experiment
from searched_session import (
    FILES,
    LUGRE,
    OPEN,
    searched,
    searched_session,
    served_session,
    session_with,
)

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
    assert (
        "; it or LuGre friction is surely there, and these data do not tell which." in seen.verdict
    )
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
    return searched_session(tmp_path / "night.session")


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
    with served_session(file) as served:
        yield served


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    pytest.importorskip("playwright")
    pytest.importorskip("axe_playwright_python")
    from app_driver import CHROMIUM, browser

    if CHROMIUM is None:
        pytest.skip("chromium is not installed")
    with browser() as chromium:
        yield chromium


def take_part(chromium: Any, app: Served, folder: Path, text: str, recording: bytes) -> Path:
    """As a user does: read what is proposed, take its file away and its recording back; the file.

    Parameters
    ----------
    text : of the experiment, a part of it
    recording : CSV of what came of it
    """
    from accessibility import LEVEL_AA, violations
    from app_driver import Walk

    tab = Walk(chromium, app.url)
    tab.step("Which effect")
    tab.page.locator("#effect-experiment-words").filter(has_text=text).wait_for()
    tab.settle()
    words = tab.page.locator("#effect-experiment-figure .infolayer text").all_text_contents()
    assert any("difference" in text for text in words)
    handed_out = tab.save(tab.button("Download the experiment"), folder)
    assert violations(tab.page, LEVEL_AA) == []

    played = {"name": "played.csv", "mimeType": "text/csv", "buffer": recording}
    tab.page.locator("#effect-recording input[type=file]").set_input_files([played])
    tab.page.get_by_text("played.csv is fitted together with the other").wait_for()
    tab.settle()
    assert tab.page.locator("#effect-experiment").is_hidden()
    sources = app.workspace.open(None).document.sources
    assert [(one.name, one.role) for one in sources][1:] == [("played.csv", "fit")]
    tab.button("Find which effect is missing").wait_for()
    tab.button("Go to Compare").click()
    tab.heading("Compare").wait_for()
    tab.settle()
    tab.choose("Recording", "played.csv")
    tab.settle()
    assert violations(tab.page, LEVEL_AA) == []
    tab.close()
    assert tab.faults == []
    return handed_out


def test_it_is_played_and_its_recording_searched_with_the_others(
    browser: Any, app: Served, tmp_path: Path
) -> None:
    recording = (demo.DATA / "demo_validate.csv").read_bytes()
    text = "Small reversals of the motor for 4 s"
    handed_out = take_part(browser, app, tmp_path, text, recording)
    assert handed_out.name == "demo_actuator_experiment.csv"
    assert handed_out.read_text() == experiment_csv(next_experiment())


# ---- where a torque drives the motor -------------------------------------------------------------


def driven_session(path: Path, recorded: Path) -> tuple[SessionFile, Experiment]:
    """Friction of the motor or its cogging, which a short motion leaves open, and the experiment
    that is proposed."""
    case, (_, experiment) = case_of("torque"), proposed("torque")
    write_csv(case.data, recorded)
    models = {effect_id: model.to_toml() for effect_id, (model, _) in case.answers.items()}
    document = new_document(GIVEN.at("torque"), [Source(key="short", name=recorded.name)])
    known = document.data_key()
    refitted = {"parent": "1", "title": "parameters refitted", "fitted_to": known}
    document = document.adding(document.version.model_copy(update=refitted | {"searched": known}))
    first, *_ = friction_found().rounds[0].candidates
    ids = [(effect_id,) for effect_id in models]
    found = [replace(first, ids=one, expected_parameters={}, fitted_parameters=()) for one in ids]
    alike = tuple(replace(one, equivalence_class=tuple(ids), probability=0.5) for one in found)
    ranked = Ranked(Round(ids[0], alike, "both explain the same"), models)
    return session_with(path, document, {"short": recorded}, ranked, experiment), experiment


def write_csv(recording: Measurement, path: Path) -> None:
    """With a torque that drives and the motor's position, which is no input then."""
    columns = {**recording.inputs, **recording.signals}
    names = {name: f"{name}_{'Nm' if 'torque' in name else 'rad'}" for name in columns}
    table = pd.DataFrame({"time_s": recording.time} | {names[one]: columns[one] for one in names})
    table.to_csv(path, index=False)


def test_a_machine_that_a_torque_drives_takes_part_too(browser: Any, tmp_path: Path) -> None:
    file, experiment = driven_session(tmp_path / "night.session", tmp_path / "short.csv")
    write_csv(case_of("torque").run(experiment), tmp_path / "came.csv")
    text = "Let its controller follow this, and record the motor torque"
    with served_session(file) as app:
        recording = (tmp_path / "came.csv").read_bytes()
        handed_out = take_part(browser, app, tmp_path, text, recording)
        session = app.workspace.open(None)
        (_, played) = session.document.sources
        ((read,),) = [session.cache.find(results.reading(played, session.files))]
    assert handed_out.read_text() == experiment_csv(experiment)
    heads = handed_out.read_text().splitlines()[0].split(",")
    assert heads == ["time_s", "motor_position_rad", "load_torque_Nm", "motor_torque_Nm"]
    assert {"motor_torque", "motor_position", "joint_position"} <= {*read.inputs, *read.signals}
