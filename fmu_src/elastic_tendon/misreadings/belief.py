"""Whether recordings are believed: looked at with the model before anything rests on them."""

from collections.abc import Sequence

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.measurement import Measurement
from elastic_tendon.misreadings.sampling import sampling_warnings
from elastic_tendon.misreadings.suspicion import refuse_suspicious, suspicions
from elastic_tendon.misreadings.time_shift import with_time_shifts_resolved
from elastic_tendon.native.library import library_path
from elastic_tendon.progress import Progress


def believed(
    model: Model,
    measurements: Sequence[Measurement],
    progress: Progress,
    *,
    as_declared: bool = False,
) -> list[Measurement]:
    """Recordings with notes of what is doubtful, and with the time shifts that were asked for.

    Parameters
    ----------
    model : Model
    measurements : as read; believed as they are where a position was not measured, or where the
        model's interface has no link
    progress : called with what is being done, and the share of it that is done
    as_declared : note what looks read wrongly instead of refusing it

    Returns
    -------
    list of Measurement, in the same order

    Raises
    ------
    MeasurementError : a recording looks as if it was read wrongly, or lacks what drives the model
    """
    measurements = [
        part.of_motion(model.motion).with_joint_position(model) for part in measurements
    ]
    if not model.kind.has_link:  # a load that was not given looks like anything
        return measurements
    if any(part.at(model.kind).unmeasured_positions for part in measurements):
        return measurements
    model = model.at_position()
    measurements = [part.at(model.kind) for part in measurements]
    # simulating comes next, and a library that has yet to be compiled takes a while
    library_path(*model.structure, progress)
    progress("looking at the data", 0.0)
    if as_declared:
        measurements = [part.noted(suspicions(model, part)) for part in measurements]
    else:
        refuse_suspicious(model, measurements)
    measurements = [part.noted(sampling_warnings(model, part)) for part in measurements]
    return with_time_shifts_resolved(model, measurements)
