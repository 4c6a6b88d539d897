"""Universal macOS libraries: one file with the library of each architecture."""

import struct
from collections.abc import Sequence

_UNIVERSAL = 0xCAFEBABE
_THIN_64_BIT = 0xFEEDFACF
_ALIGNMENT = 14  # power of 2 at which a library begins: the largest page, that of arm64

_HEADER = struct.Struct(">2I")  # magic, number of libraries
_ENTRY = struct.Struct(">5I")  # architecture, its variant, offset, size, alignment
_THIN_HEADER = struct.Struct("<3I")  # magic, architecture, its variant


def universal(libraries: Sequence[bytes]) -> bytes:
    """Join thin 64-bit Mach-O files of different architectures into a universal one.

    Parameters
    ----------
    libraries : contents of the files

    Returns
    -------
    bytes
        content of the universal file; the libraries are in it unchanged, so signatures hold
    """
    end = _HEADER.size + _ENTRY.size * len(libraries)
    entries, offsets = [], []
    for library in libraries:
        magic, *architecture = _THIN_HEADER.unpack_from(library)
        if magic != _THIN_64_BIT:
            raise ValueError("not a thin 64-bit Mach-O file")
        offsets.append(_aligned(end))
        end = offsets[-1] + len(library)
        entries.append(_ENTRY.pack(*architecture, offsets[-1], len(library), _ALIGNMENT))
    content = bytearray(end)
    head = _HEADER.pack(_UNIVERSAL, len(libraries)) + b"".join(entries)
    content[: len(head)] = head
    for offset, library in zip(offsets, libraries, strict=True):
        content[offset : offset + len(library)] = library
    return bytes(content)


def _aligned(offset: int) -> int:
    page = 1 << _ALIGNMENT
    return -(-offset // page) * page
