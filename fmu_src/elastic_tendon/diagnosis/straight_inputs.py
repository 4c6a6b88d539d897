"""Whether the inputs ran in straight lines between their samples, smooth as they look.

Wrong inputs leave errors that effects can stand for, so this is asked before an answer stands.
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.comparison.compare import LOOKED_AT
from elastic_tendon.comparison.initial_state import estimate_initial_state
from elastic_tendon.comparison.residuals import rms, simulate_measurement
from elastic_tendon.diagnosis.answer import Answer, refit
from elastic_tendon.diagnosis.data import Data, data_of
from elastic_tendon.diagnosis.evidence import SURELY
from elastic_tendon.diagnosis.options import Options
from elastic_tendon.diagnosis.refits import EFFORT, FAILURES
from elastic_tendon.diagnosis.search import Search
from elastic_tendon.diagnosis.sets import without
from elastic_tendon.diagnosis.trajectory_screen import TrajectoryScreen
from elastic_tendon.estimation.fit import QUICK
from elastic_tendon.measurement import CLEARLY_LESS, Measurement

SEEN = 0.1  # of the noise: a difference between two motions that matters
STRAIGHT = (
    "between the samples the inputs run in straight lines, smooth as they look: with curves more "
    "of the error is left"
)


def with_straight_inputs(
    model: Model,
    measurements: Sequence[Measurement],
    validation: Sequence[Measurement],
    options: Options,
    search: Search,
    *,
    final: bool,
) -> Data | None:
    """The data with straight lines, if the answer of a search then leaves clearly less.

    Parameters
    ----------
    model, measurements, validation, options : as asked
    search : has an answer
    final : also if no more is left with an effect less

    Returns
    -------
    Data; None where the curves stay
    """
    answer = search.answer
    # who moves by less cannot leave clearly less
    least = SEEN if final else (1.0 - CLEARLY_LESS**0.5) * answer.mean_square**0.5
    if not any(_difference(answer.result.model, part) > least for part in measurements):
        return None
    fitted, held_out = (
        [part.with_straight_inputs() for part in parts] for parts in (measurements, validation)
    )
    less = [without(answer.added, effect_id) for effect_id in answer.added] if final else []
    known = [search.answers[added] for added in less if added in search.answers]
    # the answer's refit may have ended on the way: it is held against where it leads
    leads = min(answer.mean_square, _could_leave(answer, straight=False))
    allowed = [(answer, CLEARLY_LESS * leads), *((part, answer.mean_square) for part in known)]
    likely = [(part, most) for part, most in allowed if _could_leave(part, straight=True) < most]
    if not likely:
        return None
    data = data_of(model, fitted, held_out, options)
    for part, most in likely:
        effort = replace(QUICK, tolerance=EFFORT.tolerance, hopeless=SURELY * most)
        with suppress(*FAILURES):
            starts = [part.result.model]
            if refit(data.given, part.added, data.fitted, starts, effort).mean_square <= most:
                return data
    return None


def _could_leave(answer: Answer, *, straight: bool) -> float:
    """Mean square that an answer leaves where its parameters have followed to first order, with
    curves straightened or as they are."""
    measurements = [
        replace(part, interpolation="linear")
        if straight and part.interpolation == "cubic"
        else part
        for part in answer.result.problem.measurements
    ]
    return answer.mean_square * TrajectoryScreen(answer).with_recordings(measurements)


def _difference(model: Model, measurement: Measurement) -> float:
    """How far straight lines in the place of assumed curves move the joint, or change its torque
    where it is given, RMS, in sigmas."""
    if not measurement.has_assumed_curves:
        return 0.0
    parts = [
        part.samples(slice(LOOKED_AT)) for part in (measurement, measurement.with_straight_inputs())
    ]
    with suppress(*FAILURES):
        start = estimate_initial_state(model, parts[0])
        first, second = (
            simulate_measurement(model, part, start)[measurement.first_signal] for part in parts
        )
        return rms(first - second) / measurement.noise[measurement.first_signal].sigma
    return 0.0
