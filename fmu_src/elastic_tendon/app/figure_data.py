"""Tables of what the page draws, and of all samples of a recording, for whoever draws it anew."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import plotly.graph_objects as go

from elastic_tendon.actuator.motion_kind import MotionKind
from elastic_tendon.actuator.variables import SIGNALS
from elastic_tendon.app.results import Compared
from elastic_tendon.comparison.comparison import FileComparison
from elastic_tendon.comparison.locate import Location
from elastic_tendon.comparison.simulated import SUFFIXES
from elastic_tendon.diagnosis.result import Round
from elastic_tendon.estimation.ladder import Step
from elastic_tendon.reports.interactive.candidates import candidates
from elastic_tendon.reports.interactive.characteristic import characteristic
from elastic_tendon.reports.interactive.correlation import residual_correlation
from elastic_tendon.reports.interactive.data import figure_table
from elastic_tendon.reports.interactive.ladder import ladder
from elastic_tendon.reports.interactive.loop import torque_loop
from elastic_tendon.reports.interactive.overlay import Run, overlay
from elastic_tendon.reports.interactive.places import error_maps, shares
from elastic_tendon.reports.interactive.torque import missing_torque
from elastic_tendon.reports.worded import worded_plotly

if TYPE_CHECKING:
    import pandas as pd

AS_GIVEN, SIMULATED = "as given", "simulated"  # what models are called beside the data


@dataclass(frozen=True)
class Table:
    """A table that is made when it is written; `name` may hold what a user wrote."""

    folder: str
    name: str
    make: Callable[[], "pd.DataFrame"]


def figures(
    known: Sequence[Compared], located: Location, steps: Sequence[Step], rounds: Sequence[Round]
) -> Iterator[Table]:
    """What the figures of the page show.

    Parameters
    ----------
    known : the model as given, then the current one where it is another, beside the data
    located : where the current one fails in the recordings that are fitted
    steps : from the one to the other
    rounds : what the search found on the way
    """
    given, current = known[0].fitted.model, known[-1].fitted.model
    springs = current.kind.has_springs
    table = partial(_table, current.motion)
    if springs:
        yield table("characteristic_curve", partial(characteristic, current, given=given))
    for runs in _side_by_side(known):
        measurement = runs[0].file.measurement
        for signal in measurement.signals:
            yield table(f"{measurement.name}_{signal}", partial(overlay, runs, signal))
    fitted = known[-1].fitted
    for file, location in zip(fitted.files, located.files, strict=True):
        name = file.measurement.name
        if springs:
            yield table(f"{name}_torque_loop", partial(torque_loop, fitted.model, file, location))
        yield table(f"{name}_missing_torque", partial(missing_torque, file, location))
        if not file.measurement.static:
            yield table(f"{name}_error_maps", partial(error_maps, file, location))
        for signal in file.signals:
            yield table(f"{name}_shares_{signal}", partial(shares, file, location, signal))
        for signal in location.correlations:
            name_of_table = f"{name}_residual_correlation_{signal}"
            yield table(name_of_table, partial(residual_correlation, location, signal))
    static = all(file.measurement.static for file in fitted.files)
    for signal in steps[0].rmse:
        yield table(f"ladder_{signal}", partial(ladder, steps, signal, static=static))
    for search_round in rounds:
        if search_round.candidates:
            yield table("candidates", partial(candidates, search_round))


def _table(motion: MotionKind, name: str, draw: Callable[[], go.Figure]) -> Table:
    return Table("figures", name, lambda: figure_table(worded_plotly(draw(), motion)))


def recordings(known: Sequence[Compared]) -> Iterator[Table]:
    """All samples of each recording: inputs, measured, simulated, and the error.

    The columns are named so that the table can be read as a recording again. SI units.

    Parameters
    ----------
    known : see `figures`
    """
    for runs in _side_by_side(known):
        yield Table("recordings", runs[0].file.measurement.name, partial(_samples, runs))


def _samples(runs: Sequence[Run]) -> "pd.DataFrame":
    import pandas as pd

    measurement = runs[0].file.measurement
    motion = measurement.motion or MotionKind.ROTARY

    def with_unit(name: str) -> str:
        return name + SUFFIXES[motion.unit(SIGNALS[name].unit)]

    inputs = {with_unit(name): values for name, values in measurement.inputs.items()}
    columns = {"time_s": measurement.time, **inputs}
    for signal, measured in measurement.signals.items():
        column = with_unit(signal)
        columns[f"measured_{column}"] = measured
        for run in runs:
            model = "" if run.label == SIMULATED else "as_given_"
            columns[f"{model}simulated_{column}"] = run.simulated(signal)
            columns[f"{model}error_{column}"] = run.error(signal)
    return pd.DataFrame(columns)


def _side_by_side(known: Sequence[Compared]) -> Iterator[tuple[Run, ...]]:
    """Of each recording, the models beside it."""
    labels = (AS_GIVEN, SIMULATED)[-len(known) :]
    for files in zip(*(_files(compared) for compared in known), strict=True):
        yield tuple(Run(label, file) for label, file in zip(labels, files, strict=True))


def _files(known: Compared) -> tuple[FileComparison, ...]:
    return (*known.fitted.files, *(known.heldout.files if known.heldout is not None else ()))
