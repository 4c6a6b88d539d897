"""What the headers of a shared library say, whatever platform it is for."""

import io
import tempfile
from dataclasses import dataclass
from pathlib import Path

from elftools.elf.elffile import ELFFile
from macholib import mach_o
from macholib.MachO import MachO, MachOHeader
from macholib.SymbolTable import SymbolTable
from pefile import MACHINE_TYPE, PE

_ADDED_BY_THE_LINKER = {"_mh_dylib_header", "__dso_handle"}  # each library's own, on macOS


@dataclass(frozen=True)
class Library:
    """One library; `imports` are the names of the libraries it needs.

    `oldest` is the oldest C library (Linux) or system (macOS) that it runs on, a version.
    """

    machine: str
    functions: frozenset[str]
    imports: frozenset[str]
    oldest: tuple[int, ...] | None
    signed: bool


def inspect(content: bytes) -> list[Library]:
    """The libraries in a file, several in a universal one of macOS."""
    if content.startswith(b"\x7fELF"):
        return [_elf(ELFFile(io.BytesIO(content)))]
    if content.startswith(b"MZ"):
        return [_windows(PE(data=content))]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "library"
        path.write_bytes(content)
        parsed = MachO(str(path))
        return [_mach_o(parsed, header) for header in parsed.headers]


def _elf(library: ELFFile) -> Library:
    needed = {
        one.name
        for _, requirement in library.get_section_by_name(".gnu.version_r").iter_versions()
        for one in requirement
    }
    versions = [tuple(map(int, one.removeprefix("GLIBC_").split("."))) for one in needed]
    symbols = library.get_section_by_name(".dynsym").iter_symbols()
    tags = library.get_section_by_name(".dynamic").iter_tags("DT_NEEDED")
    return Library(
        f"linux {library.header.e_machine.removeprefix('EM_')}",
        frozenset(one.name for one in symbols if one.name and one["st_shndx"] != "SHN_UNDEF"),
        frozenset(one.needed for one in tags),
        max(versions),
        signed=False,
    )


def _windows(library: PE) -> Library:
    machine = MACHINE_TYPE[library.FILE_HEADER.Machine].removeprefix("IMAGE_FILE_MACHINE_")
    return Library(
        f"windows {machine}",
        frozenset(one.name.decode() for one in library.DIRECTORY_ENTRY_EXPORT.symbols),
        frozenset(one.dll.decode() for one in library.DIRECTORY_ENTRY_IMPORT),
        None,
        signed=hasattr(library, "DIRECTORY_ENTRY_SECURITY"),
    )


def _mach_o(parsed: MachO, header: MachOHeader) -> Library:
    commands = {load.get_cmd_name(): (content, data) for load, content, data in header.commands}
    _, own = commands["LC_ID_DYLIB"]
    assert own.startswith(b"@rpath/")
    packed, _ = commands["LC_BUILD_VERSION"]
    oldest = int(packed.minos)
    shown = {name.decode().removeprefix("_") for _, name in SymbolTable(parsed, header).extdefsyms}
    return Library(
        f"darwin {mach_o.CPU_TYPE_NAMES[header.header.cputype]}",
        frozenset(shown - _ADDED_BY_THE_LINKER),
        frozenset(name for _, _, name in header.walkRelocatables()),
        (oldest >> 16, oldest >> 8 & 0xFF, oldest & 0xFF),
        signed="LC_CODE_SIGNATURE" in commands,
    )
