"""The page of a machine that slides: every answer and every file in metres and newtons."""

import json
import re
import zipfile
from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd
import pytest
from plotly.utils import PlotlyJSONEncoder

pytest.importorskip("dash")

import elastic_tendon as et
from elastic_tendon.actuator.motion_kind import MotionKind
from elastic_tendon.app import takeaway
from elastic_tendon.app.document import Source, new_document
from elastic_tendon.app.server import dash_app
from elastic_tendon.app.source_card import Form, card, overview
from elastic_tendon.app.steps import STEPS
from elastic_tendon.app.steps.data import seen
from elastic_tendon.app.worded import worded
from elastic_tendon.app.workspace import Session, Workspace
from elastic_tendon.diagnosis.experiment import experiment_csv
from elastic_tendon.progress import silent
from elastic_tendon.reports.interactive.theme import LIGHT
from hand_made_diagnosis import next_experiment

LINEAR = et.load_model({**et.models.figure_7.model_dump(exclude_none=True), "motion": "linear"})
TURNING = re.compile(r"\bm?rad\b|N·m\b|kg·m²|\bN\.m\b|_rad\b|_Nm\b|(?<![\w.])[Tt]orques?(?![\w-])")
TIME = np.arange(0.0, 1.0, 4e-3)
# what the fields of the page hold, by the ends of their ids
HELD = {"open": None, "theme": "light", "effect-choice": "coulomb_friction"}
HELD |= dict.fromkeys(("compare-state", "compare-moving", "compare-quantity"), "all")
SEEN = {  # of each step, what has to stand in the answers
    "model": ["force on the joint (N)", "natural frequency, both taut", "1/s", "mass J about"],
    "compare": ["joint position (m)", "RMS (mm)", "deflection as measured (m)", "load force (N)"],
    "where": ["joint velocity (m/s)", "missing force (N)", "load force (N)"],
    "effect": [
        "In slow motion load force against deflection",
        "a force of constant size",
    ],
    "add": ["Constant force"],
}


@pytest.fixture(scope="module")
def workspace(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Workspace]:
    """A session with a recording in millimetres and newtons, whose friction the model lacks."""
    motor, load = 0.2 * np.sin(9.0 * TIME), 2.0 * np.sin(14.0 * TIME)
    rubbing = LINEAR.with_effect("coulomb_friction", {"torque": 0.3})
    joint = et.simulate(rubbing, TIME, motor, load)["joint_position"]
    joint = joint + 1e-4 * np.random.default_rng(3).standard_normal(len(TIME))
    columns = {"motor_position_m": motor, "load_torque_N": load, "joint_position_mm": 1e3 * joint}
    path = tmp_path_factory.mktemp("slides") / "run.csv"
    pd.DataFrame({"time_s": TIME, **columns}).to_csv(path, index=False)
    made = Workspace(new_document(LINEAR, [Source(key="run", name="run.csv")]), {"run": path})
    yield made
    made.close()


@pytest.fixture(scope="module")
def session(workspace: Workspace) -> Session:
    return workspace.open(None)


def answers(workspace: Workspace, session: Session, step: str) -> Iterator[dict[str, Any]]:
    """What the page is told while a step is open and all that it needs is there."""
    app = dash_app(workspace, "token")
    client = app.server.test_client()
    client.get("/token/_dash-layout")  # only then are callbacks known
    (opened,) = (one for one in STEPS if one.id == step)
    for result in opened.needs(session.document, session.files):
        session.cache.obtain(result, silent)
    values = HELD | {"open": step, f"{step}-session": session.stored()}

    def given(places: list[dict[str, str]]) -> list[Any]:
        return [
            [] if place["id"].startswith("{") else {**place, "value": values.get(place["id"])}
            for place in places
        ]

    for output, callback in app.callback_map.items():
        asked = [place["id"] for place in callback["inputs"]]
        if f"{step}-session" not in asked or "{" in output:
            continue
        parts = [part.rpartition(".") for part in output.strip(".").split("...")]
        places = [{"id": name, "property": one} for name, _, one in parts]
        call = {
            "output": output,
            "outputs": places if output.startswith("..") else places[0],
            "inputs": given(callback["inputs"]),
            "state": given(callback["state"]),
        }
        answer = client.post("/token/_dash-update-component", json=call)
        assert answer.status_code in (200, 204), (output, answer.text)
        if answer.status_code == 200:
            yield answer.get_json()["response"]


def read_of(value: Any) -> str:
    """Texts of an answer that people read; in stores for the page's scripts nobody does."""
    if isinstance(value, dict):
        kept = ("data", "id", "value", "bdata", "customdata", "dtype", "data-exact")
        return " | ".join(read_of(item) for key, item in value.items() if key not in kept)
    if isinstance(value, list):
        return " | ".join(map(read_of, value))
    return value if isinstance(value, str) else ""


@pytest.mark.parametrize("step", SEEN)
def test_no_answer_counts_in_radians(step: str, workspace: Workspace, session: Session) -> None:
    told = " | ".join(map(read_of, answers(workspace, session, step))).replace("<br>", " ")
    for words in SEEN[step]:
        assert words in told
    assert not TURNING.search(told), told[max(0, TURNING.search(told).start() - 80) :][:160]


def test_a_recording_keeps_its_own_units(session: Session) -> None:
    (source,) = session.document.sources
    for result in STEPS[1].needs(session.document, session.files):
        session.cache.obtain(result, silent)
    known = seen(session, source)
    shown = json.dumps([card(known, Form()), *overview(known, LIGHT)], cls=PlotlyJSONEncoder)
    told = read_of(json.loads(shown))
    for words in (
        "load force",
        "Noise of the joint position: 0.1",
        "mm, white",
        "joint_position was read",
    ):
        assert words in told
    assert not TURNING.search(told)
    units = {row.signal: [unit["value"] for unit in row.units()] for row in known.rows()}
    assert units["joint_position"][:2] == units["motor_position"][:2] == ["m", "mm"]
    assert units["load_torque"][0] == "N"
    assert {row.si for row in known.rows()} == {"s", "m", "N"}


def test_its_tables_are_read_again(workspace: Workspace, session: Session) -> None:
    made = takeaway.data(session.document, session.files, takeaway.Depot(workspace))
    with zipfile.ZipFile(session.cache.obtain(made, silent).path) as archive:
        heads = {
            name: archive.read(name).decode().partition("\n")[0] for name in archive.namelist()
        }
    assert "θ (m),force on the joint (N)" in heads["figures/01_characteristic_curve.csv"]
    (columns,) = (head for name, head in heads.items() if name.startswith("recordings/"))
    assert {"load_torque_N", "measured_joint_position_m"} < {*columns.split(",")}
    assert not [head for head in heads.values() if TURNING.search(head)]


def test_an_experiment_is_in_metres() -> None:
    head = experiment_csv(next_experiment(), MotionKind.LINEAR).partition("\n")[0]
    assert head == "time_s,motor_position_m,load_torque_N"


def test_only_what_people_read_is_worded() -> None:
    component = {
        "type": "Div",
        "props": {"id": "torque", "value": "torque", "title": "3 rad", "data": {"label": "rad"}},
    }
    code = {"type": "Pre", "props": {"children": "torque"}}
    component["props"]["children"] = [code, "angle"]
    found = worded(component, MotionKind.LINEAR)
    changed = {"title": "3 m", "children": [code, "position"]}
    assert found == {"type": "Div", "props": component["props"] | changed}
