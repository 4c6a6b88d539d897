"""A table of results, as `sweep` has written it: whole, or in pieces where it may be large."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from elastic_tendon.sweeps.task import FAILURE, RUN, TEXTS

PIECE = 200_000  # numbers read at once
BUFFER = 100_000  # bytes of each column of Parquet
OF_EFFECTS = "effects."  # how the columns begin that few robots of a fleet have numbers in


def read_results(path: Path, texts: Sequence[str] = (FAILURE,)) -> pd.DataFrame:
    """Read a table of CSV, or of Parquet where it is called ``.parquet``.

    Parameters
    ----------
    path : of the table
    texts : columns that hold text; where there is none they are ""

    Returns
    -------
    DataFrame
    """
    if _is_parquet(path):
        from pyarrow import parquet

        # column by column, or all of it would be in memory twice
        read = parquet.read_table(path)
        table: pd.DataFrame = read.to_pandas(split_blocks=True, self_destruct=True)
        return table
    # a text may look like a number, or be NA
    table = pd.read_csv(
        path,
        dtype=dict.fromkeys(texts, str),
        keep_default_na=False,
        na_values=[""],
    )
    return table.fillna(dict.fromkeys(texts, ""))


def read_fleet(path: Path) -> pd.DataFrame:
    """Read the table of a `Fleet` in little memory: numbers of effects are sparse columns.

    Parameters
    ----------
    path : of the table, CSV or Parquet

    Returns
    -------
    DataFrame
    """
    if _is_parquet(path):
        from pyarrow import parquet

        # column by column, as pieces of rows would be there beside what they are put together to
        with parquet.ParquetFile(path, pre_buffer=False) as file:
            names = file.schema_arrow.names
            _check_columns(names)
            columns = {
                name: _sparse(file.read([name], use_threads=False).to_pandas())[name]
                for name in names
            }
        return pd.DataFrame(columns, copy=False)
    # copies, or views of a few columns would keep all of a piece
    return pd.concat([_sparse(piece).copy() for piece in pieces(path, TEXTS)], ignore_index=True)


def _sparse(table: pd.DataFrame) -> pd.DataFrame:
    kind = pd.SparseDtype(np.float64, np.nan)
    return table.astype({name: kind for name in table if str(name).startswith(OF_EFFECTS)})


def pieces(path: Path, texts: Sequence[str] = (FAILURE,)) -> Iterator[pd.DataFrame]:
    """Rows of a table, some at a time.

    Parameters
    ----------
    path : of the table, CSV or Parquet
    texts : columns that hold text; where there is none they are ""

    Raises
    ------
    ValueError : the file is no table of results
    """
    if _is_parquet(path):
        from pyarrow import parquet

        with parquet.ParquetFile(path, pre_buffer=False, buffer_size=BUFFER) as file:
            names = file.schema_arrow.names
            _check_columns(names)
            for group in range(file.num_row_groups):
                # what pyarrow reads ahead of several groups would add up to the whole file
                batches = file.iter_batches(_rows_of_piece(len(names)), row_groups=[group])
                for batch in batches:
                    yield batch.to_pandas()
        return
    names = list(pd.read_csv(path, nrows=0).columns)
    _check_columns(names)
    with pd.read_csv(
        path,
        chunksize=_rows_of_piece(len(names)),
        dtype={RUN: np.int64, **dict.fromkeys(texts, str)},
        keep_default_na=False,
        na_values=[""],
        low_memory=False,
    ) as read:
        for piece in read:
            yield piece.fillna(dict.fromkeys(texts, ""))


def _is_parquet(path: Path) -> bool:
    return path.suffix.lower() == ".parquet"


def _rows_of_piece(columns: int) -> int:
    return max(1, PIECE // columns)


def _check_columns(names: list[str]) -> None:
    missing = [name for name in (RUN, FAILURE) if name not in names]
    if missing:
        raise ValueError(f"it has no column {missing[0]!r}; give a file that a sweep has written")
