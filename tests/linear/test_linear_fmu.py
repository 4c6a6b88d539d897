"""Linear models of FMUs: as those of the equations, the paper's, and finite differences."""

import tempfile
import zipfile

import numpy as np
import pytest
from linear_cases import STATES, closed_form, damped, with_typical
from scipy.linalg import expm

from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.actuator.sections import Motor
from elastic_tendon.actuator.transmission import SlackState, slack_boundaries
from elastic_tendon.effects import CATALOGUE
from elastic_tendon.errors import LinearisationError
from elastic_tendon.fmu.export import export_fmu
from elastic_tendon.linear import fmu_variables
from elastic_tendon.linear.fmu import fmu_plant, linearise_fmu
from elastic_tendon.linear.linearise import linearise
from elastic_tendon.linear.result import Drive, OperatingPoint
from elastic_tendon.simulation.simulate import simulate
from fmu_driver import Fmu

pytestmark = pytest.mark.usefixtures("all_made_soon")

BASE = load_model("biorob_x4_joint_3")
EQUAL = 1e-9  # of the largest entry of a row
STATIC = STATES[:3]
MODELS = {
    "base": BASE,
    "asymmetric": damped("figure_7"),
    "friction": with_typical(BASE, "coulomb_friction", "overstretch_protection", "gravity_load"),
    "implicit": with_typical(
        damped("figure_7"), "spring_hardening", "spring_relaxation", "tendon_compliance"
    ),
    "states": with_typical(
        damped("figure_7"), "lugre_friction", "spring_hysteresis", "measurement_delay"
    ),
}
NONLINEAR = with_typical(damped("figure_7"), "spring_hardening", "quadratic_drag")
POINTS = (
    ("III", OperatingPoint(load_torque=0.5, motor_position=0.4)),
    ("III", OperatingPoint(joint_position=-0.3, deflection=0.01)),
    ("III", OperatingPoint(joint_velocity=0.7)),
    ("I", OperatingPoint(motor_position=0.2, deflection=-0.15, joint_velocity=-0.3)),
    ("II", OperatingPoint(motor_position=-0.1, deflection=0.15)),
)


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    """Path of the FMU of a model in a version of FMI, exported when first asked for."""
    made = {}

    def get(name, version=2):
        if (name, version) not in made:
            path = tmp_path_factory.mktemp(name) / "x.fmu"
            model = NONLINEAR if name == "nonlinear" else MODELS[name]
            made[name, version] = export_fmu(model, path, fmi_version=version)
        return made[name, version]

    return get


def blocks(system):
    """[A B; C D]."""
    return np.block([[system.A, system.B], [system.C, system.D]])


def largest_difference(found, expected):
    """Of entries of the matrices, in shares of the largest of their row."""
    found, expected = blocks(found), blocks(expected)
    size = np.abs(expected).max(axis=1, keepdims=True)
    return float((np.abs(found - expected) / np.where(size > 0.0, size, 1.0)).max())


def assert_same(found, expected):
    """The same linear model, that says the same of where it lies."""
    assert largest_difference(found, expected) <= EQUAL
    for labels in ("state_labels", "input_labels", "output_labels"):
        assert getattr(found, labels) == getattr(expected, labels)
    assert found.drive is expected.drive
    validity, wanted = found.validity, expected.validity
    assert validity.active
    assert wanted.active
    assert (validity.slack_state, validity.modes) == (wanted.slack_state, wanted.modes)
    assert validity.operating_point.modes == wanted.operating_point.modes
    for part in ("states", "inputs", "outputs"):
        assert getattr(validity.operating_point, part) == pytest.approx(
            getattr(wanted.operating_point, part), rel=1e-9, abs=1e-9
        )


def placed(system):
    """Deflection and load of the boundaries, (n, 2)."""
    return np.array(
        [(boundary.deflection, boundary.load_torque) for boundary in system.validity.boundaries]
    )


# ---- the same as of the equations ---------------------------------------------------------------


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("name", MODELS)
def test_is_that_of_the_equations(exported, name, version):
    for state in STATIC:
        found = linearise_fmu(exported(name, version), state)
        expected = linearise(MODELS[name], state)
        assert_same(found, expected)
        assert np.allclose(placed(found), placed(expected), rtol=0, atol=1e-8)


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("name", ["base", "friction"])
def test_is_that_of_the_equations_at_any_point(exported, name, version):
    for state, point in POINTS:
        found = linearise_fmu(exported(name, version), state, point)
        assert_same(found, linearise(MODELS[name], state, point))


@pytest.mark.parametrize("drive", Drive)
def test_is_that_of_the_equations_with_any_drive(exported, drive):
    model = MODELS["asymmetric"].model_copy(update={"motor": Motor(inertia=2e-3, damping=0.01)})
    kept = {"inputs": ["load_torque"], "outputs": ["deflection", "joint_velocity"]}
    found = linearise_fmu(exported("asymmetric"), "II", drive=drive, motor=model.motor, **kept)
    assert_same(found, linearise(model, "II", drive=drive, **kept))


@pytest.mark.parametrize("version", [2, 3])
def test_start_values_are_those_of_the_model(exported, version):
    values = {
        "transmission.lower_spring.parallel": 3,
        "transmission.upper_spring.damping": 12.0,
        "transmission.pretension_force": 60.0,
        "link.inertia": 0.07,
    }
    found = linearise_fmu(exported("base", version), "I", start_values=values)
    expected = linearise(BASE.with_values(values), "I")
    assert_same(found, expected)
    assert np.allclose(placed(found), placed(expected), rtol=0, atol=1e-8)
    assert largest_difference(found, linearise(BASE, "I")) > 0.1


@pytest.mark.slow
def test_matrices_are_those_of_the_equations_with_any_effect(tmp_path):
    largest = 0.0
    for effect in CATALOGUE:
        model = with_typical(damped("figure_7"), effect.id)
        path = export_fmu(model, tmp_path / f"{effect.id}.fmu")
        points = [(state, None) for state in STATIC]
        points.append(("III", OperatingPoint(load_torque=1.0, motor_position=0.3)))
        points.append(("III", OperatingPoint(joint_velocity=-0.5)))
        for state, point in points:
            found = linearise_fmu(path, state, point)
            expected = linearise(model, state, point)
            assert found.state_labels == expected.state_labels
            assert found.output_labels == expected.output_labels
            largest = max(largest, largest_difference(found, expected))
    print(f"largest difference over all effects: {largest:.1e}")
    assert largest <= EQUAL


# ---- the paper's --------------------------------------------------------------------------------


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("state", STATIC)
def test_matrices_are_those_of_the_paper(exported, state, version):
    model = MODELS["asymmetric"]
    stiffness, damping = closed_form(model, state)
    t, link = model.transmission, model.link
    ratio = t.motor_pulley_radius / t.joint_pulley_radius
    outputs = ["joint_torque", "deflection", "motor_torque"]
    system = linearise_fmu(exported("asymmetric", version), state, outputs=outputs)
    moving = [-stiffness, -(damping + link.damping), ratio * stiffness, ratio * damping, 1.0]
    torque = [-stiffness, -damping, ratio * stiffness, ratio * damping, 0.0]
    expected = np.array(
        [
            [0, 1, 0, 0, 0],
            np.array(moving) / link.inertia,
            torque,
            [1, 0, -ratio, 0, 0],
            [ratio * sample for sample in torque],
        ]
    )
    assert np.allclose(blocks(system), expected, rtol=1e-12, atol=1e-12)


# ---- finite differences -------------------------------------------------------------------------


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("name", MODELS)
def test_is_the_slope_of_rates_and_outputs_of_the_fmu(exported, tmp_path, name, version):
    path = exported(name, version)
    point = OperatingPoint(load_torque=0.4, motor_position=0.2, joint_velocity=0.2)
    system = linearise_fmu(path, "III", point)
    at = system.validity.operating_point
    x, u = np.array([*at.states.values()]), np.array([*at.inputs.values()])
    instance = Fmu(path, tmp_path).model(logging=False)
    try:
        instance.begin({"motor_velocity_connected": True})
        unknowns = [*(f"der({state})" for state in at.states), *at.outputs]

        def values(z):
            instance.move(*z[: len(x)])
            for name, value in zip(at.inputs, z[len(x) :], strict=True):
                instance.set(name, value)
            return instance.values(unknowns)

        z = np.concatenate([x, u])
        values(z)
        instance.fmu.enterEventMode()
        instance.iterate_events()
        steps = 1e-6 * np.concatenate([_nominals(instance, at.states), np.ones(3)])
        slopes = [
            (values(z + step) - values(z - step)) / (2.0 * size)
            for size, step in zip(steps, np.diag(steps), strict=True)
        ]
    finally:
        instance.free()
    expected = blocks(system)
    size = np.abs(expected).max(axis=1)
    assert np.allclose(np.transpose(slopes) / size[:, None], expected / size[:, None], atol=1e-7)


def _nominals(instance, names):
    return np.array([float(instance.variables[name].nominal or 1.0) for name in names])


DURATION = 1e-3  # s
# of joint_position, joint_velocity, motor_position, and of motor_velocity, load_torque
DISTURBANCES = np.diag([2e-3, 0.5, 2e-3, 2.0, 0.5])


@pytest.mark.parametrize("state", STATIC)
def test_what_remains_of_a_simulation_is_of_second_order(exported, state):
    """A disturbance half as large leaves a quarter: the linear part is right in every direction."""
    system = linearise_fmu(exported("nonlinear"), state, drive=Drive.VELOCITY)
    for disturbance in DISTURBANCES:
        large, small = (remainder(NONLINEAR, system, factor * disturbance) for factor in (1.0, 0.5))
        assert np.all(small <= 0.3 * large + 1e-10)  # a quarter, third order, solver
        assert 1e-8 < large.max() < 0.02


@pytest.mark.parametrize("state", STATIC)
def test_moves_as_simulated(exported, state):
    """Without effects nothing remains but the error of the solver."""
    system = linearise_fmu(exported("asymmetric"), state, drive=Drive.VELOCITY)
    for disturbance in DISTURBANCES:
        assert remainder(MODELS["asymmetric"], system, disturbance).max() < 1e-10


def remainder(model, system, disturbance):
    """What outputs of a simulation differ by from the linear model after `DURATION`.

    The states begin with the disturbance and the inputs keep it. In shares of what all
    `DISTURBANCES` do to an output at once.
    """
    at = system.validity.operating_point
    A = np.zeros((5, 5))
    A[:3] = np.hstack([system.A, system.B])
    by = np.hstack([system.C, system.D])[:-1]  # without motor_position
    expected = by @ expm(A * DURATION) @ disturbance
    time = DURATION * np.arange(3.0)  # beyond, that the motor's motion has a rate there
    joint = ("joint_position", "joint_velocity")
    start = np.array([at.states[name] for name in joint]) + disturbance[:2]
    run = simulate(
        model,
        time,
        at.inputs["motor_position"] + disturbance[2] + disturbance[3] * time,
        np.full(3, at.inputs["load_torque"] + disturbance[4]),
        initial_state=dict(zip(joint, start, strict=True)),
        tolerance=1e-13,
    )
    assert run.event_times.size == 0
    seen = system.output_labels[:-1]
    simulated = np.array([run[name][1] - at.outputs[name] for name in seen])
    size = np.abs(by) @ DISTURBANCES.diagonal()
    return np.abs(simulated - expected) / np.where(size > 0.0, size, 1.0)


# ---- boundaries ---------------------------------------------------------------------------------


@pytest.mark.parametrize("version", [2, 3])
def test_on_a_boundary_there_are_both_sides(exported, version):
    model, path = MODELS["asymmetric"], exported("asymmetric", version)
    low, high = slack_boundaries(model.transmission)
    for deflection, names in ((low, ("I", "III")), (high, ("III", "II"))):
        point = OperatingPoint(motor_position=0.1, deflection=deflection)
        for state in names:  # either can be asked for
            system = linearise_fmu(path, state, point)
            assert system.validity.on_boundary
            assert system.validity.slack_state.name == state
            assert tuple(side.validity.slack_state.name for side in system.sides) == names
            for name, side in zip(names, system.sides, strict=True):
                stiffness, _ = closed_form(model, name)
                acceleration = -stiffness / model.link.inertia
                assert side.A[1, 0] == pytest.approx(acceleration, rel=1e-12)
            assert system.A[1, 0] == system.sides[names.index(state)].A[1, 0]


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("state", STATIC)
def test_a_joint_at_rest_sticks_and_breaks_away_by_its_friction(exported, state, version):
    system = linearise_fmu(exported("friction", version), state)
    assert system.validity.operating_point.modes["joint_motion"] == 0
    assert system.validity.modes["joint_motion"] == 1
    friction = MODELS["friction"].effects["coulomb_friction"]["torque"]
    margins = {
        boundary.switches["joint_motion"]: boundary.torque_margin
        for boundary in system.validity.boundaries
        if "joint_motion" in boundary.switches
    }
    assert margins == pytest.approx({-1: -friction, 1: friction}, rel=1e-6)


def test_a_regime_is_held_beyond_its_boundary(exported):
    """The stiffness of state III at a point of state II, as a regime says."""
    with fmu_plant(exported("asymmetric"), {}) as plant:
        u = np.zeros(3)
        inside, beyond = plant.start(u, 0.0), plant.start(u, 0.09)
        taut, slack = plant.settle(inside, u), plant.settle(beyond, u)
        assert (taut.slack_state, slack.slack_state) == (SlackState.III, SlackState.II)
        for regime in (taut, slack, taut):
            stiffness, _ = closed_form(MODELS["asymmetric"], regime.slack_state.name)
            found = plant.jacobians(beyond, u, regime).A[1, 0]
            assert found == pytest.approx(-stiffness / MODELS["asymmetric"].link.inertia)


def test_indicators_without_names_are_numbered(exported, monkeypatch):
    """FMI 2.0 with an effect that nobody here knows: only the joint's motion is recognised."""
    expected = linearise_fmu(exported("friction"), "III")
    monkeypatch.setattr(fmu_variables, "BY_ID", {})
    found = linearise_fmu(exported("friction"), "III")
    count = len(expected.validity.modes) - 1
    numbered = {f"indicator_{i + 1}" for i in range(count)}
    assert found.validity.modes.keys() == {*numbered, "joint_motion"}
    assert [*found.validity.modes.values()] == [*expected.validity.modes.values()]
    assert largest_difference(found, expected) == 0.0
    monkeypatch.undo()
    monkeypatch.setattr(fmu_variables, "BY_ID", {})
    plain = linearise_fmu(exported("asymmetric"), "III")
    assert "joint_motion" not in plain.validity.modes


# ---- refusals -----------------------------------------------------------------------------------


def changed(path, folder, changes, leave_out=()):
    """A copy of an FMU with its description changed, or files left out by the start of the name."""
    copy = folder / "changed.fmu"
    with zipfile.ZipFile(path) as old, zipfile.ZipFile(copy, "w") as new:
        for name in old.namelist():
            content = old.read(name)
            if name == "modelDescription.xml":
                for before, after in changes.items():
                    assert before.encode() in content
                    content = content.replace(before.encode(), after.encode())
            if not name.startswith(tuple(leave_out)):
                new.writestr(name, content)
    return copy


def refusal(path, *arguments, **options):
    with pytest.raises(LinearisationError) as caught:
        linearise_fmu(path, *(arguments or ("III",)), **options)
    text = str(caught.value)
    assert "\n" not in text
    assert text.startswith(path.name)
    return text


def test_what_is_no_fmu_is_refused(tmp_path):
    assert "no such file" in refusal(tmp_path / "none.fmu")
    text = tmp_path / "text.fmu"
    text.write_text("no archive")
    assert "this is no FMU" in refusal(text)
    archive = tmp_path / "archive.fmu"
    with zipfile.ZipFile(archive, "w") as file:
        file.writestr("readme", "")
    assert "this is no FMU (no modelDescription.xml)" in refusal(archive)
    for content in ("<fmi", '<fmiModelDescription fmiVersion="4.0"/>', "<other/>"):
        with zipfile.ZipFile(archive, "w") as file:
            file.writestr("modelDescription.xml", content)
        assert "its modelDescription.xml cannot be read" in refusal(archive)


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({'name="load_torque"': 'name="load"'}, "the FMU has no load_torque, so it is none of"),
        ({'name="slack_state"': 'name="slack"'}, "the FMU has no slack_state, so it is none of"),
        (
            {'name="transmission.pretension_force"': 'name="force"'},
            "the FMU has no transmission.pretension_force",
        ),
        ({"providesDirectionalDerivative": "canSwim"}, "the FMU has no directional derivatives"),
        ({"<ModelExchange": "<NoExchange"}, "the FMU has no model exchange"),
        ({"canGetAndSetFMU": "canSwimFMU"}, "the FMU cannot get and set its state"),
    ],
)
@pytest.mark.parametrize("version", [2, 3])
def test_what_is_no_fmu_of_ours_is_refused(exported, tmp_path, changes, reason, version):
    assert reason in refusal(changed(exported("base", version), tmp_path, changes))


@pytest.mark.parametrize("version", [2, 3])
def test_a_binary_that_cannot_be_loaded_is_refused(exported, tmp_path, version, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = changed(exported("base", version), tmp_path, {}, leave_out=["binaries/"])
    assert "export the FMU for this platform" in refusal(path)
    with zipfile.ZipFile(path, "a") as file:
        with zipfile.ZipFile(exported("base", version)) as whole:
            binaries = [name for name in whole.namelist() if name.startswith("binaries/")]
        for binary in binaries:
            file.writestr(binary, "no library")
    assert "export the FMU for this platform" in refusal(path)
    assert tmp_path.samefile(".")


def test_what_is_asked_wrongly_is_refused(exported):
    path = exported("base")
    far = OperatingPoint(motor_position=0.0, deflection=0.2)
    assert (
        refusal(path, "I", far)
        == "x.fmu: the FMU is in state II there, and an FMU is linearised where it is; "
        "give an operating point in state I"
    )
    assert "give an operating point in state both" in refusal(path, "both")
    assert "an FMU has no rotor; give the motor" in refusal(path, drive=Drive.TORQUE)
    with pytest.raises(LinearisationError, match="no slack state 'IV'"):
        linearise_fmu(path, "IV")
    with pytest.raises(LinearisationError, match="no output 'speed'"):
        linearise_fmu(path, "III", outputs=["speed"])


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize(
    ("name", "value", "reason"),
    [
        ("transmission.pretension", 50.0, "did you mean transmission.pretension_force?"),
        ("joint_position", 0.1, "the FMU has no such parameter"),
        ("link.inertia", float("nan"), "nan is no finite number"),
        ("transmission.upper_spring.parallel", 1.5, "1.5 is no whole number"),
        ("transmission.upper_spring.parallel", float("inf"), "inf is no whole number"),
        ("link.inertia", -1.0, "link.inertia = -1 is outside"),
        ("transmission.pretension_force", 9e5, "it is above the"),
    ],
)
def test_start_values_that_cannot_be_are_refused(exported, version, name, value, reason):
    assert reason in refusal(exported("base", version), start_values={name: value})


@pytest.mark.parametrize("version", [2, 3])
def test_nothing_is_left_and_nothing_is_printed(exported, tmp_path, monkeypatch, capfd, version):
    path = exported("base", version)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    linearise_fmu(path, "II")
    refusal(path, "I", OperatingPoint(deflection=0.2))
    refusal(path, start_values={"link.inertia": -1.0})
    refusal(changed(path, tmp_path, {}, leave_out=["binaries/"]))
    assert [file.name for file in tmp_path.iterdir()] == ["changed.fmu"]
    assert capfd.readouterr() == ("", "")
