"""Signals to zoom: nothing of a peak is lost, and nothing that users write becomes markup."""

import re
from dataclasses import replace

import numpy as np
import pytest

from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.actuator.transmission import characteristic_torque
from elastic_tendon.comparison.compare import compare
from elastic_tendon.comparison.conditions import Selection
from elastic_tendon.demo import DATA
from elastic_tendon.measurement import Measurement, read_measurement
from elastic_tendon.reports.interactive.overlay import Run, overlay, values_at
from elastic_tendon.reports.interactive.theme import (
    CONFIG,
    DARK,
    LIGHT,
    THEMES,
    Theme,
    blank,
    broken,
    panels,
    place_of,
    plain,
)
from elastic_tendon.reports.thinning import stretches

SIGNAL = "joint_position"


@pytest.fixture(scope="module")
def runs() -> list[Run]:
    """The demo's recording beside two models."""
    model = load_model(DATA / "demo_model.toml")
    recording = read_measurement(str(DATA / "demo_fit.csv"))
    better = model.with_effect("coulomb_friction", {"torque": 0.3})
    labels = {"as given": model, "with friction": better}
    return [Run(label, compare(changed, [recording]).files[0]) for label, changed in labels.items()]


@pytest.fixture(scope="module")
def curve() -> Run:
    """A static curve of springs that are softer than the model's."""
    model = load_model("figure_8")
    deflection = np.linspace(-0.15, 0.15, 300)
    torque = 0.9 * characteristic_torque(deflection, model.transmission)
    noise = 1e-4 * np.random.default_rng(5).standard_normal(300)
    signals = {SIGNAL: deflection + noise}
    rows = 10.0 * np.arange(300)
    measurement = Measurement(rows, np.zeros(300), signals, -torque, static=True, name="curve.csv")
    return Run("as given", compare(model, [measurement]).files[0])


def luminance(colour: str) -> float:
    """Relative luminance of "#RRGGBB" as WCAG 2 defines it."""
    parts = np.array([int(colour[place : place + 2], 16) for place in (1, 3, 5)]) / 255.0
    linear = np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)
    return float(linear @ [0.2126, 0.7152, 0.0722])


def contrast(first: str, second: str) -> float:
    low, high = sorted((luminance(first), luminance(second)))
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("theme", THEMES.values(), ids=list(THEMES))
def test_text_and_curves_stand_out_from_the_page(theme: Theme) -> None:
    for text in (theme.ink, theme.muted):
        assert contrast(text, theme.background) >= 4.5
    for colour in (theme.measured, theme.stands_out, theme.quiet, *theme.runs):
        assert contrast(colour, theme.background) >= 3.0, colour


def test_figures_send_nothing_anywhere() -> None:
    assert CONFIG["showSendToCloud"] is False
    assert CONFIG["displaylogo"] is False


def test_the_page_shows_through_and_text_has_the_ink_of_the_theme() -> None:
    for theme in (LIGHT, DARK):
        looks = blank(theme, title="any").layout.template.layout
        assert looks.paper_bgcolor == looks.plot_bgcolor == "rgba(0,0,0,0)"
        assert looks.font.color == theme.ink


def test_panels_without_content_are_hidden() -> None:
    figure = panels(LIGHT, 4)
    assert place_of(3, 4) == {"row": 2, "col": 1}
    assert [axis.visible for axis in figure.select_xaxes()].count(False) == 2


def test_users_text_is_no_markup(runs: list[Run]) -> None:
    hostile = "<a href='javascript:x'>&lt;b>"
    assert plain(hostile) == "&lt;a href='javascript:x'&gt;&amp;lt;b&gt;"
    measurement = replace(runs[0].file.measurement, name="<i>run</i>.csv")
    run = Run("<b>mine</b> %{x}", replace(runs[0].file, measurement=measurement))
    figure = overlay([run], SIGNAL)
    names = [trace.name for trace in figure.data]
    assert figure.layout.title.text == "&lt;i&gt;run&lt;/i&gt;.csv"
    assert not any("<" in text for text in (*names, *(trace.meta for trace in figure.data[:2])))
    assert not any("mine" in trace.hovertemplate for trace in figure.data)  # %{x} is a command
    assert any("&lt;b&gt;mine" in name for name in names)


def test_long_words_are_not_torn_where_lines_break() -> None:
    assert broken("with coulomb friction and &lt;play&gt;", 16).split("<br>") == [
        "with coulomb",
        "friction and",
        "&lt;play&gt;",
    ]


def test_a_tolerance_lies_about_the_errors_in_their_unit(runs: list[Run]) -> None:
    figure = overlay(runs, SIGNAL, tolerance=0.002)
    lines = [shape for shape in figure.layout.shapes if shape.type == "line"]
    assert [(line.yref, line.y0, line.y1) for line in lines] == [
        ("y2", 2.0, 2.0),
        ("y2", -2.0, -2.0),
    ]
    assert [line.name for line in lines if line.showlegend] == ["tolerance ± 2.00 mrad"]


@pytest.mark.parametrize("theme", THEMES.values(), ids=list(THEMES))
def test_each_run_has_a_curve_and_an_error(runs: list[Run], theme: Theme) -> None:
    figure = overlay(runs, SIGNAL, theme=theme)
    upper = [trace for trace in figure.data if trace.yaxis != "y2"]
    lower = [trace for trace in figure.data if trace.yaxis == "y2"]
    assert [trace.line.color for trace in upper] == [theme.measured, theme.before, theme.after]
    assert [trace.line.dash == "solid" for trace in lower] == [False, True]
    assert upper[0].line.width > upper[1].line.width
    largest = 1e3 * max(runs[0].file.signals[SIGNAL].max_abs, 0.0)
    assert np.max(np.abs(lower[0].y)) == pytest.approx(largest)
    assert figure.layout.xaxis.title.text == "time (s)"
    assert figure.layout.yaxis.title.text == "joint position<br>(rad)"
    assert figure.layout.yaxis2.title.text == "error (mrad)"


def test_a_model_alone_keeps_the_colour_it_has_beside_others(runs: list[Run]) -> None:
    alone = overlay([replace(runs[1], colour=1)], SIGNAL)
    beside = overlay(runs, SIGNAL)
    assert alone.data[1].line.color == beside.data[3].line.color == LIGHT.after
    assert alone.data[1].line.dash == "solid"


def test_the_band_is_two_standard_deviations_of_the_noise(runs: list[Run]) -> None:
    sigma = runs[0].file.signals[SIGNAL].noise.sigma
    band = overlay(runs, SIGNAL).layout.shapes[0]
    assert (band.y0, band.y1) == pytest.approx((-2e3 * sigma, 2e3 * sigma))
    assert band.yref == "y2"


def with_peak(run: Run, index: int) -> Run:
    """The same run 40 times as long, with a peak in one measured sample."""
    file, measurement = run.file, run.file.measurement
    n = 40 * len(measurement.time)
    values = np.tile(measurement.signals[SIGNAL], 40)
    values[index] = 9.0
    time = 1e-3 * np.arange(n)
    longer = replace(
        measurement,
        time=time,
        motor_position=np.zeros(n),
        load_torque=None,
        signals={SIGNAL: values},
    )
    tiled = {
        name: np.tile(getattr(file.trajectory, name), (40, 1)) for name in ("states", "outputs")
    }
    return replace(
        run,
        file=replace(
            file, measurement=longer, trajectory=replace(file.trajectory, time=time, **tiled)
        ),
    )


def test_a_window_keeps_its_peaks_and_is_drawn_finely(runs: list[Run]) -> None:
    run = with_peak(runs[0], 100_003)
    whole = overlay([run], SIGNAL)
    part = overlay([run], SIGNAL, window=(100.0, 100.5))
    for figure in (whole, part):
        assert np.max(figure.data[0].y) == 9.0
        assert len(figure.data[0].x) <= 3002
    assert tuple(part.layout.xaxis.range) == (100.0, 100.5)
    time = np.asarray(part.data[0].x)
    assert time[0] < 100.0
    assert time[-1] > 100.5
    assert len(time) == 503  # every sample, and one more at each end
    assert np.max(overlay([run], SIGNAL, window=(0.0, 50.0)).data[0].y) < 9.0


def test_fewer_buckets_make_fewer_points(runs: list[Run]) -> None:
    assert len(overlay(runs, SIGNAL, buckets=100).data[0].x) <= 202


def test_a_window_beyond_the_recording_is_empty_but_drawn(runs: list[Run]) -> None:
    figure = overlay(runs, SIGNAL, window=(50.0, 60.0))
    assert tuple(figure.layout.xaxis.range) == (50.0, 60.0)
    assert len(figure.data[0].x) <= 1


def test_zoom_outlives_a_redraw_of_the_same_recording(runs: list[Run]) -> None:
    first = overlay(runs, SIGNAL).layout
    again = overlay(runs[:1], SIGNAL, theme=DARK, cursors=(1.0,)).layout
    assert first.uirevision == again.uirevision is not None
    assert first.yaxis.uirevision == again.yaxis.uirevision
    another = replace(runs[0].file.measurement, name="other.csv")
    changed = overlay([Run("as given", replace(runs[0].file, measurement=another))], SIGNAL).layout
    assert changed.xaxis.uirevision != first.xaxis.uirevision


def test_chosen_samples_are_one_shape(runs: list[Run]) -> None:
    time = runs[0].file.measurement.time
    chosen = (time > 1.0) & (time < 2.0) | (time > 5.0)
    shapes = overlay(runs, SIGNAL, highlighted=chosen).layout.shapes
    paths = [shape.path for shape in shapes if shape.type == "path"]
    assert [path.count("M") for path in paths] == [2]
    inside = overlay(runs, SIGNAL, highlighted=chosen, window=(1.2, 1.4)).layout.shapes
    assert [shape.path.count("M") for shape in inside if shape.type == "path"] == [1]
    nothing = overlay(runs, SIGNAL, highlighted=np.zeros(len(time), dtype=bool)).layout.shapes
    assert not any(shape.type == "path" for shape in nothing)


def test_stretches_reach_half_way_to_the_next_sample() -> None:
    time = np.arange(6.0)
    chosen = np.array([True, False, True, True, False, True])
    assert stretches(time, chosen) == [(0.0, 0.5), (1.5, 3.5), (4.5, 5.0)]


def test_too_many_stretches_are_joined_where_they_are_closest() -> None:
    time = np.arange(12.0)
    chosen = np.array([1, 0, 1, 0, 0, 0, 1, 0, 1, 0, 0, 1], dtype=bool)
    assert stretches(time, chosen, 3) == [(0.0, 2.5), (5.5, 8.5), (10.5, 11.0)]
    assert stretches(time, chosen, 1) == [(0.0, 11.0)]
    many = np.arange(100_000) % 2 == 0
    assert len(stretches(np.arange(100_000.0), many)) == 400


def test_cursors_are_lines_with_letters(runs: list[Run]) -> None:
    layout = overlay(runs, SIGNAL, cursors=(1.0, 2.5)).layout
    assert [(each.text, each.x) for each in layout.annotations] == [("A", 1.0), ("B", 2.5)]
    assert [shape.x0 for shape in layout.shapes if shape.type == "line"] == [1.0, 2.5]


def test_values_at_a_cursor_are_those_of_the_nearest_sample(runs: list[Run]) -> None:
    measurement = runs[0].file.measurement
    time = measurement.time
    for wanted, index in ((time[7] + 0.4 * (time[8] - time[7]), 7), (-5.0, 0), (99.0, -1)):
        found = values_at(runs, SIGNAL, wanted)
        assert found.time == time[index]
        assert found.index == range(len(time))[index]
        assert dict(found.values) == {
            "measured": measurement.signals[SIGNAL][index],
            "as given": runs[0].simulated(SIGNAL)[index],
            "with friction": runs[1].simulated(SIGNAL)[index],
        }


def test_a_static_curve_is_torque_over_deflection(curve: Run) -> None:
    chosen = curve.file.measurement.signals[SIGNAL] > 0.1
    figure = overlay([curve], SIGNAL, highlighted=chosen, window=(0.0, 1.0), cursors=(0.5,))
    assert figure.layout.xaxis.title.text == "deflection (rad)"
    assert figure.layout.yaxis.title.text == "joint torque<br>(N·m)"
    assert figure.layout.yaxis2.title.text == "error (mrad)"
    assert figure.layout.xaxis.range is None
    assert not figure.layout.annotations
    assert len(figure.data[-1].x) == np.count_nonzero(chosen)
    assert np.array_equal(figure.data[0].y, -curve.file.measurement.load_torque)


def test_what_is_not_selected_is_nearly_covered(runs: list[Run]) -> None:
    file = runs[0].file
    chosen = (file.measurement.time >= 3.0) & (file.measurement.time <= 5.0)
    faint = Run("as given", replace(file, selection=Selection((), chosen)))
    (veil,) = [shape for shape in overlay([faint], SIGNAL).layout.shapes if shape.layer == "above"]
    edges = [float(edge) for edge in re.findall(r"[MH](-?[\d.]+)", veil.path)]
    assert edges == pytest.approx([0.0, 3.0, 5.0, 9.998], abs=0.002)
    assert veil.fillcolor == LIGHT.background
    assert 0.5 < veil.opacity < 1.0


def test_samples_of_a_curve_that_are_not_selected_are_faint(curve: Run) -> None:
    chosen = np.arange(300) < 100
    faint = Run("as given", replace(curve.file, selection=Selection((), chosen)))
    opacity = np.asarray(overlay([faint], SIGNAL).data[0].marker.opacity)
    assert np.all(opacity[chosen] == 1.0)
    assert np.all(opacity[~chosen] < 0.5)
