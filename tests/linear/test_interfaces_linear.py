"""Linear models where a torque moves the rotor or the joint is given, against closed forms."""

import numpy as np
import pytest
from rich.console import Console

import elastic_tendon as et
from elastic_tendon.linear.analysis import analyse, is_joint_given, motor_input
from elastic_tendon.reports.linear_tables import linear_table

RADII, STIFFNESS, DAMPING = (0.03, 0.02), 9000.0, 5.0  # of joint and motor, m; of each spring
ROTOR = (0.004, 0.03)  # inertia, damping
MODEL = et.load_model(
    {
        "name": "drive",
        "transmission": {
            "joint_pulley_radius": RADII[0],
            "motor_pulley_radius": RADII[1],
            "pretension_force": 40.0,
            **{
                f"{side}_spring": {
                    "stiffness": STIFFNESS,
                    "max_deflection": 0.02,
                    "damping": DAMPING,
                }
                for side in ("upper", "lower")
            },
        },
        "link": {"inertia": 0.03, "damping": 0.1},
        "motor": {"inertia": ROTOR[0], "damping": ROTOR[1]},
    }
)
DRIVEN = {
    "torque": "driven by motor torque",
    "joint": "driven by motor position and velocity, joint given",
    "torque_joint": "driven by motor torque, joint given",
}


def test_with_the_joint_held_the_rotor_swings_on_its_tendons():
    """J_m s^2 + (b_m + 2 d r^2) s + 2 k r^2 = 0, and what the joint feels is (25)."""
    linear = et.linearise(MODEL.at("torque_joint"), "III")
    r = RADII[1]
    wanted = np.roots([ROTOR[0], ROTOR[1] + 2 * DAMPING * r**2, 2 * STIFFNESS * r**2])
    assert sorted(linear.poles(), key=np.imag) == pytest.approx(sorted(wanted, key=np.imag))
    found = analyse(linear)
    assert found.tendon_oscillation.natural_frequency == pytest.approx(abs(wanted[0]))
    assert found.tendon_stiffness == pytest.approx(2 * STIFFNESS * RADII[0] ** 2)
    assert found.tendon_damping == pytest.approx(2 * DAMPING * RADII[0] ** 2)
    assert found.stiffness == pytest.approx(2 * STIFFNESS * RADII[0] ** 2)  # motor held
    assert "stiffness    -" not in linear.summary()  # a free rotor follows a slow joint


def test_what_a_held_motor_makes_the_joint_feel():
    linear = et.linearise(MODEL.at("joint"), "III")
    found = analyse(linear)
    assert found.poles == ()
    assert found.tendon_oscillation is None
    assert found.stiffness == found.tendon_stiffness == pytest.approx(2 * STIFFNESS * 0.03**2)
    assert found.tendon_damping == pytest.approx(2 * DAMPING * 0.03**2)
    assert "poles        none" in linear.summary()


def test_a_relaxing_spring_is_stiffer_at_once_than_in_the_long_run():
    relaxing = {"stiffness": 3000.0, "time_constant": 0.13}
    model = MODEL.at("joint").with_effect("spring_relaxation", relaxing)
    found = analyse(et.linearise(model, "III"))
    assert found.stiffness == pytest.approx(2 * STIFFNESS * 0.03**2)
    assert found.tendon_stiffness == pytest.approx(2 * (STIFFNESS + 3000.0) * 0.03**2)


@pytest.mark.parametrize("kind", DRIVEN)
def test_tables_figures_and_json_say_what_drives(kind):
    models = [et.linearise(MODEL.at(kind), state) for state in ("I", "III")]
    assert is_joint_given(models[0]) == ("joint" in kind)
    console = Console(width=120)
    with console.capture() as printed:
        console.print(linear_table("drive", models))
    assert DRIVEN[kind] in " ".join(printed.get().split())
    figure = models[1].plot()
    assert DRIVEN[kind] in figure.get_suptitle()
    assert figure.axes[0].lines
    content = models[1].to_dict()
    channels = content["models"][0]["analysis"]["channels"]
    assert motor_input(models[1]) in {channel["input"] for channel in channels}
    assert content["drive"] == ("torque" if "torque" in kind else "source")
