"""Two users at two places export the same bytes, and nothing of who and where they are."""

import os
import shutil
import socket
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from elastic_tendon.demo import DATA

ROOT = Path(__file__).parents[2]
COMMANDS = {
    "plain": "elastic-tendon export demo_model.toml --fmi 3 --source -o plain.fmu",
    "evidence": "elastic-tendon export demo_model.toml --with-evidence demo_fit.csv[0:0.5] "
    "-o evidence.fmu",
    "pythonfmu": "build_pythonfmu.py demo_model.toml -o pythonfmu.fmu",
}
# binaries are not optimised, as with `made_soon`
PROGRAM = """
import sys
import build_pythonfmu
from elastic_tendon import cli
from elastic_tendon.native import compiler
compiler._FLAGS = (*compiler._FLAGS, "-Xclang", "-O0")
for command in sys.argv[1:]:
    sys.argv = command.split()
    if sys.argv[0] == "elastic-tendon":
        cli.app(standalone_mode=False)
    else:
        build_pythonfmu.main()
"""
USERS = {
    "alice": {"TZ": "Pacific/Chatham", "LC_ALL": "C", "PYTHONHASHSEED": "1"},
    "roberta": {"TZ": "America/Lima", "LC_ALL": "C.UTF-8", "PYTHONHASHSEED": "2"},
}
UMASKS = {"alice": 0o077, "roberta": 0o002}


def _environment(user: str, home: Path) -> dict[str, str]:
    """Of a user who has at home a cache and a folder for temporary files."""
    places = {"HOME": home, "TMPDIR": home / "temporary", "ELASTIC_TENDON_CACHE": home / "cache"}
    return {
        "ZIG_GLOBAL_CACHE_DIR": str(Path.home() / ".cache/zig"),  # else zig builds its C library
        **os.environ,
        **USERS[user],
        **{name: str(place) for name, place in places.items()},
        "USER": user,
        "LOGNAME": user,
        "SOURCE_DATE_EPOCH": "1700000000",
        "PYTHONPATH": os.pathsep.join([str(ROOT / "fmu_src"), str(ROOT / "build_scripts")]),
    }


@pytest.fixture(scope="module")
def folders(tmp_path_factory) -> list[Path]:
    """Folders of the users, in which each wrote an FMU by every command."""
    made = []
    for user in USERS:
        home = tmp_path_factory.mktemp("home") / user
        work = home / f"work_of_{user}"
        for folder in (work, home / "temporary"):
            folder.mkdir(parents=True)
        for name in ("demo_model.toml", "demo_fit.csv"):
            shutil.copy(DATA / name, work)
        subprocess.run(
            [sys.executable, "-c", PROGRAM, *COMMANDS.values()],
            cwd=work,
            env=_environment(user, home),
            umask=UMASKS[user],
            check=True,
        )
        assert list((home / "temporary").iterdir()) == []
        made.append(work)
    return made


@pytest.mark.parametrize("kind", COMMANDS)
def test_two_users_export_the_same_bytes(kind, folders) -> None:
    one, other = (folder / f"{kind}.fmu" for folder in folders)
    assert one.read_bytes() == other.read_bytes()
    with zipfile.ZipFile(one) as archive:
        whole = b"".join(archive.read(name) for name in archive.namelist())
    assert b"2023-11-14" in whole  # the day of SOURCE_DATE_EPOCH
    names = [*USERS, str(folders[0].parents[2]), str(ROOT), socket.gethostname()]
    assert [name for name in names if len(name) > 2 and name.encode() in whole] == []
