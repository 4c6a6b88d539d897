"""The evidence for an answer: one number, the same in every table, figure and choice.

The Bayesian information criterion (BIC): minus twice the log-likelihood with what a parameter
costs, so that less is better and a difference of 10 decides (Kass & Raftery, Journal of the
American Statistical Association 90, 1995)::

    N misfit(mean square) + n misfit(held-out mean square) + prior + implausibility + k log(N)

Errors are in units of the noise floor. `N` and `n` count the independent facts that the errors of
the best answer hold: samples that err together are one.
"""

from collections.abc import Container, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from math import exp, log

import numpy as np

from elastic_tendon import effects
from elastic_tendon.actuator.parameters import Model, typical_value
from elastic_tendon.comparison.residuals import Array
from elastic_tendon.diagnosis.answer import Answer
from elastic_tendon.diagnosis.held_out import EXPLAINED, heldout_errors
from elastic_tendon.diagnosis.sets import in_order, simpler
from elastic_tendon.effects.base import Parameter, Spread
from elastic_tendon.estimation.ladder import LEAST_SHARE_OF_NOISE
from elastic_tendon.estimation.stretches import independent_facts
from elastic_tendon.measurement import Measurement

DECISIVE = 10.0  # difference of evidence below which data do not decide
HARDLY = 2.0  # ... that is not worth more than a bare mention
# ... between an effect and one in its place: chance alone makes up to twice of what does not decide
DECISIVE_IN_PLACE = 20.0
AUDIBLE = 0.15  # RMS of what an effect explains, in units of the noise or of what is left ...
# ... and where more is left than this mean square: less than this may be some of the unknown
MUCH, AUDIBLE_BESIDE = 2.25, 0.5
WORSE = 1.01  # times a held-out mean square that is no worse
# times by which the mean square of the fitted recordings falls, and power of it by which held-out
# ones of which neither answer explains much may then rise: what both lack rules there
FAR_LESS, SOMEWHAT = 4.0, 0.25
LESS_THAN_NOISE = 0.9  # held-out mean square below which chance hardly leads
AT_NOISE = 1.1  # mean square up to which an answer leaves nothing to explain
HELDOUT_AT_NOISE = 1.5  # held-out mean square up to which nothing but noise is left
# times by which the mean square falls for what is no chance
SURELY = 3.0
HOPELESS = 1.5  # times the mean square of a better answer, from which no answer can win any more
LASTING = 0.5  # part of the explained share of the fitted errors, at least, of held-out ones too
IMPLAUSIBLE = 10.0  # what a value costs that no real actuator has
WORSE_ELSEWHERE = "makes the error on held-out data larger"
FADES_IN_TIME = "explains far less on stretches of time that are left out of the fit"
FADES = "explains far less on held-out data than on the fitted"
TOO_LITTLE = "explains too little for anybody to hear of it"
PLAUSIBLE = 30.0  # times the typical value, up to which one is plausible
UNKNOWN = 4.0  # facts that the data are worth where something unknown shapes what is left


@dataclass
class Evidence:
    """Judges answers to the same question; remembers what they err on held-out recordings."""

    heldout: tuple[Measurement, ...]
    # least that any answer leaves, mean square of the fitted recordings times that of held-out ones
    _least: float = np.inf
    _errors: dict[int, tuple[Answer, Array]] = field(default_factory=dict, repr=False)

    def heldout_errors(self, answer: Answer) -> Array:
        """Errors (n,) on recordings that were not fitted, see `heldout_errors`."""
        key = id(answer)
        if key not in self._errors:
            hopeless = min(EXPLAINED, HOPELESS * self._least)
            errors = heldout_errors(answer.result, self.heldout, hopeless)
            self._errors[key] = (answer, errors)
        return self._errors[key][1]

    def expect_like(self, answers: Iterable[Answer]) -> None:
        """Ask little from now on of answers that leave far more than one of these: nothing that
        held-out recordings may say makes up for it."""
        for answer in answers:
            left = answer.mean_square * max(self.heldout_square(answer), 1.0)
            self._least = min(self._least, left)

    @property
    def far_more(self) -> float:
        """Mean square of the fitted recordings that no effect in doubt would leave without it;
        infinite while the best leaves much, for then nobody knows what it may lead to."""
        return SURELY * self._least if self._least <= MUCH else np.inf

    def of(self, answers: Sequence[Answer], among: Sequence[Answer] = ()) -> list[float]:
        """Evidence of each answer, in one scale; lower is better.

        Parameters
        ----------
        answers : Answer to the same recordings
        among : those of which the best tells how many independent facts there are; these, if none

        Returns
        -------
        list of float, one for each
        """
        if not answers:
            return []
        among = among or answers
        facts = self.facts(among)
        judged = 0.0
        if self.heldout:
            judged = self._judged(min(among, key=self.heldout_square))
        return [self._of(answer, facts, judged) for answer in answers]

    def of_fitted(self, answers: Sequence[Answer]) -> list[float]:
        """Evidence of each answer by the fitted recordings alone, see `of`."""
        facts = self.facts(answers)
        return [_fitted(answer, facts) for answer in answers]

    def likeliest(self, answers: Sequence[Answer]) -> Answer:
        """The best of several refits of one set, each of which may have left what is plausible.

        Held-out recordings are asked only of those that would be the best if they left less than
        noise there.
        """
        fitted = self.of_fitted(answers)
        first = answers[int(np.argmin(fitted))]
        room = 0.0
        if self.heldout:
            gain = max(misfit(self.heldout_square(first)) - misfit(LESS_THAN_NOISE), 0.0)
            room = self._judged(first) * gain
        near = [
            answer
            for answer, value in zip(answers, fitted, strict=True)
            if value <= min(fitted) + room
        ]
        return near[int(np.argmin(self.of(near)))]

    def facts(self, answers: Sequence[Answer]) -> float:
        """Number of independent facts that the errors of the best of some answers hold."""
        best = min(answers, key=lambda answer: _mean_square(answer.floored))
        return max(_facts(best, best.result.problem.measurements, best.floored), 2.0)

    def heldout_square(self, answer: Answer) -> float:
        """Mean square error on held-out recordings, in units of the noise; 0 without any."""
        return _mean_square(self.heldout_errors(answer)) if self.heldout else 0.0

    def _of(self, answer: Answer, facts: float, judged: float) -> float:
        value = _fitted(answer, facts)
        if self.heldout:
            square = self.heldout_square(answer)
            value += judged * misfit(square) if np.isfinite(square) else np.inf
        return value

    def _judged(self, answer: Answer) -> float:
        """Number of independent facts that an answer's held-out errors hold; 1 without any."""
        errors = self.heldout_errors(answer)
        return _facts(answer, self.heldout, errors) if np.isfinite(errors).all() else 1.0

    def allowed(
        self, answers: Sequence[Answer], refused: Container[tuple[str, ...]] = ()
    ) -> list[Answer]:
        """Answers that may be chosen: none that bring what nobody would hear of, or err more on
        held-out recordings than with fewer effects.

        Parameters
        ----------
        answers : Answer to the same recordings, that without effects among them
        refused : sets of effects that are left out too
        """
        return [
            answer
            for answer in answers
            if answer.added not in refused and not self.refusal(answer, answers)
        ]

    def refusal(self, answer: Answer, answers: Sequence[Answer]) -> str:
        """Why an answer may not be chosen among these, "" where it may."""
        if not audible(answer, [part for part in answers if not self._tells(part, answer)]):
            return TOO_LITTLE
        return "" if self.lasting(answer, answers) else WORSE_ELSEWHERE

    def _tells(self, part: Answer, answer: Answer) -> bool:
        """Whether held-out recordings, if not the fitted ones, tell what an answer has beside
        another, and it is more than zeros or loads of their own."""
        new = set(answer.added) - set(part.added)
        if all(effects.BY_ID[effect_id].of_recording for effect_id in new):
            return False
        before = self.heldout_square(part)
        return MUCH < before < np.inf and FAR_LESS * self.heldout_square(answer) < before

    def best(self, answers: Sequence[Answer]) -> Answer:
        """The simplest of those that cannot be told from the best, plausible ones before others;
        of equally simple ones the likeliest, and of those about as likely the most common."""
        values = self.of(answers)
        near = [  # also where all of them are infinite
            (value, answer)
            for answer, value in zip(answers, values, strict=True)
            if value <= min(values) + DECISIVE
        ]
        simplest = min(_simplicity(answer) for _, answer in near)
        equals = [pair for pair in near if _simplicity(pair[1]) == simplest]
        least = min(value for value, _ in equals)
        alike = [answer for value, answer in equals if value <= least + HARDLY]
        order = list(effects.BY_ID)  # the catalogue begins with what is most common
        return min(alike, key=lambda answer: sorted(map(order.index, answer.added)))

    def lasting(self, answer: Answer, answers: Sequence[Answer]) -> bool:
        """Whether held-out recordings are met no worse than with fewer of the effects."""
        return all(
            self.heldout_square(answer) <= WORSE * self.heldout_square(part)
            or self.says_little(part, answer)
            for part in answers
            if set(part.added) < set(answer.added)
        )

    def says_little(self, part: Answer, answer: Answer) -> bool:
        """Whether held-out recordings say little of what an answer has beside another, though they
        are met somewhat worse: it leaves far less of the fitted ones, and neither explains them."""
        before, own = self.heldout_square(part), self.heldout_square(answer)
        gain = _mean_square(part.floored) / _mean_square(answer.floored)
        return before > MUCH and gain > FAR_LESS and own < gain**SOMEWHAT * before

    def fades(self, answer: Answer, base: Answer) -> bool:
        """Whether an answer leaves more than noise on held-out recordings and explains far less
        there, beside a base, than of the fitted ones: then it stands for something else.

        Unless it brings the fitted ones from far away to the noise, which nothing else would: then
        the held-out recordings have something more.
        """
        own, left = self.heldout_square(answer), _mean_square(answer.floored)
        before = _mean_square(base.floored)
        if own <= HELDOUT_AT_NOISE or (left <= AT_NOISE and before > FAR_LESS * left):
            return False
        return explained(self.heldout_square(base), own) < LASTING * explained(before, left)


def _simplicity(answer: Answer) -> tuple[int, int, int]:
    """Less is simpler: values that hardly can be, parameters, effects."""
    return len(implausible_values(answer)), answer.complexity, len(answer.added)


def _fitted(answer: Answer, facts: float) -> float:
    """The evidence but for held-out recordings."""
    value = facts * misfit(_mean_square(answer.floored)) + answer.implausibility
    value += IMPLAUSIBLE * len(implausible_values(answer))
    return value + answer.complexity * log(facts)


def misfit(square: float) -> float:
    """What a mean square error costs for each fact, in units of the noise's.

    Beyond the noise its size is unknown, and its logarithm counts. Within, the noise is known, and
    less counts less: errors of an encoder's rounding do not grow less likely towards its step.
    """
    return log(square) if square > 1.0 else square - 1.0


def audible(answer: Answer, answers: Sequence[Answer]) -> bool:
    """Whether an answer explains so much more than each with fewer of its effects that anybody
    would hear of it, whatever the number of samples makes significant."""
    own = _mean_square(answer.floored)
    unknown = max(map(_unknown_noise, answer.result.problem.measurements), default=0.0)
    # beside something unknown a richer law of the same thing has to earn its parameters so too
    beside = own > MUCH or (unknown > AUDIBLE**2 and own > AT_NOISE)
    laws = set(simpler(in_order(answer.added))) if beside else set()
    return all(
        worth_hearing(_mean_square(part.floored), own, unknown)
        for part in answers
        if set(part.added) < set(answer.added) or part.added in laws
    )


def _unknown_noise(recording: Measurement) -> float:
    """Share of the variance of the noise that was given of which nobody knows the shape, 0 to 1."""
    shares = (floor.white_share for floor in recording.noise.values())
    return 0.0 if recording.static else 1.0 - min(shares, default=1.0)


def worth_hearing(before: float, after: float, unknown_noise: float = 0.0) -> bool:
    """Whether anybody would hear of what lowers one mean square to another, in units of the
    noise's; an effect may stand for all of the noise whose shape is unknown, a share from 0 to 1.
    """
    least = AUDIBLE_BESIDE if after > MUCH else max(AUDIBLE, unknown_noise**0.5)
    return before - after >= min(least, AUDIBLE_BESIDE) ** 2 * max(after, 1.0)


def explained(before: float, after: float) -> float:
    """Share, 0 to 1, of what a mean square holds beside the noise that another lacks."""
    gain = max(before - after, 0.0)
    return gain / max(before - 1.0, gain) if gain else 0.0


def probabilities(values: Sequence[float]) -> list[float]:
    """Weight of each answer among all, from their evidence."""
    least = min(values, default=0.0)
    beyond = [value - least if value > least else 0.0 for value in values]  # all may be infinite
    weights = [exp(-0.5 * min(part, 1400.0)) for part in beyond]
    return [weight / sum(weights) for weight in weights]


def beside_unknown(without: float, left: float) -> float:
    """Most that the probability of an effect may be where something unknown is left, 0 to 1.

    An effect may then stand for some of the unknown, whatever the number of samples.

    Parameters
    ----------
    without, left : mean square error of the best answer without the effect, and with it
    """
    return 1.0 / (1.0 + float((left / without) ** (UNKNOWN / 2.0)))


def implausible_values(answer: Answer) -> dict[str, float]:
    """Estimates of effects at a bound, or that no real actuator of this size has, by path."""
    model, sizes = answer.result.model, answer.result.problem.coordinates.sizes
    found = {}
    for effect_id in answer.added:
        for parameter in effects.BY_ID[effect_id].parameters:
            value = answer.values(effect_id)[parameter.name]
            if not _plausible(model, parameter, value, sizes):
                found[f"effects.{effect_id}.{parameter.name}"] = value
    return found


def is_plausible(
    model: Model, path: str, value: float, sizes: Mapping[str, float] | None = None
) -> bool:
    """Whether a real actuator of this size may have such a value.

    Parameters
    ----------
    model : Model
    path : dotted path; parameters of the model itself have their prior
    value : in its unit
    sizes : by unit, of what matters in the recordings at hand, see `sizes_in`: springs that bear
        little, or more than they are used for, do not make it implausible
    """
    section, _, rest = path.partition(".")
    if section != "effects":
        return True
    effect_id, _, name = rest.partition(".")
    parameter = next(part for part in effects.BY_ID[effect_id].parameters if part.name == name)
    return _plausible(model, parameter, value, sizes or {})


def _plausible(
    model: Model, parameter: Parameter, value: float, sizes: Mapping[str, float]
) -> bool:
    """Whether a value is at no bound, and within what the catalogue calls typical, widely taken."""
    if value in (parameter.lower, parameter.upper) and value != parameter.null:
        return False
    if parameter.spread in (Spread.TURN, Spread.JOINT_RANGE, Spread.ELONGATION, Spread.NULL):
        return True  # where it lies is the machine's own
    typical = abs(typical_value(model, parameter))
    if not parameter.shape:
        typical = max(typical, sizes.get(parameter.unit, 0.0))
        return abs(value - parameter.null) <= PLAUSIBLE * typical
    return typical / PLAUSIBLE <= abs(value) <= typical * PLAUSIBLE


def _facts(answer: Answer, recordings: Sequence[Measurement], errors: Array) -> float:
    return independent_facts(answer.result.model, recordings, errors)


def _mean_square(errors: Array) -> float:
    """Of errors in units of their noise."""
    return max(float(np.mean(errors**2)), LEAST_SHARE_OF_NOISE**2)
