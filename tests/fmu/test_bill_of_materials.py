"""What the binaries of an FMU are made of, as CycloneDX, and the licenses of that."""

import hashlib
import json
import zipfile
from importlib.metadata import version

import pytest

from elastic_tendon.fmu.bill_of_materials import bill_of_materials

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
    assert b"Zig contributors" in files["documentation/licenses/zig.txt"]
    assert b"mingw-w64 project" in files["documentation/licenses/mingw.txt"]


def test_start_files_for_windows_are_named_where_they_are():
    made = bill_of_materials("x", "{0}", {"binaries/linux64/x.so": b""}, 3)
    assert b"mingw" not in made[NAME]
    assert "documentation/licenses/mingw.txt" not in made
    assert b"Redistributions in binary form" in made["documentation/licenses/fmi_headers.txt"]
