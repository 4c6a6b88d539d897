"""The state at the first sample, estimated on the beginning of a recording."""

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from types import SimpleNamespace
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.transmission import characteristic_stiffness
from elastic_tendon.actuator.variables import interface, moved_states
from elastic_tendon.comparison.residuals import (
    Array,
    InitialState,
    residuals_of,
    sensitivity,
    simulate_measurement,
)
from elastic_tendon.effects.base import Contribution, Slot
from elastic_tendon.errors import SimulationError
from elastic_tendon.measurement import Measurement
from elastic_tendon.native.library import DEFAULT_TOLERANCE

WINDOW = 0.1  # s; held-out data gives its initial state on this stretch and nothing else
MINIMUM_SAMPLES = 5  # for slow recordings, where the window would hold fewer
SETTLING = 10.0  # s in which a joint that is damped critically comes to rest


def estimate_initial_state(
    model: Model, measurement: Measurement, own: Mapping[str, float] | None = None
) -> InitialState:
    """Least squares on the positions of what is moved, joint or motor, over the first 0.1 s.

    Where such a position was not measured, all signals tell, each by its noise, and the start is
    where springs without load would hold it.

    Where the joint's sensor is late these are the first 0.1 s after the delay: before, it shows
    what followed from inputs that were not recorded.

    The start is a parabola through the samples; the model then says which position and velocity
    fit best. Where it cannot tell (a sticking joint hides its velocity) the parabola's answer
    stays. A static curve starts at rest where its first load holds the joint.

    Parameters
    ----------
    model : Model
    measurement : Measurement
    own : what the recording has of its own, see `InitialState`; None: as the model knows it

    Returns
    -------
    InitialState, rad and rad/s

    Raises
    ------
    SimulationError : the solver could not go on
    """
    own = model.own(measurement.recording) if own is None else own
    if own:
        held = InitialState(own=own).model(model)
        return replace(estimate_initial_state(held, measurement, {}), own=own)
    if measurement.static:
        return _equilibrium(model, measurement)
    positions = moved_states(model.kind)[::2]
    if not positions:
        return InitialState()
    beginning, late = _beginning(model, measurement)
    start = np.concatenate([_start(model, beginning, name) for name in positions])
    weights = dict.fromkeys(positions, 1.0)
    if measurement.unmeasured_positions:
        weights = {name: 1.0 / noise.sigma for name, noise in measurement.noise.items()}

    @lru_cache(maxsize=1)  # residuals and derivatives are asked for one after the other
    def evaluate(*x: float) -> tuple[Array, Array]:
        result = sensitivity(model, beginning, InitialState.of(model.kind, x), ())
        return (
            np.concatenate([w * result.residuals[name][late:] for name, w in weights.items()]),
            np.concatenate([w * result.derivatives[name][late:] for name, w in weights.items()]),
        )

    def jacobian(x: Array) -> Array:
        return evaluate(*x)[1]

    def residual(x: Array) -> Array:
        try:
            return evaluate(*x)[0]
        except SimulationError:
            return np.full(len(weights) * (len(beginning.time) - late), np.inf)

    evaluate(*start)  # let a model that cannot be simulated say so itself
    span = float(beginning.time[-1] - beginning.time[0])
    solution = least_squares(
        residual,
        start,
        jac=jacobian,
        # positions and velocities that move joint or motor by like amounts
        x_scale=[1.0, 1.0 / span] * len(positions),
        max_nfev=20,
    )
    return InitialState.of(model.kind, solution.x)


def _start(model: Model, beginning: Measurement, position: str) -> Array:
    """Position and velocity from which the search begins, rad and rad/s."""
    measured = {**beginning.inputs, **beginning.signals}
    if position in measured:
        return _parabola(beginning.time, measured[position])
    (opposite,) = {"joint_position", "motor_position"} - {position}
    if opposite not in measured:
        return np.zeros(2)
    share = model.transmission.motor_share
    ratio = share if position == "joint_position" else 1.0 / share
    return ratio * _parabola(beginning.time, measured[opposite])


def _parabola(time: Array, values: Array) -> Array:
    """Value and rate at the first sample of a parabola through all, the values' unit and per s."""
    elapsed = time - time[0]
    fit = np.polynomial.Polynomial.fit(elapsed, values, 2).convert()
    # a parabola through samples that all agree comes back shorter
    return np.append(fit.coef, [0.0, 0.0])[:2]


def _beginning(model: Model, measurement: Measurement) -> tuple[Measurement, int]:
    """The samples up to the end of the window, and how many of them a delay makes useless."""
    delay = contributed(model, Slot.SIGNAL_DELAY)
    elapsed = measurement.time - measurement.time[0]
    late = int(np.searchsorted(elapsed, delay))
    late = max(min(late, len(elapsed) - MINIMUM_SAMPLES), 0)  # a delay that a fit tries may be any
    count = int(np.searchsorted(elapsed, delay + WINDOW, side="right"))
    return measurement.samples(slice(0, max(count, late + MINIMUM_SAMPLES))), late


def contributed(model: Model, slot: Slot, at: Any = None) -> float:
    """Sum of what the effects of a slot contribute, one whose effects have neither states nor
    modes; `at` : where, in numbers, as the slot says."""
    none, total = SimpleNamespace(), 0.0
    for effect in interface(*model.structure).effects:
        if effect.slot is slot:
            numbers = SimpleNamespace(**model.effects[effect.id])
            contribution = effect.equations(at, numbers, none, none)
            assert isinstance(contribution, Contribution)  # as its slot says
            total += float(contribution.value)
    return total


def residuals_from_beginning(
    model: Model, measurement: Measurement, tolerance: float = DEFAULT_TOLERANCE
) -> dict[str, Array]:
    """Simulated less measured, by signal, from the state that the recording's beginning shows.

    Parameters
    ----------
    model : Model
    measurement : Measurement of n samples
    tolerance : of the solver, see `simulate`

    Returns
    -------
    signal -> (n,) array in its unit

    Raises
    ------
    SimulationError : the solver could not go on
    """
    initial = estimate_initial_state(model, measurement)
    return residuals_of(simulate_measurement(model, measurement, initial, tolerance), measurement)


def _equilibrium(model: Model, measurement: Measurement) -> InitialState:
    """Where the joint comes to rest under the first load, from where it was measured.

    The joint is damped at least critically on the way, which changes nothing of where it rests.
    """
    measured = float(measurement.signals["joint_position"][0])
    if not model.kind.has_springs:  # nothing draws it anywhere
        return InitialState(measured, 0.0)
    stiffness = float(characteristic_stiffness(0.0, model.transmission))
    critical = 2.0 * np.sqrt(model.link.inertia * stiffness)
    damped = model.with_values({"link.damping": max(model.link.damping, critical)})
    held = replace(
        measurement.samples(np.zeros(2, dtype=np.intp)),
        time=measurement.time[0] + np.array([0.0, SETTLING]),
        interpolation="hold",
    )
    settled = simulate_measurement(damped, held, InitialState(measured, 0.0))
    return InitialState(float(settled["joint_position"][-1]), 0.0)
