"""Settings of Sphinx for the reference site, which `build_scripts/build_site.py` builds."""

import ast
import inspect
from textwrap import dedent
from typing import Any

from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.application import Sphinx

from elastic_tendon import __version__

project = "elastic-tendon"
version = release = __version__
extensions = ["myst_parser", "sphinx.ext.autodoc", "numpydoc"]
html_theme = "furo"
html_title = f"elastic-tendon {version}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_show_copyright = html_show_sourcelink = html_copy_source = False
html_math_renderer = "mathml"  # browsers draw it themselves, without a script or a network

default_role = "py:obj"  # `name` is a link where it is public, else only slanted
myst_heading_anchors = 3
autodoc_member_order = "bysource"
numpydoc_show_class_members = False


def _as_written(
    _app: Sphinx, what: str, _name: str, thing: Any, *_rest: Any
) -> tuple[str, str] | None:
    """Signature as it stands in the source: with `ArrayLike`, not with all that this may be."""
    if inspect.isclass(thing):  # its docstring says what it is made of
        return None if issubclass(thing, Exception) else ("", "")
    try:
        function = ast.parse(dedent(inspect.getsource(thing))).body[0]
    except (OSError, TypeError):
        return None
    if not isinstance(function, ast.FunctionDef):
        return None
    if what == "method" and function.args.args:
        del function.args.args[0]
    returns = ast.unparse(function.returns or ast.Constant(None)).strip("'")  # some are quoted
    return f"({ast.unparse(function.args)})", returns


def _inline(self: Any, node: nodes.math) -> None:
    self.body.append(tex2mathml(node.astext()))
    raise nodes.SkipNode


def _display(self: Any, node: nodes.math_block) -> None:
    self.body.append(tex2mathml(node.astext(), as_block=True))
    raise nodes.SkipNode


def setup(app: Sphinx) -> None:
    """Called by Sphinx."""
    app.connect("autodoc-process-signature", _as_written)
    app.add_html_math_renderer("mathml", (_inline, None), (_display, None))
