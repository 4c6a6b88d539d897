"""Operating points: where the actuator rests, or moves steadily, under what is given of it.

Of load, motor position and joint position two are given, or the deflection
δ = q − (r / R) eθ, (10) and (11), in place of one. The third follows with all other states from
rates that vanish; sliding friction counts as the mean of both directions, so that a joint at rest
is in the middle of the positions at which it could stick. States that no rate decides (the memory
of a hysteresis) stay as they start.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from elastic_tendon.actuator.transmission import deflection_limits, slack_boundaries
from elastic_tendon.errors import LinearisationError
from elastic_tendon.linear.plant import Plant, Regime
from elastic_tendon.linear.result import Array, OperatingPoint

MOTOR_POSITION, MOTOR_VELOCITY, LOAD_TORQUE = 0, 1, 2  # places among the inputs
JOINT_POSITION, JOINT_VELOCITY = 0, 1  # places among the states
_GIVEN = ("load_torque", "motor_position", "joint_position", "deflection")
_MOST_STEPS = 60
_MOST_HALVINGS = 12
# deflections, in shares of their range, from which a search starts: the joint may be free in a play
_STARTS = (0.0, 0.1, -0.1, 0.3, -0.3, 0.6, -0.6)
_RANK = 1e-12  # singular values below this share of the largest belong to undecided states
_EXACT = 1e-14  # distance from an equilibrium, in units of the nominals, not worth another step
_REST = 1e-9  # such a distance that counts as none at all


@dataclass(frozen=True)
class Point:
    """States (n,) and inputs (3,) at which the rates vanish, and the regime active there."""

    x: Array
    u: Array
    regime: Regime

    @property
    def load_torque(self) -> float:
        """Load, N·m."""
        return float(self.u[LOAD_TORQUE])


def with_defaults(point: OperatingPoint) -> OperatingPoint:
    """The operating point with two of its four positions and torques given.

    Raises
    ------
    LinearisationError
        where more than two are given, or a load and a deflection
    """
    given = _given(point)
    for name, value in {**given, "joint_velocity": point.joint_velocity}.items():
        if not np.isfinite(value):
            raise LinearisationError(f"operating point: {name} is {value}; give a finite number")
    if len(given) > 2:
        raise LinearisationError(
            f"operating point: {', '.join(given)} are given, but two of them settle the rest"
        )
    if given.keys() == {"load_torque", "deflection"}:
        raise LinearisationError(
            "operating point: the deflection follows from the load_torque; give the motor_position "
            "or joint_position with one of them"
        )
    if len(given) < 2 and not given.keys() & {"load_torque", "deflection"}:
        given["load_torque"] = 0.0
    if len(given) < 2:
        given["motor_position"] = 0.0
    return OperatingPoint(**given, joint_velocity=point.joint_velocity)


def equilibrium(plant: Plant, asked: OperatingPoint, near: Point | None = None) -> Point:
    """The operating point that was asked for.

    Parameters
    ----------
    plant : Plant
    asked : OperatingPoint
    near : where to begin the search; None: at rest without load

    Returns
    -------
    Point

    Raises
    ------
    LinearisationError
        where there is none, or more is given than can be
    """
    asked = with_defaults(asked)
    n = len(plant.states)
    for start in _starts(plant, asked, near):
        with np.errstate(over="ignore", invalid="ignore"):  # numbers beyond sense have no rest
            solution, rest = _solved(plant, start, _unknown(asked, n))
        if rest <= _REST:
            return Point(solution[:n], solution[n:], plant.settle(solution[:n], solution[n:]))
    given = ", ".join(f"{name} {value:g}" for name, value in _given(asked).items())
    sought = "equilibrium" if asked.joint_velocity == 0.0 else "steady motion"
    raise LinearisationError(
        f"{plant.name}: no {sought} is found with {given}; give another operating point"
    )


def _solved(plant: Plant, z: Array, unknown: list[int]) -> tuple[Array, float]:
    """States and inputs moved to where the rates vanish, and how far from rest they still are.

    Newton's method with the regime active at each point; undecided states take the shortest step.
    """
    residual, slope = _residual(plant, z, unknown)
    for _ in range(_MOST_STEPS):
        if not np.isfinite(slope).all() or np.abs(residual).max() <= _EXACT:
            break
        step = -np.linalg.lstsq(slope, residual, rcond=_RANK)[0] * _nominal(plant)[unknown]
        for _ in range(_MOST_HALVINGS):
            moved = z.copy()
            moved[unknown] += step
            after, slope_after = _residual(plant, moved, unknown)
            if np.linalg.norm(after) < np.linalg.norm(residual):
                break
            step = 0.5 * step
        else:
            break  # as close as rounding lets it come
        z, residual, slope = moved, after, slope_after
    return z, float(np.abs(residual).max())


def held(plant: Plant, point: Point, deflection: float) -> Point:
    """The point with the motor where it is and the joint at a deflection, rad; load as needed."""
    asked = OperatingPoint(
        motor_position=float(point.u[MOTOR_POSITION]),
        deflection=deflection,
        joint_velocity=float(point.x[JOINT_VELOCITY]),
    )
    return equilibrium(plant, asked, near=point)


def deflection_of(plant: Plant, x: Array, u: Array) -> float:
    """δ = q − (r / R) eθ, (10) and (11), rad."""
    return float(x[JOINT_POSITION] - _ratio(plant) * u[MOTOR_POSITION])


def deflection_range(plant: Plant) -> tuple[float, float]:
    """Deflections that hold what the springs bear, (16), and both slack boundaries, (14), rad."""
    limits = deflection_limits(plant.transmission)
    slack = slack_boundaries(plant.transmission)
    return min(limits[0], slack[0]), max(limits[1], slack[1])


def deflection_span(plant: Plant) -> float:
    """Width of `deflection_range`, rad."""
    low, high = deflection_range(plant)
    return high - low


def _given(asked: OperatingPoint) -> dict[str, float]:
    """What is given of load and positions, by name."""
    return {name: value for name in _GIVEN if (value := getattr(asked, name)) is not None}


def _ratio(plant: Plant) -> float:
    """r / R, by which the motor's position counts at the joint, (10)."""
    return plant.transmission.motor_share


def torque_scale(plant: Plant) -> float:
    """Torque that the weaker spring bears, R F_max,i, (32), N·m."""
    springs = (plant.transmission.upper_spring, plant.transmission.lower_spring)
    return plant.transmission.joint_pulley_radius * min(spring.largest_force for spring in springs)


def _nominal(plant: Plant) -> Array:
    return np.concatenate([plant.nominal, [1.0, 1.0, torque_scale(plant)]])


def _unknown(asked: OperatingPoint, n: int) -> list[int]:
    """Places in states and inputs (n + 3,) of what is sought: one of three, and other states."""
    places = {"joint_position": JOINT_POSITION, "motor_position": n, "load_torque": n + LOAD_TORQUE}
    given = _given(asked)
    if "deflection" in given:  # it settles one position by the other
        return [places["load_torque"], *range(2, n)]
    return [*(place for name, place in places.items() if name not in given), *range(2, n)]


def _starts(plant: Plant, asked: OperatingPoint, near: Point | None) -> Iterator[Array]:
    """States and inputs (n + 3,) with what is given, from which to seek the rest."""
    given = _given(asked)
    ratio = _ratio(plant)
    load = given.get("load_torque", 0.0)
    for share in _STARTS:
        deflection = given.get("deflection", share * deflection_span(plant))
        if "joint_position" in given:
            joint = given["joint_position"]
            motor = given.get("motor_position", (joint - deflection) / ratio)
        else:
            motor = given.get("motor_position", 0.0)
            joint = deflection + ratio * motor
        u = np.array([motor, asked.joint_velocity / ratio, load])
        if near is not None and share == 0.0:
            x = near.x.copy()
            x[JOINT_POSITION] = joint
            u[LOAD_TORQUE] = given.get("load_torque", near.u[LOAD_TORQUE])
        else:
            x = plant.start(u, joint)
        x[JOINT_VELOCITY] = asked.joint_velocity
        yield np.concatenate([x, u])


def _residual(plant: Plant, z: Array, unknown: list[int]) -> tuple[Array, Array]:
    """Rates that must vanish, and their slopes by the unknowns, in units in which both are one.

    The rate of the joint's position is its velocity, which is given.
    """
    n = len(plant.states)
    x, u = z[:n], z[n:]
    regime = plant.settle(x, u)
    velocity = float(x[JOINT_VELOCITY])
    directions = (1, -1) if velocity == 0.0 else (int(np.sign(velocity)),)
    regimes = [plant.sliding(regime, direction) for direction in directions]
    if regimes[0] is regimes[-1]:
        regimes = regimes[:1]
    rates = np.mean([plant.rates(x, u, settled) for settled in regimes], axis=0)[1:]
    both = [plant.jacobians(x, u, settled) for settled in regimes]
    slope = np.mean([np.hstack([jacobians.A, jacobians.B]) for jacobians in both], axis=0)[
        1:, unknown
    ]
    slope = slope * _nominal(plant)[unknown]
    size = np.linalg.norm(slope, axis=1)
    size[size == 0.0] = 1.0  # of a state that no rate decides
    return rates / size, slope / size[:, None]
