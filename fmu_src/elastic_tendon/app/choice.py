"""A list to choose from, with a name that readers of the screen are told."""

from typing import Any

from dash import dcc, html


def choice(component_id: str, words: str, **options: Any) -> html.Label:
    """A named list to choose from.

    Parameters
    ----------
    component_id : of the `dcc.Dropdown`
    words : its name
    options : of the `dcc.Dropdown`
    """
    # Dash names a list by the element of this id, whatever its label says
    name = html.Span(words, id=f"{component_id}-value-count")
    return html.Label([name, dcc.Dropdown(id=component_id, **options)], htmlFor=component_id)
