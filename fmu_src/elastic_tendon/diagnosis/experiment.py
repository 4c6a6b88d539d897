"""The experiment that tells rival answers apart.

Motions are drawn at random among a few forms, the best of them improved, and the best of all
checked by full refits. An experiment is as good as it separates the pair that it separates worst,
whichever of the two is right; pairs that no motion separates do not take part.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import permutations
from math import sqrt
from typing import TYPE_CHECKING

import numpy as np

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
from elastic_tendon.identify.fit import Progress
from elastic_tendon.identify.residuals import Array, simulate_measurement
from elastic_tendon.measurement import Measurement

if TYPE_CHECKING:
    import pandas as pd

Report = Callable[[str, float], None]  # what is being done, and the share of it that is done
Pair = tuple[int, int]  # numbers of the rival that is right and of the one that is wrong

SEED = 20130506
# simulations with derivatives in all; shared among the rivals, so that time does not grow
SEARCH = 120
DRAWN = 0.6  # share of them that is spent on motions drawn at random
KEPT = 4  # so many motions are improved ...
CHECKED = 1  # ... and so many of all are checked by full refits
DISTANCE = 0.2  # over which the numbers of a motion are first changed
SEARCH_SAMPLES = 2500  # enough to judge a motion by
ROUNDS_TO_FIT = 4  # in which a motion is made smaller until the springs bear it
# a pair that a drawn motion tells apart by less than this, or a full refit with less power, is
# left out of the worst case
SEPARABLE = 1.0
WORTH_IT = 0.8
# the experiment is repeated until it decides so surely, at most so often
SURE = 0.95
REPEATS = (2, 3, 5, 8)
FIRST_SHARE = 0.6  # of the work; the rest is to find what else would decide
WORDS = "searching the experiment that decides"


@dataclass(frozen=True)
class Undecidable:
    """No experiment within the limits tells the answers apart; `text` says so and why."""

    text: str


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

    @property
    def pairs(self) -> list[Pair]:
        """All pairs, either one as the right one."""
        return list(permutations(range(len(self.rivals)), 2))

    def measurement(self, proposal: Proposal) -> Measurement:
        """The proposal as a recording that shows zeros."""
        return _measurement(self.time, *proposal.inputs(self.time, self.limits), self.sigmas)


@dataclass(frozen=True)
class _Judged:
    """A proposal and what it leaves of each pair's difference."""

    proposal: Proposal
    noncentralities: dict[Pair, float]

    def worst(self, pairs: Sequence[Pair]) -> float:
        """Least of what is left over some pairs."""
        return min((self.noncentralities[pair] for pair in pairs), default=0.0)


def next_experiment(
    rivals: Sequence[Rival],
    measurements: Sequence[Measurement],
    report: Report = lambda _text, _share: None,
) -> Experiment | Undecidable:
    """Propose the motion of motor and load that best tells rival answers apart.

    Parameters
    ----------
    rivals : at least two, fitted to the same recordings
    measurements : these recordings; they set range, speed, load and sampling rate
    report : called with words and the share of the work done, 0 to 1

    Returns
    -------
    Experiment, or Undecidable where none found is likely to tell any two of them apart

    Raises
    ------
    ValueError : fewer than two rivals
    SimulationError : a rival cannot be simulated at rest
    """
    if len(rivals) < 2:
        raise ValueError(f"{len(rivals)} rivals; at least two are needed to be told apart")
    ids = [rival.id for rival in rivals]
    models = [rival.fit.model for rival in rivals]
    limits = limits_of(models, measurements)
    search = _prepare(rivals, limits)
    best = _best(search, lambda share: report(WORDS, FIRST_SHARE * share))
    if best is not None:
        return _answer(search, best, ids)
    wider = limits.widened()
    remaining = 1.0 - FIRST_SHARE
    with_more = _best(
        _prepare(rivals, wider), lambda share: report(WORDS, FIRST_SHARE + remaining * share)
    )
    return Undecidable(undecidable_text(ids, models, wider if with_more is not None else None))


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


def _prepare(rivals: Sequence[Rival], limits: Limits) -> _Search:
    samples = len(limits.sample_times())
    time = np.linspace(0.0, limits.duration, min(samples, SEARCH_SAMPLES))
    thinner = sqrt(len(time) / samples)
    sigmas = {name: thinner * sigma for name, sigma in noise(rivals).items()}
    rest = _measurement(time, np.full_like(time, limits.motor.start), np.zeros_like(time), sigmas)
    return _Search(limits, tuple(known(rival, rest) for rival in rivals), sigmas, time, thinner)


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


def _best(search: _Search, progress: Progress) -> "_Checked | None":
    """The proposal that decides most, as often as it takes; None if it is not worth it."""
    judged = _judge_many(search, lambda share: progress(0.8 * share))
    separable = _separable(search, judged)
    if not separable:
        return None
    ranked = sorted(judged, key=lambda one: one.worst(separable), reverse=True)
    checked = []
    for index, one in enumerate(ranked[:CHECKED]):
        progress(0.8 + 0.15 * index / CHECKED)
        checked.append(_checked(search, one.proposal, separable))
    progress(0.95)
    best = _repeated(search, max(checked, key=_Checked.worth), separable)
    progress(1.0)
    return best if best.decided else None


def _judge_many(search: _Search, progress: Progress) -> list[_Judged]:
    """Motions drawn at random, then neighbours of the best."""
    rng = np.random.default_rng(SEED)
    budget = max(SEARCH // len(search.rivals), 4 * KEPT)
    drawn = round(DRAWN * budget)
    judged: list[_Judged] = []
    for index in range(drawn):
        progress(index / budget)
        judged += _judge(search, random_proposal(rng, search.limits))
    separable = _separable(search, judged)
    best = sorted(judged, key=lambda one: one.worst(separable), reverse=True)[:KEPT]
    distances = DISTANCE * 0.5 ** np.linspace(0.0, 3.0, (budget - drawn) // KEPT)
    for distance in distances if separable else ():
        progress(len(judged) / budget)
        for place, one in enumerate(best):
            for tried in _judge(search, neighbour(one.proposal, rng, distance)):
                judged.append(tried)
                if tried.worst(separable) > one.worst(separable):
                    best[place] = tried
    return judged


def _separable(search: _Search, judged: Sequence[_Judged]) -> list[Pair]:
    """Pairs that at least one motion separates, whichever of the two is right."""

    def most(pair: Pair) -> float:
        return max(
            (min(one.noncentralities[pair], one.noncentralities[pair[::-1]]) for one in judged),
            default=0.0,
        )

    return [pair for pair in search.pairs if most(pair) > SEPARABLE]


def _judge(search: _Search, proposal: Proposal) -> list[_Judged]:
    """The proposal, as small as the springs demand, and its worth; empty if it cannot be run."""
    try:
        fitted = _fitted(search, proposal)
        if fitted is None:
            return []
        experiment = search.measurement(fitted)
        predictions = [predict(one, experiment, search.sigmas) for one in search.rivals]
    except (ModelError, SimulationError):
        return []
    left = {
        (right, wrong): left_over(
            predictions[right].signals, predictions[wrong], search.rivals[wrong]
        )
        for right, wrong in search.pairs
    }
    return [_Judged(fitted, left)]


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
    for one in search.rivals:
        deflection = simulate_measurement(one.model, experiment, one.initial)["deflection"]
        share = max(
            share, deflection.max() / max(high, 1e-300), deflection.min() / min(low, -1e-300)
        )
    return float(share)


# ---- the answer ----------------------------------------------------------------------------


@dataclass(frozen=True)
class _Checked:
    """A proposal, made `repeats` times in one run, and what full refits leave of each pair."""

    proposal: Proposal
    repeats: int
    refits: dict[Pair, Refit]
    powers: dict[Pair, float]

    def power(self, pair: Pair) -> float:
        """Predicted probability that a pair is decided, whichever of the two is right."""
        return min(self.powers[pair], self.powers[pair[::-1]])

    @property
    def pairs(self) -> list[Pair]:
        """Pairs that were checked, each once."""
        return [pair for pair in self.refits if pair[0] < pair[1]]

    @property
    def decided(self) -> list[Pair]:
        """Pairs that are likely to be decided, each once."""
        return [pair for pair in self.pairs if self.power(pair) >= WORTH_IT]

    def worth(self) -> tuple[float, float]:
        """How many pairs it decides on average, then how well the worst of them."""
        expected = sum(self.power(pair) for pair in self.pairs)
        return round(expected, 2), min(one.noncentrality for one in self.refits.values())


def _checked(
    search: _Search, proposal: Proposal, pairs: Sequence[Pair], repeats: int = 1
) -> _Checked:
    experiment = search.measurement(proposal)
    sigmas = {name: sigma / sqrt(repeats) for name, sigma in search.sigmas.items()}
    predictions = [predict(one, experiment, sigmas) for one in search.rivals]
    refits = {
        (right, wrong): refit(predictions[right], search.rivals[wrong], experiment, sigmas)
        for right, wrong in pairs
    }
    expected = [plausible(one, experiment, sigmas) for one in search.rivals]
    powers = {
        (right, wrong): expected_power(
            expected[right],
            predictions[right].signals,
            predictions[wrong],
            search.rivals[wrong],
            refits[right, wrong].noncentrality,
        )
        for right, wrong in pairs
    }
    return _Checked(proposal, repeats, refits, powers)


def _repeated(search: _Search, once: _Checked, pairs: Sequence[Pair]) -> _Checked:
    """The proposal as often as it takes; it ends as it begins, so it can follow on itself."""
    best = once
    for repeats in REPEATS:
        if all(best.power(pair) >= SURE for pair in best.pairs):
            break
        best = _checked(search, once.proposal, pairs, repeats)
    return best


def _answer(search: _Search, best: _Checked, ids: Sequence[str]) -> Experiment:
    limits = search.limits
    once = best.proposal.inputs(limits.sample_times(), limits)
    # the last sample of one run is the first of the next
    inputs = [np.concatenate([*[one[:-1]] * (best.repeats - 1), one]) for one in once]
    others = [pair for pair in search.pairs if pair[0] < pair[1] and pair not in best.decided]
    return Experiment(
        text=experiment_text(
            *(limits, best.proposal, best.repeats, once),
            separated=[_separated(search, best, pair, ids) for pair in best.decided],
            left_out=[(ids[one], ids[other]) for one, other in others],
        ),
        time=np.asarray(limits.step * np.arange(len(inputs[0]))),
        motor_position=inputs[0],
        load_torque=inputs[1],
        power=min(best.power(pair) for pair in best.decided),
    )


def _separated(search: _Search, best: _Checked, pair: Pair, ids: Sequence[str]) -> Separated:
    left = min((best.refits[one] for one in (pair, pair[::-1])), key=lambda one: one.noncentrality)
    signals = left.difference.reshape(len(search.sigmas), -1)
    told = int(np.argmax(np.sum(signals**2, axis=1)))
    name = list(search.sigmas)[told]
    # back from the noise of the thinned and repeated samples
    differences = signals[told] * search.sigmas[name] / sqrt(best.repeats)
    largest = int(np.argmax(np.abs(differences)))
    return Separated(
        ids=(ids[pair[0]], ids[pair[1]]),
        signal=name,
        largest=float(abs(differences[largest])),
        at=float(search.time[largest]),
        noise=search.sigmas[name] / search.thinner,
        together=sqrt(left.noncentrality),
        power=best.power(pair),
    )
