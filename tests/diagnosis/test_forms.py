"""Every form of a learned curve: its file can be used, and its columns are its equations."""

import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.comparison.residuals import InitialState, simulate_measurement
from elastic_tendon.diagnosis.columns import Term, responses, terms_for
from elastic_tendon.diagnosis.effect_text import effect_text
from elastic_tendon.diagnosis.forms import FORMS, Curve, Form, Grid, grid_over
from elastic_tendon.diagnosis.motion import Motion
from elastic_tendon.diagnosis.splines import bump, rise
from elastic_tendon.effects.registry import Registry
from elastic_tendon.measurement import Measurement
from elastic_tendon.simulation.excitation import default_excitation

MODEL = load_model("biorob_x4_joint_3")
START = InitialState(0.0, 0.0)


@pytest.fixture(scope="module")
def motion() -> Motion:
    """The default excitation, with an error of 1 mrad."""
    excitation = default_excitation(MODEL)
    recording = Measurement(
        name="simulated",
        time=excitation.time,
        motor_position=excitation.motor_position,
        signals={"joint_position": np.zeros(len(excitation.time))},
        load_torque=excitation.load_torque,
    )
    position = simulate_measurement(MODEL, recording, START)["joint_position"]
    measured = {"joint_position": position - 1e-3}
    return Motion(
        MODEL,
        Measurement(*(excitation.time, excitation.motor_position, measured),
                    load_torque=excitation.load_torque, name="simulated"),
        START,
    )  # fmt: skip


def test_bumps_add_up_to_one_and_are_the_slope_of_rise() -> None:
    u = np.linspace(-0.9, 0.9, 181)
    np.testing.assert_allclose(sum(bump(u - i) for i in range(-3, 4)), 1.0, rtol=0, atol=1e-14)
    u, step = np.linspace(-2.5, 2.5, 101), 1e-5
    slope = (rise(u + step) - rise(u - step)) / (2 * step)
    np.testing.assert_allclose(slope, bump(u), rtol=0, atol=1e-9)
    assert rise(0.0) == 0.0
    assert rise(7.0) == -rise(-7.0) == 0.5


def test_a_grid_covers_the_range_and_a_constant_has_none() -> None:
    grid = grid_over(np.linspace(-1.0, 3.0, 1001), 4)
    assert grid is not None
    assert len(grid.centres) == 7
    assert grid.centres[1] == pytest.approx(-0.98)
    assert grid.centres[5] == pytest.approx(2.98)
    assert grid_over(np.full(20, 0.3), 4) is None


@pytest.mark.parametrize("form", FORMS, ids=lambda form: f"{form.slot.name} {form.law}")
def test_the_file_of_each_form_is_an_effect_that_can_be_used(form: Form, tmp_path: Path) -> None:
    curve = Curve(form, tuple(Grid((-0.5, 0.0, 0.5), 0.5) for _ in form.axes))
    effect_id, text = effect_text(curve, curve.bounds(MODEL), 0.05, 'a "run".csv', 0.83)
    path = tmp_path / "own.py"
    path.write_text(text, encoding="utf-8")
    effect = Registry(()).load(path)
    assert effect.id == effect_id
    assert effect.slot is form.slot
    assert tuple(one.name for one in effect.parameters) == curve.names
    assert "Learned" in effect.title
    assert effect.physics.startswith("Learned from measurements: ")
    assert "83%" in effect.reference
    assert max(map(len, text.splitlines())) <= 110
    assert not re.search(r"[{}]", effect.physics + effect.law)


def test_ids_tell_files_apart() -> None:
    curve = Curve(FORMS[0], (Grid((0.0, 1.0), 1.0),))
    texts = [effect_text(curve, (-1.0, 1.0), 0.5, data, 0.5) for data in ("a", "b", "a")]
    assert texts[0][0] != texts[1][0]
    assert texts[0] == texts[2]


def term_in(motion: Motion, law: str) -> Term:
    (found,) = [one for one in terms_for([motion]) if one.curve and one.curve.form.law == law]
    return found


def test_friction_opposes_the_motion(motion: Motion) -> None:
    term = term_in(motion, "-f(q) sgn(v); at rest what balances the other torques, up to ±f(q)")
    columns = term.columns(motion)
    assert term.acts == "load"
    assert np.all(columns * motion.velocity[:, np.newaxis] <= 0.0)
    moving = motion.velocity != 0.0
    # bumps add up to one within the range that they cover
    whole = columns[moving].sum(axis=1)
    assert np.mean(np.abs(whole + np.sign(motion.velocity[moving])) < 1e-5) > 0.98


def test_spring_columns_of_a_constant_slope_are_a_stiffness(motion: Motion) -> None:
    # within the range where the bumps add up to one, the force is the elongation itself
    columns = term_in(motion, "added force of one spring f(e), f(0) = 0").columns(motion)
    upper, lower = motion.elongations
    t = MODEL.transmission
    expected = t.joint_pulley_radius * (
        t.upper_spring.parallel * upper - t.lower_spring.parallel * lower
    )
    off = np.abs(columns.sum(axis=1) - expected)
    assert np.mean(off < 0.01 * np.max(np.abs(expected))) > 0.95


def test_responses_are_those_of_the_parameters(motion: Motion) -> None:
    # a torque -v acts as damping does
    response = responses(motion, "load", -motion.velocity[:, np.newaxis])["joint_position"][:, 0]
    step = 1e-4
    values = {"link.damping": MODEL.link.damping + step}
    moved = simulate_measurement(MODEL.with_values(values), motion.measurement, START)
    expected = (moved["joint_position"] - motion.position) / step
    np.testing.assert_allclose(
        response, expected, rtol=0, atol=0.05 * float(np.max(np.abs(expected)))
    )


def test_readings_are_not_simulated(motion: Motion) -> None:
    broken = SimpleNamespace(model=motion.model, errors=motion.errors, measurement=None)
    columns = np.arange(float(len(motion.time)))[:, np.newaxis]
    response = responses(broken, "reading", columns)["joint_position"]  # type: ignore[arg-type]
    np.testing.assert_array_equal(response, columns)
