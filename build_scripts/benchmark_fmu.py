"""The FMU against its peers: time of a step, accuracy through slack, size, time to export.

    python build_scripts/benchmark_fmu.py

Steps of 1 ms are driven by fmpy in one run: our FMUs (FMI 2.0 and 3.0), our pythonfmu flavour, and
`plain_slave.py`, a pythonfmu slave that integrates the same equations with scipy, as a user would
write it. Errors are differences from `simulate` at tolerance 1e-13; the motor swings through slack
and is held from sample to sample, or moves on with the derivative that the importer gives.
"""

import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave
from pythonfmu.builder import FmuBuilder

from benchmarking import Row, at_least, at_most, fastest, print_table, spoken

# the driver of the tests is not installed
sys.path.append(str(Path(__file__).resolve().parents[1] / "tests"))

from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.fmu.export import export_fmu
from elastic_tendon.fmu.pythonfmu_flavour import export_pythonfmu
from elastic_tendon.native.library import DEFAULT_TOLERANCE
from elastic_tendon.simulation.simulate import simulate
from fmu_driver import Fmu, Segments, run_co_simulation, run_model_exchange

MODEL = "biorob_x4_joint_3"
STEP = 1e-3  # s
STEPS = 2000
START = {"motor_position": 0.3}  # lets the joint swing through slack
REPETITIONS = 5


# ---- time of a step ------------------------------------------------------------------------------


def step_time(path: Path, folder: Path) -> float:
    """Mean time of fmpy's doStep over 1 ms, in s; the least of several runs."""
    description = read_model_description(str(path))
    kind = FMU3Slave if description.fmiVersion.startswith("3") else FMU2Slave
    slave = kind(
        guid=description.guid,
        unzipDirectory=extract(str(path), str(folder)),
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="actuator",
    )
    references = {variable.name: variable.valueReference for variable in description.modelVariables}
    slave.instantiate()
    times = []
    for _ in range(REPETITIONS):
        _initialise(slave, [references[name] for name in START])
        begin = time.perf_counter()
        for i in range(STEPS):
            slave.doStep(i * STEP, STEP)
        times.append((time.perf_counter() - begin) / STEPS)
        slave.reset()
    slave.freeInstance()
    return min(times)


def _initialise(slave: FMU2Slave | FMU3Slave, references: list[int]) -> None:
    if isinstance(slave, FMU3Slave):
        slave.setFloat64(references, list(START.values()))
    else:
        slave.setupExperiment(startTime=0.0)
        slave.setReal(references, list(START.values()))
    slave.enterInitializationMode()
    slave.exitInitializationMode()


def step_rows(folder: Path) -> list[Row]:
    """Times of a step, and how many times longer the peers take."""
    model = load_model(MODEL)
    plain = FmuBuilder.build_FMU(Path(__file__).parent / "plain_slave.py", dest=folder)
    paths = {
        "FMI 2.0": export_fmu(model, folder / "two.fmu", fmi_version=2),
        "FMI 3.0": export_fmu(model, folder / "three.fmu", fmi_version=3),
        "pythonfmu flavour": export_pythonfmu(model, folder / "flavour.fmu"),
        "plain pythonfmu slave": Path(plain),
    }
    taken = {name: step_time(path, folder / name) for name, path in paths.items()}
    rows = [Row(f"step of 1 ms, {name}", f"{1e6 * t:.3g} us") for name, t in taken.items()]
    for name in ("FMI 2.0", "FMI 3.0"):
        for peer, factor in (("pythonfmu flavour", 2.0), ("plain pythonfmu slave", 30.0)):
            rows.append(at_least(f"{peer} / {name}", taken[peer] / taken[name], factor))
    return rows


# ---- accuracy ------------------------------------------------------------------------------------


def motion(linear: bool) -> Segments:
    """Two sines, of 0.3 and 0.15 rad, for 2 s in steps of 1 ms."""
    times = np.cumsum(np.r_[0.0, np.full(STEPS, STEP)])
    return Segments(times, 0.3 * (np.sin(23.0 * times) + 0.5 * np.sin(57.0 * times)), linear)


def accuracy_rows(folder: Path) -> list[Row]:
    """Largest errors of the joint position in steps of 1 ms, rad."""
    model = load_model(MODEL)
    fmu = Fmu(export_fmu(model, folder / "accurate.fmu"), folder / "accurate")
    rows = []
    for linear in (False, True):
        segments = motion(linear)
        exact = simulate(
            *(model, segments.time, segments.position),
            interpolation=segments.interpolation,
            tolerance=1e-13,
        )
        if len(np.unique(exact["slack_state"])) < 3:
            raise SystemExit("the motion does not pass through all slack states")
        slave, exchange = fmu.slave(), fmu.model()
        stepped = run_co_simulation(slave, segments, tolerance=None)
        integrated, _ = run_model_exchange(exchange, segments, tolerance=DEFAULT_TOLERANCE)
        slave.free()
        exchange.free()
        ours, theirs = (np.abs(x - exact["joint_position"]).max() for x in (stepped, integrated))
        name = segments.interpolation
        rows += [
            at_most(f"error, co-simulation, {name}", ours, 1e-7, "rad"),
            at_least(f"error, model exchange in CVode / co-simulation, {name}", theirs / ours, 1.0),
        ]
    return rows


# ---- size and export -----------------------------------------------------------------------------


def _process_time(command: list[str]) -> float:
    """Least time of three processes, s; what they need is cached by then."""
    return fastest(lambda: subprocess.run(command, check=True, capture_output=True), 3)


def _export_time(path: Path, *options: str) -> float:
    command = [sys.executable, "-m", "elastic_tendon", "export", MODEL, "-o", str(path)]
    return _process_time([*command, "--force", *options])


def export_rows(folder: Path, everywhere: bool = True) -> list[Row]:
    """Size of the FMU and time of the export command, warm, Python's start included.

    Beside it stands pythonfmu's own command, which packs `plain_slave.py` and compiles nothing.
    """
    plain = [sys.executable, "-m", "pythonfmu", "build", "-d", str(folder)]
    peer = _process_time([*plain, "-f", str(Path(__file__).parent / "plain_slave.py")])
    rows = []
    for version in ("2", "3"):
        host = _export_time(folder / f"host_{version}.fmu", "--fmi", version)
        name = f"export of FMI {version}.0, this platform"
        rows.append(at_most(name, host, 2.0, "s"))
        rows.append(Row(f"{name} / pythonfmu build", f"{host / peer:.3g}", beside=spoken(peer)))
        if everywhere:
            path = folder / f"all_{version}.fmu"
            five = _export_time(path, "--fmi", version, "--platform", "all")
            size = path.stat().st_size / 1e6
            rows.append(at_most(f"export of FMI {version}.0, five platforms", five, 8.0, "s"))
            rows.append(at_most(f"size of FMI {version}.0, five platforms", size, 1.0, "MB"))
    return rows


def main() -> int:
    """Print the tables; exit status."""
    with tempfile.TemporaryDirectory() as work:
        folder = Path(work)
        return max(
            print_table("A step of the FMU, driven by fmpy", step_rows(folder)),
            print_table("Accuracy of the FMU through slack", accuracy_rows(folder)),
            print_table("Export", export_rows(folder)),
        )


if __name__ == "__main__":
    sys.exit(main())
