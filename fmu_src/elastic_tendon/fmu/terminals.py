"""terminalsAndIcons.xml of FMI 3.0: the flanges of the motor pulley and of the joint, and pictures.

Both flanges follow one rule of signs: `tau` is the torque that acts on the actuator from outside,
positive in the direction of `phi`, so ``tau * w`` is the power that flows in there. At the joint
that is the load, at the motor what the motor has to bring to hold the tendons.
"""

from dataclasses import dataclass
from xml.etree.ElementTree import Element, SubElement

from elastic_tendon.actuator.interfaces import InterfaceKind
from elastic_tendon.actuator.motion_kind import MotionKind

_HALF_WIDTH = 100.0  # of the picture, in the units of its coordinate system
_FLANGE_HALF_WIDTH = 10.0
_MILLIMETRES = 0.1  # on paper, of one unit


@dataclass(frozen=True)
class _Flange:
    """A flange: names of its variables, and where along the picture it is drawn."""

    name: str
    kind: str
    picture: str
    meaning: str
    position: str
    velocity: str
    torque: str
    x: float


_FLANGES = (
    _Flange(
        "motor_flange",
        "Flange_a",
        "flange_a",
        "motor pulley; tau is the torque that the motor has to apply to it",
        *("motor_position", "motor_velocity", "motor_torque"),
        -_HALF_WIDTH,
    ),
    _Flange(
        "joint_flange",
        "Flange_b",
        "flange_b",
        "joint with its link; tau is the external torque on it",
        *("joint_position", "joint_velocity", "load_torque"),
        _HALF_WIDTH,
    ),
)


def terminals_and_icons(
    kind: InterfaceKind = InterfaceKind.POSITION, motion: MotionKind = MotionKind.ROTARY
) -> Element:
    """Root element of terminalsAndIcons.xml, the same for all models of an interface and motion.

    The pictures, from `icon`, lie beside it.
    """
    root = Element("fmiTerminalsAndIcons", fmiVersion="3.0")
    picture = SubElement(root, "GraphicalRepresentation")
    whole = _box(0.0, _HALF_WIDTH)
    SubElement(picture, "CoordinateSystem", whole, suggestedScalingFactorTo_mm=repr(_MILLIMETRES))
    SubElement(picture, "Icon", whole)
    terminals = SubElement(root, "Terminals")
    for flange in _FLANGES if kind.has_springs else _FLANGES[1:]:
        terminals.append(_terminal(flange, motion))
    return root


# of the flanges of Modelica's mechanics: their package, and what they call what flows there
_MEMBERS = {
    MotionKind.ROTARY: ("Rotational", "phi", "w", "tau"),
    MotionKind.LINEAR: ("Translational", "s", "v", "f"),
}


def _terminal(flange: _Flange, motion: MotionKind) -> Element:
    package, position, velocity, torque = _MEMBERS[motion]
    attributes = {
        "name": flange.name,
        "matchingRule": "plug",
        "terminalKind": f"Modelica.Mechanics.{package}.Interfaces.{flange.kind}",
    }
    meaning = motion.words(flange.meaning.replace("tau", torque))
    terminal = Element("Terminal", attributes, description=meaning)
    for member, variable, kind in (
        (position, flange.position, "signal"),
        (velocity, flange.velocity, "signal"),
        (torque, flange.torque, "inflow"),
    ):
        names = {"variableName": variable, "memberName": member, "variableKind": kind}
        SubElement(terminal, "TerminalMemberVariable", names)
    place = _box(flange.x, _FLANGE_HALF_WIDTH) | {"iconBaseName": flange.picture}
    SubElement(terminal, "TerminalGraphicalRepresentation", place)
    return terminal


def _box(x: float, half_width: float) -> dict[str, str]:
    """Corners of a square at half the height: lower left, upper right."""
    low, high = -half_width, half_width
    corners = {"x1": x + low, "y1": low, "x2": x + high, "y2": high}
    return {name: repr(value) for name, value in corners.items()}
