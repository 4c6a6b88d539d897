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
    assert [set(file.bins) for file in location.files] == [
        {"joint_position", "joint_torque"},
        {"joint_position"},
    ]
    assert all(set(file.in_words) == set(file.bins) for file in location.files)
    for measurement, located in zip((both, second), location.files, strict=True):
        assert all(len(values) == len(measurement.time) for values in located.variables.values())
        assert len(located.missing_torque.torque) == len(measurement.time)
    shares = [share for _, share in told]
    assert shares == sorted(shares)
    assert 0.0 <= shares[0] <= shares[-1] <= 1.0
    assert any(first.name in text for text, _ in told)
    assert any(second.name in text for text, _ in told)


def test_hidden_friction_stands_out_by_the_direction_of_motion(sticking) -> None:
    known, first, _ = sticking
    located = locate(compare(known.model.with_values({}), [first])).files[0]
    assert any(bin_.stands_out for bin_ in located.bins["joint_position"])
    curve = next(curve for curve in located.missing_torque.curves if curve.by == "joint_velocity")
    assert curve.mean[0] > curve.mean[-1]
    assert curve.mean[0] == pytest.approx(-curve.mean[-1], rel=0.5)
