"""A whole table of results, as `sweep` has written it."""

from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from elastic_tendon.sweeps.task import FAILURE


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
    if path.suffix.lower() == ".parquet":
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
