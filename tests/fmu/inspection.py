"""What the headers of a shared library say, whatever platform it is for."""

from dataclasses import dataclass

import lief

lief.logging.disable()  # it complains of what it can read all the same

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
    parsed = lief.parse(content)
    if isinstance(parsed, lief.ELF.Binary):
        return [_elf(parsed)]
    if isinstance(parsed, lief.PE.Binary):
        return [_windows(parsed)]
    universal = lief.MachO.parse(content)  # named, for lief lets go of its parts with it
    return [_mach_o(one) for one in universal]


def _elf(library: lief.ELF.Binary) -> Library:
    needed = {
        one.name
        for requirement in library.symbols_version_requirement
        for one in requirement.get_auxiliary_symbols()
    }
    versions = [tuple(map(int, one.removeprefix("GLIBC_").split("."))) for one in needed]
    return Library(
        f"linux {library.header.machine_type.name}",
        frozenset(one.name for one in library.exported_symbols),
        frozenset(library.libraries),
        max(versions),
        signed=False,
    )


def _windows(library: lief.PE.Binary) -> Library:
    return Library(
        f"windows {library.header.machine.name}",
        frozenset(one.name for one in library.get_export().entries),
        frozenset(one.name for one in library.imports),
        None,
        signed=bool(library.signatures),
    )


def _mach_o(library: lief.MachO.Binary) -> Library:
    own, *others = [one.name for one in library.libraries]
    assert own.startswith("@rpath/")
    shown = {one.symbol.name.removeprefix("_") for one in library.dyld_info.exports}
    return Library(
        f"darwin {library.header.cpu_type.name}",
        frozenset(shown - _ADDED_BY_THE_LINKER),
        frozenset(others),
        tuple(library.build_version.minos),
        signed=library.has_code_signature,
    )
