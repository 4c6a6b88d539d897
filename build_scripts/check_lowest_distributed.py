"""Run the cluster tests with the lowest version of distributed that pyproject.toml allows.

    python build_scripts/check_lowest_distributed.py [arguments of pytest]

The newest is what the environment has. The lowest is installed beside it, in a folder that is gone
afterwards.
"""

import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
TESTS = ROOT / "tests" / "sweeps" / "test_dask.py"


def lowest() -> str:
    """The version, as in ``distributed>=2024.8``."""
    found = re.search(r'"distributed>=([\d.]+)', (ROOT / "pyproject.toml").read_text())
    if found is None:
        raise SystemExit("pyproject.toml names no lowest version of distributed")
    return found[1]


def main() -> int:
    """Install it, and run the tests; their exit status."""
    wanted = [f"{package}=={lowest()}.*" for package in ("dask", "distributed")]
    with tempfile.TemporaryDirectory() as folder:
        pip = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--target", folder]
        subprocess.run([*pip, *wanted], check=True)
        path = os.pathsep.join(filter(None, [folder, os.environ.get("PYTHONPATH")]))
        tests = [sys.executable, "-m", "pytest", "-n0", str(TESTS), *sys.argv[1:]]
        return subprocess.run(tests, cwd=ROOT, env=os.environ | {"PYTHONPATH": path}).returncode


if __name__ == "__main__":
    sys.exit(main())
