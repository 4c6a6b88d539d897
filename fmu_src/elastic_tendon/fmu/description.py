"""modelDescription.xml of FMI 2.0, from the layout and the structural dependencies."""

import hashlib
import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib.metadata import version
from math import isfinite
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from elastic_tendon.fmu.dependencies import Dependencies
from elastic_tendon.fmu.layout import FmuVariable, Role
from elastic_tendon.fmu.units import DISPLAY_UNITS, TYPES, base_exponents
from elastic_tendon.transmission import SlackState
from elastic_tendon.variables import Interface, Kind, Variable

SLACK_STATES = {
    SlackState.I: ("I", "the lower tendon is slack"),
    SlackState.II: ("II", "the upper tendon is slack"),
    SlackState.III: ("III", "both tendons are taut"),
    SlackState.BOTH: ("both", "both tendons are slack"),
}
LOG_CATEGORIES = (
    ("logStatusWarning", "what may not be meant"),
    ("logStatusDiscard", "steps that cannot be taken"),
    ("logStatusError", "calls that are refused"),
    ("logEvents", "tendons that become slack or taut, friction that sticks or slides"),
)
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
    co_simulation: dict[str, str] | None
    model_exchange: dict[str, str] | None


_STATE_HANDLING = {
    "canBeInstantiatedOnlyOncePerProcess": "false",
    "canNotUseMemoryManagementFunctions": "true",
    "canGetAndSetFMUstate": "true",
    "canSerializeFMUstate": "true",
}
MODEL_EXCHANGE = {
    **_STATE_HANDLING,
    "completedIntegratorStepNotNeeded": "true",
    "providesDirectionalDerivative": "true",
}
CO_SIMULATION = {
    **_STATE_HANDLING,
    "canHandleVariableCommunicationStepSize": "true",
    "canInterpolateInputs": "true",
    "maxOutputDerivativeOrder": "1",
    "canRunAsynchronuously": "false",
    "providesDirectionalDerivative": "true",
}


# ---- parts of the description --------------------------------------------------------------


def _units(root: Element, units: Iterable[str]) -> None:
    definitions = SubElement(root, "UnitDefinitions")
    for name in units:
        unit = SubElement(definitions, "Unit", name=name)
        exponents = {base: str(power) for base, power in base_exponents(name).items()}
        SubElement(unit, "BaseUnit", exponents)
        if name in DISPLAY_UNITS:
            display, factor = DISPLAY_UNITS[name]
            SubElement(unit, "DisplayUnit", name=display, factor=repr(factor))


def _types(root: Element, units: Iterable[str]) -> None:
    definitions = SubElement(root, "TypeDefinitions")
    for unit in units:
        if unit in TYPES:
            name, quantity = TYPES[unit]
            declared = SubElement(definitions, "SimpleType", name=name)
            SubElement(declared, "Real", {"quantity": quantity, **_real_unit(unit)})
    slack = SubElement(definitions, "SimpleType", name="SlackState")
    items = SubElement(slack, "Enumeration")
    for state, (name, meaning) in SLACK_STATES.items():
        SubElement(items, "Item", name=name, value=str(int(state)), description=meaning)


def _real_unit(unit: str) -> dict[str, str]:
    display = {"displayUnit": DISPLAY_UNITS[unit][0]} if unit in DISPLAY_UNITS else {}
    return {"unit": unit, **display}


def _bounds(variable: Variable) -> dict[str, str]:
    number = int if variable.kind is Kind.INTEGER else float
    bounds = {"min": variable.lower, "max": variable.upper}
    return {key: repr(number(value)) for key, value in bounds.items() if isfinite(value)}


def _typed(one: FmuVariable, state_index: int | None) -> Element:
    """The element Real, Integer, Boolean or Enumeration of a variable."""
    variable, kind = one.variable, one.variable.kind
    element = Element(kind.value)
    if kind is Kind.SLACK_STATE:
        element.set("declaredType", "SlackState")
    if kind is Kind.REAL:
        if variable.unit in TYPES:
            element.set("declaredType", TYPES[variable.unit][0])
        element.attrib.update(_real_unit(variable.unit))
        element.set("nominal", repr(float(variable.nominal)))
    if kind in (Kind.REAL, Kind.INTEGER):
        element.attrib.update(_bounds(variable))
    if state_index is not None:
        element.set("derivative", str(state_index))
    if one.start is not None:
        element.set("start", _start(kind, one.start))
    return element


def _start(kind: Kind, value: float) -> str:
    if kind is Kind.BOOLEAN:
        return "true" if value else "false"
    return repr(float(value) if kind is Kind.REAL else int(value))


def _character(one: FmuVariable) -> dict[str, str]:
    """Causality, variability and, where FMI wants it told, initial."""
    if one.role is Role.TIME:
        return {"causality": "independent", "variability": "continuous"}
    if one.role is Role.INPUT:
        return {"causality": "input", "variability": "continuous"}
    if one.role in (Role.PARAMETER, Role.OPTION):
        return {"causality": "parameter", "variability": "fixed", "initial": "exact"}
    return {
        "causality": "output" if one.is_output else "local",
        "variability": "continuous" if one.variable.kind is Kind.REAL else "discrete",
        "initial": "calculated" if one.start is None else "exact",
    }


def _variables(root: Element, variables: Sequence[FmuVariable]) -> None:
    states = {one.index: one.value_reference for one in variables if one.role is Role.STATE}
    listed = SubElement(root, "ModelVariables")
    for one in variables:
        attributes = {
            "name": one.name,
            "valueReference": str(one.value_reference),
            "description": one.variable.meaning,
            **_character(one),
        }
        state = states[one.index] + 1 if one.role is Role.DERIVATIVE else None
        SubElement(listed, "ScalarVariable", attributes).append(_typed(one, state))


# ---- structure -----------------------------------------------------------------------------


class _Structure:
    """Unknowns and what they depend on, as 1-based indices of the variables."""

    def __init__(self, description: Description) -> None:
        self.variables = description.variables
        self._dependencies = description.dependencies
        by_role = {
            role: [one for one in self.variables if one.role is role]
            for role in (Role.STATE, Role.INPUT, Role.PARAMETER)
        }
        self._columns = [
            one for listed in by_role.values() for one in sorted(listed, key=lambda one: one.index)
        ]
        (self._option,) = (one for one in self.variables if one.role is Role.OPTION)

    def _knowns(self, one: FmuVariable) -> list[FmuVariable]:
        if one.role is Role.STATE:
            return [one]
        patterns = self._dependencies
        pattern = patterns.outputs if one.role is Role.OUTPUT else patterns.rates
        return [self._columns[column] for column in pattern[one.index].nonzero()[0]]

    def _initial_knowns(self, one: FmuVariable) -> list[FmuVariable]:
        """Knowns, with those behind a calculated start in its place."""
        columns: set[int] = set()
        for known in self._knowns(one):
            if known.role is Role.STATE and known.start is None:
                columns.update(self._dependencies.starts[known.index].nonzero()[0])
            else:
                columns.add(self._columns.index(known))
        return [self._columns[column] for column in columns]

    def of(self, one: FmuVariable, *, initial: bool) -> str:
        """Dependencies of an unknown; parameters are knowns in initialisation only."""
        knowns = self._initial_knowns(one) if initial else self._knowns(one)
        if not initial:
            knowns = [known for known in knowns if known.role is not Role.PARAMETER]
        elif any(known.name == "motor_velocity" for known in knowns):
            knowns = [*knowns, self._option]
        return " ".join(str(i) for i in sorted(known.value_reference + 1 for known in knowns))


def _model_structure(root: Element, description: Description) -> None:
    structure = _Structure(description)
    outputs = [one for one in structure.variables if one.is_output]
    rates = [one for one in structure.variables if one.role is Role.DERIVATIVE]
    states = [one for one in structure.variables if one.role is Role.STATE and not one.is_output]
    unknowns = [one for one in outputs + rates + states if one.start is None]
    unknowns.sort(key=lambda one: one.value_reference)
    element = SubElement(root, "ModelStructure")
    for name, listed, initial in (
        ("Outputs", outputs, False),
        ("Derivatives", rates, False),
        ("InitialUnknowns", unknowns, True),
    ):
        group = SubElement(element, name)
        for one in listed:
            attributes = {
                "index": str(one.value_reference + 1),
                "dependencies": structure.of(one, initial=initial),
            }
            SubElement(group, "Unknown", attributes)


# ---- whole ---------------------------------------------------------------------------------


def _generation_time() -> dict[str, str]:
    """From SOURCE_DATE_EPOCH, else none: equal models give equal FMUs."""
    epoch = os.environ.get("SOURCE_DATE_EPOCH")
    if not epoch:
        return {}
    time = datetime.fromtimestamp(int(epoch), UTC)
    return {"generationDateAndTime": time.strftime("%Y-%m-%dT%H:%M:%SZ")}


def model_description(description: Description) -> Element:
    """Root element of modelDescription.xml; its guid is still to be set by `seal`.

    Parameters
    ----------
    description : Description

    Returns
    -------
    Element
    """
    effects = ", ".join(effect.title for effect in description.interface.effects)
    software = version("elastic-tendon")
    root = Element(
        "fmiModelDescription",
        {
            "fmiVersion": "2.0",
            "modelName": description.name,
            "guid": "",
            "description": f"Elastic tendon actuator with slack; effects: {effects or 'none'}",
            "author": "the elastic-tendon authors",
            "version": software,
            "license": "MIT",
            "generationTool": f"elastic-tendon {software}",
            **_generation_time(),
            "variableNamingConvention": "structured",
            "numberOfEventIndicators": str(
                sum(mode.indicators for mode in description.interface.modes)
            ),
        },
    )
    identifier = {"modelIdentifier": description.identifier}
    if description.model_exchange is not None:
        SubElement(root, "ModelExchange", identifier | description.model_exchange)
    if description.co_simulation is not None:
        SubElement(root, "CoSimulation", identifier | description.co_simulation)
    reals = [one.variable for one in description.variables if one.variable.kind is Kind.REAL]
    units = list(dict.fromkeys(variable.unit for variable in reals))
    _units(root, units)
    _types(root, units)
    categories = SubElement(root, "LogCategories")
    for name, meaning in LOG_CATEGORIES:
        SubElement(categories, "Category", name=name, description=meaning)
    SubElement(
        root,
        "DefaultExperiment",
        startTime="0.0",
        stopTime=repr(STOP_TIME),
        tolerance=repr(TOLERANCE),
        stepSize=repr(STEP_SIZE),
    )
    _variables(root, description.variables)
    _model_structure(root, description)
    return root


def seal(root: Element, binary_key: str) -> str:
    """Set and return the guid: a hash of the description and of what the binary is made from.

    Parameters
    ----------
    root : from `model_description`
    binary_key : hash of the sources of the binary
    """
    content = ElementTree.tostring(root, "utf-8") + binary_key.encode()
    digest = hashlib.sha256(content).hexdigest()
    parts = (digest[:8], digest[8:12], digest[12:16], digest[16:20], digest[20:32])
    guid = "{" + "-".join(parts) + "}"
    root.set("guid", guid)
    return guid


def to_bytes(root: Element) -> bytes:
    """The file's content, indented."""
    ElementTree.indent(root)
    content: bytes = ElementTree.tostring(root, "UTF-8", xml_declaration=True)
    return content + b"\n"
