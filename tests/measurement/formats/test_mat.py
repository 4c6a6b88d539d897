"""MAT files up to version 7 come back by variable and struct."""

from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat
from scipy.sparse import csc_matrix
from whole import assert_refused, group_named, truncated, whole

from elastic_tendon.measurement.formats import open_source

T = np.arange(300) * 0.01


@pytest.mark.parametrize("compressed", [False, True])
def test_variables_and_structs_are_groups(tmp_path: Path, compressed: bool) -> None:
    path = tmp_path / "run.mat"
    slow = {"t": T[::10], "q": np.sin(T[::10]), "inner": {"tau": T}}
    content = {"time": T[:, None], "motor": T[None, :] ** 2, "log": slow, "gain": 3.0, "title": "x"}
    savemat(path, {**content, "pair": np.stack([T, -T], axis=1)}, do_compression=compressed)
    source = open_source(path)
    assert {group.name: group.rows for group in source.groups} == {
        "": 300,
        "log": 30,
        "log/inner": 300,
    }
    root = whole(source)
    assert np.array_equal(root["time"], T)
    assert np.array_equal(root["motor"], T**2)
    assert np.array_equal(root["pair[1]"], -T)
    assert np.array_equal(whole(source, "log")["q"], np.sin(T[::10]))
    assert source.first_row == 1


def test_simulink_structure_with_time_is_one_group(tmp_path: Path) -> None:
    signals = [
        {"values": np.sin(T)[:, None], "label": "motor", "dimensions": 1},
        {"values": np.stack([T, -T], axis=1), "label": "", "dimensions": 2},
    ]
    array = np.empty(2, dtype=object)
    array[:] = signals
    savemat(tmp_path / "several.mat", {"log": {"time": T, "signals": array}})
    source = open_source(tmp_path / "several.mat")
    assert set(group_named(source, "log").columns) == {
        "time",
        "motor",
        "signals[1][0]",
        "signals[1][1]",
    }
    assert np.array_equal(whole(source, "log")["motor"], np.sin(T))
    savemat(tmp_path / "one.mat", {"log": {"time": T, "signals": signals[0]}})
    assert set(open_source(tmp_path / "one.mat").groups[0].columns) == {"time", "motor"}


def test_version_4_is_read_by_its_suffix(tmp_path: Path) -> None:
    savemat(tmp_path / "run.mat", {"time": T, "q": 2 * T}, format="4")
    assert np.array_equal(whole(open_source(tmp_path / "run.mat"))["q"], 2 * T)


def test_a_truncated_file_is_refused(tmp_path: Path) -> None:
    savemat(tmp_path / "run.mat", {"time": T, "q": 2 * T})
    assert_refused(truncated(tmp_path / "run.mat"), "MAT file is damaged or not complete")


def test_sparse_vectors_are_filled_logical_and_complex_ones_kept_as_such(tmp_path: Path) -> None:
    sparse = csc_matrix(np.where(T > 1.0, T, 0.0)[:, None])
    savemat(tmp_path / "run.mat", {"time": sparse, "on": T > 1.0, "z": T + 1j})
    table = whole(open_source(tmp_path / "run.mat"))
    assert np.array_equal(table["time"], np.where(T > 1.0, T, 0.0))
    assert table["on"].dtype == bool
    assert table["z"].dtype == object
