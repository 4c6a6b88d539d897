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
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

from benchmarking import Row, at_least, at_most, fastest, print_table
from elastic_tendon import compiler
from elastic_tendon.compiled import DEFAULT_TOLERANCE, simulate
from elastic_tendon.fmu.binary import write_sources
from elastic_tendon.fmu.layout import default_layout
from elastic_tendon.interpolation import Interpolation
from elastic_tendon.model import build
from elastic_tendon.parameters import Model, load_model

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


def motor_motion(measured: bool) -> tuple[Array, Array]:
    """Time (s) and motor position (rad): two sines through slack."""
    time = np.arange(int(12 * RATE) + 1) / RATE
    position = 0.3 * np.sin(2 * np.pi * 0.7 * time) + 0.2 * np.sin(2 * np.pi * 2.3 * time)
    if measured:
        position = np.round(position / ENCODER_STEP) * ENCODER_STEP
    return time, position


def python_rates(model: Model, time: Array, position: Array, cubic: bool) -> Rates:
    """The same equations as a user of scipy would write them for speed."""
    t, upper = model.transmission, model.transmission.upper_spring
    radius, inertia, damping = t.joint_pulley_radius, model.link.inertia, model.link.damping
    stiffness = upper.stiffness * upper.parallel
    rest = t.pretension_force / stiffness
    last = time.size - 2
    spline = CubicSpline(time, position)
    if cubic:
        rows = [tuple(row) for row in spline.c[::-1].T.tolist()]
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
        above, below = stiffness * (rest - stretch), stiffness * (rest + stretch)
        torque = radius * ((above if above > 0.0 else 0.0) - (below if below > 0.0 else 0.0))
        return [velocity, (torque - damping * velocity) / inertia]

    return rates


def scipy_fastest(rates: Any, time: Array, reference: Array) -> tuple[float, str]:
    """Time (s) and name of scipy's fastest run whose error is at most ERROR."""
    runs = []
    for method, tolerance in CANDIDATES:

        def run(method: Any = method, tolerance: float = tolerance) -> Array:
            solution = solve_ivp(
                rates,
                (0.0, time[-1]),
                [0.0, 0.0],
                method,
                time,
                rtol=tolerance,
                atol=tolerance / 10,
            )
            return np.asarray(solution.y[0])

        if np.abs(run() - reference).max() <= ERROR:
            runs.append((fastest(run, 2), f"{method} {tolerance:g}"))
    return min(runs)


def ours_fastest(
    model: Model, time: Array, position: Array, kind: Interpolation, reference: Array
) -> tuple[float, float]:
    """Time (s) and error (rad) of the fastest `simulate` whose error is at most ERROR."""
    runs = []
    for tolerance in OUR_TOLERANCES:

        def run(tolerance: float = tolerance) -> Array:
            return simulate(model, time, position, interpolation=kind, tolerance=tolerance)[
                "joint_position"
            ]

        error = float(np.abs(run() - reference).max())
        if error <= ERROR:
            runs.append((fastest(run, 100), error))
    return min(runs)


def rates_time(model: Model) -> float:
    """Time of one compiled right-hand side, s."""
    with tempfile.TemporaryDirectory() as work:
        system = build(model.effect_ids)
        variables = default_layout(system.interface)
        write_sources(Path(work), system, variables, token="", tolerance=DEFAULT_TOLERANCE)
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
                *("-std=c11", "-O2", "-ffp-contract=off", "-Wno-unused-function", "-D_GNU_SOURCE"),
                *(f"-I{folder}" for folder in (work, compiler.RUNTIME, compiler.fmi_headers())),
                *(str(source), "-o", str(program), "-lm"),
            ],
            check=True,
        )
        numbers = [repr(value) for value in model.values().values()]
        run = subprocess.run([str(program), *numbers], check=True, capture_output=True, text=True)
    return float(run.stdout) * 1e-9


def main() -> None:
    """Print the table."""
    model = load_model("biorob_x4_joint_3")
    rows: list[Row] = []
    kinds: tuple[tuple[Interpolation, float], ...] = (("linear", 500.0), ("cubic", 100.0))
    for measured in (True, False):
        time, position = motor_motion(measured)
        name = "measured" if measured else "smooth"
        for kind, target in kinds:
            exact = simulate(model, time, position, interpolation=kind, tolerance=1e-13)
            reference = exact["joint_position"]
            ours, error = ours_fastest(model, time, position, kind, reference)
            rates = python_rates(model, time, position, kind == "cubic")
            peer, method = scipy_fastest(rates, time, reference)
            ratio = f"{name} input, {kind}: times faster than scipy ({method}, {peer:.2f} s)"
            rows.append(at_least(ratio, peer / ours, target))
            rows.append(at_most(f"{name} input, {kind}: our error", error, ERROR, "rad"))
    time, position = motor_motion(measured=True)
    count = simulate(model, time, position).statistics["rates"]
    each = rates_time(model)
    overhead = fastest(lambda: simulate(model, time, position), 200) / (count * each)
    rows.append(Row("one compiled right-hand side", f"{each * 1e9:.1f} ns"))
    rows.append(at_most("run time / (right-hand sides x time of one)", overhead, 3.0))
    print_table("Simulation of 12 s at 500 Hz", rows)


if __name__ == "__main__":
    main()
