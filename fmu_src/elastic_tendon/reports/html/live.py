"""The model of a report, alive: a panel that lays it beside the first recording."""

import math
from collections.abc import Iterator, Sequence

import numpy as np

from elastic_tendon.actuator.design import design
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.comparison.comparison import FileComparison
from elastic_tendon.estimation.determinability import Estimate
from elastic_tendon.fmu.live import LiveRecording, live_panel
from elastic_tendon.progress import Progress
from elastic_tendon.reports.html.blocks import Block, Live, Paragraphs
from elastic_tendon.reports.units import shown
from elastic_tendon.simulation.simulate import given_names, spline_slopes

SAMPLES = 1000  # of a recording, at most: more than a panel has pixels, and soon simulated
PER_PERIOD = 20.0  # samples of a vibration that must be left

_INSTEAD = (
    "<p>Here the model itself would run and follow your sliders. It needs JavaScript and "
    "WebAssembly, one of which is switched off; the figures and tables of this page do without."
    "</p>"
)
_TOO_LARGE = "With so many effects the model is too large to run in this page; with fewer it does."


def live(
    model: Model,
    files: Sequence[FileComparison],
    estimates: Sequence[Estimate],
    progress: Progress,
) -> Iterator[Block]:
    """What is to be known of the panel, and the panel.

    Parameters
    ----------
    model : Model
    files : recordings beside it; the first that is no static curve is shown
    estimates : whose intervals the sliders cover
    progress : told where the model has to be compiled
    """
    moving = [file for file in files if not file.measurement.static]
    recording = live_recording(model, moving[0]) if moving else None
    intervals = {
        estimate.path: estimate.interval
        for estimate in estimates
        if all(map(math.isfinite, estimate.interval))
    }
    panel = live_panel(model, _INSTEAD, intervals=intervals, recording=recording, progress=progress)
    if not panel:
        yield Paragraphs((_TOO_LARGE,))
        return
    yield Paragraphs((_sentence(recording, moving),))
    yield Live(panel)


def _sentence(recording: LiveRecording | None, moving: Sequence[FileComparison]) -> str:
    begin = "The model runs in this page: each slider simulates it anew, with the solver that made "
    begin += "all figures here."
    if recording is None:
        return begin
    measurement = moving[0].measurement
    kept, every = (np.diff(time[:2])[0] for time in (recording.time, measurement.time))
    which = "every sample" if kept == every else f"one of every {round(kept / every)} samples"
    duration = recording.time[-1] - recording.time[0]
    return f"{begin} Shown are {duration:.3g} s of {measurement.name}, {which}."


def live_recording(model: Model, file: FileComparison) -> LiveRecording:
    """As much of a recording as a page simulates while a slider moves.

    Samples are left out where enough of each vibration are left; what is still too long is cut.
    """
    whole = file.measurement
    spacing = float(whole.time[-1] - whole.time[0]) / (len(whole.time) - 1)
    period = 2.0 * math.pi / design(model).frequency_state_3 if model.kind.has_link else math.inf
    most = max(int(period / PER_PERIOD / spacing), 1) if math.isfinite(period) else 1
    stride = min(most, -(-len(whole.time) // SAMPLES))
    kept = whole.samples(slice(0, SAMPLES * stride, stride))
    names = given_names(model)
    inputs = {name: values for name, values in kept.inputs.items() if name in names}
    curved = kept.input_interpolation == "cubic"
    slopes = {name: spline_slopes(kept.time, values) for name, values in inputs.items()}
    first = shown(next(iter(kept.signals)))
    return LiveRecording(
        title=kept.name,
        time=kept.time,
        inputs=inputs,
        slopes=slopes if curved else {},
        interpolation=kept.input_interpolation,
        start=file.initial_state.as_dict(kept.kind),
        measured=kept.signals,
        readings={name: file.trajectory.measured(name) for name in kept.signals},
        small=first.small,
        small_unit=first.small_unit,
    )
