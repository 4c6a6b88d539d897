"""Some inputs and outputs of a linear model that has all of them."""

from collections.abc import Sequence

import numpy as np

from elastic_tendon.actuator.variables import OUTPUTS
from elastic_tendon.errors import LinearisationError
from elastic_tendon.linear.result import Drive, LinearModel


def selected(
    model: LinearModel, inputs: Sequence[str] | None, outputs: Sequence[str] | None
) -> LinearModel:
    """A linear model, and those of both sides, with some inputs and outputs in the order given.

    Parameters
    ----------
    model : LinearModel
    inputs, outputs : names; None for all

    Raises
    ------
    LinearisationError
        for a name that the model does not have, or that stands twice
    """
    if inputs is None and outputs is None:
        return model
    columns = _places(model, "input", model.input_labels, inputs)
    rows = _places(model, "output", model.output_labels, outputs)
    return LinearModel(
        (model.A, model.B[:, columns], model.C[rows], model.D[np.ix_(rows, columns)]),
        *(model.validity, model.drive),
        tuple(selected(side, inputs, outputs) for side in model.sides),
        states=model.state_labels,
        inputs=[model.input_labels[i] for i in columns],
        outputs=[model.output_labels[i] for i in rows],
        actuator=model.actuator,
        motion=model.motion,
        whole=model.whole,
        name=model.name,
    )


def _places(
    model: LinearModel, kind: str, names: Sequence[str], chosen: Sequence[str] | None
) -> list[int]:
    if chosen is None:
        return list(range(len(names)))
    for name in chosen:
        if name not in names:
            raise LinearisationError(_why_not(model, kind, names, name))
        if list(chosen).count(name) > 1:
            raise LinearisationError(f"the {kind} {name} stands twice")
    return [names.index(name) for name in chosen]


def _why_not(model: LinearModel, kind: str, names: Sequence[str], name: str) -> str:
    improper = {variable.name for variable in OUTPUTS if not variable.discrete}
    if kind == "output" and model.drive is Drive.POSITION and name in improper:
        return (
            f"{name} of damped springs needs the motor's velocity, which is no signal of a motor "
            "driven by position; take another drive, as velocity or source"
        )
    return f"there is no {kind} {name!r} with this drive; there are {', '.join(names)}"
