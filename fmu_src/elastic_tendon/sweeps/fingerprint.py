"""What results depend on beside the task: the code of this package, and the packages it uses."""

import hashlib
from collections.abc import Iterator, Mapping
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

PACKAGE = Path(__file__).parents[1]
USED = ("elastic-tendon", "numpy", "scipy", "pandas", "casadi")  # whose versions change numbers
CODE = "the code of elastic-tendon"
ADVICE = "install the same on all computers"


@cache
def fingerprint() -> Mapping[str, str]:
    """Versions of packages, and a hash of every file of this one; the same on all computers."""
    return {name: _version(name) for name in USED} | {CODE: _code()}


def differences(wanted: Mapping[str, str]) -> str:
    """What is different in this process, and what to do, in words; "" where nothing is."""
    found = "; ".join(_unlike(wanted, fingerprint()))
    return f"{found}; {ADVICE}" if found else ""


def _unlike(wanted: Mapping[str, str], found: Mapping[str, str]) -> Iterator[str]:
    for name, value in wanted.items():
        here = found.get(name, "absent")
        if here == value:
            continue
        if name == CODE:
            yield f"{CODE} is another, although its version may be the same"
        else:
            yield f"{name} {here} instead of {value}"


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:  # run from a folder of sources
        return "absent"


def _code() -> str:
    digest = hashlib.sha256()
    for path in sorted(PACKAGE.rglob("*")):
        if path.is_file() and path.suffix in {".py", ".c", ".h", ".toml"}:
            content = hashlib.sha256(path.read_bytes()).hexdigest()
            digest.update(f"{path.relative_to(PACKAGE).as_posix()} {content}\n".encode())
    return digest.hexdigest()
