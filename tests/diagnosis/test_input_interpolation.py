"""How inputs ran between the samples is chosen by their spectra, and by the motion where it shows
otherwise."""

from dataclasses import replace

import numpy as np
import pytest

import elastic_tendon as et
from elastic_tendon.diagnosis.answer import refit
from elastic_tendon.diagnosis.data import data_of
from elastic_tendon.diagnosis.options import Options
from elastic_tendon.diagnosis.search import Search
from elastic_tendon.diagnosis.straight_inputs import with_straight_inputs
from elastic_tendon.estimation.fit import Effort
from elastic_tendon.progress import silent

MODEL = et.load_model("biorob_x4_joint_3")
TIME = np.arange(0.0, 8.0, 0.01)
NOISE = 2e-5
BEGUN = Effort(scouted=1, scouting=1, polished=0, evaluations=1, rounds=0)


def smooth(time):
    return 0.3 * np.sin(7.0 * time) + 0.1 * np.sin(31.0 * time + 1.0)


def stepping(time):
    return 0.2 * (np.floor(time / 0.25) % 2)


def noisy(time):
    return smooth(time) + 2e-3 * np.random.default_rng(3).standard_normal(len(time))


def recording(motor, between, model=MODEL, asked="auto"):
    joint = et.simulate(model, TIME, motor(TIME), interpolation=between)["joint_position"]
    noise = NOISE * np.random.default_rng(1).standard_normal(len(TIME))
    signals = {"joint_position": joint + noise}
    return et.Measurement(TIME, motor(TIME), signals, interpolation=asked)


@pytest.mark.parametrize(
    ("motor", "expected"), [(smooth, "cubic"), (stepping, "linear"), (noisy, "linear")]
)
def test_a_spectrum_that_ends_below_the_highest_frequency_is_that_of_a_smooth_input(
    motor, expected
):
    found = et.Measurement(TIME, motor(TIME))
    assert found.input_interpolation == expected
    assert found.samples(slice(30)).input_interpolation == expected  # as of the whole
    assert found.to_dict()["interpolation"] == expected
    assert f"between the samples: {expected}" in found.summary()
    assert replace(found, interpolation="hold").input_interpolation == "hold"


def test_one_input_that_steps_makes_both_run_in_straight_lines():
    assert et.Measurement(TIME, smooth(TIME), {}, stepping(TIME)).input_interpolation == "linear"


def test_inputs_that_stand_still_do_not_count():
    resting = np.zeros_like(TIME)
    assert et.Measurement(TIME, resting, {}, smooth(TIME)).input_interpolation == "cubic"
    assert et.Measurement(TIME, resting).input_interpolation == "linear"


def test_a_diagnosis_takes_the_inputs_as_they_ran_and_says_so():
    truth = MODEL.with_effect("coulomb_friction", {"torque": 0.3})
    only = et.Options(only=("coulomb_friction", "gravity_load"))
    found = et.diagnose(MODEL, recording(smooth, "linear", truth), options=only)
    assert found.added == ("coulomb_friction",)
    assert found.ladder[-1].noise_ratio["joint_position"] < 1.05
    (note,) = (note for note in found.notes if "in straight lines" in note)
    assert "with curves more of the error is left" in note


def test_straight_lines_do_not_win_because_a_refit_goes_on():
    heavier = MODEL.with_values({"link.inertia": 1.05 * MODEL.link.inertia})
    run = recording(smooth, "cubic", heavier)
    search = Search.of(data_of(MODEL, [run], [], Options()), silent)
    search.answers[()] = refit(MODEL, (), search.data.fitted, [], BEGUN)
    assert search.answer.mean_square > 2.0
    asked = (MODEL, [run], [], Options(), search)
    assert with_straight_inputs(*asked, final=False) is None


def test_what_was_asked_for_stays():
    assumed, asked = (recording(smooth, "linear", asked=kind) for kind in ("auto", "cubic"))
    assert assumed.with_straight_inputs().input_interpolation == "linear"
    assert asked.with_straight_inputs() is asked


@pytest.mark.parametrize("between", ["linear", "cubic"])
def test_a_comparison_and_a_fit_take_the_inputs_as_they_ran(between):
    own = recording(smooth, between)
    assert et.compare(MODEL, own).rmse()["joint_position"] < 1.05 * NOISE
    (used,) = et.fit(MODEL.with_values({"link.damping": 0.3}), own).problem.measurements
    assert used.input_interpolation == between
