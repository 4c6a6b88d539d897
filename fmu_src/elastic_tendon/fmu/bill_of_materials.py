"""What the binaries of an FMU are made of, for those who must account for it: CycloneDX, licenses.

Names, versions and licenses are those that the packages declare; nothing depends on where or when
the FMU is made.
"""

import hashlib
import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import distribution, version
from pathlib import Path
from typing import Any

from elastic_tendon.native.compiler import fmi_headers

_WINDOWS = "mingw-w64"


@dataclass(frozen=True)
class _Part:
    """Something that binaries contain: the package that brings it, its license, what it is."""

    name: str
    package: str
    license: str
    what: str


_PARTS = (
    _Part("elastic-tendon", "elastic-tendon", "MIT", "solver, events and FMI functions, in C"),
    _Part(
        *("casadi", "casadi", "MIT-0"),
        "its code generator wrote the model's equations, with helper functions that have this "
        "license; the library itself, which has another, is not in here",
    ),
    _Part("fmi-headers", "fmpy", "BSD-2-Clause", "declarations of the FMI standard, as in FMPy"),
    _Part("zig-compiler-rt", "ziglang", "MIT", "the compiler's own run-time functions"),
)
_START_FILES = _Part(
    *(_WINDOWS, "ziglang", "ZPL-2.1"), "start files and import libraries, in binaries for Windows"
)
_WRAPPER = _Part("pythonfmu", "pythonfmu", "MIT", "library and scripts that run the slave's script")


def bill_of_materials(
    name: str,
    token: str,
    binaries: Mapping[str, bytes],
    fmi_version: int,
    *,
    wrapped: bool = False,
) -> dict[str, bytes]:
    """The bill and the licenses by their path in the FMU.

    Parameters
    ----------
    name : of the model
    token : of the FMU
    binaries : content of each library by its path in the FMU
    fmi_version : 2 or 3, whose headers were used
    wrapped : whether pythonfmu runs it
    """
    windows = any(path.endswith(".dll") for path in binaries)
    parts = (*_PARTS, *[_START_FILES] * windows, *[_WRAPPER] * wrapped)
    bill = {
        "bomFormat": "CycloneDX",
        "specVersion": "1.6",
        "version": 1,
        "metadata": {
            "component": {"type": "application", "name": name, "version": token},
            "tools": {"components": [_component(_PARTS[0])]},
        },
        "components": [
            *map(_component, parts),
            *(_file(path, content) for path, content in sorted(binaries.items())),
        ],
    }
    folder = "documentation/licenses"
    files = {
        f"{folder}/casadi.txt": _helpers_license(),
        f"{folder}/fmi_headers.txt": _headers_license(fmi_version),
        f"{folder}/zig.txt": _text("ziglang", "licenses/ziglang/LICENSE"),
        "documentation/bill_of_materials.cdx.json": json.dumps(bill, indent=2) + "\n",
    }
    if windows:
        files[f"{folder}/mingw.txt"] = _text("ziglang", "licenses/ziglang/lib/libc/mingw/COPYING")
    return {path: text.encode() for path, text in files.items()}


def _headers_license(fmi_version: int) -> str:
    """From the copyright to the end of its comment in a header."""
    header = (fmi_headers() / f"fmi{fmi_version}Functions.h").read_text()
    found = re.search(r"Copyright \(C\).*?(?=\*/)", header, re.DOTALL)
    return found[0] if found else "See the headers of the FMI standard, 2-Clause BSD License.\n"


def _helpers_license() -> str:
    """From the head of one of the helper functions that CasADi writes into what it generates."""
    place = distribution("casadi").locate_file("casadi/include/casadi/core/runtime/casadi_fill.hpp")
    head = Path(str(place)).read_text() if Path(str(place)).is_file() else ""
    lines = [line[2:].strip() for line in head.splitlines() if line.startswith("//")]
    text = "\n".join(lines).partition("SYMBOL")[0].strip()
    return f"{text}\n" if text else "MIT No Attribution; see the package casadi.\n"


def _text(package: str, path: str) -> str:
    """A license as a package brings it; where one is packed elsewhere, where it is to be found."""
    return distribution(package).read_text(path) or f"See the package {package}.\n"


def _component(part: _Part) -> dict[str, Any]:
    number = version(part.package)
    return {
        "type": "library",
        "name": part.name,
        "version": number,
        "description": part.what,
        "licenses": [{"license": {"id": part.license}}],
        "purl": f"pkg:pypi/{part.package}@{number}",
    }


def _file(path: str, content: bytes) -> dict[str, Any]:
    digest = hashlib.sha256(content).hexdigest()
    return {"type": "file", "name": path, "hashes": [{"alg": "SHA-256", "content": digest}]}
