"""What is unknown of each recording is estimated for each; what is the machine's is shared.

Recordings are of `truth.recording`, which shares no code with the product.
"""

import json

import numpy as np
import pytest

import elastic_tendon as et
from elastic_tendon.estimation.coordinates import Coordinates, own_path
from elastic_tendon.estimation.problem import problem_of
from elastic_tendon.reports.diagnosis_tables import size_sentences
from elastic_tendon.reports.tables import estimate_cells
from truth import signals
from truth.catalogue import actuator_of, signal_maps_of
from truth.recording import record

ZERO, FRICTION = "effects.joint_encoder_offset.offset", 0.25
TIME = np.arange(0.0, 4.0, 5e-3)
NOISE = 1e-4
TREE = {
    "name": "zeroed anew",
    "transmission": {
        "joint_pulley_radius": 0.032,
        "motor_pulley_radius": 0.021,
        "pretension_force": 55.0,
        "upper_spring": {"stiffness": 8300.0, "max_deflection": 0.02},
        "lower_spring": {"stiffness": 8300.0, "max_deflection": 0.02},
    },
    "link": {"inertia": 0.028, "damping": 0.15},
}
ZEROS = {"monday.csv": 0.02, "tuesday.csv": -0.013}


def recorded(name: str, effects: dict, seed: int) -> et.Measurement:
    """A recording of a machine that is as given but for these effects."""
    motor = signals.sines([0.6, 0.2], [1.1 + 0.1 * seed, 2.7], [0.0, 0.7 * seed])
    load = signals.sines([1.2], [1.9], [0.0])
    tree = {**TREE, "effects": effects}
    run = record(
        actuator_of(tree),
        signals.Experiment(TIME[-1], motor, load),
        TIME,
        signal_maps_of(tree),
    )
    noise = NOISE * np.random.default_rng(seed).standard_normal(len(TIME))
    return et.Measurement(
        time=TIME,
        motor_position=[motor.value(time) for time in TIME],
        load_torque=[load.value(time) for time in TIME],
        signals={"joint_position": run["joint_position"] + noise},
        name=name,
    )


@pytest.fixture(scope="module")
def zeroed_anew() -> list[et.Measurement]:
    hidden = {"coulomb_friction": {"torque": FRICTION}}
    return [
        recorded(name, {**hidden, "joint_encoder_offset": {"offset": zero}}, seed)
        for seed, (name, zero) in enumerate(ZEROS.items())
    ]


@pytest.fixture(scope="module")
def found(zeroed_anew) -> et.Diagnosis:
    third = recorded(
        "wednesday.csv",
        {"coulomb_friction": {"torque": FRICTION}, "joint_encoder_offset": {"offset": 0.031}},
        7,
    )
    return et.diagnose(et.load_model(TREE), zeroed_anew, validate=third)


def test_a_zero_of_each_recording_is_found_beside_what_is_the_machine_s(found):
    assert set(found.added) == {"coulomb_friction", "joint_encoder_offset"}
    assert found.model.effects["coulomb_friction"]["torque"] == pytest.approx(FRICTION, rel=0.01)
    zeros = {part.recording: part for part in found.findings.of_recordings}
    assert zeros.keys() == ZEROS.keys()
    for name, zero in ZEROS.items():
        assert zeros[name].path == ZERO
        assert zeros[name].fitted == pytest.approx(zero, abs=1e-4)
        low, high = zeros[name].interval
        assert low < zeros[name].fitted < high < low + 1e-3
    assert found.model.effects["joint_encoder_offset"]["offset"] == zeros["monday.csv"].fitted
    assert found.ladder[-1].noise_ratio["joint_position"] < 1.05


def test_a_recording_that_was_not_fitted_has_its_own_zero_too(found):
    assert found.ladder[-1].heldout_rmse["joint_position"] == pytest.approx(NOISE, rel=0.1)


def test_the_improved_model_knows_them_and_is_compared_with_them(found, zeroed_anew, tmp_path):
    known = found.model.recordings
    assert known["tuesday.csv"] == {ZERO: pytest.approx(-0.013, abs=1e-4)}
    assert known["wednesday.csv"] == {ZERO: pytest.approx(0.031, abs=1e-3)}
    (tmp_path / "improved.toml").write_text(found.model.to_toml())
    again = et.load_model(tmp_path / "improved.toml")
    assert again == found.model
    assert max(et.compare(again, zeroed_anew).noise_ratio().values()) < 1.05
    assert again.without(["joint_encoder_offset"]).recordings is None


@pytest.mark.parametrize(
    ("own", "sentence"),
    [
        ({"link.inertia": 0.1}, "b.csv: link.inertia is not what a recording has of its own"),
        ({ZERO: 9.0}, f"b.csv: {ZERO} = 9 is not from -7 to 7 rad"),
    ],
)
def test_what_is_no_recording_s_own_is_refused(own, sentence):
    tree = {**TREE, "effects": {"joint_encoder_offset": {}}, "recordings": {"b.csv": own}}
    with pytest.raises(et.ModelError, match=sentence):
        et.load_model(tree)


def test_tables_and_json_say_whose_it_is(found):
    rows = [estimate_cells(part)[0] for part in found.findings.every]
    assert rows[-2:] == [f"joint_encoder_offset.offset of {name}" for name in ZEROS]
    assert len(set(rows)) == len(rows)
    told = " ".join(size_sentences(found))
    assert "rad in monday.csv, -0.0130" in told
    content = json.loads(json.dumps(found.to_dict()))
    rows = {row["recording"]: row for row in content["parameters_of_recordings"]}
    assert rows["tuesday.csv"]["path"] == ZERO
    assert rows["tuesday.csv"]["fitted"] == pytest.approx(-0.013, abs=1e-4)
    assert all(row["recording"] is None or "offset" in row["path"] for row in content["parameters"])


def test_evidence_replays_each_recording_under_its_own_load(tmp_path):
    path, loads = "effects.constant_torque.torque", {"monday.csv": 0.3, "tuesday.csv": -0.2}
    recordings = [
        recorded(name, {"constant_torque": {"torque": load}}, seed)
        for seed, (name, load) in enumerate(loads.items())
    ]
    tree = {"effects": {"constant_torque": {"torque": loads["monday.csv"]}}}
    own = {"recordings": {"tuesday.csv": {path: loads["tuesday.csv"]}}}
    model = et.load_model({**TREE, **tree, **own})
    proof = et.gather_evidence(model, recordings)
    found = et.verify(et.export_fmu(model, tmp_path / "own.fmu", evidence=proof))
    assert found.passed, found.faults
    for name in loads:
        stated, replayed = found.errors[name]["joint_position"]
        assert replayed == pytest.approx(stated, rel=1e-6)
        assert replayed < 2.0 * NOISE


def test_a_fit_to_one_recording_has_nothing_beside_the_model(zeroed_anew):
    model = et.load_model(TREE).with_effect("joint_encoder_offset", None)
    fitted = et.fit(model, zeroed_anew[0])
    assert fitted.findings.of_recordings == ()
    assert fitted.problem.coordinates.of_recording == ()


def test_derivatives_by_a_recording_s_own_zero_agree_with_differences(zeroed_anew):
    model = et.load_model({**TREE, "effects": {"joint_encoder_offset": {"offset": 0.01}}})
    problem = problem_of(model, zeroed_anew, (ZERO, "link.inertia"))
    assert problem.coordinates.paths == (ZERO, "link.inertia", own_path(ZERO, "tuesday.csv"))
    vector = problem.start(model)
    sigmas = problem.sigmas(vector)
    jacobian = problem.jacobian(vector, sigmas)
    for index in range(len(vector)):
        step = np.zeros(len(vector))
        step[index] = 1e-5
        high, low = (problem.residuals(vector + sign * step, sigmas) for sign in (1, -1))
        slope = (high - low) / 2e-5
        size = np.max(np.abs(slope))
        np.testing.assert_allclose(jacobian[:, index], slope, rtol=0, atol=1e-3 * size)


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_an_improved_model_is_fitted_again_in_any_order(order, found, zeroed_anew):
    again = et.fit(found.model, [zeroed_anew[index] for index in order])
    zeros = {part.recording: part for part in again.findings.of_recordings}
    for name, zero in ZEROS.items():
        assert zeros[name].given == pytest.approx(zero, abs=1e-4)
        assert zeros[name].fitted == pytest.approx(zero, abs=1e-4)
    assert again.model.recordings.keys() == {*ZEROS, "wednesday.csv"}
    assert again.problem.mean_square(again.vector) < 1.1


def test_known_zeros_are_taken_as_they_are(found, zeroed_anew):
    known = found.model.model_copy(update={"uncertainty": {ZERO: 0.0}})
    again = et.fit(known, zeroed_anew)
    assert again.findings.of_recordings == ()
    assert again.problem.mean_square(again.vector) < 1.1
    assert et.diagnose(known, zeroed_anew).verdict == "adequate"


def test_parts_of_one_recording_share_their_zero(zeroed_anew):
    parts = [zeroed_anew[0].samples(slice(0, 400)), zeroed_anew[0].samples(slice(400, None))]
    model = et.load_model(TREE).with_effect("joint_encoder_offset", None)
    assert Coordinates.of(model, (ZERO,), measurements=parts).paths == (ZERO,)
    assert len(Coordinates.of(model, (ZERO,), measurements=zeroed_anew).paths) == 2
