"""Draw the pictures of the FMUs: writes icon.svg, icon.png and flange_*.png into the package.

The icon shows the actuator in slack state I: motor on the left, joint pulley with its link on the
right, the upper tendon taut, the lower one slack. Both its files are made from the same shapes, in
units of a hundredth of the width; tests/fmu/test_fmu_documentation.py compares them with what is
drawn here.
"""

import io
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Polygon

FOLDER = Path(__file__).parents[1] / "fmu_src" / "elastic_tendon" / "fmu" / "pages"
PIXELS = 400
FLANGE_PIXELS = 64
DPI = 100
POINTS_PER_UNIT = PIXELS / DPI * 72 / 100

SVG = "http://www.w3.org/2000/svg"

Point = tuple[float, float]  # to the right, downwards

FRAME, CARD, HOUSING, METAL = "#8593a0", "#f4f6f9", "#a9b6c2", "#24384b"
TAUT, SLACK = "#d9480f", "#1c7ed6"

MOTOR, MOTOR_RADIUS = (22.0, 42.0), 13.0
JOINT, JOINT_RADIUS = (68.0, 42.0), 19.0
LINK_END = (89.0, 68.0)
WIDTH = 3.0  # of tendons and springs
COILS, COIL = 3, 5.5  # of a spring: their number and half their height
SAG = 15.0  # of the slack tendon


@dataclass(frozen=True)
class Disc:
    """A filled circle."""

    centre: Point
    radius: float
    colour: str

    def svg(self) -> Element:
        """As an element of SVG."""
        x, y = self.centre
        size = {"cx": f"{x:g}", "cy": f"{y:g}", "r": f"{self.radius:g}"}
        return Element("circle", {**size, "fill": self.colour})

    def draw(self, axes: Axes, order: int) -> None:
        """With matplotlib, in front of what has a lower `order`."""
        disc = Circle(self.centre, self.radius, color=self.colour, linewidth=0, zorder=order)
        axes.add_patch(disc)


@dataclass(frozen=True)
class Stroke:
    """A line with round corners and ends; `filled` closes it to an area."""

    points: tuple[Point, ...]
    width: float
    colour: str
    filled: bool = False

    def svg(self) -> Element:
        """As an element of SVG."""
        attributes = {
            "points": " ".join(f"{x:g},{y:g}" for x, y in self.points),
            "fill": self.colour if self.filled else "none",
            "stroke": self.colour,
            "stroke-width": f"{self.width:g}",
        }
        return Element("polygon" if self.filled else "polyline", attributes)

    def draw(self, axes: Axes, order: int) -> None:
        """With matplotlib, in front of what has a lower `order`."""
        width = self.width * POINTS_PER_UNIT
        if self.filled:
            area = Polygon(self.points, linewidth=width, color=self.colour, zorder=order)
            area.set_joinstyle("round")
            axes.add_patch(area)
            return
        x, y = zip(*self.points, strict=True)
        line = Line2D(x, y, linewidth=width, color=self.colour, zorder=order, snap=False)
        line.set_solid_joinstyle("round")
        line.set_solid_capstyle("round")
        axes.add_line(line)


Shape = Disc | Stroke


def _square(centre: Point, half: float) -> tuple[Point, ...]:
    x, y = centre
    return ((x - half, y - half), (x + half, y - half), (x + half, y + half), (x - half, y + half))


def _tendon(side: int, sag: float, spring: tuple[float, float], colour: str) -> list[Shape]:
    """A tendon between the pulleys; `side` -1 above, 1 below.

    `spring` says from which to which part of its length the spring reaches.
    """

    def at(part: float, aside: float = 0.0) -> Point:
        x = MOTOR[0] + part * (JOINT[0] - MOTOR[0])
        radius = MOTOR_RADIUS + part * (JOINT_RADIUS - MOTOR_RADIUS)
        y = MOTOR[1] + side * radius + 4 * sag * part * (1 - part) + aside
        return round(x, 2), round(y, 2)

    first, last = spring
    pitch = (last - first) / (2 * COILS)
    zigzag = [at(first + (i + 0.5) * pitch, COIL * (-1) ** i) for i in range(2 * COILS)]
    ropes = [[at(first * i / 6) for i in range(7)], [at(1 - (1 - last) * i / 6) for i in range(7)]]
    return [
        *(Stroke(tuple(rope), WIDTH, colour) for rope in ropes),
        Stroke((at(first), *zigzag, at(last)), WIDTH, colour),
    ]


def shapes() -> list[Shape]:
    """Everything on the icon, from back to front."""
    return [
        Stroke(_square((50.0, 50.0), 42.0), 16.0, FRAME, filled=True),
        Stroke(_square((50.0, 50.0), 42.0), 12.0, CARD, filled=True),
        Stroke(_square(MOTOR, 13.0), 5.0, HOUSING, filled=True),
        *_tendon(1, SAG, (0.32, 0.58), SLACK),
        *_tendon(-1, 0.0, (0.27, 0.69), TAUT),
        Disc(MOTOR, MOTOR_RADIUS - WIDTH / 2, METAL),
        Disc(JOINT, JOINT_RADIUS - WIDTH / 2, METAL),
        Stroke((JOINT, LINK_END), 10.0, METAL),
        Disc(MOTOR, 3.0, CARD),
        Disc(JOINT, 3.0, CARD),
    ]


def svg() -> bytes:
    """The icon as SVG."""
    round_strokes = {"stroke-linecap": "round", "stroke-linejoin": "round"}
    root = Element("svg", {"xmlns": SVG, "viewBox": "0 0 100 100", **round_strokes})
    root.extend(shape.svg() for shape in shapes())
    ElementTree.indent(root)
    content: bytes = ElementTree.tostring(root, "utf-8")
    return content + b"\n"


def flanges() -> dict[str, list[Shape]]:
    """Rotational flanges by file name: a disc for the motor's, a ring for the joint's."""
    disc = Disc((50.0, 50.0), 48.0, FRAME)
    return {"flange_a.png": [disc], "flange_b.png": [disc, Disc((50.0, 50.0), 34.0, CARD)]}


def png(listed: list[Shape], pixels: int) -> bytes:
    """Shapes as PNG, on a transparent ground."""
    figure = Figure(figsize=(pixels / DPI, pixels / DPI), dpi=DPI)
    axes = figure.add_axes((0, 0, 1, 1), xlim=(0, 100), ylim=(100, 0))
    axes.set_axis_off()
    for order, shape in enumerate(listed):
        shape.draw(axes, order)
    file = io.BytesIO()
    figure.savefig(file, format="png", transparent=True, metadata={"Software": None})
    return file.getvalue()


def files() -> dict[str, bytes]:
    """All pictures by file name."""
    drawn = {name: png(listed, FLANGE_PIXELS) for name, listed in flanges().items()}
    return {"icon.svg": svg(), "icon.png": png(shapes(), PIXELS), **drawn}


if __name__ == "__main__":
    for name, content in files().items():
        (FOLDER / name).write_bytes(content)
        print(FOLDER / name)
