"""The FMU's file: a zip archive that equal contents make equal."""

import zipfile
from collections.abc import Mapping
from pathlib import Path

from elastic_tendon.output import OutputError, check_writable

_TIME = (1980, 1, 1, 0, 0, 0)  # the earliest that a zip archive can hold
_UNIX = 3  # as if made there, wherever it was made


def checked_path(path: str | Path, *, overwrite: bool) -> Path:
    """Path of an FMU to write; OutputError where it cannot be written or has another suffix."""
    path = Path(path)
    if path.is_dir():
        raise OutputError(f"{path}: this is a folder; name a file in it that ends in .fmu")
    if path.suffix != ".fmu":
        raise OutputError(f"{path}: importers want the suffix .fmu; write {path.stem}.fmu")
    check_writable(path, force=overwrite)
    return path


def write_archive(path: Path, contents: Mapping[str, bytes]) -> None:
    """Write a zip archive.

    Parameters
    ----------
    path : file to write
    contents : content of each file by its path in the archive, with forward slashes
    """
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in sorted(contents.items()):
            entry = zipfile.ZipInfo(name, _TIME)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = _UNIX
            entry.external_attr = (0o755 if name.startswith("binaries/") else 0o644) << 16
            archive.writestr(entry, content, compresslevel=9)
