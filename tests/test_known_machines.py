"""The page and the picture of known machines are of what the scoreboard would ask today.

Where the recordings are at hand, a shortened row of each machine is asked: few seconds of the part
to fit, few candidates. Nothing here touches a test part.
"""

import json
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest

import elastic_tendon as et
import scoreboard
import study_other_machines
from benchmarking import known_misses
from make_identified_models import MODELS_MADE
from other_machines.cases import orders
from site_pages import known_machines

KEPT = json.loads(known_machines.KEPT.read_text("utf-8"))
MACHINES = {machine.name: machine for machine in scoreboard.MACHINES}


@dataclass(frozen=True)
class Shortened:
    """A row of the scoreboard in short: so many s of the part to fit, with these candidates.

    `added` : what is found, in this order. `most` : error of that part, in the machine's unit.
    """

    machine: str
    seconds: float
    candidates: tuple[str, ...]
    added: tuple[str, ...]
    most: float


SHORTENED = (
    Shortened(
        "Silverbox",
        6.0,
        ("spring_hardening", "coulomb_friction", "constant_torque"),
        ("spring_hardening", "constant_torque"),
        0.40,  # mV
    ),
    Shortened(
        "EMPS",
        8.0,
        ("coulomb_friction", "constant_torque", "quadratic_drag"),
        ("constant_torque", "coulomb_friction"),
        2.0,  # mm
    ),
    Shortened(
        "muir",
        6.0,
        ("coulomb_friction", "gear_backlash"),
        ("coulomb_friction",),
        4.0,  # mrad
    ),
    Shortened(
        "mrd, fast",
        4.0,
        ("coulomb_friction", "tendon_guide_friction"),
        ("tendon_guide_friction",),
        3.5,  # mrad
    ),
)


@pytest.mark.parametrize("row", SHORTENED, ids=lambda row: row.machine)
def test_a_shortened_row_names_the_same_and_errs_as_little(row: Shortened) -> None:
    machine = MACHINES[row.machine]
    if not (scoreboard.DATA / machine.source).is_file():
        pytest.skip("the recordings of real machines are not at hand")
    recording = machine.fitted(scoreboard.DATA).window(None, row.seconds)
    found = et.diagnose(machine.model(), recording, options=et.Options(only=row.candidates))
    assert found.added == row.added
    assert machine.scale * found.ladder[-1].rmse[machine.signal] < row.most


def test_a_shortened_row_is_of_each_machine() -> None:
    sources = {MACHINES[row.machine].name.split(",")[0] for row in SHORTENED}
    assert sources == {name.split(",")[0] for name in MACHINES}


def test_what_is_said_to_be_bundled_is() -> None:
    said = {machine.bundled.partition("et.models.")[2] for machine in scoreboard.MACHINES} - {""}
    assert said == {entry.name for entry in MODELS_MADE}
    for entry in MODELS_MADE:
        assert MACHINES[entry.machine].bundled == f"as et.models.{entry.name}"
        assert entry.name in et.models


def test_each_missed_target_is_told_and_has_its_sentence() -> None:
    for found in KEPT:
        rows = scoreboard.rows_of(MACHINES[found["machine"]], found)
        assert found["missed"] == [row.what for row in rows if row.met is False]
        assert set(found["missed"]) <= set(known_misses())


def test_every_machine_is_kept_as_it_is_asked_about() -> None:
    names = ("name", "given", "published", "best", "unit", "bundled")
    asked = [{name: getattr(machine, name) for name in names} for machine in scoreboard.MACHINES]
    kept = [{name: found[name] for name in asked[0] if name != "name"} for found in KEPT]
    assert [machine["machine"] for machine in KEPT] == [machine.pop("name") for machine in asked]
    assert kept == asked


def test_what_is_kept_agrees_with_itself() -> None:
    for found in KEPT:
        fitted = found["before"][0], found["after"][0]
        assert (found["errors"][0], found["errors"][-1]) == pytest.approx(fitted, rel=1e-3)
        largest = found["largest"]
        assert len(largest["time_s"]) == len(largest["before"]) == len(largest["after"])
        for name in ("before", "after"):  # a largest error is no less than the RMS of all
            assert max(largest[name]) > found[name][1]


@pytest.fixture
def beside(tmp_path, monkeypatch) -> None:
    """What is kept goes to a folder that is thrown away."""
    monkeypatch.setattr(scoreboard, "KEPT", tmp_path / "kept.json")
    monkeypatch.setattr(scoreboard, "PICTURE", tmp_path / "pictures" / "errors.png")
    scoreboard.keep({found["machine"]: found for found in KEPT})


@pytest.mark.usefixtures("beside")
def test_calls_on_test_parts_are_counted_in_the_file() -> None:
    before = scoreboard.kept()
    scoreboard.count_call("EMPS")
    after = scoreboard.kept()
    assert after["EMPS"].pop("calls") == before["EMPS"].pop("calls") + 1
    assert after == before
    scoreboard.count_call("a new one")
    assert scoreboard.kept()["a new one"] == {"machine": "a new one", "calls": 1}


@pytest.mark.usefixtures("beside")
def test_what_is_kept_is_written_as_it_was_read() -> None:
    assert scoreboard.KEPT.read_bytes() == known_machines.KEPT.read_bytes()


@pytest.mark.usefixtures("beside")
def test_a_machine_is_kept_with_its_largest_errors() -> None:
    model = et.load_model("biorob_x4_joint_3")
    time = np.arange(1000) / 100.0
    still = et.Measurement(
        time=time,
        motor_position=0.0 * time,
        signals={"joint_position": np.where(time == 7, 0.2, 0)},
    )
    machine = MACHINES["muir"]
    compared = et.compare(model, still)
    steps = [SimpleNamespace(title="as given", rmse={"joint_position": 0.0123456})]
    found = SimpleNamespace(sentence="It is adequate.", added=(), ladder=steps, model=model)
    outcome = scoreboard.Outcome(machine, found, (3.0, 2.0), (3.0, 2.0), (compared, compared), 1.2)
    kept = scoreboard.as_json(outcome)
    assert kept["errors"] == [12.35]  # mrad
    first = kept["largest"]["time_s"][int(np.argmax(kept["largest"]["after"]))]
    assert max(kept["largest"]["after"]) == pytest.approx(200.0, rel=0.01)
    assert 7.0 - 10.0 / scoreboard.BINS < first <= 7.0
    assert kept["missed"] == [f"{machine.name}: named"]  # nothing is
    assert kept["learned"] is None
    scoreboard.draw()
    assert scoreboard.PICTURE.stat().st_size > 10_000


def test_a_learned_curve_has_rows_of_its_own() -> None:
    machine, found = MACHINES["EMPS"], next(one for one in KEPT if one["machine"] == "EMPS")
    learned = {"title": "Learned: friction", "after": [0.5, 2.7]}
    rows = {row.what: row for row in scoreboard.rows_of(machine, found | {"learned": learned})}
    fit, test = (rows[f"EMPS: error, {part}, with a curve learned"] for part in ("fit", "test"))
    assert (fit.met, test.met) == (None, False)
    none = scoreboard.rows_of(machine, found | {"learned": None})
    assert not any("learned" in row.what for row in none)


def test_the_picture_has_a_mark_for_each_figure() -> None:
    (axes,) = known_machines.summary_figure(KEPT).axes
    marks = [line for line in axes.lines if line.get_marker() in ("o", "D")]
    published = [found for found in KEPT if found["best"] is not None]
    assert len(marks) == 2 * len(KEPT) + len(published)
    after = [line.get_xdata()[0] for line in marks if line.get_color() == known_machines.BLUE]
    assert after == [found["after"][1] / found["before"][1] for found in KEPT]


def test_the_page_tells_each_step(tmp_path) -> None:
    ((name, text),) = known_machines.pages(tmp_path)
    assert name == "known_machines.md"
    for number, found in enumerate(KEPT):
        section = text.split(f"\n## {found['machine']}\n")[1].split("\n## ")[0]
        assert section.count(f" {found['unit']} |") == len(found["steps"])
        assert f"simulated {found['calls']} times" in section
        assert section.count("\n* ") == len(found["missed"])
        assert ("fitted once more" in section) == bool(found.get("learned"))
        assert f"({known_machines.PICTURES}/{number}.svg)" in section
        assert (tmp_path / known_machines.PICTURES / f"{number}.svg").stat().st_size > 5_000


def test_the_page_has_a_row_for_each_machine_of_another_kind(tmp_path) -> None:
    kept = json.loads(known_machines.OTHER_KINDS.read_text("utf-8"))
    names = [order.name for order in orders(reported=True)]
    done = [row["name"] for row in kept]
    assert done == [name for name in names if name in done]
    ((_, text),) = known_machines.pages(tmp_path)
    section = text.split("## Simulated machines of other kinds")[1]
    assert section.count("\n| ") == len(kept) + 2
    assert f"{sum(row['right'] for row in kept)} are named rightly" in section


def test_answers_that_are_done_are_kept_for_the_page(tmp_path, monkeypatch) -> None:
    _, second, *_ = orders(reported=True)
    row = dict.fromkeys(study_other_machines.SHOWN, "") | {"ratio": 1.23456}
    (tmp_path / f"{second.name}.json").write_text(json.dumps(row | {"name": second.name}))
    monkeypatch.setattr(study_other_machines, "OTHER_KINDS", tmp_path / "kept.json")
    assert study_other_machines.keep(tmp_path) == 0
    (kept,) = json.loads((tmp_path / "kept.json").read_text())
    assert (kept["name"], kept["ratio"]) == (second.name, 1.235)


def test_the_width_of_a_hysteresis_is_that_between_the_two_directions():
    time = np.linspace(0.0, 20.0, 4000)
    motor = np.sin(time)
    joint = 0.5 * motor - 0.02 * np.sign(np.cos(time))
    assert scoreboard.loop_width(motor, joint) == pytest.approx(0.04, rel=0.05)
    assert scoreboard.loop_width(motor, 0.5 * motor) < 2e-3
