"""The seal: hashes of everything in an FMU, signed or not, as its last file.

It holds the hash of each file, and that of all bytes before it in the archive. What follows these
bytes, the seal itself and the archive's table of contents, has to be exactly what it can only be,
so that no byte can change unseen.
"""

import hashlib
import json
import struct
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from elastic_tendon.errors import EvidenceError
from elastic_tendon.evidence.manifest import FOLDER

if TYPE_CHECKING:
    from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey

SEAL = f"{FOLDER}seal.json"
_SCHEMA = "elastic-tendon/seal/1"
_TIME = (1980, 1, 1, 0, 0, 0)
_DOS_DATE = (1 << 5) | 1  # 1980-01-01
_UNIX, _VERSION = 3, 20
_INSTALL = 'install it with pip install "elastic-tendon[sign]"'
_PROGRAM, _FILE = 0o755, 0o644  # modes, as `fmu.packing` sets them


# ---- keys ----------------------------------------------------------------------------------


class Signer:
    """A private key to sign with, which is never written anywhere."""

    def __init__(self, key: "Ed25519PrivateKey") -> None:
        self._key = key
        self.public = key.public_key().public_bytes_raw().hex()

    def sign(self, message: bytes) -> str:
        """Signature as hexadecimal digits."""
        return self._key.sign(message).hex()


def load_signer(path: str | Path) -> Signer:
    """Read a private key.

    Parameters
    ----------
    path : of an Ed25519 key in PEM without a password

    Raises
    ------
    EvidenceError : it is no such key, or the package cryptography is not installed
    """
    from_pem, _, private, _ = _cryptography()
    try:
        key = from_pem(Path(path).read_bytes(), None)
    except OSError as error:
        raise EvidenceError(f"{path}: the key cannot be read ({error.strerror})") from None
    except (ValueError, TypeError):
        raise EvidenceError(
            f"{path}: a private Ed25519 key (PEM, no password) is expected"
        ) from None
    if not isinstance(key, private):
        raise EvidenceError(
            f"{path}: the key is of another kind; make one with openssl genpkey -algorithm ed25519"
        )
    return Signer(key)


def load_public_key(path: str | Path) -> str:
    """Read a public key (PEM); its bytes as hexadecimal digits.

    Raises
    ------
    EvidenceError : it is no Ed25519 key, or the package cryptography is not installed
    """
    _, from_pem, _, public = _cryptography()
    try:
        key = from_pem(Path(path).read_bytes())
    except OSError as error:
        raise EvidenceError(f"{path}: the key cannot be read ({error.strerror})") from None
    except (ValueError, TypeError):
        raise EvidenceError(f"{path}: a public Ed25519 key in PEM is expected") from None
    if not isinstance(key, public):
        raise EvidenceError(f"{path}: the key is of another kind; Ed25519 is expected")
    return str(key.public_bytes_raw().hex())


def _cryptography() -> tuple[Any, Any, Any, Any]:
    try:
        from cryptography.hazmat.primitives.asymmetric import ed25519
        from cryptography.hazmat.primitives.serialization import (
            load_pem_private_key,
            load_pem_public_key,
        )
    except ImportError:
        raise EvidenceError(f"signatures need the package cryptography; {_INSTALL}") from None
    kinds = (ed25519.Ed25519PrivateKey, ed25519.Ed25519PublicKey)
    return load_pem_private_key, load_pem_public_key, *kinds


def _is_signed_by(message: bytes, public: str, value: str) -> bool:
    from_bytes = _cryptography()[3].from_public_bytes
    from cryptography.exceptions import InvalidSignature

    try:
        from_bytes(bytes.fromhex(public)).verify(bytes.fromhex(value), message)
    except (InvalidSignature, ValueError):
        return False
    return True


# ---- sealing -------------------------------------------------------------------------------


def add_seal(path: Path, signer: Signer | None) -> None:
    """Add the seal to an FMU that holds everything else.

    Parameters
    ----------
    path : of the archive, as `fmu.packing.write_archive` writes it
    signer : None: hashes without a signature
    """
    with zipfile.ZipFile(path) as archive:
        files = {name: _hash(archive.read(name)) for name in archive.namelist()}
        before = path.read_bytes()[: archive.start_dir]
    facts = {"schema": _SCHEMA, "archive": _hash(before), "files": files}
    signature = None
    if signer is not None:
        value = signer.sign(_canonical(facts))
        signature = {"algorithm": "Ed25519", "public_key": signer.public, "value": value}
    entry = zipfile.ZipInfo(SEAL, _TIME)
    entry.create_system = _UNIX
    entry.external_attr = _FILE << 16
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr(entry, _canonical(facts | {"signature": signature}))


def _hash(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def _canonical(content: Mapping[str, Any]) -> bytes:
    return (json.dumps(content, sort_keys=True, indent=0) + "\n").encode()


# ---- checking ------------------------------------------------------------------------------


def check_seal(whole: bytes, files: Mapping[str, bytes]) -> tuple[list[str], str | None]:
    """What differs from when an FMU was sealed, a sentence each, and who signed it.

    Parameters
    ----------
    whole : bytes of the FMU
    files : content of each of its files

    Returns
    -------
    list of str, and the public key as hexadecimal digits; None: nobody, or not rightly
    """
    if SEAL not in files:
        return ["the seal was taken out: hashes and signature are missing"], None
    try:
        seal = json.loads(files[SEAL])
        facts = {name: seal[name] for name in ("schema", "archive", "files")}
        signature = seal["signature"]
        sealed = dict(facts["files"])
        known = (signature["public_key"], signature["value"]) if signature else None
    except (ValueError, KeyError, TypeError):
        return ["the seal was changed: it cannot be read"], None
    faults = [*_changes(sealed, files), *_outside(whole, files, facts["archive"])]
    if _canonical(facts | {"signature": signature}) != files[SEAL] or facts["schema"] != _SCHEMA:
        faults.append("the seal was changed: it is not as it was written")
    if known is None:
        return faults, None
    if not all(isinstance(text, str) for text in known) or not _is_signed_by(
        _canonical(facts), *known
    ):
        return [*faults, "the signature is wrong: it was made for other content"], None
    return faults, known[0]


def _changes(sealed: Mapping[str, str], files: Mapping[str, bytes]) -> list[str]:
    held = {name: _hash(content) for name, content in files.items() if name != SEAL}
    found = [f"{name} was taken out" for name in sealed.keys() - held.keys()]
    found += [f"{name} was put in" for name in held.keys() - sealed.keys()]
    found += [f"{name} was changed" for name in held if sealed.get(name, held[name]) != held[name]]
    return sorted(found)


def _outside(whole: bytes, files: Mapping[str, bytes], sealed: str) -> list[str]:
    """Changes of bytes that belong to no file: of the archive's structure."""
    entries: list[bytes] = []
    at = start_of_seal = 0
    try:
        while whole[at : at + 4] == b"PK\3\4":
            name, size = _local(whole, at)
            entries.append(_expected_entry(whole, at, name))
            start_of_seal, at = at, at + size
    except (struct.error, ValueError, UnicodeDecodeError):
        return ["the archive was packed anew or changed"]
    local = _expected_local(SEAL, files[SEAL])
    table = b"".join(entries)
    end = struct.pack("<4s4H2LH", b"PK\5\6", 0, 0, *[len(entries)] * 2, len(table), at, 0)
    as_sealed = _hash(whole[:start_of_seal]) == sealed
    if not as_sealed or whole[start_of_seal:] != local + table + end:
        return ["the archive was packed anew or changed between its files"]
    return []


def _local(whole: bytes, at: int) -> tuple[str, int]:
    """Name of a file in the archive, and how many bytes it takes there."""
    compressed, _, name, extra = struct.unpack("<LLHH", whole[at + 18 : at + 30])
    return whole[at + 30 : at + 30 + name].decode(), 30 + name + extra + compressed


def _expected_entry(whole: bytes, at: int, name: str) -> bytes:
    """Line of the table of contents for a file."""
    mode = _PROGRAM if name.startswith("binaries/") else _FILE
    head = struct.pack("<4s2B", b"PK\1\2", _VERSION, _UNIX) + whole[at + 4 : at + 30]
    return head + struct.pack("<3H2L", 0, 0, 0, mode << 16, at) + name.encode()


def _expected_local(name: str, content: bytes) -> bytes:
    """A file that is not compressed, as it stands in the archive."""
    numbers = (_VERSION, 0, zipfile.ZIP_STORED, 0, _DOS_DATE, zlib.crc32(content))
    sizes = (len(content), len(content), len(name), 0)
    return struct.pack("<4s5H3L2H", b"PK\3\4", *numbers, *sizes) + name.encode() + content
