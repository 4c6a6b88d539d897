"""What an effect explains has to be found on stretches of time that it was not fitted to."""

import numpy as np
import pytest

import elastic_tendon as et
from elastic_tendon.diagnosis.answer import refit
from elastic_tendon.diagnosis.cross_validation import crossed_squares, median_explained

MODEL = et.load_model("biorob_x4_joint_3")
TIME = np.arange(0.0, 12.0, 0.005)
MOTOR = 0.3 * np.sin(3.0 * TIME) + 0.2 * np.sin(5.3 * TIME + 0.4)
NOISE = 2e-4
FRICTION, GRAVITY = ("coulomb_friction",), ("gravity_load",)


def recording(model, load=None, time=TIME):
    """The machine, under a load that nobody recorded."""
    joint = et.simulate(model, TIME, MOTOR, load)["joint_position"]
    noisy = joint + NOISE * np.random.default_rng(1).standard_normal(len(TIME))
    whole = et.Measurement(TIME, MOTOR, {"joint_position": noisy}, interpolation="linear")
    return whole.samples(slice(len(time)))


def in_turn(tasks):
    return [task(lambda _share: None) for _, task in tasks]


def squares(measurement, *sets):
    """Mean square error where fitted, and where left out, of each set of effects."""
    answers = [refit(MODEL, added, [measurement]) for added in sets]
    return [
        (answer.mean_square, float(np.mean(crossed_squares(MODEL, answer, in_turn))))
        for answer in answers
    ]


def test_an_effect_that_is_there_explains_what_was_left_out():
    rubbing = MODEL.with_effect(*FRICTION, {"torque": 0.4})
    (nothing, left_out), (fitted, crossed) = squares(recording(rubbing), (), FRICTION)
    assert fitted < 1.1 < nothing
    assert crossed < 1.3 < left_out


def test_an_effect_that_is_not_there_does_not():
    drift = np.interp(TIME, [0.0, 6.0, 12.0], np.random.default_rng(3).normal(0.0, 1.0, 3))
    (nothing, left_out), (fitted, crossed) = squares(recording(MODEL, drift), (), GRAVITY)
    share = 1.0 - fitted / nothing
    assert share > 0.1  # it fits some of what is left
    assert 1.0 - crossed / left_out < 0.5 * share


def test_a_recording_too_short_to_be_divided_tells_nothing():
    answer = refit(MODEL, (), [recording(MODEL, time=TIME[:200])])
    assert np.isnan(crossed_squares(MODEL, answer, in_turn)).all()
    assert np.isnan(median_explained(np.full(1, np.nan), np.full(1, np.nan)))


def test_a_stretch_that_goes_beyond_all_others_is_one_of_several():
    before, after = np.array([100.0, 900.0, 200.0, 100.0]), np.array([1.0, 600.0, 1.0, 1.0])
    assert median_explained(before, after) > 0.8
    assert median_explained(after, before) < -0.8
    assert median_explained(before, before) == 0.0
    # a fit that fails has explained nothing; what is gone is no more than all
    for failures, explained in ((1, 1.0), (2, 0.0), (3, -1.0)):
        after = np.array([1.0] * (4 - failures) + [np.inf] * failures)
        assert median_explained(before, after) == pytest.approx(explained, abs=0.01)
    assert median_explained(np.full(2, 0.9), np.full(2, 0.8)) == pytest.approx(1.0)
