"""What the FMU of every effect must satisfy: it is the simulated model, in every way to call it."""

import numpy as np
import pytest
from contract_cases import CROOKED, with_typical
from fmpy.validation import validate_fmu

from elastic_tendon.compiled import simulate
from elastic_tendon.effects import BY_ID, CATALOGUE
from elastic_tendon.fmu.export import export_fmu
from elastic_tendon.variables import interface
from fmu_driver import Fmu, Segments, run_co_simulation, run_model_exchange

TOLERANCE = 1e-9
AGREEMENT = 1e-6  # rad; CVode restarts at every sample
DIFFERENCES = 1e-5  # relative, of central differences
TIME = np.cumsum(np.r_[0.0, np.full(100, 0.01)])  # the sums that an importer makes
# at rest at first: an FMU gets the rate of an input after its initialisation only
MOVING = np.maximum(TIME - TIME[1], 0.0)
MOTION = Segments(TIME, 0.4 * (np.sin(9.0 * MOVING) + 0.5 * np.sin(31.0 * MOVING)), linear=True)


# each alone, and three with equations that are solved at run time
SETS = [
    *((effect.id,) for effect in CATALOGUE),
    ("spring_hardening", "spring_relaxation", "tendon_compliance"),
]


@pytest.fixture(scope="module", params=SETS, ids="-".join)
def case(request, tmp_path_factory):
    """An actuator with the effects, and its FMU."""
    model = CROOKED
    for effect_id in request.param:
        model = with_typical(model, BY_ID[effect_id])
    folder = tmp_path_factory.mktemp("-".join(request.param))
    return model, Fmu(export_fmu(model, folder / "x.fmu"), folder / "unpacked")


@pytest.fixture
def instance(case):
    """An instance of the FMU of the kind asked for; motor velocity is connected."""
    alive = []

    def make(kind):
        alive.append(getattr(case[1], kind)())
        return alive[-1]

    yield make
    for one in alive:
        one.free()


def simulated(model):
    return simulate(
        model, MOTION.time, MOTION.position, interpolation="linear", tolerance=TOLERANCE
    )


def test_fmpy_finds_no_fault_and_every_variable(case):
    model, fmu = case
    assert validate_fmu(str(fmu.path)) == []
    names = {one.name for one in fmu.description.modelVariables}
    variables = interface(model.effect_ids)
    for group in (variables.states, variables.outputs, variables.parameters):
        assert {one.name for one in group} <= names


def test_co_simulation_is_simulate_to_the_bit(case, instance):
    expected = simulated(case[0])
    for output in ("joint_position", "joint_torque", "motor_torque", "slack_state"):
        found = run_co_simulation(instance("slave"), MOTION, output, tolerance=TOLERANCE)
        assert np.ptp(found) > 0.0
        # after the last sample the FMU's motor stands still, where simulate ends moving
        assert (found == expected[output])[:-1].all(), output


def test_model_exchange_agrees(case, instance):
    found, _ = run_model_exchange(instance("model"), MOTION, tolerance=TOLERANCE)
    assert np.abs(found - simulated(case[0])["joint_position"]).max() < AGREEMENT


def test_directional_derivatives_agree_with_differences(case, instance):
    """While initialising, where starts that are calculated follow what is set."""
    one = instance("model")
    one.set_up(
        {"joint_position": 0.1, "joint_velocity": 0.7, "motor_position": 0.23}
        | {"motor_velocity": 0.9, "motor_velocity_connected": True}
    )
    variables = interface(case[0].effect_ids)
    unknowns = [name.name for name in variables.outputs if not name.discrete]
    unknowns += [f"der({name})" for name in variables.state_names]
    parameters = [one.name for one in variables.parameters if not one.discrete]
    for known in ("motor_position", "motor_velocity", "load_torque", *parameters):
        found = one.derivative(unknowns, [known], [1.0])
        expected = differences(one, unknowns, known)
        scale = np.abs(expected) + 1e-4 * np.abs(expected).max() + 1e-4
        assert (np.abs(found - expected) <= DIFFERENCES * scale).all(), known


def differences(one, unknowns, known):
    """Central differences at 1e-4 of the value, where rounding is smaller than at less."""
    centre, nominal = one.get(known), float(one.variables[known].nominal)
    step = 1e-4 * max(abs(centre), nominal)
    values = []
    for value in (centre - step, centre + step):
        one.set(known, value)
        values.append(np.array([one.get(name) for name in unknowns]))
    one.set(known, centre)
    return (values[1] - values[0]) / (2 * step)
