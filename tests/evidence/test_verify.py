"""Verify runs an FMU's own binary and says in five lines what came of it."""

import json
import re
import zipfile
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from evidence_cases import contents, friction_model, packed, resealed
from fmpy import simulate_fmu
from fmpy.validation import validate_fmu

import elastic_tendon as et
from elastic_tendon.evidence.experiment import smoke_test
from elastic_tendon.evidence.gather import REPORT, replayable
from elastic_tendon.evidence.manifest import FOLDER, MANIFEST, Related, manifest
from elastic_tendon.evidence.parameter_set import Uncertainty, parameter_set
from elastic_tendon.evidence.replay import IMPORTERS, by_another
from fmu_driver import Fmu

PLAIN = ("modelDescription.xml", "binaries/")
STANDARD = Path(__file__).parents[3] / "shared/standards/fmi-ls-ref"


@pytest.mark.parametrize("version", [2, 3])
def test_it_reproduces_what_is_stated(version, sealed, keys) -> None:
    found = et.verify(sealed(version), public_key=keys["ours"].with_suffix(".pub"))
    assert found.passed, found.faults
    assert max(found.differences.values()) < 1e-7
    for errors in found.errors.values():
        stated, replayed = errors["joint_position"]
        # FMI 3.0 takes no derivatives of inputs
        assert replayed == pytest.approx(stated, rel=1e-9 if version == 2 else 2e-3)
    lines = repr(found).splitlines()
    assert len(lines) == 5
    assert [line.split(":")[0].split(" ")[0] for line in lines] == [
        *("x.fmu", "reproduces", "valid", "validated", "signed")
    ]
    assert "diagnosis: missing_effect" in lines[3]
    assert "not replayed" not in lines[3]
    assert found.to_dict()["schema"] == "elastic-tendon/verification/1"


def test_other_runs_of_the_process_keep_their_logger(sealed, capfd) -> None:
    """fmpy has one for all FMUs of FMI 2.0, and called the one of `verify` when it was gone."""
    assert et.verify(sealed(2)).passed
    recording = et.Measurement(time=[0.0, 1.0], motor_position=[0.0, 3.0])
    simulate_fmu(
        str(sealed(2)), fmi_type="CoSimulation", stop_time=1.0, input=et.fmpy_inputs(recording)
    )
    assert "exceeds max_deflection" in capfd.readouterr().out


@pytest.mark.parametrize("importer", [one for one in IMPORTERS if one != "fmpy"])
def test_other_importers_reproduce_it(importer, sealed) -> None:
    if find_spec({"ecos": "ecospy", "libcosim": "libcosimpy"}[importer]) is None:
        pytest.skip(f"{importer} is not installed")
    found = et.verify(sealed(2), importer=importer)
    assert found.passed
    assert found.lines[3].count("as stated, not replayed") == 2
    assert max(found.differences.values()) < 1e-7


def test_hashes_alone_are_said_not_to_be_replayed(sealed, tmp_path) -> None:
    recording = et.load_demo().recording.window(0.0, 1.0)
    kept = et.gather_evidence(friction_model(), recording, keep="hashes")
    plain = {n: c for n, c in contents(sealed(2)).items() if not n.startswith(FOLDER)}
    path = tmp_path / "x.fmu"
    resealed(path, plain | kept.contents(None))
    found = et.verify(path)
    assert found.passed, found.faults
    assert found.differences is not None
    assert found.lines[3].count("as stated, not replayed") == 1


def test_an_importer_that_cannot_take_it_says_so(sealed) -> None:
    pytest.importorskip("libcosimpy")
    with pytest.raises(et.EvidenceError, match=r"libcosim runs FMI 2\.0 alone"):
        et.verify(sealed(3), importer="libcosim")
    with pytest.raises(et.EvidenceError, match="there is no importer 'other' here"):
        et.verify(sealed(3), importer="other")


def test_a_planned_motion_is_judged_by_its_range(sealed) -> None:
    recording = et.load_demo().recording.window(0.0, 5.0)
    found = et.verify(sealed(2), inputs=recording)
    assert found.passed
    assert found.lines[-1] == "planned inputs: stay in the range in which it was validated"
    stronger = replace(recording, load_torque=1.5 * recording.load_torque)
    found = et.verify(sealed(2), inputs=stronger)
    (fault,) = found.faults
    assert found.lines[0] == "x.fmu: as it was sealed"  # it is its use that is wrong
    at = float(re.search(r"load_torque from (\S+) s", fault)[1])
    low, high = found.ranges["load_torque"]
    beyond = np.abs(stronger.load_torque - (low + high) / 2) > 0.52 * (high - low)
    assert at == pytest.approx(stronger.time[np.argmax(beyond)], abs=1e-6)


@pytest.mark.usefixtures("made_soon")
def test_a_spring_that_damps_is_replayed_with_the_motors_velocity(tmp_path) -> None:
    damping = {f"transmission.{side}_spring.damping": 300.0 for side in ("upper", "lower")}
    model = friction_model().with_values(damping)
    evidence = et.gather_evidence(model, et.load_demo().recording.window(0.0, 2.0))
    path = et.export_fmu(model, tmp_path / "x.fmu", fmi_version=3, evidence=evidence)
    found = et.verify(path)
    assert found.passed, found.faults
    assert found.lines[-1] == "unsigned"


@pytest.mark.usefixtures("made_soon")
def test_what_sensors_of_the_joint_read_is_replayed(tmp_path) -> None:
    recording = replace(et.load_demo().recording.window(0.0, 1.0), interpolation="linear")
    model = friction_model().with_effect("joint_encoder_offset", {"offset": 0.05})
    model = model.with_effect("joint_torque_gain", {"error": 0.2})
    pulled = et.simulate(friction_model(), recording)["joint_torque"]
    signals = {**recording.signals, "joint_torque": pulled}
    evidence = et.gather_evidence(model, replace(recording, signals=signals))
    found = et.verify(et.export_fmu(model, tmp_path / "x.fmu", evidence=evidence))
    assert found.passed, found.faults
    assert "not replayed" not in str(found)
    (errors,) = found.errors.values()
    assert errors["joint_position"][0] > 0.04
    for stated, replayed in errors.values():
        assert replayed == pytest.approx(stated, rel=1e-6)


def test_late_readings_a_motors_sensor_and_smooth_inputs_are_stated_and_not_replayed() -> None:
    recording = replace(et.load_demo().recording, interpolation="linear")
    assert replayable(friction_model(), recording)
    late = friction_model().with_effect("measurement_delay", {"delay": 0.01})
    assert not replayable(late, recording)
    assert not replayable(friction_model().with_effect("motor_encoder_offset", {}), recording)
    assert not replayable(friction_model(), replace(recording, interpolation="cubic"))


def test_where_nothing_is_moved_other_importers_have_nothing_to_look_at() -> None:
    experiment = smoke_test(et.models.figure_7.at("joint"))
    with pytest.raises(et.EvidenceError, match="at its interface nothing is moved, and ecos"):
        by_another("ecos", "x.fmu", experiment, ())


def test_evidence_of_before_there_were_interfaces_is_of_position(sealed, tmp_path) -> None:
    files = contents(sealed(2))
    report = json.loads(files[REPORT]) | {"signed_by": None}
    del report["interface"], report["motion"]
    resealed(tmp_path / "x.fmu", files | {REPORT: json.dumps(report).encode()})
    assert et.verify(tmp_path / "x.fmu").passed


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (b"", "it is no FMU, or damaged"),
        (b"PK\3\4 no archive", "it is no FMU, or damaged"),
        ({"a.txt": b""}, "it has no modelDescription.xml"),
        ({"modelDescription.xml": b"<a/>"}, "carries no evidence; export it with --with-evidence"),
        ({"modelDescription.xml": b"<a/>", MANIFEST: b"<a>"}, "the manifest is no XML"),
        ({"modelDescription.xml": b"<a/>", MANIFEST: b"<a/>"}, "not one of org.fmi-standard"),
    ],
)
def test_what_is_no_such_fmu_is_said(content, told, tmp_path) -> None:
    path = tmp_path / "x.fmu"
    if isinstance(content, bytes):
        path.write_bytes(content)
    else:
        packed(path, content)
    with pytest.raises(et.EvidenceError, match=told):
        et.verify(path)
    with pytest.raises(et.EvidenceError, match="cannot be read"):
        et.verify(tmp_path / "absent.fmu")


def test_an_fmu_without_a_binary_for_this_machine_is_not_run(sealed, tmp_path) -> None:
    files = contents(sealed(2))
    path = tmp_path / "x.fmu"
    elsewhere = {name.replace("linux64", "win64"): content for name, content in files.items()}
    unsigned = re.sub(rb'"signed_by": "\w+"', b'"signed_by": null', files[REPORT])
    resealed(path, elsewhere | {REPORT: unsigned})
    with pytest.raises(et.EvidenceError, match="its binary does not run on this machine"):
        et.verify(path)


def _of_another_maker(path, sealed, parameter="link.inertia", missing=False):
    """An FMU with content of LS-REF that is not ours."""
    plain = {n: c for n, c in contents(sealed(2)).items() if n.startswith(PLAIN)}
    values = parameter_set("theirs", {parameter: 0.03}, {}, Uncertainty((), (), (), "model"))
    related = [
        Related("base.ssv", "application/x-ssp-parameter-set", "parameter"),
        Related("tests/smoke.exp", "application/x-ma-ls-experiments", "experiment"),
        Related("https://example.org/report.pdf", "application/pdf", "report"),
    ]
    folder = MANIFEST.rpartition("/")[0]
    theirs = {MANIFEST: manifest(related), f"{folder}/base.ssv": values}
    if not missing:
        theirs[f"{folder}/tests/smoke.exp"] = b"anything"
    packed(path, plain | theirs)
    return path


def test_what_another_maker_packed_is_read(sealed, tmp_path) -> None:
    found = et.verify(_of_another_maker(tmp_path / "x.fmu", sealed))
    assert found.passed
    assert len(repr(found).splitlines()) == 5
    assert "1 parameter, 1 experiment, 1 report" in repr(found)


def test_the_standards_own_example_is_read(sealed, tmp_path) -> None:
    example = STANDARD / "manifest_example.xml"
    if not example.is_file():
        pytest.skip("the example of LS-REF is not here")
    path = tmp_path / "x.fmu"
    plain = {n: c for n, c in contents(sealed(2)).items() if n.startswith(PLAIN)}
    values = parameter_set("theirs", {"link.inertia": 0.03}, {}, Uncertainty((), (), (), "model"))
    sets = [f"{FOLDER}{name}-params.ssv" for name in ("baseline", "midrange", "highend", "dynamic")]
    others = ("modelica/mymodel.mo", "smoke-tests.exp")
    theirs = {MANIFEST: example.read_bytes(), **dict.fromkeys(sets, values)}
    packed(path, plain | theirs | {f"{FOLDER}{name}": b"anything" for name in others})
    found = et.verify(path)
    assert found.faults == ("metadata/model.srmd is listed and missing",)
    assert "1 model, 4 parameter, 1 experiment, 1 meta-data" in repr(found)


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"missing": True}, "tests/smoke.exp is listed and missing"),
        ({"parameter": "k"}, "base.ssv sets k, which it does not have"),
    ],
)
def test_what_another_maker_did_wrong_is_told(changed, told, sealed, tmp_path) -> None:
    found = et.verify(_of_another_maker(tmp_path / "x.fmu", sealed, **changed))
    assert found.faults == (told,)


def test_nothing_is_written_outside_its_folder(sealed, tmp_path) -> None:
    path = tmp_path / "x.fmu"
    files = contents(sealed(2))
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in {**files, "../out.txt": b""}.items():
            archive.writestr(name, content)
    assert not et.verify(path).passed
    assert not (tmp_path.parent / "out.txt").exists()


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.usefixtures("made_soon")
def test_an_output_tells_where_the_model_was_not_validated(version, evidence, tmp_path) -> None:
    options = {"fmi_version": version, "evidence": evidence, "outside_validity": True}
    path = et.export_fmu(friction_model(), tmp_path / "x.fmu", **options)
    assert validate_fmu(str(path)) == []
    assert et.verify(path).passed
    inputs = np.zeros(
        601, dtype=[(one, float) for one in ("time", "motor_position", "load_torque")]
    )
    inputs["time"] = np.linspace(0.0, 6.0, 601)
    inputs["load_torque"] = 1.2 * inputs["time"]  # leaves the range, near 5.4 N·m, at 4.5 s
    run = simulate_fmu(
        str(path),
        fmi_type="CoSimulation",
        stop_time=6.0,
        output_interval=0.01,
        input=inputs,
        output=["outside_validity", "joint_position"],
    )
    high = evidence.validity["load_torque"][1]
    outside = run["outside_validity"].astype(bool)
    late = run["time"] - 0.01  # fmpy sets inputs before a step and looks after it
    assert np.array_equal(outside, 1.2 * late > high)
    assert outside.any()
    assert not outside.all()
    fmu = Fmu(path, tmp_path / "unpacked")
    model = fmu.model()
    try:
        model.begin({"load_torque": 10.0})
        assert model.get("outside_validity")
        model.set("load_torque", 0.0)
        assert model.get("outside_validity")  # discrete: it changes at events only
        model.fmu.enterEventMode()
        model.iterate_events()
        assert not model.get("outside_validity")
    finally:
        model.free()


def test_without_evidence_there_is_no_range_to_leave(tmp_path) -> None:
    with pytest.raises(et.EvidenceError, match="outside_validity needs evidence"):
        et.export_fmu(friction_model(), tmp_path / "x.fmu", outside_validity=True)
