"""Figures of where a model fails: their numbers are the location's, and each part its samples."""

from dataclasses import replace

import numpy as np
import pytest

from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.actuator.transmission import slack_boundaries
from elastic_tendon.comparison import averaging
from elastic_tendon.comparison.bins import Bin
from elastic_tendon.comparison.compare import compare
from elastic_tendon.comparison.comparison import Comparison
from elastic_tendon.comparison.locate import FileLocation, Location, locate
from elastic_tendon.comparison.selection import only_where
from elastic_tendon.demo import DATA
from elastic_tendon.measurement import Measurement, read_measurement
from elastic_tendon.reports.comparison_figures import FAINT
from elastic_tendon.reports.interactive.correlation import residual_correlation
from elastic_tendon.reports.interactive.data import figure_table
from elastic_tendon.reports.interactive.loop import DOTS, torque_loop, torque_words
from elastic_tendon.reports.interactive.overlay import Run, overlay
from elastic_tendon.reports.interactive.places import error_maps, samples_of, shares
from elastic_tendon.reports.interactive.theme import DARK, LIGHT, THEMES, Theme, blank
from elastic_tendon.reports.interactive.torque import missing_torque
from elastic_tendon.simulation.excitation import default_excitation
from elastic_tendon.simulation.simulate import simulate

Compared = tuple[Comparison, Location]
SIGNAL = "joint_position"
themes = pytest.mark.parametrize("theme", THEMES.values(), ids=list(THEMES))


@pytest.fixture(scope="module")
def demo() -> Compared:
    model = load_model(DATA / "demo_model.toml")
    comparison = compare(model, [read_measurement(str(DATA / "demo_fit.csv"))])
    return comparison, locate(comparison)


@pytest.fixture(scope="module")
def static() -> Compared:
    """A slow sweep of a machine with friction."""
    model = load_model("figure_8")
    excitation = default_excitation(model)
    torque = 3.0 * np.sin(np.linspace(0.0, 6.0, 300))
    machine = model.with_effect("coulomb_friction", {"torque": 0.3})
    time = np.linspace(excitation.time[0], excitation.time[-1], 300)
    positions = simulate(machine, time, np.zeros(300), torque)[SIGNAL]
    noise = 1e-4 * np.random.default_rng(6).standard_normal(300)
    rows = 1000.0 * np.arange(300)
    curve = Measurement(
        rows,
        np.zeros(300),
        {SIGNAL: positions + noise},
        torque,
        static=True,
        name="<b>curve</b>.csv",
    )
    comparison = compare(model, [curve])
    return comparison, locate(comparison)


def expect_titles(figure) -> None:
    """Every visible axis says what it shows; units stand in brackets, names have none."""
    for axis in (*figure.select_xaxes(), *figure.select_yaxes()):
        if axis.visible is not False:
            assert "(" in axis.title.text or axis.title.text in {"slack state", "velocity sign"}


def expect_svg(figure) -> None:
    """No trace needs WebGL, which needs evaluation of strings."""
    assert not [trace.type for trace in figure.data if trace.type.endswith("gl")]


@themes
def test_every_figure_is_labelled_and_of_its_theme(demo: Compared, theme: Theme) -> None:
    comparison, location = demo
    file, found = comparison.files[0], location.files[0]
    figures = (
        torque_loop(comparison.model, file, found, theme=theme),
        error_maps(file, found, theme=theme),
        shares(file, found, SIGNAL, theme=theme),
        missing_torque(file, found, theme=theme),
    )
    for figure in figures:
        expect_titles(figure)
        expect_svg(figure)
        assert figure.layout.template.layout.font.color == theme.ink
        assert figure.layout.title.text.startswith("demo_fit.csv")


def test_a_static_curve_has_its_loop_bars_and_torque(static: Compared) -> None:
    comparison, location = static
    file, found = comparison.files[0], location.files[0]
    for figure in (
        torque_loop(comparison.model, file, found),
        shares(file, found, SIGNAL),
        missing_torque(file, found),
    ):
        expect_titles(figure)
        assert "<b>" not in figure.layout.title.text


# ---- loop ----------------------------------------------------------------------------------


def test_the_loop_shows_states_springs_and_boundaries(demo: Compared) -> None:
    comparison, location = demo
    figure = torque_loop(comparison.model, comparison.files[0], location.files[0])
    states = [trace for trace in figure.data if trace.mode == "markers"]
    assert [trace.name[:3].strip(" ,") for trace in states] == ["I", "II", "III"]
    assert len({trace.marker.symbol for trace in states}) == 3
    low, high = slack_boundaries(comparison.model.transmission)
    assert np.max(states[0].x) <= low <= np.min(states[2].x)
    assert np.max(states[2].x) <= high <= np.min(states[1].x)
    assert {shape.x0 for shape in figure.layout.shapes} == {low, high}
    assert sum(len(trace.x) for trace in states) <= DOTS + 3


def test_the_loop_of_a_window_holds_its_samples_only(demo: Compared) -> None:
    comparison, location = demo
    file = comparison.files[0]
    figure = torque_loop(comparison.model, file, location.files[0], window=(2.0, 3.0))
    times = np.concatenate([trace.customdata for trace in figure.data if trace.mode == "markers"])
    recorded = file.measurement.time
    assert np.array_equal(np.sort(times), recorded[(recorded >= 2.0) & (recorded <= 3.0)])


def test_the_loop_draws_samples_faint_that_are_not_selected(demo: Compared) -> None:
    comparison, location = demo
    (file,) = only_where(replace(comparison, files=comparison.files[:1]), ["time=2..3"]).files
    assert file.selection is not None
    figure = torque_loop(comparison.model, file, location.files[0], dots=10**6)
    dots = [trace for trace in figure.data if trace.mode == "markers"]
    opacity = np.concatenate([trace.marker.opacity for trace in dots])
    times = np.concatenate([trace.customdata for trace in dots])
    assert np.array_equal(opacity == 1.0, (times >= 2.0) & (times <= 3.0))
    faint, whole = [trace for trace in figure.data if trace.name == "simulated"]
    assert faint.opacity == FAINT
    selected = file.trajectory["deflection"][file.selection.chosen]
    drawn = whole.x[np.isfinite(whole.x)]
    ends = pytest.approx((selected.min(), selected.max()), abs=0.01 * np.ptp(selected))
    assert (drawn.min(), drawn.max()) == ends


def test_a_torque_that_nobody_measured_is_called_estimated(
    demo: Compared, static: Compared
) -> None:
    for (comparison, location), words, sentence in (
        (demo, "estimated", "No torque was measured: "),
        (static, "measured", "The torque is the measured one."),
    ):
        shows = comparison.model, comparison.files[0], location.files[0]
        assert torque_loop(*shows).layout.yaxis.title.text == f"{words} torque (N·m)"
        assert torque_words(shows[1].measurement).startswith(sentence)


# ---- samples of bars and cells -------------------------------------------------------------


def wrong_counts(found: FileLocation) -> list[Bin]:
    """Bins that hold not as many samples as they say; those of the frequency hold none."""
    return [
        bin_
        for bin_ in found.bins[SIGNAL]
        if np.count_nonzero(samples_of(found, (bin_.by, bin_.bin)))
        != (0 if bin_.by == "frequency" else bin_.count)
    ]


def test_bins_find_their_samples(demo: Compared) -> None:
    comparison, location = demo
    found = location.files[0]
    assert wrong_counts(found) == []
    velocity = found.variables["joint_velocity"]
    assert np.min(velocity[samples_of(found, ("velocity_sign", "positive"))]) > 0.0
    part = next(bin_ for bin_ in found.bins[SIGNAL] if bin_.by == "time")
    time = comparison.files[0].measurement.time[samples_of(found, (part.by, part.bin))]
    assert part.lower <= np.min(time) <= np.max(time) < part.upper


def test_bins_of_a_static_curve_find_their_samples(static: Compared) -> None:
    assert wrong_counts(static[1].files[0]) == []


def test_bins_of_a_long_recording_find_their_samples(
    demo: Compared, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(averaging, "LONG", 700)  # so the demo is analysed in blocks of 8
    comparison, _ = demo
    assert wrong_counts(locate(comparison).files[0]) == []


def test_every_bar_names_its_bin(demo: Compared) -> None:
    comparison, location = demo
    found = location.files[0]
    figure = shares(comparison.files[0], found, SIGNAL)
    bars = [trace for trace in figure.data if trace.type == "bar"]
    known = {(bin_.by, bin_.bin): bin_ for bin_ in found.bins[SIGNAL]}
    for trace in bars:
        for mark, height, place in zip(trace.customdata, trace.y, trace.x, strict=True):
            file = known[tuple(mark)]
            assert height == pytest.approx(100.0 * file.share)
            assert place == file.bin
            assert trace.marker.color == (LIGHT.stands_out if file.stands_out else LIGHT.quiet)
    assert sum(len(trace.x) for trace in bars) == len(known)
    assert {trace.name for trace in figure.data if trace.showlegend} == {
        "squared error, stands out",
        "squared error, does not stand out",
        "samples",
    }


def test_every_cell_names_its_samples(demo: Compared) -> None:
    comparison, location = demo
    file, found = comparison.files[0], location.files[0]
    error = 1e3 * (file.trajectory[SIGNAL] - file.measurement.signals[SIGNAL])
    wanted = (error**2, found.missing_torque.torque)
    figure = error_maps(file, found, theme=DARK)
    assert len(figure.data) == 4
    for trace, values, root in zip(figure.data, wanted * 2, (True, False) * 2, strict=True):
        filled = [cell for row in trace.customdata for cell in row if cell is not None]
        assert len(filled) == np.count_nonzero(np.isfinite(trace.z))
        for _, _, column, row in filled[::9]:
            chosen = samples_of(found, trace.customdata[row][column])
            mean = np.mean(values[chosen])
            assert trace.z[row][column] == pytest.approx(np.sqrt(mean) if root else mean)


def test_a_mark_of_something_else_is_refused(demo: Compared) -> None:
    found = demo[1].files[0]
    with pytest.raises(ValueError, match="unpack"):
        samples_of(found, ("a", "b", "c"))
    with pytest.raises(KeyError):
        samples_of(found, ("nothing", "time", 0, 0))
    assert not samples_of(found, ("nothing", "at all")).any()


# ---- missing torque and tables -------------------------------------------------------------


def test_the_missing_torque_lies_within_its_band(demo: Compared) -> None:
    comparison, location = demo
    found = location.files[0]
    figure = missing_torque(comparison.files[0], found)
    means = [trace for trace in figure.data if trace.name == "mean"]
    bands = [trace for trace in figure.data if trace.fill == "toself"]
    for curve, mean, band in zip(found.missing_torque.curves, means, bands, strict=True):
        count = len(curve.centre)
        assert np.array_equal(mean.y, curve.mean)
        assert np.all(band.y[:count] <= mean.y)
        assert np.all(band.y[count:][::-1] >= mean.y)


def test_a_table_holds_what_an_overlay_shows(demo: Compared) -> None:
    file = demo[0].files[0]
    measurement = replace(file.measurement, name="a & b.csv")
    figure = overlay([Run("<mine>", replace(file, measurement=measurement))], SIGNAL)
    table = figure_table(figure)
    columns = ["curve", "time (s)", "joint position (rad)", "error (mrad)"]
    assert list(table.columns) == columns
    assert set(table["curve"].str.split(":").str[0]) == {"measured", "<mine>", "error, <mine>"}
    measured = table[table["curve"] == "measured"]
    assert np.array_equal(measured["joint position (rad)"], figure.data[0].y)
    assert measured["error (mrad)"].isna().all()


def test_tables_of_bars_and_maps_hold_words_and_cells(demo: Compared) -> None:
    comparison, location = demo
    file, found = comparison.files[0], location.files[0]
    bars = figure_table(shares(file, found, SIGNAL))
    assert {"I", "II", "III"} == {words.split(":")[0] for words in bars["slack state"].dropna()}
    assert "share of all (%)" in bars
    cells = figure_table(error_maps(file, found))
    assert {"deflection (rad)", "time (s)", "mean missing torque (N·m)"} <= set(cells.columns)
    values = cells["RMS error, joint position (mrad)"].dropna()
    assert np.max(values) == pytest.approx(np.nanmax(error_maps(file, found).data[0].z))


def test_a_table_has_the_words_below_an_axis() -> None:
    figure = blank(LIGHT)
    figure.add_scatter(x=[0, 1], y=[2.0, 3.0], name="error")
    figure.update_xaxes(tickvals=[0, 1], ticktext=["as given", "with<br>play &amp; more"])
    figure.update_yaxes(title="error (mrad)")
    table = figure_table(figure)
    assert list(table["name"]) == ["as given", "with play & more"]
    assert list(table["error (mrad)"]) == [2.0, 3.0]
    assert figure_table(blank(LIGHT)).empty


def test_table_of_a_figure_whose_ticks_are_numbers():
    figure = blank(LIGHT, xaxis={"title": {"text": "probability (%)"}, "tickvals": [0, 50, 100]})
    figure.add_bar(x=[50, 7], y=["friction", "none"], orientation="h")
    table = figure_table(figure)
    assert list(table["probability (%)"]) == [50, 7]
    assert list(table["name"]) == ["friction", "none"]


# ---- correlation of the residual -----------------------------------------------------------


@themes
def test_every_correlation_of_the_residual_is_drawn_in_its_band(
    demo: Compared, theme: Theme
) -> None:
    location = demo[1].files[0]
    every = location.correlations[SIGNAL]
    figure = residual_correlation(location, SIGNAL, theme=theme)
    expect_titles(figure)
    bands, curves = figure.data[::2], figure.data[1::2]
    for found, band, curve in zip(every, bands, curves, strict=True):
        assert curve.y == pytest.approx(found.values)
        low, high = np.split(np.asarray(band.y), 2)
        assert low == pytest.approx(found.expected - found.bound)
        assert high[::-1] == pytest.approx(found.expected + found.bound)
    headings = [one.text for one in figure.layout.annotations]
    assert headings[:2] == ["with itself", "with the motor position"]
    # what is saved tells the curves apart
    assert set(headings) < set(figure_table(figure)["curve"])


def test_a_static_curve_has_no_correlations(static: Compared) -> None:
    assert static[1].files[0].correlations == {}
