"""The one compiler: zig cc from PyPI, the same for the cached library and for FMUs."""

import importlib.util
import platform
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

from elastic_tendon.errors import BuildError

RUNTIME = Path(__file__).parent / "runtime"

_FLAGS = (
    "-std=c11",
    "-O2",
    "-g0",
    "-s",
    "-shared",
    "-fPIC",
    "-fvisibility=hidden",
    "-ffp-contract=off",  # else aarch64 rounds differently
    "-fno-math-errno",
    "-Wall",
    "-Wno-unused-function",
)


@dataclass(frozen=True)
class Platform:
    """A target: zig's triple, FMI 2 folder of the binary, its suffix and linker flags."""

    target: str
    fmi2_folder: str
    suffix: str
    flags: tuple[str, ...]


_ELF = ("-Wl,-z,defs", "-lm")
PLATFORMS = {
    ("Linux", "x86_64"): Platform("x86_64-linux-gnu.2.17", "linux64", ".so", _ELF),
    ("Linux", "aarch64"): Platform("aarch64-linux-gnu.2.17", "aarch64-linux", ".so", _ELF),
    ("Windows", "AMD64"): Platform("x86_64-windows-gnu", "win64", ".dll", ()),
    ("Darwin", "x86_64"): Platform("x86_64-macos.11.0", "darwin64", ".dylib", ()),
    ("Darwin", "arm64"): Platform("aarch64-macos.11.0", "darwin64", ".dylib", ()),
}


def host_platform() -> Platform:
    """The platform this Python runs on; BuildError where no binary can be made for it."""
    key = (platform.system(), platform.machine())
    if key not in PLATFORMS:
        known = ", ".join(" ".join(names) for names in PLATFORMS)
        raise BuildError(f"no binary can be built for {' '.join(key)}; known platforms: {known}")
    return PLATFORMS[key]


def toolchain() -> str:
    """What the binary depends on besides its sources: compiler version and flags."""
    tools = " ".join(f"{name} {version(name)}" for name in ("ziglang", "casadi", "fmpy"))
    return f"{tools} {' '.join(_FLAGS)}"


def fmi_headers() -> Path:
    """Folder of the FMI standard's C headers, which come with fmpy (it is not imported)."""
    found = importlib.util.find_spec("fmpy")
    folders = found.submodule_search_locations if found else None
    if not folders:
        raise BuildError("fmpy, which brings the FMI headers, is missing; pip install fmpy")
    return Path(folders[0]) / "c-code"


def compile_library(
    source: Path, output: Path, target: Platform, include: Sequence[Path] = ()
) -> None:
    """Compile one C file (which includes the rest) into a shared library.

    Parameters
    ----------
    source : C file; its folder, `RUNTIME` and the FMI headers are searched for includes
    output : shared library to write
    target : platform to build for
    include : further folders with headers

    Raises
    ------
    BuildError
        with the compiler's first error
    """
    folders = (source.parent, RUNTIME, fmi_headers(), *include)
    command = [
        *(sys.executable, "-m", "ziglang", "cc", "-target", target.target),
        *_FLAGS,
        *(f"-I{folder}" for folder in folders),
        *(str(source), "-o", str(output)),
        *target.flags,
    ]
    try:
        run = subprocess.run(command, capture_output=True, text=True, check=False)
    except OSError as error:
        raise BuildError(f"the compiler cannot be started: {error.strerror}") from error
    if run.returncode != 0:
        errors = [line for line in run.stderr.splitlines() if "error" in line]
        raise BuildError(
            f"the compiler refused the generated C: {(errors or [run.stderr.strip()])[0]}"
        )
