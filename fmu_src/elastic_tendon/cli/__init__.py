"""The command line: it parses, calls and shows; physics and statistics live elsewhere.

Exit status: 0 done, 1 the data or the model says no (one line on stderr), 2 wrong usage,
130 stopped by the user. Heavy modules are imported inside the commands so that help comes at once.
"""

import os
import sys
from typing import Annotated

import typer

import elastic_tendon as et
from elastic_tendon.cli import app as app_command
from elastic_tendon.cli import diagnosis, evidence, linear, measurements, models
from elastic_tendon.cli import sweep as sweep_command
from elastic_tendon.cli.shared import INTERRUPTED, app, output

__all__ = [
    "INTERRUPTED",
    "app",
    "app_command",
    "diagnosis",
    "evidence",
    "linear",
    "main",
    "measurements",
    "models",
    "sweep_command",
]

# before numpy is imported: a fit's matrices are tall and narrow, and threads that wait for one
# another make their decomposition fifty times slower on a busy machine
for variable in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(variable, "1")


def _version(wanted: bool) -> None:
    if wanted:
        output.print(f"elastic-tendon {et.__version__}", highlight=False)
        raise typer.Exit


@app.callback()
def options(
    _version: Annotated[
        bool,
        typer.Option("--version", callback=_version, is_eager=True, help="Show the version."),
    ] = False,
) -> None:
    """The elastic tendon actuator: simulate it, export it as an FMU, compare it with measurements
    and find what is missing.
    """


def main() -> None:
    """Entry point of the command ``elastic-tendon``."""
    try:
        app()
    except KeyboardInterrupt:  # before a command has begun
        sys.exit(INTERRUPTED)
