"""What a linearisation says: the linear model, where it lies, and how far it holds."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING, Any

import control
import numpy as np
from numpy.typing import NDArray

from elastic_tendon.actuator.motion_kind import MotionKind
from elastic_tendon.actuator.transmission import SlackState
from elastic_tendon.result import Result

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]


class Drive(Enum):
    """What moves the motor; the value is its name for users.

    SOURCE: position and velocity are inputs of their own, as of the FMU; the velocity is used by
    spring damping and effects that need the rate, and whoever drives both keeps them consistent.
    POSITION: the position alone, the velocity is its derivative. VELOCITY: the velocity alone, the
    position is a state. TORQUE: a torque drives the rotor of [motor], whose position and velocity
    are states.
    """

    SOURCE = "source"
    POSITION = "position"
    VELOCITY = "velocity"
    TORQUE = "torque"


@dataclass(frozen=True)
class OperatingPoint:
    """Where to linearise: an equilibrium, by what is given of it; SI units.

    Two of `load_torque` (N·m), `motor_position` (rad at the motor pulley), `joint_position` (rad)
    and `deflection` (rad) settle it, but not load and deflection. Of what is missing, the load is
    0 first, then the motor's position; with `deflection` alone the motor is at 0. Nothing given:
    see `linearise`. `joint_velocity` (rad/s) other than 0 is steady motion: motor and joint move
    together, so that friction is that of sliding at this velocity.
    """

    load_torque: float | None = None
    motor_position: float | None = None
    joint_position: float | None = None
    deflection: float | None = None
    joint_velocity: float = 0.0


@dataclass(frozen=True)
class Equilibrium:
    """An operating point that was solved for; values by name, SI units.

    All states, inputs and outputs of the linear model are there, and those of the actuator
    (motor_position, motor_velocity, load_torque) whatever drives it. `slack_state` and `modes`
    (slack, engaged, sliding...) are those active there.
    """

    states: Mapping[str, float]
    inputs: Mapping[str, float]
    outputs: Mapping[str, float]
    slack_state: SlackState
    modes: Mapping[str, int]


@dataclass(frozen=True)
class Boundary:
    """Where modes switch as the joint is deflected with the motor held.

    At rest: a step of load overshoots, so compare the deflection of the linear model's own response
    with `deflection_margin`, not its load with `torque_margin`.

    `switches` holds the modes that change, with their values beyond; `slack_state` is that
    beyond. `deflection` (rad) and `load_torque` (N·m) are those on the boundary,
    `deflection_margin` and `torque_margin` how far they are from the operating point, signed.
    """

    switches: Mapping[str, int]
    slack_state: SlackState
    deflection: float
    load_torque: float
    deflection_margin: float
    torque_margin: float


@dataclass(frozen=True)
class Validity:
    """Where a linear model lies and holds.

    Attributes
    ----------
    slack_state, modes : for which it was made
    active : whether these are the modes at the operating point
    operating_point : the equilibrium, with the modes that are active there
    boundaries : the next ones towards negative and positive deflection, by rising deflection; also
        one at no distance where the operating point lies on it, and where the joint sticks
        the loads, deflection held, that set it in motion
    """

    slack_state: SlackState
    modes: Mapping[str, int]
    active: bool
    operating_point: Equilibrium
    boundaries: tuple[Boundary, ...]

    @property
    def on_boundary(self) -> bool:
        """Whether the operating point lies on a switching boundary."""
        return any(
            boundary.deflection_margin == 0.0 and boundary.torque_margin == 0.0
            for boundary in self.boundaries
        )


class LinearModel(Result, control.StateSpace):  # type: ignore[misc]  # control has no types
    """A `control.StateSpace` of deviations from an operating point, that knows where it holds.

    `validity` says where. On a switching boundary `sides` are the models of both sides, towards
    negative and towards positive deflection; elsewhere it is empty. `drive` says what moves the
    motor, `actuator` is the name of the actuator, `motion` says whether it turns or slides, `whole`
    is the model with all inputs and outputs of which this one has some. Systems made from this one
    with operators of control are plain `control.StateSpace`.
    """

    def __init__(
        self,
        matrices: tuple[Array, Array, Array, Array],
        validity: Validity,
        drive: Drive,
        sides: tuple["LinearModel", ...] = (),
        *,
        actuator: str = "",
        motion: MotionKind = MotionKind.ROTARY,
        whole: "LinearModel | None" = None,
        **names: Any,
    ) -> None:
        super().__init__(*matrices, **names)
        self.validity = validity
        self.drive = drive
        self.sides = sides
        self.actuator = actuator
        self.motion = motion
        self.whole = whole or self

    def summary(self) -> str:
        """Slack state, operating point, signals and poles."""
        validity, at = self.validity, self.validity.operating_point
        poles = sorted(self.poles(), key=lambda pole: (abs(pole), pole.imag))
        listed = ", ".join(f"{pole:.4g}" for pole in poles)
        unit, words, load = self.motion.frequency_unit, self.motion.words, at.inputs["load_torque"]
        return "\n".join(
            (
                f"Linear model of {self.actuator}, {validity.slack_state.label}",
                words(f"  deflection   {at.outputs['deflection']:.4g} rad"),
                f"  {words('load torque'):12} {words(f'{load:.4g} N·m')}",
                f"  active there {'yes' if validity.active else 'no'}",
                f"  states       {', '.join(self.state_labels)}",
                f"  inputs       {', '.join(self.input_labels)}",
                f"  outputs      {', '.join(self.output_labels)}",
                f"  poles        {f'{listed} {unit}' if listed else 'none'}",
                *self._felt_at_joint(),
            )
        )

    def _felt_at_joint(self) -> list[str]:
        """How stiff the actuator is to a joint whose position is given, motor held; one line."""
        if "joint_position" not in self.input_labels or "joint_torque" not in self.output_labels:
            return []
        place = self.output_labels.index("joint_torque"), self.input_labels.index("joint_position")
        stiffness = 0.0 - float(np.real(np.atleast_2d(self.dcgain())[place]))
        line = f"  stiffness    {stiffness:.4g} N·m/rad, of slow motion of the joint"
        return [self.motion.words(line)]

    def to_dict(self) -> dict[str, Any]:
        """As of the contract ``elastic-tendon/linear/1``."""
        from elastic_tendon.linear.linear_json import linear_json

        names = {"inputs": self.input_labels, "outputs": self.output_labels}
        return linear_json(self.actuator, [self.whole], **names)

    def plot(self) -> "Figure":
        """Draw frequency responses, poles and zeros."""
        from elastic_tendon.reports.linear_figures import linear_figure
        from elastic_tendon.reports.worded import worded_figure

        chosen = None if self.whole is self else (self.input_labels[0], self.output_labels[0])
        return worded_figure(linear_figure(self.actuator, [self.whole], chosen), self.motion)
