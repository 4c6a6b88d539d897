"""A fit finds the numbers behind a recording, and says which of them it could not find."""

from dataclasses import replace

import numpy as np
import pytest

from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.comparison import residuals
from elastic_tendon.errors import SimulationError
from elastic_tendon.estimation.descent import descend
from elastic_tendon.estimation.determinability import (
    CONFIDENCE,
    Estimate,
    OpenDirections,
    _ratios,
    find_open_directions,
)
from elastic_tendon.estimation.fit import QUICK, fit
from elastic_tendon.estimation.problem import TOLERANCE
from elastic_tendon.measurement import Measurement
from elastic_tendon.simulation.simulate import sensitivities, simulate

# intervals are 95 %; for all of six numbers at once a wider margin is right
MARGIN = 2.0


@pytest.fixture(scope="module")
def result(frictionless):
    known, recording = frictionless
    return fit(known.model, [recording])


def test_fit_recovers_the_truth_within_its_intervals(frictionless, result) -> None:
    known, _ = frictionless
    estimates = {one.path: one for one in result.findings.estimates}
    for path, value in known.truth.items():
        one = estimates[path]
        half = MARGIN * 0.5 * (one.interval[1] - one.interval[0])
        assert abs(one.fitted - value) < half
        assert abs(one.fitted / value - 1.0) < 0.02
        assert one.determined


def test_cost_falls_and_numbers_start_from_the_given(frictionless, result) -> None:
    known, _ = frictionless
    assert result.cost < result.start_cost
    assert result.given == known.model
    assert not result.interrupted


def test_a_start_on_a_bound_does_not_stall_the_fit() -> None:
    """Dampings of 0 lie on their bound; a joint at rest gives the optimiser a first step of 0."""
    truth = load_model("biorob_x4_joint_3").with_effect("coulomb_friction", {"torque": 0.5})
    time = np.arange(0.0, 3.0, 0.002)
    motor = np.where(time < 0.2, 0.0, 0.4 * np.sin(6 * (time - 0.2)))
    load = np.where(time < 0.3, 0.0, 2.0 * np.sin(4 * (time - 0.3)))
    position = simulate(truth, time, motor, load)["joint_position"]
    recording = Measurement(time, motor, {"joint_position": position}, load, name="made")
    found = fit(truth.with_values({"link.inertia": 0.034}), [recording])
    assert found.model.link.inertia == pytest.approx(truth.link.inertia, rel=1e-4)


def test_what_leaves_too_much_is_not_followed_to_the_end(sticking, monkeypatch) -> None:
    known, recording, *_ = sticking
    evaluated = []
    monkeypatch.setattr("elastic_tendon.estimation.fit.GLANCE", 2)

    def noted(*problem):
        evaluated.append(problem[-2])  # how many evaluations a descent may take
        return descend(*problem)

    monkeypatch.setattr("elastic_tendon.estimation.fit.descend", noted)
    fit(known.model, [recording], effort=replace(QUICK, hopeless=1e9))
    followed = evaluated.copy()
    evaluated.clear()
    glance = fit(known.model, [recording], effort=replace(QUICK, hopeless=1.0))
    assert {2, QUICK.evaluations - 2} < set(followed)
    assert 2 in evaluated
    assert QUICK.evaluations - 2 not in evaluated
    assert not glance.interrupted


def test_a_given_model_that_limits_shut_out_is_no_start(frictionless, monkeypatch) -> None:
    """A mass of nothing, moved to the least mass there may be, would swing endlessly fast."""
    known, recording = frictionless
    path, tried = "effects.spring_mass.mass", []
    nothing = known.model.with_effect("spring_mass", None)
    heavy = nothing.with_values({path: 2.0, "effects.spring_mass.damping": 5.0})
    simulated = residuals.simulate_measurement

    def noted(model, *how):
        tried.append(model.values()[path])
        return simulated(model, *how)

    monkeypatch.setattr("elastic_tendon.estimation.problem.simulate_measurement", noted)
    glance = replace(QUICK, scouting=1, evaluations=1, rounds=0)
    fit(nothing, [recording], starts=[heavy], limits={path: (0.5, np.inf)}, effort=glance)
    assert min(tried) > 1.0
    tried.clear()
    fit(nothing, [recording], limits={path: (0.5, np.inf)}, effort=glance)
    assert min(tried) < 1.0


def test_where_the_solver_errs_visibly_beside_the_noise_a_finer_one_fits(result) -> None:
    assert result.problem.tolerance == TOLERANCE
    noise, mass = 1e-6, {"mass": 1.2, "damping": 0.05}  # rings for long
    truth = load_model("biorob_x4_joint_3").with_effect("spring_mass", mass)
    time = np.arange(0.0, 3.0, 0.002)
    motor, load = 0.4 * np.sin(5.0 * time), 5.0 * np.sin(8.0 * time)
    position = simulate(truth, time, motor, load, tolerance=1e-10)["joint_position"]
    position = position + noise * np.random.default_rng(1).standard_normal(len(time))
    recording = Measurement(time, motor, {"joint_position": position}, load, "linear")
    found = fit(truth, [recording], free=["link.damping"])
    assert found.problem.tolerance < TOLERANCE
    (initial,) = found.initial_states
    errors = residuals.residuals_of(
        residuals.simulate_measurement(found.model, recording, initial), recording
    )
    assert residuals.rms(errors["joint_position"]) < 1.03 * noise


def test_right_model_is_weighed_with_its_noise(frictionless, result) -> None:
    _, recording = frictionless
    floor = residuals.noise_floors(recording)["joint_position"]
    assert result.sigmas[0]["joint_position"] == pytest.approx(floor, rel=0.2)


def test_only_named_numbers_move(frictionless) -> None:
    known, recording = frictionless
    fitted = fit(known.model, [recording], free=["link.inertia"]).model
    changed = {
        path for path, value in fitted.values().items() if value != known.model.values()[path]
    }
    assert changed == {"link.inertia"}


def test_a_parameter_at_its_bound_does_not_widen_the_other_intervals(frictionless, result) -> None:
    known, recording = frictionless
    inertia = 0.98 * result.model.link.inertia  # it would go on
    limits = {"link.inertia": (0.5 * inertia, inertia)}
    bounded = fit(known.model, [recording], limits=limits)
    assert bounded.model.link.inertia == pytest.approx(inertia)
    estimates = {part.path: part.sigma for part in bounded.findings.estimates}
    others = [path for path in estimates if path != "link.inertia"]
    held = fit(known.model.with_values({"link.inertia": inertia}), [recording], free=others)
    off_bounds = [part for part in held.findings.estimates if part.fitted > 0.0]  # of dampings
    assert len(off_bounds) == 4
    for part in off_bounds:
        assert estimates[part.path] == pytest.approx(part.sigma, rel=0.01)


def test_recordings_have_initial_states_of_their_own(sticking) -> None:
    known, first, second = sticking
    model = known.model.with_effect("coulomb_friction", {"torque": 0.3})
    result = fit(model, [first, second])
    assert len(result.initial_states) == 2
    measured = [one.signals["joint_position"][0] for one in (first, second)]
    assert [one.position for one in result.initial_states] == pytest.approx(measured, abs=2e-3)
    torque = result.model.values()["effects.coulomb_friction.torque"]
    assert torque == pytest.approx(known.truth["effects.coulomb_friction.torque"], rel=0.02)


def test_without_a_load_only_ratios_are_determined(unloaded) -> None:
    known, recording = unloaded
    model = known.model.with_effect("coulomb_friction", {"torque": 0.3})
    found = fit(model, [recording]).findings
    estimates = {one.path: one for one in found.estimates}
    assert not estimates["link.inertia"].determined
    assert not estimates["transmission.upper_spring.stiffness"].determined
    assert not estimates["effects.coulomb_friction.torque"].determined
    assert found.sentences[0].startswith("Without a known load or torque the data determine only")
    # the motor's motion alone slackens no tendon, so the pretension is silent
    assert "transmission.pretension_force" in found.sentences[-1]
    for path in known.truth.keys() - {"transmission.pretension_force"}:
        assert path in found.sentences[0]
    ratios = {one.name: one for one in found.ratios}
    truth = known.truth
    stiffness = sum(truth[f"transmission.{side}_spring.stiffness"] for side in ("upper", "lower"))
    expected = {
        "K/J": 0.03**2 * 2.0 * stiffness / truth["link.inertia"],
        "link.damping/J": truth["link.damping"] / truth["link.inertia"],
        "effects.coulomb_friction.torque/J": truth["effects.coulomb_friction.torque"]
        / truth["link.inertia"],
    }
    for name, value in expected.items():
        half = MARGIN * (ratios[name].interval[1] - ratios[name].value)
        assert abs(ratios[name].value - value) < half
        assert ratios[name].value == pytest.approx(value, rel=0.05)


def test_with_a_load_nothing_is_open(result) -> None:
    assert not result.findings.sentences
    assert not result.findings.ratios


def test_simulation_that_fails_is_no_end(frictionless, monkeypatch) -> None:
    known, recording = frictionless
    path = "link.inertia"
    given = known.model.values()[path]
    best = fit(known.model, [recording], free=[path]).model.values()[path]
    # no model more than halfway to the best can be simulated
    reach = 0.5 * (best - given)
    failures = []

    def fragile(model, *args, **kwargs):
        if (model.values()[path] - given) / reach > 1.0:
            failures.append(model)
            raise SimulationError("too far")
        return simulate(model, *args, **kwargs)

    monkeypatch.setattr(residuals, "simulate", fragile)
    result = fit(known.model, [recording], free=[path])
    assert failures
    assert 0.5 < (result.model.values()[path] - given) / reach <= 1.0


def test_interrupt_keeps_the_best_so_far(frictionless, monkeypatch) -> None:
    known, recording = frictionless
    calls = []

    def interrupted(model, time, *args, parameters, **kwargs):
        # the estimates of initial states come before, those of the judgement after
        calls.append(parameters)
        if sum(1 for one in calls if one) == 4:
            raise KeyboardInterrupt
        return sensitivities(model, time, *args, parameters=parameters, **kwargs)

    monkeypatch.setattr(residuals, "sensitivities", interrupted)
    result = fit(known.model, [recording])
    assert result.interrupted
    assert result.cost < result.start_cost


def directions(*columns: np.ndarray) -> np.ndarray:
    return np.column_stack(columns)


RNG = np.random.default_rng(5)
ALPHA, BETA = 10.0 * RNG.standard_normal((2, 400))


def test_a_common_scale_is_found() -> None:
    # errors depend on a/b only
    found = find_open_directions(directions(ALPHA, -ALPHA), np.array([5.0, 5.0]), ["a", "b"])
    assert set(found.scaled) == {"a", "b"}
    assert found.traded == ()


def test_a_trade_is_told_from_a_scale() -> None:
    # errors depend on a b only
    found = find_open_directions(directions(ALPHA, ALPHA), np.array([5.0, 5.0]), ["a", "b"])
    assert found.scaled == ()
    assert [set(group) for group in found.traded] == [{"a", "b"}]


def test_scale_and_trade_and_silence_together() -> None:
    # errors depend on (a + b) / c; d does nothing; e is determined
    half = 0.5 * ALPHA
    data = directions(half, half, -ALPHA, 0.0 * ALPHA, BETA)
    found = find_open_directions(data, np.full(5, 4.0), list("abcde"))
    assert set(found.scaled) == {"a", "b", "c"}
    assert [set(group) for group in found.traded] == [{"a", "b"}]
    assert found.silent == ("d",)


def test_determined_numbers_are_not_open() -> None:
    found = find_open_directions(directions(ALPHA, BETA), np.array([5.0, 0.0]), ["a", "b"])
    assert found.all() == set()


@pytest.mark.parametrize("value", [-0.4, 0.4])
def test_the_interval_of_a_signed_ratio_holds_it(value: float) -> None:
    """As any of a number that may be negative; one that may not has no interval below zero."""
    model = load_model("biorob_x4_joint_3")
    model = model.with_effect("gravity_load", {"torque": 0.5, "angle": value})
    paths = ("link.inertia", "link.damping", "effects.gravity_load.angle")
    estimates = tuple(
        Estimate(path, "N.m.s/rad", 0.1, 0.1, 1.0, (0.0, 1.0), False) for path in paths
    )
    scaled = OpenDirections(silent=(), scaled=paths, traded=())
    found = _ratios(model, estimates, np.diag([0.0, 1.0, 0.04**2]), scaled)
    damping, signed = (one for one in found if one.name != "K/J")
    assert signed.value == pytest.approx(value / 0.03)
    half = CONFIDENCE * 0.04 / 0.03
    assert signed.interval == pytest.approx((signed.value - half, signed.value + half))
    assert damping.interval[0] == 0.0 < damping.value < damping.interval[1]
    assert damping.unit == "1/s"
