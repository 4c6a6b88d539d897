"""Which friction matters in a servo drive: logs on a pendulum, one term after the other.

    python build_scripts/study_servo_friction.py [--logs N] [--seconds S]

A truth that shares no code with the product (tests/truth/torque_driven.py) drives a pendulum
through a gear with every term of M6 (see the page Friction of servo drives); by default 16 logs of
6 s at 200 Hz. Models from M1 on are fitted to them, and the table says what each term takes of the
error that M1 leaves, on the logs that were fitted and on as many others.
"""

import argparse
import sys
from pathlib import Path

import numpy as np

import elastic_tendon as et

sys.path.append(str(Path(__file__).resolve().parents[1] / "tests"))

from truth import torque_driven
from truth.torque_driven import Drive

RATE, NOISE = 200.0, 3e-4  # Hz, rad
RADIUS, STIFFNESS, PRETENSION, WEIGHT = 0.02, 9.0e5, 4000.0, 1.5
DRIVE = Drive(
    joint_radius=RADIUS,
    motor_radius=RADIUS,
    pretension=PRETENSION,
    stiffness=(STIFFNESS, STIFFNESS),
    damping=(600.0, 600.0),
    link=(0.03, 0.01),
    rotor=(0.012, 0.08),
    rotor_friction=0.06,
    gravity=WEIGHT,
    loss=(0.10, 0.22),
    slow=(0.05, 0.03, 0.06, 0.006, 0.006, 0.3, 1.35),
)
SPRING = {"stiffness": STIFFNESS, "damping": 600.0, "max_deflection": 0.02}
KNOWN = ("pretension_force", "upper_spring.stiffness", "lower_spring.stiffness")
DAMPED = ("upper_spring.damping", "lower_spring.damping")
M1 = et.load_model(
    {
        "name": "M1",
        "interface": {"kind": "torque"},
        "transmission": {
            "joint_pulley_radius": RADIUS,
            "motor_pulley_radius": RADIUS,
            "pretension_force": PRETENSION,
            "upper_spring": SPRING,
            "lower_spring": SPRING,
        },
        "link": {"inertia": 0.03, "damping": 0.01},
        "motor": {"inertia": 0.01, "damping": 0.05},
        "effects": {"gravity_load": {"torque": WEIGHT}, "motor_friction": {"torque": 0.1}},
        "uncertainty": {
            **{f"transmission.{name}": 0.0 for name in (*KNOWN, *DAMPED)},
            "effects.gravity_load.torque": 0.0,
            "effects.gravity_load.angle": 0.0,
            "link.inertia": 0.0,
            "link.damping": 0.0,
            "motor.damping": 2.0,
        },
    }
)
# one term of friction beyond M1, and both
LADDERS: tuple[tuple[str, ...], ...] = (
    (),
    ("motor_stiction",),
    ("gear_loss",),
    ("gear_loss", "motor_stiction"),
)


def log(seed: int, seconds: float) -> et.Measurement:
    """A log: torques that lift, lower and drop the pendulum, slow ones and fast ones."""
    rng = np.random.default_rng(seed)
    frequency = 2.0 * np.pi * np.array([0.2, 0.55, 1.3]) * rng.uniform(0.8, 1.2, 3)
    size = WEIGHT * np.array([0.8, 0.5, 0.25]) * rng.uniform(0.7, 1.2, 3)
    phase = rng.uniform(0.0, 2.0 * np.pi, 3)

    def torque(at: float) -> float:
        rise = 1.0 - np.exp(-at / 0.1)  # from rest
        return float(rise * size @ np.sin(frequency * at + phase))

    time = np.arange(0.0, seconds, 1.0 / RATE)
    states = torque_driven.simulate(DRIVE, time, torque, lambda _at: 0.0)

    def read(column: int) -> np.ndarray:
        return np.asarray(states[:, column] + NOISE * rng.standard_normal(len(time)))

    return et.Measurement(
        time=time,
        motor_position=read(2),
        signals={
            "joint_position": read(0),
            "motor_torque": np.array([torque(at) for at in time]),
        },
        name=f"log {seed:02d}",
    )


def errors(logs: int, seconds: float) -> dict[tuple[str, ...], tuple[float, float]]:
    """RMS error of the motor's position, rad, on fitted and on other logs, by what was added."""
    fitted = [log(seed, seconds) for seed in range(logs)]
    others = [log(100 + seed, seconds) for seed in range(logs)]
    found: dict[tuple[str, ...], tuple[float, float]] = {}
    for names in LADDERS:
        added = et.add(M1, names, fitted) if names else et.fit(M1, fitted)
        parts = [
            et.compare(added.model, part).rmse()["motor_position"] for part in (fitted, others)
        ]
        found[names] = parts[0], parts[1]
    return found


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--logs", type=int, default=16)
    parser.add_argument("--seconds", type=float, default=6.0)
    given = parser.parse_args()
    print("| beyond M1 | fitted, mrad | others, mrad |\n| --- | --- | --- |")
    for names, (fitted, others) in errors(given.logs, given.seconds).items():
        print(f"| {' + '.join(names) or 'nothing'} | {1e3 * fitted:.3g} | {1e3 * others:.3g} |")
    return 0


if __name__ == "__main__":
    sys.exit(main())
