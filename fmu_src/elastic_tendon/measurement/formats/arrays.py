"""Arrays in folders, as HDF5 and MATLAB keep them: which of them are columns of one table."""

from collections.abc import Iterator, Mapping, Sequence

from elastic_tendon.measurement.formats.base import Group


def series(name: str, shape: Sequence[int]) -> Iterator[tuple[str, int, bool, int | None]]:
    """Columns that an array holds.

    Samples run along the longer axis, since a recording has more samples than signals, and
    MATLAB's vectors lie either way.

    Parameters
    ----------
    name : of the array
    shape : of the array

    Yields
    ------
    name of the column, ``name[i]`` where there are several; its length; whether it runs along the
    second axis; its place on the other axis, None for a plain vector. Nothing for single values
    and for more than two axes
    """
    if len(shape) == 1 and shape[0] > 1:
        yield name, shape[0], False, None
    elif len(shape) == 2 and max(shape) > 1 and min(shape) > 0:
        across = shape[1] > shape[0]
        for i in range(min(shape)):
            yield f"{name}[{i}]" if min(shape) > 1 else name, max(shape), across, i


def grouped(folder: str, lengths: Mapping[str, int], units: Mapping[str, str]) -> Iterator[Group]:
    """Groups of the columns of one folder, one for each length.

    Parameters
    ----------
    folder : path of the folder
    lengths : column -> its rows
    units : column -> unit, where the file says one

    Yields
    ------
    Group; the longest columns keep the folder's name, others add their length to it, such as
    ``motor (100 rows)``
    """
    longest = max(lengths.values(), default=0)
    for rows in sorted(set(lengths.values()), reverse=True):
        columns = tuple(name for name, length in lengths.items() if length == rows)
        name = folder if rows == longest else f"{folder} ({rows} rows)".strip()
        own = {column: units[column] for column in columns if column in units}
        yield Group(name, columns, own, rows)
