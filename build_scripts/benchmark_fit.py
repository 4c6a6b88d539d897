"""Derivatives, a fit and a diagnosis, beside what finite differences and scipy need for them.

    python build_scripts/benchmark_fit.py

Sensitivities to all parameters are set against central differences of `simulate` at the same
tolerance, with the step that serves these best. The peer of the fit minimises the same sum of
squares from the same start with `scipy.optimize.least_squares` and its finite differences, over
`solve_ivp` on a right-hand side in plain Python; it is given the sigmas that the fit has found.
"""

import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.optimize import least_squares

from benchmark_simulate import RATE, motor_motion, python_rates, scipy_run
from benchmarking import Array, Row, at_least, at_most, in_turn, print_table, seconds, spoken
from elastic_tendon import demo
from elastic_tendon.actuator.parameters import Model, load_model, quantities
from elastic_tendon.estimation.fit import FitResult, fit
from elastic_tendon.measurement import Measurement, read_measurement
from elastic_tendon.native.library import DEFAULT_TOLERANCE
from elastic_tendon.simulation.simulate import sensitivities, simulate

MODEL = "biorob_x4_joint_3"
STEPS = (1e-3, 1e-4, 1e-5, 1e-6)  # of central differences, relative to the number
INFLUENCE = 1e-9  # rad for a change of 100 %, below which a number has none
# of a fit: without a known load, stiffnesses and inertia could grow together, and finite
# differences would lose their way in that valley
FREE = ("transmission.pretension_force", "link.inertia", "link.damping")
OTHER_MACHINE = (1.1, 1.15, 0.8)  # times the model's parameters
NOISE = 5e-4  # rad
# of the peer: the least effort of those tried that finds the same optimum
METHOD, TOLERANCE, DIFFERENCE = "LSODA", 1e-7, 1e-3
STATE_SCALES = (0.1, 1.0)  # rad and rad/s


def silent(_text: str, _share: float) -> None:
    """Progress that nobody asked for."""


# ---- sensitivities -------------------------------------------------------------------------------


@dataclass(frozen=True)
class Derivation:
    """Derivatives of the joint position (n, m) to m parameters of a model, on one motion."""

    model: Model
    time: Array
    motor: Array
    paths: tuple[str, ...]

    def exact(self, tolerance: float) -> Array:
        """By `sensitivities`."""
        run = sensitivities(
            *(self.model, self.time, self.motor), parameters=self.paths, tolerance=tolerance
        )
        return run.of("joint_position")

    def differences(self, tolerance: float, step: float) -> Array:
        """By central differences, two simulations for each number."""
        values = self.model.values()

        def position(path: str, value: float) -> Array:
            varied = self.model.with_values({path: value})
            return simulate(varied, self.time, self.motor, tolerance=tolerance)["joint_position"]

        columns = []
        for path in self.paths:
            delta = step * values[path]
            rise = position(path, values[path] + delta) - position(path, values[path] - delta)
            columns.append(rise / (2 * delta))
        return np.stack(columns, axis=1)


def derivation(duration: float) -> Derivation:
    """All numbers on which the motion depends and that can be varied by a share of themselves."""
    model = load_model(MODEL)
    time, motor = motor_motion(measured=False, duration=duration)
    whole = {quantity.path for quantity in model.quantities() if quantity.integer}
    values = {path: x for path, x in model.values().items() if x and path not in whole}
    every = Derivation(model, time, motor, tuple(values)).exact(DEFAULT_TOLERANCE)
    moved = np.abs(every).max(axis=0) * np.abs(list(values.values())) > INFLUENCE
    paths = tuple(path for path, counts in zip(values, moved, strict=True) if counts)
    return Derivation(model, time, motor, paths)


def largest_error(derivatives: Array, reference: Array) -> float:
    """Largest, over the columns, of the error's norm relative to the column's."""
    error = np.linalg.norm(derivatives - reference, axis=0)
    return float((error / np.linalg.norm(reference, axis=0)).max())


def sensitivity_rows(duration: float = 12.0, repetitions: int = 20) -> list[Row]:
    """Sensitivities against central differences."""
    case = derivation(duration)
    reference = case.exact(1e-13)
    ours = largest_error(case.exact(DEFAULT_TOLERANCE), reference)
    errors = {
        step: largest_error(case.differences(DEFAULT_TOLERANCE, step), reference) for step in STEPS
    }
    step = min(errors, key=errors.__getitem__)
    calls: list[Callable[[], object]] = [
        partial(case.exact, DEFAULT_TOLERANCE),
        partial(case.differences, DEFAULT_TOLERANCE, step),
    ]
    one, other = in_turn(calls, repetitions).min(axis=1)
    name = f"central differences / sensitivities, {len(case.paths)} numbers"
    return [
        at_least(f"{name}: time", other / one, 1.0, "", f"{spoken(other)}; {spoken(one)}"),
        at_least(
            *(f"{name}: error", errors[step] / ours, 1.0, ""),
            f"{errors[step]:.2g} with the best step, {step:g}; {ours:.2g}",
        ),
    ]


# ---- fit -----------------------------------------------------------------------------------------


def recording(model: Model, duration: float) -> Measurement:
    """What a machine with somewhat other numbers shows."""
    time, motor = motor_motion(measured=False, duration=duration)
    values = model.values()
    machine = model.with_values(
        {path: factor * values[path] for path, factor in zip(FREE, OTHER_MACHINE, strict=True)}
    )
    noise = NOISE * np.random.default_rng(5).standard_normal(len(time))
    shown = simulate(machine, time, motor)["joint_position"] + noise
    return Measurement(
        name="another machine",
        time=time,
        motor_position=motor,
        signals={"joint_position": shown},
        load_torque=None,
        interpolation="linear",
    )


@dataclass(frozen=True)
class Peer:
    """The same least squares as a user of scipy would write them.

    Its variables (5,) are the free numbers over their given values, and one more than the initial
    position and velocity over STATE_SCALES; so all begin near one, and a relative step suits them.
    """

    given: Model
    measured: Measurement
    position_sigma: float  # rad

    def values(self, x: Array) -> dict[str, float]:
        """Free numbers by path."""
        given = self.given.values()
        return {path: given[path] * share for path, share in zip(FREE, x.tolist(), strict=False)}

    def initial(self, x: Array) -> Array:
        """Position and velocity, rad and rad/s."""
        return np.asarray((x[len(FREE) :] - 1.0) * np.array(STATE_SCALES))

    def residuals(self, x: Array) -> Array:
        """Whitened errors and prior, (n + 3,)."""
        now = self.measured.time
        model = self.given.with_values(self.values(x))
        rates = python_rates(model, now, self.measured.motor_position, cubic=False)
        shown = scipy_run(rates, now, METHOD, TOLERANCE, self.initial(x).tolist())
        error = (shown - self.measured.signals["joint_position"]) / self.position_sigma
        given = self.given.values()
        prior = [
            (value - given[path]) / self.given.uncertainty_of(path)
            for path, value in self.values(x).items()
        ]
        return np.concatenate([error, prior])

    def fitted(self) -> Array:
        """The optimum, (5,)."""
        start = np.ones(len(FREE) + len(STATE_SCALES))
        start[len(FREE)] += self.measured.signals["joint_position"][0] / STATE_SCALES[0]
        solution = least_squares(
            *(self.residuals, start),
            bounds=self.bounds(),
            diff_step=np.full(len(start), DIFFERENCE),
            x_scale=1.0,
            ftol=1e-8,
        )
        return np.asarray(solution.x)

    def bounds(self) -> tuple[Array, Array]:
        """Lowest and highest variables, from the bounds of the numbers."""
        declared = {quantity.path: quantity for quantity in quantities(self.given.effect_ids)}
        given = self.given.values()
        free = np.full(len(STATE_SCALES), np.inf)
        lower = np.array([declared[path].lower / given[path] for path in FREE])
        upper = np.array([declared[path].upper / given[path] for path in FREE])
        return np.concatenate([lower, -free]), np.concatenate([upper, free])


def cost_under_fit(found: FitResult, peer: Peer, x: Array) -> float:
    """The fit's own cost of the peer's optimum."""
    values = peer.values(x)
    numbers = found.problem.coordinates.variables(
        np.array([values[path] for path in found.problem.coordinates.paths])
    )
    residuals = found.problem.residuals(np.concatenate([numbers, peer.initial(x)]), found.sigmas)
    return 0.5 * float(residuals @ residuals)


def fit_rows(duration: float = 3.0, repetitions: int = 5) -> list[Row]:
    """A fit against `least_squares` with finite differences over `solve_ivp`."""
    model = load_model(MODEL)
    measured = recording(model, duration)
    found = fit(model, [measured], free=FREE)
    ours = in_turn([lambda: fit(model, [measured], free=FREE)], repetitions).min()
    peer = Peer(model, measured, found.sigmas[0]["joint_position"])
    optima = []
    theirs = seconds(lambda: optima.append(peer.fitted()))
    apart = cost_under_fit(found, peer, optima[0]) / found.cost - 1.0
    name = f"{len(measured.time)} samples at {RATE:g} Hz, {len(FREE)} numbers"
    return [
        at_least(
            *(f"least_squares over solve_ivp / fit, {name}", theirs / ours, 1.0, ""),
            f"{spoken(theirs)}; {spoken(ours)}",
        ),
        at_most("relative difference of the costs at the two optima", abs(apart), 1e-4),
    ]


# ---- diagnosis -----------------------------------------------------------------------------------


def demo_rows() -> list[Row]:
    """The diagnosis of the demonstration, beside one fit of the same recording."""
    given = load_model(demo.DATA / "demo_model.toml")
    measured = read_measurement(str(demo.DATA / "demo_fit.csv"))
    demo.run(silent)  # fills the cache, as an earlier call would have
    whole = seconds(lambda: demo.run(silent))
    one = in_turn([lambda: fit(given, [measured])], 3).min()
    return [
        Row("diagnosis of the demonstration", spoken(whole)),
        Row("... / one fit of its recording", f"{whole / one:.3g}", beside=spoken(one)),
    ]


def main() -> int:
    """Print the tables; exit status."""
    return max(
        print_table("Sensitivities of 12 s at 500 Hz", sensitivity_rows()),
        print_table("A fit", fit_rows()),
        print_table("A diagnosis", demo_rows()),
    )


if __name__ == "__main__":
    sys.exit(main())
