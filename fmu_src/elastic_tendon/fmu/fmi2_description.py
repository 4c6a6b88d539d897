"""modelDescription.xml of FMI 2.0."""

from collections.abc import Iterable
from xml.etree.ElementTree import Element, SubElement

from elastic_tendon.fmu import description as common
from elastic_tendon.fmu.description import Description
from elastic_tendon.fmu.structure import Unknown
from elastic_tendon.fmu.units import TYPES
from elastic_tendon.native.layout import FmuVariable, Role

_BOTH = {
    "needsExecutionTool": "false",
    "canBeInstantiatedOnlyOncePerProcess": "false",
    "canNotUseMemoryManagementFunctions": "true",
    "canGetAndSetFMUstate": "true",
    "canSerializeFMUstate": "true",
    "providesDirectionalDerivative": "true",
}
MODEL_EXCHANGE = _BOTH | {"completedIntegratorStepNotNeeded": "true"}
CO_SIMULATION = _BOTH | {
    "canHandleVariableCommunicationStepSize": "true",
    "canInterpolateInputs": "true",
    "maxOutputDerivativeOrder": "1",
    "canRunAsynchronuously": "false",
}


def model_description(description: Description) -> Element:
    """Root element of modelDescription.xml; its guid is still to be set by `seal`.

    Parameters
    ----------
    description : Description, its variables without event indicators

    Returns
    -------
    Element
    """
    indicators = sum(mode.indicators for mode in description.interface.modes)
    root = common.root_element(
        description,
        {"fmiVersion": "2.0", "guid": "", "numberOfEventIndicators": str(indicators)},
    )
    common.add_units(root, description)
    _add_types(root, description)
    common.add_log_categories_and_experiment(root)
    listed = SubElement(root, "ModelVariables")
    for variable in description.variables:
        listed.append(_variable(variable, description))
    _add_structure(root, description)
    return root


def _add_types(root: Element, description: Description) -> None:
    definitions = SubElement(root, "TypeDefinitions")
    for unit in description.units:
        if unit in TYPES:
            name, quantity = TYPES[unit]
            declared = SubElement(definitions, "SimpleType", name=name)
            SubElement(declared, "Real", {"quantity": quantity, **common.unit_attributes(unit)})
    if not description.interface.kind.has_springs:
        return
    slack = SubElement(definitions, "SimpleType", name=common.SLACK_STATE_TYPE)
    common.add_slack_states(SubElement(slack, "Enumeration"))


def _index(variable: FmuVariable) -> str:
    """Place in the list of variables, counted from 1."""
    return str(variable.value_reference + 1)


def _variable(variable: FmuVariable, description: Description) -> Element:
    element = Element("ScalarVariable", common.identity(variable))
    typed = common.value_attributes(variable) | common.state_attributes(variable, description)
    if variable.role is Role.DERIVATIVE:
        typed["derivative"] = _index(description.states[variable.index])
    SubElement(element, variable.variable.kind.value, typed)
    return element


def _add_structure(root: Element, description: Description) -> None:
    structure = description.structure
    element = SubElement(root, "ModelStructure")
    for name, unknowns in (
        ("Outputs", _without_parameters(structure.outputs)),
        ("Derivatives", _without_parameters(structure.derivatives)),
        ("InitialUnknowns", structure.initial_unknowns),
    ):
        group = Element(name)
        for unknown in unknowns:
            knowns = " ".join(_index(known) for known, _ in unknown.knowns)
            SubElement(group, "Unknown", index=_index(unknown.variable), dependencies=knowns)
        if len(group):  # the standard allows no empty one
            element.append(group)


def _without_parameters(unknowns: Iterable[Unknown]) -> Iterable[Unknown]:
    """FMI 2.0 counts parameters among the knowns in initialisation only."""
    for unknown in unknowns:
        knowns = (pair for pair in unknown.knowns if pair[0].role is not Role.PARAMETER)
        yield Unknown(unknown.variable, tuple(knowns))
