"""Run the tests that are too long for CI: every pair of effects, a fit of every effect.

    python build_scripts/run_long_studies.py [arguments of pytest]

About half an hour on one core. They are the tests marked ``slow``, of which CI runs a sample.
"""

import sys
from pathlib import Path

import pytest

TESTS = Path(__file__).resolve().parents[1] / "tests"

if __name__ == "__main__":
    sys.exit(pytest.main(["-m", "slow", str(TESTS), *sys.argv[1:]]))
