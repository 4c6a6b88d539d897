"""Linear models at the interfaces that are driven by a motor torque or by a joint that is given.

The operating point is found at interface position, where its load and motor position are inputs;
there the interface's own equations are derived.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.variables import MOTOR_MOTION
from elastic_tendon.linear.equations import Equations
from elastic_tendon.linear.plant import Regime
from elastic_tendon.linear.result import Array, Drive, Equilibrium, LinearModel

_MOTOR_TORQUE, _MOTOR_VELOCITY = "motor_torque", "motor_velocity"


def at_own_interface(model: Model, found: LinearModel, modes: Mapping[str, int]) -> LinearModel:
    """A linear model of the actuator at interface position, as it is at the model's interface.

    Parameters
    ----------
    model : Model
    found : LinearModel of `Model.at_position` with all inputs and outputs
    modes : to be held, of the rotor: ``motor_motion``, which slides upwards where it is not named

    Returns
    -------
    LinearModel with all inputs and outputs of the interface
    """
    plant = Equations(model)
    at = found.validity.operating_point
    known = {**at.outputs, **at.inputs, **at.states}
    x = np.array([known[name] for name in plant.states])
    u = np.array([known[name] for name in plant.inputs])
    of_rotor = plant.settle(x, u).modes  # of effects that are not there at interface position
    held = {**of_rotor, **found.validity.modes, MOTOR_MOTION.name: 1, **modes}
    regime = Regime(
        found.validity.slack_state, {name: held[name] for name in plant.mode_names}, (x, u)
    )
    if model.kind.has_rotor:
        u[0] = _torque_at_rest(plant, x, u, regime)
    validity = replace(
        found.validity, modes=regime.modes, operating_point=_named(plant, at, x, u, regime)
    )
    sides = tuple(at_own_interface(model, side, modes) for side in found.sides)
    return LinearModel(
        plant.jacobians(x, u, regime),
        *(validity, Drive.TORQUE if model.kind.has_rotor else found.drive, sides),
        states=list(plant.states),
        inputs=list(plant.inputs),
        outputs=list(plant.outputs),
        actuator=found.actuator,
        motion=found.motion,
        name=found.name,
    )


def _torque_at_rest(plant: Equations, x: Array, u: Array, regime: Regime) -> float:
    """Motor torque, N·m, under which the rotor keeps its velocity; that is linear in it."""
    row = plant.states.index(_MOTOR_VELOCITY)
    rate = plant.rates(x, u, regime)[row]
    return float(u[0] - rate / plant.jacobians(x, u, regime).B[row, 0])


def _named(plant: Equations, at: Equilibrium, x: Array, u: Array, regime: Regime) -> Equilibrium:
    """The operating point by the names of both interfaces."""
    outputs = plant.output(x, u, regime)
    return replace(
        at,
        states={**at.states, **dict(zip(plant.states, map(float, x), strict=True))},
        inputs={**at.inputs, **dict(zip(plant.inputs, map(float, u), strict=True))},
        outputs={**at.outputs, **dict(zip(plant.outputs, map(float, outputs), strict=True))},
        modes={**at.modes, **regime.modes},
    )
