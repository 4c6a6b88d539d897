"""The next experiment: within the limits, run by an independent simulator, it decides."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from elastic_tendon.actuator.parameters import Model, load_model
from elastic_tendon.comparison.simulated import measured_table
from elastic_tendon.diagnosis.experiment import experiment_csv, next_experiment
from elastic_tendon.diagnosis.limits import BEYOND_RECORDED, limits_of
from elastic_tendon.diagnosis.proposals import FORMS, Input, neighbour, random_proposal
from elastic_tendon.diagnosis.result import Experiment
from elastic_tendon.diagnosis.separation import Rival, known, left_over, power, predict, refit
from elastic_tendon.estimation.coordinates import free_parameters
from elastic_tendon.estimation.fit import FitResult, fit
from elastic_tendon.measurement import Measurement, ReadOptions, read_measurement
from elastic_tendon.simulation.simulate import simulate
from truth.catalogue import actuator_of, signal_maps_of
from truth.experiments import Limits, multisine
from truth.noise import Sensor
from truth.recording import record
from truth.sampling import sample
from truth.signals import Experiment as Motion
from truth.signals import constant, piecewise_linear

RATE = 500  # Hz
NOISE = 1e-3  # rad
RECORDED = (1.3, 2.7), (4.2, 5.6)  # s: what is left of a motion at two constant speeds
DECISIVE = 20.0  # difference of BIC, of an effect and one in its place
BELIEVED = load_model("biorob_x4_joint_3")
ZERO = "joint_encoder_offset"


# ---- recordings and fits -------------------------------------------------------------------


def record_truth(machine: Model, motion: Motion, seed: int, *, load: bool = True) -> Measurement:
    """What the independent simulator records of a machine, joint position with white noise."""
    tree = machine.model_dump()
    time = np.arange(round(motion.duration * RATE) + 1) / RATE
    run = record(actuator_of(tree), motion, time, signal_maps_of(tree))
    table = sample(run, {"joint_position": Sensor(white=NOISE)}, seed)
    return Measurement(
        name=f"seed {seed}",
        time=table["time_s"],
        motor_position=table["motor_position_rad"],
        signals={"joint_position": table["joint_position_rad"]},
        load_torque=table["load_torque_Nm"] if load else None,
    )


def run(machine: Model, experiment: Experiment, seed: int) -> Measurement:
    """The proposed experiment, run on the machine."""
    time = experiment.time.tolist()
    motion = Motion(
        *(time[-1], piecewise_linear(time, experiment.motor_position.tolist())),
        piecewise_linear(time, experiment.load_torque.tolist()),
    )
    return record_truth(machine, motion, seed)


def rivals_for(
    given: dict[str, tuple[Model, tuple[str, ...]]], data: list[Measurement]
) -> tuple[Rival, ...]:
    """A rival for each id: its model, and the numbers that it leaves free."""
    return tuple(Rival(name, fit(model, data, free=free)) for name, (model, free) in given.items())


def bic(result: FitResult) -> float:
    """BIC under the noise that the test put there."""
    errors = [values for one in result.problem.errors(result.vector) for values in one.values()]
    squares = sum(float(np.sum((values / NOISE) ** 2)) for values in errors)
    return squares + result.findings.effective * float(np.log(sum(map(len, errors))))


def lead_of_first(rivals: tuple[Rival, ...]) -> float:
    """By how much the first of two rivals has the lower BIC."""
    return bic(rivals[1].fit) - bic(rivals[0].fit)


# ---- two pairs -----------------------------------------------------------------------------


@cache
def damping_case() -> tuple[Model, list[Measurement], dict[str, tuple[Model, tuple[str, ...]]]]:
    """Damped springs, or a damped joint: the same while the motor is held and both are taut."""
    damping = {f"transmission.{side}_spring.damping": 20.0 for side in ("upper", "lower")}
    machine = BELIEVED.with_values(damping)
    motion = replace(multisine(7, Limits(0.3, 1.0, 1.0), 6.0), motor_position=constant(0.0))
    free = free_parameters(BELIEVED)
    rivals = {
        "springs' damping": (BELIEVED, tuple(one for one in free if one != "link.damping")),
        "link.damping": (BELIEVED, tuple(one for one in free if one not in damping)),
    }
    return machine, [record_truth(machine, motion, 7)], rivals


@cache
def backlash_case() -> tuple[Model, list[Measurement], dict[str, tuple[Model, tuple[str, ...]]]]:
    """Backlash, or a delay: the same while the motor moves at one speed forth and back."""
    machine = BELIEVED.with_effect("gear_backlash", {"gap": 0.004})
    forth_and_back = piecewise_linear([0.0, 0.3, 2.8, 3.2, 5.7, 6.0], [0, 0, 1.2, 1.2, 0, 0])
    whole = record_truth(machine, Motion(6.0, forth_and_back), 8, load=False)
    rivals = {}
    for effect_id, start in (("gear_backlash", 0.003), ("measurement_delay", 0.004)):
        name = {"gear_backlash": "gap", "measurement_delay": "delay"}[effect_id]
        model = BELIEVED.with_effect(effect_id, {name: start})
        rivals[effect_id] = (model, free_parameters(model))
    return machine, [whole.window(*one) for one in RECORDED], rivals


CASES = {"damping": damping_case, "backlash": backlash_case}


@cache
def proposed(case: str) -> tuple[tuple[Rival, ...], Experiment]:
    """The rivals on the data at hand, and what is proposed."""
    _, data, given = CASES[case]()
    rivals = rivals_for(given, data)
    experiment = next_experiment(rivals, data)
    assert isinstance(experiment, Experiment)
    return rivals, experiment


@pytest.mark.parametrize("case", CASES)
def test_data_do_not_decide_and_the_proposed_experiment_does(case: str) -> None:
    machine, data, given = CASES[case]()
    rivals, experiment = proposed(case)
    assert abs(lead_of_first(rivals)) < DECISIVE
    assert experiment.power > 0.95
    new = run(machine, experiment, seed=108)
    assert lead_of_first(rivals_for(given, [*data, new])) > DECISIVE


def test_parameters_that_no_recording_shows_are_no_difference() -> None:
    """A constant torque, or the zero of an encoder: the same until both springs have been slack. A
    pretension that nothing shows makes up for what one of them tells; so does the scale of all
    torques, where no load is known."""
    machine = BELIEVED.with_effect("constant_torque", {"torque": 0.2})
    step = piecewise_linear([0.0, 0.5, 0.6, 6.0], [0.0, 0.0, 0.1, 0.1])
    data = [record_truth(machine, Motion(6.0, step), 9, load=False)]
    models = [BELIEVED.with_effect(name, None) for name in ("constant_torque", ZERO)]
    given = {model.effect_ids[0]: (model, free_parameters(model)) for model in models}
    rivals = rivals_for(given, data)
    experiment = next_experiment(rivals, data)
    assert abs(lead_of_first(rivals)) < DECISIVE
    assert isinstance(experiment, Experiment)
    assert experiment.power > 0.95
    new = run(machine, experiment, seed=109)
    assert lead_of_first(rivals_for(given, [*data, new])) > DECISIVE


@pytest.mark.parametrize("case", CASES)
def test_springs_bear_it_on_the_machine(case: str) -> None:
    machine, _, _ = CASES[case]()
    _, experiment = proposed(case)
    table = measured_table(
        machine, _as_measurement(experiment.time, experiment.motor_position, experiment.load_torque)
    )
    low, high = actuator_of(machine.model_dump()).deflection_limits()
    assert low < table["deflection_rad"].min() < table["deflection_rad"].max() < high


def test_without_a_recorded_load_only_the_motor_moves() -> None:
    _, data, _ = backlash_case()
    _, experiment = proposed("backlash")
    assert not experiment.load_torque.any()
    positions = np.concatenate([one.motor_position for one in data])
    allowed = BEYOND_RECORDED * np.ptp(positions)
    assert 0.0 < np.ptp(experiment.motor_position) < allowed


def test_text_says_what_is_done_and_who_is_told_apart() -> None:
    _, experiment = proposed("backlash")
    assert "Gear backlash and Measurement delay, either refitted" in experiment.text
    assert "500 samples per second" in experiment.text
    assert "Load:" not in experiment.text
    _, held = proposed("damping")
    assert "Load:" in held.text
    assert "The motor was held in the recordings" in held.text


def test_its_file_is_a_recording_that_can_be_read_and_simulated(tmp_path) -> None:
    _, experiment = proposed("damping")
    path = tmp_path / "experiment.csv"
    path.write_text(experiment_csv(experiment))
    assert path.read_text().splitlines()[0] == "time_s,motor_position_rad,load_torque_Nm"
    read = read_measurement(str(path), ReadOptions(joint_required=False))
    np.testing.assert_allclose(read.motor_position, experiment.motor_position, atol=1e-12)
    np.testing.assert_allclose(np.diff(read.time), 1.0 / RATE, atol=1e-9)


@pytest.mark.parametrize("case", CASES)
def test_predictions_are_those_of_the_fitted_models_from_rest(case: str) -> None:
    rivals, experiment = proposed(case)
    assert list(experiment.predictions) == [rival.id for rival in rivals]
    for rival in rivals:
        predicted = experiment.predictions[rival.id]
        motion = simulate(
            rival.fit.model,
            *(experiment.time, experiment.motor_position),
            load_torque=experiment.load_torque,
            initial_state={"joint_position": float(experiment.motor_position[0])},
            as_measured=True,
        )
        assert experiment.signal == "joint_position"
        shown = motion[motion.measured("joint_position")]
        np.testing.assert_allclose(predicted, shown, atol=1e-3 * np.ptp(shown))
    first, second = experiment.predictions.values()
    assert np.abs(first - second).max() > NOISE


def test_the_same_call_gives_the_same_answer() -> None:
    rivals, experiment = proposed("backlash")
    again = next_experiment(rivals, backlash_case()[1])
    assert isinstance(again, Experiment)
    np.testing.assert_array_equal(again.motor_position, experiment.motor_position)
    assert again.text == experiment.text


# ---- what no experiment decides ------------------------------------------------------------


@cache
def offsets() -> tuple[tuple[Rival, ...], list[Measurement]]:
    machine = BELIEVED.with_effect("joint_encoder_offset", {"offset": 0.02})
    data = [record_truth(machine, multisine(9, Limits(0.3, 2.0, 3.0), 4.0), 9)]
    models = [
        BELIEVED.with_effect(effect_id, {"offset": 0.02 * sign})
        for effect_id, sign in (("joint_encoder_offset", 1.0), ("motor_encoder_offset", -1.0))
    ]
    given = {model.effect_ids[0]: (model, free_parameters(model)) for model in models}
    return rivals_for(given, data), data


def test_aliases_are_called_undecidable_with_the_reason() -> None:
    rivals, data = offsets()
    answer = next_experiment(rivals, data)
    assert isinstance(answer, str)
    assert "Joint encoder offset and Motor encoder offset apart" in answer
    assert "the same wherever nothing depends on the angle itself" in answer


def test_one_experiment_is_for_all_answers_and_says_which_it_leaves_open() -> None:
    """Gravity is told from both offsets at once, which nothing tells from each other."""
    rivals, data = offsets()
    model = BELIEVED.with_effect("gravity_load", {"torque": 0.3, "angle": 0.5})
    third = rivals_for({"gravity_load": (model, free_parameters(model))}, data)
    answer = next_experiment((*rivals, *third), data)
    assert isinstance(answer, Experiment)
    assert answer.power > 0.95
    assert "Gravity load, either refitted to the other" in answer.text
    assert "Other pairs of answers are told apart more surely." in answer.text
    assert "It does not tell Joint encoder offset from Motor encoder offset." in answer.text


def test_where_nothing_near_decides_it_goes_farther() -> None:
    """Eccentricity and gravity are alike where the motor hardly moves and nothing loads it."""
    machine = BELIEVED.with_effect("pulley_eccentricity", {"amplitude": 0.02, "phase": 0.7})
    slow = multisine(11, Limits(0.2, 0.2, 0.0), 6.0)
    data = [record_truth(machine, slow, 11, load=False)]
    models = [
        BELIEVED.with_effect("pulley_eccentricity", {"amplitude": 0.02, "phase": 0.7}),
        BELIEVED.with_effect("gravity_load", {"torque": 0.5, "angle": 0.7}),
    ]
    given = {model.effect_ids[0]: (model, free_parameters(model)) for model in models}
    answer = next_experiment(rivals_for(given, data), data)
    assert not isinstance(answer, str)
    assert answer.power >= 0.8
    assert np.ptp(answer.motor_position) > 1.5 * np.ptp(data[0].motor_position)
    assert "go beyond what was recorded" in answer.text


def test_progress_rises_and_the_search_can_be_interrupted() -> None:
    rivals, data = offsets()
    shares: list[float] = []

    def report(_text: str, share: float) -> None:
        shares.append(share)
        if len(shares) == 20:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        next_experiment(rivals, data, report)
    assert shares == sorted(shares)
    assert 0.0 <= shares[0] < shares[-1] < 1.0


# ---- parts ---------------------------------------------------------------------------------


def _as_measurement(time, motor_position, load_torque) -> Measurement:
    return Measurement(time, motor_position, {}, load_torque, name="proposal")


def swings() -> Measurement:
    """Motor and joint swing together; the load only ever pulls one way."""
    time = np.linspace(0.0, 8.0, 4001)
    position, load = 0.2 * np.sin(time), np.clip(np.sin(time), 0.0, None)
    return Measurement(time, position, {"joint_position": position}, load, name="slow")


def test_proposals_stay_within_reach_and_begin_and_end_at_rest() -> None:
    limits = limits_of([BELIEVED], [swings()])
    assert limits.joint_side is not None
    rng = np.random.default_rng(1)
    time = limits.sample_times()
    seen = set()
    for _ in range(150):
        proposal = neighbour(random_proposal(rng, limits), rng, 0.2)
        seen.add(proposal.motion.form)
        for values, reach in zip(
            proposal.courses(time, limits), (limits.motion, limits.joint_side), strict=True
        ):
            assert reach.low - 1e-12 <= values.min() <= values.max() <= reach.high + 1e-12
            assert np.max(np.abs(np.diff(values))) <= reach.rate * limits.step * (1.0 + 1e-9)
            assert values[:50] == pytest.approx(reach.start)
            assert values[-50:] == pytest.approx(reach.start)
    assert seen == set(FORMS)


@pytest.mark.parametrize("form", FORMS)
def test_forms_fill_their_reach_with_finite_acceleration(form: str) -> None:
    limits = replace(limits_of([BELIEVED], [swings()]), frequency=1.0)
    reach = replace(limits.motion, start=0.0, low=-1.0, high=1.0, rate=1e3)
    coarse, fine = (
        Input(form, (1.0, 0.5, 0.3, 0.8)).values(
            np.linspace(0.0, limits.duration, count), reach, limits
        )
        for count in (6001, 24001)
    )
    if form != "hold":
        assert np.max(np.abs(coarse)) > 0.7
    # a step of the velocity would make the second difference fall only with the step
    kink = [np.max(np.abs(np.diff(one, 2))) for one in (coarse, fine)]
    assert kink[1] < 0.1 * kink[0] + 1e-12


def test_limits_are_those_of_recordings_and_springs() -> None:
    slow = swings()
    limits = limits_of([BELIEVED], [slow])
    assert limits.motion.high - limits.motion.low == pytest.approx(0.4 * BEYOND_RECORDED, rel=1e-3)
    assert limits.motion.rate == pytest.approx(0.2 * BEYOND_RECORDED, rel=1e-2)
    assert limits.joint_side is not None
    assert limits.joint_side.low == 0.0
    assert limits.joint_side.high == pytest.approx(BEYOND_RECORDED, rel=1e-3)
    assert limits.step == pytest.approx(0.002)
    low, high = actuator_of(BELIEVED.model_dump()).deflection_limits()
    assert low < limits.springs.deflection[0] < 0.0 < limits.springs.deflection[1] < high
    unloaded = limits_of([BELIEVED], [replace(slow, load_torque=None)])
    assert unloaded.joint_side is None


def test_a_static_curve_has_limits_too() -> None:
    load = np.linspace(-3.0, 3.0, 50)
    curve = Measurement(
        *(1000.0 * np.arange(50.0), np.zeros(50), {"joint_position": 0.02 * load}),
        load_torque=load,
        static=True,
        name="curve",
    )
    limits = limits_of([BELIEVED], [curve])
    assert limits.motor_was_held
    assert limits.motion.low < 0.0 < limits.motion.high
    moved = BELIEVED.transmission.motor_share * (limits.motion.high - limits.motion.low)
    assert moved == pytest.approx(np.ptp(limits.springs.deflection))
    assert limits.joint_side is not None
    assert limits.joint_side.high == pytest.approx(3.0 * BEYOND_RECORDED)
    assert limits.joint_side.rate > 1.0
    assert limits.duration * limits.step < 1.0


def test_linear_and_full_refit_agree_where_the_difference_is_small() -> None:
    rivals, experiment = proposed("damping")
    time = experiment.time[: 6 * RATE + 1]
    inputs = (experiment.motor_position[: len(time)], experiment.load_torque[: len(time)])
    measurement = Measurement(time, inputs[0], {"joint_position": 0.0 * time}, inputs[1], name="x")
    sigmas = {"joint_position": NOISE}
    right, wrong = (known(one, float(inputs[0][0])) for one in rivals)
    predictions = [predict(one, measurement, sigmas) for one in (right, wrong)]
    linear = left_over(predictions[0].signals, predictions[1], wrong)
    full = refit(predictions[0], wrong, measurement, sigmas)
    assert linear == pytest.approx(full.noncentrality, rel=0.3)
    assert left_over(predictions[0].signals, predictions[0], right) == pytest.approx(0.0, abs=1e-9)


def test_power_is_that_of_noisy_differences() -> None:
    # a difference of deviance between two shifted predictions, drawn many times
    rng = np.random.default_rng(5)
    for noncentrality in (5.0, 15.0, 40.0):
        drawn = (np.sqrt(noncentrality) + rng.standard_normal(20_000)) ** 2
        assert power(noncentrality) == pytest.approx(np.mean(drawn > DECISIVE), abs=0.02)
