"""The characteristic curve of an actuator as a small SVG, for the FMU's documentation."""

from collections.abc import Callable, Iterable, Sequence
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from elastic_tendon.actuator.sections import Transmission
from elastic_tendon.actuator.transmission import (
    characteristic_torque,
    deflection_limits,
    slack_boundaries,
)

WIDTH, HEIGHT = 480.0, 240.0
LEFT, RIGHT, TOP, BOTTOM = 80.0, 16.0, 24.0, 28.0  # margins
NARROW = 30.0  # a region below this width has no room for its name

Point = tuple[float, float]


def _scale(values: Sequence[float], first: float, last: float) -> Callable[[float], float]:
    """Place of a value on an axis that spans `values`, from `first` to `last`."""
    low, high = min(values), max(values)
    return lambda value: first + (value - low) / (high - low) * (last - first)


def _line(parent: Element, style: str, points: Iterable[Point]) -> None:
    text = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    SubElement(parent, "polyline", {"points": text, "class": style})


def _text(parent: Element, anchor: str, place: Point, text: str) -> None:
    x, y = (f"{coordinate:.1f}" for coordinate in place)
    SubElement(parent, "text", {"x": x, "y": y, "text-anchor": anchor}).text = text


def _slack_states(svg: Element, borders: Sequence[float]) -> None:
    """Names of the slack states over the pieces of the deflection that they hold."""
    for border in borders[1:-1]:
        _line(svg, "boundary", ((border, TOP), (border, HEIGHT - BOTTOM)))
    for name, left, right in zip(("I", "III", "II"), borders[:-1], borders[1:], strict=True):
        if right - left > NARROW:
            _text(svg, "middle", ((left + right) / 2, TOP - 8), name)


def characteristic_plot(transmission: Transmission) -> Element | None:
    """Torque on the joint over its deflection at rest, between the limits of the springs.

    Parameters
    ----------
    transmission : Transmission

    Returns
    -------
    Element, an svg with the classes axis, boundary and curve; None where the pretension stretches
    both springs to their limits
    """
    low, high = deflection_limits(transmission)
    if not low < high:
        return None
    kinks = [float(kink) for kink in np.clip(slack_boundaries(transmission), low, high)]
    deflections = [low, *kinks, high]
    torques = characteristic_torque(deflections, transmission).tolist()
    x = _scale(deflections, LEFT, WIDTH - RIGHT)
    y = _scale(torques, HEIGHT - BOTTOM, TOP)
    svg = Element("svg", {"viewBox": f"0 0 {WIDTH:g} {HEIGHT:g}", "role": "img"})
    _line(svg, "axis", ((LEFT, y(0)), (WIDTH - RIGHT, y(0))))
    _line(svg, "axis", ((x(0), TOP), (x(0), HEIGHT - BOTTOM)))
    _slack_states(svg, [x(deflection) for deflection in deflections])
    _line(svg, "curve", ((x(d), y(t)) for d, t in zip(deflections, torques, strict=True)))
    for deflection, torque, anchor in (
        (low, max(torques), "start"),
        (high, min(torques), "end"),
    ):
        _text(svg, anchor, (x(deflection), HEIGHT - 8), f"{deflection:.3g} rad")
        _text(svg, "end", (LEFT - 6, y(torque) + 4), f"{torque:.3g} N·m")
    return svg
