"""What an FMU carries: by the standard, complete, small, and without names."""

import getpass
import json
import os
import re
import socket
import zipfile
from io import BytesIO
from pathlib import Path

import fmpy
import numpy as np
import pytest
from evidence_cases import contents, friction_diagnosis, friction_model
from fmpy.validation import validate_fmu
from lxml import etree

import elastic_tendon as et
from elastic_tendon.evidence.experiment import from_csv
from elastic_tendon.evidence.gather import PARAMETERS, REPORT
from elastic_tendon.evidence.manifest import FOLDER, MANIFEST, read_manifest
from elastic_tendon.evidence.parameter_set import read_values
from elastic_tendon.evidence.seal import SEAL

ROOT = Path(__file__).parents[2]
FMPY = Path(fmpy.__file__).parent
STANDARD = ROOT.parent / "shared/standards/fmi-ls-ref/fmi3LayeredStandardReferenceManifest.xsd"


@pytest.fixture(scope="module")
def files(sealed):
    """Files of the FMU for FMI 2.0."""
    return contents(sealed(2))


def test_the_manifest_is_by_the_standards_schema(files) -> None:
    if not STANDARD.is_file():
        pytest.skip("the schema of LS-REF is not here")
    # it names its neighbours on the net; fmpy has them
    near = f'schemaLocation="{FMPY / "schema" / "fmi3"}/'
    text = re.sub(r'schemaLocation="[^"]*/', near, STANDARD.read_text())
    schema = etree.XMLSchema(etree.fromstring(text.encode()))
    schema.assertValid(etree.fromstring(files[MANIFEST]))


def test_the_manifest_lists_all_of_it_by_its_role(files) -> None:
    related = read_manifest(files[MANIFEST], "x.fmu")
    held = {name for name in files if name.startswith(FOLDER)}
    assert {one.path for one in related} | {MANIFEST} == held
    roles = {one.source: one.role for one in related}
    assert roles["recording_2_inputs.csv"] == "experiment/validation"
    assert roles["smoke_test_inputs.csv"] == "experiment/smoke-test"
    assert roles["seal.json"] == "signature"


def test_parameters_are_a_set_by_the_standard_with_covariance(files) -> None:
    schema = FMPY / "ssp" / "schema" / "SystemStructureParameterValues.xsd"
    root = etree.fromstring(files[PARAMETERS])
    etree.XMLSchema(etree.parse(schema)).assertValid(root)
    assert read_values(files[PARAMETERS], "x") == friction_model().values()
    (named,) = root.iter("covariance")
    paths = named.get("names").split()
    covariance = np.array([[float(one) for one in row.text.split()] for row in named])
    assert covariance == pytest.approx(covariance.T, rel=1e-6)
    assert np.linalg.eigvalsh(covariance / np.sqrt(np.outer(*[np.diag(covariance)] * 2))).min() > 0
    at = paths.index("link.inertia")
    assert covariance[at, at] == pytest.approx(3e-6**2)  # as the diagnosis told
    intervals = {one.get("name"): one for one in root.iter("interval")}
    assert intervals.keys() == set(paths)
    assert float(intervals["link.inertia"].get("low")) == 0.03389
    assert float(intervals["link.damping"].get("low")) >= 0.0  # no interval leaves the bounds


def test_the_report_has_errors_by_slack_state_and_the_verdict(files, evidence) -> None:
    report = json.loads(files[REPORT])
    demo = et.load_demo()
    # as importers do, who know no curves
    straight = [part.with_straight_inputs() for part in (demo.recording, demo.validation)]
    compared = et.compare(friction_model(), straight)
    for told, file in zip(report["recordings"], compared.files, strict=True):
        (stated,), (error,) = told["signals"].values(), file.signals.values()
        assert stated["rmse"] == error.rmse
        assert stated["noise"]["sigma"] == error.noise.sigma
        assert stated["slack_states"]["I"]["rmse"] == error.slack_states["I"].rmse
        low, high = report["range"]["deflection"]
        assert low <= file.trajectory["deflection"].min()
        assert high >= file.trajectory["deflection"].max()
    assert [one["role"] for one in report["recordings"]] == ["fitted", "held out"]
    assert report["diagnosis"]["verdict"] == "missing_effect"
    assert [one["ids"] for one in report["diagnosis"]["vetoed"]] == [["lugre_friction"]]
    assert report["provenance"]["versions"]["elastic-tendon"] == et.__version__
    assert repr(evidence).endswith("verdict: missing_effect")
    assert evidence.to_dict()["schema"] == "elastic-tendon/evidence/1"


def test_what_was_measured_is_packed_as_it_is(files) -> None:
    recording = et.load_demo().recording
    for kind, wanted in (("inputs", recording.inputs), ("measured", recording.signals)):
        columns = from_csv(files[f"{FOLDER}recording_1_{kind}.csv"], kind)
        assert (columns.pop("time") == recording.time - recording.time[0]).all()
        assert columns.keys() == wanted.keys()
        assert all((columns[name] == wanted[name]).all() for name in wanted)


def test_hashes_alone_give_nothing_away(evidence) -> None:
    recording = et.load_demo().recording
    kept = et.gather_evidence(friction_model(), recording, keep="hashes")
    names = {Path(name).name for name in kept.contents(None)}
    assert not [name for name in names if name.startswith("recording")]
    (told,) = kept.report["recordings"]
    assert told["hashes"] == evidence.report["recordings"][0]["hashes"]
    assert told["signals"] == evidence.report["recordings"][0]["signals"]


def test_it_is_small(sealed) -> None:
    with zipfile.ZipFile(sealed(2)) as archive:
        sizes = {one.filename: one.compress_size for one in archive.infolist()}
    measured = re.compile(rf"{re.escape(FOLDER)}recording_\d_(inputs|measured)\.csv")
    proof = sum(
        size for name, size in sizes.items() if name.startswith(FOLDER) and not measured.match(name)
    )
    without = sum(size for name, size in sizes.items() if not name.startswith(FOLDER))
    assert proof < 0.5 * without


def test_it_holds_no_path_and_no_name(monkeypatch, tmp_path) -> None:
    home = tmp_path / "home" / "alice"
    home.mkdir(parents=True)
    monkeypatch.setattr(getpass, "getuser", lambda: "alice")
    monkeypatch.setattr(socket, "gethostname", lambda: "wonderland-7.example.org")
    monkeypatch.setattr(Path, "home", lambda: home)
    demo = home / "alice_on_wonderland-7.csv"
    columns = et.load_demo().recording.to_dataframe().iloc[:400].reset_index()
    columns.columns = [f"{name}_{'s' if name == 'time' else 'rad'}" for name in columns.columns]
    columns.rename(columns={"load_torque_rad": "load_torque_Nm"}).to_csv(demo, index=False)
    evidence = et.gather_evidence(
        friction_model().model_copy(update={"name": "Alice's joint"}),
        et.read(demo),
        diagnosis=friction_diagnosis(),
        command=f"elastic-tendon export {home}/m.toml --with-evidence {demo}",
    )
    packed = b"".join(evidence.contents(None).values()).lower()
    for name in (b"alice", b"wonderland", b"/home", str(tmp_path).encode(), str(ROOT).encode()):
        assert name not in packed
    told = json.loads(evidence.contents(None)[REPORT])
    assert told["schema"] == "elastic-tendon/evidence/1"  # what is no path stays
    assert told["diagnosis"]["sentence"].endswith("says a.csv; 0.1 N·m/rad.")


def test_no_name_of_this_machine_is_in_the_fmu(files, tmp_path) -> None:
    packed = b"".join(content for name, content in files.items() if name.startswith(FOLDER))
    host = socket.gethostname()
    told = [str(Path.home()), str(tmp_path.parent), str(ROOT), os.getcwd(), host]
    assert not [name for name in told if len(name) > 2 and name.encode() in packed]
    assert not re.search(rf"\b{re.escape(getpass.getuser())}\b".encode(), packed)


def test_equal_evidence_is_equal_bytes(monkeypatch) -> None:
    """Also of who, or whose machine, is called by a word that evidence has of its own."""
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")
    recording = et.load_demo().recording.window(0.0, 1.0)
    made = []
    for user, host in (("alice", "lab-7"), ("tendon", "joint"), ("recording", "motor")):
        monkeypatch.setattr(getpass, "getuser", lambda user=user: user)
        monkeypatch.setattr(socket, "gethostname", lambda host=host: host)
        evidence = et.gather_evidence(friction_model(), recording)
        made.append(evidence.contents("ab"))
    assert made[0] == made[1] == made[2]
    assert json.loads(made[0][REPORT])["date"] == "2023-11-14"


def test_the_key_stays_where_it_is(sealed, keys) -> None:
    secret = keys["ours"].read_bytes()
    for content in contents(sealed(2)).values():
        assert secret.splitlines()[1] not in content


def test_importers_that_do_not_know_it_take_it(sealed) -> None:
    assert validate_fmu(str(sealed(2))) == []
    with zipfile.ZipFile(BytesIO(sealed(2).read_bytes())) as archive:
        assert archive.testzip() is None
        assert archive.namelist()[-1] == SEAL


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"keep": "everything"}, 'evidence keeps "data" or "hashes"'),
        ({"diagnosis": {"schema": "other"}}, "its schema is not elastic-tendon/diagnosis/2"),
        ({"diagnosis": {}}, "this is no diagnosis"),
        ({"diagnosis": "absent.json"}, "absent.json: cannot be read"),
        (
            {"diagnosis": friction_diagnosis() | {"model": et.load_demo().model.model_dump()}},
            "it did not find this model",
        ),
    ],
)
def test_what_cannot_be_gathered_is_said_in_a_sentence(given, told) -> None:
    recording = et.load_demo().recording.window(0.0, 1.0)
    with pytest.raises(et.EvidenceError, match=told):
        et.gather_evidence(friction_model(), recording, **given)


def test_evidence_and_key_have_to_fit(evidence, keys, tmp_path) -> None:
    path = tmp_path / "x.fmu"
    with pytest.raises(et.EvidenceError, match="of another model"):
        et.export_fmu(et.load_demo().model, path, evidence=evidence)
    with pytest.raises(et.EvidenceError, match="what is signed is evidence"):
        et.export_fmu(friction_model(), path, sign=keys["ours"])
    for key, told in (
        (keys["ours"].with_suffix(".pub"), "a private Ed25519 key"),
        (tmp_path / "absent.pem", "cannot be read"),
    ):
        with pytest.raises(et.EvidenceError, match=told):
            et.export_fmu(friction_model(), path, evidence=evidence, sign=key)
    assert not path.exists()


def test_evidence_needs_a_recording():
    with pytest.raises(et.EvidenceError, match="beside recordings; name at least one"):
        et.gather_evidence(et.load_model("biorob_x4_joint_3"), [])
