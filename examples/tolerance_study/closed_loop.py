"""Position controllers designed for one machine, on many machines: a task of one's own.

The controllers are those of ../controller_design, designed once, on the nominal numbers. Within a
slack state machine and controller are linear, so each machine takes a few small matrices.
"""

import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.linalg import expm

from elastic_tendon import LinearModel, Model, Points, SlackState

sys.path.append(str(Path(__file__).parents[1] / "controller_design"))

from design import (
    JOINT,
    JOINT_VELOCITY,
    MOTOR,
    SAMPLE,
    Controller,
    lqg,
    origin,
    plants,
    softened,
    stiffness,
)

I, II, III = SlackState.I, SlackState.II, SlackState.III  # noqa: E741, the paper's names
LOAD_DRIFT = 1.0  # N·m/√s, as in controller_design
# what the designs are for: how far on the way from the taut plant to the slack one, and beyond
SHARES = {"taut": 0.0, "slack": 1.0, "softer": 1.2}
STEP_SAMPLES = 400  # of a step of the reference, within which each loop overshoots
Plants = Mapping[SlackState, LinearModel]


@dataclass(frozen=True)
class ClosedLoops:
    """Damping and overshoot of each design in each slack state, a row for each machine.

    All that `sweep` needs of a task is here: `runs`, `identity`, `threads`, `batch()`, `rows()`
    and `failed()`.
    """

    model: Model
    points: Points
    plants: Plants
    designs: Mapping[str, Controller]

    @property
    def runs(self) -> int:
        return self.points.count

    @property
    def identity(self) -> dict[str, str]:
        return self.points.identity | {"model": self.model.to_toml(), "designs": repr(SHARES)}

    @property
    def threads(self) -> bool:
        return True

    def batch(self) -> int:
        return 250

    def rows(self, start: int, stop: int) -> pd.DataFrame:
        drawn = self.points.rows(start, stop)
        machines = {one.path: drawn[:, i] for i, one in enumerate(self.points.factors)}
        columns: dict[str, np.ndarray] = {"run": np.arange(start, stop), **machines}
        for state, stiffnesses in joint_stiffness(self.model, machines).items():
            for name, design in self.designs.items():
                loops, driven = closed_loops(self.plants, design, stiffnesses)
                columns[f"{name}.damping_{state.name}"] = damping(loops)
                columns[f"{name}.overshoot_{state.name}"] = overshoot(loops, driven)
        return pd.DataFrame(columns).assign(failure="")

    def failed(self, run: int, reason: str) -> pd.DataFrame:
        table = self.rows(0, 1)
        results = [name for name in table.columns if name.startswith(tuple(self.designs))]
        table[results] = np.nan
        return table.assign(run=run, failure=reason)


def closed_loops_of(model: Model, points: Points) -> ClosedLoops:
    """The designs of a model, to be tried on the machines of `points`."""
    linear = plants(model)
    designs = {
        name: lqg(softened(linear[III], linear[I], share), origin(linear[III]), LOAD_DRIFT)
        for name, share in SHARES.items()
    }
    return ClosedLoops(model, points, linear, designs)


def joint_stiffness(
    model: Model, machines: Mapping[str, np.ndarray]
) -> dict[SlackState, np.ndarray]:
    """Stiffness of the joint in each slack state (N·m/rad), (19), (23) and (25)."""
    transmission = model.transmission
    upper, lower = (
        transmission.joint_pulley_radius**2
        * getattr(transmission, side).parallel
        * machines[f"transmission.{side}.stiffness"]
        for side in ("upper_spring", "lower_spring")
    )
    return {I: upper, II: lower, III: upper + lower}


def closed_loops(
    plants: Plants, design: Controller, stiffnesses: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Motion and observer from one sample to the next (k, 7, 7), and what drives them (k, 7).

    Driven by the reference: its step of 1 rad is a step of the target of joint and motor.
    """
    taut, slack = plants[III], plants[I]
    # stiffness enters A alone, and linearly
    share = (stiffness(taut) - stiffnesses) / (stiffness(taut) - stiffness(slack))
    k = len(share)
    continuous = np.zeros((k, 4, 4))
    continuous[:, :3, :3] = taut.A + share[:, None, None] * (slack.A - taut.A)
    continuous[:, :3, 3:] = taut.B[:, :1]
    sampled = expm(SAMPLE * continuous)
    A, B = sampled[:, :3, :3], sampled[:, :3, 3:]
    feedback = design.feedback
    loops = np.empty((k, 7, 7))
    loops[:, :3, :3], loops[:, :3, 3:] = A, -B @ feedback.C
    loops[:, 3:, :3], loops[:, 3:, 3:] = feedback.B @ taut.C, feedback.A
    lead = -design.acceleration[JOINT] / design.acceleration[MOTOR]
    target = design.K @ np.array([1.0, 0.0, lead, 0.0])
    driven = np.concatenate([B @ target, np.tile(design.model.B @ target, (k, 1))], axis=1)
    return loops, driven


def damping(loops: np.ndarray) -> np.ndarray:
    """Damping ratio of the least damped pole, (k,)."""
    poles = np.log(np.linalg.eigvals(loops).astype(complex)) / SAMPLE
    return np.min(-poles.real / np.abs(poles), axis=1)


def overshoot(loops: np.ndarray, driven: np.ndarray) -> np.ndarray:
    """By which share of a step of the reference the joint goes beyond it, (k,)."""
    x = np.zeros_like(driven)
    highest = np.zeros(len(loops))
    for _ in range(STEP_SAMPLES):
        x = np.squeeze(loops @ x[:, :, None], axis=2) + driven
        highest = np.maximum(highest, x[:, JOINT])
    return np.maximum(highest - 1.0, 0.0)


def apart(task: ClosedLoops, run: int) -> float:
    """How far, relatively, the matrices of a machine are from those that `linearise` gives it."""
    (values,) = task.points.rows(run, run + 1)
    machine = dict(zip([one.path for one in task.points.factors], values, strict=True))
    linear = plants(task.model.with_values(machine))
    wanted = joint_stiffness(task.model, {path: np.array([one]) for path, one in machine.items()})
    taut, slack = task.plants[III], task.plants[I]
    found = []
    for state, (one,) in wanted.items():
        share = (stiffness(taut) - one) / (stiffness(taut) - stiffness(slack))
        difference = softened(taut, slack, share).A - linear[state].A
        found.append(np.abs(difference).max() / np.abs(linear[state].A[JOINT_VELOCITY]).max())
    return float(max(found))
