"""The compiled library of a structure: built once, cached, loaded.

A structure is an interface with a set of effects. Every number of a model is a run-time argument,
so fitting and screening never compile. A library's name in the cache begins with a key that needs
no CasADi, so that it loads at once; a second one is of what went into it.
"""

import ctypes
import hashlib
import os
import shutil
import tempfile
from functools import cache
from pathlib import Path
from threading import Lock

import platformdirs

from elastic_tendon import effects as catalogue
from elastic_tendon.actuator.interfaces import InterfaceKind
from elastic_tendon.actuator.variables import interface
from elastic_tendon.effects.registry import kept_by_ids
from elastic_tendon.errors import BuildError
from elastic_tendon.native import compiler
from elastic_tendon.native.shared import STRUCTURES, classes
from elastic_tendon.progress import Progress, silent

_PACKAGE = Path(__file__).parents[1]
# that decide on the C, beside a user's own effects; all modules of these folders, because a list of
# those that matter would be forgotten when it grows
_SOURCES = ("actuator/*.py", "effects/*.py", "native/*.py", "native/runtime/**/*.[ch]")

DEFAULT_TOLERANCE = 1e-8

CLASSES = classes(STRUCTURES)
Simulation, Runs = CLASSES["Simulation"], CLASSES["Runs"]  # what the library is called with
EachStep, ListedActuator = CLASSES["EachStep"], CLASSES["ListedActuator"]


# ---- cache ---------------------------------------------------------------------------------


def cache_folder() -> Path:
    """Folder of the compiled libraries: ELASTIC_TENDON_CACHE, else the user's cache folder."""
    chosen = os.environ.get("ELASTIC_TENDON_CACHE")
    return Path(chosen) if chosen else Path(platformdirs.user_cache_dir("elastic-tendon"))


def clear_cache() -> int:
    """Delete all cached libraries; returns how many there were."""
    libraries = [path for path in cache_folder().glob("*-*") if path.is_file()]
    for path in libraries:
        path.unlink(missing_ok=True)
    load.cache_clear()
    return len(libraries)


def structure_key(effect_ids: tuple[str, ...], kind: InterfaceKind = InterfaceKind.POSITION) -> str:
    """Hash of the files and tools that make the library of a structure: known without CasADi."""
    effects = interface(effect_ids, kind).effects
    sources = [path for pattern in _SOURCES for path in sorted(_PACKAGE.glob(pattern))]
    digest = hashlib.sha256(compiler.toolchain().encode())
    digest.update(" ".join((kind, *(effect.id for effect in effects))).encode())
    for source in sources:
        digest.update(source.read_bytes())
    for effect in effects:
        digest.update(catalogue.BY_ID.content(effect))
    return digest.hexdigest()[:32]


def _key_for(key: str, target: compiler.Platform) -> str:
    """Key of the library for a platform and compiler: machines of several kinds may share one."""
    own = "" if target == compiler.PAGE else compiler.own_compiler()
    content = " ".join(part for part in (key, target.target, own) if part)
    return hashlib.sha256(content.encode()).hexdigest()[:32]


def _content_hash(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()[:32]


def _cached(name: str) -> Path | None:
    """A cached library of this name whose content is what its name says; damaged ones go."""
    for path in cache_folder().glob(name):
        if path.stem.split("-")[-1] == _content_hash(path):
            return path
        path.unlink(missing_ok=True)
    return None


def _build(
    effect_ids: tuple[str, ...],
    kind: InterfaceKind,
    target: compiler.Platform,
    key: str,
    progress: Progress,
) -> Path:
    """Put the structure's library into the cache; a rename makes it appear whole or not at all.

    Where Python changed but not the C that it writes, an earlier library of the same C serves.
    """
    from elastic_tendon.actuator.model import build
    from elastic_tendon.native.binary import PAGE, SIMULATION, compile_binary, write_model

    unit = PAGE if target == compiler.PAGE else SIMULATION
    folder = cache_folder()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=folder) as work:
            sources, library = Path(work), Path(work) / f"library{target.suffix}"
            of_sources = _key_for(write_model(sources, build(effect_ids, kind)), target)
            if same := _cached(f"*-{of_sources}-*"):
                shutil.copyfile(same, library)
            else:
                compile_binary(sources, library, target, progress, unit)
            path = folder / f"{key}-{of_sources}-{_content_hash(library)}{target.suffix}"
            os.replace(library, path)
    except OSError as error:
        raise BuildError(
            f"the cache folder {folder} cannot be written ({error.strerror}); "
            "set ELASTIC_TENDON_CACHE to a folder that can"
        ) from error
    return path


def library_path(
    effect_ids: tuple[str, ...],
    kind: InterfaceKind = InterfaceKind.POSITION,
    progress: Progress = silent,
) -> Path:
    """Path of the shared library of a structure, compiled if it is not in the cache.

    Parameters
    ----------
    effect_ids, kind : of the structure
    progress : told what is being built, if it is not in the cache

    Raises
    ------
    BuildError
        where the compiler refuses or the cache folder cannot be written
    """
    return _path_for(compiler.host_platform(), effect_ids, kind, progress)


def page_module(
    effect_ids: tuple[str, ...],
    kind: InterfaceKind = InterfaceKind.POSITION,
    progress: Progress = silent,
) -> bytes:
    """The same library for a page: WebAssembly that imports functions of JavaScript's Math alone.

    Its functions are called with the structures as `shared.places_in_page` has them. It exports
    `malloc` too; arguments and errors are those of `library_path`.
    """
    return _path_for(compiler.PAGE, effect_ids, kind, progress).read_bytes()


def _path_for(
    target: compiler.Platform,
    effect_ids: tuple[str, ...],
    kind: InterfaceKind,
    progress: Progress,
) -> Path:
    key = _key_for(structure_key(effect_ids, kind), target)
    with _lock(key):  # whoever wants it while it is built waits for it
        return _cached(f"{key}-*") or _build(effect_ids, kind, target, key, progress)


@cache
def _lock(_key: str) -> Lock:
    return Lock()


@kept_by_ids
def load(effect_ids: tuple[str, ...], kind: InterfaceKind = InterfaceKind.POSITION) -> ctypes.CDLL:
    """The library of a structure, ready to be called."""
    library = ctypes.CDLL(str(library_path(effect_ids, kind)))
    library.elastic_tendon_simulate.argtypes = [ctypes.POINTER(Simulation)]
    library.elastic_tendon_simulate_many.argtypes = [
        ctypes.POINTER(Simulation),
        ctypes.POINTER(Runs),
    ]
    library.elastic_tendon_each.restype = ctypes.c_longlong
    return library
