"""Model to FMU: FMI 2.0, co-simulation and model exchange in one file, for this platform."""

import re
import tempfile
import zipfile
from collections.abc import Mapping
from pathlib import Path

from elastic_tendon import compiler
from elastic_tendon.compiled import DEFAULT_TOLERANCE, structure_key
from elastic_tendon.fmu import description, fmi2_description
from elastic_tendon.fmu.binary import compile_binary
from elastic_tendon.fmu.dependencies import dependencies
from elastic_tendon.fmu.layout import layout
from elastic_tendon.model import build
from elastic_tendon.output import OutputError, check_writable, write_file
from elastic_tendon.parameters import Model
from elastic_tendon.system import HybridSystem

_ZIP_TIME = (1980, 1, 1, 0, 0, 0)  # the earliest a zip can hold: equal models give equal files


def model_identifier(name: str) -> str:
    """C identifier for a model's name, which FMI wants for the binary's file name."""
    identifier = re.sub(r"\W", "_", name, flags=re.ASCII)
    return identifier if re.match("[A-Za-z]", identifier) else f"model_{identifier}"


def describe(
    model: Model,
    system: HybridSystem,
    *,
    co_simulation: dict[str, str] | None,
    model_exchange: dict[str, str] | None,
) -> description.Description:
    """What the FMU of a model says of itself; see `Description` for the two interfaces."""
    return description.Description(
        name=model.name,
        identifier=model_identifier(model.name),
        interface=system.interface,
        variables=layout(system.interface, model.values()),
        dependencies=dependencies(system),
        co_simulation=co_simulation,
        model_exchange=model_exchange,
    )


def _contents(model: Model) -> dict[str, bytes]:
    """Files of the FMU by their path in it."""
    system = build(model.effect_ids)
    described = describe(
        model,
        system,
        co_simulation=fmi2_description.CO_SIMULATION,
        model_exchange=fmi2_description.MODEL_EXCHANGE,
    )
    root = fmi2_description.model_description(described)
    target = compiler.host_platform()
    token = description.seal(root, structure_key(model.effect_ids))
    with tempfile.TemporaryDirectory() as folder:
        binary = Path(folder) / f"{described.identifier}{target.suffix}"
        compile_binary(
            *(system, described.variables, binary, target),
            token=token,
            tolerance=DEFAULT_TOLERANCE,
        )
        return {
            "modelDescription.xml": description.to_bytes(root),
            f"binaries/{target.fmi2_folder}/{binary.name}": binary.read_bytes(),
        }


def _write_zip(path: Path, contents: Mapping[str, bytes]) -> None:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in contents.items():
            entry = zipfile.ZipInfo(name, _ZIP_TIME)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = 3  # of all platforms the same
            entry.external_attr = (0o755 if name.startswith("binaries/") else 0o644) << 16
            archive.writestr(entry, content)


def checked_path(path: str | Path, *, overwrite: bool) -> Path:
    """Path of an FMU to write; OutputError where it cannot be written or has another suffix."""
    path = Path(path)
    if path.suffix != ".fmu":
        raise OutputError(f"{path}: importers want the suffix .fmu; write {path.stem}.fmu")
    check_writable(path, force=overwrite)
    return path


def export_fmu(model: Model, path: str | Path, *, overwrite: bool = False) -> Path:
    """Write the FMU of a model; the file appears whole or not at all.

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
        where the compiler refuses
    """
    path = checked_path(path, overwrite=overwrite)
    contents = _contents(model)
    write_file(path, lambda target: _write_zip(target, contents), force=overwrite)
    return path
