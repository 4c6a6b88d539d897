"""A model without [transmission]: a link that its load alone moves, from model.toml to FMU."""

import fmpy
import numpy as np
import pandas as pd
import pytest
from fmpy.validation import validate_fmu
from scipy.integrate import solve_ivp

import elastic_tendon as et
from elastic_tendon.actuator.interfaces import InterfaceKind
from elastic_tendon.actuator.variables import interface
from elastic_tendon.fmu.documentation import documentation
from elastic_tendon.native.layout import layout

INERTIA, DAMPING = 95.0, 203.0
AXIS = {"name": "axis", "link": {"inertia": INERTIA, "damping": DAMPING}}
TIME = np.arange(0.0, 4.0, 0.005)
LOAD = 60.0 * np.sin(2.0 * TIME) + 40.0 * np.sin(5.1 * TIME + 1.0)
NOISE = 1e-5  # rad


def load_at(time):
    return np.interp(time, TIME, LOAD)


def axis(**effects):
    return et.load_model({**AXIS, "effects": effects})


def moved(model, load=LOAD):
    return et.simulate(model, TIME, load_torque=load)


def recorded(model, seed=1, load=LOAD):
    noise = NOISE * np.random.default_rng(seed).standard_normal(len(TIME))
    position = moved(model, load)["joint_position"] + noise
    return et.Measurement(TIME, load_torque=load, signals={"joint_position": position})


def test_it_moves_as_an_independent_solver_says():
    model = axis(
        constant_torque={"torque": 3.0},
        quadratic_drag={"coefficient": 40.0},
        gravity_load={"torque": 25.0, "angle": 0.3},
    )

    def rates(time, state):
        position, velocity = state
        torque = load_at(time) - DAMPING * velocity + 3.0
        torque -= 40.0 * velocity * abs(velocity) + 25.0 * np.sin(position + 0.3)
        return velocity, torque / INERTIA

    truth = solve_ivp(
        rates, (0.0, TIME[-1]), (0.0, 0.0), "DOP853", TIME, rtol=1e-12, atol=1e-13, max_step=0.005
    )
    found = et.simulate(model, TIME, load_torque=LOAD, tolerance=1e-10)
    assert np.ptp(truth.y[0]) > 0.1
    assert np.abs(found["joint_position"] - truth.y[0]).max() < 1e-7
    assert np.abs(found["joint_velocity"] - truth.y[1]).max() < 1e-7


def test_dry_friction_holds_it_until_the_load_exceeds_it():
    load = 10.0 * TIME
    found = et.simulate(axis(coulomb_friction={"torque": 20.0}), TIME, load_torque=load)
    stuck = TIME <= 2.0
    assert np.all(found["joint_position"][stuck] == 0.0)

    def rates(time, state):
        return state[1], (10.0 * time - 20.0 - DAMPING * state[1]) / INERTIA

    slides = TIME[~stuck]
    truth = solve_ivp(rates, (2.0, TIME[-1]), (0.0, 0.0), "DOP853", slides, rtol=1e-12, atol=1e-14)
    assert np.abs(found["joint_position"][~stuck] - truth.y[0]).max() < 1e-7


def test_only_what_a_link_has_is_asked_and_told():
    model = axis()
    assert model.kind is InterfaceKind.LOAD
    assert [quantity.path for quantity in model.quantities()] == ["link.inertia", "link.damping"]
    assert moved(model).output_names == ("joint_position", "joint_velocity")
    assert "transmission" not in model.to_toml()
    assert et.load_model(et.load_model(AXIS).model_dump()) == model
    assert et.load_model({**AXIS, "interface": {"kind": "position"}}).kind is InterfaceKind.LOAD
    assert model.at_position() is model
    assert model.warnings() == []


SPRINGS = et.models.figure_7.model_dump(exclude_none=True)


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (
            {**AXIS, "interface": {"kind": "torque"}},
            "transmission: missing; interface torque",
        ),
        ({**AXIS, "interface": {"kind": "joint"}}, "transmission: missing; interface joint"),
        ({**SPRINGS, "interface": {"kind": "load"}}, "is that of a link without springs; leave"),
        ({**AXIS, "effects": {"gear_backlash": {}}}, "gear_backlash acts on motor or springs, whi"),
        ({**AXIS, "uncertainty": {"transmission.slack": 1.0}}, "not known in .uncertainty.; know"),
        ({**AXIS, "transmision": {}}, "not known in a model.toml; did you mean transmission"),
    ],
)
def test_what_does_not_fit_is_refused_in_a_sentence(content, sentence):
    with pytest.raises(et.ModelError, match=sentence):
        et.load_model(content)


@pytest.mark.parametrize(
    "use",
    [
        et.design,
        et.characteristic_curves,
        lambda model: et.linearise(model, "III"),
        lambda model: et.describing_function(model, [0.1]),
    ],
)
def test_what_is_about_springs_says_that_it_needs_them(use):
    with pytest.raises(et.ModelError, match=r"axis: .* needs springs; give the model a table \[tr"):
        use(axis())


def test_a_file_needs_no_motor_position_where_the_load_drives_the_joint(tmp_path):
    table = pd.DataFrame(
        {"time_s": TIME, "load_torque_Nm": LOAD, "joint_position_mrad": 1e3 * LOAD}
    )
    table.to_csv(tmp_path / "x.csv", index=False)
    recording = et.read(tmp_path / "x.csv")
    assert set(recording.inputs) == {"load_torque"}
    assert recording.signals["joint_position"] == pytest.approx(LOAD)
    with pytest.raises(et.MeasurementError, match="driven by motor_position, which was not meas"):
        et.compare(et.models.figure_7, recording)
    table.drop(columns="load_torque_Nm").to_csv(tmp_path / "y.csv", index=False)
    with pytest.raises(et.MeasurementError, match="there is no column motor_position_rad"):
        et.read(tmp_path / "y.csv")


def test_a_motor_that_was_recorded_does_not_matter():
    model = axis()
    recording = recorded(model)
    torque = {"motor_torque": LOAD}
    with_motor = et.Measurement(
        TIME, LOAD, {**recording.signals, **torque}, load_torque=LOAD, name="both"
    )
    (file,) = et.compare(model, with_motor).files
    assert file.signals.keys() == {"joint_position"}
    assert "motor_torque is not compared: the model has no springs" in file.measurement.notes
    assert et.compare(model, recording).rmse() == et.compare(model, with_motor).rmse()
    only_torque = et.Measurement(TIME, LOAD, torque)
    with pytest.raises(et.MeasurementError, match="joint_position was not measured; name its"):
        et.compare(model, only_torque)


def test_it_is_compared_located_and_fitted():
    truth = axis(coulomb_friction={"torque": 20.0})
    recording = recorded(truth)
    compared = et.compare(axis(), recording)
    words = et.locate(compared).summary()
    assert "opposes the direction of motion" in words
    assert not compared.files[0].signals["joint_position"].slack_states
    begun = truth.with_values({"link.damping": 150.0, "effects.coulomb_friction.torque": 12.0})
    found = et.fit(begun, recording).model.values()
    for path, value in (("link.damping", DAMPING), ("effects.coulomb_friction.torque", 20.0)):
        assert found[path] == pytest.approx(value, rel=0.02)


@pytest.mark.slow
def test_the_friction_that_is_missing_is_found():
    recording = recorded(axis(coulomb_friction={"torque": 20.0}))
    found = et.diagnose(axis(), recording)
    assert list(found.added) == ["coulomb_friction"]
    assert found.ladder[-1].rmse["joint_position"] < 1.1 * NOISE


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.usefixtures("made_soon")
def test_its_fmu_moves_as_simulated(version, tmp_path):
    model = axis(coulomb_friction={"torque": 20.0}, joint_encoder_offset={"offset": 0.1})
    path = et.export_fmu(model, tmp_path / "x.fmu", fmi_version=version)
    assert validate_fmu(str(path)) == []
    recording = et.Measurement(TIME, load_torque=LOAD, interpolation="hold")
    expected = et.simulate(model, TIME, load_torque=LOAD, interpolation="hold", tolerance=1e-9)
    for kind in ("CoSimulation", "ModelExchange"):
        found = fmpy.simulate_fmu(
            str(path),
            fmi_type=kind,
            input=et.fmpy_inputs(recording),
            output=["joint_position"],
            output_interval=0.005,
            stop_time=TIME[-1],
            relative_tolerance=1e-9,
        )
        at = np.searchsorted(found["time"], TIME - 1e-6)[1:]
        error = found["joint_position"][at] - expected["joint_position"][1:]
        assert np.abs(error).max() < 1e-6
    names = {variable.name for variable in fmpy.read_model_description(str(path)).modelVariables}
    assert {"load_torque", "joint_position", "measured_joint_position", "link.inertia"} <= names
    assert not any(
        name.startswith(("slack", "motor", "transmission", "deflection")) for name in names
    )


def test_a_joint_that_another_simulator_moves_needs_no_link():
    content = {key: value for key, value in SPRINGS.items() if key != "link"}
    with pytest.raises(et.ModelError, match=r"link: missing; a table \[link\] with inertia"):
        et.load_model(content)
    bare = et.load_model({**content, "interface": {"kind": "joint"}})
    assert "link" not in bare.to_toml()
    assert et.load_model(bare.model_dump()) == bare
    motion = {"motor_position": 0.2 * np.sin(TIME), "joint_position": 0.1 * np.sin(3.0 * TIME)}
    of_both = [et.simulate(one, TIME, **motion) for one in (bare, et.models.figure_7.at("joint"))]
    assert np.array_equal(*(trajectory.outputs for trajectory in of_both))
    rows = layout(interface(*bare.structure), bare.values())
    page = documentation(bare, rows, 2)["documentation/index.html"].decode()
    assert (
        page
        == documentation(et.models.figure_7.at("joint"), rows, 2)[
            "documentation/index.html"
        ].decode()
    )
    torque = {
        "joint_position": motion["joint_position"],
        "joint_torque": of_both[0]["joint_torque"],
    }
    recording = et.Measurement(TIME, motion["motor_position"], torque)
    assert et.compare(bare, recording).rmse()["joint_torque"] < 1e-9
    for use in (et.design, lambda model: et.linearise(model, "III"), et.Model.at_position):
        with pytest.raises(et.ModelError, match="link"):
            use(bare)
