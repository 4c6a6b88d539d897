"""From sections to one HTML file: all it needs is in it, and it may not ask for more."""

import json
from collections.abc import Sequence
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from elastic_tendon.fmu import live
from elastic_tendon.fmu.icon import PAGES
from elastic_tendon.reports.html.blocks import Live, Section
from elastic_tendon.reports.interactive.theme import CONFIG

HERE = Path(__file__).parent
# plotly.js 4.1.1 for figures with two axes, from the npm package plotly.js-cartesian-dist-min: a
# third of the whole that comes with plotly, which browsers take a second to begin with
PLOTLY = HERE / "plotly-cartesian.min.js"
# who turns the wheel over a figure wants the page to move
_CONFIG = CONFIG | {"scrollZoom": False}


def page(title: str, subtitle: str, sections: Sequence[Section]) -> str:
    """The whole file.

    Parameters
    ----------
    title, subtitle : of the report; text of users may be in them
    sections : in their order

    Returns
    -------
    str, HTML; whatever text it was made from cannot act as markup
    """
    environment = Environment(
        loader=FileSystemLoader(HERE),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    script = _read(HERE / "page.js").replace("CONFIG", json.dumps(_CONFIG))
    alive = any(isinstance(block, Live) for section in sections for block in section.blocks)
    scripts = [_read(PLOTLY), script, *[live.script()] * alive]
    allowed = [*map(live.source_expression, scripts), *[live.ALLOWED] * alive]
    return environment.get_template("page.html").render(
        title=title,
        subtitle=subtitle,
        sections=sections,
        style=Markup(_read(PAGES / "style.css") + _read(HERE / "page.css") + live.style() * alive),
        scripts=[Markup(code) for code in scripts],
        allowed=" ".join(allowed),
    )


def _read(path: Path) -> str:
    return path.read_text("utf-8")
