"""The catalogue of effects: a page of each, from its file, with a picture of how it shows."""

import inspect
import re
from pathlib import Path

import matplotlib as mpl

import elastic_tendon as et
from elastic_tendon.actuator.parameters import typical_value
from elastic_tendon.actuator.quantity import unit_text
from elastic_tendon.effects.base import LAW_SYMBOLS, Effect
from elastic_tendon.reports.effects import ACTS_ON, effect_sections
from elastic_tendon.reports.signature_figure import signature_figure
from elastic_tendon.simulation.signature import signature
from site_pages import Pages
from site_pages.law import typeset
from site_pages.markdown import code, plain, sidebar, table

EXAMPLE = et.load_model("biorob_x4_joint_3")  # on which typical values and pictures are
CATALOGUE = et.effects.CATALOGUE


def pages(folder: Path) -> Pages:
    """A page for each effect, and one of all; their pictures go to the folder ``effects``."""
    (folder / "effects").mkdir()
    for effect in CATALOGUE:
        _draw(effect, folder / "effects" / f"{effect.id}.svg")
        yield f"effects/{effect.id}.md", _page(effect)
    rows = (
        (f"[{effect.title}]({effect.id}.md)", f"`{effect.id}`", ACTS_ON[effect.slot])
        for effect in CATALOGUE
    )
    overview = f"# Effects\n\n{table(('effect', 'id', 'acts on'), rows)}\n"
    yield "effects/index.md", overview + sidebar(effect.id for effect in CATALOGUE)


def _draw(effect: Effect, path: Path) -> None:
    with mpl.rc_context({"svg.hashsalt": effect.id, "font.size": 12}):
        figure = signature_figure(signature(effect, EXAMPLE))
        figure.savefig(path, metadata={"Date": None})


def _page(effect: Effect) -> str:
    """The sections of `elastic-tendon effects ID`, law and numbers as formulas and as a table."""
    picture = f"[![How {effect.title} shows]({effect.id}.svg)]({effect.id}.svg)"
    parts = [f"# {effect.title}", f"`{effect.id}`", plain(effect.physics), picture]
    for heading, paragraphs in effect_sections(effect, EXAMPLE)[1:]:
        kind = heading.partition(",")[0]
        parts.append(f"## {heading}")
        if kind == "Law":
            parts.append(_law(effect))
        elif kind == "Parameters":
            parts.append(_numbers(effect))
        else:
            parts += [_linked(paragraph, effect) for paragraph in paragraphs]
    return "\n\n".join(["---\nhide-toc: true\n---", *parts])


def _law(effect: Effect) -> str:
    """Its formulas, what their letters mean, and the code that computes them."""
    lines = typeset(effect.law, [parameter.name for parameter in effect.parameters])
    shown = "\n".join(f"* {line}" for line in lines)
    source = code(inspect.getsource(effect.equations), "python")
    return f"{shown}\n\n{LAW_SYMBOLS} In its file:\n\n{source}"


def _numbers(effect: Effect) -> str:
    rows = (
        (
            *(
                f"`{parameter.name}`",
                unit_text(parameter.unit),
                f"{typical_value(EXAMPLE, parameter):.3g}",
            ),
            *(
                f"{parameter.null:g}",
                f"{parameter.lower:g} to {parameter.upper:g}",
                plain(parameter.meaning),
            ),
        )
        for parameter in effect.parameters
    )
    return table(("name", "unit", "typical", "default", "bounds", "meaning"), rows)


def _linked(text: str, effect: Effect) -> str:
    """Text in which the titles of other effects lead to their pages."""
    ids = {other.title.lower(): other.id for other in CATALOGUE if other != effect}
    titles = "|".join(map(re.escape, ids))

    def link(match: re.Match[str]) -> str:
        return f"[{match[1]}]({ids[match[1].lower()]}.md)"

    return re.sub(rf"\b({titles})\b", link, plain(text), flags=re.IGNORECASE)
