"""Samples that cannot have been: spikes are replaced, what stands in a motion is left out."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import elastic_tendon as et
from elastic_tendon.measurement import read_measurements
from elastic_tendon.measurement.preparation import check_preparation, preparation_json
from written_tables import assert_same_samples, saved

STEP = 0.0004  # of the encoder, rad
TIME = 0.002 * np.arange(4000)
MOTOR = 0.8 * np.sin(2.1 * TIME) + 0.1 * np.sin(7.0 * TIME)


def shown(position: np.ndarray) -> np.ndarray:
    return STEP * np.round(position / STEP)


def frame(joint: np.ndarray, time: np.ndarray = TIME, motor: np.ndarray = MOTOR) -> pd.DataFrame:
    columns = {"time_s": time, "motor_position_rad": motor, "joint_position_rad": joint}
    return pd.DataFrame(columns)


JOINT = shown(0.9 * MOTOR)


@pytest.mark.parametrize("length", [1, 2, 3])
@pytest.mark.parametrize("column", ["joint_position", "motor_position"])
def test_spike_is_replaced_and_told(tmp_path: Path, column: str, length: int) -> None:
    data = frame(JOINT, motor=shown(MOTOR))
    name = f"{column}_rad"
    was = data[name].to_numpy().copy()
    data.loc[1000 : 1000 + length - 1, name] += 0.02
    found = et.read(saved(tmp_path, data))
    own = found.motor_position if column == "motor_position" else found.joint_position
    assert len(found.time) == len(TIME)
    assert np.abs(own - was)[1000 : 1000 + length].max() < 2.0 * STEP
    assert np.array_equal(np.delete(own, np.s_[1000:1003]), np.delete(was, np.s_[1000:1003]))
    assert any(note.startswith(f"{column}: a spike") and "at 2 s" in note for note in found.notes)


def held(joint: np.ndarray, first: int, count: int) -> np.ndarray:
    joint = joint.copy()
    joint[first : first + count] = joint[first]
    return joint


def test_what_stands_while_it_moves_is_left_out_and_cuts(tmp_path: Path) -> None:
    path = saved(tmp_path, frame(held(held(JOINT, 700, 40), 2500, 60)))
    found = et.read(path)
    lost = np.r_[701:740, 2501:2560]
    assert np.array_equal(found.time, np.delete(TIME, lost))
    assert np.array_equal(found.joint_position, np.delete(JOINT, lost))
    assert [len(piece.time) for piece in found.pieces] == [701, 1761, 1440]
    assert any("stands 2 times" in note and "98 samples" in note for note in found.notes)
    for piece, again in zip(read_measurements(path), found.pieces, strict=True):
        assert_same_samples(piece, again)
        assert (piece.name, piece.recording) == (again.name, again.recording)
        # a piece is read again as it is written in a comparison
        tree = json.loads(json.dumps(preparation_json(again.preparation)))
        (replayed,) = read_measurements(path, check_preparation(tree, "again"))
        assert_same_samples(replayed, again)


def test_slow_motion_that_stands_is_seen_by_more_than_its_next_samples(tmp_path: Path) -> None:
    motor = 0.08 * np.sin(2.1 * TIME)
    assert np.max(np.abs(np.diff(shown(motor)))) < 1.5 * STEP
    found = et.read(saved(tmp_path, frame(held(shown(motor), 60, 40), motor=motor)))
    assert any("stands once" in note for note in found.notes)


RNG = np.random.default_rng(8)
HONEST = {
    "noise": JOINT + 0.003 * RNG.normal(size=len(TIME)),
    "impacts": shown(np.abs(MOTOR)),
    "steps in one sample": shown(0.1 * np.floor(3.0 * TIME)),
    "slips in one sample, ringing": shown(
        0.1 * np.floor(3.0 * TIME) + 0.02 * np.exp(-30.0 * (TIME % (1 / 3))) * np.sin(300.0 * TIME)
    ),
    "sampled at a tenth of the rate": np.repeat(JOINT[::10], 10),
    "rest and ramp": shown(np.clip(np.abs(TIME % 4.0 - 2.0) - 1.0, 0.0, 0.5)),
    "stuck at the ends": shown(np.clip(MOTOR, -0.5, 0.5)),
}


@pytest.mark.parametrize("case", HONEST)
def test_what_a_machine_may_do_stays(tmp_path: Path, case: str) -> None:
    data = frame(HONEST[case])
    found = et.read(saved(tmp_path, data))
    assert np.array_equal(found.joint_position, data["joint_position_rad"])
    assert not found.cuts


def test_many_are_the_nature_of_a_signal(tmp_path: Path) -> None:
    joint = JOINT.copy()
    joint[50::90] += 0.02
    found = et.read(saved(tmp_path, frame(joint)))
    assert np.array_equal(found.joint_position, joint)


@pytest.mark.parametrize(("moves", "pieces"), [(True, 2), (False, 1)])
def test_missing_rows_cut_where_the_motor_bends(tmp_path: Path, moves: bool, pieces: int) -> None:
    # over eight steps the sine turns round
    motor = np.where(moves | (np.abs(TIME - 3.0) > 0.5), np.sin(8.0 * np.pi * TIME), 0.0)
    data = frame(JOINT, motor=motor)
    if not moves:
        data = data.assign(motor_position_rad=np.interp(TIME, [0, 2.4, 3.6, 8], [0, 1, 1, 0]))
    found = et.read(saved(tmp_path, data.drop(index=range(1530, 1537))))
    assert len(found.pieces) == pieces


def test_pieces_of_one_recording_share_its_zero(tmp_path: Path) -> None:
    model = et.load_model("biorob_x4_joint_3")
    motion = et.simulate(model, TIME, 0.3 * MOTOR)
    joint = shown(motion["joint_position"] + 0.01)
    found = et.read(saved(tmp_path, frame(held(joint, 1500, 40), motor=0.3 * MOTOR)))
    assert len(found.pieces) == 2
    added = et.add(model, "joint_encoder_offset", found)
    assert added.model.effects["joint_encoder_offset"]["offset"] == pytest.approx(0.01, rel=0.05)
    assert not added.model.recordings
    assert len(et.compare(added.model, found).files) == 2
