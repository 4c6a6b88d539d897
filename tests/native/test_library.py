"""The cache of compiled libraries."""

import os
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.errors import BuildError
from elastic_tendon.native import compiler, library

BASE: tuple[str, ...] = ()

_SIMULATE = """
import numpy, sys
from elastic_tendon import load_model, simulate
time = numpy.linspace(0.0, 1.0, 101)
model = load_model("biorob_x4_joint_3")
print(repr(float(simulate(model, time, numpy.sin(time))["joint_position"][-1])))
print("casadi" in sys.modules)
"""


@pytest.fixture
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("ELASTIC_TENDON_CACHE", str(tmp_path / "cache"))
    library.load.cache_clear()
    yield tmp_path / "cache"
    library.load.cache_clear()


def _python(cache):
    return subprocess.Popen(
        [sys.executable, "-c", _SIMULATE],
        env=os.environ | {"ELASTIC_TENDON_CACHE": str(cache)},
        stdout=subprocess.PIPE,
        text=True,
    )


def test_two_processes_that_build_at_once_both_succeed_and_leave_one_library(cache):
    processes = [_python(cache) for _ in range(2)]
    answers = [process.communicate()[0] for process in processes]
    assert [process.returncode for process in processes] == [0, 0]
    assert answers[0] == answers[1]
    assert len(list(cache.iterdir())) == 1


def test_threads_that_want_the_same_library_build_it_once(cache, monkeypatch):
    built = []
    build = library._build

    def counted(*arguments):
        built.append(arguments)
        return build(*arguments)

    monkeypatch.setattr(library, "_build", counted)
    with ThreadPoolExecutor(2) as pool:
        first, second = pool.map(library.library_path, [("gravity_load",)] * 2)
    assert first == second
    assert len(built) == len(list(cache.iterdir())) == 1


def test_a_cached_library_is_used_without_casadi(cache):
    path = library.library_path(BASE)
    modified = path.stat().st_mtime_ns
    answer, imported_casadi = _python(cache).communicate()[0].split()
    assert np.isfinite(float(answer))
    assert imported_casadi == "False"
    assert path.stat().st_mtime_ns == modified


def test_a_damaged_entry_is_rebuilt(cache):
    path = library.library_path(BASE)
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    assert library.library_path(BASE).read_bytes() == whole
    assert len(list(cache.iterdir())) == 1


def test_clearing_says_how_many_there_were(cache):
    library.library_path(BASE)
    assert library.clear_cache() == 1
    assert library.clear_cache() == 0
    assert list(cache.iterdir()) == []


def test_the_key_is_the_structure_and_not_the_numbers():
    model = load_model("biorob_x4_joint_3")
    other = load_model("bench_actuator")
    friction = model.with_effect("coulomb_friction", {"torque": 0.1})
    key = library.structure_key(model.effect_ids)
    assert key == library.structure_key(other.effect_ids)
    assert key != library.structure_key(friction.effect_ids)


def test_the_order_of_listing_effects_does_not_matter():
    ids = ("overstretch_protection", "coulomb_friction")
    assert library.structure_key(ids) == library.structure_key(ids[::-1])


def test_a_cache_folder_that_cannot_be_used_is_told(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("ELASTIC_TENDON_CACHE", str(tmp_path / "file"))
    with pytest.raises(BuildError, match="set ELASTIC_TENDON_CACHE to a folder that can"):
        library.library_path(BASE)


def test_python_that_writes_the_same_c_does_not_compile_again(cache, monkeypatch):
    path = library.library_path(BASE)
    monkeypatch.setattr(
        library, "structure_key", lambda *_structure: "of a file with another comment"
    )
    monkeypatch.setattr(compiler, "compile_library", None)  # fails where it is called
    again = library.library_path(BASE)
    assert again != path
    assert again.read_bytes() == path.read_bytes()
    assert len(list(cache.iterdir())) == 2


OWN_COMPILERS = [name for name in ("gcc", "clang") if shutil.which(name)]


@pytest.mark.skipif(not OWN_COMPILERS, reason="there is neither gcc nor clang")
@pytest.mark.parametrize("command", OWN_COMPILERS)
def test_a_compiler_of_the_machines_own_makes_a_library_of_its_own(cache, monkeypatch, command):
    usual, *_ = _python(cache).communicate()[0].split()
    monkeypatch.setenv(compiler.OWN_COMPILER, command)
    own, *_ = _python(cache).communicate()[0].split()
    assert float(own) == pytest.approx(float(usual), abs=1e-9)
    assert len(list(cache.iterdir())) == 2
    monkeypatch.setenv(compiler.OWN_COMPILER, f"{command} -O1")
    key = library._key_for(library.structure_key(BASE), compiler.host_platform())
    assert library._cached(f"{key}-*") is None


@pytest.mark.skipif(not OWN_COMPILERS, reason="there is neither gcc nor clang")
def test_other_platforms_are_built_as_ever(tmp_path, monkeypatch):
    monkeypatch.setenv(compiler.OWN_COMPILER, OWN_COMPILERS[0])
    source = tmp_path / "answer.c"
    source.write_text("int answer(void) { return 42; }")
    other = next(one for one in compiler.PLATFORMS.values() if one.suffix == ".dll")
    compiler.compile_library(source, tmp_path / "answer.dll", other)
    assert (tmp_path / "answer.dll").read_bytes().startswith(b"MZ")


@pytest.mark.parametrize(
    ("command", "problem"),
    [
        ("no-such-cc", "the compiler no-such-cc, which ELASTIC_TENDON_CC names, cannot be started"),
        ("false", "ELASTIC_TENDON_CC is 'false', which is no gcc or clang"),
        ("'gcc", "which is no command: No closing quotation"),
    ],
)
@pytest.mark.usefixtures("cache")
def test_what_is_no_compiler_is_told(monkeypatch, command, problem):
    monkeypatch.setenv(compiler.OWN_COMPILER, command)
    with pytest.raises(BuildError, match=problem):
        library.library_path(BASE)
