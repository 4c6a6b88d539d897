"""The friction of servo drives as robotics writes it, M1 to M6, is that of models of ours.

The formulas are of Duclusaud et al., Extended friction models for the physics simulation of servo
actuators (2024), written here anew; the page servo_friction of the site is the table of them.
"""

import re
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from elastic_tendon.actuator.model import build
from elastic_tendon.actuator.parameters import parse_model
from elastic_tendon.effects import BY_ID

AGREEMENT = 1e-9  # N·m
PAGE = Path(__file__).resolve().parents[2] / "fmu_src" / "site" / "servo_friction.md"
RADIUS, STIFFNESS, INERTIA = 0.02, 5.0e4, 0.015

SERVO = {
    "Kv": 0.11, "Kc": 0.07, "Kcs": 0.05, "vs": 0.3, "alpha": 1.35, "Kl": 0.12, "Kls": 0.06,
    "Km": 0.13, "Ke": 0.21, "Kms": 0.04, "Kes": 0.09, "Qm": 0.006, "Qe": 0.009,
}  # fmt: skip
LOADS = {  # torque of the motor, and from outside, N·m: positive moves the motor forward
    "drives": (3.0, -2.1),
    "is driven": (1.2, -2.9),
    "with its load": (1.1, 1.6),
    "brakes": (-0.4, -1.7),
    "unloaded": (0.9, 0.0),
}
VELOCITIES = (-2.5, -0.2, 0.004, 0.35, 4.0)  # rad/s


def budget(kind: int, motor: float, load: float, velocity: float) -> float:
    """Torque against the motion, N·m, of model M1 to M6."""
    s, total = SERVO, SERVO["Kc"] + SERVO["Kv"] * abs(velocity)
    slow = np.exp(-(abs(velocity / s["vs"]) ** s["alpha"]))
    if kind in (2, 4, 5, 6):
        total += slow * s["Kcs"]
    if kind in (3, 4):
        total += s["Kl"] * abs(load - motor)
    if kind == 4:
        total += slow * s["Kls"] * abs(load - motor)
    if kind in (5, 6):
        total += abs(s["Ke"] * load - s["Km"] * motor)
        total += slow * abs(s["Kes"] * load - s["Kms"] * motor)
    if kind == 6 and np.sign(motor) != np.sign(load):
        driving = abs(load) < abs(motor)
        total += slow * (s["Qe"] * load**2 if driving else s["Qm"] * motor**2)
    return float(total)


def effects_of(kind: int) -> dict[str, dict[str, float]]:
    """Our effects for a model, as the table of the page says."""
    s = SERVO
    effects = {"motor_friction": {"torque": s["Kc"]}}
    if kind >= 3:
        shares = (s["Kl"], s["Kl"]) if kind < 5 else (s["Km"], s["Ke"])
        effects["gear_loss"] = dict(zip(("motor_share", "load_share"), shares, strict=True))
    if kind in (2, 4, 5, 6):
        slow = {"torque": s["Kcs"], "stribeck_velocity": s["vs"], "exponent": s["alpha"]}
        shares = {4: (s["Kls"], s["Kls"]), 5: (s["Kms"], s["Kes"]), 6: (s["Kms"], s["Kes"])}
        slow |= dict(zip(("motor_share", "load_share"), shares.get(kind, (0.0, 0.0)), strict=True))
        if kind == 6:
            slow |= {"driving_square": s["Qe"], "driven_square": s["Qm"]}
        effects["motor_stiction"] = slow
    return effects


def friction(kind: int, motor: float, load: float, velocity: float) -> float:
    """What our model takes of the torques on its rotor while it moves, N·m against the motion."""
    spring = {"stiffness": STIFFNESS, "max_deflection": 1.0}
    tree = {
        "name": f"M{kind}",
        "interface": {"kind": "torque"},
        "transmission": {
            "joint_pulley_radius": RADIUS,
            "motor_pulley_radius": RADIUS,
            "pretension_force": 0.0,
            "slack": 0,
            "upper_spring": spring,
            "lower_spring": spring,
        },
        "link": {"inertia": 0.05},
        "motor": {"inertia": INERTIA, "damping": SERVO["Kv"]},
        "effects": effects_of(kind),
    }
    model = parse_model(tree, "here")
    system = build(model.effect_ids, model.kind)
    bent = load / (2.0 * RADIUS**2 * STIFFNESS)  # of the shaft, which turns the motor with `load`
    known = {"joint_position": bent, "motor_velocity": velocity, "motor_torque": motor}
    x, u = (
        [known.get(name, 0.0) for name in names]
        for names in (system.interface.state_names, system.interface.input_names)
    )
    evaluate = ca.Function(
        "rates", [system.x, system.u, system.p, system.r], [system.rates, system.next_modes]
    )
    modes = [mode.start for mode in system.interface.modes]
    for _ in range(4):
        modes = evaluate(x, u, list(model.values().values()), modes)[1]
    rates = evaluate(x, u, list(model.values().values()), modes)[0]
    acceleration = float(rates[system.interface.state_names.index("motor_velocity")])
    return float(np.sign(velocity) * (motor + load - INERTIA * acceleration))


@pytest.mark.parametrize("load", LOADS)
@pytest.mark.parametrize("kind", range(1, 7))
def test_each_model_of_a_servo_is_one_of_ours(kind: int, load: str) -> None:
    for velocity in VELOCITIES:
        expected = budget(kind, *LOADS[load], velocity)
        assert abs(friction(kind, *LOADS[load], velocity) - expected) < AGREEMENT, velocity


def test_terms_add_up_to_other_torques_in_every_model() -> None:
    """So that no two models are compared with the same number."""
    found = [budget(kind, *LOADS["drives"], 0.35) for kind in range(1, 7)]
    assert min(np.diff(sorted(found))) > 1e-3


def test_the_page_names_only_parameters_that_there_are_and_all_of_them() -> None:
    told = set(re.findall(r"`(\w+)\.(\w+)`", PAGE.read_text("utf-8")))
    for effect_id in ("motor_friction", "gear_loss", "motor_stiction"):
        names = {parameter.name for parameter in BY_ID[effect_id].parameters}
        assert {name for owner, name in told if owner == effect_id} == names
    assert all(owner in {*BY_ID, "motor", "link"} for owner, _ in told)
