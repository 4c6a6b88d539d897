"""The tables of model.toml that every model has: springs, transmission, link, motor.

Each quantity is declared where its field stands, with unit, bounds, meaning and default
uncertainty; everything said of it elsewhere is derived from that.
"""

import math

from pydantic import BaseModel, Field, ValidationInfo, field_validator
from pydantic_core import PydanticCustomError

from elastic_tendon.actuator.interfaces import InterfaceKind
from elastic_tendon.actuator.quantity import STRICT, declare


class Spring(BaseModel):
    """The springs of one side: `parallel` equal springs side by side."""

    model_config = STRICT

    stiffness: float = declare("N/m", "stiffness of one spring", (20.0, 1e8), 1e4, uncertainty=0.1)
    parallel: int = declare("1", "number of equal springs side by side", (1, 100), 1, default=1)
    damping: float = declare(
        *("N.s/m", "viscous damping of one spring", (0.0, 1e6), 10.0),
        uncertainty=1.0,
        default=0.0,
        tunable=True,
    )
    max_deflection: float = declare(
        "m", "largest elongation from the rest length that the spring bears", (1e-4, 1.0), 0.01
    )
    mass: float = declare(
        "kg",
        "mass of one spring, only for a warning: the springs of the paper are massless",
        (0.0, 100.0),
        0.05,
        default=0.0,
        run_time=False,
    )

    @property
    def combined_stiffness(self) -> float:
        """k_i of all parallel springs, (33) and (34), N/m."""
        return self.parallel * self.stiffness

    @property
    def combined_damping(self) -> float:
        """d_i of all parallel springs, N·s/m; dampers side by side add as stiffnesses do."""
        return self.parallel * self.damping

    @property
    def largest_force(self) -> float:
        """F_max,i = l_max,i k_i, (32), N."""
        return self.max_deflection * self.combined_stiffness


class Transmission(BaseModel):
    """Pulleys, springs and pretension (paper, Fig. 2)."""

    model_config = STRICT

    joint_pulley_radius: float = declare("m", "radius R of the joint pulley", (5e-4, 2.0), 0.03)
    motor_pulley_radius: float = declare(
        "m",
        "radius r of the motor pulley; equal to R where the motor position counts at the joint",
        (5e-4, 2.0),
        0.03,
    )
    upper_spring: Spring
    lower_spring: Spring
    # after the springs: its validator needs them
    pretension_force: float = declare(
        "N", "force F_p in both tendons at rest", (0.0, 1e6), 50.0, uncertainty=0.3, tunable=True
    )
    slack: int = declare(
        *("1", "1: tendons only pull and can be slack; 0: their springs push too", (0, 1), 1),
        default=1,
    )

    @field_validator("pretension_force")
    @classmethod
    def _borne_by_springs(cls, value: float, info: ValidationInfo) -> float:
        springs = [
            info.data[side] for side in ("upper_spring", "lower_spring") if side in info.data
        ]
        limit = min((spring.largest_force for spring in springs), default=math.inf)
        if value > limit:
            raise PydanticCustomError(
                "pretension",
                "it is above the {limit} N that the springs bear, min(l_max,i k_i), paper (27)",
                {"limit": f"{limit:g}"},
            )
        return value

    @property
    def absent(self) -> bool:
        """Whether it is `NO_SPRINGS`, of a model without this table."""
        return self.upper_spring.stiffness == 0.0

    @property
    def motor_share(self) -> float:
        """Joint rotation for a rotation of the motor without load, 1/n_t of (10)."""
        return self.motor_pulley_radius / self.joint_pulley_radius

    @property
    def largest_pretension(self) -> float:
        """Pretension that stretches a spring to its limit at rest, (26) and (27), N."""
        return min(self.upper_spring.largest_force, self.lower_spring.largest_force)

    @property
    def recommended_pretension(self) -> float:
        """Pretension with the widest range of both tendons taut, (30), N."""
        series = 1 / (
            1 / self.upper_spring.combined_stiffness + 1 / self.lower_spring.combined_stiffness
        )
        return series * min(self.upper_spring.max_deflection, self.lower_spring.max_deflection)


_NO_SPRING = Spring.model_construct(stiffness=0.0, max_deflection=math.inf)
# of a model without [transmission]: no torque at any deflection, and nothing is ever slack
NO_SPRINGS = Transmission.model_construct(
    joint_pulley_radius=1.0,
    motor_pulley_radius=1.0,
    upper_spring=_NO_SPRING,
    lower_spring=_NO_SPRING,
    pretension_force=0.0,
    slack=0,
)


class Link(BaseModel):
    """What the joint pulley moves."""

    model_config = STRICT

    inertia: float = declare(
        *("kg.m2", "moment of inertia J about the joint", (1e-9, 1e4), 0.03),
        uncertainty=0.3,
        tunable=True,
    )
    damping: float = declare(
        *("N.m.s/rad", "viscous damping b of the joint", (0.0, 1e4), 0.1),
        uncertainty=1.0,
        default=0.0,
        tunable=True,
    )

    @property
    def absent(self) -> bool:
        """Whether it is `NO_LINK`, of a model without this table."""
        return math.isnan(self.inertia)


# of a model without [link], whose joint another simulator moves
NO_LINK = Link.model_construct(inertia=math.nan, damping=0.0)


class Motor(BaseModel):
    """Rotor and gear at the motor pulley: what a motor torque moves."""

    model_config = STRICT

    inertia: float = declare(
        *("kg.m2", "moment of inertia of rotor and gear at the motor pulley", (1e-10, 1e3), 1e-3),
        uncertainty=0.3,
        tunable=True,
    )
    damping: float = declare(
        *("N.m.s/rad", "viscous damping at the motor pulley", (0.0, 1e4), 1e-2),
        uncertainty=1.0,
        default=0.0,
        tunable=True,
    )
    friction_torque: float = declare(
        *("N.m", "dry friction at the motor pulley, only for designs", (0.0, 1e4), 0.1),
        default=0.0,
        run_time=False,
    )


class InterfaceSection(BaseModel):
    """What is given and what is computed."""

    model_config = STRICT

    kind: InterfaceKind = Field(InterfaceKind.POSITION, strict=False)  # a text in model.toml
