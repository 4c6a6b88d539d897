"""Time to the first trajectory, of the first import, and of the help; prints one table.

    python build_scripts/benchmark_startup.py

Each figure is taken in fresh processes. To the first trajectory counts from model.toml on, imports
excluded; "warm compiler" means that zig has compiled something before on this machine, but not this
structure; "cached" that the structure is in the cache. Import and help count from the start of the
process to its end, beside one that imports numpy, scipy.optimize and casadi and does nothing.
"""

import os
import subprocess
import sys
import tempfile
from functools import partial

from benchmarking import Row, at_most, in_turn, print_table, spread

_FIRST_TRAJECTORY = """
import time
import numpy, casadi, platformdirs
from elastic_tendon.native import codegen
from elastic_tendon.simulation.simulate import simulate
from elastic_tendon.actuator import model, parameters
begin = time.perf_counter()
actuator = parameters.load_model("biorob_x4_joint_3")
times = numpy.linspace(0.0, 1.0, 501)
simulate(actuator, times, numpy.sin(times))
print(time.perf_counter() - begin)
"""


def first_trajectory(cache: str) -> float:
    """Seconds to the first trajectory with the given cache folder."""
    run = subprocess.run(
        [sys.executable, "-c", _FIRST_TRAJECTORY],
        env=os.environ | {"ELASTIC_TENDON_CACHE": cache},
        capture_output=True,
        text=True,
        check=True,
    )
    return float(run.stdout)


def trajectory_rows(repetitions: int = 5) -> list[Row]:
    """Time to the first trajectory."""
    with tempfile.TemporaryDirectory() as warm_up:
        first_trajectory(warm_up)
    with tempfile.TemporaryDirectory() as cache:
        compiled = first_trajectory(cache)
        cached = min(first_trajectory(cache) for _ in range(repetitions))
    return [
        at_most("model.toml to first trajectory, warm compiler", compiled, 3.0, "s"),
        at_most("model.toml to first trajectory, cached library", cached, 0.15, "s"),
    ]


def process_rows(repetitions: int = 20) -> list[Row]:
    """Import and help against the import of what they do without, in processes that take turns."""
    commands = {
        "import elastic_tendon": ["-c", "import elastic_tendon"],
        "elastic-tendon --help": ["-m", "elastic_tendon", "--help"],
        "import numpy, scipy.optimize, casadi": ["-c", "import numpy, scipy.optimize, casadi"],
    }
    calls = [partial(_run, arguments) for arguments in commands.values()]
    *ours, peer = in_turn(calls, repetitions)
    *names, other = commands
    return [
        at_most(
            *(f"{name} / {other}", float(times.min() / peer.min()), 1.0, ""),
            f"{spread(times)}; {spread(peer)}",
        )
        for name, times in zip(names, ours, strict=True)
    ]


def _run(arguments: list[str]) -> None:
    subprocess.run([sys.executable, *arguments], capture_output=True, check=True)


def main() -> int:
    """Print the table; exit status."""
    return print_table("Start-up", [*trajectory_rows(), *process_rows()])


if __name__ == "__main__":
    sys.exit(main())
