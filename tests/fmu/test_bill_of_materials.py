"""What the binaries of an FMU are made of, as CycloneDX, and the licenses of that."""

import hashlib
import json
import zipfile
from importlib.metadata import version

import pytest
from fmu_cases import MODELS

from elastic_tendon.fmu.bill_of_materials import bill_of_materials
from elastic_tendon.fmu.pythonfmu_flavour import export_pythonfmu
from elastic_tendon.native import compiler

NAME = "documentation/bill_of_materials.cdx.json"


@pytest.fixture(scope="module")
def files(complete):
    """Content of the FMU for all platforms by path."""
    with zipfile.ZipFile(complete(2)) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def test_it_follows_the_schema(files):
    validation = pytest.importorskip("cyclonedx.validation.json")
    from cyclonedx.schema import SchemaVersion

    validate = validation.JsonStrictValidator(SchemaVersion.V1_6)
    assert validate.validate_str(files[NAME].decode()) is None
    assert validate.validate_str(files[NAME].decode().replace('"type"', '"kind"')) is not None


def test_every_binary_is_in_it_with_its_hash(files):
    bill = json.loads(files[NAME])
    told = {
        one["name"]: one["hashes"][0]["content"]
        for one in bill["components"]
        if one["type"] == "file"
    }
    assert told == {
        name: hashlib.sha256(content).hexdigest()
        for name, content in files.items()
        if name.startswith("binaries/")
    }
    assert len(told) == 4


def test_every_part_has_its_version_and_license(files):
    listed = json.loads(files[NAME])["components"]
    parts = {one["name"]: one for one in listed if one["type"] == "library"}
    assert set(parts) == {
        *("elastic-tendon", "casadi", "fmi-headers", "zig-compiler-rt", "mingw-w64")
    }
    assert parts["casadi"]["version"] == version("casadi")
    assert all(one["licenses"][0]["license"]["id"] for one in parts.values())
    assert b"Modelica Association" in files["documentation/licenses/fmi_headers.txt"]
    assert b"Redistributions in binary form" in files["documentation/licenses/fmi_headers.txt"]
    assert b"MIT No Attribution" in files["documentation/licenses/casadi.txt"]
    assert b"WITHOUT WARRANTY" in files["documentation/licenses/casadi.txt"]
    assert b"Zig contributors" in files["documentation/licenses/zig.txt"]
    assert b"mingw-w64 project" in files["documentation/licenses/mingw.txt"]


def test_start_files_for_windows_are_named_where_they_are():
    made = bill_of_materials("x", "{0}", {"binaries/linux64/x.so": b""}, 3)
    assert b"mingw" not in made[NAME]
    assert "documentation/licenses/mingw.txt" not in made
    assert b"Redistributions in binary form" in made["documentation/licenses/fmi_headers.txt"]


@pytest.mark.usefixtures("made_soon")
def test_the_pythonfmu_flavour_has_a_bill_too(tmp_path):
    """Of both libraries: pythonfmu's, and the model's in the resources."""
    with zipfile.ZipFile(export_pythonfmu(MODELS["base"], tmp_path / "x.fmu")) as archive:
        held = {name: archive.read(name) for name in archive.namelist()}
    bill = json.loads(held[NAME])
    parts = {one["name"]: one for one in bill["components"]}
    assert parts["pythonfmu"]["version"] == version("pythonfmu")
    libraries = {name for name, one in parts.items() if one["type"] == "file"}
    suffix = compiler.host_platform().suffix
    assert libraries == {name for name in held if name.endswith(suffix)}
    assert {name.partition("/")[0] for name in libraries} == {"binaries", "resources"}
    packed = {name for name in held if name.startswith("documentation/licenses/")}
    names = ("license", "casadi", "fmi_headers", "zig", "pythonfmu")
    assert packed == {f"documentation/licenses/{name}.txt" for name in names}
