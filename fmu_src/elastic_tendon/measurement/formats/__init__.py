"""Files of measurements, one module for each format."""

from pathlib import Path

from elastic_tendon.measurement.formats.base import Group, Report, Source, silent

__all__ = ["Group", "Report", "Source", "open_source", "silent"]


def open_source(path: Path) -> Source:
    """Open a file of measurements; which format it has, its first bytes say.

    Parameters
    ----------
    path : a file, or the folder of a ROS 2 bag

    Returns
    -------
    Source

    Raises
    ------
    MeasurementError : there is no such file, it cannot be read, or it is of no known format
    """
    raise NotImplementedError(path)
