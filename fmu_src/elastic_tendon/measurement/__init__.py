"""Measurements: read at the door, SI inside, with the noise floor of each signal."""

from elastic_tendon.measurement.noise import NoiseFloor, noise_floors
from elastic_tendon.measurement.noise_text import parse_size
from elastic_tendon.measurement.options import ReadOptions
from elastic_tendon.measurement.preparation import Preparation
from elastic_tendon.measurement.reader import (
    read_measurement,
    read_measurements,
    read_prepared,
)
from elastic_tendon.measurement.recording import (
    CLEARLY_LESS,
    Measurement,
    Recordings,
    listed,
)

__all__ = [
    "CLEARLY_LESS",
    "Measurement",
    "NoiseFloor",
    "Preparation",
    "ReadOptions",
    "Recordings",
    "listed",
    "noise_floors",
    "parse_size",
    "read_measurement",
    "read_measurements",
    "read_prepared",
]
