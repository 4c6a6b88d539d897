"""Tables of the terminal at 80 columns: no cell is cut, or broken in the middle of a word."""

import io
from collections.abc import Iterator

import pytest
from rich.console import Console
from rich.table import Table
from rich.text import Text

from elastic_tendon.actuator.design import design
from elastic_tendon.actuator.parameters import load_model, quantities
from elastic_tendon.effects import CATALOGUE
from elastic_tendon.estimation.determinability import Estimate, Findings
from elastic_tendon.linear.linearise import linearise
from elastic_tendon.linear.result import OperatingPoint
from elastic_tendon.reports.comparison_tables import bin_tables, error_table
from elastic_tendon.reports.diagnosis_tables import candidates_table
from elastic_tendon.reports.effects import effects_table
from elastic_tendon.reports.linear_tables import linear_tables
from elastic_tendon.reports.neighbours import neighbours_table, would_show_table
from elastic_tendon.reports.sweep_tables import bootstrap_table, statistics_table
from elastic_tendon.reports.tables import design_table, estimates_table, ladder_table
from elastic_tendon.sweeps.bootstrap import BootstrapInterval
from elastic_tendon.sweeps.summary import ColumnSummary, Summary
from hand_made_diagnosis import friction_found

MODEL = load_model("biorob_x4_joint_3")
WIDTH = 80


def broken(table: Table) -> set[str]:
    """Words of the cells and headings that stand nowhere whole."""
    stream = io.StringIO()
    Console(file=stream, width=WIDTH).print(table)
    lines = stream.getvalue().splitlines()
    assert max(map(len, lines)) <= WIDTH
    printed = {word for line in lines for word in line.replace("│", " ").replace("┃", " ").split()}
    cells = [str(cell) for column in table.columns for cell in (column.header, *column.cells)]
    return {word for cell in cells for word in Text.from_markup(cell).plain.split()} - printed


def estimates() -> list[Estimate]:
    """Every number of the model with every effect, as wide as the fit may tell it."""
    ids = [effect.id for effect in CATALOGUE]
    return [
        Estimate(quantity.path, quantity.unit, -1.234e-05, 0.0108, 1.0, (1e-4, 0.192), True)
        for quantity in quantities(ids)
    ]


def of_a_diagnosis() -> Iterator[Table]:
    found = friction_found()
    for file, location in zip(found.comparison.files, found.location.files, strict=True):
        yield error_table(found.comparison, file)
        yield from bin_tables(file, location, all_bins=True)
    yield ladder_table(found.ladder)
    yield estimates_table(Findings(1.0, tuple(estimates()), (), ()))
    for judged in found.rounds:
        if (table := candidates_table(judged, every=True)) is not None:
            yield table
    for table in (neighbours_table(found, every=True), would_show_table(found.would_show)):
        assert table is not None
        yield table


def of_sweeps() -> Iterator[Table]:
    numbers = (-1.234e-3,) * 3
    columns = [
        ColumnSummary(name, 9, 0.0, 0.0, -1.234e-3, 0, 1.234e-3, 1, numbers)
        for name in (*(estimate.path for estimate in estimates()), "joint_position.rms_error_rad")
    ]
    summary = Summary(9, 0, 9, 9, (), tuple(columns))
    yield statistics_table(summary, {estimate.path: estimate.unit for estimate in estimates()})
    yield bootstrap_table(
        [
            BootstrapInterval(
                estimate.path, estimate.unit, 0.0108, (0.01, 0.01254), (0.01011, 0.01192)
            )
            for estimate in estimates()
        ]
    )


def of_a_model() -> Iterator[Table]:
    at = OperatingPoint(deflection=0.0)
    yield from linear_tables(
        MODEL.name, [linearise(MODEL, state, at) for state in ("I", "II", "III", "both")]
    )
    yield design_table(MODEL.name, design(MODEL))
    yield effects_table(CATALOGUE, {})


@pytest.mark.parametrize("tables", [of_a_diagnosis, of_sweeps, of_a_model])
def test_no_word_of_a_cell_is_broken(tables) -> None:
    for table in tables():
        assert broken(table) == set(), table.title


def test_a_broken_word_is_seen() -> None:
    table = Table("a heading", width=20)
    table.add_row("a-word-that-is-wider-than-its-table")
    assert broken(table)
