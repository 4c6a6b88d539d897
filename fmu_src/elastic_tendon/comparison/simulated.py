"""Simulate recordings; trajectories as tables with the measurement contract's column names.

Tables are recordings: the motor position is what its encoder reads, and a delay is exact. Beside
what a sensor reads (``measured_...``) stands what is true at the time it reads.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import pandas as pd
from numpy.typing import ArrayLike

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.variables import interface
from elastic_tendon.comparison.initial_state import estimate_initial_state
from elastic_tendon.comparison.residuals import Array, InitialState, simulate_measurement
from elastic_tendon.measurement import Measurement
from elastic_tendon.native.interpolation import Interpolation
from elastic_tendon.native.library import DEFAULT_TOLERANCE
from elastic_tendon.simulation.excitation import default_excitation
from elastic_tendon.simulation.simulate import Trajectory, driving_torque, given_names
from elastic_tendon.simulation.simulate import simulate as call

SUFFIXES = {"rad": "_rad", "rad/s": "_rad_per_s", "N.m": "_Nm", "N": "_N", "1": ""}
SUFFIXES |= {"m": "_m", "m/s": "_m_per_s"}


def simulate(
    model: Model,
    time: Measurement | ArrayLike,
    motor_position: ArrayLike | None = None,
    load_torque: ArrayLike | None = None,
    *,
    motor_torque: ArrayLike | None = None,
    joint_position: ArrayLike | None = None,
    initial_state: Mapping[str, float] | None = None,
    interpolation: Interpolation = "linear",
    tolerance: float = DEFAULT_TOLERANCE,
    as_measured: bool = False,
) -> Trajectory:
    """Simulate the motion of a recording, or one that is given, in one call of the library.

    Parameters
    ----------
    model : Model
    time : Measurement, whose inputs are simulated as its sensors show them, from the state at its
        first sample; all other arguments are left out then. Or (n,) array, s; increasing
    motor_position : (n,) array, rad at the motor pulley
    load_torque : (n,) array, N·m on the joint, optional; none acts where it is missing
    motor_torque : (n,) array, N·m at the motor pulley, in place of the motor position where the
        model's interface is torque or torque_joint
    joint_position : (n,) array, rad, in place of the load torque where it is joint or torque_joint
    initial_state : mapping of state names to values, optional; start values where missing
    interpolation : "hold", "linear" or "cubic" (spline) between the samples
    tolerance : relative, and absolute in units of the states' nominals; 1e-14 to 1e-2
    as_measured : for a model with effects on measured signals: `motor_position` is what the
        encoder reads, and outputs of the joint are what is recorded at the sample times, a delay
        late. Before the first sample the inputs are as there. What swings far faster than the
        samples is given up. Else: true angles, no delay

    Returns
    -------
    Trajectory

    Raises
    ------
    SimulationError
        where the solver cannot go on; the message names the time and the reason
    ValueError
        where an argument has the wrong shape or is not finite
    """
    if isinstance(time, Measurement):
        time = time.for_model(model)
        return simulate_measurement(model, time, starting_state(model, time))
    return call(
        *(model, time, motor_position, load_torque),
        motor_torque=motor_torque,
        joint_position=joint_position,
        initial_state=initial_state,
        interpolation=interpolation,
        tolerance=tolerance,
        as_measured=as_measured,
    )


def default_table(model: Model) -> pd.DataFrame:
    """Simulate the default excitation from rest.

    Parameters
    ----------
    model : Model

    Returns
    -------
    DataFrame; SI units, as the columns' suffixes say
    """
    time, inputs = default_inputs(model)
    trajectory = call(model, time, as_measured=True, **inputs)
    return _table(model, trajectory, inputs)


def default_inputs(model: Model) -> tuple[Array, dict[str, Any]]:
    """Time (n,), s, of the default excitation, and what drives the model then, (n,) by name.

    Where the joint is given it moves as the model's own link would, a motor torque moves the rotor
    as the motor is to move.
    """
    excitation = default_excitation(model)
    position = model.at_position()
    inputs: dict[str, Any] = {
        "motor_position": excitation.motor_position,
        "load_torque": excitation.load_torque,
    }
    if position.kind is not model.kind:
        moved = call(position, excitation.time, **inputs)
        torque = driving_torque(model, excitation.time, excitation.motor_position, moved)
        inputs |= {"joint_position": moved["joint_position"], "motor_torque": torque}
    return excitation.time, {name: inputs.get(name) for name in given_names(model)}


def measured_table(model: Model, measurement: Measurement) -> pd.DataFrame:
    """Simulate the inputs of a measurement, from its `starting_state`.

    Parameters
    ----------
    model : Model
    measurement : Measurement

    Returns
    -------
    DataFrame; SI units, as the columns' suffixes say
    """
    measurement = measurement.for_model(model)
    initial = starting_state(model, measurement)
    trajectory = simulate_measurement(model, measurement, initial)
    return _table(model, trajectory, measurement.inputs)


def starting_state(model: Model, measurement: Measurement) -> InitialState:
    """State of the joint at the first sample, also where its position was not measured.

    Estimated on the first 0.1 s; where the joint was not measured it is at rest in equilibrium
    under the first load.

    Parameters
    ----------
    model : Model
    measurement : Measurement

    Returns
    -------
    InitialState, rad and rad/s

    Raises
    ------
    SimulationError : the solver could not go on
    """
    transmission = model.transmission
    started = measurement
    if model.kind.has_link and "joint_position" not in measurement.signals:
        # a static curve starts where its first load holds the joint
        ratio = transmission.motor_share
        unloaded = {"joint_position": ratio * measurement.motor_position}
        started = replace(measurement, signals=unloaded, static=True)
    return estimate_initial_state(model, started)


def _table(
    model: Model, trajectory: Trajectory, inputs: Mapping[str, Array | None]
) -> pd.DataFrame:
    columns = {"time_s": trajectory.time}
    variables = interface(*model.structure)
    for variable in (*variables.inputs, *variables.outputs):
        name = variable.name + SUFFIXES[model.motion.unit(variable.unit)]
        if variable.name in trajectory.output_names:
            columns[name] = trajectory[variable.name]
        elif (values := inputs.get(variable.name)) is not None:
            columns[name] = values
    return pd.DataFrame(columns).astype(
        {output.name: int for output in variables.outputs if output.discrete}
    )
