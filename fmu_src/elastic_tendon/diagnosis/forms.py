"""The shapes that a learned term can take, each written as the text of an effect file.

The text is the only statement of a form's law: `columns` runs it on a recording to see what each
coefficient does, and whoever keeps the file gets the same law in model, FMU and fit.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.comparison.residuals import Array
from elastic_tendon.effects.base import Slot

# of the samples, at each end of a variable's range, for which the curve is not made finer
RARE = 0.005
# a spring keeps this share of its stiffness wherever a learned force softens it
STIFFNESS_KEPT = 0.5
# steepest that a learned angle map may be, rad per rad
STEEPEST_ANGLE = 0.25
# of the variables that curves go over
UNITS = {
    "position": "rad",
    "speed": "rad/s",
    "velocity": "rad/s",
    "motor_position": "rad",
    "elongation": "m",
    "tension": "N",
}
ANY = 1e5  # a bound that no machine reaches, N·m


@dataclass(frozen=True)
class Form:
    """Where a learned term acts and on what it depends.

    `variables` are told to users; `axes` names the properties of `Motion` over which the curves
    go, with so many `parts` of each range. `shapes` and `answer` are Python of the effect's
    equations: `over` gives the bumps of a variable, `until` their integrals, and `total` the sum
    of coefficients times shapes. `unit` is that of a coefficient; `reach` its bounds.
    """

    slot: Slot
    variables: tuple[str, ...]
    words: str
    law: str
    axes: tuple[str, ...]
    parts: tuple[int, ...]
    shapes: str
    answer: str
    unit: str
    reach: Callable[[Model, float], tuple[float, float]]
    sides: tuple[str, ...] = ("",)


def _free(_model: Model, _width: float) -> tuple[float, float]:
    return -ANY, ANY


def _opposing(_model: Model, _width: float) -> tuple[float, float]:
    return 0.0, ANY


def _share(_model: Model, _width: float) -> tuple[float, float]:
    return 0.0, 1.0


def _softening(model: Model, _width: float) -> tuple[float, float]:
    springs = model.transmission.upper_spring, model.transmission.lower_spring
    return -(1.0 - STIFFNESS_KEPT) * min(spring.stiffness for spring in springs), 1e3 * ANY


def _turning(_model: Model, width: float) -> tuple[float, float]:
    return -0.5 * STEEPEST_ANGLE * width, 0.5 * STEEPEST_ANGLE * width


_OPPOSES = "FrictionBounds(-total(p, shapes), total(p, shapes))"

FORMS = (
    Form(
        slot=Slot.JOINT_TORQUE,
        variables=("joint_position",),
        words="a torque on the joint that depends on its position",
        law="torque f(q)",
        axes=("position",),
        parts=(7,),
        shapes="over(at.position)",
        answer="Contribution(total(p, shapes))",
        unit="N.m",
        reach=_free,
    ),
    Form(
        slot=Slot.SPRING_LAW,
        variables=("elongation",),
        words="a force of each spring that depends on its elongation",
        law="added force of one spring f(e), f(0) = 0",
        axes=("elongation",),
        parts=(6,),
        shapes="until(at.elongation)",
        answer="Contribution(total(p, shapes))",
        unit="N/m",
        reach=_softening,
    ),
    Form(
        slot=Slot.DRY_FRICTION,
        variables=("joint_velocity",),
        words="a friction of the joint that depends on its speed",
        law="-f(|v|) sgn(v); at rest what balances the other torques, up to ±f(0)",
        axes=("speed",),
        parts=(6,),
        shapes="over(absolute(at.velocity))",
        answer=_OPPOSES,
        unit="N.m",
        reach=_opposing,
    ),
    Form(
        slot=Slot.DRY_FRICTION,
        variables=("joint_velocity",),
        words="a friction of the joint by its speed, other in each direction",
        law="-f(v) for v > 0, g(-v) for v < 0; at rest what balances the other torques",
        axes=("speed",),
        parts=(4,),
        shapes="over(absolute(at.velocity))",
        answer="FrictionBounds(-total(p, shapes), total(p, shapes, len(shapes)))",
        unit="N.m",
        reach=_opposing,
        sides=(" forwards", " backwards"),
    ),
    Form(
        slot=Slot.DRY_FRICTION,
        variables=("joint_position", "velocity_sign"),
        words="a friction of the joint that depends on its position",
        law="-f(q) sgn(v); at rest what balances the other torques, up to ±f(q)",
        axes=("position",),
        parts=(7,),
        shapes="over(at.position)",
        answer=_OPPOSES,
        unit="N.m",
        reach=_opposing,
    ),
    Form(
        slot=Slot.SPRING_LAW,
        variables=("elongation", "elongation_rate"),
        words="a damping of each spring that depends on its elongation",
        law="added force of one spring f(e) times the rate of e",
        axes=("elongation",),
        parts=(5,),
        shapes="over(at.elongation)",
        answer="Contribution(total(p, shapes) * at.rate)",
        unit="N.s/m",
        reach=_opposing,
    ),
    Form(
        slot=Slot.TENDON_LOSS,
        variables=("tension", "velocity_sign"),
        words="a friction of the tendons that depends on their tension",
        law="at the joint pulley each tension F loses f(F), f(0) = 0, against the motion",
        axes=("tension",),
        parts=(5,),
        shapes="[a + b for a, b in zip(until(at.upper_tension), until(at.lower_tension))]",
        answer="FrictionBounds(-at.radius * total(p, shapes), at.radius * total(p, shapes))",
        unit="1",
        reach=_share,
    ),
    Form(
        slot=Slot.ANGLE_MAP,
        variables=("motor_position",),
        words="an angle of the motor pulley that depends on the motor's position",
        law="pulley angle = θ + f(θ)",
        axes=("motor_position",),
        parts=(7,),
        shapes="over(at.motor_position)",
        answer="Contribution(at.motor_position + total(p, shapes))",
        unit="rad",
        reach=_turning,
    ),
    Form(
        slot=Slot.JOINT_SIGNAL,
        variables=("joint_position",),
        words="an error of the joint encoder that depends on the position",
        law="measured joint position = q + f(q)",
        axes=("position",),
        parts=(7,),
        shapes="over(at.value)",
        answer="Contribution(total(p, shapes))",
        unit="rad",
        reach=_turning,
    ),
    Form(
        slot=Slot.JOINT_TORQUE,
        variables=("joint_position", "joint_velocity"),
        words="a torque on the joint that depends on its position and velocity",
        law="torque f(q, v)",
        axes=("position", "velocity"),
        parts=(3, 2),
        shapes="[a * b for a in over(at.position) for b in over(at.velocity, 1)]",
        answer="Contribution(total(p, shapes))",
        unit="N.m",
        reach=_free,
    ),
)


@dataclass(frozen=True)
class Grid:
    """Evenly spaced centres of bumps over one variable, and the space between them."""

    centres: tuple[float, ...]
    width: float


def grid_over(values: Array, parts: int) -> Grid | None:
    """Centres of the bumps that make any smooth curve over these values; None if they are one.

    Parameters
    ----------
    values : (n,) array, any unit
    parts : int, of the range; there is a centre beyond each end
    """
    low, high = np.quantile(values, [RARE, 1.0 - RARE]).tolist()
    if not high - low > 1e-9 * max(abs(low), abs(high)):
        return None
    # as short as it can be written without being noticed
    width = float(f"{(high - low) / parts:.4g}")
    centres = tuple(float(f"{low + i * width:.6g}") for i in range(-1, parts + 2))
    return Grid(centres, width)


@dataclass(frozen=True)
class Curve:
    """A form with the places of its coefficients: k of them."""

    form: Form
    grids: tuple[Grid, ...]

    @property
    def count(self) -> int:
        """Number k of coefficients."""
        each = int(np.prod([len(grid.centres) for grid in self.grids]))
        return each * len(self.form.sides)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the coefficients."""
        return tuple(f"c{i + 1}" for i in range(self.count))

    def bounds(self, model: Model) -> tuple[float, float]:
        """Least and largest value that physics allows a coefficient."""
        return self.form.reach(model, self.grids[0].width)
