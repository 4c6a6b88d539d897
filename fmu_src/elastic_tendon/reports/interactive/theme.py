"""How every interactive figure looks: the one place for colours, fonts and margins."""

import html
import textwrap
from dataclasses import astuple, dataclass
from functools import cache
from typing import Any

import plotly.graph_objects as go
from plotly.subplots import make_subplots

from elastic_tendon.reports.comparison_figures import (
    BLUE,
    GREEN,
    ORANGE,
    PURPLE,
    SKY,
    VERMILLION,
)

CLEAR = "rgba(0,0,0,0)"  # the ground of the page shows through
FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', Arial, sans-serif"
COLUMNS = 3  # panels side by side
# heights: of panels, between them, and of what is around all, pixels; between them is enough for
# the name of an axis to stand closer to its own panel than to the one below
ROW, GAP, HEAD = 230, 105, 130
# of plotly's own buttons and gestures; wherever a figure is shown
CONFIG: dict[str, Any] = {
    "displaylogo": False,
    # a button that would send the figure's data to a server of plotly's makers
    "showSendToCloud": False,
    "plotlyServerURL": "",
    "scrollZoom": True,
    "responsive": True,
    "modeBarButtonsToRemove": ["lasso2d", "select2d"],
    "toImageButtonOptions": {"format": "svg", "filename": "elastic-tendon"},
}


@dataclass(frozen=True)
class Theme:
    """Colours of a figure upon a page of the colour `background`.

    `ink` and `muted` are for text, at least 4.5 to 1 against the background; the colours of curves
    have at least 3 to 1. `measured` is the recording, `before` and `after` the model without and
    with what was added, `more` other models beside these. `band` is filled where noise lies, a
    translucent grey; `stands_out` and `quiet` mark errors above the noise and others;
    `highlight` is laid under chosen samples, translucent. `states` are for slack states I, II,
    III and both slack. `blank` fills map cells without samples; `sequential` and `diverging` are
    colour scales by name, and the middle of the latter is zero.
    """

    name: str
    background: str
    ink: str
    muted: str
    grid: str
    measured: str
    before: str
    after: str
    more: tuple[str, ...]
    stands_out: str
    quiet: str
    band: str
    highlight: str
    states: tuple[str, str, str, str]
    blank: str
    sequential: str
    diverging: str

    @property
    def runs(self) -> tuple[str, ...]:
        """Colours of models side by side, the one before first."""
        return (self.before, self.after, *self.more)


LIGHT = Theme(
    name="light",
    background="#FFFFFF",
    ink="#1A1A1A",
    muted="#595959",
    grid="#E6E6E6",
    measured="#000000",
    before=VERMILLION,  # orange has too little contrast on white
    after=BLUE,
    more=(GREEN, "#A64D79", "#7A5C00"),
    stands_out=VERMILLION,
    quiet="#8C8C8C",
    band="rgba(120,120,120,0.22)",
    highlight="rgba(204,121,167,0.35)",
    states=(BLUE, ORANGE, GREEN, PURPLE),
    blank="#D9D9D9",
    sequential="Viridis",
    diverging="RdBu_r",
)
DARK = Theme(
    name="dark",
    background="#14181D",
    ink="#F0F0F0",
    muted="#B4B8BD",
    grid="#33383F",
    measured="#F5F5F5",
    before=ORANGE,
    after=SKY,
    more=(GREEN, PURPLE, "#F0E442"),
    stands_out=ORANGE,
    quiet="#7D838B",
    band="rgba(170,175,185,0.25)",
    highlight="rgba(204,121,167,0.40)",
    states=(SKY, ORANGE, GREEN, PURPLE),
    blank="#33383F",
    sequential="Viridis",
    diverging="RdBu_r",
)
THEMES = {theme.name: theme for theme in (LIGHT, DARK)}


def light_by_dark() -> dict[str, str]:
    """Colours of the light theme by those of the dark in small letters, for figures on paper.

    One that the dark theme has in several places becomes what stands in the first of them.
    """
    dark, light = map(_colours, (DARK, LIGHT))
    return {ours.lower(): theirs for ours, theirs in reversed([*zip(dark, light, strict=True)])}


def _colours(theme: Theme) -> list[str]:
    """All colours, in the order of the fields; scales, which are named, are the same in both."""
    _, *values = astuple(theme)
    every = (value if isinstance(value, tuple) else (value,) for value in values)
    return [colour for colours in every for colour in colours if colour[:1] in "#r"]


def noise_band(sigma: float, theme: Theme) -> dict[str, Any]:
    """How two sigma of the noise to either side are drawn along a figure."""
    style = {"fillcolor": theme.band, "line": {"width": 0}, "layer": "below"}
    band = {"y0": -2.0 * sigma, "y1": 2.0 * sigma}
    return band | style | {"name": "± 2σ of the noise", "showlegend": True}


def plain(text: str) -> str:
    """Text of users as plotly draws it letter by letter, where it would read some HTML.

    Parameters
    ----------
    text : str; the name of a recording, a model, an effect
    """
    return html.escape(text, quote=False)


def broken(text: str, width: int = 20) -> str:
    """Text that is plain already, in lines of so many letters where its words are no longer."""
    return "<br>".join(textwrap.wrap(text, width, break_long_words=False))


def upright(text: str) -> str:
    """Title of an axis that goes up, in lines that fit beside a low panel, as on paper."""
    return broken(text, 14)


def blank(theme: Theme, **layout: Any) -> go.Figure:
    """An empty figure.

    Parameters
    ----------
    theme : Theme
    layout : as of `plotly.graph_objects.Layout`
    """
    return dressed(go.Figure(), theme, **layout)


def dressed(figure: go.Figure, theme: Theme, **layout: Any) -> go.Figure:
    """The same figure with the style of a theme; for those of `plotly.subplots`.

    Parameters
    ----------
    figure : go.Figure, changed
    theme : Theme
    layout : as of `plotly.graph_objects.Layout`
    """
    figure.update_layout(template=_template(theme), **layout)
    # titles of panels are annotations; plotly sets them large
    figure.update_annotations(font={"size": 13, "color": theme.ink})
    return figure


def panels(theme: Theme, count: int, **layout: Any) -> go.Figure:
    """A figure of so many panels, `COLUMNS` side by side; `place_of` says where each is.

    Parameters
    ----------
    theme : Theme
    count : int, positive
    layout : as of `plotly.graph_objects.Layout`
    """
    columns = min(COLUMNS, count)
    rows = -(-count // columns)
    height = ROW * rows + HEAD
    space = {"vertical_spacing": GAP / (ROW * rows), "horizontal_spacing": 0.12}
    figure = make_subplots(rows, columns, **space)
    for index in range(count, rows * columns):
        figure.update_xaxes(visible=False, **place_of(index, count))
        figure.update_yaxes(visible=False, **place_of(index, count))
    return dressed(figure, theme, height=height, **layout)


def place_of(index: int, count: int) -> dict[str, int]:
    """Row and column, from 1, of the panel with a number from 0 among so many."""
    row, column = divmod(index, min(COLUMNS, count))
    return {"row": row + 1, "col": column + 1}


@cache
def _template(theme: Theme) -> go.layout.Template:
    axis = {
        "gridcolor": theme.grid,
        "linecolor": theme.muted,
        "showline": True,
        "ticks": "outside",
        "tickcolor": theme.muted,
        "ticklen": 4,
        "zeroline": False,
        "automargin": True,
        "title": {"standoff": 8},
        # plotly lays white below a spike where the ground is clear, which is glaring on dark
        "showspikes": False,
    }
    return go.layout.Template(
        layout={
            "font": {"family": FONT, "size": 13, "color": theme.ink},
            "paper_bgcolor": CLEAR,
            "plot_bgcolor": CLEAR,
            "title": {
                "font": {"size": 15},
                "x": 0.0,
                "xref": "paper",
                "xanchor": "left",
                "y": 1.0,
                "yref": "container",
                "yanchor": "top",
                "pad": {"t": 8},
            },
            # above: the title and a legend of two rows
            "margin": {"l": 64, "r": 16, "t": 88, "b": 48},
            "legend": {
                "orientation": "h",
                "x": 0.0,
                "y": 1.02,
                "yanchor": "bottom",
                "bgcolor": CLEAR,
            },
            "hoverlabel": {
                "bgcolor": theme.background,
                "bordercolor": theme.muted,
                "font": {"family": FONT, "color": theme.ink, "size": 12},
                "align": "left",
            },
            "modebar": {"bgcolor": CLEAR, "color": theme.muted, "activecolor": theme.ink},
            "xaxis": axis,
            "yaxis": axis,
        }
    )
