"""What the FMUs of every effect must satisfy: they are the simulated model, however called."""

import numpy as np
import pytest
from contract_cases import CROOKED, with_typical
from fmpy.validation import validate_fmu

from effects_at import AT_POSITION
from elastic_tendon.actuator.variables import interface
from elastic_tendon.effects import BY_ID
from elastic_tendon.fmu.export import export_fmu
from elastic_tendon.simulation.simulate import simulate
from fmu_driver import Fmu, Segments, run_co_simulation, run_model_exchange

pytestmark = pytest.mark.usefixtures("all_made_soon")

TOLERANCE = 1e-9
AGREEMENT = 1e-6  # rad; CVode restarts at every sample
DIFFERENCES = 1e-5  # relative, of central differences
TIME = np.cumsum(np.r_[0.0, np.full(100, 0.01)])  # the sums that an importer makes
# at rest at first: an FMU gets the rate of an input after its initialisation only
MOVING = np.maximum(TIME - TIME[1], 0.0)
POSITION = 0.4 * (np.sin(9.0 * MOVING) + 0.5 * np.sin(31.0 * MOVING))
# FMI 3.0 has no rates of inputs, so it is driven by steps; half as long, for they take more events
MOTIONS = {
    2: Segments(TIME, POSITION, linear=True),
    3: Segments(TIME[:51], POSITION[:51], linear=False),
}

# in CI each alone in one version of FMI, in turn; in both, three that are solved at run time
ALONE = [
    pytest.param(((effect.id,), version), marks=[] if (i + version) % 2 else [pytest.mark.slow])
    for i, effect in enumerate(AT_POSITION)
    for version in MOTIONS
]
TOGETHER = [
    (("spring_hardening", "spring_relaxation", "tendon_compliance"), version) for version in MOTIONS
]


def _name(case):
    effect_ids, version = case
    return f"{'-'.join(effect_ids)}-fmi{version}"


@pytest.fixture(scope="module", params=[*ALONE, *TOGETHER], ids=_name)
def case(request):
    """Ids of effects, and a version of FMI."""
    return request.param


@pytest.fixture(scope="module")
def model(case):
    """An actuator with the effects."""
    model = CROOKED
    for effect_id in case[0]:
        model = with_typical(model, BY_ID[effect_id])
    return model


@pytest.fixture(scope="module")
def fmu(case, model, tmp_path_factory):
    """Its FMU."""
    folder = tmp_path_factory.mktemp("fmu")
    path = export_fmu(model, folder / "x.fmu", fmi_version=case[1])
    return Fmu(path, folder / "unpacked")


@pytest.fixture
def instance(fmu):
    """An instance of the FMU of the kind asked for; motor velocity is connected."""
    alive = []

    def make(kind):
        alive.append(getattr(fmu, kind)())
        return alive[-1]

    yield make
    for instance in alive:
        instance.free()


def simulated(model, motion):
    options = {"interpolation": motion.interpolation, "tolerance": TOLERANCE}
    return simulate(model, motion.time, motion.position, **options)


def test_fmpy_finds_no_fault_and_every_variable(model, fmu):
    assert validate_fmu(str(fmu.path)) == []
    names = {variable.name for variable in fmu.description.modelVariables}
    variables = interface(model.effect_ids)
    for group in (variables.states, variables.outputs, variables.parameters):
        assert {effect.name for effect in group} <= names


def test_co_simulation_is_simulate_to_the_bit(model, fmu, instance):
    motion = MOTIONS[fmu.version]
    expected = simulated(model, motion)
    for output in ("joint_position", "joint_torque", "motor_torque", "slack_state"):
        found = run_co_simulation(instance("slave"), motion, output, tolerance=TOLERANCE)
        assert np.ptp(found) > 0.0
        # after the last sample the FMU's motor stands still, where simulate ends moving
        assert (found == expected[output])[:-1].all(), output


def test_model_exchange_agrees(model, fmu, instance):
    motion = MOTIONS[fmu.version]
    found, _ = run_model_exchange(instance("model"), motion, tolerance=TOLERANCE)
    assert np.abs(found - simulated(model, motion)["joint_position"]).max() < AGREEMENT


def test_derivatives_agree_with_differences_and_each_other(model, fmu, instance):
    """While initialising, where starts that are calculated follow what is set."""
    running = instance("model")
    running.set_up(
        {"joint_position": 0.1, "joint_velocity": 0.7, "motor_position": 0.23}
        | {"motor_velocity": 0.9, "motor_velocity_connected": True}
    )
    variables = interface(model.effect_ids)
    unknowns = [name.name for name in variables.outputs if not name.discrete]
    unknowns += [f"der({name})" for name in variables.state_names]
    parameters = [parameter.name for parameter in variables.parameters if not parameter.discrete]
    knowns = ["motor_position", "motor_velocity", "load_torque", *parameters]
    directional = [running.derivative(unknowns, [known], [1.0]) for known in knowns]
    for known, found in zip(knowns, directional, strict=True):
        expected = differences(running, unknowns, known)
        scale = np.abs(expected) + 1e-4 * np.abs(expected).max() + 1e-4
        assert (np.abs(found - expected) <= DIFFERENCES * scale).all(), known
    if fmu.version == 3:
        rows = [running.adjoint(unknowns, knowns, row) for row in np.eye(len(unknowns)).tolist()]
        assert (np.array(rows) == np.array(directional).T).all()


def differences(running, unknowns, known):
    """Central differences at 1e-4 of the value, where rounding is smaller than at less."""
    centre, nominal = running.get(known), float(running.variables[known].nominal)
    step = 1e-4 * max(abs(centre), nominal)
    values = []
    for value in (centre - step, centre + step):
        running.set(known, value)
        values.append(running.values(unknowns))
    running.set(known, centre)
    return (values[1] - values[0]) / (2 * step)
