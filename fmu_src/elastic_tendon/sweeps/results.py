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
        return pd.read_parquet(path)
    # a text may look like a number, or be NA
    table = pd.read_csv(
        path,
        dtype=dict.fromkeys(texts, str),
        keep_default_na=False,
        na_values=[""],
    )
    return table.fillna(dict.fromkeys(texts, ""))
