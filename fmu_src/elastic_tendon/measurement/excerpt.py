"""A stretch of a recording that shows most of its motion in few samples."""

import numpy as np

from elastic_tendon.measurement import Measurement
from elastic_tendon.measurement.recording import Array

SHARE = 0.5  # of each signal's whole travel, which an excerpt has to show
PLACES = 50  # at which a window is tried


def liveliest(measurement: Measurement, count: int) -> Measurement:
    """At most `count` samples in which motor, joint and load move most.

    Neighbouring samples are taken where they show half of what motor and joint travel in the
    whole recording; else every second, every fourth... over a longer stretch. No use is made of
    the unit of time, which may be wrong.

    Parameters
    ----------
    measurement : Measurement with ``joint_position``
    count : int, samples

    Returns
    -------
    Measurement; the same one where it is short enough
    """
    total = len(measurement.time)
    load = measurement.load_torque
    moving = [measurement.motor_position, measurement.signals["joint_position"]]
    motion = moving if load is None else [*moving, load]
    travels = [float(np.ptp(values)) for values in motion]
    stride = 1
    while count * stride < total:
        starts = np.linspace(0, total - count * stride, PLACES).astype(int)
        windows = [slice(start, start + count * stride, stride) for start in starts]
        shares = [_shares(motion, travels, window) for window in windows]
        best = max(range(PLACES), key=lambda place: sum(shares[place]))
        if min(shares[best][: len(moving)]) >= SHARE:
            return measurement.samples(windows[best])
        stride *= 2
    return measurement.samples(slice(None, None, stride))


def _shares(motion: list[Array], travels: list[float], window: slice) -> list[float]:
    """Travel within a window over that of the whole; 1 for what does not move at all."""
    return [
        float(np.ptp(values[window]) / travel) if travel > 0.0 else 1.0
        for values, travel in zip(motion, travels, strict=True)
    ]
