"""What the analysis says, against the paper's closed forms and against plain linear algebra."""

from math import inf, sqrt

import numpy as np
import pytest
from linear_cases import with_typical

from elastic_tendon import simulate
from elastic_tendon.actuator.parameters import Model, load_model, typical_value
from elastic_tendon.effects import BY_ID
from elastic_tendon.errors import LinearisationError
from elastic_tendon.linear.analysis import Analysis, analyse, frequency_span, main_channels
from elastic_tendon.linear.linearise import linearise
from elastic_tendon.linear.result import Drive, LinearModel, OperatingPoint
from elastic_tendon.linear.selection import selected

STIFFNESS = {"I": 1.0, "II": 0.75, "III": 1.75}  # of R² k_1, (19), (23), (25)
DAMPING = {"I": 2.0, "II": 5.0, "III": 7.0}  # of R², (20), (23), (25)
# effects with states of their own; of some, a mode at 0 that nothing brings back
WITH_STATES = (
    "lugre_friction",
    "spring_hysteresis",
    "spring_relaxation",
    "spring_mass",
    "tendon_compliance",
)


@pytest.fixture(scope="module")
def model() -> Model:
    """Asymmetric springs with damping, a gear and a rotor."""
    base = load_model("biorob_x4_joint_3").model_dump()
    springs = base["transmission"]
    springs["upper_spring"] |= {"stiffness": 12000.0, "parallel": 1, "damping": 2.0}
    springs["lower_spring"] |= {"stiffness": 9000.0, "parallel": 1, "damping": 5.0}
    springs["motor_pulley_radius"] = 0.02
    base["motor"] = {"inertia": 0.004, "damping": 0.02}
    return Model.model_validate(base)


def closed_form(model: Model, state: str) -> tuple[float, float]:
    """Stiffness (N·m/rad) and damping (N·m·s/rad) of a state by the paper."""
    squared = model.transmission.joint_pulley_radius**2
    return 12000.0 * squared * STIFFNESS[state], squared * DAMPING[state]


def with_matrices(model: LinearModel, A: np.ndarray, B: np.ndarray, C: np.ndarray) -> LinearModel:
    """Another system under the names of a linear model."""
    return LinearModel(
        (A, B, C, np.zeros((len(C), B.shape[1]))),
        *(model.validity, model.drive),
        inputs=list(model.input_labels[: B.shape[1]]),
        outputs=list(model.output_labels[: len(C)]),
        states=[f"x{i}" for i in range(len(A))],
    )


@pytest.mark.parametrize("state", ["I", "II", "III"])
def test_poles_and_stiffness_are_those_of_the_paper(model: Model, state: str) -> None:
    stiffness, damping = closed_form(model, state)
    found = analyse(linearise(model, state))
    (pole,) = found.poles
    inertia, friction = model.link.inertia, model.link.damping
    frequency = sqrt(stiffness / inertia)
    assert pole.oscillates
    assert pole.natural_frequency == pytest.approx(frequency, rel=1e-12)
    assert pole.damping_ratio == pytest.approx(
        (damping + friction) / (2.0 * inertia * frequency), rel=1e-12
    )
    assert found.tendon_stiffness == pytest.approx(stiffness, rel=1e-12)
    assert found.tendon_damping == pytest.approx(damping, rel=1e-12)
    assert found.stiffness == pytest.approx(stiffness, rel=1e-12)


@pytest.mark.parametrize("drive", list(Drive))
def test_static_stiffness_is_that_with_the_motor_held_for_every_drive(
    model: Model, drive: Drive
) -> None:
    found = analyse(linearise(model, "II", drive=drive))
    assert found.stiffness == pytest.approx(closed_form(model, "II")[0], rel=1e-9)
    if drive is Drive.POSITION:
        assert found.tendon_stiffness is None  # the torque needs the motor's velocity
    else:
        assert found.tendon_stiffness == pytest.approx(found.stiffness, rel=1e-9)


def test_a_sudden_deflection_takes_the_memory_of_a_hysteresis_along() -> None:
    """Against the simulated torque of a small and fast motion of the motor, the joint at rest."""
    model = with_typical(load_model("biorob_x4_joint_3"), "spring_hysteresis")
    time, step = np.linspace(0.0, 1e-3, 11), 1e-5
    run = simulate(model.with_values({"link.inertia": 1e4}), time, step * time / time[-1])
    simulated = float(run["joint_torque"][-1]) / step
    assert simulated > 1.5 * closed_form(model, "III")[0]
    assert analyse(linearise(model, "III")).tendon_stiffness == pytest.approx(simulated, rel=2e-3)


def test_a_joint_that_sticks_says_nothing_of_its_tendons() -> None:
    model = with_typical(load_model("biorob_x4_joint_3"), "tendon_guide_friction")
    found = analyse(linearise(model, "III", modes={"joint_motion": 0}))
    assert (found.tendon_stiffness, found.tendon_damping) == (None, None)
    assert found.stiffness == inf
    assert not found.channel("load_torque", "joint_position").responds


def test_the_tendons_oscillation_is_not_that_of_the_arm_under_gravity() -> None:
    model = with_typical(load_model("biorob_x4_joint_3"), "gravity_load")
    found = analyse(linearise(model, "III", drive=Drive.TORQUE))
    slowest = next(pole for pole in found.poles if pole.oscillates)
    bare = analyse(linearise(load_model("biorob_x4_joint_3"), "III", drive=Drive.TORQUE))
    frequency = found.tendon_oscillation.natural_frequency
    assert frequency == pytest.approx(bare.tendon_oscillation.natural_frequency, rel=0.02)
    assert slowest.natural_frequency < 0.2 * frequency


@pytest.mark.parametrize("state", ["I", "II", "III"])
def test_anti_resonance_of_the_motor_is_the_joint_on_its_tendons(model: Model, state: str) -> None:
    """A motor that stands still leaves the joint swinging on the held tendons."""
    linear = linearise(model, state, drive=Drive.TORQUE)
    found = analyse(linear)
    collocated, non_collocated = (found.channel(*channel) for channel in main_channels(linear)[:2])
    held = sqrt(closed_form(model, state)[0] / model.link.inertia)
    assert collocated.anti_resonances == pytest.approx([held], rel=1e-9)
    assert len(collocated.zeros) == 2
    assert non_collocated.anti_resonances == ()
    stiffness, damping = closed_form(model, state)
    assert non_collocated.zeros == pytest.approx([-stiffness / damping], rel=1e-9)


def test_poles_of_a_free_rotor_are_a_pair_and_two_of_rigid_motion(model: Model) -> None:
    found = analyse(linearise(model, "III", drive=Drive.TORQUE)).poles
    at_rest, slow, pair = found
    assert (at_rest.value, at_rest.time_constant, at_rest.damping_ratio) == (0.0, inf, 0.0)
    ratio = 1.5  # of the pulleys: the rotor counts with its square at the joint
    inertia = model.link.inertia + 0.004 * ratio**2
    friction = model.link.damping + 0.02 * ratio**2
    assert slow.time_constant == pytest.approx(inertia / friction, rel=0.02)
    assert slow.damping_ratio == 1.0
    assert pair.oscillates
    assert pair.value.imag > 0.0


@pytest.mark.parametrize("drive", list(Drive))
def test_transfer_functions_of_zeros_poles_and_gain_are_the_systems(
    model: Model, drive: Drive
) -> None:
    """At one frequency, by the products over zeros and poles, scaled at another."""
    linear = linearise(model, "III", drive=drive)
    near, far = 3.0 + 2.0j, 50.0 - 7.0j
    response, scale = linear(near), linear(far)
    poles, modes = np.linalg.eig(linear.A)
    for channel in analyse(linear).channels:
        i = linear.output_labels.index(channel.output)
        j = linear.input_labels.index(channel.input)
        if abs(scale[i, j]) == 0.0:
            assert channel.zeros == ()
            continue
        # zeros that cancel a pole are left out, so leave out the poles without a share
        shares = (linear.C[i] @ modes) * np.linalg.solve(modes, linear.B[:, j])
        kept = list(poles[np.abs(shares) > 1e-9 * np.abs(shares).max()])
        zeros = list(channel.zeros)

        def product(at: complex, roots: list[complex]) -> complex:
            return complex(np.prod([at - root for root in roots]))

        expected = scale[i, j] * product(near, zeros) / product(far, zeros)
        expected *= product(far, kept) / product(near, kept)
        assert response[i, j] == pytest.approx(expected, rel=1e-8), (channel.input, channel.output)


@pytest.mark.parametrize("drive", [Drive.SOURCE, Drive.VELOCITY, Drive.TORQUE])
@pytest.mark.parametrize("effect_id", ["", *WITH_STATES])
def test_gain_is_the_limit_at_low_frequency(model: Model, effect_id: str, drive: Drive) -> None:
    if effect_id:
        parameters = BY_ID[effect_id].parameters
        model = model.with_effect(
            effect_id, {parameter.name: typical_value(model, parameter) for parameter in parameters}
        )
    linear = linearise(model, "I", drive=drive)
    found = analyse(linear)
    infinite = 0
    for channel in found.channels:
        i = linear.output_labels.index(channel.output)
        j = linear.input_labels.index(channel.input)
        slow = linear(1e-7)[i, j].real
        if abs(channel.gain) == inf:
            infinite += 1
            assert np.sign(slow) == np.sign(channel.gain)
            assert abs(slow) > 1e4
        else:
            assert slow == pytest.approx(channel.gain, rel=1e-4, abs=1e-4)
    assert infinite < len(found.channels)
    assert infinite > 0 or drive is not Drive.VELOCITY  # the motor drifts, at least


def test_zeros_far_from_all_poles_are_no_rounding(model: Model) -> None:
    """Of four integrators in a row none; control's pencil has them where rounding puts them."""
    base = linearise(model, "III")
    A = np.diag(np.ones(3), 1) - np.diag([1.0, 20.0, 300.0, 4e4])
    A[3, 0] = -5e8  # closes the chain, so that no pole is a zero
    B, C = np.eye(4)[:, [3]], np.eye(4)
    load = np.hstack([np.zeros((4, 2)), 7.0 * B])
    found = analyse(with_matrices(base, A, load, C))
    zeros = {
        channel.output: channel.zeros
        for channel in found.channels
        if channel.input == "load_torque"
    }
    assert zeros["joint_torque"] == ()
    assert zeros["joint_position"] == pytest.approx([-1.0])
    assert zeros["deflection"] == pytest.approx([-1.0, -20.0, -300.0])
    assert all(channel.zeros == () for channel in found.channels if channel.input != "load_torque")


def test_gravity_counts_to_the_static_stiffness_and_not_to_the_tendons() -> None:
    model = load_model("biorob_x4_joint_3").with_effect("gravity_load", None)
    name = next(path for path in model.values() if path.startswith("effects.gravity_load."))
    model = model.with_values({name: 3.0})
    linear = linearise(model, "III", OperatingPoint(joint_position=0.4, deflection=0.0))
    found = analyse(linear)
    inertia = model.link.inertia
    assert found.tendon_stiffness == pytest.approx(41.688, rel=1e-9)
    assert abs(found.stiffness - 41.688) > 0.1
    assert found.stiffness == pytest.approx(-inertia * linear.A[1, 0], rel=1e-9)


def test_a_joint_that_sticks_is_stiff_and_one_without_tendons_drifts() -> None:
    model = load_model("biorob_x4_joint_3")
    rough = model.with_effect("coulomb_friction", {"torque": 0.5})
    assert analyse(linearise(rough, "III", modes={"joint_motion": 0})).stiffness == inf
    assert analyse(linearise(rough, "III")).stiffness == pytest.approx(41.688, rel=1e-9)
    free = analyse(linearise(model, "both"))
    assert free.stiffness == 0.0
    assert free.tendon_oscillation is None
    assert free.channel("load_torque", "joint_velocity").gain == pytest.approx(1.0 / 0.16)


def test_memory_that_no_rate_brings_back_holds_in_the_long_run() -> None:
    """LuGre's bristles at rest: a spring beside the tendons, whose state is a mode at 0."""
    model = load_model("biorob_x4_joint_3").with_effect("lugre_friction", None)
    rates = {path: 2.0 for path in model.values() if path.startswith("effects.lugre_friction.")}
    linear = linearise(model.with_values(rates), "III")
    found = analyse(linear)
    slow = linear(1e-6)[linear.output_labels.index("joint_position"), 2].real
    assert found.stiffness == pytest.approx(1.0 / slow, rel=1e-6)


def test_span_is_from_the_slackest_to_the_tautest_state(model: Model) -> None:
    every = [analyse(linearise(model, state)) for state in ("I", "II", "III", "both")]
    span = frequency_span(every)
    assert span is not None
    assert span.lowest == pytest.approx(sqrt(closed_form(model, "II")[0] / model.link.inertia))
    assert span.ratio == pytest.approx(sqrt(1.75 / 0.75), rel=1e-9)
    assert frequency_span(every[3:]) is None


def test_a_selection_is_analysed_before_it_is_made(model: Model) -> None:
    linear = linearise(model, "III")
    wanted = selected(linear, ["load_torque"], ["deflection", "joint_velocity"])
    assert wanted.output_labels == ["deflection", "joint_velocity"]
    assert np.array_equal(wanted.B, linear.B[:, [2]])
    assert np.array_equal(wanted.C, linear.C[[3, 2]])
    with pytest.raises(LinearisationError, match=r"no output joint_position.*select afterwards"):
        analyse(wanted)
    with pytest.raises(LinearisationError, match="no input 'speed'"):
        selected(linear, ["speed"], None)
    found: Analysis = analyse(linear)
    with pytest.raises(LinearisationError, match="no channel from 'speed'"):
        found.channel("speed", "deflection")
