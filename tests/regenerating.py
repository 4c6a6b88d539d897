"""What build scripts write, written anew."""

import subprocess
import sys
from pathlib import Path

SCRIPTS = Path(__file__).resolve().parents[1] / "build_scripts"


def regenerated(script: str, folder: Path) -> Path:
    """The folder, into which a script has written; a warning is a failure."""
    command = [sys.executable, "-W", "error", str(SCRIPTS / script), "--output", str(folder)]
    subprocess.run(command, check=True, capture_output=True)
    return folder
