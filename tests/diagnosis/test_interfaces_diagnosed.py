"""Comparing, fitting and diagnosing where a motor torque or a joint is given.

Recordings are of `truth.torque_driven`, those of effects on a given joint of `truth.recording`,
which share no code with the product.
"""

from dataclasses import replace

import numpy as np
import pytest

import elastic_tendon as et
from elastic_tendon.actuator.parameters import parse_model
from elastic_tendon.diagnosis.data import FEWER, MOST, data_of
from elastic_tendon.diagnosis.windows import horizon_for, input_notes
from elastic_tendon.estimation.coordinates import free_parameters
from elastic_tendon.estimation.problem import problem_of
from elastic_tendon.estimation.segments import nearly_integrates
from elastic_tendon.reports.diagnosis_figures import all_figures as figures_of_diagnosis
from elastic_tendon.reports.location_figures import all_figures
from truth import signals, torque_driven
from truth.catalogue import actuator_of, signal_maps_of
from truth.recording import record
from truth.torque_driven import Drive

TIME = np.arange(0.0, 4.0, 4e-3)
NOISE = 1e-4  # rad
TORQUE_NOISE = 0.02  # N·m

GIVEN = parse_model(
    {
        "name": "drive",
        "transmission": {
            "joint_pulley_radius": 0.03,
            "motor_pulley_radius": 0.02,
            "pretension_force": 40.0,
            "upper_spring": {"stiffness": 9000.0, "max_deflection": 0.02, "damping": 5.0},
            "lower_spring": {"stiffness": 9000.0, "max_deflection": 0.02, "damping": 5.0},
        },
        "link": {"inertia": 0.03, "damping": 0.1},
        "motor": {"inertia": 0.004, "damping": 0.03},
        "uncertainty": {
            "transmission.upper_spring.damping": 0.0,
            "transmission.lower_spring.damping": 0.0,
        },
    },
    "drive",
)
TRUE = Drive(
    joint_radius=0.03,
    motor_radius=0.02,
    pretension=40.0,
    stiffness=(8300.0, 8300.0),
    damping=(5.0, 5.0),
    link=(0.035, 0.13),
    rotor=(0.0048, 0.024),
)


def torque(t):
    return 0.8 * np.sin(4.1 * t) + 0.6 * np.sin(13.7 * t) * np.sin(0.7 * t)


def load(t):
    return 1.2 * np.sin(2.3 * t)


def recording(drive: Drive, seed: int = 4) -> et.Measurement:
    states = torque_driven.simulate(drive, TIME, torque, load)
    rng = np.random.default_rng(seed)
    pulls = np.array([drive.pulls(*row) for row in states])
    shown = drive.joint_radius * (pulls[:, 0] - pulls[:, 1])
    return et.Measurement(
        name="driven",
        time=TIME,
        motor_position=states[:, 2] + NOISE * rng.standard_normal(len(TIME)),
        load_torque=load(TIME),
        signals={
            "joint_position": states[:, 0] + NOISE * rng.standard_normal(len(TIME)),
            "joint_torque": shown + TORQUE_NOISE * rng.standard_normal(len(TIME)),
            "motor_torque": torque(TIME),
        },
    )


@pytest.fixture(scope="module")
def plain():
    return recording(TRUE)


@pytest.mark.parametrize("kind", ["torque", "torque_joint", "joint"])
def test_a_fit_finds_the_numbers_that_the_interface_shows(plain, kind):
    shown = plain
    if kind == "joint":  # its motor torque is a command, not a sensor of the springs
        kept = {name: plain.signals[name] for name in ("joint_position", "joint_torque")}
        shown = replace(plain, signals=kept)
    found = et.fit(GIVEN.at(kind), shown).model
    stiffness = (
        found.transmission.upper_spring.stiffness + found.transmission.lower_spring.stiffness
    )
    assert stiffness == pytest.approx(2 * 8300.0, rel=0.01)
    if found.kind.has_rotor:
        assert found.motor.inertia == pytest.approx(0.0048, rel=0.02)
        assert found.motor.damping == pytest.approx(0.024, rel=0.1)
    if found.kind.has_link:
        assert found.link.inertia == pytest.approx(0.035, rel=0.01)
    compared = et.compare(found, shown)
    # the noise of a joint that is an input shows in all that is computed
    assert compared.noise_ratio()["joint_torque"] < 1.3
    assert (
        set(compared.rmse())
        == {
            "torque": {"joint_position", "motor_position", "joint_torque"},
            "torque_joint": {"motor_position", "joint_torque"},
            "joint": {"joint_torque"},
        }[kind]
    )


@pytest.mark.parametrize(
    ("kind", "floats"), [("torque", True), ("torque_joint", False), ("position", False)]
)
def test_segments_are_asked_of_a_motor_and_a_joint_that_float_together(plain, kind, floats):
    model = GIVEN.at(kind)
    problem = problem_of(model, [plain], free_parameters(model))
    assert nearly_integrates(problem, problem.start(model)) is floats


def test_where_the_error_lies_is_told_at_every_interface(plain):
    for kind in ("torque", "torque_joint", "joint"):
        compared = et.compare(GIVEN.at(kind), plain)
        located = et.locate(compared)
        assert set(located.files[0].bins) == set(compared.rmse())
        assert (
            compared.to_dict()["files"][0]["initial_state"].keys()
            == {
                "torque": {"joint_position", "joint_velocity", "motor_position", "motor_velocity"},
                "torque_joint": {"motor_position", "motor_velocity"},
                "joint": set(),
            }[kind]
        )


@pytest.mark.parametrize("kind", ["torque", "torque_joint"])
def test_friction_of_the_motor_is_named(kind):
    found = et.diagnose(GIVEN.at(kind), recording(replace(TRUE, rotor_friction=0.15)))
    assert found.verdict == "missing_effect"
    assert found.added == ("motor_friction",)
    assert found.model.effects["motor_friction"]["torque"] == pytest.approx(0.15, rel=0.03)
    assert found.ladder[-1].noise_ratio["motor_position"] < 1.1
    assert "Motor friction is surely missing" in found.sentence


def test_the_loss_of_a_gear_is_found_beside_its_friction():
    lossy = recording(replace(TRUE, rotor_friction=0.05, loss=(0.12, 0.25)))
    found = et.add(GIVEN.at("torque"), ("motor_friction", "gear_loss"), lossy)
    effects = found.model.effects
    assert effects["motor_friction"]["torque"] == pytest.approx(0.05, rel=0.02)
    assert effects["gear_loss"]["motor_share"] == pytest.approx(0.12, rel=0.02)
    assert effects["gear_loss"]["load_share"] == pytest.approx(0.25, rel=0.02)
    without, with_loss = (step.noise_ratio["motor_position"] for step in found.ladder[-2:])
    assert without > 100.0
    assert with_loss < 1.1


@pytest.mark.slow
def test_the_loss_of_a_gear_is_named_where_all_else_leaves_much():
    """Rare effects are no candidates until then."""
    lossy = recording(replace(TRUE, rotor_friction=0.05, loss=(0.12, 0.25)))
    found = et.diagnose(GIVEN.at("torque"), lossy)
    assert set(found.added) == {"motor_friction", "gear_loss"}
    assert found.ladder[-1].noise_ratio["motor_position"] < 1.1


@pytest.mark.parametrize("kind", ["torque", "torque_joint"])
def test_nothing_is_called_missing_of_a_rotor_that_is_as_modelled(kind, plain):
    found = et.diagnose(GIVEN.at(kind), plain)
    assert found.added == ()
    assert found.verdict == "wrong_parameter"


def held(effects, seed=1):
    """A joint that springs and a load moved, with its torque measured; for interface joint."""
    tree = GIVEN.model_dump() | {"effects": effects}
    for side in ("upper_spring", "lower_spring"):
        tree["transmission"][side]["stiffness"] = 8300.0
    driven = signals.sines([0.6, 0.2, 0.06], [1.1, 2.7, 5.3], [0.0, 0.0, 0.0])
    loaded = signals.sines([1.2, 0.8], [1.9, 3.4], [0.0, 0.0])
    experiment = signals.Experiment(TIME[-1], driven, loaded)
    run = record(actuator_of(tree), experiment, TIME, signal_maps_of(tree))
    rng = np.random.default_rng(seed)
    noise = {"motor_position": 0.5 * NOISE, "joint_position": NOISE, "joint_torque": TORQUE_NOISE}
    columns = {name: run[name] + s * rng.standard_normal(len(TIME)) for name, s in noise.items()}
    known = {"joint_torque": TORQUE_NOISE}
    motor = columns.pop("motor_position")
    return et.Measurement(TIME, motor, columns, name=f"held{seed}", given_noise=known)


HIDDEN = {
    "pulley_eccentricity": {"amplitude": 0.05, "phase": 0.7},
    "spring_relaxation": {"stiffness": 2500.0, "time_constant": 0.13},
}


@pytest.mark.parametrize("effect_id", HIDDEN)
def test_an_effect_of_the_tendons_is_named_where_the_joint_is_given(effect_id, tmp_path):
    found = et.diagnose(GIVEN.at("joint"), held({effect_id: HIDDEN[effect_id]}))
    assert found.verdict == "missing_effect"
    assert found.added == (effect_id,)
    for name, value in HIDDEN[effect_id].items():
        assert found.model.effects[effect_id][name] == pytest.approx(value, rel=0.05)
    assert found.ladder[-1].noise_ratio["joint_torque"] < 1.1
    assert not {"coulomb_friction", "gravity_load"} & {part.id for part in found.would_show}
    et.report(found, tmp_path / "x.html")
    for _, draw in figures_of_diagnosis(found):
        assert draw().axes


def test_nothing_is_called_missing_of_a_joint_that_is_as_modelled():
    """The other simulator's link need not be in the model."""
    tree = GIVEN.at("joint").model_dump()
    bare = parse_model({name: tree[name] for name in tree if name not in ("link", "motor")}, "bare")
    found = et.diagnose(bare, held({}), validate=held({}, seed=2))
    assert found.added == ()
    assert found.verdict == "wrong_parameter"
    springs = found.model.transmission
    both = springs.upper_spring.stiffness + springs.lower_spring.stiffness
    assert both == pytest.approx(2 * 8300.0, rel=0.01)
    (where,) = found.location.files
    assert where.missing_torque.notes == (
        "the model has no [link], so the missing torque is not known",
    )
    (where,) = et.locate(et.compare(GIVEN.at("joint"), held({}))).files
    (note,) = where.missing_torque.notes
    assert note.startswith("at interface joint the joint is given, and load_torque was not measur")


def test_a_long_recording_of_a_given_joint_is_searched_in_excerpts():
    short = held({})
    times = int(np.ceil(1.1 * MOST / len(TIME)))
    noise = np.random.default_rng(3).standard_normal(times * len(TIME))

    def again(values, sigma):
        return np.tile(values, times) + sigma * noise

    torque_shown = again(short.signals["joint_torque"], TORQUE_NOISE)
    joint = again(short.signals["joint_position"], NOISE)
    long = et.Measurement(
        np.arange(len(noise)) * TIME[1],
        np.tile(short.motor_position, times),
        {"joint_position": joint, "joint_torque": torque_shown},
    ).for_model(GIVEN.at("joint"))
    data = data_of(GIVEN.at("joint"), [long], [])
    assert data.excerpts
    assert sum(len(part.time) for part in data.motions) <= FEWER


def with_noisy_torque(clean, seed=5):
    rng = np.random.default_rng(seed)
    read = clean.signals["motor_torque"] + TORQUE_NOISE * rng.standard_normal(len(TIME))
    signals = {"joint_position": clean.signals["joint_position"], "motor_torque": read}
    return replace(clean, signals=signals, name=f"noisy{seed}")


def test_windows_are_so_short_that_the_noise_of_the_torque_matters_little(plain):
    torque_driven_model, noisy = GIVEN.at("torque"), with_noisy_torque(plain)
    given = noisy.for_model(torque_driven_model)
    horizon = horizon_for(torque_driven_model, [given])
    assert 0.2 <= horizon < 1.0
    (note,) = input_notes(torque_driven_model, [given], None, horizon)
    assert "the motor torque has noise of 0.02 N·m" in note
    assert f"in windows of {horizon:.2g} s" in note
    (note,) = input_notes(torque_driven_model, [given], 2.0, 2.0)
    assert "Shorter windows drift less" in note
    for part, model in ((plain, torque_driven_model), (noisy, GIVEN)):
        shown = part.for_model(model)
        assert horizon_for(model, [shown]) is None
        assert input_notes(model, [shown], None, None) == []


def test_a_noisy_motor_torque_hides_nothing_and_makes_nothing_up(plain):
    """A rotor integrates it, so that whole recordings end at many times the encoder's noise."""
    found = et.diagnose(GIVEN.at("torque"), with_noisy_torque(plain))
    assert found.added == ()
    assert found.verdict == "wrong_parameter"
    rough = replace(TRUE, rotor_friction=0.15)
    fitted, heldout = (with_noisy_torque(recording(rough, seed), seed) for seed in (4, 6))
    again = et.diagnose(GIVEN.at("torque"), fitted, validate=heldout)
    assert again.added == ("motor_friction",)
    assert again.model.effects["motor_friction"]["torque"] == pytest.approx(0.15, rel=0.05)
    last = again.ladder[-1]
    assert last.noise_ratio["motor_position"] < 1.2
    assert last.heldout_rmse["motor_position"] < 1.5e-3
    assert "Motor friction is surely missing" in again.sentence


def test_what_an_interface_needs_and_lacks_is_told(plain):
    without = replace(plain, signals={"joint_position": plain.signals["joint_position"]})
    with pytest.raises(et.MeasurementError, match="interface torque is driven by motor_torque, wh"):
        et.compare(GIVEN.at("torque"), without)
    with pytest.raises(et.MeasurementError, match="so there is nothing to compare"):
        et.compare(GIVEN.at("joint"), without)
    moved = et.simulate(GIVEN.at("joint"), without)  # to which nothing needs to be compared
    assert np.ptp(moved["joint_torque"]) > 0.1
    curve = replace(without, static=True)
    with pytest.raises(et.MeasurementError, match="a static curve is compared at interface posit"):
        et.compare(GIVEN.at("torque"), curve)


def lacking(plain, position, *signals):
    """The recording without one of the positions, with some of the signals."""
    shown = {name: plain.signals[name] for name in ("motor_torque", *signals)}
    if position != "motor_position":
        return replace(plain, signals=shown)
    shown["joint_position"] = plain.signals["joint_position"]
    return et.Measurement(TIME, None, shown, plain.load_torque, name="driven")


@pytest.mark.parametrize(
    ("kind", "position", "signals"),
    [
        ("torque", "joint_position", ()),
        ("torque", "motor_position", ()),
        ("torque_joint", "motor_position", ("joint_torque",)),
    ],
)
def test_a_position_that_the_interface_computes_need_not_be_measured(
    kind, position, signals, plain, tmp_path
):
    shown = lacking(plain, position, *signals)
    fitted = et.add(GIVEN.at(kind), (), shown)
    found = fitted.model.values()
    assert found["motor.inertia"] == pytest.approx(0.0048, rel=0.02)
    assert found["motor.damping"] == pytest.approx(0.024, rel=0.05)
    if kind == "torque":
        assert found["link.inertia"] == pytest.approx(0.035, rel=0.02)
    assert max(fitted.ladder[-1].noise_ratio.values()) < 1.1
    # as held out: the first 0.1 s tell the state, and nothing holds a rotor that starts wrong
    assert max(et.compare(fitted.model, shown).noise_ratio().values()) < 10.0
    compared = et.compare(GIVEN.at(kind), shown)
    (where,) = et.locate(compared).files
    assert all(where.in_words.values())
    assert not where.missing_torque.known
    assert where.missing_torque.notes == (
        f"{position} was not measured, so the missing torque is not known",
    )
    assert compared.to_dict()["files"][0]["missing_torque"]["rms"] is None
    et.report(compared, tmp_path / "x.html")


@pytest.mark.parametrize("position", ["joint_position", "motor_position"])
def test_a_diagnosis_says_which_position_it_lacks(position, plain):
    with pytest.raises(et.MeasurementError, match=f"and {position} was not measured; name its col"):
        et.diagnose(GIVEN.at("torque"), lacking(plain, position))


def test_a_joint_torque_alone_tells_of_a_joint_that_is_computed(plain):
    shown = replace(plain, signals={"joint_torque": plain.signals["joint_torque"]})
    found = et.fit(GIVEN, shown).model
    assert found.link.inertia == pytest.approx(0.035, rel=0.02)
    assert et.compare(found, shown).noise_ratio()["joint_torque"] < 1.1


@pytest.mark.parametrize("kind", ["joint", "torque_joint"])
def test_every_figure_of_a_given_joint_is_drawn(kind, plain, tmp_path):
    compared = et.compare(GIVEN.at(kind), plain)
    for _, draw in all_figures(compared, et.locate(compared)):
        assert draw().axes
    et.report(compared, tmp_path / "x.html")


def test_the_linear_model_has_the_rotor_or_what_the_joint_feels():
    by_drive = et.linearise(GIVEN, "III", drive=et.Drive.TORQUE)
    at_torque = et.linearise(GIVEN.at("torque"), "III")
    assert sorted(by_drive.poles(), key=abs) == pytest.approx(sorted(at_torque.poles(), key=abs))
    felt = et.linearise(GIVEN.at("joint"), "III", outputs=["joint_torque"])
    stiffness = 0.03**2 * 2 * 9000.0  # (25)
    by_name = dict(zip(felt.input_labels, felt.D[0], strict=True))
    assert by_name["joint_position"] == pytest.approx(-stiffness)
    assert by_name["joint_velocity"] == pytest.approx(-(0.03**2) * 2 * 5.0)
    assert by_name["motor_position"] == pytest.approx(stiffness * 0.02 / 0.03)
    assert "stiffness    16.2 N·m/rad" in et.linearise(GIVEN.at("joint"), "III").summary()
    with pytest.raises(et.LinearisationError, match="at interface torque the motor is driven as"):
        et.linearise(GIVEN.at("torque"), "III", drive=et.Drive.TORQUE)
    # in state I half as stiff, at both interfaces
    slack = et.linearise(GIVEN.at("joint"), "I", outputs=["joint_torque"])
    assert slack.D[0, 2] == pytest.approx(-0.5 * stiffness)


def with_noisy_load(clean, kind, sigma=0.1):
    noise = sigma * np.random.default_rng(8).standard_normal(len(TIME))
    measured = ("joint_position", "motor_torque")[: 2 if kind == "torque" else 1]
    signals = {name: clean.signals[name] for name in measured}
    return replace(clean, load_torque=clean.load_torque + noise, signals=signals)


@pytest.mark.parametrize(
    ("kind", "moves"), [("torque", "motor drifts"), ("position", "joint moves")]
)
def test_the_noise_of_a_load_is_noise_of_what_it_moves(plain, kind, moves):
    model = GIVEN.at(kind)
    found = et.diagnose(model, with_noisy_load(plain, kind))
    assert found.verdict == "wrong_parameter"
    assert found.added == ()
    # of so short a recording the noise moves a joint on springs by a quarter more or less
    assert all(part.noise_ratio < 1.4 for part in found.remaining.values())
    (note,) = (note for note in found.notes if "the load torque has noise of 0.1 N·m" in note)
    assert f"the simulated {moves} by" in note
    assert ("in windows of" in note) == model.kind.has_rotor


def test_a_held_out_recording_has_the_noise_of_its_load_too(plain):
    exact = with_noisy_load(plain, "position", 0.0)
    data = data_of(GIVEN, [exact], [with_noisy_load(recording(TRUE, seed=6), "position")])
    fitted, heldout = (
        part.noise["joint_position"].sigma for (part,) in (data.fitted, data.heldout)
    )
    assert fitted == pytest.approx(NOISE, rel=0.2)
    assert heldout > 10.0 * NOISE


def test_a_load_that_excites_all_frequencies_is_no_noise(plain):
    white = np.random.default_rng(9).standard_normal(len(TIME))
    spectrum = np.fft.rfft(white)
    spectrum[int(0.6 * len(spectrum)) :] = 0.0  # as of a generator behind a filter
    cell = with_noisy_load(plain, "position")
    assert len(input_notes(GIVEN, [cell.for_model(GIVEN)], None, None)) == 1
    for excited in (white, np.fft.irfft(spectrum, len(TIME))):
        recording = replace(cell, load_torque=excited).for_model(GIVEN)
        assert input_notes(GIVEN, [recording], None, None) == []
