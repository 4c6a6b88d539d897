"""What a figure shows as a table, for whoever wants to draw it anew."""

import html
import re
from typing import TYPE_CHECKING, Any

import numpy as np
import plotly.graph_objects as go

if TYPE_CHECKING:
    import pandas as pd

CURVE = "curve"  # the column that says of which curve a row is
NAME = "name"  # that of what stands along an axis without numbers


def figure_table(figure: go.Figure) -> "pd.DataFrame":
    """Points of all curves of a figure below each other; of a map, its cells.

    Parameters
    ----------
    figure : of this package

    Returns
    -------
    pandas.DataFrame; a column with the name of the curve, and one for each title of an axis, with
    its unit, empty where a curve has nothing to do with it
    """
    import pandas as pd

    tables = [pd.DataFrame(_columns(figure, trace)) for trace in figure.data]
    return pd.concat(tables, ignore_index=True) if tables else pd.DataFrame({CURVE: []})


def _columns(figure: go.Figure, trace: Any) -> dict[str, Any]:
    across, up = (_axis(figure, letter, getattr(trace, f"{letter}axis")) for letter in "xy")
    horizontal, vertical = _title(figure, across, "x"), _title(figure, up, "y")
    if trace.type == "heatmap":
        middles = (
            0.5 * (np.asarray(values[1:]) + np.asarray(values[:-1]))
            for values in (trace.x, trace.y)
        )
        x, y = np.meshgrid(*middles)
        cells = {horizontal: x, vertical: y, _words(trace.name): np.asarray(trace.z)}
        return {name: values.ravel() for name, values in cells.items()}
    columns = {horizontal: _places(trace.x, across), vertical: _places(trace.y, up)}
    return {CURVE: _words(trace.name or ""), **columns}


def _axis(figure: go.Figure, letter: str, name: str | None) -> Any:
    """The axis that a curve calls "x2", of the layout's name "xaxis2"."""
    return figure.layout[f"{letter}axis{(name or letter)[1:]}"]


def _title(figure: go.Figure, axis: Any, letter: str) -> str:
    """Title of an axis, or of the one it moves with; only the outer one of these may have one.

    Only an axis of names, such as those of steps, has none.
    """
    if axis.title.text is None and axis.matches is not None:
        axis = _axis(figure, letter, axis.matches)
    return _words(axis.title.text or NAME)


def _places(values: Any, axis: Any) -> Any:
    """What stands below points on an axis with words instead of numbers, else the values."""
    words = dict(zip(axis.tickvals, axis.ticktext, strict=True)) if axis.ticktext else {}
    if words and all(value in words for value in values):
        return [_words(words[value]) for value in values]
    return values


def _words(text: str) -> str:
    """Text as it is read, without what plotly takes for markup."""
    return html.unescape(re.sub("<[^>]*>", " ", text))
