"""The binary: generated C and the runtime, compiled into one shared library.

The cached library that Python calls and the library inside an FMU are made here, from the same
sources; they differ in start values and token only.
"""

import tempfile
from collections.abc import Sequence
from pathlib import Path

from elastic_tendon import compiler
from elastic_tendon.codegen import generate
from elastic_tendon.fmu.layout import FmuVariable, c_tables
from elastic_tendon.system import HybridSystem


def write_sources(
    folder: Path,
    system: HybridSystem,
    variables: Sequence[FmuVariable],
    *,
    token: str,
    tolerance: float,
) -> None:
    """Write the generated C of a model, which `runtime/library.c` includes, into a folder.

    Parameters are those of `compile_binary`.
    """
    mode_names = [mode.name for mode in system.interface.modes]
    tables = c_tables(variables, mode_names, token, tolerance)
    (folder / "model.c").write_text(generate(system), "utf-8")
    (folder / "variables.c").write_text(tables, "utf-8")


def compile_binary(
    system: HybridSystem,
    variables: Sequence[FmuVariable],
    output: Path,
    target: compiler.Platform,
    *,
    token: str,
    tolerance: float,
) -> None:
    """Compile the shared library of a model.

    Parameters
    ----------
    system : equations
    variables : from `layout`, with the start values that the library is to have
    output : file to write
    target : platform to build for
    token : guid of the FMU
    tolerance : of the co-simulation solver where the importer sets none

    Raises
    ------
    BuildError
        where the compiler refuses
    """
    with tempfile.TemporaryDirectory() as work:
        write_sources(Path(work), system, variables, token=token, tolerance=tolerance)
        source = compiler.RUNTIME / "library.c"
        compiler.compile_library(source, output, target, include=[Path(work)])
