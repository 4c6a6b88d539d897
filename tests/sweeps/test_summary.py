"""What a table of results says as a whole, read in pieces."""

import importlib.util
import tracemalloc

import numpy as np
import pandas as pd
import pytest

from elastic_tendon.errors import SweepError
from elastic_tendon.sweeps import results
from elastic_tendon.sweeps import summary as module
from elastic_tendon.sweeps.summary import summarise

FORMATS = ["csv", "parquet"] if importlib.util.find_spec("pyarrow") else ["csv"]


def _table(count):
    random = np.random.default_rng(11)
    failed = np.arange(count) % 100 == 7
    reason = [f"stopped at {0.01 * i:.6g} s: it is too stiff" for i in range(count)]
    reason = ["no model" if i == 307 else text for i, text in enumerate(reason)]
    return pd.DataFrame(
        {
            "run": np.arange(count),
            "link.damping": random.uniform(0.1, 0.3, count),
            "joint_position.maximum_rad": np.where(
                failed, np.nan, 1e6 + random.standard_normal(count)
            ),
            "nothing_rad": np.full(count, np.nan),
            "appeared": ["" if i < count // 2 else "friction" for i in range(count)],
            "failure": np.where(failed, reason, ""),
        }
    )


def _write(table, path):
    if path.suffix == ".csv":
        table.to_csv(path, index=False)
    else:
        table.to_parquet(path, index=False)
    return path


@pytest.mark.parametrize("suffix", FORMATS)
def test_statistics_are_those_of_the_whole_table(tmp_path, monkeypatch, suffix):
    monkeypatch.setattr(results, "PIECE", 2_000)
    table = _table(5_000)
    found = summarise(_write(table, tmp_path / f"runs.{suffix}"))
    assert (found.runs, found.failed, found.rows, found.sampled) == (5_000, 50, 5_000, 5_000)
    assert [column.name for column in found.columns] == [
        "link.damping",
        "joint_position.maximum_rad",
    ]
    for column in found.columns:
        values = table[column.name].dropna()
        assert column.count == len(values)
        assert column.mean == pytest.approx(values.mean(), rel=1e-13)
        assert column.deviation == pytest.approx(values.std(), rel=1e-9)
        assert column.minimum == pytest.approx(values.min(), rel=1e-15)
        assert column.maximum == pytest.approx(values.max(), rel=1e-15)
        assert (column.lowest_run, column.highest_run) == (values.idxmin(), values.idxmax())
        np.testing.assert_allclose(column.quantiles, values.quantile([0.05, 0.5, 0.95]))


@pytest.mark.parametrize("suffix", FORMATS)
def test_failures_are_counted_by_what_they_say(tmp_path, monkeypatch, suffix):
    monkeypatch.setattr(results, "PIECE", 2_000)
    found = summarise(_write(_table(5_000), tmp_path / f"runs.{suffix}"))
    solver, again = found.reasons
    assert (solver.text, solver.run, solver.count) == ("stopped at 0.07 s: it is too stiff", 7, 49)
    assert (again.text, again.run, again.count) == ("no model", 307, 1)


def test_quantiles_of_a_long_table_are_of_rows_spaced_evenly(tmp_path, monkeypatch):
    monkeypatch.setattr(results, "PIECE", 700)
    monkeypatch.setattr(module, "QUANTILE_ROWS", 1_000)
    count = 9_000
    table = pd.DataFrame({"run": np.arange(count), "x_rad": np.arange(count) / 1.0, "failure": ""})
    found = summarise(_write(table, tmp_path / "runs.csv"))
    assert found.rows == count
    assert found.sampled == len(np.arange(0, count, 16))
    expected = np.quantile(np.arange(0, count, 16), (0.05, 0.5, 0.95))
    np.testing.assert_allclose(found.columns[0].quantiles, expected)
    assert found.columns[0].mean == pytest.approx((count - 1) / 2.0)


def test_trajectories_are_counted_by_run(tmp_path, monkeypatch):
    monkeypatch.setattr(results, "PIECE", 40)
    table = pd.DataFrame(
        {
            "run": np.repeat([0, 1, 2, 3], [30, 1, 30, 30]),
            "time_s": np.linspace(0.0, 1.0, 91),
            "failure": ["lost" if i == 30 else "" for i in range(91)],
        }
    )
    found = summarise(_write(table, tmp_path / "runs.csv"))
    assert (found.runs, found.failed, found.rows) == (4, 1, 91)
    assert found.columns[0].highest_run == 3


def test_table_of_one_row_has_no_deviation(tmp_path):
    value = 0.1 + 0.2
    table = pd.DataFrame({"run": [0], "x_rad": [value], "failure": [""]})
    (column,) = summarise(_write(table, tmp_path / "runs.csv")).columns
    assert column.minimum == column.mean == pytest.approx(value, rel=1e-15)
    assert np.isnan(column.deviation)


def test_memory_does_not_grow_with_the_number_of_runs(tmp_path, monkeypatch):
    monkeypatch.setattr(results, "PIECE", 3_000)
    monkeypatch.setattr(module, "QUANTILE_ROWS", 1_000)
    peaks = []
    for count in (20_000, 80_000):
        path = _write(_table(count), tmp_path / f"{count}.csv")
        tracemalloc.start()
        summarise(path)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] < 1.5 * peaks[0]


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("absent.csv", None, "cannot be read"),
        ("empty.csv", "", "is no table of results"),
        ("other.csv", "time,angle\n0,1\n", "has no column 'run'"),
        ("half.csv", "run,x\n0,1\n", "has no column 'failure'"),
        ("text.csv", "run,failure\nfirst,\n", "is no table of results"),
        ("damaged.csv", "run,failure\n0,\n1,a,b,c\n", "is no table of results"),
        ("binary.csv", b"run,failure\n0,\xff\xfe\n", "is no table of results"),
        ("headers.csv", "run,failure\n", "has no rows"),
        ("no.parquet", "run,failure\n0,\n", "is no table of results"),
    ],
)
def test_what_is_no_table_of_results_is_told_in_one_sentence(tmp_path, name, content, said):
    path = tmp_path / name
    if content is not None:
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(SweepError) as refused:
        summarise(path)
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)
