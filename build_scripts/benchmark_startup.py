"""Time to the first trajectory and the first refit, of the first import, and of the help.

    python build_scripts/benchmark_startup.py

Each figure is taken in fresh processes. To the first trajectory counts from model.toml on, imports
excluded; "warm compiler" means that zig has compiled something before on this machine, but not this
structure; "cached" that the structure is in the cache. Before a diagnosis nothing was compiled on
this machine: the caches of libraries and of zig are empty; it counts from the call to what its
progress callback is told. Import and help count from the start of the process to its end, beside
one that imports numpy, scipy.optimize and casadi and does nothing.
"""

import os
import subprocess
import sys
import tempfile
from functools import partial

from benchmarking import Row, at_most, in_turn, print_table, spoken, spread

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

_FIRST_REFITS = """
import time
from elastic_tendon.demo import load_demo
from elastic_tendon.diagnosis.diagnose import diagnose
from elastic_tendon.progress import Enough
begin = time.perf_counter()
def look(text, share):
    if text.startswith(awaited[0]):
        print(time.perf_counter() - begin)
        if len(awaited) == 1:
            raise Enough
        del awaited[0]
awaited = ["refitting the parameters", "refitting the likeliest sets"]
diagnose(*load_demo(), progress=look)
"""


def first_trajectory(cache: str) -> float:
    """Seconds to the first trajectory with the given cache folder."""
    (duration,) = _told(_FIRST_TRAJECTORY, {"ELASTIC_TENDON_CACHE": cache})
    return duration


def refit_rows() -> list[Row]:
    """Time to the refits with which a diagnosis of the demonstration begins."""
    with tempfile.TemporaryDirectory() as libraries, tempfile.TemporaryDirectory() as of_zig:
        fresh = {"ELASTIC_TENDON_CACHE": libraries, "ZIG_GLOBAL_CACHE_DIR": of_zig}
        parameters, effects = _told(_FIRST_REFITS, fresh)
    return [
        at_most("diagnose to first refit, nothing compiled before", parameters, 10.0, "s"),
        Row("... to first refit with an effect", spoken(effects)),
    ]


def _told(program: str, environment: dict[str, str]) -> list[float]:
    """The numbers, a line each, that a program prints in a process of its own."""
    run = subprocess.run(
        [sys.executable, "-c", program],
        env=os.environ | environment,
        capture_output=True,
        text=True,
        check=True,
    )
    return [float(line) for line in run.stdout.splitlines()]


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
    return print_table("Start-up", [*trajectory_rows(), *refit_rows(), *process_rows()])


if __name__ == "__main__":
    sys.exit(main())
