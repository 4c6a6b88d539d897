"""The describing function against closed forms and quadrature; limit cycles against simulation."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from elastic_tendon.actuator.design import design
from elastic_tendon.actuator.parameters import load_model, typical_value
from elastic_tendon.actuator.transmission import characteristic_torque, slack_boundaries
from elastic_tendon.effects import CATALOGUE
from elastic_tendon.errors import LinearisationError
from elastic_tendon.linear.describing_function import (
    default_amplitudes,
    describing_function,
)

SAMPLED = 1e-7  # relative, what the product says of kinks
AMPLITUDES = np.array([0.05, 0.11, 0.13, 0.2, 0.4])


@pytest.fixture(scope="module")
def symmetric():
    return load_model("biorob_x4_joint_3")


@pytest.fixture(scope="module")
def asymmetric():
    return load_model("figure_7")


def two_slopes(amplitude, boundary, inner, outer):
    """Describing function of an odd spring of two slopes (Gelb and Vander Velde, chapter 2)."""
    x = np.minimum(boundary / amplitude, 1.0)
    return outer + (inner - outer) * 2 / np.pi * (np.arcsin(x) + x * np.sqrt(1 - x**2))


def by_quadrature(model, amplitude, deflection):
    """Mean torque and equivalent stiffness of the paper's characteristic, (17) to (24)."""

    def torque(phase):
        swing = deflection + amplitude * np.cos(phase)
        return float(characteristic_torque(swing, model.transmission))

    cosines = (np.array(slack_boundaries(model.transmission)) - deflection) / amplitude
    kinks = np.arccos(cosines[np.abs(cosines) < 1])
    pieces = list(pairwise(sorted([0.0, *kinks, np.pi])))
    mean = sum(quad(torque, *piece)[0] for piece in pieces) / np.pi
    in_phase = sum(quad(lambda p: torque(p) * np.cos(p), *piece)[0] for piece in pieces)
    return mean, -2 * in_phase / (np.pi * amplitude)


# ---- the base model ------------------------------------------------------------------------


def test_symmetric_springs_follow_the_closed_form(symmetric):
    table = design(symmetric)
    found = describing_function(symmetric, AMPLITUDES)
    expected = two_slopes(
        *(AMPLITUDES, table.positive_slack_boundary),
        *(table.stiffness_state_3, table.stiffness_state_1),
    )
    assert np.allclose(found.stiffness, expected, rtol=SAMPLED)
    assert np.abs(found.damping).max() * found.frequency < SAMPLED * table.stiffness_state_3
    assert np.abs(found.mean_torque).max() < SAMPLED * table.positive_max_torque * -1


def test_the_ends_are_the_stiffnesses_of_the_states(symmetric):
    table = design(symmetric)
    small, large = describing_function(symmetric, [1e-6, 1e4]).stiffness
    assert small == pytest.approx(table.stiffness_state_3, rel=1e-8)
    assert large == pytest.approx(table.stiffness_state_1, rel=2e-5)


@pytest.mark.parametrize("deflection", [-0.12, 0.0, 0.05, 0.3])
@pytest.mark.parametrize("name", ["symmetric", "asymmetric"])
def test_a_biased_swing_agrees_with_quadrature(name, deflection, request):
    model = request.getfixturevalue(name)
    found = describing_function(model, AMPLITUDES, deflection=deflection)
    expected = np.array([by_quadrature(model, amplitude, deflection) for amplitude in AMPLITUDES])
    largest = design(model).stiffness_state_3
    assert np.allclose(found.stiffness, expected[:, 1], rtol=SAMPLED)
    assert np.allclose(found.mean_torque, expected[:, 0], atol=SAMPLED * largest * AMPLITUDES)


@pytest.mark.parametrize("load", [0.0, 3.0])
def test_the_mean_deflection_is_the_one_that_carries_a_load(asymmetric, load):
    found = describing_function(asymmetric, AMPLITUDES, load_torque=load)
    for index, amplitude in enumerate(AMPLITUDES):
        mean = brentq(lambda mean, a=amplitude: by_quadrature(asymmetric, a, mean)[0] + load, -1, 1)
        assert found.deflection[index] == pytest.approx(mean, abs=2e-6 * amplitude)
    assert np.ptp(found.deflection) > 1e-3


def test_damping_of_taut_springs_is_that_of_the_paper(symmetric):
    damped = symmetric.with_values(
        {"transmission.upper_spring.damping": 20.0, "transmission.lower_spring.damping": 50.0}
    )
    found = describing_function(damped, [0.05])
    assert found.damping[0] == pytest.approx(0.03**2 * 2 * (20.0 + 50.0), rel=SAMPLED)  # (25)
    expected = np.pi * found.frequency * found.damping[0] * 0.05**2
    assert found.loss[0] == pytest.approx(expected, rel=1e-12)


def test_a_kelvin_voigt_spring_does_not_mind_the_frequency_of_a_taut_swing(symmetric):
    slow, fast = (
        describing_function(symmetric, [0.1, 0.2], frequency=frequency)
        for frequency in (0.5, 300.0)
    )
    assert np.allclose(slow.stiffness, fast.stiffness, rtol=1e-7)


def test_a_joint_as_heavy_as_can_be_takes_its_natural_frequency(symmetric):
    springs = [f"transmission.{side}_spring.stiffness" for side in ("upper", "lower")]
    heavy = symmetric.with_values({"link.inertia": 1e4} | dict.fromkeys(springs, 1e7))
    found = describing_function(heavy, [0.001, 0.3])
    expected = [by_quadrature(heavy, amplitude, 0.0)[1] for amplitude in found.amplitudes]
    assert np.allclose(found.stiffness, expected, rtol=3 * SAMPLED)


# ---- with effects --------------------------------------------------------------------------


def test_backlash_follows_the_closed_form_of_a_dead_zone(symmetric):
    """While both tendons stay taut the play is a dead zone of half a gap to each side."""
    gap = 0.02
    loose = symmetric.with_effect("gear_backlash", {"gap": gap})
    amplitudes = np.array([0.005, 0.015, 0.05, 0.1])
    found = describing_function(loose, amplitudes)
    stiffness = design(symmetric).stiffness_state_3
    expected = two_slopes(amplitudes, gap / 2, 0.0, stiffness)
    assert np.allclose(found.stiffness, expected, atol=SAMPLED * stiffness)


def test_tendon_friction_loses_what_its_law_says(symmetric):
    """Taut, with equal springs, the loss is constant: 2 R F_p sinh(w), and 4 A of it a cycle."""
    wrap = 0.05
    rubbing = symmetric.with_effect("tendon_guide_friction", {"wrap_friction": wrap})
    amplitudes = np.array([0.02, 0.1])
    found = describing_function(rubbing, amplitudes)
    friction = 2 * 0.03 * 80.0 * np.sinh(wrap)
    assert np.allclose(found.loss, 4 * amplitudes * friction, rtol=1e-5)
    stiffness = design(symmetric).stiffness_state_3 * np.cosh(wrap)
    assert np.allclose(found.stiffness, stiffness, rtol=1e-5)


def test_relaxing_springs_follow_their_complex_stiffness(symmetric):
    added, time_constant = 2000.0, 0.05
    relaxing = symmetric.with_effect(
        "spring_relaxation", {"stiffness": added, "time_constant": time_constant}
    )
    found = describing_function(relaxing, [0.05], frequency=15.0)
    lag = 1j * 15.0 * time_constant
    complex_stiffness = 0.03**2 * 4 * (11580.0 + added * lag / (1 + lag))  # four springs
    assert found.stiffness[0] == pytest.approx(complex_stiffness.real, rel=1e-6)
    assert found.damping[0] == pytest.approx(complex_stiffness.imag / 15.0, rel=1e-5)


def test_effects_on_the_joint_are_no_part_of_it(symmetric):
    loaded = symmetric.with_effect("coulomb_friction", {"torque": 2.0})
    loaded = loaded.with_effect("gravity_load", {"torque": 3.0})
    alone = describing_function(symmetric, [0.2])
    assert describing_function(loaded, [0.2]).stiffness == pytest.approx(alone.stiffness, rel=1e-8)


def test_a_protection_stiffens_large_swings_only(symmetric):
    protected = symmetric.with_effect("overstretch_protection", {"stiffness": 1e6})
    amplitudes = [0.2, 0.45]
    plain, stiff = (
        describing_function(model, amplitudes).stiffness for model in (symmetric, protected)
    )
    assert stiff[0] == pytest.approx(plain[0], rel=1e-7)
    assert stiff[1] > 1.5 * plain[1]


@pytest.mark.slow
@pytest.mark.parametrize("effect", CATALOGUE, ids=lambda effect: effect.id)
def test_every_effect_has_a_describing_function(symmetric, effect):
    numbers = {
        parameter.name: typical_value(symmetric, parameter) for parameter in effect.parameters
    }
    found = describing_function(symmetric.with_effect(effect.id, numbers), [0.05, 0.3])
    assert np.isfinite(found.stiffness).all()
    assert (found.loss >= -1e-6).all()


# ---- wrong arguments -----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"amplitudes": [0.0, 0.1]}, "amplitudes must be finite, positive and increase"),
        ({"amplitudes": [0.2, 0.1]}, "amplitudes must be finite, positive and increase"),
        ({"amplitudes": [np.nan]}, "amplitudes must be finite, positive and increase"),
        ({"amplitudes": []}, "one row with one number at least"),
        ({"amplitudes": 0.1}, "one row with one number at least"),
        ({"deflection": np.inf}, "deflection is inf"),
        ({"load_torque": np.nan}, "load_torque is nan"),
        ({"frequency": 0.0}, "frequency is 0.0, but a positive number"),
        ({"deflection": 0.1, "load_torque": 1.0}, "give one"),
        ({"frequency": 1e-4}, "choose a higher frequency"),
    ],
)
def test_wrong_arguments_are_refused_in_a_sentence(symmetric, arguments, sentence):
    with pytest.raises(LinearisationError, match=sentence):
        describing_function(symmetric, **({"amplitudes": [0.1]} | arguments))


def test_a_drift_that_outlasts_all_cycles_is_refused(symmetric):
    slow = symmetric.with_effect("spring_relaxation", {"stiffness": 5e3, "time_constant": 1e3})
    with pytest.raises(LinearisationError, match="still drifts after 120 cycles"):
        describing_function(slow, [0.3], deflection=0.1)


def test_default_amplitudes_stand_on_boundaries_and_limits(asymmetric):
    amplitudes = default_amplitudes(asymmetric, 0.01)
    for boundary in slack_boundaries(asymmetric.transmission):
        assert np.abs(amplitudes - abs(boundary - 0.01)).min() < 1e-6
    assert (np.diff(amplitudes) > 0).all()
