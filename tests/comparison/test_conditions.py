"""Conditions are read as they are meant, refused in a sentence, and choose their samples."""

from dataclasses import replace

import numpy as np
import pytest

from elastic_tendon.comparison.compare import compare
from elastic_tendon.comparison.comparison import FileComparison
from elastic_tendon.comparison.comparison_json import comparison_json
from elastic_tendon.comparison.conditions import parse_condition, select
from elastic_tendon.comparison.locate import locate
from elastic_tendon.comparison.selection import only_where, quantities_of
from elastic_tendon.errors import MeasurementError

VALUES = np.array([-2.0, -1.0, 0.0, 1.0, 2.0])
SIGNAL = "joint_position"


@pytest.mark.parametrize(
    ("text", "holds"),
    [
        ("time>0", [False, False, False, True, True]),
        (" time >= 0 s ", [False, False, True, True, True]),
        ("time<-1e0", [True, False, False, False, False]),
        ("time<=-1000ms", [True, True, False, False, False]),
        ("time=-1..1", [False, True, True, True, False]),
        ("time=.5s .. 60000ms", [False, False, False, True, True]),
    ],
)
def test_a_bound_and_a_range_choose_their_samples(text: str, holds: list[bool]) -> None:
    assert parse_condition(text).holds(VALUES).tolist() == holds


def test_a_slack_state_is_meant_by_its_numeral() -> None:
    condition = parse_condition("slack_state=II")
    assert condition.holds(np.array([1.0, 2.0, 3.0, 4.0])).tolist() == [False, True, False, False]


def test_units_of_the_user_become_si() -> None:
    assert parse_condition("deflection<180deg").high == pytest.approx(np.pi)
    assert parse_condition("motor_velocity>60rpm").low == pytest.approx(2.0 * np.pi)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("slack_state", "write it as slack_state=I, joint_velocity>0"),
        ("slack_state=IV", "one of slack_state=I, slack_state=II, slack_state=III"),
        ("slack_state>I", "one of slack_state=I, slack_state=II, slack_state=III"),
        ("speed>0", "no quantity speed; take slack_state, time, motor_position"),
        ("joint_velocity=0", "give a range, as joint_velocity=3..5, or a bound"),
        ("time=5..3", "from its lower end to its upper end"),
        ("time>soon", "'soon' is no number"),
        ("time=3..", "'' is no number"),
        ("time>1.2.3", "'1.2.3' is no number"),
        ("deflection>3Nm", "Nm is no unit of angle; deflection needs one such as rad or deg"),
    ],
)
def test_what_is_no_condition_is_refused_in_a_sentence(text: str, says: str) -> None:
    with pytest.raises(MeasurementError) as raised:
        parse_condition(text)
    assert str(raised.value).startswith(f"condition {text!r}: ")
    assert says in str(raised.value)


def test_all_conditions_have_to_hold() -> None:
    conditions = [parse_condition("time>-2"), parse_condition("deflection<0")]
    found = select(conditions, {"time": VALUES, "deflection": -VALUES}, "run.csv")
    assert found.chosen.tolist() == [False, False, False, True, True]
    assert found.words == "time>-2 and deflection<0: 2 of 5 samples"
    with pytest.raises(MeasurementError, match=r"run.csv has no deflection; it has time"):
        select(conditions, {"time": VALUES}, "run.csv")


# ---- over a recording ----------------------------------------------------------------------


@pytest.fixture(scope="module")
def file(frictionless) -> FileComparison:
    known, recording = frictionless
    return compare(known.model, [recording]).files[0]


def test_errors_are_those_of_the_samples_chosen(frictionless, file: FileComparison) -> None:
    known, recording = frictionless
    chosen = compare(known.model, recording, where=["slack_state=III", "time=1..3"]).files[0]
    assert chosen.selection is not None
    mask = chosen.selection.chosen
    error = (file.trajectory[SIGNAL] - recording.signals[SIGNAL])[mask]
    assert set(recording.time[mask] // 1.0) <= {1.0, 2.0, 3.0}
    assert 0 < chosen.signals[SIGNAL].count == len(error) < len(recording.time)
    assert chosen.signals[SIGNAL].rmse == pytest.approx(np.sqrt(np.mean(error**2)))
    assert set(chosen.signals[SIGNAL].slack_states) == {"III"}
    in_window = compare(known.model, recording, where=["time=1..3"]).files[0]
    assert chosen.signals[SIGNAL].count == in_window.signals[SIGNAL].slack_states["III"].count


def test_the_joint_velocity_is_the_measured_one(frictionless, file: FileComparison) -> None:
    """Though the model is off by a third, and noise is larger than a step of the motion."""
    known, recording = frictionless
    true = compare(known.model.with_values(known.truth), [recording]).files[0].trajectory
    found = quantities_of(known.model, file)["joint_velocity"]
    off = np.std(file.trajectory["joint_velocity"] - true["joint_velocity"])
    assert np.std(found - true["joint_velocity"]) < 0.3 * off


def test_tolerances_and_the_json_are_of_the_samples_chosen(frictionless) -> None:
    known, recording = frictionless
    late = compare(known.model, recording, where=["time>=2"])
    (check,) = late.within({SIGNAL: 1e-6})
    assert check.time >= 2.0
    assert check.largest == late.files[0].signals[SIGNAL].max_abs
    location = locate(late)
    (content,) = comparison_json(late, location)["files"]
    assert content["only_where"] == ["time>=2"]
    assert content["signals"][SIGNAL]["count"] < content["samples"] == len(recording.time)
    # where the error lies is told of all samples
    counts = [part.count for part in location.files[0].bins[SIGNAL] if part.by == "slack_state"]
    assert sum(counts) == len(recording.time)
    assert repr(late).splitlines()[0].endswith("beside 1 recording, where time>=2")


def test_recordings_without_such_a_sample_are_left_out(frictionless) -> None:
    known, recording = frictionless
    comparison = compare(known.model, [recording, replace(recording.window(0.0, 1.0), name="a")])
    assert [kept.measurement for kept in only_where(comparison, ["time>2"]).files] == [recording]
    assert only_where(comparison, []) is comparison
    with pytest.raises(MeasurementError, match=rf"no sample of {recording.name}, a meets time>99"):
        only_where(comparison, ["time>99"])
