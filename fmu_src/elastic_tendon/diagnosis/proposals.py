"""Motions and loads to choose a further experiment from.

A proposal is a form for what moves and one for what acts at the joint's side, with four parameters
of each, all between 0 and 1: how much of its reach it uses, where in the reach its middle lies, and
two rates. Both begin and end at rest where the machine stands, and stay within their reach.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from elastic_tendon.comparison.residuals import Array
from elastic_tendon.diagnosis.limits import Limits, Reach

REST = 0.2  # s at rest at either end
LEAST_FADE = 0.4  # s in which a motion fades in and out, at least
FADE_SHARE = 0.06  # ... and this share of the whole
FASTEST = 2.0  # times the natural frequency: beyond, the joint no longer follows
SAMPLES_PER_PERIOD = 20  # at least, so that straight lines between samples are close enough
SINES = 8
MOST_TIMES = 12  # steps, runs or releases in one experiment
PARAMETERS = 4  # of a form
CORNER = 0.3  # of the shortest run, in which it turns
SLOWEST_EDGE = 0.25  # of the longest time that a form has for an edge


@dataclass(frozen=True)
class Form:
    """Parameters of one form; rates in Hz, `slow` is at most `fast`."""

    time: Array
    slow: float
    fast: float
    lowest: float  # the lowest rate there is, about one a recording

    @property
    def duration(self) -> float:
        """s."""
        return float(self.time[-1])

    @property
    def times(self) -> int:
        """How often the form repeats what it does, 2 to 12, by its slow rate."""
        return int(np.clip(round(2.0 * self.slow / self.lowest), 2, MOST_TIMES))

    @property
    def edge(self) -> float:
        """s that a step takes, by its fast rate."""
        return min(0.5 / self.fast, SLOWEST_EDGE * self.duration / self.times)


def _hold(form: Form) -> Array:
    return np.zeros_like(form.time)


def _sines(form: Form) -> Array:
    frequencies = np.geomspace(form.slow, form.fast, SINES)
    phases = np.pi * np.arange(SINES) ** 2 / SINES  # Schroeder's: a low crest
    angles = 2.0 * np.pi * np.outer(form.time, frequencies) + phases
    return _normalised(np.sin(angles) @ frequencies**-0.5)


def _rising(form: Form) -> Array:
    ratio = np.log(form.fast / form.slow + 1e-6)
    cycles = form.slow * form.duration / ratio * np.expm1(ratio * form.time / form.duration)
    return np.asarray(np.sin(2.0 * np.pi * cycles))


def _steps(form: Form) -> Array:
    """Levels that differ as much as they can: the digits of the count in base 2, reversed."""
    levels = [2.0 * int(f"{index:04b}"[::-1], 2) / 15.0 - 1.0 for index in range(1, MOST_TIMES + 1)]
    starts = form.duration * np.arange(form.times) / form.times
    values = np.array(levels[: form.times])
    times = np.column_stack([starts, starts + form.edge]).ravel()[1:]
    return _smooth(form.time, times, np.repeat(values, 2)[:-1], form.edge)


def _runs(form: Form) -> Array:
    """Forth and back between the ends, each run at a speed of its own."""
    speeds = np.geomspace(form.slow, form.fast, form.times)
    lengths = 1.0 / np.concatenate([speeds, speeds[::-1]])
    times = np.concatenate([[0.0], np.cumsum(lengths)]) * form.duration / np.sum(lengths)
    corner = CORNER * float(np.min(np.diff(times)))
    return _smooth(form.time, times, np.resize([-1.0, 1.0], len(times)), corner)


def _reversals(form: Form) -> Array:
    """Swings that grow and shrink to nothing, several times."""
    size = 0.5 * (1.0 - np.cos(2.0 * np.pi * form.times * form.time / form.duration))
    return np.asarray(size * np.sin(2.0 * np.pi * form.fast * form.time))


def _releases(form: Form) -> Array:
    """Slowly to one end, held, and let go at once; then to the other end."""
    period = form.duration / form.times
    starts = period * np.arange(form.times)[:, np.newaxis]
    times = starts + np.array([0.0, 0.35 * period, 0.5 * period, 0.5 * period + form.edge])
    signs = np.resize([1.0, -1.0], form.times)[:, np.newaxis]
    values = signs * np.array([0.0, 1.0, 1.0, 0.0])
    return _smooth(form.time, times.ravel(), values.ravel(), form.edge)


FORMS: Mapping[str, Callable[[Form], Array]] = {
    "hold": _hold,
    "sines": _sines,
    "rising": _rising,
    "steps": _steps,
    "runs": _runs,
    "reversals": _reversals,
    "releases": _releases,
}


def _normalised(values: Array) -> Array:
    return np.asarray(values / np.max(np.abs(values)))


def _smooth(time: Array, times: Array, values: Array, corner: float) -> Array:
    """Straight lines between points, their corners rounded over some seconds."""
    straight = np.interp(time, times, values)
    count = 2 * max(round(0.5 * corner / float(time[1] - time[0])), 1) + 1
    window = np.hanning(count + 2)[1:-1]
    padded = np.pad(straight, count // 2, mode="edge")
    return np.asarray(np.convolve(padded, window / window.sum(), mode="valid"))


@dataclass(frozen=True)
class Input:
    """What one input does: a form and its four parameters, each between 0 and 1."""

    form: str
    parameters: tuple[float, ...]

    def values(self, time: Array, reach: Reach, limits: Limits) -> Array:
        """The input at evenly spaced `time` (n,) s from 0; (n,) array, unit of the reach."""
        amount, place, _, _ = self.parameters
        middle = reach.low + place * (reach.high - reach.low)
        amplitude = amount * min(middle - reach.low, reach.high - middle)
        form = self.at(time, limits)
        away = _fade(time) * (middle - reach.start + amplitude * FORMS[self.form](form))
        fastest = float(np.max(np.abs(np.diff(away)))) / float(time[1] - time[0])
        return reach.start + away * min(1.0, reach.rate / max(fastest, 1e-300))

    def at(self, time: Array, limits: Limits) -> Form:
        """The form's rates, between one a recording and what the joint can follow."""
        lowest = 1.0 / limits.duration
        highest = min(FASTEST * limits.frequency, 1.0 / (SAMPLES_PER_PERIOD * limits.step))
        span = np.log(max(highest / lowest, 2.0))
        slow, fast = sorted(lowest * np.exp(span * share) for share in self.parameters[2:])
        return Form(time, float(slow), float(fast), lowest)


def _fade(time: Array) -> Array:
    """From 0 to 1 and back with finite acceleration: quintics 10 s^3 - 15 s^4 + 6 s^5."""
    length = max(LEAST_FADE, FADE_SHARE * float(time[-1]))
    near = np.minimum(time, time[-1] - time) - REST
    s = np.clip(near / length, 0.0, 1.0)
    return np.asarray(s**3 * (10.0 - 15.0 * s + 6.0 * s**2))


@dataclass(frozen=True)
class Proposal:
    """What the machine is to do, made smaller by `scale` (0 to 1), see `Limits`.

    `joint_side` is None where nothing can be done there.
    """

    motion: Input
    joint_side: Input | None
    scale: float = 1.0

    def courses(self, time: Array, limits: Limits) -> tuple[Array, Array]:
        """The motion (rad) and what is done at the joint's side (N·m or rad) at `time` (n,) s.

        Returns
        -------
        two (n,) arrays
        """
        start = limits.motion.start
        position = self.motion.values(time, limits.motion, limits)
        beside = np.zeros_like(time)
        if self.joint_side is not None and limits.joint_side is not None:
            beside = self.scale * self.joint_side.values(time, limits.joint_side, limits)
        return start + self.scale * (position - start), beside


def random_proposal(rng: np.random.Generator, limits: Limits) -> Proposal:
    """Forms and parameters drawn alike; what nothing else moves does not hold still."""
    forms = list(FORMS)
    moved = forms if limits.joint_side is not None else forms[1:]

    def drawn(among: list[str]) -> Input:
        parameters = rng.uniform(size=PARAMETERS)
        # half of them about the middle of the reach, where the motion can be largest
        if rng.uniform() < 0.5:
            parameters[1] = 0.5
        return Input(str(rng.choice(among)), tuple(parameters.tolist()))

    motion = drawn(moved)
    return Proposal(motion, drawn(forms) if limits.joint_side is not None else None)


def neighbour(proposal: Proposal, rng: np.random.Generator, distance: float) -> Proposal:
    """The same forms with other parameters, at most about `distance` away."""

    def moved(before: Input) -> Input:
        after = np.array(before.parameters) + distance * rng.standard_normal(PARAMETERS)
        return Input(before.form, tuple(np.clip(after, 0.0, 1.0).tolist()))

    beside = None if proposal.joint_side is None else moved(proposal.joint_side)
    return Proposal(moved(proposal.motion), beside)
