"""Arms that MuJoCo plays with its own tendons and friction, for the way back.

Each joint has two fixed tendons to a motor whose place is written before every step, as
`engine.machines` makes them; the links are those of examples/arm/arm.xml with other masses.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from elastic_tendon.actuator.parameters import Model, parse_model
from elastic_tendon.measurement import Measurement
from engine.machines import HEAVY, Answer, Base, Cord, dry_hinge, soft_stop
from engine.motions import waves

Array = NDArray[np.float64]

JOINTS = ("base", "shoulder", "elbow", "wrist")
STEP, RATE, SETTLING = 1e-4, 500, 1.0  # s, Hz, s
SIGMA = 2e-4  # rad, of the joints' encoders
BASES = {
    "base": Base(damping=0.25),
    "shoulder": Base(damping=0.25),
    "elbow": Base(damping=0.12),
    "wrist": Base(
        joint_radius=0.02, motor_radius=0.02, pretension=25.0, upper=3000.0, lower=3000.0,
        damping=0.03,
    ),
}  # fmt: skip
NOTHING: Answer = frozenset()
FRICTION: set[Answer] = {frozenset({"coulomb_friction"}), frozenset({"stribeck_friction"})}
ACCEPTED: dict[str, set[Answer]] = {  # sets of effects that are a right answer, by what hides
    "nothing": {NOTHING},
    "rotor": {NOTHING},  # more inertia is a wrong number
    "dry": FRICTION,
    "stopped": {frozenset({"joint_stop"})},
    "dry_stopped": {one | {"joint_stop"} for one in FRICTION},
}
STOP = 1.25  # rad, of the elbow, which passes it now and then


@dataclass(frozen=True)
class PlayedArm:
    """A question: which joint hides what, and with which random numbers."""

    hidden: str
    joint: str
    seed: int

    @property
    def name(self) -> str:
        """For tables and files."""
        return f"{self.hidden}-{self.joint}-{self.seed}"


def _masses(seed: int) -> dict[str, float]:
    rng = np.random.default_rng([1, seed])
    return dict(
        zip(
            ("upper_arm", "forearm", "hand"),
            (np.array([0.5, 0.35, 0.3]) * rng.uniform(0.8, 1.2, 3)).tolist(),
            strict=True,
        )
    )


def links(seed: int, joint_attributes: Mapping[str, str] | None = None) -> str:
    """The bodies of the arm, without motors and tendons."""
    more, mass = joint_attributes or {}, _masses(seed)

    def joint(name: str, axis: str) -> str:
        return (
            f'<joint name="{name}" axis="{axis}" damping="{BASES[name].damping!r}" '
            f"{more.get(name, '')}/>"
        )

    return f"""
    <body name="column" pos="0 0 0.04">
      {joint("base", "0 0 1")}
      <geom type="capsule" fromto="0 0 0 0 0 0.4" size="0.05" mass="3"/>
      <body name="upper_arm" pos="0 0 0.4">
        {joint("shoulder", "0 1 0")}
        <geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.025" mass="{mass["upper_arm"]!r}"/>
        <body name="forearm" pos="0.3 0 0">
          {joint("elbow", "0 1 0")}
          <geom type="capsule" fromto="0 0 0 0.28 0 0" size="0.02" mass="{mass["forearm"]!r}"/>
          <body name="hand" pos="0.28 0 0">
            {joint("wrist", "0 1 0")}
            <geom type="capsule" fromto="0 0 0 0.1 0 0" size="0.03" mass="{mass["hand"]!r}"/>
          </body>
        </body>
      </body>
    </body>"""


def _mjcf(bodies: str, more: str = "") -> str:
    return f"""
<mujoco>
  <compiler angle="radian" autolimits="true"/>
  <option timestep="{STEP}" integrator="implicitfast" gravity="0 0 -9.81" tolerance="1e-15">
    <flag contact="disable" refsafe="disable"/></option>
  <worldbody>{bodies}</worldbody>{more}
</mujoco>"""


def robot(seed: int) -> mujoco.MjModel:
    """What is known of the arm: links and the damping of joints."""
    return mujoco.MjModel.from_xml_string(_mjcf(links(seed)))


def _cords(name: str, base: Base) -> tuple[Cord, Cord]:
    r, R = base.motor_radius, base.joint_radius
    upper, lower = base.sides
    return (
        Cord(f"{name}_upper", {f"{name}_motor": r, name: -R}, upper, -base.pretension / upper),
        Cord(f"{name}_lower", {f"{name}_motor": -r, name: R}, lower, -base.pretension / lower),
    )


def _machine(arm: PlayedArm) -> mujoco.MjModel:
    """The arm with motors, tendons and what hides."""
    base = BASES[arm.joint]
    attributes, cords = "", [cord for name in JOINTS for cord in _cords(name, BASES[name])]
    if "dry" in arm.hidden:
        share = np.random.default_rng([5, arm.seed]).uniform(0.02, 0.06)
        attributes += dry_hinge(float(share) * base.torque)
    if "stopped" in arm.hidden:
        attributes += " " + soft_stop(base, STOP)
    if arm.hidden == "rotor":
        attributes = 'armature="0.01"'
    motors = "".join(
        f'<body><joint name="{name}_motor" axis="0 1 0" armature="{HEAVY}"/>'
        '<inertial pos="0 0 0" mass="0.001" diaginertia="1e-6 1e-6 1e-6"/></body>'
        for name in JOINTS
    )
    tendons = f"<tendon>{''.join(cord.mjcf for cord in cords)}</tendon>"
    text = _mjcf(motors + links(arm.seed, {arm.joint: attributes}), tendons)
    return mujoco.MjModel.from_xml_string(text)


def motors(arm: PlayedArm, duration: float, run: int) -> tuple[Array, Array]:
    """Motions of the motors at the engine's steps, (n, 4), rad; `run` tells one from another."""
    rng = np.random.default_rng([2, arm.seed, run])
    time = np.maximum(np.arange(-round(SETTLING / STEP), round(duration / STEP)) * STEP, 0.0)
    speeds = (2.2, 1.8, 3.5, 4.0)
    begin = (0.0, -0.6, 0.9, 0.2)
    columns = [
        at + waves(rng, 0.3, 3.0, 8, speed)(time) for at, speed in zip(begin, speeds, strict=True)
    ]
    return time, np.array(columns).T


def play(arm: PlayedArm, duration: float = 12.0, run: int = 0) -> dict[str, Measurement]:
    """What the encoders show: joint -> Measurement."""
    machine = _machine(arm)
    data = mujoco.MjData(machine)
    numbers = {machine.joint(number).name: number for number in range(machine.njnt)}
    joints = [numbers[name] for name in JOINTS]
    driven = [numbers[f"{name}_motor"] for name in JOINTS]
    time, motor = motors(arm, duration, run)
    rate = np.gradient(motor, STEP, axis=0)
    place, speed, advance = data.qpos, data.qvel, mujoco.mj_step
    place[joints] = motor[0]
    found = np.empty((len(time), len(JOINTS)))
    for i in range(len(time)):
        found[i] = place[joints]
        place[driven] = motor[i]
        speed[driven] = rate[i]
        advance(machine, data)
    samples = np.arange(round(SETTLING / STEP), len(time), round(1 / (RATE * STEP)))
    rng = np.random.default_rng([3, arm.seed, run])
    return {
        name: Measurement(
            name=arm.name,
            time=time[samples],
            motor_position=motor[samples, index],
            signals={
                "joint_position": found[samples, index] + SIGMA * rng.standard_normal(len(samples))
            },
        )
        for index, name in enumerate(JOINTS)
    }


def believed(arm: PlayedArm) -> dict[str, Model]:
    """Models of the actuators, numbers off by some percent, without what hides."""
    rng = np.random.default_rng([4, arm.seed])
    models = {}
    for name in JOINTS:
        tree = BASES[name].tree() | {"name": name}
        transmission = tree["transmission"]
        for spring in ("upper_spring", "lower_spring"):
            transmission[spring]["stiffness"] *= 1.0 + 0.08 * rng.uniform(-1.0, 1.0)
        transmission["pretension_force"] *= 1.0 + 0.15 * rng.uniform(-1.0, 1.0)
        models[name] = parse_model(tree, name)
    return models
