"""Values of parameters with their uncertainty, as a parameter set (SSV) of the standard SSP."""

from collections.abc import Mapping
from dataclasses import dataclass
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from elastic_tendon.errors import EvidenceError
from elastic_tendon.evidence.xml_content import one_line, parse

_VALUES = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"
_COMMON = "http://ssp-standard.org/SSP1/SystemStructureCommon"
_OURS = "elastic-tendon"  # type of the annotations


@dataclass(frozen=True)
class Uncertainty:
    """Of m parameters: dotted `paths`, 95 % `intervals` and `covariance` (m, m), SI.

    `basis` : whose word the sizes are, "diagnosis" or "model".
    """

    paths: tuple[str, ...]
    intervals: tuple[tuple[float, float], ...]
    covariance: tuple[tuple[float, ...], ...]
    basis: str


def parameter_set(
    name: str,
    values: Mapping[str, float],
    units: Mapping[str, str],
    uncertainty: Uncertainty,
) -> bytes:
    """The set as XML: every value; of fitted ones the interval; the covariance of all of them.

    Parameters
    ----------
    name : of the set
    values, units : by dotted path, SI
    uncertainty : of some of them
    """
    ElementTree.register_namespace("ssv", _VALUES)
    ElementTree.register_namespace("ssc", _COMMON)
    root = Element(f"{{{_VALUES}}}ParameterSet", version="1.0", name=name)
    listed = SubElement(root, f"{{{_VALUES}}}Parameters")
    intervals = dict(zip(uncertainty.paths, uncertainty.intervals, strict=True))
    for path, value in values.items():
        parameter = SubElement(listed, f"{{{_VALUES}}}Parameter", name=path)
        SubElement(parameter, f"{{{_VALUES}}}Real", value=repr(float(value)))
    facts = SubElement(
        SubElement(root, f"{{{_VALUES}}}Annotations"), f"{{{_COMMON}}}Annotation", type=_OURS
    )
    facts = SubElement(facts, "uncertainty", basis=uncertainty.basis)
    for path, (low, high) in intervals.items():
        SubElement(
            facts,
            "interval",
            {"name": path, "unit": units[path], "low": repr(low), "high": repr(high)},
            confidence="0.95",
        )
    covariance = SubElement(facts, "covariance", names=" ".join(uncertainty.paths))
    for row in uncertainty.covariance:
        SubElement(covariance, "row").text = " ".join(f"{number:.9g}" for number in row)
    ElementTree.indent(root)
    return bytes(ElementTree.tostring(root, "utf-8", xml_declaration=True)) + b"\n"


def read_values(content: bytes, source: str) -> dict[str, float]:
    """Real numbers of a parameter set by name, whoever made it.

    Raises
    ------
    EvidenceError : it is no parameter set
    """
    root = parse(content, source)
    try:
        found = root.iter(f"{{{_VALUES}}}Parameter")
        reals = (
            (one_line(entry.get("name", "")), entry.find(f"{{{_VALUES}}}Real")) for entry in found
        )
        values = {name: float(real.get("value", "")) for name, real in reals if real is not None}
    except ValueError:
        raise EvidenceError(f"{source}: it is no parameter set (SSV) of numbers") from None
    if root.tag != f"{{{_VALUES}}}ParameterSet":
        raise EvidenceError(f"{source}: it is no parameter set (SSV)")
    return values
