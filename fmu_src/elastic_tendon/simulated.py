"""Simulated trajectories as tables with the measurement contract's column names.

They are recordings: the motor position is what its encoder reads, and a delay is exact. Beside
what a sensor reads (``measured_...``) stands what is true at the time it reads.
"""

from dataclasses import replace

import pandas as pd

from elastic_tendon.compiled import Trajectory, simulate
from elastic_tendon.excitation import default_excitation
from elastic_tendon.identify.initial_state import estimate_initial_state
from elastic_tendon.identify.residuals import Array, InitialState, simulate_measurement
from elastic_tendon.measurement import Measurement
from elastic_tendon.parameters import Model
from elastic_tendon.variables import INPUTS, interface

SUFFIXES = {"rad": "_rad", "rad/s": "_rad_per_s", "N.m": "_Nm", "N": "_N", "1": ""}


def default_table(model: Model) -> pd.DataFrame:
    """Simulate the default excitation from rest.

    Parameters
    ----------
    model : Model

    Returns
    -------
    DataFrame; SI units, as the columns' suffixes say
    """
    excitation = default_excitation(model)
    inputs = (excitation.motor_position, excitation.load_torque)
    trajectory = simulate(model, excitation.time, *inputs, as_measured=True)
    return _table(model, trajectory, *inputs)


def measured_table(model: Model, measurement: Measurement) -> pd.DataFrame:
    """Simulate the motor motion and load of a measurement, from its `initial_state`.

    Parameters
    ----------
    model : Model
    measurement : Measurement

    Returns
    -------
    DataFrame; SI units, as the columns' suffixes say
    """
    initial = initial_state(model, measurement)
    trajectory = simulate_measurement(model, measurement, initial)
    return _table(model, trajectory, measurement.motor_position, measurement.load_torque)


def initial_state(model: Model, measurement: Measurement) -> InitialState:
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
    if "joint_position" not in measurement.signals:
        # a static curve starts where its first load holds the joint
        ratio = transmission.motor_pulley_radius / transmission.joint_pulley_radius  # 1/n_t, (10)
        unloaded = {"joint_position": ratio * measurement.motor_position}
        started = replace(measurement, signals=unloaded, static=True)
    return estimate_initial_state(model, started)


def _table(
    model: Model, trajectory: Trajectory, motor_position: Array, load_torque: Array | None
) -> pd.DataFrame:
    inputs = {"motor_position": motor_position, "load_torque": load_torque}
    columns = {"time_s": trajectory.time}
    for variable in (*INPUTS, *interface(model.effect_ids).outputs):
        name = variable.name + SUFFIXES[variable.unit]
        if variable.name in trajectory.output_names:
            columns[name] = trajectory[variable.name]
        elif (values := inputs.get(variable.name)) is not None:
            columns[name] = values
    return pd.DataFrame(columns).astype(
        {output.name: int for output in interface(model.effect_ids).outputs if output.discrete}
    )
