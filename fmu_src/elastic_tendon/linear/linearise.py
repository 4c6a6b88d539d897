"""Linear models of an actuator around each stiffness state.

`linearise` for a model, by its equations; for an FMU see `linear.fmu`.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from elastic_tendon.actuator import transmission
from elastic_tendon.actuator.interfaces import WITH_SPRINGS, InterfaceKind
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.sections import Motor
from elastic_tendon.actuator.transmission import SlackState
from elastic_tendon.actuator.variables import INPUTS, JOINT_MOTION, MOTOR_MOTION
from elastic_tendon.errors import LinearisationError
from elastic_tendon.linear.boundaries import REACH, boundaries, sides, switches
from elastic_tendon.linear.drive import completed, driven, driven_by_source
from elastic_tendon.linear.equations import Equations
from elastic_tendon.linear.equilibrium import (
    JOINT_VELOCITY,
    Point,
    deflection_range,
    deflection_span,
    equilibrium,
)
from elastic_tendon.linear.interfaces import at_own_interface
from elastic_tendon.linear.names import slack_state
from elastic_tendon.linear.plant import Plant, Regime
from elastic_tendon.linear.result import (
    Array,
    Boundary,
    Drive,
    Equilibrium,
    LinearModel,
    OperatingPoint,
    Validity,
)
from elastic_tendon.linear.selection import selected

_POINTS = 121  # looked at in search of a regime


def linearise(
    model: Model,
    state: SlackState | str,
    operating_point: OperatingPoint | None = None,
    *,
    drive: Drive = Drive.SOURCE,
    inputs: Sequence[str] | None = None,
    outputs: Sequence[str] | None = None,
    modes: Mapping[str, int] | None = None,
) -> LinearModel:
    """Linear model in a slack state, with the regimes of effects that are active or chosen.

    At interface torque it has the rotor, at interface joint it is what the joint feels of the
    actuator: its torque by the joint's position and velocity.

    Without effects it has the stiffness and damping of (19), (20), (23) and (25). Dry friction of
    the joint slides unless `modes` says ``{"joint_motion": 0}``: to a small motion it is constant.

    Parameters
    ----------
    model : Model
    state : "I", "II", "III", "both" or a SlackState
    operating_point : where to linearise; None: at rest without load if the state is active there,
        else near the middle of the deflections, or joint positions, at which state and modes
        are active
    drive : what moves the motor, at interface position; `Drive.TORQUE` needs [motor] in model.toml
    inputs, outputs : names in the order wanted; None: all that the drive has
    modes : modes of effects to hold, by name, where others than those active are wanted

    Returns
    -------
    LinearModel, a `control.StateSpace` in SI units. Its `validity` says where it lies, whether the
    state is active there and how far the next boundary is; on one, `sides` are both models

    Raises
    ------
    LinearisationError
        where there is no such equilibrium, name or motor
    """
    if not isinstance(model, Model):
        raise LinearisationError(
            f"{model}: linearise takes a model, as load_model reads it; linearise_fmu takes the "
            "path of an FMU"
        )
    model.check_interface("a linear model", WITH_SPRINGS)
    if model.kind is not InterfaceKind.POSITION:
        return _at_interface(model, state, operating_point, drive, inputs, outputs, modes or {})
    if not model.transmission.slack and slack_state(state) is not SlackState.III:
        raise LinearisationError(
            f"{model.name}: its springs push too (slack = 0 in [transmission]), so no tendon is "
            "ever slack; linearise in state III"
        )
    plant = Equations(model)
    chosen = plant.chosen(slack_state(state), modes or {})
    sought = {name: mode for name, mode in chosen.items() if name != JOINT_MOTION.name}
    point = operating_point_of(
        plant, operating_point, lambda regime: sought.items() <= regime.modes.items()
    )
    regime = plant.holding(moving(plant, point, point.regime), chosen)
    active = plant.holds(point.x, point.u, regime)
    whole = linear_model(plant, point, regime, active, drive, model.motor)
    return selected(whole, inputs, outputs)


def _at_interface(
    model: Model,
    state: SlackState | str,
    operating_point: OperatingPoint | None,
    drive: Drive,
    inputs: Sequence[str] | None,
    outputs: Sequence[str] | None,
    modes: Mapping[str, int],
) -> LinearModel:
    """`linearise` at another interface than position, which says what drives the motor."""
    if drive is not Drive.SOURCE:
        raise LinearisationError(
            f"{model.name}: at interface {model.kind} the motor is driven as the interface says; "
            f"leave the drive {drive.value} out, or linearise at interface position"
        )
    of_rotor = {name: mode for name, mode in modes.items() if name == MOTOR_MOTION.name}
    others = {name: mode for name, mode in modes.items() if name not in of_rotor}
    found = linearise(model.at_position(), state, operating_point, modes=others)
    return selected(at_own_interface(model, found, of_rotor), inputs, outputs)


def operating_point_of(
    plant: Plant, asked: OperatingPoint | None, is_sought: Callable[[Regime], bool]
) -> Point:
    """The equilibrium asked for; without one, where the regime sought is active.

    Raises
    ------
    LinearisationError
        where there is no such equilibrium
    """
    if asked is not None:
        return equilibrium(plant, asked)
    unloaded = equilibrium(plant, OperatingPoint())
    if is_sought(unloaded.regime):
        return unloaded
    for path in _paths(plant):
        if (deflection := _middle_of_longest(plant, path, unloaded, is_sought)) is not None:
            return deflection
    return unloaded


def linear_model(
    plant: Plant, point: Point, regime: Regime, active: bool, drive: Drive, motor: Motor | None
) -> LinearModel:
    """Linear model at a point in a regime, with those of both sides where it is on a boundary.

    It has all inputs and outputs of its drive.

    Parameters
    ----------
    plant : Plant
    point : Point
    regime : to be held
    active : whether it is active at the point
    drive : what moves the motor
    motor : the rotor of Drive.TORQUE
    """
    beside = sides(plant, point)
    neighbours = boundaries(plant, point, beside)
    at = _equilibrium(plant, point)

    def made(regime: Regime, active: bool, sides: tuple[LinearModel, ...] = ()) -> LinearModel:
        jacobians = plant.jacobians(point.x, point.u, regime)
        source = driven_by_source(jacobians, plant.states, plant.outputs)
        matrices = driven(source, drive, motor, plant.name)
        within = _around(neighbours, regime, beside)
        here = completed(at, matrices, source, motor)
        validity = Validity(regime.slack_state, regime.modes, active, here, within)
        return LinearModel(
            (matrices.A, matrices.B, matrices.C, matrices.D),
            *(validity, drive, sides),
            states=list(matrices.states),
            inputs=list(matrices.inputs),
            outputs=list(matrices.outputs),
            actuator=plant.name,
            motion=plant.motion,
            name=regime.slack_state.name,
        )

    if not switches(beside[0].regime, beside[1].regime):
        return made(regime, active)
    motion = regime.modes.get(JOINT_MOTION.name, 1)
    one_sided = tuple(made(plant.sliding(side.regime, motion), True) for side in beside)
    active = any(not switches(side.regime, regime) for side in beside)
    return made(regime, active, one_sided)


def _around(
    neighbours: tuple[Boundary, ...], regime: Regime, beside: tuple[Point, Point]
) -> tuple[Boundary, ...]:
    """Boundaries as a regime sees them: that of one side of a boundary ends there."""
    low, high = (side.regime for side in beside)
    if not switches(low, high):
        return neighbours
    if not switches(low, regime):
        return tuple(boundary for boundary in neighbours if boundary.deflection_margin <= 0.0)
    if not switches(high, regime):
        return tuple(
            boundary
            if boundary.deflection_margin or boundary.torque_margin
            else replace(boundary, switches=switches(high, low), slack_state=low.slack_state)
            for boundary in neighbours
            if boundary.deflection_margin >= 0.0
        )
    return neighbours


def _equilibrium(plant: Plant, point: Point) -> Equilibrium:
    def named(names: Iterable[str], values: Array) -> dict[str, float]:
        return dict(zip(names, map(float, values), strict=True))

    return Equilibrium(
        named(plant.states, point.x),
        named((variable.name for variable in INPUTS), point.u),
        named(plant.outputs, plant.output(point.x, point.u, point.regime)),
        point.regime.slack_state,
        point.regime.modes,
    )


def moving(plant: Plant, point: Point, regime: Regime) -> Regime:
    """The regime with the joint sliding: as it moves at a point, at rest upwards."""
    return plant.sliding(regime, -1 if point.x[JOINT_VELOCITY] < 0.0 else 1)


def _paths(plant: Plant) -> Iterator[list[OperatingPoint]]:
    """Where a regime is looked for: deflections borne, those beyond, positions of the joint."""
    low, high = deflection_range(plant)
    further = REACH * deflection_span(plant)
    borne = transmission.deflection_limits(plant.transmission)
    for ends in (borne, (low - further, high + further)):
        deflections = np.linspace(*ends, _POINTS)
        yield [
            OperatingPoint(motor_position=0.0, deflection=float(deflection))
            for deflection in deflections
        ]
    positions = np.linspace(-np.pi, np.pi, _POINTS)
    yield [OperatingPoint(joint_position=float(position), deflection=0.0) for position in positions]


def _middle_of_longest(
    plant: Plant, path: list[OperatingPoint], near: Point, is_sought: Callable[[Regime], bool]
) -> Point | None:
    """The point in the middle of the longest stretch of a path with the regime sought."""
    longest: list[Point] = []
    run: list[Point] = []
    for asked in path:
        try:
            point = equilibrium(plant, asked, near)
        except LinearisationError:
            run = []
            continue
        run = [*run, point] if is_sought(point.regime) else []
        longest = max(longest, run, key=len)
    return longest[len(longest) // 2] if longest else None
