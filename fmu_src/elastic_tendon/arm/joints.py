"""A recording of an arm, cut into recordings of its joints: what the other links do is a load."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_filter, welch

from elastic_tendon.actuator.parameters import Model, parse_model, sizes_of
from elastic_tendon.arm.robot import joint_numbers, joints_of, mass_matrix, mujoco
from elastic_tendon.errors import ArmError
from elastic_tendon.measurement import Measurement

Array = NDArray[np.float64]

_ORDER = 5  # of the polynomials whose derivatives are taken
_ABOVE = 10.0  # times the noise's spectrum, down to which motion is told from it
_NARROWEST, _WIDEST = 9, 201  # samples of a polynomial
_DRAWS = 8  # of other noise, whose effect on the loads is looked at
_SEED = 1


@dataclass(frozen=True)
class CutJoint:
    """One joint of an arm as if it were alone: what `diagnose` takes.

    `model` : at interface position, with the link that the robot's mass matrix shows
    `recording` : of this joint, the load torque being what the rest of the arm does to that link
    `load_noise` : standard deviation of the load torque, N·m, that noise of all joints makes
    """

    model: Model
    recording: Measurement
    load_noise: float


def cut_into_joints(
    robot: Any, actuators: Mapping[str, Model], recordings: Mapping[str, Measurement]
) -> dict[str, CutJoint]:
    """Cut a recording of an arm into one of each joint, by inverse dynamics of the robot.

    The torque on each joint follows from measured positions, whose derivatives are those of
    polynomials about each sample, as wide as motion and noise allow; half of one is cut off at
    either end. What it takes beyond the link's own inertia is the joint's load. Noise of positions
    makes noise of loads, which moves the simulated joint: the recordings count it with their
    sensors' own, so it has its weight.

    Parameters
    ----------
    robot : mujoco.MjModel without what hides; all of its joints are hinges
    actuators : name of a joint -> Model of its actuator, of the joints that are elastic
    recordings : name of a joint -> Measurement of its motor and joint positions, of a joint without
        springs the latter alone; of every joint, with the same times; loads recorded there act
        beside what the arm does

    Returns
    -------
    dict of the elastic joints' names -> CutJoint

    Raises
    ------
    ArmError
        where joints and recordings do not belong together, a position is missing, or times are
        not evenly spaced
    """
    time = _common_time(robot, actuators, recordings)
    names = joints_of(robot)
    measured = np.array([recordings[name].signals["joint_position"] for name in names])
    sigmas = [recordings[name].noise["joint_position"].sigma for name in names]
    smoothers = [
        _Smoother.of(values, sigma, time) for values, sigma in zip(measured, sigmas, strict=True)
    ]
    # before and behind lies half a polynomial alone, whose derivatives are too noisy
    edge = max(smoother.width for smoother in smoothers) // 2
    inside = slice(edge, len(time) - edge)
    inertia = _inertias(robot, measured)
    loads = _loads(robot, inertia, measured, smoothers)
    rng = np.random.default_rng(_SEED)
    drawn = []
    for _ in range(_DRAWS):
        noise = np.array(sigmas)[:, None] * rng.standard_normal(measured.shape)
        drawn.append(_loads(robot, inertia, measured + noise, smoothers) - loads)
    return {
        name: _cut(
            *(robot, name, actuators[name], recordings[name].samples(inside)),
            *(inertia[index], loads[index, inside]),
            *(np.array([draw[index, inside] for draw in drawn]), sigmas[index]),
        )
        for index, name in enumerate(names)
        if name in actuators
    }


# ---- what belongs together -----------------------------------------------------------------


def _common_time(
    robot: Any, actuators: Mapping[str, Model], recordings: Mapping[str, Measurement]
) -> Array:
    names = joints_of(robot)
    if set(recordings) != set(names):
        raise ArmError(
            f"the arm has {len(names)} joints ({', '.join(names)}), but there are "
            f"{len(recordings)} recordings ({', '.join(recordings) or 'none'}); give one of each "
            "joint"
        )
    joint_numbers(robot, tuple(actuators))
    first, *others = (recordings[name] for name in names)
    for name, recording in zip(names[1:], others, strict=True):
        if not np.array_equal(recording.time, first.time):
            raise ArmError(
                f"the recordings of {names[0]} and {name} have different times; give samples that "
                "were taken together"
            )
    for name in names:
        if "joint_position" not in recordings[name].signals:
            raise ArmError(f"the recording of {name} has no joint_position, which the loads need")
        measured = {**recordings[name].inputs, **recordings[name].signals}
        if name in actuators and "motor_position" not in measured:
            raise ArmError(
                f"the recording of {name} has no motor_position, which its springs need; give the "
                "motor's angle, or leave the joint out of the actuators"
            )
    steps = np.diff(first.time)
    if len(steps) < _WIDEST or np.ptp(steps) > 0.01 * steps.mean():
        raise ArmError(
            f"derivatives need more than {_WIDEST} samples at one rate, and these are "
            f"{len(steps) + 1} at {steps.min():.4g} to {steps.max():.4g} s; resample them"
        )
    return first.time


# ---- derivatives ---------------------------------------------------------------------------


@dataclass(frozen=True)
class _Smoother:
    """Polynomials about each sample: how many samples, and how far apart, s."""

    width: int
    step: float

    @classmethod
    def of(cls, values: Array, sigma: float, time: Array) -> "_Smoother":
        """As wide as lets through what stands out of the noise."""
        step = float((time[-1] - time[0]) / (len(time) - 1))
        frequency, power = welch(values, 1 / step, nperseg=min(1024, len(values)))
        floor = 2 * sigma**2 * step
        above = frequency[power > _ABOVE * floor]
        cut = float(above[-1]) if above.size else frequency[1]
        # half-width at which it passes this frequency to half its power (Schafer, 2011)
        half = ((_ORDER + 1) / (2 * cut * step) + 4.6) / 3.2
        width = 2 * round(half / 2) + 1
        return cls(int(np.clip(width, _NARROWEST, _WIDEST)), step)

    def __call__(self, values: Array) -> Iterator[Array]:
        """Values, velocities, accelerations."""
        for derivative in range(3):
            yield savgol_filter(
                values, self.width, _ORDER, deriv=derivative, delta=self.step, mode="interp"
            )


# ---- inverse dynamics ----------------------------------------------------------------------


def _inertias(robot: Any, positions: Array) -> Array:
    """Mean inertia of what each joint turns, kg·m²."""
    package, data = mujoco(), mujoco().MjData(robot)
    places, dofs = joint_numbers(robot, joints_of(robot))
    total, every = np.zeros(len(dofs)), max(1, positions.shape[1] // 200)
    for position in positions.T[::every]:
        data.qpos[places] = position
        package.mj_forward(robot, data)
        total += np.diag(mass_matrix(robot, data))[dofs]
    inertias: Array = total / len(positions.T[::every])
    return inertias


def _loads(robot: Any, inertia: Array, positions: Array, smoothers: list[_Smoother]) -> Array:
    """What the rest of the arm does to each link, (joints, n), N·m."""
    package, data = mujoco(), mujoco().MjData(robot)
    places, dofs = joint_numbers(robot, joints_of(robot))
    derivatives = [
        tuple(smoother(values)) for smoother, values in zip(smoothers, positions, strict=True)
    ]
    position, velocity, acceleration = np.array(derivatives).transpose(1, 2, 0)
    loads = np.empty(position.shape)
    for index in range(len(position)):
        data.qpos[places] = position[index]
        data.qvel[dofs] = velocity[index]
        data.qacc[dofs] = acceleration[index]
        package.mj_inverse(robot, data)
        loads[index] = data.qfrc_inverse[dofs]
    # the link's own inertia and damping stay with the joint's model
    own = inertia * acceleration + robot.dof_damping[dofs] * velocity
    return np.asarray((own - loads).T)


def _cut(
    robot: Any,
    name: str,
    actuator: Model,
    recording: Measurement,
    inertia: float,
    load: Array,
    drawn: Array,
    noise: float,
) -> CutJoint:
    _, (dof,) = joint_numbers(robot, (name,))
    damping = float(robot.dof_damping[dof])
    link = {"inertia": float(inertia), "damping": damping}  # the robot's, whatever the model has
    model = parse_model(actuator.model_dump() | {"link": link}, actuator.name).at_position()
    stiffness = sizes_of(model.transmission, model.link).joint_stiffness
    step = float(np.mean(np.diff(recording.time)))
    moved = np.sqrt(np.mean(_answer(drawn, step, inertia, damping, stiffness) ** 2))
    sigma = float(np.hypot(noise, moved))
    given = recording.load_torque
    cut = Measurement(
        name=f"{recording.name}, {name}",
        time=recording.time,
        motor_position=recording.motor_position,
        signals={"joint_position": recording.signals["joint_position"]},
        load_torque=load if given is None else load + given,
        interpolation=recording.interpolation,
        notes=recording.notes,
    ).with_noise({"joint_position": sigma})
    return CutJoint(model, cut, float(np.sqrt(np.mean(drawn**2))))


def _answer(torque: Array, step: float, inertia: float, damping: float, stiffness: float) -> Array:
    """How far torques move the joint with both tendons taut, rad."""
    rate = 2 * np.pi * np.fft.rfftfreq(torque.shape[-1], step)
    compliance = 1 / (stiffness - inertia * rate**2 + 1j * damping * rate)
    return np.fft.irfft(np.fft.rfft(torque) * compliance, torque.shape[-1])
