"""By how much a sensor is late is found again, and what cannot be told is not."""

from dataclasses import replace

import numpy as np
import pytest

from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.errors import MeasurementError
from elastic_tendon.measurement import Measurement
from elastic_tendon.measurement.preparation import Preparation
from elastic_tendon.misreadings.time_shift import estimate_time_shift, with_time_shifts_resolved
from truth.catalogue import actuator_of
from truth.experiments import Limits, multisine
from truth.noise import Sensor
from truth.recording import SignalMaps, record
from truth.sampling import sample

RATE, DURATION = 500, 4.0  # Hz, s
DELAY = 0.0137  # s, no multiple of the samples' distance
NOISE = 2e-4  # rad
MODEL = load_model("biorob_x4_joint_3")


@pytest.fixture(scope="module")
def late() -> Measurement:
    """A joint sensor that is late by DELAY, with noise; motor and load move."""
    time = np.arange(round(DURATION * RATE)) / RATE
    experiment = multisine(8, Limits(0.3, 4.0, 5.0), DURATION)
    run = record(actuator_of(MODEL.model_dump()), experiment, time, SignalMaps(delay=DELAY))
    table = sample(run, {"joint_position": Sensor(white=NOISE)}, 8)
    return Measurement(
        name="late.csv",
        time=time,
        motor_position=table["motor_position_rad"],
        signals={"joint_position": table["joint_position_rad"]},
        load_torque=table["load_torque_Nm"],
    )


def test_late_joint_is_found_to_a_tenth_of_a_sample(late) -> None:
    found = estimate_time_shift(MODEL, late, "joint_position")
    assert found.shift == pytest.approx(DELAY, abs=0.1 / RATE)
    assert found.standard_error < 0.1 / RATE


def test_early_joint_is_found(late) -> None:
    early = late.shifted({"joint_position": 0.05})
    found = estimate_time_shift(MODEL, early, "joint_position")
    assert found.shift == pytest.approx(DELAY - 0.05, abs=0.1 / RATE)


@pytest.mark.parametrize("signal", ["motor_position", "load_torque"])
def test_late_input_is_found(late, signal) -> None:
    straight = late.shifted({"joint_position": DELAY})
    wrong = straight.shifted({signal: -0.02})
    found = estimate_time_shift(MODEL, wrong, signal)
    assert found.shift == pytest.approx(0.02, abs=0.5 / RATE)


def test_late_joint_torque_is_found_by_its_own_simulation(late) -> None:
    from elastic_tendon.simulation.simulate import simulate

    straight = late.shifted({"joint_position": DELAY})
    motion = simulate(MODEL, straight.time, straight.motor_position, straight.load_torque)
    torque = np.interp(straight.time - 0.0071, straight.time, motion["joint_torque"])
    recording = replace(straight, signals=straight.signals | {"joint_torque": torque})
    found = estimate_time_shift(MODEL, recording, "joint_torque")
    assert found.shift == pytest.approx(0.0071, abs=0.25 / RATE)


def test_wrong_inertia_is_confused_with_a_delay(late) -> None:
    # said in the docstring: the standard error does not know of it
    heavy = MODEL.with_values({"link.inertia": 1.2 * MODEL.link.inertia})
    found = estimate_time_shift(heavy, late, "joint_position")
    assert found is not None
    assert found.shift < DELAY - 2.0 * found.standard_error


def test_recording_at_rest_cannot_tell(late) -> None:
    rest = replace(late, motor_position=np.zeros_like(late.time), load_torque=None)
    assert estimate_time_shift(MODEL, rest, "motor_position") is None
    assert estimate_time_shift(MODEL, rest, "load_torque") is None


def left_open(measurement: Measurement, *signals: str) -> Measurement:
    return replace(measurement, preparation=Preparation(time_shift=dict.fromkeys(signals, "auto")))


def test_open_shift_is_filled_in(late) -> None:
    (resolved,) = with_time_shifts_resolved(MODEL, [left_open(late, "joint_position")])
    shift = resolved.preparation.time_shift["joint_position"]
    assert shift == pytest.approx(DELAY, abs=0.1 / RATE)
    assert "joint_position is taken as 13." in resolved.notes[-1]
    # reading the file with this number gives the same samples
    again = late.shifted({"joint_position": shift})
    np.testing.assert_array_equal(resolved.motor_position, again.motor_position)
    np.testing.assert_array_equal(resolved.time, again.time)


def test_shifts_given_as_numbers_stay(late) -> None:
    given = replace(late, preparation=Preparation(time_shift={"joint_position": 0.003}))
    (same,) = with_time_shifts_resolved(MODEL, [given])
    assert same.preparation.time_shift == {"joint_position": 0.003}
    np.testing.assert_array_equal(same.time, given.time)


def test_shift_that_cannot_be_told_is_refused_in_a_sentence(late) -> None:
    rest = left_open(replace(late, motor_position=np.zeros_like(late.time)), "motor_position")
    with pytest.raises(MeasurementError, match=r"^late.csv: .*--shift motor_position=0.004"):
        with_time_shifts_resolved(MODEL, [rest])
