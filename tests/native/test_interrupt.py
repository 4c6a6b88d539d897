"""Ctrl-C ends what the library and the compiler do; the signal goes to this process alone."""

import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.simulation.simulate import sensitivities, simulate, simulate_many

WITHIN = 2.0  # s of the processor
DELAY = 0.2  # s, after which the signal comes
MODEL = load_model("biorob_x4_joint_3")

_COMPILE = """
import sys
from elastic_tendon import export_fmu, load_model
def progress(text, share):
    print(text, flush=True)
export_fmu(load_model("biorob_x4_joint_3"), sys.argv[1], platforms="all", progress=progress)
"""
_BUILD = """
from elastic_tendon.native.library import library_path
library_path((), progress=lambda text, share: print(text, flush=True))
"""


def _motion(n):
    time = 0.002 * np.arange(n)
    return time, 0.3 * np.sin(9.0 * time) * np.sin(3.0 * time)


# each takes many times `WITHIN` undisturbed
def _one_long_motion():
    simulate(MODEL, *_motion(3_000_000), tolerance=1e-14)


def _derivatives():
    names = ("link.inertia", "link.damping", "transmission.pretension_force")
    sensitivities(MODEL, *_motion(800_000), parameters=names, tolerance=1e-14)


def _many_runs():
    inertia = np.linspace(0.01, 0.05, 500_000)
    simulate_many(MODEL, {"link.inertia": inertia}, *_motion(100), outputs=["joint_position"])


def _one_sample():
    simulate(MODEL, [0.0, 1e5], [0.0, 1e3], tolerance=1e-14)


@pytest.fixture
def answer():
    """Sets what answers Ctrl-C; in the background that may be nothing."""
    before = signal.getsignal(signal.SIGINT)
    yield lambda handler: signal.signal(signal.SIGINT, handler)
    signal.signal(signal.SIGINT, before)


@pytest.fixture
def interrupt_soon():
    """Function that sends the signal after `DELAY`."""
    timer = threading.Timer(DELAY, os.kill, (os.getpid(), signal.SIGINT))
    yield timer.start
    timer.cancel()


@pytest.mark.parametrize("work", [_one_long_motion, _derivatives, _many_runs, _one_sample])
def test_a_call_of_the_library_ends(work, answer, interrupt_soon):
    simulate(MODEL, *_motion(10))  # compiles
    answer(signal.default_int_handler)
    interrupt_soon()
    begin = time.process_time()
    with pytest.raises(KeyboardInterrupt):
        work()
    assert time.process_time() - begin < DELAY + WITHIN
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_where_the_answer_raises_nothing_the_result_is_whole(answer, interrupt_soon):
    # longer than the library goes on without asking, so that it is ended and begins again
    inertia = {"link.inertia": np.linspace(0.01, 0.05, 500)}
    arguments = (MODEL, inertia, *_motion(20_000))
    known = simulate_many(*arguments, outputs=["joint_position"])
    heard = []
    answer(lambda number, _frame: heard.append(number))
    interrupt_soon()
    again = simulate_many(*arguments, outputs=["joint_position"])
    assert heard == [signal.SIGINT]
    assert np.array_equal(again.outputs, known.outputs)


@pytest.mark.parametrize("script", [_COMPILE, _BUILD])
def test_a_compiler_ends_at_once(script, tmp_path):
    process = subprocess.Popen(
        [sys.executable, "-c", script, str(tmp_path / "x.fmu")],
        env=os.environ | {"ELASTIC_TENDON_CACHE": str(tmp_path / "cache")},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    process.stdout.readline()  # it has begun to build
    time.sleep(DELAY)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate()
    assert errors.rstrip().endswith("KeyboardInterrupt")
    assert not (tmp_path / "x.fmu").exists()
    assert list((tmp_path).rglob("*.so")) == []
