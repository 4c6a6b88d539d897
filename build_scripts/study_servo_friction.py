"""Which friction matters in a servo drive: logs on a pendulum, one term after the other.

    python build_scripts/study_servo_friction.py [--logs N] [--seconds S] [--only DRIVE...]

A truth that shares no code with the product (tests/truth/torque_driven.py) drives a pendulum
through a gear with every term of M6 (see the page Friction of servo drives): a drive with round
numbers, and four with those that BAM publishes of real ones. By default it records 16 logs of 6 s
at 200 Hz. Models from M1 on are fitted to them; the table has the RMS error of the motor's position
on as many other logs, and by how much that of M1 is larger. Pendulums are not published: each is
about as heavy as its drive can lift. M3 here has a share for each side of the gear, which the
published M3 shares, so its column is also what M5 has without stiction.
"""

import argparse
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import elastic_tendon as et

sys.path.append(str(Path(__file__).resolve().parents[1] / "tests"))

from truth import torque_driven
from truth.torque_driven import Drive

RATE, NOISE = 200.0, 3e-4  # Hz, rad
RADIUS = 0.02  # m
# of springs so stiff that the pendulum is as good as fixed to the gear, over the pendulum's weight
STIFFNESS, PRETENSION, DAMPING = 6.0e5, 2700.0, 400.0


@dataclass(frozen=True)
class Servo:
    """A pendulum and its drive, in the numbers of M6, SI.

    `weight` : most torque of gravity. `loss` : shares of the torques before and behind the gear.
    `slow` : as of `torque_driven.Drive`.
    """

    weight: float
    inertia: float  # of the pendulum
    rotor: float
    viscous: float
    coulomb: float
    loss: tuple[float, float]
    slow: tuple[float, ...]

    @property
    def drive(self) -> Drive:
        """The machine."""
        return Drive(
            joint_radius=RADIUS,
            motor_radius=RADIUS,
            pretension=PRETENSION * self.weight,
            stiffness=(STIFFNESS * self.weight,) * 2,
            damping=(DAMPING * self.weight,) * 2,
            link=(self.inertia, 0.0),
            rotor=(self.rotor, self.viscous),
            rotor_friction=self.coulomb,
            gravity=self.weight,
            loss=self.loss,
            slow=self.slow,
        )

    @property
    def given(self) -> et.Model:
        """M1, with numbers of the drive that are off."""
        spring = {
            "stiffness": STIFFNESS * self.weight,
            "damping": DAMPING * self.weight,
            "max_deflection": RADIUS,
        }
        springs = {"upper_spring": spring, "lower_spring": spring}
        sides = [f"{side}.{name}" for side in springs for name in ("stiffness", "damping")]
        known = (
            *(f"transmission.{name}" for name in ("pretension_force", *sides)),
            *("effects.gravity_load.torque", "effects.gravity_load.angle"),
            *("link.inertia", "link.damping"),
        )
        return et.load_model(
            {
                "name": "M1",
                "interface": {"kind": "torque"},
                "transmission": {
                    "joint_pulley_radius": RADIUS,
                    "motor_pulley_radius": RADIUS,
                    "pretension_force": PRETENSION * self.weight,
                    **springs,
                },
                "link": {"inertia": self.inertia, "damping": 0.0},
                "motor": {"inertia": 0.85 * self.rotor, "damping": 0.6 * self.viscous},
                "effects": {
                    "gravity_load": {"torque": self.weight},
                    "motor_friction": {"torque": 0.07 * self.weight},
                },
                "uncertainty": {**dict.fromkeys(known, 0.0), "motor.damping": 2.0},
            }
        )


SERVOS = {
    "round numbers": Servo(
        *(1.5, 0.03, 0.012, 0.08, 0.06),
        loss=(0.10, 0.22),
        slow=(0.05, 0.03, 0.06, 0.006, 0.006, 0.3, 1.35),
    ),
    # bam/params, github.com/Rhoban/bam, m6.json of each
    "MX-64": Servo(
        *(0.6, 0.0063, 0.0123, 0.0253, 0.0),
        loss=(0.311, 0.0),
        slow=(0.123, 0.188, 0.0141, 0.01, 0.00691, 2.58, 0.841),
    ),
    "MX-106": Servo(
        *(1.2, 0.0126, 0.026, 0.0507, 0.0),
        loss=(0.198, 0.0222),
        slow=(0.122, 0.199, 0.0871, 7.3e-5, 0.01, 1.75, 1.14),
    ),
    "eRob80:50": Servo(
        *(30.0, 0.9, 0.362, 1.4, 3.26),
        loss=(0.0357, 0.000843),
        slow=(0.32, 0.00377, 0.0414, 0.0016, 0.00187, 2.83, 1.79),
    ),
    "eRob80:100": Servo(
        *(30.0, 0.9, 1.14, 9.71, 0.0),
        loss=(0.0489, 0.0),
        slow=(5.23, 0.0, 0.0512, 0.00256, 0.0027, 2.03, 3.0),
    ),
}
STICTION = ("torque", "stribeck_velocity", "exponent")
SHARES, SQUARES = ("motor_share", "load_share"), ("driving_square", "driven_square")
# effects beside motor_friction, and which of their parameters are fitted
MODELS: dict[str, dict[str, tuple[str, ...]]] = {
    "M1": {},
    "M2": {"motor_stiction": STICTION},
    "M3": {"gear_loss": SHARES},
    "M5": {"gear_loss": SHARES, "motor_stiction": (*STICTION, *SHARES)},
    "M6": {"gear_loss": SHARES, "motor_stiction": (*STICTION, *SHARES, *SQUARES)},
}
SLOW = (0.3, 2.0)  # rad/s, Stribeck velocities from which fits start
SHARE, SQUARE = 0.05, 0.005  # from which they start, the second over the weight


def log(servo: Servo, seed: int, seconds: float) -> et.Measurement:
    """A log: torques that lift, lower and drop the pendulum, slow ones and fast ones."""
    rng = np.random.default_rng(seed)
    frequency = 2.0 * np.pi * np.array([0.2, 0.55, 1.3]) * rng.uniform(0.8, 1.2, 3)
    size = servo.weight * np.array([0.8, 0.5, 0.25]) * rng.uniform(0.7, 1.2, 3)
    phase = rng.uniform(0.0, 2.0 * np.pi, 3)

    def torque(at: float) -> float:
        rise = 1.0 - np.exp(-at / 0.1)  # from rest
        return float(rise * size @ np.sin(frequency * at + phase))

    time = np.arange(0.0, seconds, 1.0 / RATE)
    states = torque_driven.simulate(servo.drive, time, torque, lambda _at: 0.0)

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


def starts(servo: Servo, name: str, simpler: Iterable[et.Model]) -> list[et.Model]:
    """One of the models, from where it is fitted: from small shares, and from simpler models."""
    values = {
        **dict.fromkeys(SHARES, SHARE),
        **dict.fromkeys(SQUARES, SQUARE / servo.weight),
        "torque": SHARE * servo.weight,
        "exponent": 1.0,
    }
    found = []
    for slow in SLOW:
        model = servo.given
        for effect_id, parameters in MODELS[name].items():
            known = values | {"stribeck_velocity": slow}
            model = model.with_effect(effect_id, {name: known[name] for name in parameters})
        found.append(model)
    first = found[0]
    own = first.values()
    for model in simpler:
        known = {path: value for path, value in model.values().items() if path in own}
        found.append(first.with_values(known))
    return found


def fitted(servo: Servo, logs: list[et.Measurement]) -> dict[str, et.Model]:
    """The models, fitted to logs one after the other."""
    found: dict[str, et.Model] = {}
    for name, effects in MODELS.items():
        simpler = [
            model for known, model in found.items() if MODELS[known].keys() <= effects.keys()
        ]
        first, *others = starts(servo, name, simpler)
        added = [
            f"effects.{effect_id}.{parameter}"
            for effect_id, parameters in effects.items()
            for parameter in parameters
        ]
        free = ("motor.inertia", "motor.damping", "effects.motor_friction.torque", *added)
        found[name] = et.fit(first, logs, free=free, starts=others).model
    return found


def errors(servo: Servo, logs: int, seconds: float) -> dict[str, float]:
    """RMS error of the motor's position, rad, on logs that were not fitted, by model."""
    seen = [log(servo, seed, seconds) for seed in range(logs)]
    others = [log(servo, 100 + seed, seconds) for seed in range(logs)]
    return {
        name: et.compare(model, others).rmse()["motor_position"]
        for name, model in fitted(servo, seen).items()
    }


def row(name: str, found: dict[str, float]) -> str:
    """Error in mrad, and how many times larger that of M1 is."""
    cells = [f"{1e3 * error:.3g} ({found['M1'] / error:.3g})" for error in found.values()]
    return f"| {name} | {' | '.join(cells)} |"


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--logs", type=int, default=16)
    parser.add_argument("--seconds", type=float, default=6.0)
    parser.add_argument("--only", nargs="+", choices=list(SERVOS), default=list(SERVOS))
    given = parser.parse_args()
    print(f"| drive | {' | '.join(MODELS)} |\n|{' --- |' * (len(MODELS) + 1)}")
    for name in given.only:
        print(row(name, errors(SERVOS[name], given.logs, given.seconds)), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
