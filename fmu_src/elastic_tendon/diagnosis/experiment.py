"""The experiment that tells rival answers apart.

Motions are drawn at random among a few forms, the best of them improved, and the best of all
checked by full refits. An experiment is as good as it separates each two of the rivals, whichever
of them is right (Atkinson & Fedorov 1975, "several models").
"""

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations
from math import sqrt
from operator import attrgetter

import numpy as np

from elastic_tendon.actuator.motion_kind import MotionKind
from elastic_tendon.actuator.variables import SIGNALS
from elastic_tendon.comparison.residuals import Array, residuals_of, simulate_measurement
from elastic_tendon.comparison.simulated import SUFFIXES
from elastic_tendon.diagnosis.driving import drive_of, following
from elastic_tendon.diagnosis.experiment_text import Separated, experiment_text, undecidable_text
from elastic_tendon.diagnosis.limits import Limits, limits_of
from elastic_tendon.diagnosis.proposals import Proposal, neighbour, random_proposal
from elastic_tendon.diagnosis.result import Experiment
from elastic_tendon.diagnosis.separation import (
    Known,
    Refit,
    Rival,
    expected_power,
    known,
    left_over,
    noise,
    plausible,
    predict,
    refit,
)
from elastic_tendon.errors import ModelError, SimulationError
from elastic_tendon.estimation.fit import ShareProgress
from elastic_tendon.measurement import Measurement
from elastic_tendon.progress import Progress, silent
from elastic_tendon.simulation.work import Work, counted, enough

SEED = 20130506
DRAWN = 36  # motions drawn at random
KEPT, IMPROVED = 4, 6  # so many of them are improved, so often
SEARCH = DRAWN + KEPT * IMPROVED  # motions that are judged
DISTANCE = 0.2  # over which the parameters of a motion are first changed
SEARCH_SAMPLES = 2500  # enough to judge a motion by
ROUNDS_TO_FIT = 4  # in which a motion is made smaller until the springs bear it
# rivals that a drawn motion tells apart by less than this, or a full refit with less power, count
# as not told apart
SEPARABLE = 1.0
WORTH_IT = 0.8
# the experiment is repeated until it decides so surely, at most so often
SURE = 0.95
REPEATS = (1, 2, 3, 5, 8)
ENOUGH = 37.0  # noncentrality that decides with about that power
PLENTY = 0.95  # of all pairs decided, where none is in doubt any more
WORDS = "searching the experiment that decides"

Pair = tuple[int, int]  # places of two rivals


@dataclass(frozen=True)
class _Search:
    """What stays the same for all proposals.

    `time` (n,) s is coarser than the recordings, so `sigmas` are smaller than the noise of
    a sample by the factor `thinner`: few samples then tell as much as all of them.
    """

    limits: Limits
    rivals: tuple[Known, ...]
    sigmas: dict[str, float]
    time: Array
    thinner: float

    def measurement(self, proposal: Proposal, expected_by: int = 0) -> Measurement:
        """The proposal as a recording that shows zeros; a torque as a rival expects it."""
        courses = proposal.courses(self.time, self.limits)
        return _recording(self.rivals[expected_by], self.limits, self.time, courses, self.sigmas)


@dataclass(frozen=True)
class _Judged:
    """A proposal, and for each two rivals what a linear refit leaves of their difference, whichever
    of them is right."""

    proposal: Proposal
    left: Mapping[Pair, float]

    @property
    def worth(self) -> float:
        """About how many pairs it decides."""
        return sum(left / (left + ENOUGH) for left in self.left.values())

    @property
    def decides(self) -> bool:
        """Whether nothing better need be looked for."""
        return self.worth > PLENTY * len(self.left)

    @property
    def separable(self) -> list[Pair]:
        """Rivals that it may tell apart."""
        return [pair for pair, left in self.left.items() if left > SEPARABLE]


def next_experiment(
    rivals: Sequence[Rival],
    measurements: Sequence[Measurement],
    progress: Progress = silent,
) -> Experiment | str:
    """Propose the motion and load that best tell rival answers apart.

    It stays near what was recorded; where that leaves rivals undecided, it goes as far as the
    springs bear if that decides more. Where a torque drives the machine, it is that under which the
    answer named first follows the motion.

    Parameters
    ----------
    rivals : two or more, fitted to the same recordings
    measurements : these recordings; they set range, speed, load and sampling rate
    progress : called with words and the share of the work done, 0 to 1

    Returns
    -------
    Experiment; where none is likely to tell them apart, a text that says so and why

    Raises
    ------
    SimulationError : a rival cannot be simulated at rest
    """
    ids = [rival.id for rival in rivals]
    models = [rival.fit.model for rival in rivals]
    limits = limits_of(models, measurements)
    found: tuple[_Search, _Checked] | None = None
    for done, allowed in enumerate((limits, limits.widened())):
        search = _prepare(rivals, allowed)
        with counted(Work()):
            best = _best(search, partial(_tell, progress, done))
        if best is not None and (found is None or len(best.told) > len(found[1].told)):
            found = search, best
        if best is not None and len(best.told) == len(_pairs(rivals)):
            break
    if found is None:
        return undecidable_text(ids, models)
    experiment = _answer(*found, ids)
    return replace(experiment, text=models[0].motion.words(experiment.text))


def _pairs(rivals: Sequence[object]) -> list[Pair]:
    return list(combinations(range(len(rivals)), 2))


def _tell(progress: Progress, done: int, share: float) -> None:
    progress(WORDS, 0.5 * (done + share))


def experiment_csv(experiment: Experiment, motion: MotionKind = MotionKind.ROTARY) -> str:
    """Text of the file with the experiment, which `simulate` and a machine can run.

    Returns
    -------
    str; a row a sample, columns time_s, motor_position_rad, load_torque_Nm, or those of another
        interface, see `Experiment.columns`; of a machine that slides motor_position_m and so on
    """
    import pandas as pd

    columns = {
        name + SUFFIXES[motion.unit(SIGNALS[name].unit)]: values
        for name, values in experiment.columns.items()
    }
    return str(pd.DataFrame({"time_s": experiment.time, **columns}).to_csv(index=False))


def _prepare(rivals: Sequence[Rival], limits: Limits) -> _Search:
    samples = len(limits.sample_times())
    time = np.linspace(0.0, limits.duration, min(samples, SEARCH_SAMPLES))
    thinner = sqrt(len(time) / samples)
    sigmas = {name: thinner * sigma for name, sigma in noise(rivals).items()}
    start = limits.motion.start
    first = known(rivals[0], start)
    others = (known(rival, start, like=first) for rival in rivals[1:])
    return _Search(limits, (first, *others), sigmas, time, thinner)


def _recording(
    rival: Known, limits: Limits, time: Array, courses: tuple[Array, Array], signals: Iterable[str]
) -> Measurement:
    """The courses of a proposal as inputs of the interface, from a machine as the rival expects it;
    all signals show zeros."""
    kind, (motion, beside) = limits.kind, courses
    driving = {}
    if not kind.has_link:
        driving["joint_position"] = rival.model.transmission.motor_share * motion + beside
    recording = Measurement(
        name="proposal",
        time=time,
        motor_position=motion if kind.has_springs else np.zeros_like(time),
        signals={name: np.zeros_like(time) for name in signals},
        load_torque=beside if kind.has_link else None,
        kind=kind,
        driving=driving,
    )
    if drive_of(kind) is None:
        return recording
    torque = following(rival.model, recording, rival.initial, motion, limits.frequency)
    if kind.has_rotor:
        return replace(recording, driving=driving | {"motor_torque": torque})
    return replace(recording, load_torque=torque)


# ---- search --------------------------------------------------------------------------------


def _best(search: _Search, progress: ShareProgress) -> "_Checked | None":
    """The proposal that decides most, as often as it takes; None if it is not worth it."""
    found: list[_Checked] = []
    for judged in _judge_many(search, lambda share: progress(0.8 * share)):
        if judged.separable:
            found.append(_as_often_as_it_takes(search, judged))
            if len(found[-1].told) == len(judged.separable) or enough():
                break
    progress(1.0)
    best = max(found, key=lambda checked: len(checked.told), default=None)
    return best if best is not None and best.told else None


def _judge_many(search: _Search, progress: ShareProgress) -> list[_Judged]:
    """The best of motions drawn at random, and of neighbours of these, as far as work allows."""
    rng = np.random.default_rng(SEED)
    best: list[_Judged] = []
    for index in range(DRAWN):
        progress(index / SEARCH)
        least = best[-1].worth if len(best) == KEPT else 0.0
        best += _judge(search, random_proposal(rng, search.limits), least)
        best = sorted(best, key=attrgetter("worth"), reverse=True)[:KEPT]
        if best and (best[0].decides or enough()):
            return best
    if not best or not best[0].separable:
        return best
    for number, distance in enumerate(DISTANCE * 0.5 ** np.linspace(0.0, 3.0, IMPROVED)):
        progress((DRAWN + KEPT * number) / SEARCH)
        for place, kept in enumerate(best):
            for tried in _judge(search, neighbour(kept.proposal, rng, distance), kept.worth):
                best[place] = max(kept, tried, key=attrgetter("worth"))
            if enough():
                break
    return sorted(best, key=attrgetter("worth"), reverse=True)


def _judge(search: _Search, proposal: Proposal, least: float) -> list[_Judged]:
    """The proposal, as small as the springs demand, and its worth; empty if it cannot be run.

    What seems worth more than the least to a linear refit is judged by a full one: springs that
    fall slack a little later are another motion, and a parameter that makes up for it.
    """
    try:
        fitted = _fitted(search, proposal)
        if fitted is None:
            return []
        experiment = search.measurement(fitted)
        predictions = [predict(rival, experiment, search.sigmas) for rival in search.rivals]
    except (ModelError, SimulationError):
        return []

    def linear(pair: Pair) -> float:
        return min(
            left_over(predictions[right].signals, predictions[wrong], search.rivals[wrong])
            for right, wrong in (pair, pair[::-1])
        )

    def full(pair: Pair) -> float:
        lefts = (
            refit(predictions[right], search.rivals[wrong], experiment, search.sigmas)
            for right, wrong in (pair, pair[::-1])
        )
        first = next(lefts).noncentrality
        return first if first < SEPARABLE else min(first, next(lefts).noncentrality)

    judged = _Judged(fitted, {pair: linear(pair) for pair in _pairs(predictions)})
    for pair in judged.separable:
        if judged.worth <= least or enough():
            break
        judged = _Judged(fitted, {**judged.left, pair: full(pair)})
    return [judged]


def _fitted(search: _Search, proposal: Proposal) -> Proposal | None:
    """The proposal, made smaller until no rival's deflection or drive passes the limits."""
    for _ in range(ROUNDS_TO_FIT):
        used = _share_of_limits(search, proposal)
        if used <= 1.0:
            return proposal
        proposal = replace(proposal, scale=0.97 * proposal.scale / used)
    return None


def _share_of_limits(search: _Search, proposal: Proposal) -> float:
    """Largest deflection or torque of the drive that a rival expects, as a share of the limit."""
    low, high = search.limits.springs.deflection
    drive = drive_of(search.limits.kind)
    share = 0.0
    for place, rival in enumerate(search.rivals):
        experiment = search.measurement(proposal, place)
        if drive is not None:
            torque = float(np.abs(experiment.inputs[drive.torque]).max())
            share = max(share, torque / search.limits.drive)
        if search.limits.kind.has_springs:
            deflection = simulate_measurement(rival.model, experiment, rival.initial)["deflection"]
            share = max(
                share, deflection.max() / max(high, 1e-300), deflection.min() / min(low, -1e-300)
            )
    return float(share)


# ---- the answer ----------------------------------------------------------------------------


@dataclass(frozen=True)
class _Told:
    """Two rivals told apart: what the lesser of both full refits leaves, and the predicted
    probability that it decides, whichever of them is right."""

    pair: Pair
    left: Refit
    power: float


@dataclass(frozen=True)
class _Checked:
    """A proposal, made `repeats` times in one run, and the rivals that it tells apart."""

    proposal: Proposal
    repeats: int
    told: tuple[_Told, ...]

    @property
    def hardest(self) -> _Told:
        """The two that are told apart least surely."""
        return min(self.told, key=lambda told: (told.power, told.left.noncentrality))


def _as_often_as_it_takes(search: _Search, best: _Judged) -> _Checked:
    """The proposal, repeated until it decides; it ends as it begins, so it can follow on itself."""
    reachable = {pair for pair in best.separable if best.left[pair] * REPEATS[-1] > ENOUGH}
    for repeats in REPEATS:
        if repeats < REPEATS[-1] and any(best.left[pair] * repeats < ENOUGH for pair in reachable):
            continue
        checked = _checked(search, best, repeats)
        if reachable <= {told.pair for told in checked.told if told.power >= SURE}:
            break
    return checked


def _checked(search: _Search, best: _Judged, repeats: int) -> _Checked:
    experiment = search.measurement(best.proposal)
    sigmas = {name: sigma / sqrt(repeats) for name, sigma in search.sigmas.items()}
    predictions = [predict(rival, experiment, sigmas) for rival in search.rivals]
    expected = [plausible(rival, experiment, sigmas) for rival in search.rivals]

    def held_against(right: int, wrong: int) -> tuple[Refit, float]:
        left = refit(predictions[right], search.rivals[wrong], experiment, sigmas)
        signals, known_of_wrong = predictions[right].signals, search.rivals[wrong]
        full = left.noncentrality
        power = expected_power(expected[right], signals, predictions[wrong], known_of_wrong, full)
        return left, power

    told = []
    for pair in best.separable:
        (left, power), (other_left, other_power) = held_against(*pair), held_against(*pair[::-1])
        least = min(left, other_left, key=attrgetter("noncentrality"))
        told.append(_Told(pair, least, min(power, other_power)))
    worth_it = tuple(pair for pair in told if pair.power >= WORTH_IT)
    return _Checked(best.proposal, repeats, worth_it)


def _answer(search: _Search, best: _Checked, ids: Sequence[str]) -> Experiment:
    limits, proposal = search.limits, best.proposal
    motion, beside = proposal.courses(limits.sample_times(), limits)
    time = np.asarray(limits.step * np.arange(best.repeats * (len(motion) - 1) + 1))
    courses = (_repeated(motion, best.repeats), _repeated(beside, best.repeats))
    whole = _recording(search.rivals[0], limits, time, courses, search.sigmas)
    separated = _separated(search, best, ids)
    followed = {} if limits.kind.has_springs else {"joint_position": courses[0]}
    load = whole.load_torque
    return Experiment(
        text=experiment_text(limits, proposal, best.repeats, whole, separated),
        time=time,
        motor_position=whole.motor_position,
        load_torque=np.zeros_like(time) if load is None else load,
        power=best.hardest.power,
        signal=separated.signal,
        predictions=_predictions(search, whole, separated.signal),
        kind=limits.kind,
        driving={**whole.driving, **followed},
    )


def _repeated(course: Array, repeats: int) -> Array:
    """A course as often as that; the last sample of one run is the first of the next."""
    return np.concatenate([*[course[:-1]] * (repeats - 1), course])


def _predictions(search: _Search, whole: Measurement, signal: str) -> dict[str, Array]:
    """What the rivals predict of a signal; without any that cannot be simulated so finely."""
    found = {}
    for rival in search.rivals:
        with suppress(SimulationError):
            trajectory = simulate_measurement(rival.model, whole, rival.initial)
            found[rival.rival.id] = residuals_of(trajectory, whole)[signal]
    return found


def _separated(search: _Search, best: _Checked, ids: Sequence[str]) -> Separated:
    hardest = best.hardest
    signals = hardest.left.difference.reshape(len(search.sigmas), -1)
    shows = int(np.argmax(np.sum(signals**2, axis=1)))
    name = list(search.sigmas)[shows]
    # back from the noise of the thinned and repeated samples
    differences = signals[shows] * search.sigmas[name] / sqrt(best.repeats)
    largest = int(np.argmax(np.abs(differences)))
    apart = {told.pair for told in best.told}
    left_open = [pair for pair in _pairs(ids) if pair not in apart]
    return Separated(
        ids=(ids[hardest.pair[0]], ids[hardest.pair[1]]),
        first=ids[0],
        easier=len(best.told) - 1,
        left_open=tuple((ids[first], ids[second]) for first, second in left_open),
        signal=name,
        largest=float(abs(differences[largest])),
        at=float(search.time[largest]),
        noise=search.sigmas[name] / search.thinner,
        together=sqrt(hardest.left.noncentrality),
        power=hardest.power,
    )
