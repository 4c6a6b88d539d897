"""The binary: generated C and the runtime, compiled into one shared library.

The cached library that Python calls and the library inside an FMU are made here, from the same
model and solver; that of an FMU has the functions of FMI around them.
"""

import hashlib
import tempfile
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path
from threading import Event

from elastic_tendon.actuator.system import HybridSystem
from elastic_tendon.native import compiler, shared
from elastic_tendon.native.codegen import generate
from elastic_tendon.native.layout import FmuVariable, c_tables
from elastic_tendon.progress import Progress, silent

_AT_ONCE = 2  # compilers; each keeps a core busy
# the C of an FMU, of what Python calls, and of what a page runs
LIBRARY, SIMULATION, PAGE = "library.c", "simulation.c", "page.c"
_MODEL = "model.c"
_LARGE = 4_000_000  # bytes of it, from which on a compiler is busy for minutes
_LARGE_MODEL = "large model: some minutes"
_FIRST_TIME = "the first time: minutes"  # when the libraries for Windows themselves are built


def write_model(folder: Path, system: HybridSystem) -> str:
    """Write the generated C of a model, which `SIMULATION` includes, into a folder.

    Returns
    -------
    str, a hash of all that goes into the library: this C, that of the runtime, compiler and flags;
    the same on every host
    """
    digest = hashlib.sha256(compiler.toolchain().encode())
    for name, text in {_MODEL: generate(system), "shared.h": shared.header()}.items():
        content = text.encode()  # with the same ends of lines everywhere
        (folder / name).write_bytes(content)
        digest.update(content)
    for path in sorted(compiler.RUNTIME.rglob("*.[ch]")):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:32]


def write_sources(
    folder: Path,
    system: HybridSystem,
    variables: Sequence[FmuVariable],
    *,
    tolerance: float,
    fmi_version: int = 2,
) -> str:
    """Write the generated C of a model's FMU, which `LIBRARY` includes, into a folder.

    What is compiled needs the token too, see `write_token`.

    Parameters
    ----------
    folder : where to
    system : equations
    variables : from `layout`, with the start values that the library is to have
    tolerance : of the co-simulation solver where the importer sets none
    fmi_version : 2 or 3, whose functions the library shows

    Returns
    -------
    str, a hash of all that goes into the library, see `write_model`
    """
    key = write_model(folder, system)
    tables = c_tables(variables, system.interface.modes, tolerance, fmi_version).encode()
    (folder / "variables.c").write_bytes(tables)
    return hashlib.sha256(key.encode() + tables).hexdigest()[:32]


def write_token(folder: Path, token: str) -> None:
    """Write the string by which a description and its binary know each other beside the C."""
    (folder / "token.h").write_bytes(f'#define MODEL_TOKEN "{token}"\n'.encode())


def compile_binary(
    sources: Path,
    output: Path,
    target: compiler.Platform,
    progress: Progress = silent,
    unit: str = LIBRARY,
) -> None:
    """Compile the shared library of a model.

    Parameters
    ----------
    sources : folder filled by `write_sources` and `write_token`, or by `write_model`
    output : file to write
    target : platform to build for
    progress : told what is being built
    unit : file of the runtime that includes all others; but for
        `LIBRARY`, `write_model` is enough

    Raises
    ------
    BuildError
        where the compiler refuses
    """
    progress(_being_built(sources, [target]), 0.0)
    compiler.compile_library(compiler.RUNTIME / unit, output, target, include=[sources])


def compile_binaries(
    sources: Path, identifier: str, platforms: Sequence[compiler.Platform], progress: Progress
) -> dict[compiler.Platform, bytes]:
    """Compile the library of a model for several platforms.

    Parameters
    ----------
    sources : folder filled by `write_sources` and `write_token`
    identifier : the libraries' file name without suffix, which some formats write into them
    platforms : to build for
    progress : told what is being built

    Returns
    -------
    dict
        content of each platform's library

    Raises
    ------
    BuildError
        where the compiler refuses
    """
    progress(_being_built(sources, platforms), 0.0)
    built: dict[compiler.Platform, bytes] = {}
    pool, stopped = ThreadPoolExecutor(_AT_ONCE), Event()
    try:
        started = {
            pool.submit(_compile, sources, identifier, platform, stopped): platform
            for platform in platforms
        }
        for done in as_completed(started):
            built[started[done]] = done.result()
            waiting = [platform for platform in platforms if platform not in built]
            progress(_being_built(sources, waiting), len(built) / len(platforms))
    finally:  # also of an interrupt, which ends the compilers that are running
        stopped.set()
        pool.shutdown(cancel_futures=True)
    return {platform: built[platform] for platform in platforms}


def _compile(sources: Path, identifier: str, platform: compiler.Platform, stopped: Event) -> bytes:
    with tempfile.TemporaryDirectory() as work:
        output = Path(work) / f"{identifier}{platform.suffix}"
        compiler.compile_library(compiler.RUNTIME / LIBRARY, output, platform, [sources], stopped)
        return output.read_bytes()  # what the linker for Windows leaves beside it is not wanted


def _being_built(sources: Path, waiting: Sequence[compiler.Platform]) -> str:
    """What is done now, and why it takes long where it does."""
    if not waiting:
        return "packing"
    now = waiting[:_AT_ONCE]
    large = (sources / _MODEL).stat().st_size > _LARGE
    long = [_LARGE_MODEL] if large else []
    long += [_FIRST_TIME] if any(platform.suffix == ".dll" for platform in now) else []
    why = f" ({'; '.join(long)})" if long else ""
    return f"building {', '.join(platform.name for platform in now)}{why}"
