"""A recording at a glance: every signal with its unit, thinned, the split marked."""

from pathlib import Path

import numpy as np

from elastic_tendon.measurement import Measurement
from elastic_tendon.measurement.reader import read_measurement
from elastic_tendon.reports.interactive.preview import BUCKETS, preview

TIME = np.arange(50_000) * 1e-3
RECORDING = Measurement(
    name="run",
    time=TIME,
    motor_position=np.sin(TIME),
    signals={"joint_position": np.sin(TIME), "joint_torque": np.cos(TIME)},
)


def test_angles_and_torques_have_axes_of_their_own() -> None:
    figure = preview(RECORDING, split=30.0)
    assert {trace.name: trace.yaxis for trace in figure.data} == {
        "motor position": "y",
        "joint position": "y",
        "joint torque": "y2",
    }
    assert (figure.layout.yaxis.title.text, figure.layout.yaxis2.title.text) == ("rad", "N·m")
    assert all(len(trace.x) <= 2 * BUCKETS + 2 for trace in figure.data)
    assert {shape.x0 for shape in figure.layout.shapes} == {30.0}


def test_a_static_curve_is_torque_over_deflection(tmp_path: Path) -> None:
    path = tmp_path / "curve.csv"
    deflection = np.linspace(-0.1, 0.1, 40)
    rows = "\n".join(f"{angle:.6g},{-40 * angle:.6g}" for angle in deflection)
    path.write_text(f"joint_deflection_rad,joint_torque_Nm\n{rows}\n")
    (drawn,) = preview(read_measurement(str(path))).data
    np.testing.assert_allclose(drawn.y, -40 * np.asarray(drawn.x), atol=1e-4)
