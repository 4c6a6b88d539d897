"""How far FMU co-simulation, FMU model exchange with CVode and `simulate` lie apart.

    python build_scripts/benchmark_fmu_agreement.py [--rate HZ]

Motor motion through slack, 3 s, sampled at HZ (default 100), at tolerance 1e-8: held between the
samples, and linear with derivatives of the inputs. Largest differences of the joint position.
The errors are differences from `simulate` at tolerance 1e-13: CVode restarts at every sample and
every event, and each restart costs it accuracy, so its error grows with the rate.
"""

import argparse
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from benchmarking import Row, at_most, print_table

# the driver of the tests is not installed
sys.path.append(str(Path(__file__).resolve().parents[1] / "tests"))

from elastic_tendon.actuator.parameters import Model, load_model
from elastic_tendon.fmu.export import export_fmu
from elastic_tendon.simulation.simulate import Array, simulate
from fmu_driver import Fmu, Segments, run_co_simulation, run_model_exchange

TOLERANCE = 1e-8
REFERENCE_TOLERANCE = 1e-13
ALLOWED = 1e-6  # rad
DURATION = 3.0  # s


def models() -> dict[str, Model]:
    """The paper's actuator, and the same with everything that brings events."""
    paper = load_model("biorob_x4_joint_3")
    sticking = paper.with_effect("coulomb_friction", {"torque": 0.35})
    protected = {"engagement": 0.4, "stiffness": 2e4}
    return {
        "paper": paper,
        "friction and protection": sticking.with_effect("overstretch_protection", protected),
    }


def motion(rate: float, linear: bool) -> Segments:
    """Two sines, of 0.3 and 0.15 rad, sampled at `rate` Hz."""
    time = np.cumsum(np.r_[0.0, np.full(round(DURATION * rate), 1 / rate)])
    position = 0.3 * (np.sin(23.0 * time) + 0.5 * np.sin(57.0 * time))
    return Segments(time, position, linear)


def simulated(model: Model, segments: Segments, tolerance: float) -> Array:
    """Joint position (n,), rad, at the samples."""
    options = (segments.time, segments.position)
    run = simulate(model, *options, interpolation=segments.interpolation, tolerance=tolerance)
    return run["joint_position"]


def compare(what: str, model: Model, fmu: Fmu, segments: Segments) -> Iterator[Row]:
    """Rows of the table for one model and kind of input."""
    exact, same = (simulated(model, segments, t) for t in (REFERENCE_TOLERANCE, TOLERANCE))
    slave, exchange = fmu.slave(), fmu.model()
    stepped = run_co_simulation(slave, segments, tolerance=TOLERANCE)
    integrated, events = run_model_exchange(exchange, segments, tolerance=TOLERANCE)
    slave.free()
    exchange.free()

    def apart(one: Array, other: Array) -> float:
        return float(np.abs(one - other).max())

    yield at_most(f"{what}: co-simulation - simulate", apart(stepped, same), ALLOWED, "rad")
    yield at_most(f"{what}: model exchange - simulate", apart(integrated, same), ALLOWED, "rad")
    yield Row(f"{what}: error of simulate", f"{apart(same, exact):.3g} rad")
    yield Row(f"{what}: error of model exchange", f"{apart(integrated, exact):.3g} rad")
    yield Row(f"{what}: events CVode located", str(len(events)))


def table(rate: float) -> list[Row]:
    """All rows, for samples at `rate` Hz."""
    rows: list[Row] = []
    with tempfile.TemporaryDirectory() as folder:
        for name, model in models().items():
            path = export_fmu(model, Path(folder) / f"{name}.fmu")
            fmu = Fmu(path, Path(folder) / name)
            for linear in (False, True):
                segments = motion(rate, linear)
                rows += compare(f"{name}, {segments.interpolation}", model, fmu, segments)
    return rows


def main() -> int:
    """Print the table; exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--rate", type=float, default=100.0, metavar="HZ")
    rate: float = parser.parse_args().rate
    return print_table(f"Agreement of FMU and simulate, inputs at {rate:g} Hz", table(rate))


if __name__ == "__main__":
    sys.exit(main())
