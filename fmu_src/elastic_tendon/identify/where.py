"""Where the error lies: by slack state, direction of motion and deflection."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastic_tendon.compiled import Trajectory
from elastic_tendon.identify.residuals import Array, autocorrelation_time, rms

# slower than this share of the largest speed counts as rest
REST_SHARE = 0.01
# fewer blocks say nothing about how much their mean scatters
MINIMUM_BLOCKS = 4
SLACK_LABELS = {1: "I, lower slack", 2: "II, upper slack", 3: "III, both taut", 4: "both slack"}


@dataclass(frozen=True)
class Bin:
    """Error of one signal over the samples of one bin.

    `rmse` in the signal's unit; `share` of the signal's squared error over the whole recording;
    `significance`: by how many standard errors the mean square lies above the noise floor, None
    where the bin is too short to tell.
    """

    by: str
    bin: str
    rmse: float
    share: float
    significance: float | None


def where_it_fails(residual: Array, trajectory: Trajectory, floor: float) -> tuple[Bin, ...]:
    """Split the squared error of one signal by what the model was doing.

    Samples close in time err together, so they are joined to blocks twice as long as the
    autocorrelation time of the squared residual about its mean. The mean squares of the blocks
    within a bin are taken as independent, and their scatter gives the standard error of the bin's
    mean square.

    Parameters
    ----------
    residual : (n,) array, simulated less measured
    trajectory : Trajectory of n samples
    floor : float, noise of the signal, same unit as `residual`

    Returns
    -------
    tuple of Bin; empty bins are left out
    """
    squares = residual**2
    length = int(np.ceil(2.0 * autocorrelation_time(squares - np.mean(squares))))
    blocks = np.arange(len(residual)) // length
    total = float(np.sum(squares))
    return tuple(
        Bin(
            by=by,
            bin=label,
            rmse=rms(residual[mask]),
            share=float(np.sum(squares[mask])) / total if total > 0.0 else 0.0,
            significance=_significance(squares[mask], blocks[mask], floor),
        )
        for by, label, mask in _masks(trajectory)
        if np.any(mask)
    )


def _masks(trajectory: Trajectory) -> Iterator[tuple[str, str, NDArray[np.bool_]]]:
    states = np.round(trajectory["slack_state"])
    for state, label in SLACK_LABELS.items():
        yield "slack_state", label, states == state
    velocity = trajectory["joint_velocity"]
    rest = REST_SHARE * float(np.max(np.abs(velocity)))
    yield "velocity_sign", "negative", velocity < -rest
    yield "velocity_sign", "at rest", np.abs(velocity) <= rest
    yield "velocity_sign", "positive", velocity > rest
    deflection = trajectory["deflection"]
    edges = np.linspace(deflection.min(), deflection.max(), 4)
    third = np.clip(np.searchsorted(edges, deflection, side="right") - 1, 0, 2)
    for index in range(3):
        label = f"{edges[index]:.3g} to {edges[index + 1]:.3g} rad"
        yield "deflection", label, third == index


def _significance(squares: Array, blocks: NDArray[np.int_], floor: float) -> float | None:
    _, members = np.unique(blocks, return_inverse=True)
    counts = np.bincount(members)
    if len(counts) < MINIMUM_BLOCKS:
        return None
    means = np.bincount(members, weights=squares) / counts
    weights = counts / counts.sum()
    mean = float(weights @ means)
    error = float(np.sqrt(np.sum(weights**2 * (means - mean) ** 2)))
    return (mean - floor**2) / error if error > 0.0 else 0.0
