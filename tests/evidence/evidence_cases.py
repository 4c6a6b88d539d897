"""A model that fits the demo's recordings, what a diagnosis said of it, and FMUs written anew."""

import io
import zipfile
from pathlib import Path

import elastic_tendon as et
from elastic_tendon.evidence.seal import SEAL, add_seal, load_signer
from elastic_tendon.fmu.packing import write_archive

FITTED = {
    "transmission.upper_spring.stiffness": 12158.360716467852,
    "transmission.lower_spring.stiffness": 11231.978853228678,
    "transmission.pretension_force": 70.40653523687618,
    "link.inertia": 0.03390116417356976,
    "link.damping": 0.19990600877912165,
    "effects.coulomb_friction.torque": 0.34999402293519366,
}


def friction_model() -> et.Model:
    """As the diagnosis of the demo finds it."""
    return et.load_demo().model.with_effect("coulomb_friction", {}).with_values(FITTED)


def friction_diagnosis() -> dict:
    """What the evidence takes of the JSON of that diagnosis."""
    return {
        "schema": "elastic-tendon/diagnosis/2",
        "verdict": "missing_effect",
        "sentence": "Coulomb friction is missing, says /home/alice/logs/a.csv; 0.1 N·m/rad.",
        "complete": True,
        "added": ["coulomb_friction"],
        "certainty": {"coulomb_friction": 0.995},
        "parameters_changed": ["link.inertia"],
        "remaining": {},
        "ladder": [{"title": "as given", "rmse": {"joint_position": 0.0375}}],
        "parameters": [
            {"path": "link.inertia", "sigma": 3e-6, "interval": [0.03389, 0.03391]},
        ],
        "fitted_files": ["demo_fit.csv"],
        "heldout_files": ["demo_validate.csv"],
        "rounds": [
            {
                "chosen": ["coulomb_friction"],
                "candidates": [
                    {"ids": [one], "fitted": fitted, "reason": "", "heldout_gain": None}
                    for one, fitted in (
                        ("coulomb_friction", True),
                        ("lugre_friction", True),
                        ("gear_backlash", False),
                    )
                ],
            }
        ],
        "model": friction_model().model_dump(mode="json", exclude_none=True),
    }


def contents(path: Path) -> dict[str, bytes]:
    """Files of an FMU."""
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def packed(path: Path, files: dict[str, bytes]) -> bytes:
    """Bytes of an FMU of these files, written to a path; a seal is a file like another."""
    write_archive(path, files)
    return path.read_bytes()


def resealed(path: Path, files: dict[str, bytes], key: Path | None = None) -> bytes:
    """As who can write a seal, but has no key, or another one."""
    write_archive(path, {name: content for name, content in files.items() if name != SEAL})
    add_seal(path, None if key is None else load_signer(key))
    return path.read_bytes()


def entry(whole: bytes, name: str) -> int:
    """Where a file's head stands in an FMU."""
    with zipfile.ZipFile(io.BytesIO(whole)) as archive:
        return archive.getinfo(name).header_offset
