"""What Compare and Where look at, and what they say of it, without a browser."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from elastic_tendon import demo
from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.app import results, sliders
from elastic_tendon.app.document import Source, Version, new_document
from elastic_tendon.app.filters import ALL, conditions
from elastic_tendon.app.readings import (
    NO_CURSORS,
    beyond,
    chosen_samples,
    chosen_words,
    cursor_rows,
    decimals,
    error_heads,
    error_rows,
    strongest_bins,
    with_cursor,
)
from elastic_tendon.app.redrawing import BUCKETS, moved_curves
from elastic_tendon.app.results import Compared
from elastic_tendon.app.sliders import LABEL, moved_runs, moved_words
from elastic_tendon.app.steps import compare as step
from elastic_tendon.app.tables import Exact
from elastic_tendon.app.view import (
    SIGNAL,
    View,
    before_of,
    compared_now,
    fingerprint,
    located_heldout,
    location_of,
    recording_options,
    recordings,
    runs_of,
    signal_options,
    view_of,
    while_waiting,
)
from elastic_tendon.app.workspace import Failure, Session
from elastic_tendon.comparison.compare import compare
from elastic_tendon.comparison.conditions import parse_condition
from elastic_tendon.comparison.locate import FileLocation
from elastic_tendon.comparison.maps import CELLS
from elastic_tendon.comparison.residuals import rms
from elastic_tendon.errors import MeasurementError
from elastic_tendon.reports.comparison_tables import bin_cells, sample_shares
from elastic_tendon.reports.interactive.loop import torque_loop
from elastic_tendon.reports.interactive.overlay import Run, overlay
from elastic_tendon.reports.interactive.theme import THEMES
from elastic_tendon.reports.units import number, shown


def copied(cell: str | Exact) -> float:
    """The number that is copied from a cell."""
    assert isinstance(cell, Exact)
    return float(cell.text)


def quiet(_text: str, _share: float) -> None:
    """Nobody watches."""


@pytest.fixture(scope="module")
def session() -> Iterator[Session]:
    """The demo, one step beyond the model as given, everything computed."""
    model = load_model(str(demo.DATA / "demo_model.toml"))
    sources = [
        Source(key="fit", name="fit.csv", window=(0.0, 4.0)),
        Source(key="hold", name="<b>hold</b>.csv", role="validate", window=(0.0, 2.0)),
    ]
    files: dict[str, Path] = {
        "fit": demo.DATA / "demo_fit.csv",
        "hold": demo.DATA / "demo_validate.csv",
    }
    heavier = model.with_values({"link.inertia": 1.1 * model.link.inertia})
    document = new_document(model, sources).adding(
        Version(id="", parent="1", title="heavier", model=heavier.to_toml())
    )
    made = Session("0", document, files)
    for version in document.versions:
        made.cache.obtain(results.compared(document, version, files), quiet)
    made.cache.obtain(results.located(document, document.version, files), quiet)
    made.cache.obtain(located_heldout(document, document.version, files), quiet)
    return made


@pytest.fixture(scope="module")
def found(session: Session) -> Compared:
    now = compared_now(session)
    assert now is not None
    return now


@pytest.fixture(scope="module")
def runs(session: Session, found: Compared) -> tuple[Run, ...]:
    return runs_of(session, view_of(None, found))


@pytest.fixture(scope="module")
def location(session: Session, found: Compared) -> FileLocation:
    there = location_of(session, view_of(None, found))
    assert there is not None
    return there


# ---- what is looked at ---------------------------------------------------------------------


def test_the_first_recording_is_looked_at_until_another_is_chosen(found: Compared) -> None:
    assert view_of(None, found) == View("fitted 0", SIGNAL)
    chosen = View("held out 0", SIGNAL, before=False)
    assert view_of(chosen.stored(), found) == chosen


def test_what_is_no_longer_there_is_not_looked_at(found: Compared) -> None:
    gone = View("fitted 7", "motor_torque")
    assert view_of(gone.stored(), found) == View("fitted 0", SIGNAL)


def test_recordings_held_out_are_told_apart(found: Compared) -> None:
    labels = [option["label"] for option in recording_options(found)]
    assert [label.rsplit(" (", 1)[1] for label in labels] == ["fitted)", "held out)"]
    assert len(recording_options(found, fitted_only=True)) == 1


def test_signals_are_offered_with_their_units(found: Compared) -> None:
    options = signal_options(recordings(found)["fitted 0"])
    assert {"value": SIGNAL, "label": "joint position (rad)"} in options


def test_the_model_as_given_stands_before_the_current_version(
    session: Session, runs: tuple[Run, ...], found: Compared
) -> None:
    assert [run.label for run in runs] == ["as given", "heavier"]
    alone = runs_of(session, replace(view_of(None, found), before=False))
    assert [run.label for run in alone] == ["heavier"]
    assert alone[0].colour == runs[1].colour != runs[0].colour


@pytest.mark.parametrize(
    ("asked", "follows"),
    [
        ((ALL, ALL, ALL, 1.0, None), []),
        (
            ("slack_state=I", "joint_velocity>0", ALL, 3.0, 5.0),
            ["slack_state=I", "joint_velocity>0"],
        ),
        ((ALL, ALL, "time", 3.0, 5), ["time=3..5"]),
        ((ALL, ALL, "deflection", -0.1, ""), ["deflection>=-0.1"]),
        ((ALL, ALL, "deflection", None, 1e-3), ["deflection<=0.001"]),
    ],
)
def test_conditions_follow_from_the_fields(asked: tuple[Any, ...], follows: list[str]) -> None:
    assert conditions(*asked) == follows
    assert [parse_condition(text).text for text in follows] == follows


def test_all_models_are_compared_over_the_same_samples(session: Session, found: Compared) -> None:
    """Each would put the ends of the slack states elsewhere."""
    chosen = runs_of(session, view_of(None, found), ["slack_state=III", "time<3"])
    selections = [run.file.selection for run in chosen]
    assert len(selections) == 2
    assert selections[0] is selections[1]
    counts = {run.file.signals[SIGNAL].count for run in chosen}
    assert len(counts) == 1
    assert 0 < counts.pop() < len(chosen[0].file.measurement.time)
    with pytest.raises(MeasurementError, match=r"no sample of fit\.csv"):
        runs_of(session, view_of(None, found), ["time>99"])


def test_a_model_as_given_has_nothing_before_it(session: Session) -> None:
    assert before_of(session.document.at("1")) is None
    root = before_of(session.document)
    assert root is not None
    assert root.id == "1"


def test_a_held_out_recording_is_located_too(session: Session, found: Compared) -> None:
    there = location_of(session, View("held out 0", SIGNAL))
    assert there is not None
    time = recordings(found)["held out 0"].measurement.time
    assert len(there.missing_torque.torque) == len(time)


def test_sliders_make_a_model_beside_the_same_samples(session: Session, found: Compared) -> None:
    version = session.document.version
    (run,) = runs_of(session, replace(view_of(None, found), before=False), ["time<3"])
    values = {"link.inertia": 0.02}
    held = {"of": version.mark, "values": values}
    (moved,), fault = moved_runs(version, run.file, held)
    assert moved_runs(version, run.file, held)[0][0] is moved  # simulated once
    (again,), _ = moved_runs(version, replace(run.file), held)
    assert again is not moved
    alone = compare(version.loaded().with_values(values), run.file.measurement.window(None, 3.0))
    assert fault == ""
    assert moved.file.selection is run.file.selection
    rmse = moved.file.signals[SIGNAL].rmse
    assert rmse == pytest.approx(alone.files[0].signals[SIGNAL].rmse, rel=0.01)
    words = moved_words(version, [run], [moved], SIGNAL)
    assert f"{shown(SIGNAL).error(rmse)} with the sliders" in words


def test_sliders_simulate_what_is_seen_of_a_long_recording(
    session: Session, found: Compared, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sliders, "LONGEST", 500)
    version = session.document.version
    (run,) = runs_of(session, replace(view_of(None, found), before=False))
    held = {"of": version.mark, "values": {"link.inertia": 0.02}}
    (moved,), _ = moved_runs(version, run.file, held, (2.0, 3.0))
    time, seen = run.file.measurement.time, moved.file.measurement.time
    np.testing.assert_array_equal(seen, time[time >= 2.0][:500])
    words = moved_words(version, [run], [moved], SIGNAL)
    before = rms(run.error(SIGNAL)[np.isin(time, seen)])
    assert f"{shown(SIGNAL).error(before)} with the model's values" in words
    assert f"from {seen[0]:.4g} s to {seen[-1]:.4g} s" in words
    # curves and readings are where it was simulated
    curve = next(part for part in overlay([run, moved], SIGNAL).data if LABEL in (part.name or ""))
    assert (curve.x[0], curve.x[-1]) == (seen[0], seen[-1])
    values = {row[0]: row[1:3] for row in cursor_rows([run, moved], SIGNAL, {"A": 1.0, "B": 2.1})}
    outside, inside = values[f"{LABEL} (rad)"]
    assert outside == "–"
    assert inside != "–"


def test_a_move_changes_two_curves_and_nothing_else(
    session: Session, runs: tuple[Run, ...]
) -> None:
    version = session.document.version
    places = [{"of": version.mark, "values": {"link.inertia": value}} for value in (0.02, 0.025)]
    moved = [moved_runs(version, runs[-1].file, held)[0][0] for held in places]
    drawn, wanted = (overlay([*runs, run], SIGNAL, buckets=BUCKETS).to_dict() for run in moved)
    curves, first = moved_curves(moved[-1], SIGNAL, None), 1 + step.CURVES * len(runs)
    for change in step.moved_only(curves, first).to_plotly_json()["operations"]:
        assert change["operation"] == "Assign"
        part, index, name = change["location"]
        drawn[part][index][name] = change["params"]["value"]
    assert drawn == wanted


def test_sliders_of_another_model_move_nothing(session: Session, runs: tuple[Run, ...]) -> None:
    version = session.document.version
    held = {"of": session.document.find("1").mark, "values": {"link.inertia": 0.02}}
    assert moved_runs(version, runs[-1].file, held) == ((), "")
    assert moved_runs(version, runs[-1].file, None) == ((), "")


def test_what_no_model_can_have_is_told(session: Session, runs: tuple[Run, ...]) -> None:
    version = session.document.version
    moved, fault = moved_runs(
        version, runs[-1].file, {"of": version.mark, "values": {"link.inertia": -1.0}}
    )
    assert moved == ()
    assert "inertia" in fault


def test_before_anything_is_computed_nothing_is_shown(session: Session, found: Compared) -> None:
    empty = Session("1", session.document, session.files)
    assert compared_now(empty) is None
    assert runs_of(empty, view_of(None, found)) == ()
    assert location_of(empty, view_of(None, found)) is None


def test_what_failed_is_not_waited_for(session: Session) -> None:
    fresh = Session("2", session.document, session.files)
    needed = results.compared(fresh.document, fresh.document.version, fresh.files)
    assert while_waiting(fresh, [needed], "Comparing…") == "Comparing…"
    fresh.cache.put(needed, Failure("the file has no rows"))
    assert while_waiting(fresh, [needed], "Comparing…") == ""


def test_a_figure_is_drawn_again_when_what_it_shows_comes_or_changes(session: Session) -> None:
    fresh = Session("3", session.document, session.files)
    needed = results.compared(session.document, session.document.version, session.files)
    assert fingerprint(session, [needed], "light") == fingerprint(session, [needed], "light")
    assert fingerprint(session, [needed], "light") != fingerprint(session, [needed], "dark")
    assert fingerprint(session, [needed], "light") != fingerprint(fresh, [needed], "light")


def test_a_zoom_comes_back_to_a_loop_that_was_drawn(
    session: Session, found: Compared, location: FileLocation, monkeypatch
) -> None:
    drawn: list[object] = []

    def draw(*given: object, **look: object) -> object:
        drawn.append(look["window"])
        return torque_loop(*given, **look)

    monkeypatch.setattr(step, "torque_loop", draw)
    file = found.fitted.files[0]
    whole, part, again = (
        step.loop_figure(session, file, location, theme=THEMES["light"], window=window, key=key)
        for window, key in ((None, "whole"), ((1.0, 2.0), "part"), (None, "whole"))
    )
    assert drawn == [None, (1.0, 2.0)]
    assert again == whole
    assert part != whole


# ---- zoom and cursors ----------------------------------------------------------------------


def test_the_ends_of_a_zoom_tell_samples_apart() -> None:
    assert decimals(0.002 * np.arange(9.0)) == 3
    assert decimals(1e-4 * np.arange(9.0)) == 4
    assert decimals(3e-5 * np.arange(9.0)) == 5
    assert decimals(10.0 * np.arange(9.0)) == 3


def test_samples_lie_beyond_a_zoom_only_where_none_is_within() -> None:
    time = np.arange(10.0)
    chosen = (time == 2.0) | (time == 7.0)
    assert beyond(chosen, time, (3.0, 6.0))
    assert not beyond(chosen, time, (3.0, 7.0))
    assert not beyond(chosen, time, None)
    assert not beyond(np.zeros(10, dtype=np.bool_), time, (3.0, 6.0))


def test_clicks_set_the_cursors_in_turn() -> None:
    first = with_cursor(NO_CURSORS, 1.0)
    second = with_cursor(first, 2.0)
    third = with_cursor(second, 3.0)
    fourth = with_cursor(third, 4.0)
    assert [first["A"], first["B"]] == [1.0, None]
    assert [second["A"], second["B"]] == [1.0, 2.0]
    assert [third["A"], third["B"]] == [3.0, 2.0]
    assert [fourth["A"], fourth["B"]] == [3.0, 4.0]


def test_readings_are_those_of_the_nearest_samples(runs: tuple[Run, ...]) -> None:
    file = runs[-1].file
    time, measured = file.measurement.time, file.measurement.signals[SIGNAL]
    a, b = 100, 700
    rows = cursor_rows(runs, SIGNAL, {"A": float(time[a]) + 1e-4, "B": float(time[b])})
    heads = [row[0] for row in rows]
    assert heads[:2] == ["time (s)", "measured (rad)"]
    assert heads[-2:] == ["error, as given (mrad)", "error, heavier (mrad)"]
    assert copied(rows[0][3]) == time[b] - time[a]
    assert copied(rows[1][1]) == measured[a]
    error = runs[-1].error(SIGNAL)
    assert copied(rows[-1][3]) == pytest.approx(1e3 * (error[b] - error[a]), rel=1e-12)


def test_one_cursor_has_no_difference(runs: tuple[Run, ...]) -> None:
    rows = cursor_rows(runs, SIGNAL, {"A": None, "B": 1.0})
    assert all(row[1] == "–" and isinstance(row[2], Exact) and row[3] == "–" for row in rows)
    assert cursor_rows(runs, SIGNAL, NO_CURSORS) == []


# ---- errors --------------------------------------------------------------------------------


def test_the_table_of_errors_begins_with_both_models(runs: tuple[Run, ...]) -> None:
    rows = list(error_rows(runs, SIGNAL))
    assert len(error_heads(shown(SIGNAL))) == len(rows[0])
    assert [row[0] for row in rows[:3]] == [
        "as given, all",
        "heavier, all",
        "I, lower slack",
    ]
    states = runs[-1].file.signals[SIGNAL].slack_states
    assert len(rows) == 2 + len(states)
    assert sum(int(str(row[1])) for row in rows[2:]) == int(str(rows[1][1]))
    rmse = runs[-1].file.signals[SIGNAL].rmse
    assert copied(rows[1][2]) == 1e3 * rmse
    assert isinstance(rows[1][2], Exact)
    assert rows[1][2].shown == number(1e3 * rmse)
    assert next(error_rows(runs[-1:], SIGNAL))[0] == "all"


# ---- chosen samples ------------------------------------------------------------------------


def test_a_chosen_bin_is_described_by_its_own_error(
    runs: tuple[Run, ...], location: FileLocation
) -> None:
    found_bin = next(
        found_bin for found_bin in location.bins[SIGNAL] if found_bin.by == "deflection"
    )
    chosen = chosen_samples(location, [found_bin.by, found_bin.bin])
    assert chosen is not None
    assert np.count_nonzero(chosen) == found_bin.count
    words = chosen_words(runs[-1], SIGNAL, location, [found_bin.by, found_bin.bin], chosen)
    assert words.startswith(f"Deflection {found_bin.bin}: {found_bin.count} of ")
    assert shown(SIGNAL).error(found_bin.rmse) in words


def test_a_slack_state_keeps_its_letters(runs: tuple[Run, ...], location: FileLocation) -> None:
    found_bin = next(
        found_bin for found_bin in location.bins[SIGNAL] if found_bin.bin.startswith("III")
    )
    mark = [found_bin.by, found_bin.bin]
    chosen = chosen_samples(location, mark)
    assert chosen is not None
    assert chosen_words(runs[-1], SIGNAL, location, mark, chosen).startswith("Slack state III")


def test_a_cell_is_described_by_what_it_spans(
    runs: tuple[Run, ...], location: FileLocation
) -> None:
    across, up = "deflection", "joint_velocity"
    sample = 300
    column, row = (
        min(int(CELLS * (values[sample] - values.min()) / (values.max() - values.min())), CELLS - 1)
        for values in (location.variables[across], location.variables[up])
    )
    mark = [across, up, column, row]
    chosen = chosen_samples(location, mark)
    assert chosen is not None
    assert chosen[sample]
    words = chosen_words(runs[-1], SIGNAL, location, mark, chosen)
    assert " rad and joint velocity " in words
    assert f"rad/s: {np.count_nonzero(chosen)} of " in words


def test_a_band_of_frequencies_has_no_samples_to_show(
    runs: tuple[Run, ...], location: FileLocation
) -> None:
    found_bin = next(
        found_bin for found_bin in location.bins[SIGNAL] if found_bin.by == "frequency"
    )
    mark = [found_bin.by, found_bin.bin]
    chosen = chosen_samples(location, mark)
    assert chosen is not None
    assert "no samples" in chosen_words(runs[-1], SIGNAL, location, mark, chosen)


def test_a_mark_that_is_no_longer_there_marks_nothing(location: FileLocation) -> None:
    assert chosen_samples(location, None) is None
    assert chosen_samples(location, ["a", "b", "c"]) is None
    assert chosen_samples(location, ["nothing", "joint_velocity", 1, 2]) is None


def test_the_densest_bins_stand_first(location: FileLocation) -> None:
    bins = location.bins[SIGNAL]
    held = sample_shares(bins)
    chosen = strongest_bins(bins)
    excess = [error_bin.share - held[error_bin] for error_bin in chosen]
    assert chosen
    assert all(error_bin.stands_out for error_bin in chosen)
    assert excess == sorted(excess, reverse=True)
    row = bin_cells(chosen[0], shown(SIGNAL), held[chosen[0]])
    assert row[1] == chosen[0].bin
    assert row[4] == f"{100.0 * chosen[0].share:.0f}"
