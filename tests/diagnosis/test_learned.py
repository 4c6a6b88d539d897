"""What remains, on recordings of the independent simulator: found where there is something, learned
as an effect, and exported; seeds below 1000.
"""

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from elastic_tendon import effects, export_fmu
from elastic_tendon.actuator.parameters import Model, load_model
from elastic_tendon.comparison.initial_state import estimate_initial_state
from elastic_tendon.comparison.residuals import residuals_of, rms, simulate_measurement
from elastic_tendon.diagnosis.lack_of_fit import LackOfFit, regress
from elastic_tendon.diagnosis.learned import learn, learned_effect
from elastic_tendon.diagnosis.result import LearnedTerm
from elastic_tendon.effects.base import Joint, Slot
from elastic_tendon.errors import EffectError
from elastic_tendon.estimation.fit import FitResult, fit
from elastic_tendon.measurement import Measurement
from elastic_tendon.simulation.simulate import simulate as replay
from truth.actuator import Actuator, Link, Spring
from truth.experiments import Limits, steps_with_load_pulses
from truth.noise import Sensor, coloured_noise, measured
from truth.sampling import sample
from truth.solver import Trajectory, simulate

GIVEN = load_model("biorob_x4_joint_3")
NOISE = 2e-4  # rad
DURATION, RATE = 10.0, 500  # s, Hz
Torque = Callable[[float, float, float], float]


def detent(_time: float, position: float, _velocity: float) -> float:
    """A torque of no effect in the catalogue: one dent at 0.08 rad, N·m."""
    return 0.04 * math.exp(-(((position - 0.08) / 0.12) ** 2))


def run(seed: int, extra: Torque | None = None) -> Trajectory:
    """Steps with load pulses on a machine a little off the given model."""
    link = Link(1.08 * 0.03, 0.9 * 0.16, **({"extra_torque": extra} if extra else {}))
    machine = Actuator(
        *(0.03, 0.03, 0.94 * 80.0),
        upper=Spring(1.03 * 2 * 11580.0, 0.015),
        lower=Spring(0.98 * 2 * 11580.0, 0.015),
        link=link,
    )
    experiment = steps_with_load_pulses(seed, Limits(0.3, 4.0, 5.0), DURATION)
    return simulate(machine, experiment, np.arange(round(DURATION * RATE)) / RATE)


def recording(of: Trajectory, seed: int) -> Measurement:
    """With white noise of the joint's encoder."""
    table = sample(of, {"joint_position": Sensor(white=NOISE)}, seed)
    return Measurement(
        name=f"seed {seed}",
        time=table["time_s"],
        motor_position=table["motor_position_rad"],
        signals={"joint_position": table["joint_position_rad"]},
        load_torque=table["load_torque_Nm"],
    )


@pytest.fixture(scope="module")
def plain() -> Trajectory:
    """A machine from which nothing is missing."""
    return run(801)


@pytest.fixture(scope="module")
def dented() -> tuple[FitResult, Measurement]:
    """Fit of the machine with a dent, and a second recording."""
    fitted = fit(GIVEN, [recording(run(803, detent), 803)])
    return fitted, recording(run(805, detent), 805)


@pytest.fixture(scope="module")
def term(dented: tuple[FitResult, Measurement]) -> LearnedTerm:
    """What is learned of the dent."""
    learned = learn(regress(dented[0]))
    assert learned is not None
    return learned


def heldout(model: Model, measurement: Measurement) -> float:
    """Error on a recording of which only the first state is estimated, rad."""
    initial = estimate_initial_state(model, measurement)
    trajectory = simulate_measurement(model, measurement, initial)
    return rms(residuals_of(trajectory, measurement)["joint_position"])


# ---- nothing is missing ------------------------------------------------------------------------


def test_nothing_is_learned_where_nothing_is_missing(plain: Trajectory) -> None:
    fitted = fit(GIVEN, [recording(plain, 801)])
    assert learn(regress(fitted)) is None


@pytest.mark.parametrize("kind", ["coloured", "quantised", "motor encoder"])
def test_no_noise_is_taken_for_lack_of_fit(plain: Trajectory, kind: str) -> None:
    own, rng = recording(plain, 801), np.random.default_rng(811)
    joint, motor = plain["joint_position"], own.motor_position
    if kind == "coloured":
        joint = measured(joint, Sensor(coloured=NOISE, correlation=0.9), rng)
    elif kind == "quantised":
        joint = measured(joint, Sensor(step=2 * math.pi / 2**14), rng)
    else:
        joint, motor = own.signals["joint_position"], motor + 3 * NOISE * rng.standard_normal(5000)
    told = replace(own, motor_position=motor, signals={"joint_position": joint})
    assert_adequate(regress(fit(GIVEN, [told])).found)


@pytest.mark.parametrize("memory", [0.02, 0.2])
def test_a_torque_that_acts_at_random_is_no_lack_of_fit(plain: Trajectory, memory: float) -> None:
    # twice the noise and more, from a torque that nobody recorded; its kinks at every sample would
    # hold up the independent simulator, so the product's own takes its place
    rng, own = np.random.default_rng(812), recording(plain, 801)
    torque = coloured_noise(rng, len(own.time), 0.02, math.exp(-1.0 / (RATE * memory)))
    load = own.inputs["load_torque"] + torque
    values = {"link.inertia": 1.08 * 0.03, "transmission.pretension_force": 75.0}
    shaken = replay(GIVEN.with_values(values), own.time, own.motor_position, load)
    joint = measured(shaken["joint_position"], Sensor(white=NOISE), rng)
    disturbed = replace(own, signals={"joint_position": joint})
    fitted = fit(GIVEN, [disturbed])
    left = fitted.problem.errors(fitted.vector)[0]["joint_position"]
    assert rms(left) > 2.0 * NOISE
    assert_adequate(regress(fitted).found)


def assert_adequate(found: dict[str, LackOfFit]) -> None:
    assert not found["joint_position"].significant
    assert found["joint_position"].p_value > 0.01


# ---- a dent is missing -------------------------------------------------------------------------


def test_a_dent_is_found_where_it_is(dented: tuple[FitResult, Measurement]) -> None:
    reports: list[float] = []
    found = regress(dented[0], lambda _text, share: reports.append(share)).found["joint_position"]
    assert found.significant
    assert found.variables == ("joint_position",)
    left = dented[0].problem.errors(dented[0].vector)[0]["joint_position"]
    assert found.explains == pytest.approx(1.0 - (NOISE / rms(left)) ** 2, abs=0.1)
    assert reports == sorted(reports)
    assert 0.0 <= reports[0] < reports[-1] < 1.0


def test_coefficients_keep_within_the_bounds_of_their_file(term: LearnedTerm) -> None:
    for parameter in learned_effect(term).parameters:
        assert parameter.lower <= term.values[parameter.name] <= parameter.upper


def test_what_is_learned_comes_near_the_floor_on_another_recording(
    dented: tuple[FitResult, Measurement], term: LearnedTerm
) -> None:
    fitted, other = dented
    effect = learned_effect(term)
    assert effect.id == term.id
    assert effect.slot is Slot.JOINT_TORQUE
    assert effect.title.startswith("Learned: ")
    assert "seed 803" in effect.reference
    refitted = fit(fitted.model.with_effect(term.id, term.values), fitted.problem.measurements)
    before, after = heldout(fitted.model, other), heldout(refitted.model, other)
    assert before > 2.0 * NOISE
    assert after - NOISE < 0.3 * (before - NOISE)
    # less a constant, which is as good as an asymmetry of the springs, it is the dent itself
    place = np.linspace(-0.1, 0.25, 50)
    p = type("Numbers", (), refitted.model.effects[term.id])
    curve = effect.equations(Joint(place, np.zeros(50)), p, None, None).value
    true = np.array([detent(0.0, one, 0.0) for one in place])
    assert np.corrcoef(curve, true)[0, 1] > 0.9


def test_a_learned_effect_is_exported(
    dented: tuple[FitResult, Measurement], term: LearnedTerm, tmp_path: Path
) -> None:
    from fmpy import simulate_fmu

    learned_effect(term)
    model = dented[0].model.with_effect(term.id, term.values)
    one = dented[1]
    kept = slice(0, 1000)
    columns = {
        "time": one.time[kept],
        "motor_position": one.motor_position[kept],
        "load_torque": one.inputs["load_torque"][kept],
    }
    inputs = np.zeros(1000, dtype=[(name, float) for name in columns])
    for name, values in columns.items():
        inputs[name] = values
    fmu = export_fmu(model, tmp_path / "learned.fmu")
    driven = simulate_fmu(
        str(fmu),
        stop_time=float(inputs["time"][-1]),
        output_interval=1 / RATE,
        input=inputs,
        output=["joint_position"],
    )["joint_position"]
    own = replay(model, *columns.values(), interpolation="hold")["joint_position"]
    np.testing.assert_allclose(driven, own[: len(driven)], rtol=0, atol=1e-6)


def test_a_learned_term_is_loaded_once(term: LearnedTerm) -> None:
    assert learned_effect(term) is learned_effect(term)
    with pytest.raises(EffectError, match="already"):
        learned_effect(replace(term, source=term.source + "\n# changed\n"))
    assert effects.BY_ID.content(effects.BY_ID[term.id]) == term.source.encode()
