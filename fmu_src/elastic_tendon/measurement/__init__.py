"""Measurements: read at the door, SI inside, with the noise floor of each signal."""

from elastic_tendon.measurement.noise import NoiseFloor, noise_floors, noise_sigma
from elastic_tendon.measurement.preparation import Preparation
from elastic_tendon.measurement.reader import (
    read_measurement,
    read_measurements,
    read_prepared,
)
from elastic_tendon.measurement.recording import Measurement

__all__ = [
    "Measurement",
    "NoiseFloor",
    "Preparation",
    "noise_floors",
    "noise_sigma",
    "read_measurement",
    "read_measurements",
    "read_prepared",
]
