"""The command in an empty folder, and a recording to give it."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from command_line import MODEL, RATE
from elastic_tendon import cli
from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.simulation.excitation import default_excitation
from elastic_tendon.simulation.simulate import simulate


@pytest.fixture
def run(monkeypatch, tmp_path: Path):
    """Call the command in an empty folder; both streams come back apart."""
    monkeypatch.chdir(tmp_path)
    runner = CliRunner()

    def run(*arguments: str, columns: str = "100"):
        return runner.invoke(cli.app, list(arguments), env={"COLUMNS": columns})

    return run


@pytest.fixture
def recording(tmp_path: Path) -> str:
    """Two seconds of a machine with a heavier link than the model, without noise."""
    model = load_model(MODEL)
    heavier = model.with_values({"link.inertia": 1.1 * model.link.inertia})
    time = np.arange(2 * RATE) / RATE
    motion = 0.3 * np.sin(7.0 * time) * np.minimum(time, 1.0)
    trajectory = simulate(heavier, time, motion)
    columns = {
        "time_s": time,
        "motor_position_rad": motion,
        "joint_position_rad": trajectory["joint_position"].round(6),
    }
    path = tmp_path / "run.csv"
    pd.DataFrame(columns).to_csv(path, index=False)
    return str(path)


@pytest.fixture(scope="session")
def table() -> pd.DataFrame:
    """Ten seconds in which mostly the motor moves the joint, and a small load."""
    model = load_model(MODEL)
    excitation = default_excitation(model)
    inputs = (excitation.motor_position, 0.2 * excitation.load_torque)
    trajectory = simulate(model, excitation.time, *inputs)
    return pd.DataFrame(
        {
            "time_s": excitation.time,
            "motor_position_rad": inputs[0],
            "joint_position_rad": trajectory["joint_position"].round(6),
            "load_torque_Nm": inputs[1],
        }
    )
