"""modelDescription.xml of FMI 3.0, for every effect; what both versions share besides."""

import math
import re

import pytest
from descriptions import (
    MANY,
    SCHEMAS,
    STRUCTURES,
    content,
    described,
    strict_schema,
    structure_name,
)
from fmpy import read_model_description
from lxml import etree

from elastic_tendon.actuator.variables import Kind
from elastic_tendon.fmu import fmi3_description
from elastic_tendon.fmu.description import seal, to_bytes

# of FMI 2.0.4, section 2.2.9, and FMI 3.0.2, section 2.4.7.5, without quoted names
PART = r"[A-Za-z_]\w*(\[\d+(,\d+)*\])?"
STRUCTURED_NAME = re.compile(rf"(?a:{PART}(\.{PART})*|der\({PART}(\.{PART})*(,\d+)?\))")
XSD = {"xs": "http://www.w3.org/2001/XMLSchema"}
every_structure = pytest.mark.parametrize("effect_ids", STRUCTURES, ids=structure_name)
both_versions = pytest.mark.parametrize("version", [2, 3])


@pytest.fixture(scope="module")
def strict(tmp_path_factory):
    """Strict schema of each version."""
    return {
        version: strict_schema(
            version, f"fmi{version}ModelDescription.xsd", tmp_path_factory.mktemp("schema")
        )
        for version in (2, 3)
    }


def _root(effect_ids, version=3):
    return etree.fromstring(content(effect_ids, version))


def _variables(root):
    return {one.get("name"): one for one in root.find("ModelVariables")}


def _typed(root):
    """By name: the element that has a variable's unit, bounds and start."""
    inside = root.get("fmiVersion") == "2.0"
    return {name: one[0] if inside else one for name, one in _variables(root).items()}


def _unknowns(root, group):
    """By name: knowns with their kinds, by name."""
    names = {one.get("valueReference"): name for name, one in _variables(root).items()}
    found = {}
    for one in root.findall(f"ModelStructure/{group}"):
        knowns = [names[reference] for reference in one.get("dependencies").split()]
        kinds = one.get("dependenciesKind", "dependent " * len(knowns)).split()
        found[names[one.get("valueReference")]] = dict(zip(knowns, kinds, strict=True))
    return found


# ---- both versions -------------------------------------------------------------------------


@both_versions
@every_structure
def test_the_schema_knows_every_attribute(effect_ids, version, strict):
    schema = strict[version]
    assert schema.validate(_root(effect_ids, version)), schema.error_log


@pytest.mark.parametrize(
    ("version", "misspelt"), [(2, "canGetAndSetFMUState"), (3, "canGetAndSetFMUstate")]
)
def test_a_misspelt_capability_would_be_seen(version, misspelt, strict):
    root = _root((), version)
    root.find("CoSimulation").set(misspelt, "true")
    assert not strict[version].validate(root)


@both_versions
@every_structure
def test_fmpy_finds_no_problem(effect_ids, version, tmp_path):
    (tmp_path / "modelDescription.xml").write_bytes(content(effect_ids, version))
    options = {"validate_variable_names": True, "validate_model_structure": True}
    description = read_model_description(str(tmp_path), validate=True, **options)
    names = [one.name for one in description.modelVariables]
    assert names == [one.name for one in described(effect_ids, version).variables]


@both_versions
def test_fmpy_would_see_a_problem(version, tmp_path):
    """It raises what it finds, so that reading is the test."""
    root = _root((), version)
    root.find("ModelVariables")[1].set("name", "no name")
    (tmp_path / "modelDescription.xml").write_bytes(to_bytes(root))
    with pytest.raises(Exception, match="no name"):
        read_model_description(str(tmp_path), validate=True, validate_variable_names=True)


@both_versions
@every_structure
def test_names_are_structured(effect_ids, version):
    root = _root(effect_ids, version)
    assert root.get("variableNamingConvention") == "structured"
    for name in _variables(root):
        assert STRUCTURED_NAME.fullmatch(name), name


@pytest.mark.parametrize("name", ["a b", "1a", "a.", "der(der(a))", "a[1", "ä", "a[i]"])
def test_the_grammar_refuses(name):
    assert not STRUCTURED_NAME.fullmatch(name)


@both_versions
@every_structure
def test_every_number_is_described(effect_ids, version):
    for one in described(effect_ids, version).variables:
        assert one.variable.meaning, one.name
        assert one.variable.nominal > 0, one.name
        if one.start is not None:
            assert one.variable.lower <= one.start <= one.variable.upper, one.name


@both_versions
@every_structure
def test_min_and_max_stand_where_a_quantity_has_them(effect_ids, version):
    """Each parameter is bounded, a tension on one side; inputs and motion are not."""
    found = {
        name: (float(one.get("min", -math.inf)), float(one.get("max", math.inf)))
        for name, one in _typed(_root(effect_ids, version)).items()
    }
    parameters = described(effect_ids, version).interface.parameters
    bounded = {name: bounds for name, bounds in found.items() if bounds != (-math.inf, math.inf)}
    assert bounded == {
        **{one.name: (one.lower, one.upper) for one in parameters},
        **dict.fromkeys(("slack_state", "slack_state_number"), (1, 4)),
        **dict.fromkeys(("upper_spring_force", "lower_spring_force"), (0, math.inf)),
    }
    assert all(-math.inf < one.lower < one.upper < math.inf for one in parameters)


@both_versions
@every_structure
def test_starts_are_the_shortest_decimals_that_read_back(effect_ids, version):
    typed = _typed(_root(effect_ids, version))
    reals = [one for one in described(effect_ids, version).variables if one.start is not None]
    for one in reals:
        if one.variable.kind is Kind.REAL:
            assert typed[one.name].get("start") == repr(float(one.start)), one.name
    assert typed["link.inertia"].get("start") == "0.03"


@both_versions
@every_structure
def test_every_length_is_shown_in_millimetres(effect_ids, version):
    lengths = [
        one.get("displayUnit")
        for one in _typed(_root(effect_ids, version)).values()
        if one.get("unit") == "m"
    ]
    assert len(lengths) >= 4
    assert set(lengths) == {"mm"}


def test_sizes_agree():
    """The joint's velocity and the derivative of its position are the same number."""
    nominal = {one.name: one.variable.nominal for one in described((), 3).variables}
    assert nominal["der(joint_position)"] == nominal["joint_velocity"]
    assert nominal["der(joint_velocity)"] == 10.0  # rad/s2


@both_versions
def test_only_what_an_event_changes_may_be_set_anew(version):
    """Friction that stops the joint takes its velocity to 0; no other state jumps."""
    roots = (_root((), version), _root(("coulomb_friction",), version))
    found = [
        [one.getparent().get("name") if version == 2 else one.get("name") for one in marked]
        for marked in (root.xpath("//*[@reinit='true']") for root in roots)
    ]
    assert found == [[], ["joint_velocity"]]


@both_versions
def test_token_is_of_content_and_binary(version):
    contents = {content((), version), content(("coulomb_friction",), version)}
    other = _root((), version)
    seal(other, "another binary")
    contents.add(to_bytes(other))
    attribute = {2: "guid", 3: "instantiationToken"}[version]
    roots = [etree.fromstring(one) for one in contents]
    tokens = {root.get(attribute) for root in roots}
    assert len(tokens) == 3
    assert all(
        re.fullmatch(r"\{[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}\}", one) for one in tokens
    )
    assert not {"guid", "instantiationToken"} - {attribute} & set(roots[0].attrib)


# ---- variables -----------------------------------------------------------------------------


@every_structure
def test_types_and_one_independent_variable(effect_ids):
    variables = _variables(_root(effect_ids))
    independent = [name for name, one in variables.items() if one.get("causality") == "independent"]
    assert independent == ["time"]
    references = [one.get("valueReference") for one in variables.values()]
    assert len(set(references)) == len(references)
    assert variables["slack_state"].tag == "Enumeration"
    assert variables["slack_state"].get("declaredType") == "SlackState"
    assert variables["transmission.upper_spring.parallel"].tag == "Int32"
    assert variables["overstretched"].tag == variables["motor_velocity_connected"].tag == "Boolean"
    others = {one.tag for name, one in variables.items() if one.get("variability") == "continuous"}
    assert others == {"Float64"}


def test_angles_are_shown_in_degrees():
    root = _root(())
    for name, display in (
        ("joint_position", "deg"),
        ("motor_velocity", "deg/s"),
        ("der(joint_velocity)", "deg/s2"),
    ):
        assert _variables(root)[name].get("displayUnit") == display
        (unit,) = root.xpath(f"UnitDefinitions/Unit/DisplayUnit[@name='{display}']")
        assert float(unit.get("factor")) * 3.141592653589793 == 180.0


@every_structure
def test_derivatives_name_their_states(effect_ids):
    variables = _variables(_root(effect_ids))
    named = {name: one for name, one in variables.items() if one.get("derivative") is not None}
    assert {f"der({one.name})" for one in described(effect_ids, 3).interface.states} == set(named)
    for name, one in named.items():
        assert variables[name[4:-1]].get("valueReference") == one.get("derivative")


def test_what_is_read_and_set_inside_a_step():
    """Reals that the importer connects; what is discrete waits for the step's end."""
    variables = _variables(_root(MANY))
    marked = {name for name, one in variables.items() if one.get("intermediateUpdate") == "true"}
    interface = described(MANY, 3).interface
    discrete = {"slack_state", "overstretched"}
    inputs = {one.name for one in interface.inputs}
    assert marked == inputs | set(interface.output_names) - discrete


@every_structure
def test_parameters_are_fixed_or_tunable(effect_ids):
    variables = _variables(_root(effect_ids))
    variability = {
        name: one.get("variability")
        for name, one in variables.items()
        if one.get("causality") == "parameter"
    }
    assert set(variability.values()) == {"fixed", "tunable"}
    assert variability["link.inertia"] == "tunable"
    assert variability["transmission.joint_pulley_radius"] == "fixed"
    assert variability["motor_velocity_connected"] == "fixed"


# ---- structure -----------------------------------------------------------------------------


@every_structure
def test_structure_is_in_the_order_of_the_solver(effect_ids):
    root, interface = _root(effect_ids), described(effect_ids, 3).interface
    assert tuple(_unknowns(root, "Output")) == (*interface.output_names, "slack_state_number")
    rates = [f"der({name})" for name in interface.state_names]
    assert list(_unknowns(root, "ContinuousStateDerivative")) == rates
    indicators = list(_unknowns(root, "EventIndicator"))
    modes = [mode.name for mode in interface.modes for _ in range(mode.indicators)]
    assert [name.rpartition(".indicator")[0] for name in indicators] == modes
    variables = _variables(root)
    for name in indicators:
        assert variables[name].get("causality") == "local"
        assert variables[name].get("variability") == "continuous"


@every_structure
def test_initial_unknowns_are_what_is_calculated(effect_ids):
    root, interface = _root(effect_ids), described(effect_ids, 3).interface
    exact = {one.name for one in interface.states if one.start is not None}
    states = {*interface.state_names, *(f"der({name})" for name in interface.state_names)}
    found = _unknowns(root, "InitialUnknown")
    outputs = {*interface.output_names, "slack_state_number"}
    assert set(found) == (outputs | states) - exact
    variables = _variables(root)
    for name, knowns in found.items():
        assert variables[name].get("initial") == "calculated"
        assert {variables[known].get("initial", "exact") for known in knowns} == {"exact"}
        assert set(knowns.values()) <= {"dependent", "constant"}, name


@every_structure
def test_knowns_are_what_may_change(effect_ids):
    """What is fixed after initialisation is no known any more."""
    root, interface = _root(effect_ids), described(effect_ids, 3).interface
    tunable = {one.name for one in interface.parameters if one.tunable}
    knowns = {*interface.state_names, *(one.name for one in interface.inputs)} | tunable
    for group in ("Output", "ContinuousStateDerivative", "EventIndicator"):
        assert set().union(*_unknowns(root, group).values()) <= knowns
    for name in ("slack_state", "overstretched"):
        assert set(_unknowns(root, "Output")[name].values()) == {"dependent"}


def test_kinds_of_dependence():
    root = _root(())
    outputs, rates = (_unknowns(root, group) for group in ("Output", "ContinuousStateDerivative"))
    assert outputs["deflection"] == {"motor_position": "fixed", "joint_position": "constant"}
    assert rates["der(joint_position)"] == {"joint_velocity": "constant"}
    assert rates["der(joint_velocity)"]["load_torque"] == "tunable"
    assert rates["der(joint_velocity)"]["joint_position"] == "discrete"
    assert rates["der(joint_velocity)"]["link.inertia"] == "dependent"
    assert _unknowns(root, "InitialUnknown")["deflection"] == {
        "motor_position": "dependent",
        "joint_position": "constant",
        "transmission.joint_pulley_radius": "dependent",
        "transmission.motor_pulley_radius": "dependent",
    }


# ---- capabilities --------------------------------------------------------------------------


def test_interfaces_with_their_capabilities():
    root = _root(())
    for name, capabilities in (
        ("ModelExchange", fmi3_description.MODEL_EXCHANGE),
        ("CoSimulation", fmi3_description.CO_SIMULATION),
    ):
        assert root.find(name).attrib == {"modelIdentifier": "model"} | capabilities
        assert capabilities["providesEvaluateDiscreteStates"] == "false"  # nothing to evaluate


@both_versions
def test_no_capability_is_left_to_the_default(version):
    schemas = [etree.parse(str(path)) for path in (SCHEMAS / f"fmi{version}").glob("*.xsd")]
    root = _root((), version)
    for name in ("ModelExchange", "CoSimulation"):
        places = f"*[@name='{name}' or @name='fmi3{name}' or @name='fmi3InterfaceType']"
        query = f"//{places}//xs:attribute[@type='xs:boolean']/@name"
        known = {one for schema in schemas for one in schema.xpath(query, namespaces=XSD)}
        assert len(known) > 5
        assert known <= set(root.find(name).keys())
