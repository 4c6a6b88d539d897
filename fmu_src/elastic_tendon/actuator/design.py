"""Design and dimensioning of the actuator, (26) to (39) of the paper.

Symbols as in `transmission`; J, b inertia and damping of the link.
"""

from collections.abc import Sequence
from dataclasses import Field, asdict, dataclass, field, fields, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from elastic_tendon.actuator import transmission as tendons
from elastic_tendon.actuator.interfaces import WITH_SPRINGS
from elastic_tendon.actuator.motion_kind import MotionKind
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.quantity import unit_text
from elastic_tendon.actuator.transmission import FloatArray
from elastic_tendon.errors import ModelError
from elastic_tendon.result import Result, plain

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

CURVE_POINTS = 201  # of a characteristic curve, besides its kinks
FAMILY_SHARES = (0.25, 0.5, 0.75, 1.0)  # pretensions of a default family, in shares of (30)
SAME_PRETENSION = 0.1  # of (30): members of a family closer than that look alike


@dataclass(frozen=True)
class DesignRow:
    """One line of the design table."""

    name: str
    symbol: str
    equation: str
    value: float
    unit: str


def _row(name: str, symbol: str, equation: str, unit: str) -> Any:
    return field(metadata={"name": name, "symbol": symbol, "equation": equation, "unit": unit})


@dataclass(frozen=True, repr=False)
class DesignTable(Result):
    """What the numbers of an actuator come to; SI, deflections in rad.

    "Positive" and "negative" are the signs of the deflection δ = q − jθ; at a negative one
    the upper tendon pulls (state I), at a positive one the lower (state II). `model` is the
    actuator's.
    """

    model: Model
    negative_slack_boundary: float = _row(
        "slack boundary, lower tendon", "-F_p/(R k_2)", "(14)", "rad"
    )
    positive_slack_boundary: float = _row(
        "slack boundary, upper tendon", "F_p/(R k_1)", "(14)", "rad"
    )
    negative_max_deflection: float = _row(
        "largest negative deflection", "-l_max,1/R + F_p/(k_1 R)", "(16) corrected", "rad"
    )
    positive_max_deflection: float = _row(
        "largest positive deflection", "l_max,2/R - F_p/(k_2 R)", "(16) corrected", "rad"
    )
    stiffness_state_1: float = _row("stiffness, lower tendon slack", "R^2 k_1", "(19)", "N.m/rad")
    stiffness_state_2: float = _row("stiffness, upper tendon slack", "R^2 k_2", "(23)", "N.m/rad")
    stiffness_state_3: float = _row("stiffness, both taut", "R^2 (k_1 + k_2)", "(25)", "N.m/rad")
    damping_state_1: float = _row("damping, lower tendon slack", "R^2 d_1", "(20)", "N.m.s/rad")
    damping_state_2: float = _row("damping, upper tendon slack", "R^2 d_2", "(23)", "N.m.s/rad")
    damping_state_3: float = _row("damping, both taut", "R^2 (d_1 + d_2)", "(25)", "N.m.s/rad")
    largest_pretension: float = _row("largest pretension", "min(l_max,i k_i)", "(27)", "N")
    recommended_pretension: float = _row(
        "recommended largest pretension", "min l_max,i / (1/k_1 + 1/k_2)", "(30), (31)", "N"
    )
    upper_largest_force: float = _row("largest force, upper spring", "l_max,1 k_1", "(32)", "N")
    lower_largest_force: float = _row("largest force, lower spring", "l_max,2 k_2", "(32)", "N")
    negative_max_torque: float = _row(
        "torque at the largest negative deflection", "R (F_1 - F_2)", "(7), (16)", "N.m"
    )
    positive_max_torque: float = _row(
        "torque at the largest positive deflection", "R (F_1 - F_2)", "(7), (16)", "N.m"
    )
    effective_link_mass: float = _row("effective link mass", "J/R^2", "section II", "kg")
    frequency_state_1: float = _row(
        "natural frequency, lower tendon slack", "sqrt(R^2 k_1/J)", "(19)", "rad/s"
    )
    frequency_state_2: float = _row(
        "natural frequency, upper tendon slack", "sqrt(R^2 k_2/J)", "(23)", "rad/s"
    )
    frequency_state_3: float = _row(
        "natural frequency, both taut", "sqrt(R^2 (k_1 + k_2)/J)", "(25)", "rad/s"
    )

    def summary(self) -> str:
        """Every figure with its unit, a line each."""
        return "\n".join(
            f"{row.name:40} {row.value:11.5g} {unit_text(row.unit)}" for row in self.rows().values()
        )

    def to_dataframe(self) -> "pd.DataFrame":
        """Every figure with its symbol, equation and unit, a row each."""
        import pandas as pd

        return pd.DataFrame([asdict(row) for row in self.rows().values()])

    def to_dict(self) -> dict[str, Any]:
        """Every figure by its name in Python, SI."""
        return {figure.name: getattr(self, figure.name) for figure in _figures()}

    def plot(self) -> "Figure":
        """Draw the characteristic curves over pretension."""
        from elastic_tendon.reports.figures import characteristic_curves
        from elastic_tendon.reports.worded import worded_figure

        return worded_figure(characteristic_curves(self.model), self.model.motion)

    def rows(self) -> dict[str, DesignRow]:
        """Table for printing: name of a field -> its row, in their order."""
        return {figure.name: self._moving(figure) for figure in _figures()}

    def _moving(self, figure: "Field[Any]") -> DesignRow:
        """A figure in the words and units of the machine's motion."""
        motion = self.model.motion
        row = DesignRow(value=getattr(self, figure.name), **figure.metadata)
        # of velocities there is none
        unit = motion.frequency_unit if row.unit == "rad/s" else motion.unit(row.unit)
        return replace(row, name=motion.words(row.name), unit=unit)


def _figures() -> "list[Field[Any]]":
    return [figure for figure in fields(DesignTable) if figure.metadata]


def design(model: Model) -> DesignTable:
    """Evaluate (26) to (34) and the limits of section II for a model.

    With a pretension above (30) both tendons are still taut at a limit, and the largest
    torque there is below R k_i l_max,i; the table holds the torque that is reached.

    Parameters
    ----------
    model : Model

    Returns
    -------
    DesignTable; SI units, with rad

    Raises
    ------
    ModelError : the model has no springs, or no link
    """
    model.check_interface("a design", WITH_SPRINGS)
    if model.link.absent:
        raise ModelError(model.name, ["a design needs a link; give the model a table [link]"])
    transmission = model.transmission
    upper, lower = transmission.upper_spring, transmission.lower_spring
    square = transmission.joint_pulley_radius**2
    boundaries = tendons.slack_boundaries(transmission)
    limits = tendons.deflection_limits(transmission)
    torques = tendons.characteristic_torque(limits, transmission)
    stiffness_state_1 = square * upper.combined_stiffness
    stiffness_state_2 = square * lower.combined_stiffness
    damping_state_1 = square * upper.combined_damping
    damping_state_2 = square * lower.combined_damping

    def frequency(stiffness: float) -> float:
        return float(np.sqrt(stiffness / model.link.inertia))

    return DesignTable(
        model=model,
        negative_slack_boundary=boundaries[0],
        positive_slack_boundary=boundaries[1],
        negative_max_deflection=limits[0],
        positive_max_deflection=limits[1],
        stiffness_state_1=stiffness_state_1,
        stiffness_state_2=stiffness_state_2,
        stiffness_state_3=stiffness_state_1 + stiffness_state_2,
        damping_state_1=damping_state_1,
        damping_state_2=damping_state_2,
        damping_state_3=damping_state_1 + damping_state_2,
        largest_pretension=transmission.largest_pretension,
        recommended_pretension=transmission.recommended_pretension,
        upper_largest_force=upper.largest_force,
        lower_largest_force=lower.largest_force,
        negative_max_torque=float(torques[0]),
        positive_max_torque=float(torques[1]),
        effective_link_mass=model.link.inertia / square,
        frequency_state_1=frequency(stiffness_state_1),
        frequency_state_2=frequency(stiffness_state_2),
        frequency_state_3=frequency(stiffness_state_1 + stiffness_state_2),
    )


@dataclass(frozen=True, repr=False)
class CharacteristicCurve(Result):
    """Static characteristic at one pretension (N), from one deflection limit to the other.

    `deflection` (n,) rad, `torque` (n,) N·m on the joint, `stiffness` (n,) N·m/rad.
    `slack_boundaries` (2,) rad holds those of (14), `boundary_torques` (2,) N·m the torque
    there; outside the limits, which happens above (30), they are NaN. `motion` : whether the
    machine turns or slides; then metres and newtons stand for rad and N·m.
    """

    pretension: float
    deflection: FloatArray
    torque: FloatArray
    stiffness: FloatArray
    slack_boundaries: FloatArray
    boundary_torques: FloatArray
    motion: MotionKind = MotionKind.ROTARY

    def summary(self) -> str:
        """Pretension, and the ranges of deflection, torque and stiffness."""
        columns = ("deflection", "rad"), ("torque", "N·m"), ("stiffness", "N·m/rad")
        lines = [f"Characteristic curve at a pretension of {self.pretension:.4g} N"]
        words = self.motion.words
        for name, unit in columns:
            values = getattr(self, name)
            least, most = f"{values.min():11.4g}", f"{values.max():11.4g}"
            lines.append(f"  {words(name):10} {least} to {most} {words(unit)}")
        return "\n".join(lines)

    def to_dataframe(self) -> "pd.DataFrame":
        """Torque and stiffness, SI; the index is the deflection, rad."""
        import pandas as pd

        index = pd.Index(self.deflection, name="deflection")
        return pd.DataFrame({"torque": self.torque, "stiffness": self.stiffness}, index=index)

    def to_dict(self) -> dict[str, Any]:
        """All of it, an array as a list, SI."""
        content: dict[str, Any] = plain(asdict(self))
        return content

    def plot(self) -> "Figure":
        """Draw torque and stiffness over deflection."""
        from elastic_tendon.reports.figures import curves_figure
        from elastic_tendon.reports.worded import worded_figure

        return worded_figure(curves_figure([self], "characteristic curve"), self.motion)


def characteristic_curves(
    model: Model, pretensions: Sequence[float] | None = None
) -> tuple[CharacteristicCurve, ...]:
    """Characteristic curves of the paper's springs over several pretensions (Figs. 7 to 9).

    Effects in the model do not take part.

    Parameters
    ----------
    model : Model
    pretensions : sequence of float, N; None: quarters of the recommended limit (30) and the
        model's own pretension

    Returns
    -------
    tuple of CharacteristicCurve, by rising pretension

    Raises
    ------
    ModelError
        for a pretension above (27), or a model without springs
    """
    model.check_interface("a characteristic curve", WITH_SPRINGS)
    chosen = default_pretensions(model) if pretensions is None else pretensions
    return tuple(_curve(model, pretension) for pretension in sorted(set(chosen)))


def default_pretensions(model: Model) -> tuple[float, ...]:
    """Own pretension of the model and quarters of (30) that differ visibly from it, N."""
    recommended = model.transmission.recommended_pretension
    own = model.transmission.pretension_force
    family = (share * recommended for share in FAMILY_SHARES)
    others = (force for force in family if abs(force - own) > SAME_PRETENSION * recommended)
    return tuple(sorted((own, *others)))


def _curve(model: Model, pretension: float) -> CharacteristicCurve:
    changed = model.with_values({"transmission.pretension_force": pretension})
    transmission = changed.transmission
    low, high = tendons.deflection_limits(transmission)
    boundaries = np.array(tendons.slack_boundaries(transmission))
    boundaries[(boundaries < low) | (boundaries > high)] = np.nan

    # the kinks and their neighbours are points of the curve, so its jumps stay upright
    kinks = boundaries[np.isfinite(boundaries)]
    sides = (np.nextafter(kinks, -np.inf), kinks, np.nextafter(kinks, np.inf))
    points = np.unique(np.concatenate([np.linspace(low, high, CURVE_POINTS), *sides]))
    deflection = points[(points >= low) & (points <= high)]
    return CharacteristicCurve(
        pretension=pretension,
        deflection=deflection,
        torque=tendons.characteristic_torque(deflection, transmission),
        stiffness=tendons.characteristic_stiffness(deflection, transmission),
        slack_boundaries=boundaries,
        boundary_torques=tendons.characteristic_torque(boundaries, transmission),
        motion=model.motion,
    )
