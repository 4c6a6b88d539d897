"""Every example runs and writes the pictures it speaks of."""

import importlib.util
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = sorted((Path(__file__).parents[1] / "examples").glob("*/run.py"))


def _check_system_simulation(printed):
    """A tendon goes slack; both simulators of the SSP step alike, so they differ by rounding."""
    assert float(re.search(r"slack for (\d+) ms", printed)[1]) > 0
    apart = [float(one) for one in re.findall(r"joint (\S+) rad from fmpy's", printed)]
    assert len(apart) == (2 if importlib.util.find_spec("ecospy") else 0)
    assert all(one < 1e-12 for one in apart)


CHECKS = {"system_simulation": _check_system_simulation}


@pytest.mark.parametrize("script", EXAMPLES, ids=lambda script: script.parent.name)
def test_example_runs(script, tmp_path):
    run = subprocess.run(
        [sys.executable, "-W", "error", str(script), str(tmp_path)],
        cwd=tmp_path,
        env=os.environ | {"MPLBACKEND": "Agg"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stdout + run.stderr
    assert run.stdout
    assert list(tmp_path.glob("*.png"))
    if check := CHECKS.get(script.parent.name):
        check(run.stdout)


def test_there_are_examples():
    assert EXAMPLES
