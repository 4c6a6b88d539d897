"""Terminals: the file, that its variables exist, and that signs are what it says."""

import io
import zipfile

import casadi as ca
import numpy as np
import pytest
from descriptions import STRUCTURES, described, strict_schema, structure_name
from lxml import etree
from matplotlib import image

import elastic_tendon as et
from elastic_tendon.actuator.interfaces import WITH_SPRINGS
from elastic_tendon.actuator.model import build
from elastic_tendon.fmu.description import to_bytes
from elastic_tendon.fmu.icon import flanges
from elastic_tendon.fmu.terminals import terminals_and_icons


@pytest.fixture(scope="module")
def root():
    return etree.fromstring(to_bytes(terminals_and_icons()))


def _flanges(root):
    """By name of the flange: (variable, kind) by member."""
    return {
        terminal.get("name"): {
            one.get("memberName"): (one.get("variableName"), one.get("variableKind"))
            for one in terminal.findall("TerminalMemberVariable")
        }
        for terminal in root.find("Terminals")
    }


def test_the_schema_knows_every_attribute(root, tmp_path):
    schema = strict_schema(3, "fmi3TerminalsAndIcons.xsd", tmp_path)
    assert schema.validate(root), schema.error_log


def test_version_is_that_of_the_description(root):
    """FMI 3.0.2, section 2.4.9: the two must match."""
    assert root.get("fmiVersion") == "3.0"


def test_flanges_have_the_members_of_a_rotational_flange(root):
    flanges = _flanges(root)
    assert set(flanges) == {"motor_flange", "joint_flange"}
    for members in flanges.values():
        kinds = {member: kind for member, (_, kind) in members.items()}
        assert kinds == {"phi": "signal", "w": "signal", "tau": "inflow"}
    assert {one.get("matchingRule") for one in root.find("Terminals")} == {"plug"}


@pytest.mark.parametrize("effect_ids", STRUCTURES, ids=structure_name)
def test_members_are_inputs_and_outputs(root, effect_ids):
    interface = described(effect_ids, 3).interface
    connected = {one.name: one.unit for one in (*interface.inputs, *interface.outputs)}
    units = {"phi": "rad", "w": "rad/s", "tau": "N.m"}
    for members in _flanges(root).values():
        for member, (variable, _) in members.items():
            assert connected[variable] == units[member]


def test_what_flows_in_is_stored(root):
    """``tau w`` at both flanges is the growth of energy, for positive `tau` flows in."""
    system = build(())
    interface = system.interface
    names = (interface.state_names, [one.name for one in interface.inputs], interface.output_names)
    columns = (system.x, system.u, system.outputs)
    symbol = {
        name: part
        for listed, column in zip(names, columns, strict=True)
        for name, part in zip(listed, ca.vertsplit(column), strict=True)
    }
    parameter = dict(zip(interface.parameter_names, ca.vertsplit(system.p), strict=True))
    energy = 0.5 * parameter["link.inertia"] * symbol["joint_velocity"] ** 2
    for side in ("upper_spring", "lower_spring"):
        path = f"transmission.{side}"
        stiffness = parameter[f"{path}.stiffness"] * parameter[f"{path}.parallel"]
        energy += symbol[f"{side}_force"] ** 2 / (2 * stiffness)
    motion = ca.vertcat(system.rates, symbol["motor_velocity"])
    along = ca.vertcat(system.x, symbol["motor_position"])
    power = sum(
        symbol[members["tau"][0]] * symbol[members["w"][0]] for members in _flanges(root).values()
    )
    balance = ca.Function(
        "balance",
        [system.x, system.u, system.p, system.r],
        [ca.jtimes(energy, along, motion), power],
    )
    undamped = {"link.damping": 0.0, "transmission.motor_pulley_radius": 0.02}
    values = [undamped.get(one.name, one.start) for one in interface.parameters]
    draw = np.random.default_rng(5)
    for _ in range(10):
        found = balance(
            *(draw.uniform(-1e-3, 1e-3, 2), draw.uniform(-1e-3, 1e-3, 3), values, [1, 1, 0, 0])
        )
        assert abs(float(found[1])) > 1e-9
        assert float(found[0]) == pytest.approx(float(found[1]), rel=1e-9)


def _read_by_another(path):
    """Terminals of an FMU as fmu-manipulation-toolbox reads them, and the variables by name.

    It takes the first element for the terminals, where the schema puts the picture (3.0.2, section
    2.4.9), which is therefore left out.
    """
    module = pytest.importorskip("fmu_manipulation_toolbox.terminals")
    with zipfile.ZipFile(path) as archive:
        read = etree.fromstring(archive.read("terminalsAndIcons/terminalsAndIcons.xml"))
        listed = etree.fromstring(archive.read("modelDescription.xml")).find("ModelVariables")
    read.remove(read.find("GraphicalRepresentation"))
    found = module.Terminals.from_xml_source(io.BytesIO(etree.tostring(read)))
    return found, {one.get("name"): one for one in listed}


@pytest.mark.parametrize("kind", WITH_SPRINGS)
@pytest.mark.usefixtures("made_soon")
def test_a_reader_that_is_not_ours_plugs_one_drive_into_another(kind, tmp_path):
    model = et.models.biorob_x4_joint_3.at(kind)
    found, variables = _read_by_another(et.export_fmu(model, tmp_path / "x.fmu", fmi_version=3))
    assert {one.name: (one.kind, one.matching) for one in found} == {
        "motor_flange": ("Modelica.Mechanics.Rotational.Interfaces.Flange_a", "plug"),
        "joint_flange": ("Modelica.Mechanics.Rotational.Interfaces.Flange_b", "plug"),
    }
    assert found["motor_flange"].connect(found["joint_flange"]) == [
        ("motor_position", "joint_position"),
        ("motor_velocity", "joint_velocity"),
        ("motor_torque", "load_torque"),
    ]
    given = {name for one in found for name in one.members.values()} & {
        name for name, variable in variables.items() if variable.get("causality") == "input"
    }
    motor = {"motor_torque"} if kind.has_rotor else {"motor_position", "motor_velocity"}
    joint = {"load_torque"} if kind.has_link else {"joint_position", "joint_velocity"}
    assert given == motor | joint
    units = {"phi": "rad", "w": "rad/s", "tau": "N.m"}
    for one in found:
        assert {
            member: variables[name].get("unit") for member, name in one.members.items()
        } == units


def test_every_picture_is_there(root):
    """Beside the icon, whose place is the whole picture; flanges lie at its left and right edge."""
    pictures = flanges()
    drawn = root.findall("Terminals/Terminal/TerminalGraphicalRepresentation")
    assert {f"{one.get('iconBaseName')}.png" for one in drawn} == set(pictures)
    edges = root.find("GraphicalRepresentation/Icon").get
    middles = [(float(one.get("x1")) + float(one.get("x2"))) / 2 for one in drawn]
    assert middles == [float(edges("x1")), float(edges("x2"))]
    for content in pictures.values():
        pixels = image.imread(io.BytesIO(content))
        assert pixels[0, 0, 3] == 0.0  # outside the disc nothing covers the ground
        assert pixels[32, 2:62, 3].min() == 1.0
