"""The file that an export writes: the same for the same model, whole or not there."""

import os
import subprocess
import sys
import tempfile
import zipfile
from xml.etree import ElementTree

import pytest
from fmpy import read_model_description
from fmpy.validation import validate_fmu
from fmu_cases import MODELS

from elastic_tendon.errors import BuildError, ElasticTendonError
from elastic_tendon.fmu.export import export_fmu, model_identifier
from elastic_tendon.fmu.pythonfmu_flavour import export_pythonfmu
from elastic_tendon.native import binary, compiler
from elastic_tendon.native.library import library_path

LICENSES = ("license", "casadi", "fmi_headers", "zig")
EXPORT = """
from elastic_tendon import export_fmu, load_model
model = load_model("biorob_x4_joint_3")
export_fmu(model, "there.fmu", platforms="all", source=True)
"""


def test_two_exports_for_all_platforms_are_the_same_bytes(complete, tmp_path):
    """As another process in another folder writes them; `test_reproducible` has other users."""
    environment = os.environ | {"PYTHONHASHSEED": "random"}
    command = [sys.executable, "-c", EXPORT]
    subprocess.run(command, cwd=tmp_path, env=environment, check=True)
    assert (tmp_path / "there.fmu").read_bytes() == complete(2).read_bytes()


@pytest.mark.usefixtures("made_soon")
def test_another_number_gives_another_token(tmp_path):
    tokens = []
    for inertia in (0.03, 0.031):
        model = MODELS["base"].with_values({"link.inertia": inertia})
        path = export_fmu(model, tmp_path / f"{inertia}.fmu")
        with zipfile.ZipFile(path) as archive:
            root = ElementTree.fromstring(archive.read("modelDescription.xml"))
        tokens.append(root.get("guid"))
    assert tokens[0] != tokens[1]


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.usefixtures("made_soon")
def test_every_zip_tool_can_read_it(version, tmp_path):
    path = export_fmu(MODELS["base"], tmp_path / "x.fmu", fmi_version=version, source=True)
    with zipfile.ZipFile(path) as archive:
        assert archive.testzip() is None
        for entry in archive.infolist():
            assert entry.compress_type in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
            assert entry.extract_version <= 20  # 2.0
            assert entry.flag_bits & 0b1001 == 0  # neither encrypted nor with sizes behind
            assert not entry.filename.startswith("/")
            assert "\\" not in entry.filename
            executable = bool(entry.external_attr >> 16 & 0o111)
            assert executable == entry.filename.startswith("binaries/")


@pytest.mark.parametrize(
    ("version", "expected"),
    [
        (2, {"model.png"}),
        (
            3,
            {
                *(f"terminalsAndIcons/icon.{suffix}" for suffix in ("png", "svg")),
                *(f"terminalsAndIcons/flange_{flange}.png" for flange in "ab"),
                "terminalsAndIcons/terminalsAndIcons.xml",
            },
        ),
    ],
)
@pytest.mark.usefixtures("made_soon")
def test_what_is_in_it_beside_the_binary(version, expected, tmp_path):
    path = export_fmu(
        MODELS["base"], tmp_path / "x.fmu", fmi_version=version, platforms="x86_64-linux"
    )
    folder = {2: "linux64", 3: "x86_64-linux"}[version]
    with zipfile.ZipFile(path) as archive:
        assert set(archive.namelist()) == expected | {
            *("documentation/index.html", "documentation/bill_of_materials.cdx.json"),
            *(f"documentation/licenses/{one}.txt" for one in LICENSES),
            "modelDescription.xml",
            f"binaries/{folder}/biorob_x4_joint_3.so",
        }


@pytest.mark.usefixtures("made_soon")
def test_an_existing_file_is_replaced_only_when_told(tmp_path):
    path = tmp_path / "x.fmu"
    path.write_text("precious")
    with pytest.raises(ElasticTendonError, match=r"x\.fmu"):
        export_fmu(MODELS["base"], path)
    assert path.read_text() == "precious"
    export_fmu(MODELS["base"], path, overwrite=True)
    assert zipfile.is_zipfile(path)
    assert [one.name for one in tmp_path.iterdir()] == ["x.fmu"]


def test_another_suffix_is_refused_before_any_work(tmp_path):
    with pytest.raises(ElasticTendonError, match=r"write x\.fmu"):
        export_fmu(MODELS["base"], tmp_path / "x.zip")


def test_a_folder_is_refused_before_any_work(tmp_path):
    with pytest.raises(ElasticTendonError, match=r"folder; name a file in it that ends in \.fmu"):
        export_fmu(MODELS["base"], tmp_path)


@pytest.mark.usefixtures("made_soon")
def test_an_interrupted_export_leaves_nothing(tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))

    def interrupt(_text, share):
        if share > 0.0:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        export_fmu(
            *(MODELS["base"], tmp_path / "x.fmu"),
            platforms=["x86_64-linux", "aarch64-linux", "x86_64-darwin"],
            progress=interrupt,
        )
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("made_soon")
def test_progress_names_what_is_built_and_warns_of_windows(tmp_path):
    told = []
    export_fmu(
        *(MODELS["base"], tmp_path / "x.fmu"),
        platforms=["x86_64-linux", "x86_64-windows"],
        progress=lambda text, share: told.append((text, share)),
    )
    texts, shares = zip(*told, strict=True)
    assert shares == (0.0, 0.5, 1.0)
    assert texts[0] == "building x86_64-linux, x86_64-windows (the first time: minutes)"
    assert texts[-1] == "packing"


@pytest.mark.parametrize(("size", "large"), [(1_000, False), (5_000_000, True)])
def test_progress_tells_of_a_large_model(size, large, tmp_path, monkeypatch):
    """Before it is compiled; here generated C of that size, which does not compile."""
    monkeypatch.setattr(binary, "generate", lambda _system: "#error " + size * "x")
    told = []

    def note(text, _share):
        told.append(text)

    with pytest.raises(BuildError):
        export_fmu(MODELS["base"], tmp_path / "x.fmu", progress=note)
    monkeypatch.setenv("ELASTIC_TENDON_CACHE", str(tmp_path))
    with pytest.raises(BuildError):
        library_path(MODELS["base"].effect_ids, progress=note)
    assert len(told) == 2
    assert all(text.endswith(" (large model: some minutes)") == large for text in told)


@pytest.mark.parametrize(
    ("name", "identifier"),
    [
        ("a_1", "a_1"),
        ("3rd joint", "model_3rd_joint"),
        ("Gelenk-ü", "Gelenk__"),
        ("_x", "model__x"),
        ("x" * 300, "x" * 64),
        ("3" * 300, "model_" + "3" * 58),
    ],
)
def test_identifier_is_a_c_name(name, identifier):
    assert model_identifier(name) == identifier


@pytest.mark.parametrize("name", ['3rd "joint" <ü> & %s', "long " * 60])
@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.usefixtures("made_soon")
def test_any_name_can_be_exported(version, name, tmp_path):
    model = MODELS["base"].model_copy(update={"name": name})
    path = export_fmu(model, tmp_path / "x.fmu", fmi_version=version, source=True)
    assert validate_fmu(str(path)) == []


@pytest.mark.usefixtures("made_soon")
def test_the_pythonfmu_flavour_has_one_wrapper_and_the_licenses(tmp_path):
    path = export_pythonfmu(MODELS["base"], tmp_path / "x.fmu")
    host = compiler.host_platform()
    with zipfile.ZipFile(path) as archive:
        wrappers = [name for name in archive.namelist() if name.startswith("binaries/")]
        licenses = {
            name: archive.read(name)
            for name in archive.namelist()
            if name.startswith("documentation/licenses/")
        }
    assert wrappers == [f"binaries/{host.fmi2_folder}/biorob_x4_joint_3{host.suffix}"]
    assert set(licenses) == {
        f"documentation/licenses/{one}.txt" for one in (*LICENSES, "pythonfmu")
    }
    assert b"MIT License" in licenses["documentation/licenses/pythonfmu.txt"]


@pytest.mark.usefixtures("made_soon")
def test_the_pythonfmu_flavour_says_what_it_needs(tmp_path):
    path = export_pythonfmu(MODELS["base"], tmp_path / "x.fmu")
    told = read_model_description(str(path)).description
    assert told.endswith(
        f"needs {compiler.host_platform().name} and a process with Python 3.11 or newer that "
        "loads it; no packages"
    )
