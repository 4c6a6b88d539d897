"""What modelDescription.xml says in any version of FMI; a module for each version writes it."""

import hashlib
import os
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib.metadata import version
from math import isfinite
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from elastic_tendon.actuator.transmission import SlackState
from elastic_tendon.actuator.variables import Interface, Kind
from elastic_tendon.effects.units import base_exponents
from elastic_tendon.fmu.dependencies import Dependencies
from elastic_tendon.fmu.structure import Structure, structure
from elastic_tendon.fmu.units import DISPLAY_UNITS, TYPES
from elastic_tendon.native.layout import FmuVariable, Role
from elastic_tendon.native.shared import LOG_CATEGORIES

SLACK_STATE_TYPE = "SlackState"
SLACK_STATES = {
    SlackState.I: ("I", "the lower tendon is slack"),
    SlackState.II: ("II", "the upper tendon is slack"),
    SlackState.III: ("III", "both tendons are taut"),
    SlackState.BOTH: ("both", "both tendons are slack"),
}
COPYRIGHT = "Copyright (c) 2026 the elastic-tendon authors"  # as in LICENSE
STOP_TIME = 10.0  # s
STEP_SIZE = 1e-3  # s
# of the importer's integrator; a tighter one stalls integrators that see inputs jump, as in fmpy
TOLERANCE = 1e-6


@dataclass(frozen=True)
class Description:
    """What a modelDescription.xml is made from.

    `co_simulation` and `model_exchange` are the attributes of these elements beside the model
    identifier, None where the FMU does not have the interface.
    """

    name: str
    identifier: str
    interface: Interface
    variables: tuple[FmuVariable, ...]
    dependencies: Dependencies
    co_simulation: Mapping[str, str] | None
    model_exchange: Mapping[str, str] | None

    @property
    def structure(self) -> Structure:
        """Unknowns and what they depend on."""
        return structure(self.variables, self.dependencies)

    @property
    def units(self) -> tuple[str, ...]:
        """Units of the variables, each once."""
        declared = (variable.variable for variable in self.variables)
        return tuple(dict.fromkeys(real.unit for real in declared if real.kind is Kind.REAL))

    @property
    def states(self) -> dict[int, FmuVariable]:
        """States by their index, which their derivatives have too."""
        return {
            variable.index: variable for variable in self.variables if variable.role is Role.STATE
        }


# ---- elements that all versions share ------------------------------------------------------


def root_element(description: Description, attributes: Mapping[str, str]) -> Element:
    """The root with `attributes` of the version, and the elements of the interfaces."""
    effects = ", ".join(effect.title for effect in description.interface.effects)
    software = version("elastic-tendon")
    root = Element(
        "fmiModelDescription",
        {
            **attributes,
            "modelName": description.name,
            "description": f"{_machine(description.interface)}; effects: {effects or 'none'}",
            "author": "the elastic-tendon authors",
            "version": software,
            "copyright": COPYRIGHT,
            "license": "MIT",
            "generationTool": f"elastic-tendon {software}",
            **_generation_time(),
            "variableNamingConvention": "structured",
        },
    )
    identifier = {"modelIdentifier": description.identifier}
    for name, capabilities in (
        ("ModelExchange", description.model_exchange),
        ("CoSimulation", description.co_simulation),
    ):
        if capabilities is not None:
            SubElement(root, name, identifier | dict(capabilities))
    return root


def _machine(interface: Interface) -> str:
    if not interface.kind.has_springs:
        return "Link that a load moves, without springs"
    return "Elastic tendon actuator with slack"


def _generation_time() -> dict[str, str]:
    """From SOURCE_DATE_EPOCH, else none: equal models give equal FMUs."""
    epoch = os.environ.get("SOURCE_DATE_EPOCH")
    if not epoch:
        return {}
    time = datetime.fromtimestamp(int(epoch), UTC)
    return {"generationDateAndTime": time.strftime("%Y-%m-%dT%H:%M:%SZ")}


def add_units(root: Element, description: Description) -> None:
    """Add the definitions of units; all are SI, so their factor is the default, 1."""
    definitions = SubElement(root, "UnitDefinitions")
    for name in description.units:
        unit = SubElement(definitions, "Unit", name=name)
        exponents = {base: str(power) for base, power in base_exponents(name).items()}
        SubElement(unit, "BaseUnit", exponents)
        if name in DISPLAY_UNITS:
            display, factor = DISPLAY_UNITS[name]
            SubElement(unit, "DisplayUnit", name=display, factor=repr(factor))


def add_slack_states(enumeration: Element) -> None:
    """Add the items of the enumeration."""
    for state, (name, meaning) in SLACK_STATES.items():
        SubElement(enumeration, "Item", name=name, value=str(int(state)), description=meaning)


def add_log_categories_and_experiment(root: Element) -> None:
    """Add the categories of messages, and what an importer may take for want of better."""
    categories = SubElement(root, "LogCategories")
    for name, meaning in LOG_CATEGORIES.values():
        SubElement(categories, "Category", name=name, description=meaning)
    SubElement(
        root,
        "DefaultExperiment",
        startTime="0.0",
        stopTime=repr(STOP_TIME),
        tolerance=repr(TOLERANCE),
        stepSize=repr(STEP_SIZE),
    )


# ---- attributes of variables that all versions share ---------------------------------------


def identity(variable: FmuVariable) -> dict[str, str]:
    """Name, reference, meaning, causality, variability and, where FMI wants it told, initial."""
    return {
        "name": variable.name,
        "valueReference": str(variable.value_reference),
        "description": variable.variable.meaning,
        "causality": _causality(variable),
        "variability": variable.variability,
        **_initial(variable),
    }


def _causality(variable: FmuVariable) -> str:
    if variable.role is Role.TIME:
        return "independent"
    if variable.role is Role.INPUT:
        return "input"
    if variable.role in (Role.PARAMETER, Role.OPTION):
        return "parameter"
    return "output" if variable.is_output else "local"


def _initial(variable: FmuVariable) -> dict[str, str]:
    if variable.role in (Role.TIME, Role.INPUT):
        return {}
    return {"initial": "calculated" if variable.start is None else "exact"}


def unit_attributes(unit: str) -> dict[str, str]:
    """A unit and the one to display it in."""
    display = {"displayUnit": DISPLAY_UNITS[unit][0]} if unit in DISPLAY_UNITS else {}
    return {"unit": unit, **display}


def value_attributes(variable: FmuVariable) -> dict[str, str]:
    """Type, unit, nominal, bounds and start, as far as the variable's type has them."""
    declared, kind = variable.variable, variable.variable.kind
    attributes = {}
    if kind is Kind.SLACK_STATE:
        attributes["declaredType"] = SLACK_STATE_TYPE
    if kind is Kind.REAL:
        if declared.unit in TYPES:
            attributes["declaredType"] = TYPES[declared.unit][0]
        attributes |= unit_attributes(declared.unit)
        attributes["nominal"] = repr(float(declared.nominal))
    if kind is not Kind.BOOLEAN:
        bounds = {"min": declared.lower, "max": declared.upper}
        attributes |= {key: _text(kind, value) for key, value in bounds.items() if isfinite(value)}
    if variable.start is not None:
        attributes["start"] = _text(kind, variable.start)
    return attributes


def _text(kind: Kind, value: float) -> str:
    if kind is Kind.BOOLEAN:
        return "true" if value else "false"
    return repr(float(value) if kind is Kind.REAL else int(value))


def state_attributes(variable: FmuVariable, description: Description) -> dict[str, str]:
    """Whether an event may change a state; nothing of other variables."""
    jumps = variable.role is Role.STATE and description.dependencies.jumps[variable.index]
    return {"reinit": "true"} if jumps else {}


# ---- token and bytes -----------------------------------------------------------------------


def seal(root: Element, binary_key: str) -> str:
    """Set and return the token: a hash of the description and of what the binary is made from.

    Parameters
    ----------
    root : from `model_description` of a version, with an empty token
    binary_key : from `binary.write_sources`
    """
    content = ElementTree.tostring(root, "utf-8") + binary_key.encode()
    digest = hashlib.sha256(content).hexdigest()
    parts = (digest[:8], digest[8:12], digest[12:16], digest[16:20], digest[20:32])
    token = "{" + "-".join(parts) + "}"
    (name,) = {"guid", "instantiationToken"} & set(root.attrib)
    root.set(name, token)
    return token


def to_bytes(root: Element) -> bytes:
    """The file's content, indented."""
    ElementTree.indent(root)
    content: bytes = ElementTree.tostring(root, "UTF-8", xml_declaration=True)
    return content + b"\n"
