"""The table of linear models: a column for each state, and sentences for what is easily missed."""

import pytest
from rich.console import Console

from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.linear.linearise import linearise
from elastic_tendon.linear.result import Drive, LinearModel, OperatingPoint
from elastic_tendon.reports.linear_tables import columns, linear_table, mode_words, remarks

MODEL = load_model("biorob_x4_joint_3")
SLACK = 80.0 / (0.03 * 2 * 11580.0)  # rad, (36)
STATES = ("I", "II", "III")


def printed(models: list[LinearModel], channels=None) -> str:
    console = Console(width=100)
    with console.capture() as capture:
        console.print(linear_table("joint", models, channels))
    return capture.get()


def row(text: str, label: str) -> list[str]:
    (line,) = [line for line in text.splitlines() if line.strip().startswith(label)]
    return line.strip().removeprefix(label).split()


def test_each_state_has_its_column_with_numbers_of_the_paper() -> None:
    text = printed([linearise(MODEL, state) for state in STATES])
    assert row(text, "tendons' stiffness (N·m/rad)") == ["20.84", "20.84", "41.69"]
    assert row(text, "natural frequency (rad/s)") == ["26.36", "26.36", "37.28"]
    assert row(text, "active there") == ["yes", "yes", "yes"]
    assert "-2.667 ± 37.18j" in text
    assert "upper tendon goes" in text
    assert "motor position and velocity" in text
    assert max(map(len, text.splitlines())) <= 100


def test_a_torque_driven_rotor_shows_its_anti_resonance() -> None:
    text = printed([linearise(MODEL, state, drive=Drive.TORQUE) for state in STATES])
    assert row(text, "motor's anti-resonance (rad/s)") == ["26.36", "26.36", "37.28"]
    assert "zeros, motor drive torque" in text


def test_a_state_that_is_not_active_says_which_is() -> None:
    text = printed([linearise(MODEL, "II", OperatingPoint(deflection=0.0))])
    assert "no: III is" in text


def test_of_damped_springs_driven_by_position_the_torque_is_left_out() -> None:
    damped = MODEL.with_values({"transmission.upper_spring.damping": 3.0})
    text = printed([linearise(damped, state, drive=Drive.POSITION) for state in ("II", "III")])
    assert row(text, "tendons' stiffness (N·m/rad)") == ["20.84", "–"]
    assert "joint torque" not in text
    assert "→ joint position" in text


def test_channels_of_the_users_choice_are_shown_instead() -> None:
    text = printed([linearise(MODEL, "III")], [("load_torque", "joint_velocity")])
    assert row(text, "→ joint velocity (rad/s)") == []
    assert row(text, "zeros, load torque") == ["0"]
    assert "motor position\n" not in text


def test_on_a_boundary_both_sides_have_a_column() -> None:
    at = OperatingPoint(deflection=SLACK)
    on = linearise(MODEL, "III", at)
    assert [(side, column.validity.slack_state.name) for side, column in columns([on])] == [
        ("towards −", "III"),
        ("towards +", "II"),
    ]
    every = [linearise(MODEL, state, at) for state in STATES]
    shown = [column.validity.slack_state.name for _, column in columns(every)]
    assert sorted(shown) == ["I", "II", "III"]
    (sentence,) = [remark for remark in remarks([on]) if "boundary" in remark]
    assert "upper tendon goes slack" in sentence
    assert "both sides" in sentence


def test_the_span_of_frequencies_is_told_where_there_are_two() -> None:
    told = remarks([linearise(MODEL, state) for state in STATES])
    assert told == [
        "Between the states the tendons' natural frequency spans 26.4 to 37.3 rad/s, a factor 1.41."
    ]
    told = remarks([linearise(MODEL, "III"), linearise(MODEL, "both")])
    assert told[0] == "In state both the joint does not oscillate on its tendons."
    assert "not active" in told[1]


def test_sliding_friction_and_separate_inputs_are_said_to_be_so() -> None:
    rough = MODEL.with_effect("coulomb_friction", {"torque": 0.3})
    (told,) = remarks([linearise(rough, "III")])
    assert "sliding" in told
    assert "--mode joint_motion=0" in told
    assert remarks([linearise(rough, "III", OperatingPoint(joint_velocity=1.0))]) == []
    sticking = linearise(rough, "III", modes={"joint_motion": 0})
    assert remarks([sticking]) == []
    text = printed([sticking])
    assert "sticks" in text
    assert row(text, "static stiffness (N·m/rad)") == ["inf"]
    assert row(text, "added load to break away") == ["-0.3", "N·m"]
    damped = MODEL.with_values({"transmission.upper_spring.damping": 3.0})
    (told,) = remarks([linearise(damped, "III")])
    assert "--drive position" in told


def test_with_memory_sudden_and_static_stiffness_are_told_apart() -> None:
    relaxing = MODEL.with_effect("spring_relaxation", None)
    (told,) = remarks([linearise(relaxing, "III")])
    assert "sudden motion" in told
    assert "static stiffness" in told


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("lower_spring.taut", 0, "lower tendon goes slack"),
        ("upper_spring.taut", 1, "upper tendon comes taut"),
        ("upper_spring.overstretched", 0, "upper spring no longer overstretched"),
        (
            "lower_spring.overstretch_protection.engaged",
            1,
            "lower spring: the protective string is taut",
        ),
        ("joint_stop.upper_touched", 0, "the joint is beyond the upper stop no more"),
        ("indicator_3", 1, "indicator_3"),
    ],
)
def test_switches_are_told_in_words(name: str, value: int, words: str) -> None:
    assert mode_words(name, value) == words
