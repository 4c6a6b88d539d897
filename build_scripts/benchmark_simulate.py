"""Speed of `simulate` against scipy's solve_ivp at equal error, as ratios of one run.

    python build_scripts/benchmark_simulate.py

12 s of motor position sampled at 500 Hz, with the rounding of a 14-bit encoder ("measured") and
without ("smooth"). Scipy gets a right-hand side in plain Python floats, the fastest form it can
call, and every method and tolerance that might win. On both sides the fastest run whose largest
error is at most 1e-7 rad counts.
"""

import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

from benchmarking import Row, at_least, at_most, fastest, print_table, spoken
from elastic_tendon.actuator.model import build
from elastic_tendon.actuator.parameters import Model, load_model
from elastic_tendon.native import compiler
from elastic_tendon.native.binary import write_model
from elastic_tendon.native.interpolation import Interpolation
from elastic_tendon.native.library import DEFAULT_TOLERANCE
from elastic_tendon.simulation.simulate import simulate

Array = NDArray[np.float64]
Rates = Callable[[float, list[float]], list[float]]

RATE = 500.0  # Hz
ERROR = 1e-7  # rad
ENCODER_STEP = 2 * np.pi / 2**14  # rad
OUR_TOLERANCES = (DEFAULT_TOLERANCE, 1e-7, 1e-6, 1e-5)
CANDIDATES = [
    *(("LSODA", tolerance) for tolerance in (1e-7, 3e-8, 1e-8, 3e-9, 1e-9)),
    *(("RK45", tolerance) for tolerance in (1e-7, 1e-8, 1e-9)),
    *(("DOP853", tolerance) for tolerance in (1e-6, 1e-7, 1e-8)),
]


@dataclass(frozen=True)
class Run:
    """The fastest run of one side that is accurate enough: its time (s), error (rad), settings."""

    seconds: float
    error: float
    method: str
    tolerance: float


def motor_motion(measured: bool, duration: float = 12.0) -> tuple[Array, Array]:
    """Time (s) and motor position (rad): two sines through slack."""
    time = np.arange(int(duration * RATE) + 1) / RATE
    position = 0.3 * np.sin(2 * np.pi * 0.7 * time) + 0.2 * np.sin(2 * np.pi * 2.3 * time)
    if measured:
        position = np.round(position / ENCODER_STEP) * ENCODER_STEP
    return time, position


def python_rates(model: Model, time: Array, position: Array, cubic: bool) -> Rates:
    """The same equations as a user of scipy would write them for speed."""
    t = model.transmission
    radius, inertia, damping = t.joint_pulley_radius, model.link.inertia, model.link.damping
    stiff_above, stiff_below = (s.stiffness * s.parallel for s in (t.upper_spring, t.lower_spring))
    rest_above, rest_below = t.pretension_force / stiff_above, t.pretension_force / stiff_below
    last = time.size - 2
    if cubic:
        rows = [tuple(row) for row in CubicSpline(time, position).c[::-1].T.tolist()]
    else:
        slopes = np.diff(position) * RATE
        rows = [
            (a, b, 0.0, 0.0) for a, b in zip(position[:-1].tolist(), slopes.tolist(), strict=True)
        ]

    def rates(now: float, state: list[float]) -> list[float]:
        i = min(int(now * RATE), last)
        since = now - i / RATE
        a, b, c, d = rows[i]
        motor = a + since * (b + since * (c + since * d)) if cubic else a + since * b
        angle, velocity = state
        stretch = radius * (angle - motor)
        above, below = stiff_above * (rest_above - stretch), stiff_below * (rest_below + stretch)
        torque = radius * ((above if above > 0.0 else 0.0) - (below if below > 0.0 else 0.0))
        return [velocity, (torque - damping * velocity) / inertia]

    return rates


def scipy_run(
    rates: Any, time: Array, method: Any, tolerance: float, start: Sequence[float] = (0.0, 0.0)
) -> Array:
    """Joint position (n,), rad, by solve_ivp."""
    span = (0.0, float(time[-1]))
    solution = solve_ivp(rates, span, start, method, time, rtol=tolerance, atol=tolerance / 10)
    return np.asarray(solution.y[0])


def scipy_fastest(rates: Any, time: Array, reference: Array) -> Run:
    """Scipy's fastest run whose error is at most ERROR; the least of five times."""
    runs = []
    for method, tolerance in CANDIDATES:

        def run(method: str = method, tolerance: float = tolerance) -> Array:
            return scipy_run(rates, time, method, tolerance)

        error = float(np.abs(run() - reference).max())
        if error <= ERROR:
            runs.append(Run(fastest(run, 2), error, method, tolerance))
    best = min(runs, key=lambda one: one.seconds)
    again = fastest(lambda: scipy_run(rates, time, best.method, best.tolerance), 3)
    return replace(best, seconds=min(again, best.seconds))


def ours_fastest(
    model: Model, time: Array, position: Array, kind: Interpolation, reference: Array
) -> Run:
    """The fastest `simulate` whose error is at most ERROR."""
    runs = []
    for tolerance in OUR_TOLERANCES:

        def run(tolerance: float = tolerance) -> Array:
            return simulate(model, time, position, interpolation=kind, tolerance=tolerance)[
                "joint_position"
            ]

        error = float(np.abs(run() - reference).max())
        if error <= ERROR:
            runs.append(Run(fastest(run, 100), error, "simulate", tolerance))
    return min(runs, key=lambda one: one.seconds)


def rates_time(model: Model) -> float:
    """Time of one compiled right-hand side, s."""
    with tempfile.TemporaryDirectory() as work:
        write_model(Path(work), build(model.effect_ids))
        program = Path(work) / "time_rates"
        source = Path(__file__).with_name("time_rates.c")
        subprocess.run(
            [
                *(
                    sys.executable,
                    "-m",
                    "ziglang",
                    "cc",
                    "-target",
                    compiler.host_platform().target,
                ),
                # without debugging as the models, else zig builds its own once more for this one
                *("-std=c11", "-O2", "-g0", "-s"),
                *("-ffp-contract=off", "-Wno-unused-function", "-D_GNU_SOURCE"),
                *(f"-I{folder}" for folder in (work, compiler.RUNTIME, compiler.fmi_headers())),
                *(str(source), "-o", str(program), "-lm"),
            ],
            check=True,
        )
        numbers = [repr(value) for value in model.values().values()]
        run = subprocess.run([str(program), *numbers], check=True, capture_output=True, text=True)
    return float(run.stdout) * 1e-9


def peer_rows(model: Model, measured: bool, kind: Interpolation, duration: float) -> list[Row]:
    """Scipy against `simulate` on one motion."""
    time, position = motor_motion(measured, duration)
    exact = simulate(model, time, position, interpolation=kind, tolerance=1e-13)
    reference = exact["joint_position"]
    ours = ours_fastest(model, time, position, kind, reference)
    peer = scipy_fastest(python_rates(model, time, position, kind == "cubic"), time, reference)
    name = f"{'measured' if measured else 'smooth'} input, {kind}"
    times = (
        f"{spoken(ours.seconds)} at {ours.tolerance:g}; "
        f"scipy {peer.method} {spoken(peer.seconds)} at {peer.tolerance:g}"
    )
    target = {"linear": 500.0, "cubic": 100.0}[kind]
    return [
        at_least(f"{name}: solve_ivp / simulate", peer.seconds / ours.seconds, target, "", times),
        at_most(f"{name}: our error", ours.error, ERROR, "rad", f"scipy {peer.error:.2g} rad"),
    ]


def overhead_rows(model: Model, duration: float) -> list[Row]:
    """Time of one right-hand side, and what a run costs beyond all of them."""
    time, position = motor_motion(True, duration)
    count = simulate(model, time, position).statistics["rates"]
    each = rates_time(model)
    overhead = fastest(lambda: simulate(model, time, position), 200) / (count * each)
    return [
        Row("one compiled right-hand side", spoken(each)),
        at_most("run time / (right-hand sides x time of one)", overhead, 3.0),
    ]


def rows(duration: float = 12.0) -> list[Row]:
    """All rows; `duration` is that of the motion, s."""
    model = load_model("biorob_x4_joint_3")
    kinds: tuple[Interpolation, ...] = ("linear", "cubic")
    table = [
        row
        for measured in (True, False)
        for kind in kinds
        for row in peer_rows(model, measured, kind, duration)
    ]
    return table + overhead_rows(model, duration)


def main() -> int:
    """Print the table; exit status."""
    return print_table("Simulation of 12 s at 500 Hz", rows())


if __name__ == "__main__":
    sys.exit(main())
