"""Reports in the units and words of a machine that turns or slides; they are made for the former.

Commands, code and data stay as they are, and the panel of `fmu.live`, which has its words already.
"""

import json
from dataclasses import fields, replace
from typing import Any

import plotly.graph_objects as go
from matplotlib.figure import Figure
from matplotlib.text import Text

from elastic_tendon.actuator.motion_kind import MotionKind
from elastic_tendon.fmu.live import script_safe
from elastic_tendon.reports.html.blocks import Code, Live, Plot

_DATA = ("bdata", "customdata")  # of a figure's JSON, which holds no words


def worded_figure(figure: Figure, motion: MotionKind) -> Figure:
    """The figure with its texts in the words of this motion."""
    if motion is not MotionKind.ROTARY:
        for text in figure.findobj(Text):
            text.set_text(motion.words(text.get_text()))
    return figure


def worded_blocks(value: Any, motion: MotionKind) -> Any:
    """Blocks of a page, at any depth, in the words of this motion.

    Parameters
    ----------
    value : a block of `html.blocks`, text, or a tuple of these
    motion : MotionKind
    """
    if motion is MotionKind.ROTARY or isinstance(value, Code | Live):
        return value
    if isinstance(value, str):
        return motion.words(value)
    if isinstance(value, tuple):
        return tuple(worded_blocks(item, motion) for item in value)
    if isinstance(value, Plot):
        light, dark = (_json(text, motion) for text in (value.light, value.dark))
        return replace(value, words=motion.words(value.words), light=light, dark=dark)
    if not hasattr(value, "__dataclass_fields__"):
        return value
    changed = {
        part.name: worded_blocks(getattr(value, part.name), motion) for part in fields(value)
    }
    return replace(value, **changed)


def worded_plotly(figure: go.Figure, motion: MotionKind) -> go.Figure:
    """The interactive figure with its texts in the words of this motion."""
    if motion is MotionKind.ROTARY:
        return figure
    # part by part: as a whole its arrays would become text
    parts = (*figure.data, figure.layout)
    *traces, layout = (worded_tree(part.to_plotly_json(), motion) for part in parts)
    return go.Figure(traces, layout)


def _json(text: str, motion: MotionKind) -> str:
    return script_safe(worded_tree(json.loads(text), motion))


def worded_tree(value: Any, motion: MotionKind) -> Any:
    """An interactive figure as plain data, its texts in the words of this motion."""
    if isinstance(value, dict):
        return {
            key: item if key in _DATA else worded_tree(item, motion) for key, item in value.items()
        }
    if isinstance(value, list):
        return [worded_tree(item, motion) for item in value]
    return motion.words(value) if isinstance(value, str) else value
