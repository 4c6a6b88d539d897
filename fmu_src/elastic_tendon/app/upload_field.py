"""Where files are chosen or dropped."""

from typing import Any

from dash import dcc, html


def upload(component_id: str, words: str, most: int, *, tell: str) -> html.Div:
    """Where files are chosen or dropped; assets/uploads.js tells what is too large to be sent.

    Parameters
    ----------
    component_id : of the `dcc.Upload`
    words : what it says
    most : bytes that are taken at a time
    tell : id of the component that shows why a file is refused
    """
    where = dcc.Upload(
        words,
        id=component_id,
        max_size=most,
        multiple=True,
        className="drop",
        className_active="drop active",
    )
    for_script: dict[str, Any] = {"data-most": str(most), "data-tell": tell}
    return html.Div(where, **for_script)
