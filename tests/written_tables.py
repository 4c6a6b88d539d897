"""Tables of recordings, written as files for a reader."""

from pathlib import Path

import numpy as np
import pandas as pd

from elastic_tendon.measurement import Measurement, ReadOptions
from elastic_tendon.measurement.recording import Array


def mapped(*mapping: str) -> ReadOptions:
    """How a file is read with these mappings."""
    return ReadOptions(mapping=mapping)


def signal(time: Array) -> tuple[Array, Array]:
    """Motor and joint position, rad, that differ at all times."""
    return np.sin(3.0 * time), np.sin(3.0 * time + 0.1) + 0.01 * np.sin(71.0 * time)


def table(time: Array, **columns: Array) -> pd.DataFrame:
    """Contract's table over some times."""
    motor, joint = signal(time)
    data = {"time_s": time, "motor_position_rad": motor, "joint_position_rad": joint}
    return pd.DataFrame(data | columns)


def saved(folder: Path, frame: pd.DataFrame, name: str = "run.csv") -> str:
    """Path of the table as CSV."""
    path = folder / name
    frame.to_csv(path, index=False)
    return str(path)


def assert_same_samples(first: Measurement, second: Measurement) -> None:
    """Bit for bit, in every array."""
    assert np.array_equal(first.time, second.time)
    assert np.array_equal(first.motor_position, second.motor_position)
    assert first.signals.keys() == second.signals.keys()
    assert all(np.array_equal(first.signals[name], second.signals[name]) for name in first.signals)
    assert (first.load_torque is None) == (second.load_torque is None)
    if first.load_torque is not None and second.load_torque is not None:
        assert np.array_equal(first.load_torque, second.load_torque)
    assert first.static == second.static
    assert first.preparation == second.preparation


def runs_with_gaps(step: float = 0.01) -> pd.DataFrame:
    """Two runs whose time begins anew, the second with a gap of half a second."""
    time = step * np.arange(200) + 0.003
    late = np.where(np.arange(200) < 80, time, time + 0.5)
    frame = pd.concat([table(time, run=1 + 0 * time), table(late, run=2 + 0 * time)])
    frame["load_torque_mNm"] = np.linspace(0.0, 70.0, len(frame))
    return frame
