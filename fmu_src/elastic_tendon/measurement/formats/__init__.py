"""Files of measurements, one module for each format."""

from importlib import import_module
from pathlib import Path

from elastic_tendon.errors import MeasurementError
from elastic_tendon.measurement.formats.base import Group, Source
from elastic_tendon.progress import Progress, silent

__all__ = ["Group", "Progress", "Source", "open_source", "silent"]

# how a file of a format begins -> module here that reads it; a bag may be one file of a folder
_BEGINNINGS = {
    b"PAR1": "parquet",
    b"\x89HDF\r\n\x1a\n": "hdf5",
    b"MATLAB 7.3": "hdf5",
    b"MATLAB 5.0": "mat",
    b"MDF     ": "mdf",
    b"UnFinMF ": "mdf",
    b"\x89MCAP0\r\n": "rosbag",
    b"SQLite format 3\x00": "rosbag",
}
# a damaged beginning, and MAT version 4, which has none of its own
_SUFFIXES = {
    ".parquet": "parquet",
    ".h5": "hdf5",
    ".hdf5": "hdf5",
    ".mat": "mat",
    ".mf4": "mdf",
    ".mdf": "mdf",
    ".mcap": "rosbag",
    ".db3": "rosbag",
}
_NOT_READ = {
    b"PK\x03\x04": "an Excel workbook, arrays of NumPy, or another zip archive",
    b"\x93NUMPY": "an array of NumPy",
    b"\xd0\xcf\x11\xe0": "an Excel workbook",
    b"\x89PNG": "a PNG picture",
    b"\xff\xd8\xff": "a JPEG picture",
    b"%PDF": "a PDF document",
    b"\x1f\x8b": "a gzip archive",
    b"#ROSBAG V": "a bag of ROS 1",
    b"\xff\xfe": "text in UTF-16",
    b"\xfe\xff": "text in UTF-16",
}
_KINDS = {"parquet": "Parquet", "hdf5": "HDF5", "mdf": "MDF", "rosbag": "ROS 2 bags"}


def open_source(path: Path) -> Source:
    """Open a file of measurements.

    Which format it has, its first bytes say, whatever the suffix; where they are of no known
    format, the suffix; else it is text.

    Parameters
    ----------
    path : a file, or the folder of a ROS 2 bag

    Returns
    -------
    Source

    Raises
    ------
    MeasurementError : there is no such file, it cannot be read, it is damaged, or it is of a
        format that is not read
    """
    module = "rosbag" if (path / "metadata.yaml").is_file() else _format(path)
    try:
        reader = import_module(f"{__name__}.{module}")
    except ModuleNotFoundError as error:
        raise MeasurementError(
            f"{path.name}: reading {_KINDS[module]} needs {error.name}, which is not installed; "
            'pip install "elastic-tendon[formats]"'
        ) from None
    source: Source = reader.open_file(path)
    return source


def _format(path: Path) -> str:
    head = _head(path)
    if not head.strip():
        raise MeasurementError(
            f"{path.name}: the file is empty; it needs a header and one row for each sample"
        )
    for beginning, what in _NOT_READ.items():
        if head.startswith(beginning):
            raise MeasurementError(f"{path.name}: this is {what}; save the table as CSV in UTF-8")
    for beginning, module in _BEGINNINGS.items():
        if head.startswith(beginning):
            return module
    return _SUFFIXES.get(path.suffix.lower(), "text")


def _head(path: Path) -> bytes:
    """First bytes of a file; enough of them that only an empty file has nothing but blanks."""
    if path.is_dir():
        raise MeasurementError(f"{path}: this is a folder; name one file in it")
    try:
        if path.exists() and not path.is_file():
            raise MeasurementError(f"{path}: this is a device; save its data in a file")
        with path.open("rb") as file:
            return file.read(4096)
    except FileNotFoundError:
        raise MeasurementError(
            f"{path}: there is no such file; check the name and the folder"
        ) from None
    except OSError as error:
        raise MeasurementError(
            f"{path}: the file cannot be read ({error.strerror}); check its permissions"
        ) from None
