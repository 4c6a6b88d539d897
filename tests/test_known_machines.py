"""The page and the picture of known machines are of what the scoreboard would ask today."""

import json
from types import SimpleNamespace

import numpy as np
import pytest

import elastic_tendon as et
import scoreboard
from site_pages import known_machines

KEPT = json.loads(known_machines.KEPT.read_text())


def test_every_machine_is_kept_as_it_is_asked_about() -> None:
    asked = [
        {name: getattr(machine, name) for name in ("name", "given", "published", "best", "unit")}
        for machine in scoreboard.MACHINES
    ]
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


def test_a_machine_is_kept_with_its_largest_errors(tmp_path, monkeypatch) -> None:
    model = et.load_model("biorob_x4_joint_3")
    time = np.arange(1000) / 100.0
    still = et.Measurement(
        time=time,
        motor_position=0.0 * time,
        signals={"joint_position": np.where(time == 7, 0.2, 0)},
    )
    machine = scoreboard.MACHINES[-1]
    compared = et.compare(model, still)
    steps = [SimpleNamespace(title="as given", rmse={"joint_position": 0.0123456})]
    found = SimpleNamespace(sentence="It is adequate.", added=(), ladder=steps)
    outcome = scoreboard.Outcome(machine, found, (3.0, 2.0), (3.0, 2.0), (compared, compared), 1.2)
    monkeypatch.setattr(scoreboard, "KEPT", tmp_path / "kept.json")
    monkeypatch.setattr(scoreboard, "PICTURE", tmp_path / "pictures" / "errors.png")
    scoreboard.keep([outcome])
    (kept,) = json.loads(scoreboard.KEPT.read_text())
    assert kept["errors"] == [12.35]  # mrad
    first = kept["largest"]["time_s"][int(np.argmax(kept["largest"]["after"]))]
    assert max(kept["largest"]["after"]) == pytest.approx(200.0, rel=0.01)
    assert 7.0 - 10.0 / scoreboard.BINS < first <= 7.0
    assert scoreboard.PICTURE.stat().st_size > 10_000


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
        assert f"({known_machines.PICTURES}/{number}.svg)" in section
        assert (tmp_path / known_machines.PICTURES / f"{number}.svg").stat().st_size > 5_000
