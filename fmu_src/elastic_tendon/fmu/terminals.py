"""terminalsAndIcons.xml of FMI 3.0: the flanges of the motor pulley and of the joint, and pictures.

Both flanges follow one rule of signs: `tau` is the torque that acts on the actuator from outside,
positive in the direction of `phi`, so ``tau * w`` is the power that flows in there. At the joint
that is the load, at the motor what the motor has to bring to hold the tendons.
"""

import struct
import zlib
from dataclasses import dataclass
from xml.etree.ElementTree import Element, SubElement

import numpy as np

_HALF_WIDTH = 100.0  # of the picture, in the units of its coordinate system
_FLANGE_HALF_WIDTH = 10.0
_MILLIMETRES = 0.1  # on paper, of one unit
_PIXELS = 64  # across the picture of a flange
_GREY = 128


@dataclass(frozen=True)
class _Flange:
    """A rotational flange: names of its variables, and where along the picture it is drawn."""

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
        "Modelica.Mechanics.Rotational.Interfaces.Flange_a",
        "flange_a",
        "motor pulley; tau is the torque that the motor has to apply to it",
        *("motor_position", "motor_velocity", "motor_torque"),
        -_HALF_WIDTH,
    ),
    _Flange(
        "joint_flange",
        "Modelica.Mechanics.Rotational.Interfaces.Flange_b",
        "flange_b",
        "joint with its link; tau is the external torque on it",
        *("joint_position", "joint_velocity", "load_torque"),
        _HALF_WIDTH,
    ),
)


def terminals_and_icons() -> Element:
    """Root element of terminalsAndIcons.xml, the same for every model.

    The icon lies beside it as icon.png and icon.svg, `flange_pictures` too.
    """
    root = Element("fmiTerminalsAndIcons", fmiVersion="3.0")
    picture = SubElement(root, "GraphicalRepresentation")
    whole = _box(0.0, _HALF_WIDTH)
    SubElement(picture, "CoordinateSystem", whole, suggestedScalingFactorTo_mm=repr(_MILLIMETRES))
    SubElement(picture, "Icon", whole)
    terminals = SubElement(root, "Terminals")
    for flange in _FLANGES:
        terminals.append(_terminal(flange))
    return root


def _terminal(flange: _Flange) -> Element:
    attributes = {"name": flange.name, "matchingRule": "plug", "terminalKind": flange.kind}
    terminal = Element("Terminal", attributes, description=flange.meaning)
    for member, variable, kind in (
        ("phi", flange.position, "signal"),
        ("w", flange.velocity, "signal"),
        ("tau", flange.torque, "inflow"),
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


# ---- pictures of the flanges ---------------------------------------------------------------


def flange_pictures() -> dict[str, bytes]:
    """PNG files by name: a grey disc for the motor's flange, a grey ring for the joint's."""
    return {"flange_a.png": _ring_png(0.0), "flange_b.png": _ring_png(0.7)}


def _ring_png(hole: float) -> bytes:
    """Picture of a ring whose hole is white, of a radius relative to the ring's."""
    place = np.arange(_PIXELS) - 0.5 * (_PIXELS - 1)
    distance = np.hypot(place[:, None], place)  # from the middle, pixels
    radius = 0.5 * _PIXELS - 1.0
    inside, in_hole = (np.clip(r - distance + 0.5, 0.0, 1.0) for r in (radius, hole * radius))
    shade = np.rint(_GREY + (255 - _GREY) * in_hole * (hole > 0))
    pixels = np.stack([shade, np.rint(255 * inside)], axis=-1).astype(np.uint8)
    # each row begins with the number of its filter, 0 for none
    rows = b"".join(b"\0" + row.tobytes() for row in pixels)
    header = struct.pack(">IIBBBBB", _PIXELS, _PIXELS, 8, 4, 0, 0, 0)  # grey with transparency
    chunks = ((b"IHDR", header), (b"IDAT", zlib.compress(rows, 0)), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(_chunk(*chunk) for chunk in chunks)


def _chunk(name: bytes, content: bytes) -> bytes:
    check = struct.pack(">I", zlib.crc32(name + content))
    return struct.pack(">I", len(content)) + name + content + check
