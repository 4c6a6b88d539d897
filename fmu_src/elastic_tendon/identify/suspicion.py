"""Recordings that look as if they were read wrongly: what is odd, and how to read them right."""

from collections.abc import Sequence

from elastic_tendon.errors import MeasurementError
from elastic_tendon.measurement import Measurement
from elastic_tendon.parameters import Model


def suspicions(model: Model, measurement: Measurement) -> tuple[str, ...]:
    """What looks as if it was read wrongly, a sentence each, the likeliest first.

    Parameters
    ----------
    model : Model
    measurement : Measurement; SI units

    Returns
    -------
    tuple of sentences; each says what was found, by what number, and how to read the file right
    """
    return ()


def refuse_suspicious(model: Model, measurements: Sequence[Measurement]) -> None:
    """Refuse recordings that look as if they were read wrongly.

    Parameters
    ----------
    model : Model
    measurements : sequence of Measurement

    Raises
    ------
    MeasurementError : the first suspicion, and that ``--as-declared`` takes the data as they are
    """
    for measurement in measurements:
        for sentence in suspicions(model, measurement):
            raise MeasurementError(sentence)
