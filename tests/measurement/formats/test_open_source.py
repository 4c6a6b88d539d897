"""A file's format is told by its content; what is not read is said by its name."""

import os
import sys
from pathlib import Path

import pandas as pd
import pytest
from whole import assert_refused, whole

from elastic_tendon.errors import MeasurementError
from elastic_tendon.measurement.formats import open_source


def test_a_folder_and_a_missing_file_are_refused(tmp_path: Path) -> None:
    assert_refused(tmp_path, "this is a folder; name one file in it")
    assert_refused(tmp_path / "none.csv", "there is no such file")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no named pipes here")
def test_a_pipe_is_refused_and_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "run.csv")
    assert_refused(tmp_path / "run.csv", "is a device")


def test_a_file_without_permission_is_refused(tmp_path: Path, monkeypatch) -> None:
    path = tmp_path / "run.csv"
    path.write_text("time_s,q\n0,1\n")

    def forbidden(*_args: object, **_options: object) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "open", forbidden)  # root may read every file
    with pytest.raises(MeasurementError, match=r"cannot be read \(Permission denied\)"):
        open_source(path)


@pytest.mark.parametrize(
    ("beginning", "what"),
    [
        (b"\x89PNG\r\n\x1a\n", "PNG picture"),
        (b"PK\x03\x04", "an Excel workbook, arrays of NumPy"),
        (b"\x93NUMPY\x01\x00", "an array of NumPy"),
        (b"\xd0\xcf\x11\xe0", "Excel workbook"),
        (b"%PDF-1.7", "PDF"),
        (b"\x1f\x8b\x08", "gzip"),
        (b"\xff\xfet\x00", "UTF-16"),
        (b"#ROSBAG V2.0\n", "bag of ROS 1"),
    ],
)
def test_what_is_no_measurement_is_named(tmp_path: Path, beginning: bytes, what: str) -> None:
    path = tmp_path / "run.csv"
    path.write_bytes(beginning + bytes(range(256)))
    assert_refused(path, what, "save the table as CSV")


def test_the_content_decides_where_the_suffix_lies(tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    pd.DataFrame({"time_s": [0.0, 0.1], "q": [1.0, 2.0]}).to_parquet(path)
    assert whole(open_source(path))["q"].tolist() == [1.0, 2.0]


@pytest.mark.parametrize("suffix", ["parquet", "h5", "mat", "mf4", "mcap", "db3"])
def test_a_beginning_that_is_lost_is_damage(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"run.{suffix}"
    path.write_bytes(b"\x07nothing that any format begins with" * 50)
    assert_refused(path, "is damaged or not complete; export it again")


@pytest.mark.parametrize(
    ("beginning", "module", "library", "kind"),
    [
        (b"PAR1", "parquet", "pyarrow", "Parquet"),
        (b"\x89HDF\r\n\x1a\n", "hdf5", "h5py", "HDF5"),
        (b"MDF     ", "mdf", "asammdf", "MDF"),
        (b"\x89MCAP0\r\n", "rosbag", "rosbags.highlevel", "ROS 2 bags"),
    ],
)
def test_a_missing_library_is_named_with_how_to_install_it(
    tmp_path: Path, monkeypatch, beginning: bytes, module: str, library: str, kind: str
) -> None:
    path = tmp_path / "run.log"
    path.write_bytes(beginning + bytes(100))
    monkeypatch.setitem(sys.modules, library, None)
    monkeypatch.delitem(sys.modules, f"elastic_tendon.measurement.formats.{module}", raising=False)
    wanted = f"{kind} needs {library}, which is not installed"
    assert_refused(path, wanted, 'pip install "elastic-tendon[formats]"')
