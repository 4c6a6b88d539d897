"""What is drawn of a proposed experiment, over time, on paper and on a page."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from elastic_tendon.comparison.residuals import Array
from elastic_tendon.diagnosis.result import Experiment
from elastic_tendon.reports.diagnosis_tables import called
from elastic_tendon.reports.units import shown, with_unit

TITLE = "The experiment to run next"


@dataclass(frozen=True)
class Panel:
    """Curves over one axis, whose `label` has the unit.

    `predicted` : their names are those of answers, which have the same colour in all panels.
    """

    label: str
    curves: Mapping[str, Array]
    predicted: bool = False


def title_of(experiment: Experiment) -> str:
    """What stands above the panels."""
    unloaded = experiment.kind.has_springs and not np.any(experiment.load_torque)
    return f"{TITLE}, without load" if experiment.kind.has_link and unloaded else TITLE


def panels_of(experiment: Experiment) -> Iterator[Panel]:
    """What is done, a load where one is to act, and what each answer predicts.

    Predictions differ by far less than they swing, so the last panel is of their differences.
    """
    for name, values in experiment.columns.items():
        if name != "load_torque" or np.any(values):
            yield Panel(with_unit(name), {name.partition("_")[0]: values})
    predictions = {called(name): values for name, values in experiment.predictions.items()}
    if len(predictions) < 2:
        return
    quantity = shown(experiment.signal)
    yield Panel(f"predicted {quantity.words} ({quantity.unit})", predictions, predicted=True)
    first, *others = predictions
    yield Panel(
        f"difference from {first} ({quantity.small_unit})",
        {
            name: quantity.small * (predictions[name] - predictions[first])
            for name in (first, *others)
        },
        predicted=True,
    )
