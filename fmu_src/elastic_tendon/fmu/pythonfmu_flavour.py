"""The pythonfmu flavour: an FMI 2.0 co-simulation FMU whose slave is a Python script.

The script (`pythonfmu_slave.py`) passes every call to the same compiled library, packed in the
resources. On the target it needs the platform it was built for (Linux or Windows on x86_64, for
which pythonfmu ships its wrapper) and Python 3.11 or newer as the process that loads the FMU:
the wrapper takes Python from there. No packages: pythonfmu packs itself into the FMU.

Beside the plain FMU it lacks model exchange, directional derivatives and derivatives of inputs
and outputs, which pythonfmu does not have; and a call that fails is told by the logger and by
discarded steps, not by its status (`pythonfmu_slave` says why).
"""

import shutil
import sys
import tempfile
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from elastic_tendon.actuator.interfaces import InterfaceKind
from elastic_tendon.actuator.model import build
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.errors import BuildError
from elastic_tendon.fmu import description, fmi2_description
from elastic_tendon.fmu.bill_of_materials import bill_of_materials
from elastic_tendon.fmu.documentation import licenses
from elastic_tendon.fmu.export import describe
from elastic_tendon.fmu.packing import checked_path, write_archive
from elastic_tendon.native import compiler
from elastic_tendon.native.binary import compile_binary, write_sources, write_token
from elastic_tendon.native.library import DEFAULT_TOLERANCE
from elastic_tendon.output import write_file

_SLAVE = Path(__file__).parent / "pythonfmu_slave.py"
CO_SIMULATION = fmi2_description.CO_SIMULATION | {
    "needsExecutionTool": "true",
    "canInterpolateInputs": "false",
    "maxOutputDerivativeOrder": "0",
    "providesDirectionalDerivative": "false",
}


def needs() -> str:
    """What the FMU needs where it runs; its description says so too."""
    host = compiler.host_platform().name
    return f"needs {host} and a process with Python 3.11 or newer that loads it; no packages"


def _write_resources(model: Model, folder: Path) -> tuple[list[Path], str]:
    """Description and library of the model, and their token."""
    system = build(*model.structure)
    described = replace(
        describe(model, system, 2), co_simulation=CO_SIMULATION, model_exchange=None
    )
    root = fmi2_description.model_description(described)
    root.set("description", f"{root.get('description')}; {needs()}")
    target = compiler.host_platform()
    # its folder comes on the search path of whoever loads the FMU: no package may have its name
    library = folder / f"elastic_tendon_fmu{target.suffix}"
    with tempfile.TemporaryDirectory() as work:
        sources = Path(work)
        key = write_sources(sources, system, described.variables, tolerance=DEFAULT_TOLERANCE)
        token = description.seal(root, key)
        write_token(sources, token)
        compile_binary(sources, library, target)
    text = folder / "description.xml"
    text.write_bytes(description.to_bytes(root))
    return [text, library], token


def _built(script: Path, resources: list[Path]) -> dict[str, bytes]:
    """Files of the FMU by their path in it, with pythonfmu's wrapper for this platform only.

    The builder packs those of all platforms; the compiled library is for one.
    """
    from pythonfmu.builder import FmuBuilder

    packed = FmuBuilder.build_FMU(script, dest=script.with_suffix(".fmu"), project_files=resources)
    with zipfile.ZipFile(packed) as archive:
        contents = {name: archive.read(name) for name in archive.namelist()}
    wrappers = f"binaries/{compiler.host_platform().fmi2_folder}/"
    return {
        name: content
        for name, content in contents.items()
        if name.startswith(wrappers) or not name.startswith("binaries/")
    }


@contextmanager
def _imports_undone(module: str) -> Iterator[None]:
    """The builder imports the slave's script from its folder; here nothing of it shall stay."""
    search_path = list(sys.path)
    before = sys.modules.pop(module, None)
    try:
        yield
    finally:
        sys.path[:] = search_path
        sys.modules.pop(module, None)
        if before is not None:
            sys.modules[module] = before


def export_pythonfmu(model: Model, path: str | Path, *, overwrite: bool = False) -> Path:
    """Write the pythonfmu flavour of a model's FMU.

    Parameters
    ----------
    model : Model
    path : of the file, ending in .fmu
    overwrite : whether an existing file may be replaced

    Returns
    -------
    Path, that of the file

    Raises
    ------
    OutputError
        where the file exists, cannot be written or does not end in .fmu
    BuildError
        where the compiler refuses, or pythonfmu has no wrapper for this platform
    """
    from pythonfmu.builder import FmuBuilder

    model.check_interface("the pythonfmu flavour", (InterfaceKind.POSITION,))
    path = checked_path(path, overwrite=overwrite)
    if not FmuBuilder.has_binary():
        raise BuildError("pythonfmu has no wrapper for this platform; export the plain FMU instead")
    with _imports_undone(_SLAVE.stem), tempfile.TemporaryDirectory() as work:
        folder = Path(work)
        script = Path(shutil.copy(_SLAVE, folder))
        resources, token = _write_resources(model, folder)
        contents = _built(script, resources)
    suffix = compiler.host_platform().suffix
    binaries = {name: content for name, content in contents.items() if name.endswith(suffix)}
    contents |= bill_of_materials(model.name, token, binaries, 2, wrapped=True)
    contents |= licenses("pythonfmu")
    write_file(path, lambda target: write_archive(target, contents), force=overwrite)
    return path
