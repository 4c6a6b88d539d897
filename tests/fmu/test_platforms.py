"""Binaries for platforms that this is not: looked into, and run where an emulator is installed."""

import os
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

import numpy as np
import pytest
from fmpy import read_model_description
from fmpy.validation import validate_fmu
from fmu_cases import MODELS
from inspection import inspect

import elastic_tendon
from elastic_tendon.errors import BuildError
from elastic_tendon.fmu.export import export_fmu
from elastic_tendon.fmu.mach_o import universal
from elastic_tendon.native import compiler

FOLDERS = {
    2: {"linux64": ".so", "aarch64-linux": ".so", "win64": ".dll", "darwin64": ".dylib"},
    3: {
        "x86_64-linux": ".so",
        "aarch64-linux": ".so",
        "x86_64-windows": ".dll",
        "x86_64-darwin": ".dylib",
        "aarch64-darwin": ".dylib",
    },
}
WINDOWS = re.compile(r"KERNEL32\.dll|api-ms-win-crt-\w+-l1-1-0\.dll")  # of Windows 10 and newer
MACHINES = {
    "x86_64-linux": "linux X86_64",
    "aarch64-linux": "linux AARCH64",
    "x86_64-windows": "windows AMD64",
    "x86_64-darwin": "darwin x86_64",
    "aarch64-darwin": "darwin ARM64",
}
OUTPUTS = ("joint_position", "joint_velocity", "joint_torque", "lower_spring_force")
STEPS = 1000


@pytest.fixture(scope="module", params=[2, 3])
def version(request):
    return request.param


@pytest.fixture(scope="module")
def fmu(version, complete, tmp_path_factory):
    """An FMU with everything that one can have, exported and unpacked."""
    folder = tmp_path_factory.mktemp(f"fmi{version}")
    path = Path(shutil.copy(complete(version), folder))
    with zipfile.ZipFile(path) as archive:
        archive.extractall(folder / "unpacked")
    return path


def _unpacked(fmu):
    return fmu.parent / "unpacked"


def _libraries(fmu):
    """All libraries in an FMU by their machine."""
    found = [
        library
        for path in _unpacked(fmu).glob("binaries/*/*")
        for library in inspect(path.read_bytes())
    ]
    return {library.machine: library for library in found}


# ---- what is in it -------------------------------------------------------------------------


def test_fmpy_finds_no_problem(fmu):
    assert validate_fmu(str(fmu)) == []


def test_each_platform_has_its_folder_with_one_binary(fmu, version):
    identifier = read_model_description(str(fmu)).coSimulation.modelIdentifier
    packed = {path.relative_to(_unpacked(fmu)) for path in _unpacked(fmu).glob("binaries/*/*")}
    assert packed == {
        Path("binaries", folder, identifier + suffix) for folder, suffix in FOLDERS[version].items()
    }


def test_every_machine_is_there(fmu):
    assert set(_libraries(fmu)) == set(MACHINES.values())


@pytest.mark.parametrize("machine", MACHINES.values())
def test_functions_are_those_of_the_header(fmu, version, machine):
    header = (compiler.fmi_headers() / f"fmi{version}Functions.h").read_text()
    expected = set(re.findall(rf"FMI{version}_Export\s+\w+TYPE\s+(\w+);", header))
    assert len(expected) > 40
    shown = _libraries(fmu)[machine].functions
    assert {one for one in shown if not one.startswith("elastic_tendon_")} == expected


def test_nothing_is_needed_but_what_every_system_has(fmu):
    for machine, library in _libraries(fmu).items():
        if machine.startswith("linux"):
            assert library.imports <= {"libc.so.6", "libm.so.6"}
            assert library.oldest <= (2, 17)
        elif machine.startswith("windows"):
            assert all(WINDOWS.fullmatch(one) for one in library.imports), library.imports
        else:
            assert library.imports == {"/usr/lib/libSystem.B.dylib"}
            assert library.oldest == (11, 0, 0)


def test_macs_with_arm_load_signed_code_only(fmu):
    assert _libraries(fmu)["darwin ARM64"].signed


def test_it_is_no_larger_than_promised(fmu):
    assert fmu.stat().st_size <= 1e6


def test_no_path_of_this_machine_is_in_it(fmu):
    folders = {
        *(str(Path.home()), tempfile.gettempdir(), os.getcwd()),
        *(str(Path(package.__file__).parent) for package in (elastic_tendon, np)),
    }
    with zipfile.ZipFile(fmu) as archive:
        for name in archive.namelist():
            content = archive.read(name)
            assert [one for one in folders if one.encode() in content] == [], name


# ---- run elsewhere -------------------------------------------------------------------------


def _wine():
    found = shutil.which("wine64") or "/usr/lib/wine/wine64"  # Debian's is not on the path
    return [found] if Path(found).exists() else None


def _qemu():
    libraries = Path("/usr/aarch64-linux-gnu")
    found = shutil.which("qemu-aarch64-static") or shutil.which("qemu-aarch64")
    return [found, "-L", str(libraries)] if found and libraries.exists() else None


EMULATORS = {"aarch64-linux": _qemu(), "x86_64-windows": _wine()}


@pytest.fixture(scope="module")
def wine(tmp_path_factory):
    """Environment of wine, whose folder is made before its first program starts.

    Else a program sometimes finds it half made.
    """
    prefix = tmp_path_factory.mktemp("wine")
    environment = os.environ | {"WINEPREFIX": str(prefix), "WINEDEBUG": "-all"}
    if EMULATORS["x86_64-windows"]:
        boot = [*EMULATORS["x86_64-windows"], "wineboot", "--init"]
        subprocess.run(boot, check=False, capture_output=True, env=environment)
    return environment


def _drive(fmu, version, platform, emulator, folder, environment=None):
    """Outputs (steps, outputs) of the platform's binary, driven by a program of that platform."""
    description = read_model_description(str(fmu))
    references = {one.name: str(one.valueReference) for one in description.modelVariables}
    (library,) = _unpacked(fmu).glob(f"binaries/{platform.folder(version)}/*")
    program = folder / f"drive-{platform.name}.exe"
    command = [  # as the libraries, else zig builds the platform's own once more, for a minute
        *(sys.executable, "-m", "ziglang", "cc", "-target", platform.target, "-O2", "-g0", "-s"),
        *(f"-DFMI_VERSION={version}", f"-I{compiler.fmi_headers()}"),
        *(str(Path(__file__).with_name("drive.c")), "-o", str(program)),
    ]
    subprocess.run(command, check=True, capture_output=True)
    token = description.guid if version == 2 else description.instantiationToken
    run = subprocess.run(
        [
            *(*emulator, str(program), str(library), token, str(STEPS)),
            *(references["motor_position"], "0.3", *(references[name] for name in OUTPUTS)),
        ],
        capture_output=True,
        check=False,
        text=True,
        env=environment,
    )
    assert run.returncode == 0, run.stderr
    rows = [
        [struct.unpack(">d", bytes.fromhex(bits))[0] for bits in line.split()]
        for line in run.stdout.splitlines()
    ]
    return np.array(rows)


@pytest.fixture(scope="module")
def here(fmu, version, tmp_path_factory):
    folder = tmp_path_factory.mktemp("here")
    return _drive(fmu, version, compiler.host_platform(), [], folder)


@pytest.mark.parametrize("name", EMULATORS)
def test_other_platforms_give_the_same_numbers(fmu, version, here, name, wine, tmp_path):
    if EMULATORS[name] is None:
        pytest.skip(f"nothing is installed here that runs programs for {name}")
    found = _drive(fmu, version, compiler.PLATFORMS[name], EMULATORS[name], tmp_path, wine)
    assert found.shape == (STEPS, len(OUTPUTS))
    assert here[:, OUTPUTS.index("lower_spring_force")].min() == 0.0  # it was slack at times
    scale = np.abs(here).max(axis=0)
    assert (np.abs(found - here) <= 1e-12 * scale).all()


# ---- choice --------------------------------------------------------------------------------


def test_the_token_is_the_same_whatever_the_platforms(fmu, version, tmp_path):
    one = export_fmu(
        MODELS["base"], tmp_path / "x.fmu", fmi_version=version, platforms="aarch64-linux"
    )
    assert [path for path in zipfile.ZipFile(one).namelist() if path.startswith("binaries/")] == [
        "binaries/aarch64-linux/biorob_x4_joint_3.so"
    ]
    if version == 3:  # the description of FMI 2.0 lists the sources too
        tokens = [read_model_description(str(path)).instantiationToken for path in (one, fmu)]
        assert tokens[0] == tokens[1]


def test_names_of_platforms():
    linux, arm = (compiler.PLATFORMS[name] for name in ("x86_64-linux", "aarch64-linux"))
    assert compiler.platforms_named(None) == (compiler.host_platform(),)
    assert compiler.platforms_named("x86_64-linux") == (linux,)
    assert compiler.platforms_named(["aarch64-linux, x86_64-linux", "x86_64-linux"]) == (linux, arm)
    assert compiler.platforms_named("linux64,aarch64-linux") == (linux, arm)
    macos = compiler.platforms_named("darwin64")
    assert [one.name for one in macos] == ["x86_64-darwin", "aarch64-darwin"]
    assert compiler.platforms_named(["all"]) == tuple(compiler.PLATFORMS.values())


def test_an_unknown_platform_is_told_with_those_known(tmp_path):
    with pytest.raises(BuildError, match=r"'amiga'; known are x86_64-linux, .*, and all"):
        export_fmu(MODELS["base"], tmp_path / "x.fmu", platforms=["amiga"])
    assert list(tmp_path.iterdir()) == []


def test_an_unknown_version_is_told_with_those_known(tmp_path):
    with pytest.raises(BuildError, match="no FMI version 4 here; choose 2 or 3"):
        export_fmu(MODELS["base"], tmp_path / "x.fmu", fmi_version=4)


def test_an_unknown_host_is_told(monkeypatch):
    monkeypatch.setattr(compiler.platform, "machine", lambda: "m68k")
    with pytest.raises(BuildError, match="m68k; known platforms: x86_64-linux"):
        compiler.host_platform()


def test_only_thin_libraries_are_joined():
    with pytest.raises(ValueError, match="thin"):
        universal([b"\x7fELF" + bytes(100)])
