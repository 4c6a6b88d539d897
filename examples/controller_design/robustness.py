"""What linear models say of a controller: margins, damping, and a common Lyapunov function."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import reduce
from itertools import accumulate, product

import control
import numpy as np
from design import SAMPLE, Controller
from scipy.linalg import LinAlgError, solve_discrete_are

FREQUENCIES = np.geomspace(0.1, 0.999 * np.pi / SAMPLE, 1000)  # rad/s
FASTEST, HALVINGS = 50.0, 10  # 1/s; where the bisection of a decay rate begins, how far it goes
# rad, rad/s, rad of the plant, then of the observer with N·m: P weighs all of them at least so
SIZES = np.array([1.0, 40.0, 1.0, 1.0, 40.0, 1.0, 20.0])
LEAST_WEIGHT = 1e-2


@dataclass(frozen=True)
class Margins:
    """Of the loop broken at the motor's velocity, and the poles of the closed one.

    `gain` dB, `phase` degrees, `delay` s, `disk` (balanced: 2 is as good as it gets), `damping`
    ratio of the least damped pole, `decay` 1/s of the slowest.
    """

    gain: float
    phase: float
    delay: float
    disk: float
    damping: float
    decay: float


def margins(plant: control.StateSpace, controller: Controller) -> Margins:
    """Margins of a controller on a linear model, all by frequency response in state space.

    Margins of a transfer function made from a state space can be nonsense, and a list of two
    frequencies would be a range to python-control.
    """
    opened = loop(plant, controller)
    gain, phase, _, _, crossing, _ = control.stability_margins(control.frd(opened, FREQUENCIES))
    disk, _, _ = control.disk_margins(opened, FREQUENCIES)
    poles = np.log(np.linalg.eigvals(closed_loop(plant, controller)).astype(complex)) / SAMPLE
    return Margins(
        gain=20.0 * np.log10(gain),
        phase=phase,
        delay=np.deg2rad(phase) / crossing,
        disk=disk,
        damping=float(np.min(-poles.real / np.abs(poles))),
        decay=float(-poles.real.max()),
    )


def loop(plant: control.StateSpace, controller: Controller) -> control.StateSpace:
    """The loop, broken at the motor's velocity and closed by negative feedback."""
    return controller.feedback * control.c2d(plant, SAMPLE)[:, 0]


def closed_loop(plant: control.StateSpace, controller: Controller) -> np.ndarray:
    """Motion and observer (7, 7) from one sample to the next."""
    return closed_through([plant], controller)


def closed_through(sequence: Sequence[control.StateSpace], controller: Controller) -> np.ndarray:
    """The same where the plant runs through several states within the sample, equally long."""
    parts = [control.c2d(plant, SAMPLE / len(sequence)) for plant in sequence]
    A = reduce(lambda before, part: part.A @ before, parts, np.eye(3))
    B = reduce(lambda before, part: part.A @ before + part.B[:, :1], parts, np.zeros((3, 1)))
    feedback = controller.feedback
    return np.block([[A, -B @ feedback.C], [feedback.B @ sequence[0].C, feedback.A]])


def common_lyapunov(loops: Sequence[np.ndarray], rate: float = 0.0) -> np.ndarray | None:
    """P > 0 that falls in every one of the loops, and however they take turns; None: not found.

    The loops are their middle and what is uncertain of it, E Δ F with |Δ| ≤ 1; by the
    bounded-real lemma a Riccati equation gives P if that is stable for any Δ, constant or not.
    (S. Boyd et al., Linear Matrix Inequalities in System and Control Theory, SIAM, 1994, 5.1.)

    Parameters
    ----------
    loops : matrices from one sample to the next
    rate : 1/s at which the states shall fall
    """
    scaled = [np.exp(rate * SAMPLE) * loop for loop in loops]
    farthest = max(scaled, key=lambda loop: np.linalg.norm(loop - scaled[0]))
    middle, apart = (scaled[0] + farthest) / 2.0, (farthest - scaled[0]) / 2.0
    left, sizes, right = np.linalg.svd(apart)
    rank = int(np.sum(sizes > 1e-12 * sizes[0]))
    E = left[:, :rank] * np.sqrt(sizes[:rank])
    F = np.sqrt(sizes[:rank, None]) * right[:rank]
    least = LEAST_WEIGHT * np.diag(SIZES**-2)
    try:
        P = solve_discrete_are(middle, E, F.T @ F + least, -np.eye(rank))
    except (LinAlgError, ValueError):
        return None
    P = (P + P.T) / 2.0
    if np.linalg.eigvalsh(P)[0] <= 0.0 or growth(P, scaled) >= 0.0:
        return None
    return P


def growth(P: np.ndarray, loops: Iterable[np.ndarray]) -> float:
    """Largest eigenvalue of A' P A - P among the loops, for P scaled to the identity."""
    factor = np.linalg.cholesky(P).T
    inverse = np.linalg.inv(factor)
    return max(float(np.linalg.norm(factor @ A @ inverse, 2)) ** 2 - 1.0 for A in loops)


def guaranteed_decay(loops: Sequence[np.ndarray]) -> float | None:
    """Largest rate (1/s) for which there is a common P, by bisection; None: for none."""
    if common_lyapunov(loops) is None:
        return None
    low, high = 0.0, FASTEST
    for _ in range(HALVINGS):
        middle = (low + high) / 2.0
        low, high = (low, middle) if common_lyapunov(loops, middle) is None else (middle, high)
    return low


def slowest_rhythm(first: np.ndarray, second: np.ndarray, longest: int = 150) -> float:
    """Decay (1/s) when two loops take turns at their worst rhythm; negative where it grows.

    No common P can guarantee more than this. Each has its turn for 1 to `longest` samples.
    """
    turns = [np.stack(list(accumulate([A] * longest, np.matmul))) for A in (first, second)]
    rounds = turns[0][:, None] @ turns[1][None]
    samples = np.add.outer(np.arange(longest), np.arange(longest)) + 2
    largest = np.abs(np.linalg.eigvals(rounds)).max(axis=-1)
    return float(-np.max(np.log(largest) / (SAMPLE * samples)))


def growth_within_samples(
    P: np.ndarray, plants: Sequence[control.StateSpace], controller: Controller, parts: int = 4
) -> float:
    """`growth` for every sequence of states through the parts of a sample."""
    sequences = product(plants, repeat=parts)
    return growth(P, (closed_through(sequence, controller) for sequence in sequences))
