"""Smooth motions of the product's own simulator, as its torque balance and a sensor see them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from elastic_tendon import effects
from elastic_tendon.actuator.parameters import Model, load_model, typical_value
from elastic_tendon.diagnosis.torque_balance import Motion
from elastic_tendon.measurement import Measurement
from elastic_tendon.simulation.simulate import simulate

Array = NDArray[np.float64]

STEP, DURATION = 0.002, 6.0  # s
SETTLED = slice(100, -100)  # samples at which splines of the motion are to be trusted
GIVEN = load_model("biorob_x4_joint_3")


@dataclass(frozen=True)
class Played:
    """What a model does: (n,) time s, motor rad, load N·m, joint as its encoder shows it, rad."""

    model: Model
    time: Array
    motor: Array
    load: Array
    joint: CubicSpline

    @property
    def acceleration(self) -> Array:
        """Of the joint, rad/s²."""
        return np.asarray(self.joint(self.time, 2))

    @property
    def motion(self) -> Motion:
        """The exact motion, as a torque balance takes it."""
        motor, load = CubicSpline(self.time, self.motor), CubicSpline(self.time, self.load)
        velocity = np.asarray(self.joint(self.time, 1))
        up = velocity > 0.0

        def inputs_at(delay: float) -> tuple[Array, Array]:
            late = self.time - delay
            none = np.zeros(len(late))  # no torque drives the motor
            rates = [motor(late, 1), motor(late, 2), load(late, 1), none]
            values = [motor(late), rates[0], load(late), none]
            return np.column_stack(values), np.column_stack(rates)

        return Motion(
            step=STEP,
            position=np.asarray(self.joint(self.time)),
            velocity=velocity,
            inputs_at=inputs_at,
            weights=np.column_stack([up, ~up, np.zeros((len(up), 4))]).astype(float),
        )

    def recording(self, noise: float = 0.0, seed: int = 1) -> Measurement:
        """With white noise of the joint's encoder, rad."""
        rng = np.random.default_rng(seed)
        shown = self.joint(self.time) + noise * rng.standard_normal(len(self.time))
        return Measurement(
            name="played",
            time=self.time,
            motor_position=self.motor,
            signals={"joint_position": shown},
            load_torque=self.load,
            interpolation="cubic",
        )


def typical_model(*effect_ids: str) -> Model:
    """The bundled model with effects of their typical size."""
    model = GIVEN
    for effect_id in effect_ids:
        values = {
            parameter.name: typical_value(GIVEN, parameter)
            for parameter in effects.BY_ID[effect_id].parameters
        }
        model = model.with_effect(effect_id, values)
    return model


def played(model: Model, duration: float = DURATION) -> Played:
    """A model moved by a multisine and loaded by a sine that makes either tendon slack."""
    time = np.arange(0.0, duration, STEP)
    motor = 0.4 * np.sin(2 * np.pi * 0.5 * time) + 0.2 * np.sin(2 * np.pi * 1.7 * time)
    load = 2.0 * np.sin(2 * np.pi * 0.9 * time + 1.0)
    run = simulate(model, time, motor, load, interpolation="cubic", as_measured=True)
    shown = run[run.measured("joint_position")]
    return Played(model, time, motor, load, CubicSpline(time, shown))
