"""The contract of linear models for programs: matrices, names, where they hold, what they say."""

from collections.abc import Sequence
from math import isfinite
from typing import Any

from elastic_tendon.linear.analysis import Analysis, Channel, Pole, analyse, frequency_span
from elastic_tendon.linear.names import state_name, unit_of
from elastic_tendon.linear.result import Boundary, Equilibrium, LinearModel
from elastic_tendon.linear.selection import selected

SCHEMA = "elastic-tendon/linear/1"


def linear_json(
    name: str,
    models: Sequence[LinearModel],
    *,
    inputs: Sequence[str] | None = None,
    outputs: Sequence[str] | None = None,
) -> dict[str, Any]:
    """Linear models of an actuator as JSON; numbers that are not finite are null.

    Parameters
    ----------
    name : of the actuator
    models : one for each slack state, of one drive, with all inputs and outputs
    inputs, outputs : of the matrices, in this order; None for all. The analysis has all

    Returns
    -------
    dict, to be written by `json.dumps`

    Raises
    ------
    LinearisationError
        for a name that the models do not have
    """
    span = frequency_span([analyse(model) for model in models])
    return {
        "schema": SCHEMA,
        "model": name,
        "drive": models[0].drive.value,
        "models": [_model(model, inputs, outputs) for model in models],
        "frequency_span": span
        and {"lowest": span.lowest, "highest": span.highest, "ratio": span.ratio},
    }


def _model(
    model: LinearModel, inputs: Sequence[str] | None, outputs: Sequence[str] | None
) -> dict[str, Any]:
    wanted, validity = selected(model, inputs, outputs), model.validity
    content: dict[str, Any] = {
        "state": state_name(validity.slack_state),
        "active": validity.active,
        "on_boundary": validity.on_boundary,
        "modes": dict(validity.modes),
        **{key: getattr(wanted, key).tolist() for key in "ABCD"},
        "states": _named(wanted.state_labels),
        "inputs": _named(wanted.input_labels),
        "outputs": _named(wanted.output_labels),
        "operating_point": _equilibrium(validity.operating_point),
        "boundaries": [_boundary(boundary) for boundary in validity.boundaries],
        "analysis": _analysis(analyse(model)),
    }
    if model.sides:
        content["sides"] = [_model(side, inputs, outputs) for side in model.sides]
    return content


def _named(names: Sequence[str]) -> list[dict[str, str | None]]:
    return [{"name": name, "unit": unit_of(name)} for name in names]


def _equilibrium(at: Equilibrium) -> dict[str, Any]:
    return {
        "states": dict(at.states),
        "inputs": dict(at.inputs),
        "outputs": dict(at.outputs),
        "slack_state": state_name(at.slack_state),
        "modes": dict(at.modes),
    }


def _boundary(boundary: Boundary) -> dict[str, Any]:
    return {
        "switches": dict(boundary.switches),
        "slack_state": state_name(boundary.slack_state),
        "deflection": boundary.deflection,
        "load_torque": boundary.load_torque,
        "deflection_margin": boundary.deflection_margin,
        "torque_margin": boundary.torque_margin,
    }


def _analysis(analysis: Analysis) -> dict[str, Any]:
    return {
        "poles": [_pole(pole) for pole in analysis.poles],
        "stiffness": _finite(analysis.stiffness),
        "tendon_stiffness": analysis.tendon_stiffness,
        "tendon_damping": analysis.tendon_damping,
        "channels": [_channel(channel) for channel in analysis.channels],
    }


def _pole(pole: Pole) -> dict[str, Any]:
    return {
        "real": pole.value.real,
        "imaginary": pole.value.imag,
        "natural_frequency": pole.natural_frequency,
        "damping_ratio": pole.damping_ratio,
        "time_constant": None if pole.time_constant is None else _finite(pole.time_constant),
    }


def _channel(channel: Channel) -> dict[str, Any]:
    return {
        "input": channel.input,
        "output": channel.output,
        "gain": _finite(channel.gain),
        "zeros": [{"real": zero.real, "imaginary": zero.imag} for zero in channel.zeros],
        "anti_resonances": list(channel.anti_resonances),
    }


def _finite(value: float) -> float | None:
    return value if isfinite(value) else None
