"""A whole motion simulated by fmpy through the FMU, against one call of `simulate`.

    python build_scripts/benchmark_fmpy.py

3 s at 500 Hz through slack, by `fmpy.simulate_fmu`: our FMU (FMI 2.0) in model exchange with CVode
and in co-simulation, our pythonfmu flavour, and `plain_slave.py`, a pythonfmu slave that integrates
the same equations with scipy. fmpy is used as fast as it allows: the FMU is unpacked, its
description read and its instance made before the clock runs, and only reset between runs; nothing
is validated and one output is recorded. Inputs are linear between samples in model exchange and
held in co-simulation, as fmpy does it; each error is that against the same motion at tolerance
1e-13. In model exchange fmpy 0.3 gives CVode the inputs for event indicators only, not for rates,
which costs accuracy.
"""

import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from fmpy import extract, instantiate_fmu, read_model_description, simulate_fmu
from pythonfmu.builder import FmuBuilder

from benchmark_simulate import motor_motion
from benchmarking import Array, Row, at_least, fastest, in_turn, print_table, spoken
from elastic_tendon.actuator.parameters import Model, load_model
from elastic_tendon.fmu.export import export_fmu
from elastic_tendon.fmu.pythonfmu_flavour import export_pythonfmu
from elastic_tendon.native.interpolation import Interpolation
from elastic_tendon.native.library import DEFAULT_TOLERANCE
from elastic_tendon.simulation.simulate import simulate

MODEL = "biorob_x4_joint_3"
CVODE_TOLERANCE = 1e-6
REPETITIONS = 5
Kind = Literal["ModelExchange", "CoSimulation"]


@dataclass(frozen=True)
class Motion:
    """What drives the joint: time (n,) s and motor position (n,) rad."""

    time: Array
    position: Array

    def simulated(
        self, model: Model, kind: Interpolation, tolerance: float = DEFAULT_TOLERANCE
    ) -> Array:
        """Joint position (n,), rad."""
        run = simulate(model, self.time, self.position, interpolation=kind, tolerance=tolerance)
        return run["joint_position"]

    def signals(self, names: set[str]) -> Any:
        """The inputs as fmpy takes them, those of the FMU's that it knows; no load."""
        rate = np.append(np.diff(self.position) / np.diff(self.time), 0.0)
        columns = {
            "time": self.time,
            "motor_position": self.position,
            "motor_velocity": rate,
            "load_torque": np.zeros_like(self.time),
        }
        kept = {name: values for name, values in columns.items() if name in names | {"time"}}
        return np.rec.fromarrays(list(kept.values()), dtype=[(name, float) for name in kept])


def driver(path: Path, folder: Path, kind: Kind, motion: Motion) -> Callable[[], Array]:
    """What simulates the motion through an FMU, unpacked into a new folder; (n,) rad."""
    description = read_model_description(str(path))
    unpacked = extract(str(path), str(folder))
    instance = instantiate_fmu(unpacked, description, kind)
    inputs = {
        variable.name for variable in description.modelVariables if variable.causality == "input"
    }
    signals = motion.signals(inputs)

    def run() -> Array:
        instance.reset()
        result = simulate_fmu(
            unpacked,
            validate=False,
            model_description=description,
            fmu_instance=instance,
            fmi_type=kind,
            start_time=0.0,
            stop_time=float(motion.time[-1]),
            output_interval=float(motion.time[1]),
            relative_tolerance=CVODE_TOLERANCE if kind == "ModelExchange" else DEFAULT_TOLERANCE,
            input=signals,
            output=["joint_position"],
            record_events=False,
        )
        return np.asarray(result["joint_position"])

    return run


def drivers(model: Model, folder: Path, motion: Motion) -> dict[str, Callable[[], Array]]:
    """Peers by name; those of model exchange are linear between samples, the others hold."""
    two = export_fmu(model, folder / "two.fmu", fmi_version=2)
    flavour = export_pythonfmu(model, folder / "flavour.fmu")
    plain = FmuBuilder.build_FMU(Path(__file__).parent / "plain_slave.py", dest=folder)
    peers: tuple[tuple[str, Path, Kind], ...] = (
        ("model exchange, CVode", two, "ModelExchange"),
        ("co-simulation", two, "CoSimulation"),
        ("pythonfmu flavour", flavour, "CoSimulation"),
        ("plain pythonfmu slave with scipy", Path(plain), "CoSimulation"),
    )
    return {
        name: driver(path, folder / str(number), kind, motion)
        for number, (name, path, kind) in enumerate(peers)
    }


def rows(duration: float = 3.0, repetitions: int = REPETITIONS) -> list[Row]:
    """Times longer than `simulate`, and errors; `duration` is that of the motion, s."""
    model = load_model(MODEL)
    motion = Motion(*motor_motion(measured=False, duration=duration))
    table = []
    with tempfile.TemporaryDirectory() as work:
        peers = drivers(model, Path(work), motion)
        theirs = in_turn(list(peers.values()), repetitions).min(axis=1)
        ours = fastest(lambda: motion.simulated(model, "linear"), 20 * repetitions)
        for (name, run), taken in zip(peers.items(), theirs, strict=True):
            kind: Interpolation = "linear" if name.startswith("model exchange") else "hold"
            exact = motion.simulated(model, kind, tolerance=1e-13)
            error = np.abs(run() - exact).max()
            own = np.abs(motion.simulated(model, kind) - exact).max()
            times = f"{spoken(taken)}, error {error:.1g} rad; {spoken(ours)}, {own:.1g} rad"
            table.append(at_least(f"{name} / simulate", taken / ours, 1.0, "", times))
    return table


def main() -> int:
    """Print the table; exit status."""
    return print_table("3 s at 500 Hz through an FMU, driven by fmpy", rows())


if __name__ == "__main__":
    sys.exit(main())
