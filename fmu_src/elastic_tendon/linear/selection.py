"""Some inputs and outputs of a linear model that has all of them."""

from collections.abc import Sequence

from elastic_tendon.linear.drive import Matrices
from elastic_tendon.linear.result import LinearModel


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
    names = (model.state_labels, model.input_labels, model.output_labels)
    found = Matrices(
        *(model.A, model.B, model.C, model.D), *(tuple(one) for one in names)
    ).selected(inputs, outputs)
    return LinearModel(
        (found.A, found.B, found.C, found.D),
        *(model.validity, model.drive),
        tuple(selected(side, inputs, outputs) for side in model.sides),
        states=list(found.states),
        inputs=list(found.inputs),
        outputs=list(found.outputs),
        name=model.name,
    )
