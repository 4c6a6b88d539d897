"""An effect's signature shows it, and shows what its texts say."""

import numpy as np
import pytest

from elastic_tendon.actuator.parameters import load_model, typical_value
from elastic_tendon.effects import BY_ID, CATALOGUE
from elastic_tendon.simulation.signature import FACTORS, HIDDEN, VISIBLE, Beside, Curve, signature

SAMPLED = 0.01  # relative, of what is read from curves of some thousand points


@pytest.fixture(scope="module")
def example():
    return load_model("biorob_x4_joint_3")


@pytest.fixture(scope="module")
def of(example):
    """Signature of an effect, computed once."""
    known = {}

    def of(effect_id):
        if effect_id not in known:
            known[effect_id] = signature(BY_ID[effect_id], example)
        return known[effect_id]

    return of


def at(curve: Curve, x: float, rising: bool) -> float:
    """y of the branch of a loop on which x rises or falls."""
    step = np.gradient(curve.x)
    branch = step > 0 if rising else step < 0
    return float(curve.y[branch][np.argmin(np.abs(curve.x[branch] - x))])


def height(loop: Beside, x: float) -> float:
    return abs(at(loop.with_it, x, True) - at(loop.with_it, x, False))


def test_difference_is_a_share_of_the_axes():
    x = np.linspace(0.0, 10.0, 101)
    line, raised = Curve(x, 1e3 * x), Curve(x, 1e3 * x + 500.0)
    assert Beside(line, line).difference == 0.0
    for beside in (Beside(line, raised), Beside(raised, line)):
        # its upper end is farthest from the other line: 500 on an axis of 10500
        assert beside.difference == pytest.approx(500.0 / 10500.0)


@pytest.mark.parametrize("effect", CATALOGUE, ids=lambda effect: effect.id)
def test_every_effect_shows(effect, of):
    found = of(effect.id)
    assert found.difference >= VISIBLE
    assert found.times_typical in FACTORS
    for curve in (found.slow_loop.with_it, found.fast_loop.with_it, found.step.with_it):
        assert np.isfinite(curve.x).all()
        assert np.isfinite(curve.y).all()


def test_typical_values_are_taken_where_they_show(of):
    assert of("coulomb_friction").times_typical == 1.0
    assert of("gear_backlash").times_typical > 1.0


def test_strength_grows_and_direction_stays(of, example):
    found = of("pulley_eccentricity")
    typical = {
        parameter.name: typical_value(example, parameter) for parameter in found.effect.parameters
    }
    assert found.times_typical > 1.0
    assert found.numbers["amplitude"] == pytest.approx(found.times_typical * typical["amplitude"])
    assert found.numbers["phase"] == typical["phase"]


@pytest.mark.parametrize(
    "effect_id",
    ["quadratic_drag", "spring_relaxation", "spring_mass", "joint_stop", "measurement_delay"],
)
def test_slow_motion_hides_what_its_text_says(effect_id, of):
    assert of(effect_id).slow_loop.difference < HIDDEN


def test_load_goes_through_all_slack_states(of):
    found = of("measurement_delay")
    deflection = found.slow_loop.without.x
    assert deflection.min() < 2.0 * found.slack_boundaries[0]
    assert deflection.max() > 2.0 * found.slack_boundaries[1]
    assert found.fast_loop.without.x.min() < found.slack_boundaries[0]


def test_coulomb_loop_is_twice_the_torque_in_every_state(of):
    found = of("coulomb_friction")
    for deflection in (-0.25, 0.0, 0.25):
        twice = 2.0 * found.numbers["torque"]
        assert height(found.slow_loop, deflection) == pytest.approx(twice, rel=0.05)


def test_guide_friction_opens_where_hysteresis_closes(of):
    guide, hysteresis = of("tendon_guide_friction").slow_loop, of("spring_hysteresis").slow_loop
    assert height(guide, 0.25) > 1.3 * height(guide, 0.0)
    assert height(hysteresis, 0.25) < 0.7 * height(hysteresis, 0.0)


def test_offset_shifts_all_that_is_measured(of):
    found = of("joint_encoder_offset")
    offset = found.numbers["offset"]
    for beside in (found.slow_loop, found.fast_loop):
        assert beside.with_it.x - beside.without.x == pytest.approx(offset, rel=SAMPLED)
    assert found.step.with_it.y - found.step.without.y == pytest.approx(offset, rel=SAMPLED)


def test_motor_offset_shifts_the_joint_the_other_way(of):
    found = of("motor_encoder_offset")
    before = found.step.with_it.x < 0.0
    assert before.any()
    assert found.step.with_it.y[before] == pytest.approx(-found.numbers["offset"], rel=SAMPLED)


def test_delay_opens_a_loop_in_fast_motion(of):
    found = of("measurement_delay").fast_loop

    def area(curve):
        return abs(np.trapezoid(curve.y, curve.x))

    assert area(found.with_it) > 20.0 * area(found.without)
