"""What an answer errs from the beginnings of recordings, where a fit chose their initial states.

A fit chooses them with all samples, and what the model lacks may hide there: a machine that nearly
integrates goes the whole way differently for a little velocity. An unseen recording has no such
choice.
"""

from collections.abc import Iterator
from math import sqrt

from elastic_tendon.comparison.compare import compare
from elastic_tendon.comparison.comparison import Comparison
from elastic_tendon.diagnosis.evidence import MUCH
from elastic_tendon.errors import SimulationError

HIDES = 1.5  # times the error as fitted, from which a user should know


def beginning_notes(fitted: Comparison) -> Iterator[str]:
    """For each recording and signal with more than noise left, of which a model errs far more once
    its first 0.1 s give the initial state, a sentence.

    Parameters
    ----------
    fitted : the model beside recordings, begun as the fit found them
    """
    for file in fitted.files:
        much = {
            name: error.rmse
            for name, error in file.signals.items()
            if error.rmse > sqrt(MUCH) * error.noise.sigma
        }
        if not much or file.measurement.static:
            continue
        try:
            (begun,) = compare(fitted.model, file.measurement).files
        except SimulationError:
            continue
        for name, rmse in much.items():
            times = begun.signals[name].rmse / rmse
            if times > HIDES:
                yield (
                    f"{file.measurement.name}: begun as its first 0.1 s show, the model errs "
                    f"{times:.3g} times as much in {name.replace('_', ' ')} as from the initial "
                    "state that was fitted to all samples. Expect the larger error of a new "
                    "recording."
                )
