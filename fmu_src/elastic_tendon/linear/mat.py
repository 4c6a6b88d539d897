"""Linear models as a MAT file, for MATLAB and Octave."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from elastic_tendon.linear.names import state_name
from elastic_tendon.linear.result import Boundary, LinearModel
from elastic_tendon.output import write_file

SIDES = ("below", "above")  # towards negative and towards positive deflection


def write_mat(
    name: str, models: Sequence[LinearModel], path: str | Path, *, force: bool = False
) -> None:
    """Write linear models, of which ``ss(state_I.A, state_I.B, state_I.C, state_I.D)`` makes one.

    The file holds `model`, `drive` and a struct for each slack state: `state_I`, `state_II`,
    `state_III`, `state_both`. In it are A, B, C, D, `state_names`, `input_names` and `output_names`
    (cells), `active`, `on_boundary`, `modes`, `operating_point` and `boundaries`, whose fields have
    a row for each boundary; on a switching boundary also `below` and `above`, the models of both
    sides. SI units. Dots in names of fields become underscores, since MATLAB allows none.

    Parameters
    ----------
    name : of the actuator
    models : one for each slack state, of one drive
    path : file to be written
    force : whether an existing file may be replaced

    Raises
    ------
    OutputError
        where the file cannot be written
    """
    from scipy.io import savemat

    content = {
        "model": name,
        "drive": models[0].drive.value,
        **{f"state_{state_name(model.validity.slack_state)}": _struct(model) for model in models},
    }
    write_file(
        Path(path), lambda target: savemat(target, content, long_field_names=True), force=force
    )


def _struct(model: LinearModel) -> dict[str, Any]:
    validity, at = model.validity, model.validity.operating_point
    return {
        **{key: getattr(model, key) for key in "ABCD"},
        "state_names": _cells(model.state_labels),
        "input_names": _cells(model.input_labels),
        "output_names": _cells(model.output_labels),
        "active": validity.active,
        "on_boundary": validity.on_boundary,
        "modes": _fields(validity.modes),
        "operating_point": {
            "states": _fields(at.states),
            "inputs": _fields(at.inputs),
            "outputs": _fields(at.outputs),
            "modes": _fields(at.modes),
            "slack_state": state_name(at.slack_state),
        },
        "boundaries": _columns(validity.boundaries),
        **{side: _struct(beside) for side, beside in zip(SIDES, model.sides, strict=False)},
    }


def _columns(boundaries: Sequence[Boundary]) -> dict[str, Any]:
    """Columns (n, 1) of the numbers of boundaries, and what switches in words."""
    names = ("deflection", "load_torque", "deflection_margin", "torque_margin")
    numbers = np.array([[getattr(boundary, name) for name in names] for boundary in boundaries])
    columns = dict(zip(names, np.hsplit(numbers.reshape(-1, len(names)), len(names)), strict=True))
    switches = [
        ", ".join(f"{name} = {value}" for name, value in boundary.switches.items())
        for boundary in boundaries
    ]
    return {**columns, "switches": _cells(switches).reshape(-1, 1)}


def _cells(names: Iterable[str]) -> np.ndarray[Any, np.dtype[np.object_]]:
    return np.array(list(names), dtype=object)


def _fields(values: Mapping[str, float]) -> dict[str, float]:
    return {name.replace(".", "_"): float(value) for name, value in values.items()}
