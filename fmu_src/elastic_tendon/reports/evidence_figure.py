"""Errors that an FMU states, beside those that its own binary makes."""

import numpy as np
from matplotlib.figure import Figure

from elastic_tendon.evidence.verify import Verification


def evidence_figure(found: Verification) -> Figure:
    """Draw the stated and the replayed error of each recording and signal.

    Parameters
    ----------
    found : Verification

    Returns
    -------
    Figure; bars over recordings and signals, RMS errors in SI units
    """
    table = found.to_dataframe()
    figure = Figure(figsize=(6.4, 1.4 + 0.5 * len(table)), layout="constrained")
    axes = figure.subplots()
    places = np.arange(len(table))
    for column, shift in (("stated", -0.2), ("replayed", 0.2)):
        axes.barh(places + shift, table[column].astype(float), 0.4, label=column)
    axes.set_yticks(places, [f"{row.recording}\n{row.signal}" for row in table.itertuples()])
    axes.invert_yaxis()
    axes.set_xlabel("RMS error (SI unit of the signal)")
    axes.set_title(found.name)
    axes.legend()
    return figure
