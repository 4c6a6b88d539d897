"""Where a model fails: by what the joint was doing, in bins and in words."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from elastic_tendon.actuator.motion_kind import MotionKind
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.comparison.averaging import block_means, spread, stride_of
from elastic_tendon.comparison.bins import Bin, bins_of
from elastic_tendon.comparison.compare import compare
from elastic_tendon.comparison.comparison import Comparison, FileComparison
from elastic_tendon.comparison.correlations import Correlation, correlations
from elastic_tendon.comparison.in_words import in_words
from elastic_tendon.comparison.missing_torque import (
    MissingTorque,
    missing_torque,
    without_torque,
)
from elastic_tendon.comparison.partition import Partition
from elastic_tendon.comparison.patterns import Evidence
from elastic_tendon.comparison.residuals import Array, residuals_of
from elastic_tendon.comparison.selection import at
from elastic_tendon.measurement import Measurement
from elastic_tendon.progress import Progress, silent
from elastic_tendon.result import Result, plain

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class FileLocation:
    """Where the model fails in one recording, which `comparison` holds beside its simulation.

    `bins` and `in_words` by signal; `variables` are what the joint did, (n,) arrays by name:
    ``time`` (s), ``deflection`` (rad), ``joint_velocity`` (rad/s), ``joint_acceleration``
    (rad/s²), ``joint_position`` and ``motor_position`` (rad), ``load_torque`` and
    ``joint_torque``, which the tendons exert (N·m), ``slack_state`` of the measured deflection, see
    `comparison.slack_states_measured`; the rest of the model moved as measured, by the missing
    torque. Neighbouring samples of a long recording share their values, see `averaging`. `parts`
    are the samples of such a recording, or blocks of them, sorted into the bins. `correlations` of
    each signal's residual, with itself first; none of a static curve, which has no lags.
    """

    bins: Mapping[str, tuple[Bin, ...]]
    in_words: Mapping[str, str]
    missing_torque: MissingTorque
    variables: Mapping[str, Array]
    parts: Mapping[str, Partition]
    comparison: FileComparison
    correlations: Mapping[str, tuple[Correlation, ...]]

    def samples_of(self, by: str, words: str) -> NDArray[np.bool_]:
        """Which samples a bin holds, (n,); none where the bin is one of the frequency.

        Parameters
        ----------
        by, words : the variable of a `Bin`, and its part as `bin` says it
        """
        n = len(self.variables["time"])
        if by not in self.parts or words not in self.parts[by].words:
            return np.zeros(n, dtype=np.bool_)
        part = self.parts[by]
        return spread(part.member == part.words.index(words), stride_of(n), n)


@dataclass(frozen=True, repr=False)
class Location(Result):
    """Where a model fails, for each file of a comparison and in its order."""

    files: tuple[FileLocation, ...]

    def summary(self) -> str:
        """A sentence for each signal of each recording."""
        several = len(self.files) > 1
        return "\n".join(
            f"{f'recording {number}, ' if several else ''}{signal}: {words}"
            for number, file in enumerate(self.files, start=1)
            for signal, words in file.in_words.items()
        )

    def to_dataframe(self) -> "pd.DataFrame":
        """The error in each bin of each variable, a row each, SI."""
        import pandas as pd

        return pd.DataFrame(
            [
                {"recording": number, "signal": signal} | asdict(part)
                for number, file in enumerate(self.files, start=1)
                for signal, parts in file.bins.items()
                for part in parts
            ]
        )

    def to_dict(self) -> dict[str, Any]:
        """As ``where`` and ``in_words`` of the contract ``elastic-tendon/comparison/1``."""
        content: dict[str, Any] = plain(
            {
                "files": [
                    {
                        signal: {"where": [asdict(part) for part in parts], "in_words": words}
                        for (signal, parts), words in zip(
                            file.bins.items(), file.in_words.values(), strict=True
                        )
                    }
                    for file in self.files
                ]
            }
        )
        return content

    def plot(self) -> "Figure":
        """Draw the share of the error that lies in each bin, for each recording and signal."""
        from elastic_tendon.reports.location_figures import shares_of_error
        from elastic_tendon.reports.worded import worded_figure

        motions = (file.comparison.measurement.motion for file in self.files)
        motion = next(filter(None, motions), MotionKind.ROTARY)
        return worded_figure(shares_of_error(self), motion)


def locate(comparison: Comparison, progress: Progress = silent) -> Location:
    """Find where the error of a comparison lies, of all samples whatever conditions they meet.

    Parameters
    ----------
    comparison : Comparison
    progress : told what is being done, and the share of all that is done

    Returns
    -------
    Location
    """
    files: list[FileLocation] = []
    for file in comparison.files:

        def report_progress(text: str, share: float, name: str = file.measurement.name) -> None:
            progress(f"{name}: {text}", (len(files) + share) / len(comparison.files))

        files.append(_locate_one(comparison.model, file, report_progress))
    return Location(tuple(files))


def _seen_from_joint(
    model: Model, file: FileComparison, progress: Progress
) -> tuple[MissingTorque, Mapping[str, Array], Mapping[str, Partition]]:
    """Missing torque as at interface position, where one that is missing at the joint shows."""
    if reason := _why_unknown(model, file.measurement):
        return without_torque(model, file, reason)
    position = model.at_position()
    if position.kind is not model.kind:
        model, file = position, compare(position, file.measurement).files[0]
    return missing_torque(model, file, progress)


def _why_unknown(model: Model, measurement: Measurement) -> str:
    """Why the missing torque cannot be known; empty where it can."""
    if lacking := " and ".join(measurement.unmeasured_positions):
        return f"{lacking} was not measured"
    if not model.kind.has_link and model.link.absent:
        return "the model has no [link]"
    if not model.kind.has_link and measurement.load_torque is None:  # all that moves it is missing
        return f"at interface {model.kind} the joint is given, and load_torque was not measured"
    return ""


def _locate_one(model: Model, file: FileComparison, progress: Progress) -> FileLocation:
    file = at(model, file, None)
    measurement = file.measurement
    missing, variables, parts = _seen_from_joint(model, file, progress)
    progress("where the error lies", 0.9)
    residuals = residuals_of(file.trajectory, measurement)
    measured = {"time": measurement.time}
    if "motor_position" not in measurement.unmeasured_positions:
        measured["motor_position"] = measurement.motor_position
    n = len(measurement.time)
    stride = stride_of(n)
    bins = {
        name: bins_of(
            *(residual, measurement.signals[name], measurement.time, parts),
            file.signals[name].noise,
            static=measurement.static,
            stride=stride,
        )
        for name, residual in residuals.items()
    }
    return FileLocation(
        bins=bins,
        in_words={
            name: model.motion.words(
                in_words(
                    Evidence(
                        *(name, block_means(residual, stride), file.signals[name], bins[name]),
                        *(missing, variables, parts),
                        static=measurement.static,
                        model=model,
                        load_recorded=measurement.load_torque is not None,
                    )
                )
            )
            for name, residual in residuals.items()
        },
        missing_torque=replace(
            missing,
            torque=spread(missing.torque, stride, n),
            sigma=spread(missing.sigma, stride, n),
        ),
        variables={
            **{name: spread(values, stride, n) for name, values in variables.items()},
            **measured,
        },
        parts=parts,
        comparison=file,
        correlations={}
        if measurement.static
        else {name: correlations(file, name) for name in file.signals},
    )
