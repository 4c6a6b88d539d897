"""MAT files come back as they were written."""

from pathlib import Path

import numpy as np
import pytest
from scipy.io import loadmat

from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.linear.linearise import linearise
from elastic_tendon.linear.mat import write_mat
from elastic_tendon.linear.result import Drive, OperatingPoint
from elastic_tendon.output import OutputError

MODEL = load_model("biorob_x4_joint_3").with_effect("overstretch_protection", None)


def test_each_state_is_a_struct_with_matrices_and_names(tmp_path: Path) -> None:
    models = [linearise(MODEL, state, drive=Drive.VELOCITY) for state in ("I", "III", "both")]
    write_mat(MODEL.name, models, tmp_path / "joint.mat")
    found = loadmat(tmp_path / "joint.mat", simplify_cells=True)
    assert found["model"] == MODEL.name
    assert found["drive"] == "velocity"
    for model, name in zip(models, ("state_I", "state_III", "state_both"), strict=True):
        struct = found[name]
        for key in "ABCD":
            assert np.array_equal(struct[key], getattr(model, key))
        assert list(struct["state_names"]) == model.state_labels
        assert list(struct["input_names"]) == model.input_labels
        assert list(struct["output_names"]) == model.output_labels
        assert bool(struct["active"]) is model.validity.active
    at = found["state_I"]["operating_point"]
    assert at["outputs"]["deflection"] == models[0].validity.operating_point.outputs["deflection"]
    assert at["slack_state"] == "I"
    assert found["state_I"]["modes"]["upper_spring_overstretch_protection_engaged"] == 0.0


def test_a_boundary_brings_both_sides(tmp_path: Path) -> None:
    slack = 80.0 / (0.03 * 2 * 11580.0)
    model = linearise(MODEL, "III", OperatingPoint(deflection=slack))
    write_mat(MODEL.name, [model], tmp_path / "joint.mat")
    struct = loadmat(tmp_path / "joint.mat", simplify_cells=True)["state_III"]
    assert struct["on_boundary"]
    assert np.array_equal(struct["below"]["A"], model.sides[0].A)
    assert np.array_equal(struct["above"]["A"], model.sides[1].A)
    assert not np.array_equal(struct["below"]["A"], struct["above"]["A"])


def test_boundaries_are_columns(tmp_path: Path) -> None:
    path = tmp_path / "joint.mat"
    write_mat("joint", [linearise(MODEL, "III")], str(path))
    boundaries = loadmat(path, simplify_cells=True)["state_III"]["boundaries"]
    assert boundaries["torque_margin"] == pytest.approx([-4.8, 4.8])
    assert list(boundaries["switches"]) == ["lower_spring.taut = 0", "upper_spring.taut = 0"]


def test_a_file_is_not_replaced_unasked(tmp_path: Path) -> None:
    path = tmp_path / "joint.mat"
    path.write_text("mine")
    models = [linearise(MODEL, "III")]
    with pytest.raises(OutputError, match="exists already"):
        write_mat("x", models, path)
    assert path.read_text() == "mine"
    write_mat("x", models, path, force=True)
    assert "state_III" in loadmat(path)
