"""HDF5 groups come back with their rates and units, MAT 7.3 among them."""

from pathlib import Path

import h5py
import numpy as np
import pytest
from whole import assert_refused, group_named, truncated, whole

from elastic_tendon.measurement.formats import base, open_source

FAST, SLOW = np.arange(1000) * 0.001, np.arange(200) * 0.005


@pytest.fixture
def path(tmp_path: Path) -> Path:
    path = tmp_path / "run.h5"
    with h5py.File(path, "w") as file:
        file["time"], file["motor"] = FAST, np.sin(FAST)
        file["motor"].attrs["unit"] = "deg"
        file["sample_time"] = 0.001
        joint = file.create_group("bench/joint")
        joint["time"], joint["position"] = SLOW, np.cos(SLOW)
        joint["position"].attrs["units"] = np.bytes_("rad")
        joint["pair"] = np.stack([SLOW, -SLOW], axis=1)
        joint["slow"] = np.arange(20.0)
        fields = np.zeros(50, dtype=[("t", "f4"), ("tau", "f8"), ("n", "i4")])
        fields["tau"] = np.arange(50) / 4
        file["table"] = fields
        file["names"] = np.array(["a", "b"] * 500, dtype=object)
    return path


def test_arrays_of_one_length_are_a_group(path: Path, monkeypatch) -> None:
    monkeypatch.setattr(base, "CHUNK_ROWS", 300)
    source = open_source(path)
    assert {group.name: group.rows for group in source.groups} == {
        "": 1000,
        "bench/joint": 200,
        "bench/joint (20 rows)": 20,
        "table": 50,
    }
    root = whole(source)
    assert np.array_equal(root["time"], FAST)
    assert np.array_equal(root["motor"], np.sin(FAST))
    assert root["names"][[0, -1]].tolist() == ["a", "b"]
    joint = whole(source, "bench/joint")
    assert np.array_equal(joint["position"], np.cos(SLOW))
    assert np.array_equal(joint["pair[1]"], -SLOW)
    assert np.array_equal(whole(source, "bench/joint (20 rows)")["slow"], np.arange(20.0))
    assert np.array_equal(whole(source, "table")["tau"], np.arange(50) / 4)


def test_units_are_those_of_the_attributes(path: Path) -> None:
    source = open_source(path)
    assert group_named(source, "").units == {"motor": "deg"}
    assert group_named(source, "bench/joint").units == {"position": "rad"}


def test_a_truncated_file_is_refused(path: Path) -> None:
    assert_refused(truncated(path), "HDF5 file is damaged or not complete; export it again")


def test_a_file_without_arrays_is_refused(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "run.h5", "w") as file:
        file["gain"] = 3.0
    assert_refused(tmp_path / "run.h5", "no columns of numbers")


def test_a_million_columns_are_refused(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "run.h5", "w") as file:
        file.create_dataset("wide", shape=(2000, 2000, 2), dtype="f8")
        file.create_dataset("square", shape=(20_000, 20_000), dtype="f8")
    assert_refused(tmp_path / "run.h5", "20000 columns and may have 10000")


def test_mat_7_3_is_read_as_matlab_writes_it(tmp_path: Path) -> None:
    path = tmp_path / "run.mat"
    with h5py.File(path, "w", userblock_size=512) as file:
        file["t"] = FAST[None, :]  # MATLAB's columns are rows here
        file["both"] = np.stack([FAST, -FAST])
        file["title"] = np.array([[ord(letter)] for letter in "jaw"], dtype=np.uint16)
        file["title"].attrs["MATLAB_class"] = np.bytes_("char")
        file["none"] = np.array([0, 0], dtype=np.uint64)
        file["none"].attrs["MATLAB_empty"] = 1
        file["log/q"] = SLOW[:, None]
        file["#refs#/a"] = np.arange(7.0)
    with path.open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(116) + b" " * 8 + b"\0\2IM")
    source = open_source(path)
    assert [group.columns for group in source.groups] == [("both[0]", "both[1]", "t"), ("q",)]
    assert np.array_equal(whole(source)["both[1]"], -FAST)
    assert np.array_equal(whole(source, "log")["q"], SLOW)


@pytest.mark.parametrize("key", ["unit", "Units", "UNIT"])
@pytest.mark.parametrize("value", ["deg", np.bytes_("deg"), ["deg"], [b"deg"]])
def test_unit_is_found_however_it_is_stored(tmp_path: Path, key: str, value: object) -> None:
    with h5py.File(tmp_path / "run.h5", "w") as file:
        file["q"] = FAST
        file["q"].attrs[key] = value
    assert open_source(tmp_path / "run.h5").groups[0].units == {"q": "deg"}


def test_numbers_are_unpacked_as_netcdf_packs_them(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "run.h5", "w") as file:
        file["q"] = np.array([0, 10, -9999, 30], dtype=np.int16)
        file["q"].attrs["scale_factor"] = np.array([0.1])
        file["q"].attrs["add_offset"] = 2.0
        file["q"].attrs["_FillValue"] = np.int16(-9999)
        file["plain"] = np.arange(4.0)
        file["plain"].attrs["_FillValue"] = np.nan
    table = whole(open_source(tmp_path / "run.h5"))
    assert table["q"] == pytest.approx([2.0, 3.0, np.nan, 5.0], nan_ok=True)
    assert table["plain"].tolist() == [0.0, 1.0, 2.0, 3.0]


def test_a_timetable_is_refused_with_what_to_do(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "run.mat", "w") as file:
        file["log"] = np.array([[3707764736, 2, 1, 1, 1, 1]], dtype=np.uint32)
        file["log"].attrs["MATLAB_class"] = np.bytes_("timetable")
        file["log"].attrs["MATLAB_object_decode"] = np.int32(3)
    assert_refused(tmp_path / "run.mat", "log is a MATLAB timetable", "save its columns as vectors")


def test_logical_and_complex_arrays_are_passed_on_as_such(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "run.mat", "w") as file:
        file["on"] = np.array([1, 0, 1], dtype=np.uint8)
        file["on"].attrs["MATLAB_class"] = np.bytes_("logical")
        file["z"] = np.array([1j, 2.0, 3.0])
    table = whole(open_source(tmp_path / "run.mat"))
    assert table["on"].dtype == bool
    assert table["z"].dtype == object
