"""modelDescription.xml of FMI 3.0."""

from xml.etree.ElementTree import Element, SubElement

from elastic_tendon.actuator.variables import Kind
from elastic_tendon.fmu import description as common
from elastic_tendon.fmu.dependencies import Dependence
from elastic_tendon.fmu.description import Description
from elastic_tendon.fmu.structure import Unknown
from elastic_tendon.fmu.units import TYPES
from elastic_tendon.native.layout import FmuVariable, Role

_BOTH = {
    "needsExecutionTool": "false",
    "canBeInstantiatedOnlyOncePerProcess": "false",
    "canGetAndSetFMUState": "true",
    "canSerializeFMUState": "true",
    "providesDirectionalDerivatives": "true",
    "providesAdjointDerivatives": "true",
    "providesPerElementDependencies": "false",
    "providesEvaluateDiscreteStates": "false",
}
MODEL_EXCHANGE = _BOTH | {"needsCompletedIntegratorStep": "false"}
CO_SIMULATION = _BOTH | {
    "canHandleVariableCommunicationStepSize": "true",
    "maxOutputDerivativeOrder": "1",
    "hasEventMode": "true",
    "mightReturnEarlyFromDoStep": "true",
    "providesIntermediateUpdate": "true",
    "canReturnEarlyAfterIntermediateUpdate": "true",
    # the solver looks back no step, so what is not smooth between its steps costs nothing
    "recommendedIntermediateInputSmoothness": "0",
}
_ELEMENTS = {
    Kind.REAL: "Float64",
    Kind.INTEGER: "Int32",
    Kind.BOOLEAN: "Boolean",
    Kind.SLACK_STATE: "Enumeration",
}


def model_description(description: Description) -> Element:
    """Root element of modelDescription.xml; its instantiationToken is still to be set by `seal`.

    Parameters
    ----------
    description : Description, event indicators among its variables

    Returns
    -------
    Element
    """
    root = common.root_element(description, {"fmiVersion": "3.0", "instantiationToken": ""})
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
            attributes = {"name": name, "quantity": quantity, **common.unit_attributes(unit)}
            SubElement(definitions, "Float64Type", attributes)
    if not description.interface.kind.has_springs:
        return
    slack = SubElement(definitions, "EnumerationType", name=common.SLACK_STATE_TYPE)
    common.add_slack_states(slack)


def _variable(variable: FmuVariable, description: Description) -> Element:
    attributes = common.identity(variable) | common.value_attributes(variable)
    attributes |= common.state_attributes(variable, description)
    if variable.role is Role.DERIVATIVE:
        attributes["derivative"] = str(description.states[variable.index].value_reference)
    # what is discrete holds its value until the step ends
    if variable.role is Role.INPUT or (variable.is_output and variable.variability == "continuous"):
        attributes["intermediateUpdate"] = "true"
    return Element(_ELEMENTS[variable.variable.kind], attributes)


def _add_structure(root: Element, description: Description) -> None:
    structure = description.structure
    element = SubElement(root, "ModelStructure")
    for name, unknowns in (
        ("Output", structure.outputs),
        ("ContinuousStateDerivative", structure.derivatives),
        ("InitialUnknown", structure.initial_unknowns),
        ("EventIndicator", structure.event_indicators),
    ):
        for unknown in unknowns:
            SubElement(element, name, _dependencies(unknown))


def _dependencies(unknown: Unknown) -> dict[str, str]:
    """Reference of an unknown, knowns and, where some enter by a factor, how each does."""
    attributes = {
        "valueReference": str(unknown.variable.value_reference),
        "dependencies": " ".join(str(known.value_reference) for known, _ in unknown.knowns),
    }
    kinds = [kind for _, kind in unknown.knowns]
    if any(kind is not Dependence.DEPENDENT for kind in kinds):
        attributes["dependenciesKind"] = " ".join(kind.name.lower() for kind in kinds)
    return attributes
