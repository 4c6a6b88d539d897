"""What an FMU says to people: documentation/index.html of this model, and the license.

The page is the template `pages/index.html`. Whatever comes from a model or an effect is put in as
text of elements, so nothing in it can act as HTML.
"""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from html import escape
from importlib.metadata import distribution
from string import Template
from typing import Literal
from xml.etree.ElementTree import Element, SubElement, tostring

from elastic_tendon.actuator.design import design
from elastic_tendon.actuator.interfaces import InterfaceKind
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.quantity import unit_text
from elastic_tendon.actuator.sections import Link, Transmission
from elastic_tendon.actuator.system import HYSTERESIS
from elastic_tendon.actuator.variables import (
    JOINT_MOTION,
    MOTOR_MOTION,
    MOTOR_VELOCITY,
    Kind,
    Mode,
    Variable,
    interface,
)
from elastic_tendon.effects.base import LAW_SYMBOLS, Effect
from elastic_tendon.fmu.characteristic_plot import characteristic_plot
from elastic_tendon.fmu.description import STEP_SIZE, TOLERANCE
from elastic_tendon.fmu.icon import PAGES, icon
from elastic_tendon.fmu.live import page_parts, style
from elastic_tendon.native.compiler import PLATFORMS
from elastic_tendon.native.layout import FmuVariable, Role
from elastic_tendon.native.library import DEFAULT_TOLERANCE
from elastic_tendon.native.shared import LOG_CATEGORIES

# derivatives and event indicators say nothing that their states and relations do not
_GROUPS = (
    ("Inputs", lambda variable: variable.role is Role.INPUT),
    ("Outputs", lambda variable: variable.is_output),
    (
        "Local: further states",
        lambda variable: variable.role is Role.STATE and not variable.is_output,
    ),
    ("Independent", lambda variable: variable.role is Role.TIME),
)
_TYPES = {Kind.INTEGER: "integer", Kind.BOOLEAN: "Boolean", Kind.SLACK_STATE: "enumeration"}

# of the formulas in the template, where $F_p stands for F with the subscript p
_SYMBOLS = (
    *("F_p", "F_1", "F_2", "F_i", "k_1", "k_2", "k_i", "d_1", "d_2", "d_i", "x_1", "x_2", "x_i"),
    *("l_p_i", "l_max_1", "l_max_2", "l_max_i", "theta_j", "tau_j", "tau_m", "tau_load"),
)
# what the page says of each side, by whether the rotor, and the link, is computed
_AT_MOTOR = {
    False: {
        "motor_given": "<code>motor_position</code>, the angle at the motor pulley in rad",
        "motor_read": "<code>motor_torque</code> (N·m) is what the motor must exert",
        "motor_task": "The motion of the motor",
    },
    True: {
        "motor_given": "<code>motor_torque</code>, that of the motor at its pulley in N·m",
        "motor_read": "<code>motor_position</code> (rad) and <code>motor_velocity</code> (rad/s)",
        "motor_task": "The torque of the motor",
    },
}
_AT_JOINT = {
    True: {
        "joint_given": "<code>load_torque</code> on the joint in N·m",
        "joint_read": "<code>joint_position</code> (rad) and <code>joint_velocity</code> (rad/s)",
        "joint_task": "a load on the joint",
    },
    False: {
        "joint_given": "<code>joint_position</code> (rad) with <code>joint_velocity</code> (rad/s)",
        "joint_read": "<code>joint_torque</code> (N·m), which the tendons exert on the joint",
        "joint_task": "the motion of the joint",
    },
}
_CALCULATED = {
    InterfaceKind.POSITION: "the motion of the joint and the forces",
    InterfaceKind.TORQUE: "the motion of motor and joint and the forces",
    InterfaceKind.JOINT: "the forces",
    InterfaceKind.TORQUE_JOINT: "the motion of the motor and the forces",
    InterfaceKind.LOAD: "the motion of the joint",
}
_INDICATORS = {
    2: "",
    3: ", and the event indicators, which carry the names of the relations under Events",
}
_JUMPS = {
    False: "No state jumps.",
    True: "What begins to stick has a velocity of exactly 0 from there on; nothing else jumps.",
}
_CURVE = "Torque on the joint over its deflection, at rest, as far as the springs bear it"
_BUILD_LINK = ' <a href="#build">Build from source</a>'
# of the page: lines about springs, and lines in their place
_PART = re.compile(
    "<!-- springs -->\n(?P<springs>.*?)(?:<!-- else -->\n(?P<none>.*?))?<!-- end -->\n", re.DOTALL
)
_SCRIPTS = re.compile(r"(<script.*?</script>)", re.DOTALL)
_GREEK = {"theta": "θ", "tau": "τ"}

Cell = str | Element


# ---- pieces of HTML ------------------------------------------------------------------------


def _html(element: Element) -> str:
    return tostring(element, "unicode", method="html") + "\n"


def _element(tag: str, content: Cell = "", **attributes: str) -> Element:
    element = Element(tag, attributes)
    if isinstance(content, str):
        element.text = content
    else:
        element.append(content)
    return element


def _code(name: str) -> Element:
    return _element("code", name)


def _row(tag: str, cells: Iterable[Cell]) -> Element:
    row = Element("tr")
    row.extend(_element(tag, cell) for cell in cells)
    return row


def _table(heading: Sequence[str], rows: Iterable[Element]) -> str:
    """A table that scrolls by itself where the window is narrow."""
    frame = Element("div", {"class": "scroll listing", "tabindex": "0"})
    table = SubElement(frame, "table")
    table.append(_row("th", heading))
    table.extend(rows)
    return _html(frame)


def _symbol(name: str) -> str:
    """MathML of a symbol with subscripts, such as ``l_max_i``."""
    base, *below = name.split("_")
    marks = [f"<mn>{mark}</mn>" if mark.isdigit() else f"<mi>{mark}</mi>" for mark in below]
    subscript = "<mo>,</mo>".join(marks)
    return f"<msub><mi>{_GREEK.get(base, base)}</mi><mrow>{subscript}</mrow></msub>"


# ---- numbers and units ---------------------------------------------------------------------


def _unit(variable: Variable) -> str:
    """Unit as people write it, such as kg·m²; of what is no real number its type."""
    if variable.kind is not Kind.REAL:
        return _TYPES[variable.kind]
    return unit_text(variable.unit)


def _number(value: float, digits: int = 6) -> str:
    """A number as people write it: 1e8, not 1e+08."""
    return re.sub(r"e([+-])0?", lambda match: "e" + match[1].strip("+"), f"{value:.{digits}g}")


def _start(variable: FmuVariable) -> str:
    if variable.role is Role.TIME:
        return ""
    if variable.start is None:
        return "calculated"
    if variable.variable.kind is Kind.BOOLEAN:
        return "true" if variable.start else "false"
    return _number(variable.start)


def _bounds(parameter: Variable) -> str:
    if parameter.kind is Kind.BOOLEAN:
        return ""
    return f"{_number(parameter.lower)} to {_number(parameter.upper)}"


# ---- sections ------------------------------------------------------------------------------


def _group(title: str, columns: int) -> Element:
    row = Element("tr")
    row.append(_element("th", title, colspan=str(columns), **{"class": "group"}))
    return row


def _variables(variables: Sequence[FmuVariable]) -> str:
    heading = ("Name", "Unit", "Start", "Meaning")
    rows: list[Element] = []
    for title, belongs in _GROUPS:
        members = [variable for variable in variables if belongs(variable)]
        rows += [_group(title, len(heading))] if members else []
        rows += [_row("td", (*_cells(variable), variable.variable.meaning)) for variable in members]
    return _table(heading, rows)


def _parameters(parameters: Iterable[FmuVariable]) -> str:
    heading = ("Name", "Unit", "Start", "Bounds", "Variability", "Meaning")
    return _table(
        heading,
        [
            _row(
                "td",
                (
                    *_cells(parameter),
                    _bounds(parameter.variable),
                    parameter.variability,
                    parameter.variable.meaning,
                ),
            )
            for parameter in parameters
        ],
    )


def _cells(variable: FmuVariable) -> tuple[Cell, ...]:
    return _code(variable.name), _unit(variable.variable), _start(variable)


def _effect(effect: Effect, parameters: Iterable[FmuVariable]) -> Iterator[str]:
    title = _element("h3", f"{effect.title} ")
    title.append(_code(effect.id))
    yield _html(title)
    yield _html(_element("p", effect.physics))
    for name, text in (("Law", effect.law), ("Reference", effect.reference)):
        if text:
            yield _html(_element("p", f"{name}: {text}"))
    yield _parameters(parameters)


def _effects(effects: Sequence[Effect], parameters: Sequence[FmuVariable]) -> str:
    if not effects:
        return "<p>None: this is the model of the paper.</p>\n"
    pieces = [_html(_element("p", LAW_SYMBOLS))]
    for effect in effects:
        own = [
            parameter
            for parameter in parameters
            if parameter.name.startswith(f"effects.{effect.id}.")
        ]
        pieces.extend(_effect(effect, own))
    return "".join(pieces)


def _curve(transmission: Transmission) -> str:
    plot = characteristic_plot(transmission)
    if plot is None:
        return ""
    plot.set("aria-label", _CURVE)
    figure = _element("figure", plot)
    figure.append(_element("figcaption", _CURVE))
    return _html(figure)


def _modes(modes: Iterable[Mode]) -> str:
    heading = ("Relation", "Values", "Meaning of 1, or of the value")
    cells = ((_code(mode.name), ", ".join(map(str, mode.values)), mode.meaning) for mode in modes)
    return _table(heading, (_row("td", row) for row in cells))


def _log_categories() -> str:
    cells = ((_code(name), meaning) for name, meaning in LOG_CATEGORIES.values())
    return _table(("Category", "What it tells"), (_row("td", row) for row in cells))


# ---- whole ---------------------------------------------------------------------------------


def _count(effects: Sequence[Effect]) -> str:
    if not effects:
        return "as in the paper"
    return f"with {len(effects)} effect{'s' if len(effects) > 1 else ''} beside the paper's model"


def _page(name: str) -> str:
    return (PAGES / f"{name}.html").read_text("utf-8")


def _index_page(kind: InterfaceKind) -> str:
    """The page's template, with what only springs have or, where it says so, what stands in place
    of it."""

    def chosen(part: re.Match[str]) -> str:
        return part["springs"] if kind.has_springs else part["none"] or ""

    return _PART.sub(chosen, _page("index"))


def _build(library: str, fmi_version: Literal[2, 3]) -> str:
    """How to build the packed source code; `library` is its file name without suffix."""
    folders = dict.fromkeys(platform.folder(fmi_version) for platform in PLATFORMS.values())
    return Template(_page("build")).substitute(
        identifier=library,
        folder=PLATFORMS["x86_64-linux"].folder(fmi_version),
        folders=", ".join(f"<code>{folder}</code>" for folder in folders),
    )


def _link_motion(kind: InterfaceKind, symbols: Mapping[str, str]) -> str:
    page = _page("link_motion") if kind.has_link else ""
    if not kind.has_springs:
        page = page.replace("$tau_j<mo>+</mo>", "")
    return Template(page).substitute(symbols)


def _index(
    model: Model,
    variables: Sequence[FmuVariable],
    fmi_version: Literal[2, 3],
    library: str | None,
    panel: str,
) -> str:
    structure = interface(*model.structure)
    parameters = [
        variable for variable in variables if variable.role in (Role.PARAMETER, Role.OPTION)
    ]
    of_effects = [parameter for parameter in parameters if parameter.name.startswith("effects.")]
    symbols = {name: _symbol(name) for name in _SYMBOLS}
    kind, velocity = structure.kind, MOTOR_VELOCITY in structure.inputs
    of_version = {
        part: _page(f"fmi{fmi_version}_{part}")
        for part in ("connect", "co_simulation", "model_exchange")
    }
    numbers = {}
    if kind.has_springs:
        # none of the page's numbers is of the link, which need not be there
        designed = design(model.model_copy(update={"link": Link(inertia=1.0)}))
        numbers = {name: _number(value, 4) for name, value in designed.to_dict().items()}
    else:
        of_version["connect"] = _page("fmi3_connect_free") if fmi_version == 3 else ""
    if not velocity and fmi_version == 2:  # it is of the velocity alone
        of_version["connect"] = ""
    return Template(_index_page(kind)).substitute(
        symbols
        | numbers
        | of_version
        | page_parts(panel)
        | _AT_MOTOR[kind.has_rotor]
        | _AT_JOINT[kind.has_link],
        calculated=_CALCULATED[kind],
        velocity=_page("velocity") if velocity else "",
        link_motion=_link_motion(kind, symbols),
        rotor_motion=_page("rotor_motion") if kind.has_rotor else "",
        R2="<msup><mi>R</mi><mn>2</mn></msup>",
        name=escape(model.name),
        style=(PAGES / "style.css").read_text("utf-8") + (style() if panel else ""),
        icon=icon()["icon.svg"].decode(),
        software=distribution("elastic-tendon").version,
        fmi_version=fmi_version,
        build=_build(library, fmi_version) if library else "",
        build_link=_BUILD_LINK if library else "",
        effect_count=_count(structure.effects),
        without_effects=", without effects" if structure.effects else "",
        variables=_variables(variables),
        parameters=_parameters(
            parameter for parameter in parameters if parameter not in of_effects
        ),
        indicators=_INDICATORS[fmi_version],
        effects=_effects(structure.effects, of_effects),
        modes=_modes(structure.modes),
        log_categories=_log_categories(),
        jumps=_JUMPS[bool({JOINT_MOTION, MOTOR_MOTION} & {*structure.modes})],
        curve=_curve(model.transmission) if kind.has_springs else "",
        dead_band=_number(HYSTERESIS),
        step_size=_number(1e3 * STEP_SIZE),
        tolerance=_number(TOLERANCE),
        solver_tolerance=_number(DEFAULT_TOLERANCE),
    )


def licenses(*packed: str) -> dict[str, bytes]:
    """Files of the folder ``documentation/licenses`` by their path in the FMU.

    Parameters
    ----------
    packed : Python packages that are in the FMU beside what is ours
    """
    named = {"license": "elastic-tendon"} | {package: package for package in packed}
    return {
        f"documentation/licenses/{name}.txt": (
            distribution(package).read_text("licenses/LICENSE") or ""
        ).encode()
        for name, package in named.items()
    }


def documentation(
    model: Model,
    variables: Sequence[FmuVariable],
    fmi_version: Literal[2, 3],
    *,
    library: str | None = None,
    panel: str = "",
) -> dict[str, bytes]:
    """Files of the folder ``documentation``: content by path inside the FMU.

    Parameters
    ----------
    model : Model
    variables : of the FMU, from `layout`
    fmi_version : 2 or 3, major version of FMI
    library : file name without suffix of what is built where the FMU holds its source code
    panel : from `live.fmu_panel`, in which the model runs; "": there is none

    Returns
    -------
    dict of bytes by path; equal arguments give equal bytes
    """
    page = _index(model, variables, fmi_version, library, panel)
    worded = "".join(
        part if part.startswith("<script") else model.motion.words(part)
        for part in _SCRIPTS.split(page)  # which the page's policy names by their digests
    )
    return {"documentation/index.html": worded.encode(), **licenses()}
