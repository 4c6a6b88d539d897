"""The experiment that tells two rival answers apart.

Motions are drawn at random among a few forms, the best of them improved, and the best of all
checked by full refits. An experiment is as good as it separates the two whichever of them is right.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import sqrt
from operator import attrgetter
from typing import TYPE_CHECKING

import numpy as np

from elastic_tendon.comparison.residuals import Array, simulate_measurement
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

if TYPE_CHECKING:
    import pandas as pd

SEED = 20130506
SEARCH = 60  # simulations of each rival with derivatives
DRAWN = 36  # of them that are spent on motions drawn at random
KEPT = 4  # so many motions are improved
DISTANCE = 0.2  # over which the parameters of a motion are first changed
SEARCH_SAMPLES = 2500  # enough to judge a motion by
ROUNDS_TO_FIT = 4  # in which a motion is made smaller until the springs bear it
# a drawn motion that tells the rivals apart by less than this, or a full refit with less power, is
# not proposed
SEPARABLE = 1.0
WORTH_IT = 0.8
# the experiment is repeated until it decides so surely, at most so often
SURE = 0.95
REPEATS = (2, 3, 5, 8)
WORDS = "searching the experiment that decides"
EITHER = ((0, 1), (1, 0))  # index of the rival that is right and of the one that is wrong


@dataclass(frozen=True)
class _Search:
    """What stays the same for all proposals.

    `time` (n,) s is coarser than the recordings, so `sigmas` are smaller than the noise of
    a sample by the factor `thinner`: few samples then tell as much as all of them.
    """

    limits: Limits
    rivals: tuple[Known, Known]
    sigmas: dict[str, float]
    time: Array
    thinner: float

    def measurement(self, proposal: Proposal) -> Measurement:
        """The proposal as a recording that shows zeros."""
        return _measurement(self.time, *proposal.inputs(self.time, self.limits), self.sigmas)


@dataclass(frozen=True)
class _Judged:
    """A proposal, and what a linear refit leaves of the difference, whichever rival is right."""

    proposal: Proposal
    left: float


def next_experiment(
    rivals: tuple[Rival, Rival],
    measurements: Sequence[Measurement],
    progress: Progress = silent,
) -> Experiment | str:
    """Propose the motion of motor and load that best tells two rival answers apart.

    It stays near what was recorded; where nothing there decides, it goes as far as the springs
    bear.

    Parameters
    ----------
    rivals : fitted to the same recordings
    measurements : these recordings; they set range, speed, load and sampling rate
    progress : called with words and the share of the work done, 0 to 1

    Returns
    -------
    Experiment; where none is likely to tell them apart, a text that says so and why

    Raises
    ------
    SimulationError : a rival cannot be simulated at rest
    """
    ids = rivals[0].id, rivals[1].id
    models = [rival.fit.model for rival in rivals]
    limits = limits_of(models, measurements)
    for done, allowed in enumerate((limits, limits.widened())):
        search = _prepare(rivals, allowed)
        best = _best(search, partial(_tell, progress, done))
        if best is not None:
            return _answer(search, best, ids)
    return undecidable_text(ids, models)


def _tell(progress: Progress, done: int, share: float) -> None:
    progress(WORDS, 0.5 * (done + share))


def experiment_table(experiment: Experiment) -> "pd.DataFrame":
    """The experiment as a file that `simulate` and a machine can run.

    Returns
    -------
    DataFrame; columns time_s, motor_position_rad, load_torque_Nm
    """
    import pandas as pd

    return pd.DataFrame(
        {
            "time_s": experiment.time,
            "motor_position_rad": experiment.motor_position,
            "load_torque_Nm": experiment.load_torque,
        }
    )


def _prepare(rivals: tuple[Rival, Rival], limits: Limits) -> _Search:
    samples = len(limits.sample_times())
    time = np.linspace(0.0, limits.duration, min(samples, SEARCH_SAMPLES))
    thinner = sqrt(len(time) / samples)
    sigmas = {name: thinner * sigma for name, sigma in noise(rivals).items()}
    rest = _measurement(time, np.full_like(time, limits.motor.start), np.zeros_like(time), sigmas)
    both = known(rivals[0], rest), known(rivals[1], rest)
    return _Search(limits, both, sigmas, time, thinner)


def _measurement(
    time: Array, motor_position: Array, load_torque: Array, signals: Iterable[str]
) -> Measurement:
    return Measurement(
        name="proposal",
        time=time,
        motor_position=motor_position,
        signals={name: np.zeros_like(time) for name in signals},
        load_torque=load_torque,
    )


# ---- search --------------------------------------------------------------------------------


def _best(search: _Search, progress: ShareProgress) -> "_Checked | None":
    """The proposal that decides most, as often as it takes; None if it is not worth it."""
    judged = _judge_many(search, lambda share: progress(0.8 * share))
    best = max(judged, key=attrgetter("left"), default=None)
    if best is None or best.left <= SEPARABLE:
        return None
    progress(0.8)
    once = _checked(search, best.proposal)
    progress(0.95)
    repeated = _repeated(search, once)
    progress(1.0)
    return repeated if repeated.power >= WORTH_IT else None


def _judge_many(search: _Search, progress: ShareProgress) -> list[_Judged]:
    """Motions drawn at random, then neighbours of the best."""
    rng = np.random.default_rng(SEED)
    judged: list[_Judged] = []
    for index in range(DRAWN):
        progress(index / SEARCH)
        judged += _judge(search, random_proposal(rng, search.limits))
    best = sorted(judged, key=attrgetter("left"), reverse=True)[:KEPT]
    if not best or best[0].left <= SEPARABLE:
        return judged
    for distance in DISTANCE * 0.5 ** np.linspace(0.0, 3.0, (SEARCH - DRAWN) // KEPT):
        progress(len(judged) / SEARCH)
        for place, kept in enumerate(best):
            for tried in _judge(search, neighbour(kept.proposal, rng, distance)):
                judged.append(tried)
                if tried.left > kept.left:
                    best[place] = tried
    return judged


def _judge(search: _Search, proposal: Proposal) -> list[_Judged]:
    """The proposal, as small as the springs demand, and its worth; empty if it cannot be run."""
    try:
        fitted = _fitted(search, proposal)
        if fitted is None:
            return []
        experiment = search.measurement(fitted)
        predictions = [predict(rival, experiment, search.sigmas) for rival in search.rivals]
    except (ModelError, SimulationError):
        return []
    left = (
        left_over(predictions[right].signals, predictions[wrong], search.rivals[wrong])
        for right, wrong in EITHER
    )
    return [_Judged(fitted, min(left))]


def _fitted(search: _Search, proposal: Proposal) -> Proposal | None:
    """The proposal, made smaller until no rival's deflection passes the limits."""
    for _ in range(ROUNDS_TO_FIT):
        used = _share_of_deflection(search, proposal)
        if used <= 1.0:
            return proposal
        proposal = replace(proposal, scale=0.97 * proposal.scale / used)
    return None


def _share_of_deflection(search: _Search, proposal: Proposal) -> float:
    """Largest deflection that any rival expects, as a share of what may be."""
    low, high = search.limits.deflection
    experiment = search.measurement(proposal)
    share = 0.0
    for rival in search.rivals:
        deflection = simulate_measurement(rival.model, experiment, rival.initial)["deflection"]
        share = max(
            share, deflection.max() / max(high, 1e-300), deflection.min() / min(low, -1e-300)
        )
    return float(share)


# ---- the answer ----------------------------------------------------------------------------


@dataclass(frozen=True)
class _Checked:
    """A proposal, made `repeats` times in one run, what the lesser of both full refits leaves, and
    the predicted probability that it decides, whichever rival is right."""

    proposal: Proposal
    repeats: int
    left: Refit
    power: float


def _checked(search: _Search, proposal: Proposal, repeats: int = 1) -> _Checked:
    experiment = search.measurement(proposal)
    sigmas = {name: sigma / sqrt(repeats) for name, sigma in search.sigmas.items()}
    predictions = [predict(rival, experiment, sigmas) for rival in search.rivals]
    expected = [plausible(rival, experiment, sigmas) for rival in search.rivals]
    refits = [
        refit(predictions[right], search.rivals[wrong], experiment, sigmas)
        for right, wrong in EITHER
    ]
    powers = [
        expected_power(
            expected[right],
            predictions[right].signals,
            predictions[wrong],
            search.rivals[wrong],
            left.noncentrality,
        )
        for (right, wrong), left in zip(EITHER, refits, strict=True)
    ]
    least = min(refits, key=attrgetter("noncentrality"))
    return _Checked(proposal, repeats, least, min(powers))


def _repeated(search: _Search, once: _Checked) -> _Checked:
    """The proposal as often as it takes; it ends as it begins, so it can follow on itself."""
    best = once
    for repeats in REPEATS:
        if best.power >= SURE:
            break
        best = _checked(search, once.proposal, repeats)
    return best


def _answer(search: _Search, best: _Checked, ids: tuple[str, str]) -> Experiment:
    limits = search.limits
    once = best.proposal.inputs(limits.sample_times(), limits)
    # the last sample of one run is the first of the next
    inputs = [np.concatenate([*[values[:-1]] * (best.repeats - 1), values]) for values in once]
    separated = _separated(search, best, ids)
    return Experiment(
        text=experiment_text(limits, best.proposal, best.repeats, once, separated),
        time=np.asarray(limits.step * np.arange(len(inputs[0]))),
        motor_position=inputs[0],
        load_torque=inputs[1],
        power=best.power,
    )


def _separated(search: _Search, best: _Checked, ids: tuple[str, str]) -> Separated:
    signals = best.left.difference.reshape(len(search.sigmas), -1)
    told = int(np.argmax(np.sum(signals**2, axis=1)))
    name = list(search.sigmas)[told]
    # back from the noise of the thinned and repeated samples
    differences = signals[told] * search.sigmas[name] / sqrt(best.repeats)
    largest = int(np.argmax(np.abs(differences)))
    return Separated(
        ids=ids,
        signal=name,
        largest=float(abs(differences[largest])),
        at=float(search.time[largest]),
        noise=search.sigmas[name] / search.thinner,
        together=sqrt(best.left.noncentrality),
        power=best.power,
    )
