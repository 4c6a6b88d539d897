"""Measurements: read at the door, SI inside, with the noise floor of each signal."""

from elastic_tendon.measurement.noise import NoiseFloor, noise_sigma
from elastic_tendon.measurement.reader import read_measurement
from elastic_tendon.measurement.recording import Measurement

__all__ = ["Measurement", "NoiseFloor", "noise_sigma", "read_measurement"]
