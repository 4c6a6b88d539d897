"""Accuracy of the solver against closed forms, itself and differences; prints one table.

    python build_scripts/benchmark_accuracy.py

The functions return figures; tests assert on them.
"""

import sys
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from benchmarking import at_least, at_most, print_table
from elastic_tendon.actuator.parameters import Model, load_model
from elastic_tendon.simulation.simulate import Trajectory, sensitivities, simulate

Array = NDArray[np.float64]

RELEASED_AT = -0.3  # rad, well inside slack state I of the BioRob joint


def _actuator(damping: float = 0.0) -> Model:
    return load_model("biorob_x4_joint_3").with_values({"link.damping": damping})


def _released(model: Model, time: Array, tolerance: float) -> Trajectory:
    """Undriven motion after a release at rest from slack."""
    start = {"joint_position": RELEASED_AT}
    still = np.zeros_like(time)
    return simulate(
        model, time, still, initial_state=start, interpolation="hold", tolerance=tolerance
    )


def slack_crossing_error(tolerance: float = 1e-8) -> float:
    """Error of the first slack crossing, s, against the closed form.

    In state I the joint oscillates about F_p / (R k) with the stiffness R^2 k of one spring,
    (19); the lower tendon is taut again at q = -F_p / (R k), (13).
    """
    model = _actuator()
    radius = model.transmission.joint_pulley_radius
    stiffness = model.transmission.upper_spring.stiffness * model.transmission.upper_spring.parallel
    centre = model.transmission.pretension_force / (radius * stiffness)
    frequency = np.sqrt(radius**2 * stiffness / model.link.inertia)
    exact = np.arccos(-2 * centre / (RELEASED_AT - centre)) / frequency
    located = _released(model, np.array([0.0, 0.05]), tolerance).event_times[0]
    return float(abs(located - exact))


def energy_drift(tolerance: float = 1e-10, duration: float = 100.0) -> float:
    """Relative change of the energy of the undamped actuator over `duration` s through slack."""
    model = _actuator()
    motion = _released(model, np.array([0.0, duration]), tolerance)
    springs = (model.transmission.upper_spring, model.transmission.lower_spring)
    energy = 0.5 * model.link.inertia * motion["joint_velocity"] ** 2
    for spring, force in zip(springs, ("upper_spring_force", "lower_spring_force"), strict=True):
        energy += 0.5 * motion[force] ** 2 / (spring.stiffness * spring.parallel)
    return float(abs(energy[-1] / energy[0] - 1))


def explicit_order(start: float) -> float:
    """Observed order of Dormand-Prince, by halving a fixed step.

    Samples so dense that they limit the step fix it. `start` is the angle of release, rad: inside
    the taut range the motion is smooth, outside it passes through slack.
    """
    model = _actuator()

    def end(steps: int, tolerance: float) -> float:
        time = np.linspace(0.0, 0.15, steps + 1)
        still = np.zeros_like(time)
        motion = simulate(
            model,
            time,
            still,
            initial_state={"joint_position": start},
            interpolation="hold",
            tolerance=tolerance,
        )
        return float(motion["joint_position"][-1])

    exact = end(1, 1e-13)
    errors = [abs(end(steps, 1e-2) - exact) for steps in (40, 80)]
    return float(np.log2(errors[0] / errors[1]))


def implicit_order(damping: float = 1000.0) -> float:
    """Observed order of Radau on the stiff overdamped joint: error against number of steps.

    Closed form of the release from inside the taut range; its two rates differ by a factor of
    8e5 at 1000 N·m·s/rad.
    """
    model = _actuator(damping)
    springs = (model.transmission.upper_spring, model.transmission.lower_spring)
    stiffness = model.transmission.joint_pulley_radius**2 * sum(
        spring.stiffness * spring.parallel for spring in springs
    )
    root = np.sqrt(damping**2 - 4 * stiffness * model.link.inertia)
    slow, fast = -2 * stiffness / (damping + root), -(damping + root) / (2 * model.link.inertia)
    time, release = np.array([0.0, 2 * damping / stiffness]), 0.1
    decay = fast * np.exp(slow * time[1]) - slow * np.exp(fast * time[1])
    exact = release * decay / (fast - slow)
    errors, steps = [], []
    for tolerance in (1e-6, 1e-10):
        motion = simulate(
            model,
            time,
            np.zeros_like(time),
            initial_state={"joint_position": release},
            interpolation="hold",
            tolerance=tolerance,
        )
        errors.append(abs(motion["joint_position"][-1] - exact))
        steps.append(motion.statistics["implicit_steps"])
    return float(np.log(errors[0] / errors[1]) / np.log(steps[1] / steps[0]))


def sensitivity_error(effects: dict[str, dict[str, float]], tolerance: float = 1e-10) -> float:
    """Largest relative difference between sensitivities and central differences.

    Over all parameters on which the joint position depends and both initial states; 3 s of
    motion and load through slack (and, with effects, sticking and engagement).
    """
    model = load_model("biorob_x4_joint_3").with_values(
        {"transmission.upper_spring.damping": 2.0, "transmission.lower_spring.damping": 1.0}
    )
    for effect_id, numbers in effects.items():
        model = model.with_effect(effect_id, numbers)
    time = np.arange(0.0, 3.0, 0.002)
    motor, load = 0.5 * np.sin(2 * np.pi * 1.1 * time), 2.0 * np.sin(3.0 * time)
    start = {"joint_position": 0.3, "joint_velocity": 0.1}
    paths = [quantity.path for quantity in model.quantities() if not quantity.integer]
    exact = sensitivities(
        model,
        time,
        motor,
        load,
        parameters=paths,
        initial_states=tuple(start),
        initial_state=start,
        tolerance=tolerance,
    ).of("joint_position")

    def position(name: str, value: float) -> Array:
        varied = model.with_values({name: value}) if name in paths else model
        begin = start | ({name: value} if name in start else {})
        return simulate(varied, time, motor, load, initial_state=begin, tolerance=1e-12)[
            "joint_position"
        ]

    values = model.values() | start
    errors = []
    for column, name in zip(exact.T, (*paths, *start), strict=True):
        norm = float(np.linalg.norm(column))
        if norm * abs(values[name]) < 1e-9:
            continue  # max_deflection: no influence without overstretch protection
        difference = _best_difference(position, name, values[name], column)
        errors.append(difference / norm)
    return max(errors)


def _best_difference(
    position: object, name: str, value: float, exact: Array, steps: Sequence[float] = (1e-4, 1e-5)
) -> float:
    """Distance to the central difference, for the better of a few step sizes."""
    assert callable(position)
    distances = []
    for step in steps:
        delta = step * value
        difference = (position(name, value + delta) - position(name, value - delta)) / (2 * delta)
        distances.append(float(np.linalg.norm(difference - exact)))
    return min(distances)


FRICTION = {"coulomb_friction": {"torque": 0.35}}
PROTECTION = {"overstretch_protection": {"engagement": 0.5, "stiffness": 20000.0}}


def main() -> int:
    """Print the table; exit status."""
    rows = [
        at_most("slack crossing against the closed form", slack_crossing_error(), 1e-9, "s"),
        at_most("energy drift, 100 s undamped at 1e-10", energy_drift(), 1e-7),
        at_least("order, smooth (designed: 5)", explicit_order(0.1), 4.7),
        at_least("order, through slack events (designed: 5)", explicit_order(-0.3), 4.7),
        at_least("order, stiff, Radau (designed: 5)", implicit_order(), 4.7),
        at_most("sensitivities, smooth forces, through slack", sensitivity_error({}), 1e-5),
        at_most("sensitivities, through stick-slip", sensitivity_error(FRICTION), 1e-5),
        at_most(
            "sensitivities, stick-slip and protection",
            sensitivity_error(FRICTION | PROTECTION),
            1e-5,
        ),
    ]
    return print_table("Accuracy", rows)


if __name__ == "__main__":
    sys.exit(main())
