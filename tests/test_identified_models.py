"""Bundled models of real machines: they run, and err on the recordings by what they say."""

import re

import numpy as np
import pytest

import elastic_tendon as et
import make_identified_models
from make_identified_models import DATA, MODELS, MODELS_MADE, error_on
from scoreboard import MACHINES

ROUNDING = 0.02  # of an error: three digits of it, six of each number
NAMES = [entry.name for entry in MODELS_MADE]


def text(name: str) -> str:
    return (MODELS / f"{name}.toml").read_text("utf-8")


def stated(name: str) -> tuple[float, float]:
    """Errors on what was fitted and on what was not, as the file says."""
    said = re.sub(r"\n# ", " ", text(name))
    (fitted,) = re.findall(r"fitted \([^)]*\): (\S+) ", said)
    (unseen,) = re.findall(r"what was not \([^)]*\): (\S+) ", said)
    return float(fitted), float(unseen)


@pytest.mark.parametrize("name", NAMES)
def test_an_identified_model_says_where_it_comes_from_and_runs(name: str) -> None:
    model = getattr(et.models, name)
    assert re.search(r"GitHub|\b20\d\d\b", text(name))
    assert re.search(r" to -?[\d.e-]+$", text(name), re.MULTILINE)  # an interval
    time = np.arange(200) / 200.0
    held = model.effects.get("coulomb_friction", {}).get("torque", 0.0)
    run = et.simulate(model, time, np.zeros(200), np.full(200, 0.1 + 2.0 * held))
    assert np.all(np.isfinite(run["joint_position"]))
    assert np.ptp(run["joint_position"]) > 0.0


@pytest.mark.parametrize("entry", MODELS_MADE, ids=NAMES)
def test_it_errs_by_what_its_file_says(entry: make_identified_models.Identified) -> None:
    machine = next(one for one in MACHINES if one.name == entry.machine)
    if not (DATA / machine.source).is_file():
        pytest.skip("the recordings of real machines are not at hand")
    error = error_on(getattr(et.models, entry.name), machine.test(DATA), machine)
    assert error == pytest.approx(stated(entry.name)[1], rel=ROUNDING)


def test_what_is_not_at_hand_is_said(tmp_path, capsys) -> None:
    assert make_identified_models.main(["--data", str(tmp_path)]) == 1
    assert "name its folder with --data" in capsys.readouterr().out
