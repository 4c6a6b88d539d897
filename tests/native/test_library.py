"""The cache of compiled libraries."""

import os
import subprocess
import sys

import numpy as np
import pytest

from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.errors import BuildError
from elastic_tendon.native import library

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
