"""Model to FMU: co-simulation and model exchange in one file, for FMI 2.0 or 3.0."""

import re
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Literal, get_args

from elastic_tendon.actuator.interfaces import AS_RECORDED
from elastic_tendon.actuator.model import build
from elastic_tendon.actuator.motion_kind import MotionKind
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.system import HybridSystem
from elastic_tendon.actuator.variables import Variable
from elastic_tendon.errors import BuildError, EvidenceError
from elastic_tendon.evidence.gather import Evidence
from elastic_tendon.evidence.seal import Signer, add_seal, load_signer
from elastic_tendon.fmu import description, fmi2_description, fmi3_description
from elastic_tendon.fmu.bill_of_materials import bill_of_materials
from elastic_tendon.fmu.dependencies import dependencies
from elastic_tendon.fmu.documentation import documentation
from elastic_tendon.fmu.icon import flanges, icon
from elastic_tendon.fmu.live import fmu_panel
from elastic_tendon.fmu.mach_o import universal
from elastic_tendon.fmu.packing import checked_path, write_archive
from elastic_tendon.fmu.sources import declare_sources, source_files
from elastic_tendon.fmu.terminals import terminals_and_icons
from elastic_tendon.native.binary import compile_binaries, write_sources, write_token
from elastic_tendon.native.compiler import Platform, platforms_named
from elastic_tendon.native.layout import layout
from elastic_tendon.native.library import DEFAULT_TOLERANCE
from elastic_tendon.output import write_file
from elastic_tendon.progress import Progress, silent

FmiVersion = Literal[2, 3]
_LONGEST_IDENTIFIER = 64  # characters; file systems and old importers have limits
_DESCRIPTIONS = {2: fmi2_description, 3: fmi3_description}


def model_identifier(name: str) -> str:
    """C identifier for a model's name, which FMI wants for the binary's file name."""
    identifier = re.sub(r"\W", "_", name, flags=re.ASCII)
    if not re.match("[A-Za-z]", identifier):
        identifier = f"model_{identifier}"
    return identifier[:_LONGEST_IDENTIFIER]


def _variant_name(model: Model) -> str:
    """The model's name, and its interface where that is not the default."""
    kind = model.kind
    return model.name if kind in AS_RECORDED else f"{model.name}, interface {kind}"


def _moving(variable: Variable, model: Model) -> Variable:
    """The variable in the units and words of the model's motion."""
    if model.motion is MotionKind.ROTARY:
        return variable
    own = {quantity.path: quantity for quantity in model.quantities()}.get(variable.name)
    unit = model.motion.unit(variable.unit) if own is None else own.unit
    return replace(variable, unit=unit, meaning=model.motion.words(variable.meaning))


def describe(
    model: Model,
    system: HybridSystem,
    fmi_version: FmiVersion,
    validity: Mapping[str, tuple[float, float]] | None = None,
) -> description.Description:
    """What the FMU of a model says of itself."""
    rows = layout(system.interface, model.values(), indicators=fmi_version == 3, validity=validity)
    return description.Description(
        name=_variant_name(model),
        identifier=model_identifier(model.name),
        interface=system.interface,
        variables=tuple(replace(row, variable=_moving(row.variable, model)) for row in rows),
        dependencies=dependencies(system),
        co_simulation=_DESCRIPTIONS[fmi_version].CO_SIMULATION,
        model_exchange=_DESCRIPTIONS[fmi_version].MODEL_EXCHANGE,
    )


def _binaries(
    built: Mapping[Platform, bytes], identifier: str, fmi_version: FmiVersion
) -> dict[str, bytes]:
    """Libraries by their path; those of one folder, as FMI 2.0 has it for macOS, become one."""
    of_path: dict[str, list[bytes]] = {}
    for platform, library in built.items():
        path = f"binaries/{platform.folder(fmi_version)}/{identifier}{platform.suffix}"
        of_path.setdefault(path, []).append(library)
    return {
        path: libraries[0] if len(libraries) == 1 else universal(libraries)
        for path, libraries in of_path.items()
    }


def _icon_and_terminals(fmi_version: FmiVersion, model: Model) -> dict[str, bytes]:
    """Files for drawing and connecting the FMU by their path in it."""
    if fmi_version == 2:
        return {"model.png": icon()["icon.png"]}
    terminals = description.to_bytes(terminals_and_icons(model.kind, model.motion))
    files = {"terminalsAndIcons.xml": terminals, **icon(), **flanges()}
    return {f"terminalsAndIcons/{name}": content for name, content in files.items()}


def _contents(
    model: Model,
    fmi_version: FmiVersion,
    platforms: Sequence[Platform],
    source: bool,
    validity: Mapping[str, tuple[float, float]] | None,
    progress: Progress,
) -> dict[str, bytes]:
    """Files of the FMU by their path in it."""
    system = build(*model.structure)
    described = describe(model, system, fmi_version, validity)
    root = _DESCRIPTIONS[fmi_version].model_description(described)
    if source and fmi_version == 2:
        declare_sources(root)
    with ThreadPoolExecutor(1) as beside, tempfile.TemporaryDirectory() as work:
        panel = beside.submit(fmu_panel, model)  # its module is compiled while the binaries are
        folder = Path(work)
        key = write_sources(
            *(folder, system, described.variables),
            tolerance=DEFAULT_TOLERANCE,
            fmi_version=fmi_version,
        )
        token = description.seal(root, key)
        write_token(folder, token)
        built = compile_binaries(folder, described.identifier, platforms, progress)
        sources = source_files(folder, described.identifier, fmi_version) if source else {}
    binaries = _binaries(built, described.identifier, fmi_version)
    return {
        "modelDescription.xml": description.to_bytes(root),
        **binaries,
        **bill_of_materials(model.name, token, binaries, fmi_version),
        **sources,
        **documentation(
            *(model, described.variables, fmi_version),
            library=described.identifier if source else None,
            panel=panel.result(),
        ),
        **_icon_and_terminals(fmi_version, model),
    }


def export_fmu(
    model: Model,
    path: str | Path,
    *,
    fmi_version: FmiVersion = 2,
    platforms: str | Iterable[str] | None = None,
    source: bool = False,
    evidence: Evidence | None = None,
    sign: str | Path | None = None,
    outside_validity: bool = False,
    overwrite: bool = False,
    progress: Progress = silent,
) -> Path:
    """Write the FMU of a model; the file appears whole or not at all.

    Equal models give equal files, on whatever platform and wherever they are written.

    Parameters
    ----------
    model : Model
    path : of the file, ending in .fmu
    fmi_version : 2 for FMI 2.0, 3 for FMI 3.0
    platforms : names of platforms that the FMU is to run on, as "x86_64-windows", or "all"; the
        one this Python runs on where missing
    source : whether the C code is packed too, for platforms that are not among these
    evidence : from `gather_evidence` of this model: what the FMU carries as proof
    sign : file of an Ed25519 key (PEM) that the evidence is signed with; the key is not packed
    outside_validity : whether a Boolean output of this name tells when inputs or motion leave the
        range of the evidence
    overwrite : whether an existing file may be replaced
    progress : called with what is being done, and the share of the work that is done

    Returns
    -------
    Path, that of the file

    Raises
    ------
    OutputError
        where the file exists, cannot be written or does not end in .fmu
    BuildError
        for an unknown version or platform, or where the compiler refuses
    EvidenceError
        for evidence of another model, a key that cannot be used, or one without evidence
    """
    path = checked_path(path, overwrite=overwrite)
    if fmi_version not in get_args(FmiVersion):
        raise BuildError(f"there is no FMI version {fmi_version!r} here; choose 2 or 3")
    signer = _signer(model, evidence, sign)
    validity = None
    if outside_validity:
        if evidence is None:
            raise EvidenceError("outside_validity needs evidence, which has the range; give it too")
        validity = evidence.validity
    targets = platforms_named(platforms)
    contents = _contents(model, fmi_version, targets, source, validity, progress)

    def write(target: Path) -> None:
        if evidence is None:
            write_archive(target, contents)
        else:
            proof = evidence.contents(signer.public if signer else None)
            write_archive(target, contents | proof)
            add_seal(target, signer)

    write_file(path, write, force=overwrite)
    return path


def _signer(model: Model, evidence: Evidence | None, sign: str | Path | None) -> Signer | None:
    if evidence is None and sign is not None:
        raise EvidenceError("what is signed is evidence; give it too")
    if evidence is not None and evidence.model != model:
        raise EvidenceError("the evidence is of another model; gather it of the one to export")
    return None if sign is None else load_signer(sign)
