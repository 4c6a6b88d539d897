"""What users correct of how a file is read becomes what the command line would be told."""

import pytest

from elastic_tendon.app.document import Source
from elastic_tendon.app.mapping import (
    BY_NAME,
    Row,
    in_app_words,
    number_of,
    remapped,
    rows_of,
    shifts_of,
    window_of,
)
from elastic_tendon.errors import MeasurementError
from elastic_tendon.measurement.reader import read_measurement

SOURCE = Source(key="a", name="run.csv")
LABELS = ("t", "m", "enc*2", "a:deg")
JOINT = Row("joint_position", "enc", "deg")


def corrected(row: Row, field: str, value: str | None, labels=LABELS) -> tuple[str, ...]:
    return remapped(SOURCE, labels, row, field, value)


def test_a_correction_is_one_item_of_a_mapping() -> None:
    assert corrected(JOINT, "unit", "rad") == ("joint_position=enc:rad",)
    assert corrected(JOINT, "times", "-1") == ("joint_position=enc:deg*-1.0",)
    assert corrected(JOINT, "plus", "-0.25") == ("joint_position=enc:deg-0.25",)
    assert corrected(JOINT, "column", "m") == ("joint_position=m",)
    assert corrected(JOINT, "column", BY_NAME) == ()


def test_names_with_signs_in_them_are_read_as_they_are() -> None:
    assert corrected(JOINT, "column", "enc*2") == ("joint_position=enc*2",)
    with pytest.raises(MeasurementError, match="rename it in the file"):
        corrected(Row("joint_position", "a:deg"), "times", "2")


def test_other_signals_and_a_preparation_stay_as_they_are() -> None:
    source = SOURCE.changed(mapping=("time=t", "joint_position=m", "run.toml"))
    assert remapped(source, LABELS, JOINT, "unit", "rad") == (
        *("time=t", "run.toml"),
        "joint_position=enc:rad",
    )


@pytest.mark.parametrize(
    ("field", "value", "sentence"),
    [
        ("times", "0", "joint position: times 0 would leave nothing of it"),
        ("times", "two", "“two” is not a number; the last one is kept"),
        ("plus", "inf", "“inf” is not a number; the last one is kept"),
    ],
)
def test_a_wrong_number_is_refused_in_a_sentence(field: str, value: str, sentence: str) -> None:
    with pytest.raises(MeasurementError, match=sentence):
        corrected(JOINT, field, value)


def test_the_table_shows_what_was_found_and_what_could_be(tmp_path) -> None:
    path = tmp_path / "run.csv"
    lines = [f"{0.01 * i},{i},{2 * i}" for i in range(20)]
    path.write_text("\n".join(["time_s,motor_position_deg,enc", *lines]))
    source = SOURCE.changed(mapping=("joint_position=enc:mrad*-1",))
    labels = ("time_s", "motor_position_deg", "enc")
    found = read_measurement(str(path), source.options)
    rows = {row.signal: row for row in rows_of(source, labels, found)}
    assert rows["joint_position"] == Row("joint_position", "enc", "mrad", times=-1.0)
    assert rows["motor_position"].unit == "deg"
    assert rows["load_torque"] == Row("load_torque")
    assert "joint_deflection" not in rows
    unread = {row.signal: row for row in rows_of(source, labels, None)}
    assert unread["joint_position"] == Row("joint_position", "enc", "mrad", times=-1.0)
    assert unread["joint_deflection"].column is None


def test_windows_and_shifts() -> None:
    assert window_of(SOURCE, "start", "2") == (2.0, None)
    assert window_of(SOURCE, "end", " ") == (None, None)
    with pytest.raises(MeasurementError, match="from 4 s to 2 s is nothing"):
        window_of(Source(key="a", name="a", window=(4.0, None)), "end", "2")
    assert shifts_of(SOURCE, "motor_position", "auto") == {"motor_position": "auto"}
    late = SOURCE.changed(time_shift={"motor_position": 0.004})
    assert shifts_of(late, "motor_position", "0") == {}
    assert number_of("−0.5", "plus") == -0.5


def test_advice_for_the_command_line_is_told_in_words_of_the_page() -> None:
    told = (
        "a.csv: it is odd; read it with --map joint_position=q:deg*-1 --map motor_position=m; "
        "if the file is right, add --as-declared"
    )
    assert in_app_words(told) == (
        "a.csv: it is odd; read joint position from q in deg times −1 and motor position from m"
    )
    missing = "there is no column time_s; name the right one with --map time=COLUMN"
    assert in_app_words(missing) == "there is no column time_s; choose its column below"
