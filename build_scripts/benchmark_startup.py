"""Time from model.toml to the first trajectory, imports excluded; prints one table.

    python build_scripts/benchmark_startup.py

Each figure is taken in a fresh process. "Warm compiler" means that zig has compiled something
before on this machine, but not this structure; "cached" that the structure is in the cache.
"""

import os
import subprocess
import sys
import tempfile

from benchmarking import at_most, print_table

_FIRST_TRAJECTORY = """
import time
import numpy, casadi, platformdirs
from elastic_tendon import compiled, codegen, model, parameters
begin = time.perf_counter()
actuator = parameters.load_model("biorob_x4_joint_3")
times = numpy.linspace(0.0, 1.0, 501)
compiled.simulate(actuator, times, numpy.sin(times))
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


def main() -> None:
    """Print the table."""
    with tempfile.TemporaryDirectory() as warm_up:
        first_trajectory(warm_up)
    with tempfile.TemporaryDirectory() as cache:
        compiled = first_trajectory(cache)
        cached = min(first_trajectory(cache) for _ in range(5))
    rows = [
        at_most("model.toml to first trajectory, warm compiler", compiled, 3.0, "s"),
        at_most("model.toml to first trajectory, cached library", cached, 0.15, "s"),
    ]
    print_table("Start-up", rows)


if __name__ == "__main__":
    main()
