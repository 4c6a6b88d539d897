"""Every file is located, in its order, and progress is told."""

from dataclasses import replace

import pytest

from elastic_tendon.comparison.compare import compare
from elastic_tendon.comparison.locate import locate


def test_every_file_and_signal_is_located(sticking) -> None:
    known, first, second = sticking
    file = compare(known.model, [first]).files[0]
    torque = {"joint_torque": file.trajectory["joint_torque"] + 1e-3 * first.motor_position}
    both = replace(first, signals={**first.signals, **torque})
    told: list[tuple[str, float]] = []
    location = locate(
        compare(known.model, [both, second]), lambda text, share: told.append((text, share))
    )
    assert [set(one.bins) for one in location.files] == [
        {"joint_position", "joint_torque"},
        {"joint_position"},
    ]
    assert all(set(one.in_words) == set(one.bins) for one in location.files)
    for measurement, one in zip((both, second), location.files, strict=True):
        assert all(len(values) == len(measurement.time) for values in one.variables.values())
        assert len(one.missing_torque.torque) == len(measurement.time)
    shares = [share for _, share in told]
    assert shares == sorted(shares)
    assert 0.0 <= shares[0] <= shares[-1] <= 1.0
    assert any(first.name in text for text, _ in told)
    assert any(second.name in text for text, _ in told)


def test_hidden_friction_stands_out_by_the_direction_of_motion(sticking) -> None:
    known, first, _ = sticking
    located = locate(compare(known.model.with_values({}), [first])).files[0]
    assert any(one.stands_out for one in located.bins["joint_position"])
    curve = next(one for one in located.missing_torque.curves if one.by == "joint_velocity")
    assert curve.mean[0] > curve.mean[-1]
    assert curve.mean[0] == pytest.approx(-curve.mean[-1], rel=0.5)
