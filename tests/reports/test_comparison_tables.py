"""Tables of a comparison are whole at 80 columns, and hold the comparison's own numbers."""

import io
from dataclasses import replace

import numpy as np
import pytest
from rich.console import Console

from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.comparison.bins import Bin
from elastic_tendon.comparison.comparison import (
    Comparison,
    ErrorFigures,
    FileComparison,
    SignalError,
)
from elastic_tendon.comparison.locate import FileLocation
from elastic_tendon.comparison.missing_torque import MissingTorque
from elastic_tendon.comparison.residuals import InitialState
from elastic_tendon.measurement import Measurement, NoiseFloor
from elastic_tendon.reports.comparison_tables import (
    ROWS,
    bin_tables,
    error_table,
    noise_sentence,
    strongest,
)
from elastic_tendon.reports.units import noise_ratio, number, shown, times_noise
from elastic_tendon.simulation.simulate import Trajectory

LONG = "a_position_loop_that_was_disturbed_by_hand_and_has_a_long_name.csv[3.25:14.75]"
N = 100
NOTHING = np.zeros(N)


def printed(renderable) -> str:
    """What the terminal shows at 80 columns."""
    stream = io.StringIO()
    Console(file=stream, width=80).print(renderable)
    return stream.getvalue()


def expect_whole(text: str) -> None:
    """Nothing is cut off and no line is broken."""
    assert "…" not in text
    assert max(len(line) for line in text.splitlines()) <= 80


def file_comparison(static: bool = False) -> FileComparison:
    noise = NoiseFloor(2.04e-4, "coloured", "repeated periods", 0.7)
    parts = {
        state: ErrorFigures(0.123456, 12.3456, -1.23456, -123.456, 12345.6, 123456)
        for state in ("I", "II", "III")
    }
    error = SignalError(0.0123, 0.0456, -0.000789, None, 60.3, N, noise, parts)
    signals = {"joint_position": NOTHING, "joint_torque": NOTHING}
    measurement = Measurement(np.arange(N), NOTHING, signals, static=static, name=LONG)
    empty = np.zeros((N, 0))
    trajectory = Trajectory(measurement.time, empty, empty, (), (), np.array([]), {})
    errors = dict.fromkeys(signals, error)
    return FileComparison(measurement, InitialState(0.0, 0.0), trajectory, errors)


def location(count: int) -> FileLocation:
    """Bins of which the later ones hold more of the error than of the samples."""
    shares = np.arange(1.0, count + 1.0) / np.sum(np.arange(1.0, count + 1.0))
    bins = tuple(
        Bin(
            *("joint_acceleration", f"-1.2{index}e+03 to -1.2{index} rad/s²", None, None),
            *(10, 0.0123 * share, -0.01, float(share), 5.0, index > 0),
        )
        for index, share in enumerate(shares)
    )
    missing = MissingTorque(NOTHING, NOTHING, (), (), found=True)
    return FileLocation({"joint_position": bins}, {}, missing, {}, {}, file_comparison(), {})


def test_error_table_has_every_figure_at_80_columns() -> None:
    file = file_comparison()
    text = printed(error_table(Comparison(load_model("figure_8"), (file,)), file))
    expect_whole(text)
    (whole,) = (line for line in text.splitlines() if "joint position, mrad" in line)
    assert whole.split()[-6:] == ["100", "12.3", "45.6", "-0.789", "-", "60.3"]
    (state,) = (line for line in text.splitlines()[:12] if "II, upper slack" in line)
    assert state.split()[-6:] == ["123456", "123", "12346", "-1235", "-123.5", "12346"]


def test_static_curves_are_spoken_of_as_deflection() -> None:
    file = file_comparison(static=True)
    text = printed(error_table(Comparison(load_model("figure_8"), (file,)), file))
    assert "deflection, mrad" in text
    assert "joint position" not in text


def test_noise_is_told_with_its_kind() -> None:
    sentence = noise_sentence(file_comparison())
    assert "joint position 0.204 mrad, coloured, from repeated periods" in sentence


def test_only_what_stands_out_is_listed_unless_all_is_asked_for() -> None:
    file, found = file_comparison(), location(5)
    (short,) = (printed(table) for table in bin_tables(file, found))
    (long,) = (printed(table) for table in bin_tables(file, found, all_bins=True))
    for text in (short, long):
        expect_whole(text)
    # two more stand out, but hold no more of the error than of the samples
    assert (short.count("acceleration"), long.count("acceleration")) == (2, 5)
    assert "2 more stand out" in short
    assert long.count("*") == 4 + 1  # and the caption
    (last,) = (line for line in short.splitlines() if "-1.24" in line)
    assert last.split()[-4:] == ["33", "%", "20", "%"]


def test_a_signal_that_repeats_another_is_not_shown_again() -> None:
    file, found = file_comparison(), location(5)
    (own,) = found.bins.values()
    both = replace(found, bins={"joint_torque": own, "motor_torque": own})
    (table,) = (printed(table) for table in bin_tables(file, both))
    assert "where the joint torque is off" in table
    assert "The motor torque is off in the same places." in table
    fewer = replace(found, bins={"joint_torque": own, "motor_torque": own[1:]})
    assert len(list(bin_tables(file, fewer))) == 2


def test_a_wall_of_bins_is_cut_to_the_worst() -> None:
    found = location(3 * ROWS)
    tables = bin_tables(file_comparison(), found, advice=", see --all-bins")
    (text,) = (printed(table) for table in tables)
    assert text.count("joint acceleration") == ROWS
    assert f"{2 * ROWS - 1} more stand out, see --all-bins" in text
    bins = found.bins["joint_position"]
    assert strongest(bins, dict.fromkeys(bins, 0.01)) == list(bins[-ROWS:])


def test_signals_that_fail_nowhere_have_no_table() -> None:
    assert list(bin_tables(file_comparison(), location(1))) == []


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0.00"),
        (12345.6, "12346"),
        (123.4, "123"),
        (12.0, "12.0"),
        (-0.5, "-0.500"),
        (1.2345e-5, "1.23e-05"),
        (1.2345e9, "1.23e+09"),
    ],
)
def test_numbers_have_three_digits_and_rarely_an_exponent(value: float, text: str) -> None:
    assert number(value) == text


def test_an_error_far_below_the_noise_is_not_told_as_zero_times_it() -> None:
    assert times_noise(0.004) == "less than 0.1 times the noise"
    assert times_noise(1.02) == "1.02 times the noise"
    assert noise_ratio(1e-9) == "<0.1"


def test_only_a_static_joint_position_is_a_deflection() -> None:
    assert shown("joint_position", static=True).words == "deflection"
    assert shown("joint_torque", static=True).words == "joint torque"
    assert shown("joint_position").words == "joint position"
