"""The source code in an FMU: complete, and built in the ways that people have."""

import os
import re
import shutil
import subprocess
import sys
import zipfile
from importlib.util import find_spec
from pathlib import Path
from xml.etree import ElementTree

import pytest
from fmpy import read_model_description, simulate_fmu
from fmpy.build import build_platform_binary
from fmu_cases import MODELS
from lxml import etree

from elastic_tendon.fmu.export import export_fmu
from elastic_tendon.native import compiler

NO_COMPILER = pytest.mark.skipif(shutil.which("cc") is None, reason="there is no cc")
NO_CMAKE = pytest.mark.skipif(shutil.which("cmake") is None, reason="there is no cmake")


@pytest.fixture(scope="module", params=[2, 3])
def version(request):
    return request.param


@pytest.fixture(scope="module")
def fmu(version, tmp_path_factory):
    path = tmp_path_factory.mktemp(f"fmi{version}") / "x.fmu"
    return export_fmu(MODELS["effects"], path, fmi_version=version, source=True)


@pytest.fixture
def unpacked(fmu, tmp_path):
    """The FMU in a folder, where another binary may take the place of its own."""
    with zipfile.ZipFile(fmu) as archive:
        archive.extractall(tmp_path / "unpacked")
    return tmp_path / "unpacked"


def _binary(unpacked):
    (library,) = unpacked.glob("binaries/*/*")
    return library


def _simulate(fmu, kind="CoSimulation"):
    start = {"motor_position": 0.3, "joint_velocity": 1.0}
    return simulate_fmu(str(fmu), fmi_type=kind, start_values=start, stop_time=0.5)


def check_agreement(fmu, unpacked):
    expected, found = _simulate(fmu), _simulate(unpacked)
    assert len(set(expected["slack_state"])) > 1
    for name in expected.dtype.names:
        assert found[name] == pytest.approx(expected[name], rel=1e-9, abs=1e-9)


def test_sources_are_those_of_the_binary(unpacked, tmp_path):
    """To the bit, with the same compiler; nothing but the FMI headers is taken from elsewhere."""
    again = tmp_path / _binary(unpacked).name
    outside = set(compiler.RUNTIME.iterdir())
    compiler.compile_library(unpacked / "sources/library.c", again, compiler.host_platform())
    assert again.read_bytes() == _binary(unpacked).read_bytes()
    assert set(compiler.RUNTIME.iterdir()) == outside


@NO_COMPILER
def test_a_plain_compiler_builds_them(fmu, unpacked):
    """With the headers of FMI and no flag that is not needed."""
    command = [
        *("cc", "-shared", "-fPIC", f"-I{compiler.fmi_headers()}", "-Werror"),
        *(str(unpacked / "sources/library.c"), "-o", str(_binary(unpacked)), "-lm"),
    ]
    subprocess.run(command, check=True, capture_output=True)
    check_agreement(fmu, unpacked)


@NO_COMPILER
@NO_CMAKE
def test_fmpy_builds_them(fmu, unpacked, tmp_path):
    binary, work = _binary(unpacked), tmp_path / "build"
    binary.unlink()
    work.mkdir()
    build_platform_binary(unpacked, work)
    assert binary.exists()
    check_agreement(fmu, unpacked)


@NO_COMPILER
@pytest.mark.skipif(not (shutil.which("zip") and shutil.which("unzip")), reason="no zip or unzip")
def test_the_printed_commands_build_them(version, tmp_path):
    """As they stand in the documentation, for an FMU without a binary for this platform."""
    path = export_fmu(
        *(MODELS["effects"], tmp_path / "X.fmu"),
        fmi_version=version,
        platforms="aarch64-darwin",
        source=True,
    )
    with zipfile.ZipFile(path) as archive:
        page = ElementTree.fromstring(archive.read("documentation/index.html"))
    commands = page.find(".//pre").text
    python = Path(sys.executable).parent
    environment = os.environ | {"PATH": f"{python}{os.pathsep}{os.environ['PATH']}"}
    subprocess.run(["bash", "-ec", commands], cwd=tmp_path, env=environment, check=True)
    host = compiler.host_platform().folder(version)
    with zipfile.ZipFile(path) as archive:
        assert [one for one in archive.namelist() if one.startswith(f"binaries/{host}/")]
    assert len(set(_simulate(path)["slack_state"])) > 1


def _headers(folder):
    """FMI's headers; fmpy's for FMI 2.0 leave out the prefix, which the standard's put in."""
    folder.mkdir()
    for header in compiler.fmi_headers().glob("fmi*.h"):
        text = header.read_text().replace(
            "#define fmi2FullName(name) name",
            "#define fmi2Joined(a, b) a##b\n#define fmi2Both(a, b) fmi2Joined(a, b)\n"
            "#define fmi2FullName(name) fmi2Both(FMI2_FUNCTION_PREFIX, name)",
        )
        (folder / header.name).write_text(text)
    return folder


@NO_COMPILER
def test_linked_statically_they_keep_to_their_prefix(version, unpacked, tmp_path):
    """So that one program can hold several FMUs."""
    output = tmp_path / "library.o"
    command = [
        *("cc", "-c", f"-DFMI{version}_FUNCTION_PREFIX=mine_", f"-I{_headers(tmp_path / 'fmi')}"),
        *(str(unpacked / "sources/library.c"), "-o", str(output)),
    ]
    subprocess.run(command, check=True, capture_output=True)
    listed = subprocess.run(
        ["nm", "--defined-only", "--extern-only", str(output)],
        capture_output=True,
        text=True,
        check=True,
    )
    shown = {line.split()[-1] for line in listed.stdout.splitlines()}
    assert f"mine_fmi{version}DoStep" in shown
    assert [one for one in shown if not one.startswith("mine_fmi")] == []


def test_headers_of_fmi_are_left_to_the_importer(version, unpacked):
    files = {path.name for path in (unpacked / "sources").iterdir()}
    assert "library.c" in files
    assert [one for one in files if one.startswith(f"fmi{5 - version}")] == []
    assert [one for one in files if re.fullmatch(r"fmi\d\w*\.h", one)] == []


def test_the_importer_is_told_what_to_compile(version, fmu, unpacked):
    description = read_model_description(str(fmu), validate=True)
    for configuration in description.buildConfigurations:
        assert configuration.modelIdentifier == description.coSimulation.modelIdentifier
        assert [one.sourceFiles for one in configuration.sourceFileSets] == [["library.c"]]
    assert len(description.buildConfigurations) == {2: 1, 3: 3}[version]
    if version == 2:
        root = etree.parse(str(unpacked / "modelDescription.xml"))
        assert [one.getparent().tag for one in root.findall("*/SourceFiles")] == [
            *("ModelExchange", "CoSimulation")
        ]


def test_build_description_follows_the_schema(version, unpacked):
    path = unpacked / "sources/buildDescription.xml"
    assert path.exists() == (version == 3)
    if version == 3:
        folder = Path(find_spec("fmpy").submodule_search_locations[0]) / "schema/fmi3"
        schema = etree.XMLSchema(file=str(folder / "fmi3BuildDescription.xsd"))
        schema.assertValid(etree.parse(str(path)))
        found = [
            (one.get("platform"), [library.attrib for library in one.findall("Library")])
            for one in etree.parse(str(path)).findall("BuildConfiguration")
        ]
        libm = [{"name": "m", "external": "true"}]
        # importers take the first that fits, and the one without a platform fits all
        assert found == [("x86_64-linux", libm), ("aarch64-linux", libm), (None, [])]


@pytest.mark.usefixtures("made_soon")
def test_without_asking_there_are_none(version, tmp_path):
    path = export_fmu(MODELS["base"], tmp_path / "x.fmu", fmi_version=version)
    with zipfile.ZipFile(path) as archive:
        assert [one for one in archive.namelist() if one.startswith("sources/")] == []
    assert read_model_description(str(path)).buildConfigurations == []
