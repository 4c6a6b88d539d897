"""The benchmark scripts measure what they say, at sizes too small to mean anything."""

import ast
import math
import re
from pathlib import Path

import numpy as np
import pytest

import benchmark_all
import benchmark_cluster
import benchmark_fit
import benchmark_fmpy
import benchmark_simulate
import benchmark_startup
import benchmark_sweep
from benchmarking import (
    Row,
    at_least,
    at_most,
    in_turn,
    known_misses,
    print_rows,
    spoken,
    spread,
)
from elastic_tendon.actuator.parameters import load_model

SCRIPTS = [  # that print figures beside targets
    path
    for path in sorted((Path(__file__).parents[1] / "build_scripts").glob("*.py"))
    if "print_table(" in path.read_text("utf-8") and path.stem != "benchmarking"
]
NUMBER = re.compile(r"[-+]?(\d+\.?\d*(e[-+]?\d+)?|inf|nan)")


def assert_finite(rows: list[Row]) -> None:
    """Every row has a figure above zero, and so have the numbers beside it."""
    assert rows
    for row in rows:
        for text in (row.figure, row.beside):
            figures = [float(found[0]) for found in NUMBER.finditer(text)]
            assert all(math.isfinite(figure) for figure in figures), row
        figure = NUMBER.match(row.figure)
        assert figure is not None, row
        assert float(figure[0]) > 0.0, row


def test_times_are_taken_in_turn_after_one_call_each():
    calls: list[str] = []
    times = in_turn([lambda: calls.append("a"), lambda: calls.append("b")], 2)
    assert "".join(calls) == "ababab"
    assert times.shape == (2, 2)
    assert (times >= 0.0).all()


@pytest.mark.parametrize(
    ("duration", "text"), [(12.34, "12.3 s"), (1e-3, "1 ms"), (25e-6, "25 µs"), (3e-10, "0.3 ns")]
)
def test_a_time_has_the_unit_that_suits_it(duration, text):
    assert spoken(duration) == text


def test_a_spread_is_told_as_median_least_and_most():
    assert spread(np.array([3e-3, 1e-3, 2e-3])) == "2 ms (1 ms to 3 ms)"


def test_a_row_says_whether_its_target_is_met(capsys):
    rows = [at_least("fast", 3.0, 2.0, "x", "1 s; 3 s"), at_most("small", 3.0, 2.0)]
    assert print_rows(rows, known={}) == 1
    fast, small = capsys.readouterr().out.splitlines()
    assert fast.split() == ["fast", "3", "x", "≥", "2", "x", "met", "1", "s;", "3", "s"]
    assert small.split() == ["small", "3", "≤", "2", "MISSED"]


@pytest.mark.parametrize(
    ("known", "status"), [({"small": "2.9"}, 0), ({"large": "2.9"}, 1), ({}, 1)]
)
def test_a_miss_fails_unless_it_is_known(known, status, capsys):
    rows = [Row("told", "5"), at_least("fast", 3.0, 2.0), at_most("small", 3.0, 2.0)]
    assert print_rows(rows, known) == status
    assert ("MISSED (known: 2.9)" in capsys.readouterr().out) == (status == 0)
    assert print_rows(rows[:2], known) == 0


def test_known_misses_are_read_from_their_file(tmp_path):
    path = tmp_path / "known.toml"
    path.write_text('"a fit, in time" = "1.2 s"\n', "utf-8")
    assert known_misses(path) == {"a fit, in time": "1.2 s"}
    assert all(re.search(r"\d", figure) for figure in known_misses().values())


def test_a_known_miss_of_a_study_is_known_for_any_number_of_cases():
    rows = [at_least("named (24)", 91.0, 95.0, "%")]
    assert print_rows(rows, {"named": "92 %"}) == 0
    assert print_rows(rows, {"name": "92 %"}) == 1


@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: path.stem)
def test_every_benchmark_and_study_hands_on_whether_a_target_is_missed(path):
    text = path.read_text("utf-8")
    assert "sys.exit(main())" in text.splitlines()[-1]
    tree = ast.walk(ast.parse(text))
    alone = [statement.value for statement in tree if isinstance(statement, ast.Expr)]
    called = {
        call.func.id for call in alone if isinstance(call, ast.Call) and "id" in vars(call.func)
    }
    assert not called & {"print_table", "print_rows"}


def test_simulate_beside_scipy():
    model = load_model(benchmark_sweep.MODEL)
    assert_finite(benchmark_simulate.peer_rows(model, False, "linear", 0.1))


def test_the_peer_of_the_fit_finds_the_same_optimum():
    ratio, apart = benchmark_fit.fit_rows(duration=0.4, repetitions=1)
    assert_finite([ratio])
    assert apart.met, apart


def test_sensitivities_beside_differences():
    time, error = benchmark_fit.sensitivity_rows(duration=0.5, repetitions=1)
    assert_finite([time, error])
    assert float(error.figure) > 0.1  # derivatives of the same thing, and in the same order


def test_fmpy_simulates_the_same_motion():
    rows = benchmark_fmpy.rows(duration=0.1, repetitions=1)
    assert_finite(rows)
    errors = [float(row.beside.split("error ")[1].split()[0]) for row in rows]
    assert max(errors) < 1e-3


def test_many_simulations_beside_scipy():
    assert_finite(benchmark_sweep.peer_rows(count=20, machines=1))


def test_sweeps_over_runs_and_cores():
    assert_finite(benchmark_sweep.scaling_rows([2, 20]))
    assert_finite(benchmark_sweep.cores_rows(20, 1))


def test_memory_is_that_of_the_runs():
    row, *summary = benchmark_sweep.memory_rows((2, 3))
    assert row.beside.count("MB") == 2 or row.figure == "not told here"
    assert all(row.figure.endswith("MB") for row in summary)


def test_processes_are_told_beside_one_that_imports_numpy():
    assert_finite(benchmark_startup.process_rows(1))


def test_a_first_refit_is_told_where_nothing_was_compiled():
    parameters, effects = benchmark_startup.refit_rows()
    assert_finite([parameters, effects])
    assert parameters.target == "≤ 10 s"


def test_every_group_has_a_heading_of_its_own():
    titles = [group.title for group in benchmark_all.groups(quick=True)]
    assert len(set(titles)) == len(titles) > 5


def test_a_word_that_no_heading_has_is_told(monkeypatch, capsys):
    monkeypatch.setattr("sys.argv", ["benchmark_all.py", "--only", "quantum"])
    assert benchmark_all.main() == 1
    assert "no heading has 'quantum' in it" in capsys.readouterr().err


def test_cores_are_busy_where_dealing_out_costs_nothing():
    free = benchmark_cluster.simulated(100_000, 100, 0.0)
    assert 97.0 < free.busy <= 100.0
    assert free.total == pytest.approx(1000.0, rel=0.03)


def test_a_scheduler_deals_out_so_many_pieces_and_no_more():
    """Each of at most 60 s, for 0.6 s: a hundred of a thousand cores are busy."""
    found = benchmark_cluster.simulated(1_000_000, 1000, 0.6)
    assert found.busy < 11.0
