"""The file: description, units, structure, archive, binary."""

import re
import subprocess
import zipfile
from importlib.util import find_spec
from pathlib import Path

import pytest
from fmpy.validation import validate_fmu
from fmu_cases import BOTH, MODELS
from lxml import etree

from elastic_tendon.actuator.variables import interface
from elastic_tendon.effects.units import base_exponents
from elastic_tendon.errors import BuildError
from elastic_tendon.fmu.export import export_fmu
from elastic_tendon.native.layout import rate_unit


def _root(fmu):
    with zipfile.ZipFile(fmu.path) as archive:
        return etree.fromstring(archive.read("modelDescription.xml"))


def _unknowns(fmu, group):
    """Dependencies by unknown, by name."""
    names = [one.name for one in fmu.description.modelVariables]
    return {
        names[int(one.get("index")) - 1]: {
            names[int(i) - 1] for i in one.get("dependencies").split()
        }
        for one in _root(fmu).find(f"ModelStructure/{group}")
    }


def test_fmpy_finds_no_problem(fmus, name):
    assert validate_fmu(str(fmus(name).path)) == []


def test_description_follows_the_schema(fmus, name):
    schema = Path(find_spec("fmpy").origin).parent / "schema" / "fmi2" / "fmi2ModelDescription.xsd"
    root = _root(fmus(name))
    etree.XMLSchema(etree.parse(str(schema))).assertValid(root)
    assert root.get("fmiVersion") == "2.0"


def test_variables_are_those_of_the_model(fmus, name):
    model, fmu = MODELS[name], fmus(name)
    variables = interface(model.effect_ids)
    found = {}
    for one in fmu.description.modelVariables:
        found.setdefault(one.causality, []).append(one.name)
    assert found["input"] == [one.name for one in variables.inputs]
    assert found["output"] == [*variables.output_names, "slack_state_number"]
    assert found["parameter"] == [*variables.parameter_names, "motor_velocity_connected"]
    assert found["independent"] == ["time"]
    references = [one.valueReference for one in fmu.description.modelVariables]
    assert len(set(references)) == len(references)


def test_every_start_is_within_its_bounds(fmus, name):
    bounded = [
        one
        for one in fmus(name).description.modelVariables
        if one.min is not None and one.start is not None
    ]
    assert len(bounded) > 10
    for one in bounded:
        assert float(one.min) <= float(one.start) <= float(one.max), one.name


def test_binary_starts_with_the_values_of_the_description(fmus, instances, name):
    fmu = fmus(name)
    slave = instances(fmu.slave())
    slave.set_up()
    values = MODELS[name].values()
    for one in fmu.description.modelVariables:
        if one.start is not None:
            start = {"true": 1.0, "false": 0.0}.get(one.start)
            assert slave.get(one.name) == (float(one.start) if start is None else start), one.name
        if one.name in values:
            assert slave.get(one.name) == values[one.name]


@BOTH
def test_description_says_whose_it_is_and_what_it_needs(base, version):
    root = _root(base)
    holder = re.search(r"Copyright.*", (Path(__file__).parents[2] / "LICENSE").read_text())[0]
    assert (root.get("copyright"), root.get("license")) == (holder, "MIT")
    for interface_type in ("ModelExchange", "CoSimulation"):
        said = root.find(interface_type).attrib
        assert said["needsExecutionTool"] == "false"
        assert said["canBeInstantiatedOnlyOncePerProcess"] == "false"
        assert version == 2 or said["providesPerElementDependencies"] == "false"


@BOTH
def test_lengths_are_shown_in_millimetres(base):
    shown = base.description.unitDefinitions
    (millimetre,) = next(unit for unit in shown if unit.name == "m").displayUnits
    assert (millimetre.name, millimetre.factor) == ("mm", 1000.0)
    radius = base.description.modelVariables[15]
    assert radius.name == "transmission.joint_pulley_radius"
    assert (radius.unit, radius.declaredType.displayUnit) == ("m", "mm")


@BOTH
def test_a_tension_is_never_negative(base, instances):
    """Also where an importer looks beyond an event, with relations that are frozen."""
    model = instances(base.model())
    model.begin()
    for position in (-0.5, 0.5):
        model.set("joint_position", position)
        forces = [model.get(f"{side}_spring_force") for side in ("upper", "lower")]
        assert min(forces) == 0.0
        assert max(forces) > 0.0
    bounds = {one.name: one.min for one in base.description.modelVariables}
    assert float(bounds["upper_spring_force"]) == float(bounds["lower_spring_force"]) == 0.0


def test_derivatives_name_their_states(fmus, name):
    derivatives = fmus(name).description.derivatives
    assert len(derivatives) == len(interface(MODELS[name].effect_ids).states)
    for unknown in derivatives:
        assert unknown.variable.name == f"der({unknown.variable.derivative.name})"


def test_dependencies_of_outputs(fmus):
    """All that the equations let through, through whatever mode, and nothing else."""
    found = _unknowns(fmus("base"), "Outputs")
    motion = {"motor_position", "joint_position"}
    rates = {"motor_velocity", "joint_velocity"}
    assert found["joint_torque"] == found["slack_state"] == motion | rates
    assert found["deflection"] == found["overstretched"] == motion
    assert found["joint_position"] == {"joint_position"}


def test_dependencies_pass_through_modes(fmus):
    """Whether the joint sticks depends on the load, so its rate does."""
    assert "load_torque" not in _unknowns(fmus("base"), "Derivatives")["der(joint_position)"]
    assert "load_torque" in _unknowns(fmus("effects"), "Derivatives")["der(joint_position)"]


def test_initial_unknowns_depend_on_parameters_too(fmus):
    found = _unknowns(fmus("base"), "InitialUnknowns")
    assert "joint_position" not in found
    assert "link.inertia" in found["der(joint_velocity)"]
    assert "link.inertia" not in found["joint_torque"]
    assert "motor_velocity_connected" in found["joint_torque"]
    assert "motor_velocity_connected" not in found["deflection"]


@pytest.mark.parametrize(
    ("unit", "exponents"),
    [
        ("N.m.s/rad", {"kg": 1, "m": 2, "s": -1, "rad": -1}),
        ("kg.m2", {"kg": 1, "m": 2}),
        ("1", {}),
        ("1/s", {"s": -1}),
        ("N/(m.s)", {"kg": 1, "s": -3}),
    ],
)
def test_units_in_base_units(unit, exponents):
    assert base_exponents(unit) == exponents


def test_units_of_rates():
    assert [rate_unit(unit) for unit in ("rad", "rad/s", "N/m", "1")] == [
        *("rad/s", "rad/s2", "N/(m.s)", "1/s")
    ]


def test_an_unknown_unit_is_refused():
    with pytest.raises(BuildError, match="furlong"):
        base_exponents("furlong/s")


def test_generation_time_comes_from_the_environment(fmus, tmp_path, monkeypatch):
    assert fmus("base").description.generationDateAndTime is None
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "86400")
    path = export_fmu(MODELS["base"], tmp_path / "x.fmu")
    with zipfile.ZipFile(path) as archive:
        assert b'generationDateAndTime="1970-01-02T00:00:00Z"' in archive.read(
            "modelDescription.xml"
        )


def test_sources_have_no_writable_globals(base):
    """Instances run in parallel threads: all that the runtime keeps is in the instance."""
    (library,) = Path(base.folder).glob("binaries/linux64/*.so")
    sections = subprocess.run(
        ["readelf", "-S", "-W", str(library)], capture_output=True, text=True, check=True
    ).stdout
    sizes = {
        match[1]: int(match[2], 16)
        for match in re.finditer(r"\] (\.\w+)\s+\w+\s+\w+ \w+ (\w+) ", sections)
    }
    assert ".text" in sizes
    assert sizes.get(".data", 0) + sizes.get(".bss", 0) <= 64  # the C run-time's own few bytes
