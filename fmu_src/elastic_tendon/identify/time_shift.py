"""By how much a signal is late, estimated from the simulation."""

from collections.abc import Sequence

from elastic_tendon.measurement import Measurement
from elastic_tendon.parameters import Model


def estimate_time_shift(model: Model, measurement: Measurement, signal: str) -> float | None:
    """Delay of a signal against the others, s; positive where its sensor is late.

    Parameters
    ----------
    model : Model
    measurement : Measurement; not shifted
    signal : name of an input or signal of the measurement

    Returns
    -------
    float, s; None where the recording cannot tell
    """
    return None


def with_time_shifts_resolved(
    model: Model, measurements: Sequence[Measurement]
) -> list[Measurement]:
    """Put estimates in the place of every shift that is left to be estimated (``"auto"``).

    Parameters
    ----------
    model : Model
    measurements : sequence of Measurement

    Returns
    -------
    list of Measurement; shifted, with the number in its preparation and a note

    Raises
    ------
    MeasurementError : the recording cannot tell by how much a signal is late
    """
    return list(measurements)
