"""Text comes back as it is written; bad text is refused with its row, in one sentence."""

import warnings
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from whole import assert_refused, whole

from elastic_tendon.measurement.formats import open_source, text, text_layout
from elastic_tendon.progress import silent

HEADER = "time_s,motor_position_rad,joint_position_rad"


@pytest.fixture
def write(tmp_path: Path):
    def write(content: str | bytes, name: str = "run.csv") -> Path:
        path = tmp_path / name
        path.write_bytes(content.encode() if isinstance(content, str) else content)
        return path

    return write


@pytest.fixture(params=["whole", "blocks"])
def either_way(request, monkeypatch):
    """Both ways of reading: the file at once, and blocks of a few rows."""
    if request.param == "blocks":
        monkeypatch.setattr(text, "_WHOLE", 0)
        monkeypatch.setattr(text, "_BLOCK", 64)


def rows(count: int, separator: str = ",") -> str:
    lines = (f"{0.01 * i:.2f}{separator}{i}{separator}{-0.5 * i:g}" for i in range(count))
    return "\n".join(lines) + "\n"


@pytest.mark.usefixtures("either_way")
@pytest.mark.parametrize(
    "content",
    [
        f"{HEADER}\n{rows(50)}",
        f"\ufeff{HEADER}\n{rows(50)}",
        f"{HEADER}\n{rows(50)}".replace("\n", "\r\n"),
        f"{HEADER}\n{rows(50)}".rstrip("\n"),
        f"{HEADER}\n{rows(50)}\n\n,,\n",
        f"{HEADER}\n{rows(50)}".replace(",", ", "),
        f"{HEADER}\n{rows(50)}".replace(",", "\t"),
        f'"{HEADER}"\n{rows(50)}'.replace(",", '","', 2),
        f"\n\n{HEADER}\n{rows(50)}",
    ],
    ids=["plain", "mark", "crlf", "no end", "blank end", "spaces", "tabs", "quoted", "blank start"],
)
def test_the_same_numbers_come_back_however_the_text_is_written(write, content) -> None:
    source = open_source(write(content))
    assert source.groups[0].columns == tuple(HEADER.split(","))
    table = whole(source)
    assert np.allclose(table["time_s"], np.arange(50) / 100, rtol=1e-15, atol=0.0)
    assert np.array_equal(table["motor_position_rad"], np.arange(50.0))
    assert np.array_equal(table["joint_position_rad"], -0.5 * np.arange(50))
    assert source.first_row == (4 if content.startswith("\n") else 2)


def test_numbers_are_those_of_pandas(write) -> None:
    values = np.random.default_rng(7).normal(size=(2000, 3)) * 10.0 ** np.arange(-3, 6, 3)
    path = write(pd.DataFrame(values, columns=HEADER.split(",")).to_csv(index=False))
    table = whole(open_source(path))
    expected = pd.read_csv(path)
    assert all(np.array_equal(table[name], expected[name]) for name in expected)


@pytest.mark.usefixtures("either_way")
def test_text_and_blanks_are_passed_on_in_their_row(write) -> None:
    content = f"{HEADER},remark\n" + "".join(
        f"{line},{'start' if i == 3 else ''}\n" for i, line in enumerate(rows(20).splitlines())
    )
    table = whole(open_source(write(content.replace("7,-3.5", "seven,"))))
    assert table["motor_position_rad"].dtype == object
    assert table["motor_position_rad"][7] == "seven"
    assert float(table["motor_position_rad"][8]) == 8.0
    assert np.flatnonzero(np.isnan(table["joint_position_rad"].astype(float))).tolist() == [7]
    assert table["remark"][3] == "start"


def test_only_the_wanted_columns_are_read(write) -> None:
    source = open_source(write(f"{HEADER}\n{rows(5)}"))
    chunks = list(source.read("", ["joint_position_rad"], lambda _text, _share: None))
    assert [list(chunk) for chunk in chunks] == [["joint_position_rad"]]


@pytest.mark.usefixtures("either_way")
def test_progress_ends_at_one_and_never_falls(write) -> None:
    source = open_source(write(f"{HEADER}\n{rows(200)}"))
    shares: list[float] = []
    chunks = list(source.read("", ["time_s"], lambda _text, share: shares.append(share)))
    assert sum(len(chunk["time_s"]) for chunk in chunks) == 200
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


def test_memory_is_bounded_by_blocks(write, monkeypatch) -> None:
    monkeypatch.setattr(text, "_WHOLE", 0)
    monkeypatch.setattr(text, "_BLOCK", 1000)
    source = open_source(write(f"{HEADER}\n{rows(5000)}"))
    lengths = [len(c["time_s"]) for c in source.read("", ["time_s"], lambda _t, _s: None)]
    assert sum(lengths) == 5000
    assert max(lengths) < 200


def test_latin_1_is_read_where_the_header_is_not_utf_8(write) -> None:
    content = f"time_s,winkel [°],größe\n{rows(12)}".encode("latin-1")
    source = open_source(write(content))
    assert source.groups[0].columns == ("time_s", "winkel [°]", "größe")
    assert whole(source)["größe"][-1] == -5.5


def test_a_column_without_a_name_gets_its_number(write) -> None:
    source = open_source(write(f",motor,joint\n{rows(5)}"))
    assert source.groups[0].columns == ("column 1", "motor", "joint")


@pytest.mark.usefixtures("either_way")
@pytest.mark.parametrize(
    ("content", "parts"),
    [
        ("", ["is empty"]),
        ("\n \n", ["is empty"]),
        (HEADER, ["no samples"]),
        (f"{HEADER}\n\n\n", ["no samples"]),
        (f"{HEADER}\n{rows(9)}".replace(",", ";"), ["semicolons", "save it with commas"]),
        (
            f"{HEADER.replace(',', ';')}\n{rows(9, ';').replace('.', ',')}",
            ["semicolons", "decimal points"],
        ),
        (f"{HEADER}\n{rows(9)}".replace(",", " "), ["spaces", "save it with commas"]),
        (f"{HEADER}\n{rows(9)}".replace(",", "|"), ["vertical bars", "save it with commas"]),
        ("time_s\n0\n1\n", ["one column"]),
        (f"{HEADER}\n0,01,1,25,2,5\n", ["row 2", "decimal commas", "2,5"]),
        (f"{HEADER}\n{rows(20)}0,20,1,25,2,5\n", ["row 22", "decimal commas"]),
        (
            f"{HEADER}\n{rows(20)}0.2,1,2\n".replace(",", "\t").replace(".", ","),
            ["row 2", "decimal commas", "0,00"],
        ),
        (f'{HEADER}\n{rows(20)}"0,2","1,5","2"\n', ["row 22", "decimal commas", "0,2"]),
        ("time_s,q,p,q\n0,1,2,3\n", ["columns 2 and 4 are both called q"]),
        (f"{HEADER}\n{rows(20)}0.2,1\n", ["row 22 holds 2 values", "3 names"]),
        (f"{HEADER}\n{rows(20)}0.2,1,0.5,0.5\n", ["row 22 holds 4 values"]),
        (f"{HEADER}\n0,1,2,3.5\n{rows(20)}", ["row 2 holds 4 values"]),
        # as many separators in all as there should be
        (f"{HEADER}\n{rows(20)}0.2,1,0.5,7\n0.21,1\n{rows(3)}", ["row 22 holds 4 values"]),
        (f"{HEADER}\n{rows(20)}0.2,1\n0.21,1,0.5,7\n", ["row 22 holds 2 values"]),
        (f"{HEADER}\n0.2,1\n{rows(20)}0.21,1,0.5,7\n", ["row 2 holds 2 values"]),
        (f"sep=,\n{HEADER}\n{rows(20)}", ["row 1", "'sep=,'", "remove"]),
        (f"{HEADER}\n{rows(20)}0.2,1,0.5,\n", ["row 22 holds 4 values"]),
        (f"{HEADER}\n{rows(20)}".replace("3,-1.5", "3,-1\0.5"), ["row 5", "NUL"]),
        (f"{HEADER}\0\n{rows(3)}", ["no text"]),
        (f"{HEADER}\n{rows(20)}".replace("3,-1.5", '3,"-1.5'), ["row 5", "quotation mark"]),
        (f"{HEADER},x\n" + '0,1,2,a\n0,1,2,"a\n0,1,2,a\n0,1,2,"\n', ["row 3", "quotation mark"]),
        (f"{HEADER}\n{rows(20)}".replace("3,-1.5", "3,-1\r5"), ["row 5", "carriage return"]),
        (f"{HEADER}\n{rows(20)}".replace("3,-1.5", "3\r-1.5"), ["row 5 holds 2 values"]),
        (f"{HEADER}\n{rows(20)}0.2,1,{'x' * 200_000},0\n", ["row 22 holds 4 values"]),
        (f"{HEADER},x\n0,1,2,a\f\x85\n{rows(3)}", ["row 3 holds 3 values"]),
        (rows(20), ["row 1 holds numbers", "header"]),
        (f"# {HEADER}\n{rows(20)}", ["row 1 is a comment"]),
        (f"Test of 3 May\n{HEADER}\n{rows(20)}", ["row 1 is no header", "Test of 3 May"]),
        (f"{HEADER}\n{rows(20)}".replace("\n", "\r"), ["carriage return"]),
    ],
)
def test_bad_text_is_refused_with_what_to_do(write, content, parts) -> None:
    assert_refused(write(content), *parts)


def test_a_million_columns_are_refused_by_the_header_alone(write, monkeypatch) -> None:
    content = ",".join(f"c{i}" for i in range(1_000_000))
    monkeypatch.setattr(text_layout, "_cells", None)  # nothing may take the line apart
    assert_refused(write(f"{content}\n{content}\n"), "columns and may have 10000")


def test_a_line_without_end_is_refused(write, monkeypatch) -> None:
    monkeypatch.setattr(text_layout, "LONGEST_LINE", 5000)
    monkeypatch.setattr(text, "_BLOCK", 64)
    assert_refused(write(f"{HEADER}\n{rows(3)}{'1' * 20_000}\n"), "row 5 is longer")
    assert_refused(write("x" * 20_000), "row 1 is longer")


def test_many_blank_lines_at_the_end_are_left_away(write) -> None:
    table = whole(open_source(write(f"{HEADER}\n{rows(20)}{chr(10) * 1_000_000}")))
    assert len(table["time_s"]) == 20


def test_quoted_separators_do_not_make_a_row_ragged(write) -> None:
    content = "time_s,motor,joint,remark\n" + '0.1,1,2,"here, and there"\n' * 12
    table = whole(open_source(write(content)))
    assert table["remark"][0] == "here, and there"
    assert table["joint"][-1] == 2.0


def test_text_late_in_a_long_file_is_passed_on_without_a_warning(write) -> None:
    path = write(f"{HEADER}\n{rows(300_000)}3000,lost,1\n")
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        chunks = list(open_source(path).read("", ["motor_position_rad"], silent))
    assert not warned
    assert chunks[-1]["motor_position_rad"][-1] == "lost"
    assert chunks[0]["motor_position_rad"].dtype == float
