"""Machines in the words of MuJoCo: hinges, slides and fixed tendons that only pull.

A machine is a `Base`, which the product's model describes too, and a `Hidden` part, which the model
that is given to the tool lacks. Tendons are springs of MuJoCo with a dead band: no force up to the
length at which they are taut. The joint is the hinge ``joint``, the motor the hinge ``motor``.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any
from zlib import crc32

import numpy as np

Tree = dict[str, Any]
Answer = frozenset[str]

STEP = 5e-5  # s, of the engine
HEAVY = 10.0  # kg m², of the motor, whose place is written before every step
LOOSE = -1000.0  # m, start of a dead band that no motion reaches
NOTHING: Answer = frozenset()
UNBOUND = 3.0  # rad, where a stop is never met
# reaches its reference within two steps, and gives way by a thousandth of what pushes it
STIFF = f'"{2 * STEP:g} 1"', '"0.9999 0.9999 0.001"'


@dataclass(frozen=True)
class Base:
    """Numbers of the actuator without anything hidden; of one spring, two of them side by side."""

    joint_radius: float = 0.03  # m
    motor_radius: float = 0.03  # m
    pretension: float = 80.0  # N
    upper: float = 11580.0  # N/m
    lower: float = 11580.0  # N/m
    max_deflection: float = 0.015  # m
    inertia: float = 0.03  # kg m²
    damping: float = 0.16  # N m s/rad

    PARALLEL = 2

    @property
    def sides(self) -> tuple[float, float]:
        """Stiffness of all upper and of all lower springs, N/m."""
        return self.PARALLEL * self.upper, self.PARALLEL * self.lower

    @property
    def stiffness(self) -> float:
        """Of the joint with both tendons taut, N·m/rad."""
        return self.joint_radius**2 * sum(self.sides)

    @property
    def torque(self) -> float:
        """What the weaker side bears at the joint, N·m."""
        return self.joint_radius * min(self.sides) * self.max_deflection

    @property
    def ratio(self) -> float:
        """Turn of the joint for one of the motor, nothing pulling."""
        return self.motor_radius / self.joint_radius

    @property
    def slack_deflection(self) -> float:
        """Smallest deflection at which either tendon is slack, rad."""
        return self.pretension / (self.joint_radius * max(self.sides))

    @property
    def largest_deflection(self) -> float:
        """What the springs bear to both sides, rad."""
        spare = self.max_deflection - self.pretension / min(self.sides)
        return spare / self.joint_radius

    def tree(self) -> Tree:
        """The content of a model.toml."""
        springs = [
            {"stiffness": one, "parallel": self.PARALLEL, "max_deflection": self.max_deflection}
            for one in (self.upper, self.lower)
        ]
        return {
            "name": "played_by_mujoco",
            "transmission": {
                "joint_pulley_radius": self.joint_radius,
                "motor_pulley_radius": self.motor_radius,
                "pretension_force": self.pretension,
                "upper_spring": springs[0],
                "lower_spring": springs[1],
            },
            "link": {"inertia": self.inertia, "damping": self.damping},
        }


@dataclass(frozen=True)
class Cord:
    """A fixed tendon: what each joint contributes to its length (m per rad or m), and its spring.

    It pulls where its length exceeds `taut` (m).
    """

    name: str
    arms: Mapping[str, float]
    stiffness: float = 0.0  # N/m
    taut: float = 0.0
    more: str = ""  # attributes

    @property
    def mjcf(self) -> str:
        """The element."""
        arms = "".join(f'<joint joint="{j}" coef="{arm!r}"/>' for j, arm in self.arms.items())
        spring = f'stiffness="{self.stiffness!r}" springlength="{LOOSE:g} {self.taut!r}"'
        return f'<fixed name="{self.name}" {spring} {self.more}>{arms}</fixed>'


def tendons(base: Base, motor: str = "motor") -> tuple[Cord, Cord]:
    """The upper and the lower tendon from the pulley on a joint `motor` to the link."""
    r, R = base.motor_radius, base.joint_radius
    upper, lower = base.sides
    return (
        Cord("upper", {motor: r, "joint": -R}, upper, -base.pretension / upper),
        Cord("lower", {motor: -r, "joint": R}, lower, -base.pretension / lower),
    )


@dataclass(frozen=True)
class Hidden:
    """What a machine has beside its base.

    `joint` : attributes of the joint's hinge. `link` : inside the link's body, None for a link
    that is balanced. `bodies` : beside it. `cords` : all tendons, None for the two of the base.
    `option` : attributes of the engine's options. `delay` (s) and `offset` (rad) of the joint's
    encoder. `push` : torque on the joint that nobody records, N·m. `stop` : where one begins, rad;
    who never comes there cannot know of it. `effects` : the same in the
    product's numbers, None where no law of the catalogue is it. `accepted` : right answers.
    `unknown` : "unexplained" is right too. `most_error` : of a right answer, in units of the noise.
    """

    joint: str = ""
    link: str | None = None
    bodies: str = ""
    cords: tuple[Cord, ...] | None = None
    option: str = ""
    delay: float = 0.0
    offset: float = 0.0
    push: float = 0.0
    stop: float = math.inf
    effects: Tree | None = field(default_factory=dict)
    accepted: frozenset[Answer] = frozenset({NOTHING})
    unknown: bool = False
    most_error: float = 1.1


@dataclass(frozen=True)
class Machine:
    """A machine that the engine can play; `true` is the base that a right model has."""

    name: str
    base: Base
    hidden: Hidden
    true: Base

    @property
    def bare(self) -> "Machine":
        """The same without what is hidden."""
        return Machine(self.name, self.base, Hidden(), self.base)

    @property
    def mjcf(self) -> str:
        """The whole model."""
        base, hidden = self.base, self.hidden
        inertia = f"{base.inertia!r} " * 3
        link = hidden.link or f'<inertial pos="0 0 0" mass="1" diaginertia="{inertia}"/>'
        cords = hidden.cords or tendons(base)
        return f"""
<mujoco>
  <compiler angle="radian" autolimits="true"/>
  <option timestep="{STEP}" integrator="implicitfast" gravity="0 0 -9.81" tolerance="1e-15"
    {hidden.option}><flag contact="disable" refsafe="disable"/></option>
  <worldbody>
    <body name="motor">
      <joint name="motor" type="hinge" axis="0 1 0" armature="{HEAVY}"/>
      <inertial pos="0 0 0" mass="0.001" diaginertia="1e-6 1e-6 1e-6"/>
    </body>
    <body name="link">
      <joint name="joint" type="hinge" axis="0 1 0" damping="{base.damping!r}" {hidden.joint}/>
      {link}
    </body>
    {hidden.bodies}
  </worldbody>
  <tendon>{"".join(one.mjcf for one in cords)}</tendon>
</mujoco>"""


def answers(*sets: tuple[str, ...]) -> frozenset[Answer]:
    """Right answers."""
    return frozenset(frozenset(one) for one in sets)


# ---- parts that hide -----------------------------------------------------------------------------


def dry_hinge(torque: float) -> str:
    """Attributes of a hinge with dry friction, N·m."""
    return f'frictionloss="{torque!r}" solreffriction={STIFF[0]} solimpfriction={STIFF[1]}'


def weight_of(base: Base, share: float) -> tuple[float, float, float]:
    """Mass (kg), distance (m) and angle (rad) of an eccentric link of the base's inertia."""
    distance = 0.12
    return share * base.torque / (9.81 * distance), distance, 0.7


def eccentric_link(base: Base, share: float) -> str:
    """A link whose weight turns it with up to a share of the largest torque."""
    mass, distance, angle = weight_of(base, share)
    # positive turns about y carry what hangs (-z) towards -x
    x, z = -distance * math.sin(angle), -distance * math.cos(angle)
    own = base.inertia - mass * distance**2
    return f'<inertial pos="{x!r} 0 {z!r}" mass="{mass!r}" diaginertia="{own!r} {own!r} {own!r}"/>'


def gravity(base: Base, share: float) -> Tree:
    """The same in the product's numbers."""
    mass, distance, angle = weight_of(base, share)
    return {"gravity_load": {"torque": mass * 9.81 * distance, "angle": angle}}


def soft_stop(base: Base, upper: float) -> str:
    """Attributes of a hinge with an elastic stop.

    With next to no impedance MuJoCo's limit is a spring and a damper, counted per inertia.
    """
    stop = stop_numbers(base, upper)
    spring, damper = stop["stiffness"] / base.inertia, stop["damping"] / base.inertia
    return (
        f'range="{-UNBOUND} {upper!r}" solreflimit="{-spring!r} {-damper!r}" '
        'solimplimit="0.0001 0.0001 0.001"'
    )


def stop_numbers(base: Base, upper: float) -> dict[str, float]:
    """The same in the product's numbers."""
    damping = 0.4 * math.sqrt(base.stiffness * base.inertia)
    return {
        "lower": -UNBOUND, "upper": upper, "stiffness": 12.0 * base.stiffness, "damping": damping,
    }  # fmt: skip


# ---- machines ------------------------------------------------------------------------------------

Make = Callable[[Base], Hidden]


def nothing(_base: Base) -> Hidden:
    """Nothing hides; the numbers alone are wrong."""
    return Hidden()


def armature(base: Base) -> Hidden:
    """A rotor that turns with the joint: more inertia, so a wrong number."""
    return Hidden(joint=f'armature="{ROTOR * base.inertia!r}"')


ROTOR = 0.3  # of the link's inertia


def dry_joint(base: Base) -> Hidden:
    """Dry friction of the joint; a Stribeck curve of equal levels is the same."""
    torque = 0.035 * base.torque
    return Hidden(
        joint=dry_hinge(torque),
        effects={"coulomb_friction": {"torque": torque}},
        accepted=answers(("coulomb_friction",), ("stribeck_friction",)),
    )


def eccentric(base: Base) -> Hidden:
    """The weight of the link."""
    return Hidden(
        link=eccentric_link(base, 0.12),
        effects=gravity(base, 0.12),
        accepted=answers(("gravity_load",)),
    )


def stopped(base: Base) -> Hidden:
    """A rubber stop."""
    upper = 0.55
    return Hidden(
        joint=soft_stop(base, upper),
        stop=upper,
        effects={"joint_stop": stop_numbers(base, upper)},
        accepted=answers(("joint_stop",)),
    )


def hard_stop(_base: Base) -> Hidden:
    """A stop by MuJoCo's own law: it slows what comes, whatever pushes."""
    return Hidden(
        joint=f'range="{-UNBOUND} 0.5" solreflimit="0.004 1" solimplimit="0.95 0.99 0.001"',
        stop=0.5,
        effects=None,
        accepted=answers(("joint_stop",)),
        unknown=True,
        most_error=2.0,
    )


def late(_base: Base) -> Hidden:
    """The joint's encoder is read late."""
    return Hidden(
        delay=0.0042,
        effects={"measurement_delay": {"delay": 0.0042}},
        accepted=answers(("measurement_delay",)),
    )


def shifted(_base: Base) -> Hidden:
    """The joint's encoder is mounted turned; only an offset of the motor's could be the same."""
    return Hidden(
        offset=0.013,
        effects={"joint_encoder_offset": {"offset": 0.013}},
        accepted=answers(("joint_encoder_offset",), ("motor_encoder_offset",)),
    )


THICKNESS = 3e-5  # kg m², a rod's inertia about its length


def submerged(base: Base) -> Hidden:
    """A rod that swings in water."""
    rod = f'diaginertia="{base.inertia!r} {base.inertia!r} {THICKNESS}"'
    # MuJoCo's fluid acts on the box of the same inertia
    width, length = math.sqrt(6.0 * THICKNESS), math.sqrt(6.0 * (2.0 * base.inertia - THICKNESS))
    coefficient = 1000.0 / 64.0 * width * (width**4 + length**4)
    return Hidden(
        link=f'<inertial pos="0 0 0" mass="1" {rod}/>',
        option='density="1000"',
        effects={"quadratic_drag": {"coefficient": coefficient}},
        accepted=answers(("quadratic_drag",)),
    )


def strung(base: Base) -> Hidden:
    """Safety strings beside the springs: tendons of their own that are taut later."""
    engagement, stiffness = 0.55, 4.0 * base.upper
    strings = tuple(
        replace(
            cord,
            name=f"{cord.name}_string",
            stiffness=base.PARALLEL * stiffness,
            taut=engagement * base.max_deflection + cord.taut,
        )
        for cord in tendons(base)
    )
    return Hidden(
        cords=(*tendons(base), *strings),
        effects={"overstretch_protection": {"engagement": engagement, "stiffness": stiffness}},
        accepted=answers(("overstretch_protection",)),
    )


def heavy_springs(base: Base) -> Hidden:
    """The middle of each spring is a slide with mass."""
    mass = 0.02 * base.inertia / base.joint_radius**2
    damping = 0.01 * math.sqrt(4.0 * base.upper * mass)
    bodies, cords = [], []
    for cord in tendons(base):
        middle, (motor, joint) = f"{cord.name}_middle", cord.arms.items()
        bodies.append(
            f'<body><joint name="{middle}" type="slide" axis="1 0 0"/>'
            f'<inertial pos="0 0 0" mass="{base.PARALLEL * mass!r}" diaginertia="1 1 1"/></body>'
        )
        halves = (dict([motor, (middle, -1.0)]), dict([(middle, 1.0), joint]))
        cords += [
            Cord(f"{cord.name}_{i}", arms, 2.0 * cord.stiffness, 0.5 * cord.taut)
            for i, arms in enumerate(halves)
        ]
        # drags at the middle against the mean of both ends
        ends = {name: 0.5 * arm * sign for (name, arm), sign in ((motor, -1.0), (joint, 1.0))}
        drag = f'damping="{base.PARALLEL * damping!r}"'
        cords.append(Cord(f"{cord.name}_drag", {middle: 1.0, **ends}, more=drag))
    return Hidden(
        bodies="".join(bodies),
        cords=tuple(cords),
        effects={"spring_mass": {"mass": mass, "damping": damping}},
        accepted=answers(("spring_mass",)),
    )


def loose_gear(base: Base) -> Hidden:
    """A light pulley beside the motor, held to it by a tendon with limits: the play."""
    gap, inertia = 0.025, 1e-7
    pulley = (
        '<body><joint name="pulley" type="hinge" axis="0 1 0"/>'
        f'<inertial pos="0 0 0" mass="0.001" diaginertia="{inertia} {inertia} {inertia}"/></body>'
    )
    play = f'range="{-0.5 * gap!r} {0.5 * gap!r}" solreflimit={STIFF[0]} solimplimit={STIFF[1]}'
    rub = f'damping="{0.2 * math.sqrt(base.stiffness * inertia)!r}"'
    return Hidden(
        bodies=pulley,
        cords=(
            *tendons(base, "pulley"),
            Cord("play", {"pulley": 1.0, "motor": -1.0}, more=play),
            # lets the light pulley settle; at rest beside the joint it does nothing
            Cord("rub", {"pulley": base.ratio, "joint": -1.0}, more=rub),
        ),
        effects={"gear_backlash": {"gap": gap}},
        accepted=answers(("gear_backlash",)),
    )


def dry_eccentric(base: Base) -> Hidden:
    """Dry friction and weight."""
    torque = 0.025 * base.torque
    return Hidden(
        joint=dry_hinge(torque),
        link=eccentric_link(base, 0.1),
        effects={"coulomb_friction": {"torque": torque}} | gravity(base, 0.1),
        accepted=answers(
            ("coulomb_friction", "gravity_load"), ("stribeck_friction", "gravity_load")
        ),
    )


def late_dry(base: Base) -> Hidden:
    """Dry friction, and the encoder is read late."""
    torque = 0.03 * base.torque
    return Hidden(
        joint=dry_hinge(torque),
        delay=0.003,
        effects={
            "coulomb_friction": {"torque": torque},
            "measurement_delay": {"delay": 0.003},
        },
        accepted=answers(
            ("coulomb_friction", "measurement_delay"), ("stribeck_friction", "measurement_delay")
        ),
    )


def three(base: Base) -> Hidden:
    """Dry friction, weight and a rubber stop."""
    torque, upper = 0.02 * base.torque, 0.55
    return Hidden(
        joint=f"{dry_hinge(torque)} {soft_stop(base, upper)}",
        stop=upper,
        link=eccentric_link(base, 0.1),
        effects={
            "coulomb_friction": {"torque": torque},
            "joint_stop": stop_numbers(base, upper),
            **gravity(base, 0.1),
        },
        accepted=answers(
            ("coulomb_friction", "gravity_load", "joint_stop"),
            ("stribeck_friction", "gravity_load", "joint_stop"),
        ),
    )


def rubbing_tendons(base: Base) -> Hidden:
    """Friction along each tendon, alike whatever its tension is, and also where it is slack."""
    rub = f'frictionloss="{0.02 * base.torque / base.joint_radius!r}" '
    rub += f"solreffriction={STIFF[0]} solimpfriction={STIFF[1]}"
    return Hidden(
        cords=tuple(replace(cord, more=rub) for cord in tendons(base)),
        effects=None,
        # springs that yield early come nearest, at many times the noise
        accepted=frozenset(),
        unknown=True,
    )


def second_link(base: Base) -> Hidden:
    """A flexible hinge in the link, behind which a third of the inertia swings."""
    tip, frequency = 0.35 * base.inertia, 2.0 * math.pi * 11.0
    rest = base.inertia - tip
    damping = 2.0 * 0.02 * frequency * tip
    swinging = (
        f'<body><joint name="tip" type="hinge" axis="0 1 0" stiffness="{frequency**2 * tip!r}" '
        f'damping="{damping!r}"/>'
        f'<inertial pos="0 0 0" mass="0.1" diaginertia="{tip!r} {tip!r} {tip!r}"/></body>'
    )
    return Hidden(
        link=f'<inertial pos="0 0 0" mass="1" diaginertia="{rest!r} {rest!r} {rest!r}"/>{swinging}',
        effects=None,
        accepted=frozenset(),
        unknown=True,
    )


def grounded(base: Base) -> Hidden:
    """A spring between joint and ground, such as a stiff cable."""
    return Hidden(
        joint=f'stiffness="{0.06 * base.stiffness!r}" springref="0.2"',
        effects=None,
        accepted=frozenset(),
        unknown=True,
    )


def pushed(base: Base) -> Hidden:
    """Somebody leans on the link now and then, beside the load cell."""
    return Hidden(push=0.12 * base.torque, effects=None, accepted=frozenset(), unknown=True)


MACHINES: dict[str, Make] = {
    "bundled": nothing,
    "other_numbers": nothing,
    "armature": armature,
    "dry_joint": dry_joint,
    "eccentric": eccentric,
    "stopped": stopped,
    "hard_stop": hard_stop,
    "late": late,
    "shifted": shifted,
    "submerged": submerged,
    "strung": strung,
    "heavy_springs": heavy_springs,
    "loose_gear": loose_gear,
    "dry_eccentric": dry_eccentric,
    "late_dry": late_dry,
    "three": three,
    "rubbing_tendons": rubbing_tendons,
    "second_link": second_link,
    "grounded": grounded,
    "pushed": pushed,
}


def random_base(rng: np.random.Generator) -> Base:
    """Numbers around those of the bundled joint."""
    radius = float(rng.uniform(0.025, 0.038))
    stiffness = float(rng.uniform(8e3, 1.5e4))
    upper, lower = (stiffness * float(rng.uniform(0.9, 1.12)) for _ in range(2))
    taut = float(rng.uniform(2.5e-3, 4.5e-3))  # m, by which pretension stretches the springs
    base = Base(
        joint_radius=radius,
        motor_radius=radius * float(rng.uniform(0.7, 1.1)),
        pretension=taut * 2.0 * stiffness,
        upper=upper,
        lower=lower,
    )
    frequency = 2.0 * math.pi * float(rng.uniform(4.5, 6.5))
    inertia = base.stiffness / frequency**2
    damping = 2.0 * float(rng.uniform(0.05, 0.11)) * math.sqrt(base.stiffness * inertia)
    return replace(base, inertia=inertia, damping=damping)


def machine_of(name: str, seed: int) -> Machine:
    """A machine of a kind in `MACHINES`; every seed has other numbers, but for the bundled one."""
    rng = np.random.default_rng([crc32(name.encode()), seed])
    base = Base() if name == "bundled" else random_base(rng)
    hidden = MACHINES[name](base)
    heavier = (1.0 + ROTOR) * base.inertia if name == "armature" else base.inertia
    return Machine(name, base, hidden, replace(base, inertia=heavier))
