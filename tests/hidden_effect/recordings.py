"""What the sensors of a machine show of a motion, and what hides in it."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastic_tendon.measurement import Measurement
from elastic_tendon.native.interpolation import AskedInterpolation
from truth.fast import FastRun, Inputs
from truth.noise import Sensor, counts, measured

Array = NDArray[np.float64]

BITS = 14
QUANTISED = counts(BITS) / math.sqrt(12.0)  # rad, standard deviation of rounding
DISTURBANCE_BAND = (0.3, 4.0)  # Hz
DISTURBANCE = 3.0  # deflection that it causes, in standard deviations of the noise
CORRELATION = 0.9

NOISES = ("white", "coloured", "quantised", "motor encoder", "disturbance", "combined")
# noises of which the first rows of the targets speak
PLAIN = ("white", "quantised")


@dataclass(frozen=True)
class Noise:
    """A kind in `NOISES`, and its standard deviation on the joint's encoder, rad."""

    kind: str
    sigma: float

    @property
    def correlation(self) -> float:
        """From one sample to the next."""
        return CORRELATION if self.kind == "coloured" else 0.0

    @property
    def joint(self) -> Sensor:
        """The joint's encoder."""
        if self.kind == "coloured":
            return Sensor(coloured=self.sigma, correlation=CORRELATION)
        if self.kind == "quantised":
            return Sensor(step=counts(BITS))
        if self.kind == "combined":
            part = 0.6 * self.sigma
            return Sensor(white=part, coloured=part, correlation=CORRELATION, step=counts(BITS))
        return Sensor(white=self.sigma)

    @property
    def motor(self) -> Sensor:
        """The motor's encoder."""
        if self.kind in ("motor encoder", "combined"):
            return Sensor(white=0.3 * self.sigma, step=counts(BITS))
        return Sensor()


def disturbance(rng: np.random.Generator, time: Array, rms: float) -> Array:
    """A random torque on the joint, band limited, that nobody knows of, N·m."""
    frequencies = rng.uniform(*DISTURBANCE_BAND, 30)
    phases = rng.uniform(0.0, 2.0 * math.pi, 30)
    waves = np.cos(2.0 * math.pi * np.outer(time, frequencies) + phases).sum(axis=1)
    return np.asarray(rms * waves / math.sqrt(15.0))


@dataclass(frozen=True)
class Shown:
    """What is recorded, and by how much it is off the truth without disturbance, RMS a signal."""

    measurement: Measurement
    floor: dict[str, float]


def shown(
    name: str,
    inputs: Inputs,
    disturbed: FastRun,
    undisturbed: FastRun,
    noise: Noise,
    torque_sigma: float,
    rng: np.random.Generator,
    interpolation: AskedInterpolation = "cubic",
) -> Shown:
    """A recording of a run.

    Parameters
    ----------
    inputs : as the sensors would show them without noise
    disturbed, undisturbed : the joint with and without what disturbs it
    torque_sigma : noise of the joint's torque, N·m; 0: it is not recorded
    """
    signals = {"joint_position": measured(disturbed.joint_position, noise.joint, rng)}
    true = {"joint_position": undisturbed.joint_position}
    if torque_sigma > 0.0:
        sensor = Sensor(white=torque_sigma)
        signals["joint_torque"] = measured(disturbed.joint_torque, sensor, rng)
        true["joint_torque"] = undisturbed.joint_torque
    measurement = Measurement(
        name=name,
        time=inputs.time,
        motor_position=measured(inputs.motor_position, noise.motor, rng),
        signals=signals,
        load_torque=inputs.load_torque if np.any(inputs.load_torque) else None,
        interpolation=interpolation,
    )
    floor = {key: float(np.sqrt(np.mean((signals[key] - true[key]) ** 2))) for key in signals}
    return Shown(measurement, floor)
