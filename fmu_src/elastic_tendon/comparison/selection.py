"""A comparison over those samples only for which conditions hold; the simulation is the same."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.comparison.comparison import (
    Comparison,
    FileComparison,
    deflection_measured,
    signal_error,
    slack_states_measured,
)
from elastic_tendon.comparison.conditions import (
    STATE,
    Condition,
    Selection,
    in_words,
    parse_condition,
    select,
)
from elastic_tendon.comparison.correlations import motor_derivative
from elastic_tendon.comparison.missing_torque import joint_velocity_measured
from elastic_tendon.comparison.residuals import Array, residuals_of
from elastic_tendon.errors import MeasurementError


def quantities_of(model: Model, file: FileComparison) -> dict[str, Array]:
    """What conditions can be on, as it was measured: (n,) arrays by name, SI.

    A static curve has neither time nor velocities, and what was not recorded is left out.

    Parameters
    ----------
    model : Model
    file : FileComparison of the same model
    """
    measurement = file.measurement
    found = {"time": measurement.time} if not measurement.static else {}
    if model.kind.has_springs:
        found |= {
            STATE: slack_states_measured(model, file.trajectory, measurement),
            "deflection": deflection_measured(model, file.trajectory, measurement),
            "motor_position": measurement.motor_position,
        }
    found |= {**measurement.inputs, **measurement.signals}
    if not measurement.static:
        if model.kind.has_springs:
            found["motor_velocity"] = motor_derivative(measurement, 1)
        if "joint_position" in measurement.signals:
            found["joint_velocity"] = joint_velocity_measured(file)
    return found


def selection_of(model: Model, file: FileComparison, conditions: Sequence[Condition]) -> Selection:
    """Samples of a recording for which all conditions hold.

    Raises
    ------
    MeasurementError : a condition is on what the recording does not have
    """
    return select(conditions, quantities_of(model, file), file.measurement.name)


def at(model: Model, file: FileComparison, selection: Selection | None) -> FileComparison:
    """The errors of a recording over the samples that are selected; None: over all."""
    if selection is None and file.selection is None:
        return file
    states = slack_states_measured(model, file.trajectory, file.measurement)
    chosen = np.ones(len(states), np.bool_) if selection is None else selection.chosen
    errors = residuals_of(file.trajectory, file.measurement)
    signals = {
        name: signal_error(
            errors[name][chosen],
            file.measurement.signals[name][chosen],
            states[chosen],
            error.noise,
        )
        for name, error in file.signals.items()
    }
    return replace(file, signals=signals, selection=selection)


def only_where(comparison: Comparison, where: Sequence[str]) -> Comparison:
    """The same comparison over those samples only for which all conditions hold.

    Parameters
    ----------
    comparison : Comparison
    where : conditions as of `conditions.parse_condition`; none: over all samples

    Returns
    -------
    Comparison; recordings without such a sample are left out

    Raises
    ------
    MeasurementError : a condition cannot be read, is on what a recording does not have, or no
        recording has a sample for which all hold
    """
    conditions = [parse_condition(text) for text in where]
    if not conditions:
        return comparison
    model = comparison.model
    selections = [selection_of(model, file, conditions) for file in comparison.files]
    kept = tuple(
        at(model, file, selection)
        for file, selection in zip(comparison.files, selections, strict=True)
        if selection.chosen.any()
    )
    if not kept:
        names = ", ".join(file.measurement.name for file in comparison.files)
        raise MeasurementError(
            f"no sample of {names} meets {in_words(conditions)}; give other conditions"
        )
    return replace(comparison, files=kept)
