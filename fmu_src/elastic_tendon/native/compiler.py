"""The one compiler: zig cc from PyPI, the same for the cached library and for FMUs.

The environment variable ``ELASTIC_TENDON_CC`` names a gcc or clang of the machine's own instead, as
in ``ELASTIC_TENDON_CC=gcc`` or ``ELASTIC_TENDON_CC="ccache clang"``. It serves the platform that
this runs on; binaries for others are always zig's. An FMU that such a compiler made needs the C
library of the machine it was made on, or a newer one.
"""

import importlib.util
import os
import platform
import shlex
import subprocess
import sys
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path
from threading import Event

from elastic_tendon.errors import BuildError

RUNTIME = Path(__file__).parent / "runtime"
OWN_COMPILER = "ELASTIC_TENDON_CC"
_PATIENCE = 0.2  # s, after which it is looked whether the compiler is still wanted

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
    "-fno-slp-vectorize",  # packs the few states into vectors, and then waits for shuffling them
    "-Wall",
    "-Wno-unused-function",
)
_OF_SHARED = ("-shared", "-fPIC")  # a module for a page is no shared library
_GCC_NAMES = {"-fno-slp-vectorize": "-fno-tree-slp-vectorize"}  # which clang understands too


@dataclass(frozen=True)
class Platform:
    """A platform that a binary can be built for.

    `name` is its folder in an FMU of FMI 3.0, `fmi2_folder` that of FMI 2.0, `target` what zig
    calls it.
    """

    name: str
    target: str
    fmi2_folder: str
    suffix: str

    def folder(self, fmi_version: int) -> str:
        """Folder of its binary below ``binaries/``."""
        return self.name if fmi_version == 3 else self.fmi2_folder


PLATFORMS = {
    platform.name: platform
    for platform in (
        Platform("x86_64-linux", "x86_64-linux-gnu.2.17", "linux64", ".so"),
        Platform("aarch64-linux", "aarch64-linux-gnu.2.17", "aarch64-linux", ".so"),
        Platform("x86_64-windows", "x86_64-windows-gnu", "win64", ".dll"),
        Platform("x86_64-darwin", "x86_64-macos.11.0", "darwin64", ".dylib"),
        Platform("aarch64-darwin", "aarch64-macos.11.0", "darwin64", ".dylib"),
    )
}
# what a browser runs inside a page, by `page.c`; no platform for FMUs
PAGE = Platform("page", "wasm32-freestanding", "", ".wasm")
ALL = "all"
_HOSTS = {  # what Python calls them
    ("Linux", "x86_64"): "x86_64-linux",
    ("Linux", "aarch64"): "aarch64-linux",
    ("Windows", "AMD64"): "x86_64-windows",
    ("Darwin", "x86_64"): "x86_64-darwin",
    ("Darwin", "arm64"): "aarch64-darwin",
}


def host_platform() -> Platform:
    """The platform this Python runs on; BuildError where no binary can be made for it."""
    key = (platform.system(), platform.machine())
    if key not in _HOSTS:
        raise BuildError(
            f"no binary can be built for {' '.join(key)}; known platforms: {', '.join(PLATFORMS)}"
        )
    return PLATFORMS[_HOSTS[key]]


def _by_any_name() -> dict[str, tuple[Platform, ...]]:
    """Platforms by what people call them: the folders of both versions of FMI, and all of them."""
    platforms = tuple(PLATFORMS.values())
    folders = {platform.folder(version) for platform in platforms for version in (2, 3)}
    named = {
        folder: tuple(
            platform for platform in platforms if folder in (platform.name, platform.fmi2_folder)
        )
        for folder in folders
    }
    return named | {ALL: platforms}


def platforms_named(names: str | Iterable[str] | None) -> tuple[Platform, ...]:
    """Platforms by name, each once and in the order of `PLATFORMS`.

    Parameters
    ----------
    names : a name, names joined by commas, several of both, or "all"; none: the host's. The
        folders of FMI 2.0 are names too, as "linux64"; "darwin64" is both of macOS

    Raises
    ------
    BuildError
        for a name that is not known
    """
    if not names:
        return (host_platform(),)
    listed = [names] if isinstance(names, str) else list(names)
    wanted = {part.strip() for name in listed for part in name.split(",")}
    known = _by_any_name()
    if unknown := wanted - known.keys():
        raise BuildError(
            f"there is no platform {', '.join(sorted(map(repr, unknown)))}; "
            f"known are {', '.join(PLATFORMS)}, and {ALL} for all of these"
        )
    chosen = {platform for name in wanted for platform in known[name]}
    return tuple(platform for platform in PLATFORMS.values() if platform in chosen)


def _link_flags(library: Path) -> tuple[str, ...]:
    """Linker flags by the suffix of the library to write."""
    return {
        # not zig's own library beside that of C: compiling it took most of the first compilation.
        # defs: else symbols that are missing show when it is loaded only
        ".so": ("-nostdlib", "-Wl,-z,defs", "-lc", "-lm"),
        ".dylib": (f"-Wl,-install_name,@rpath/{library.name}",),  # else where it was built
        ".dll": (),
        ".wasm": ("-Wl,--no-entry", "-rdynamic"),  # a page calls what is marked EXPORT
    }[library.suffix]


def toolchain() -> str:
    """What the binary depends on besides its sources: compiler version and flags."""
    tools = " ".join(f"{name} {version(name)}" for name in ("ziglang", "casadi", "fmpy"))
    return f"{tools} {' '.join(_FLAGS)}"


def own_compiler() -> str:
    """Command and version of the compiler in `OWN_COMPILER`; "" where zig is used."""
    command = _own_command()
    return f"{shlex.join(command)} {_version_of(command)}" if command else ""


def _own_command() -> tuple[str, ...]:
    text = os.environ.get(OWN_COMPILER, "")
    try:
        return tuple(shlex.split(text, posix=os.name != "nt"))
    except ValueError as error:
        raise BuildError(f"{OWN_COMPILER} is {text!r}, which is no command: {error}") from None


@lru_cache
def _version_of(command: tuple[str, ...]) -> str:
    status, messages = _run([*command, "-v"])
    if status != 0:
        raise BuildError(f"{OWN_COMPILER} is {shlex.join(command)!r}, which is no gcc or clang")
    return messages


def _run(command: Sequence[str], stopped: Event | None = None) -> tuple[int, str]:
    """Exit status and messages of a compiler; BuildError where it is not there or was stopped."""
    try:
        with subprocess.Popen(
            command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
        ) as process:
            try:
                return _finished(process, stopped)
            except BaseException:  # also of an interrupt
                process.kill()
                raise
    except OSError as error:
        if command[0] == sys.executable:
            raise BuildError(f"the compiler cannot be started: {error.strerror}") from error
        raise BuildError(
            f"the compiler {command[0]}, which {OWN_COMPILER} names, cannot be started: "
            f"{error.strerror}; name another, or unset it to use the one that is installed with "
            "elastic-tendon"
        ) from error


def _finished(process: subprocess.Popen[str], stopped: Event | None) -> tuple[int, str]:
    while stopped is None or not stopped.is_set():
        with suppress(subprocess.TimeoutExpired):
            _, messages = process.communicate(timeout=_PATIENCE)
            return process.returncode, messages
    raise BuildError("the compiler was stopped")


def _compile_command(target: Platform) -> list[str]:
    """Compiler and flags for a platform."""
    own = _own_command()
    if own and target == host_platform():
        return [*own, *(_GCC_NAMES.get(flag, flag) for flag in _FLAGS)]
    flags = [flag for flag in _FLAGS if target != PAGE or flag not in _OF_SHARED]
    return [*(sys.executable, "-m", "ziglang", "cc", "-target", target.target), *flags]


def _headers(target: Platform) -> list[Path]:
    """Folders of headers, beside those of the C library."""
    of_page = [RUNTIME / "page"] if target == PAGE else []
    return [*of_page, RUNTIME, fmi_headers()]


def fmi_headers() -> Path:
    """Folder of the FMI standard's C headers, which come with fmpy (it is not imported)."""
    specification = importlib.util.find_spec("fmpy")
    folders = specification.submodule_search_locations if specification else None
    if not folders:
        raise BuildError("fmpy, which brings the FMI headers, is missing; pip install fmpy")
    return Path(folders[0]) / "c-code"


def compile_library(
    source: Path,
    output: Path,
    target: Platform,
    include: Sequence[Path] = (),
    stopped: Event | None = None,
) -> None:
    """Compile one C file (which includes the rest) into a shared library.

    Parameters
    ----------
    source : C file; its folder, `RUNTIME` and the FMI headers are searched for includes
    output : shared library to write
    target : platform to build for
    include : further folders with headers
    stopped : when another thread sets it, the compiler ends

    Raises
    ------
    BuildError
        with the compiler's first error, or where it was stopped
    """
    folders = (source.parent, *_headers(target), *include)
    command = [
        *_compile_command(target),
        *(f"-I{folder}" for folder in folders),
        *(str(source), "-o", str(output)),
        *_link_flags(output),
    ]
    status, messages = _run(command, stopped)
    if status != 0:
        errors = [line for line in messages.splitlines() if "error" in line]
        raise BuildError(
            f"the compiler refused the generated C: {(errors or [messages.strip()])[0]}"
        )
