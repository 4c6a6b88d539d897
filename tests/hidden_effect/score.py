"""What a diagnosis got right: figures of (facts, diagnosis JSON), nothing else.

A figure counts the results that belong to it, so results of many cases may be judged together or
alone. Targets are those that the study is to reach; where there is none the figure is reported.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from statistics import median
from typing import Any

from contradictions_in_words import contradictions_of
from hidden_effect.recordings import NOISES, PLAIN
from truth.outside import MEANT_BY

CLOSE = 10.0  # ΔBIC within which answers are of one class
CLEARLY = 2.0  # times R*, above which a truth beats its nearest rival clearly
RICH = ("multisine", "steps")
# words of the sentence, the probabilities that they stand for, and in how many % it has to be so
WORDS = (("surely", 0.99, 1.01, 95.0), ("probably", 0.9, 0.99, None), ("perhaps", 0.0, 0.9, None))
SIGNAL = "joint_position"
# effects that only what depends on the angle itself could tell apart
ALIASED = (("joint_encoder_offset", "motor_encoder_offset"),)


@dataclass(frozen=True)
class Result:
    """One case and what the tool said.

    `rivals` : true effect -> rival -> ΔBIC of its best noise-free refit, "" for no effect;
    `samples` : values that were compared; `floor` : RMSE of the true system on held-out data by
    signal; `numbers` : true values by path; `diagnosis` : the tool's JSON; `follow_up` : its JSON
    after the experiment it proposed, None where there was none; `seconds` : of the diagnosis.
    """

    name: str
    family: str
    effects: tuple[str, ...]
    ratio: float
    experiment: str
    noise: str
    interpolation: str
    samples: int
    rivals: Mapping[str, Mapping[str, float]]
    numbers: Mapping[str, float]
    floor: Mapping[str, float]
    diagnosis: Mapping[str, Any]
    follow_up: Mapping[str, Any] | None
    seconds: float

    @property
    def plain(self) -> bool:
        """Ordinary noise, exact inputs, an experiment that shows everything."""
        exact = self.noise in PLAIN and self.interpolation == "cubic"
        return exact and self.experiment in RICH

    @property
    def added(self) -> tuple[str, ...]:
        """Effects that the tool added."""
        return tuple(self.diagnosis["added"])


@dataclass(frozen=True)
class Figure:
    """A row of the table: `value` of `count` results beside its target; `missed` are named.

    `best` : "high" or "low", which of the two the target asks for; "" without a target.
    """

    what: str
    value: float
    count: int
    unit: str = "%"
    best: str = ""
    target: float | None = None
    missed: tuple[str, ...] = ()

    @property
    def met(self) -> bool | None:
        """Whether the target is reached; None without one, or without a case."""
        if self.target is None or self.count == 0:
            return None
        return self.value >= self.target if self.best == "high" else self.value <= self.target


# ---- what single results say ---------------------------------------------------------------------


def true_class(result: Result, effect: str) -> set[str]:
    """The effects that explain the noise-free data as well as this one; "" where none is needed."""
    if effect in MEANT_BY:
        return set(MEANT_BY[effect])
    return {one for one, bic in result.rivals[effect].items() if bic < CLOSE} | {effect}


def limit_ratio(result: Result, effect: str) -> float:
    """R*: the strength below which the ΔBIC of some rival is less than 10.

    The misfit of a rival grows with the square of the strength, what its parameters cost does not.
    """
    found = result.rivals[effect]

    def limit(rival: str) -> float:
        penalty = (count_of(rival) - count_of(effect)) * math.log(result.samples)
        misfit = found[rival] - penalty
        if penalty >= CLOSE:
            return 0.0
        return math.inf if misfit <= 0.0 else result.ratio * math.sqrt((CLOSE - penalty) / misfit)

    return max(limit(rival) for rival in found if rival != effect)


def count_of(effect: str) -> int:
    """How many numbers an effect has."""
    from hidden_effect.refit import PARAMETERS

    return PARAMETERS.get(effect, 0)


def ranked(result: Result) -> list[str]:
    """Candidates of the first round, the likeliest first; "" for none. Sets of several effects,
    which a case of one effect does not ask for, have their ids joined by "+"."""
    rounds = result.diagnosis["rounds"]
    listed = rounds[0]["candidates"] if rounds else []
    return ["+".join(candidate["ids"]) for candidate in listed] or [""]


def class_among(result: Result, first: int) -> bool:
    """Whether one of the right class is among the first candidates."""
    right = true_class(result, result.effects[0])
    if "" in right and not result.added:
        return True
    return bool(right & set(ranked(result)[:first]))


def found_both(result: Result) -> bool:
    """Whether each hidden effect has one of its class among those added."""
    return all(true_class(result, one) & set(result.added) for one in result.effects)


def told_apart(result: Result) -> bool:
    """Whether a wrong number and a missing effect were not taken for each other."""
    if result.family == "wrong parameter":
        return result.diagnosis["verdict"] == "wrong_parameter" and not result.added
    return result.diagnosis["verdict"] in ("missing_effect", "unexplained")


def undecidable(result: Result) -> set[str]:
    """The answers that come as near as the best; a law with needless numbers is not among them."""
    found = result.rivals[result.effects[0]]
    best = min(found.values())
    return {one for one, bic in found.items() if one and bic < best + CLOSE}


def called_undecided(result: Result) -> bool:
    """Whether the tool says that it cannot tell some of them apart."""
    possible = undecidable(result)
    return any(len(possible & set(one)) > 1 for one in result.diagnosis["indistinguishable"])


def aliases(result: Result) -> set[str]:
    """The truth, and what no experiment can tell from it."""
    effect = result.effects[0]
    return next((set(group) for group in ALIASED if effect in group), {effect})


def decided(result: Result) -> bool:
    """Whether after the proposed experiment the truth was added, and nothing beside it possible."""
    after = result.follow_up
    if after is None:
        return False
    # what is too small to matter has groups of its own
    meant = [set(one) for one in after["indistinguishable"] if set(one) & set(after["added"])]
    only = all(group <= aliases(result) for group in meant)
    return bool(aliases(result) & set(after["added"])) and only


def error_ratio(result: Result) -> float:
    """Held-out error at the end over that of the true system."""
    return float(result.diagnosis["ladder"][-1]["heldout_rmse"][SIGNAL] / result.floor[SIGNAL])


def structure_right(result: Result) -> bool:
    """Whether the tool's model has the true effects, so that its numbers can be compared."""
    return set(result.added) == set(result.effects)


def covered(result: Result) -> list[bool]:
    """For each number that the tool determined, whether its 95 % interval holds the truth."""
    return [
        one["interval"][0] <= result.numbers[one["path"]] <= one["interval"][1]
        for one in result.diagnosis["parameters"]
        if one["determined"] and one["path"] in result.numbers
    ]


# ---- figures -------------------------------------------------------------------------------------

Test = Callable[[Result], bool]


def share(
    what: str,
    results: Iterable[Result],
    right: Test,
    target: float | None = None,
    best: str = "high",
) -> Figure:
    """Share of results, %, of which something is true; with a target those on its wrong side."""
    asked = list(results)
    hits = [right(one) for one in asked]
    value = 100.0 * sum(hits) / len(asked) if asked else math.nan
    wrong = best == "low"
    missed = tuple(one.name for one, hit in zip(asked, hits, strict=True) if hit == wrong)
    return Figure(what, value, len(asked), "%", best if target is not None else "", target, missed)


def percentile(values: Sequence[float], part: float) -> float:
    """Smallest value that `part` (0 to 1) of the values do not exceed; NaN of none."""
    ordered = sorted(values)
    return ordered[math.ceil(part * len(ordered)) - 1] if ordered else math.nan


def identifiable(result: Result) -> bool:
    """Whether the data need the effect at all."""
    return "" not in true_class(result, result.effects[0])


def ranking(results: Sequence[Result]) -> list[Figure]:
    """Right class first, exact effect first, right class among the first three."""
    plain = [one for one in results if one.family == "effect" and one.plain]
    strong = [one for one in plain if one.ratio >= 0.25]
    clear = [one for one in strong if one.ratio > CLEARLY * limit_ratio(one, one.effects[0])]
    figures = [
        share("right class first, R ≥ 0.3", strong, lambda one: class_among(one, 1), 97.0),
        share(
            "exact effect first, clearly ahead of its rivals",
            clear,
            lambda one: ranked(one)[0] == one.effects[0],
            90.0,
        ),
        share("right class among three, R ≥ 0.1", plain, lambda one: class_among(one, 3), 99.0),
    ]
    figures += [
        share(
            f"  right class first, R = {ratio:g}",
            [one for one in plain if 0.8 * ratio < one.ratio < 1.2 * ratio],
            lambda one: class_among(one, 1),
        )
        for ratio in (0.1, 0.3, 1.0, 3.0)
    ]
    return figures


def heldout(results: Sequence[Result]) -> list[Figure]:
    """Held-out error at the end over the floor."""
    asked = [
        one for one in results if one.plain and one.family in ("effect", "nothing", "two effects")
    ]
    ratios = [error_ratio(one) for one in asked]
    worst = tuple(one.name for one, ratio in zip(asked, ratios, strict=True) if ratio > 1.10)
    middle = median(ratios) if ratios else math.nan
    high = percentile(ratios, 0.95)
    what = "held-out error after / floor"
    return [
        Figure(f"{what}, median", middle, len(asked), "", "low", 1.02),
        Figure(f"{what}, 95th percentile", high, len(asked), "", "low", 1.10, worst),
    ]


def blame(results: Sequence[Result]) -> list[Figure]:
    """What is called missing when nothing is, or something else."""

    def alarm(one: Result) -> bool:
        return bool(one.added) or one.diagnosis["verdict"] in ("missing_effect", "unexplained")

    nothing = [one for one in results if one.family == "nothing"]
    figures = [
        share(
            f"called missing when nothing is, {noise} noise",
            [one for one in nothing if one.noise == noise],
            alarm,
            5.0,
            "low",
        )
        for noise in NOISES
    ]
    wrong = [one for one in results if one.family == "wrong parameter"]
    missing = [
        one
        for one in results
        if one.family == "effect" and one.plain and one.ratio >= 0.25 and identifiable(one)
    ]
    two = [one for one in results if one.family == "two effects" and one.ratio >= 0.8]
    outside = [one for one in results if one.family == "outside"]
    return [
        *figures,
        share("wrong parameter told from missing effect", [*wrong, *missing], told_apart, 98.0),
        share("  wrong parameter called so", wrong, told_apart),
        share("both of two hidden effects found, R ≥ 1 each", two, found_both, 90.0),
        share(
            "outside the catalogue: called unexplained",
            outside,
            lambda one: one.diagnosis["verdict"] == "unexplained",
            90.0,
        ),
        share(
            "outside the catalogue: blamed on an effect of it",
            outside,
            lambda one: bool(one.added),
            5.0,
            "low",
        ),
    ]


def intervals(results: Sequence[Result]) -> list[Figure]:
    """How often the intervals hold the truth, where the tool's model has its effects."""
    asked = [
        one
        for one in results
        if one.plain and one.family in ("effect", "nothing", "wrong parameter", "two effects")
        and structure_right(one)
    ]  # fmt: skip
    inside = [(one.name, held) for one in asked for held in covered(one)]
    value = 100.0 * sum(held for _, held in inside) / len(inside) if inside else math.nan
    missed = tuple(dict.fromkeys(name for name, held in inside if not held))
    what = "95 % intervals cover the truth"
    return [
        Figure(f"{what}, at least", value, len(inside), "%", "high", 93.0, missed),
        Figure(f"{what}, at most", value, len(inside), "%", "low", 97.0),
    ]


def undecided(results: Sequence[Result]) -> list[Figure]:
    """Whether what cannot be told apart is called so, and then decided."""
    single = [
        one
        for one in results
        if one.family == "effect" and one.noise in PLAIN and identifiable(one)
    ]
    pairs = [one for one in single if len(undecidable(one)) > 1]
    # nothing is proposed for what is called too small to matter
    told = [one for one in pairs if called_undecided(one) and one.added]
    asked = [one for one in told if undecidable(one) - aliases(one)]
    clear = [one for one in single if len(undecidable(one)) == 1]
    return [
        share("undecidable pairs called so", pairs, called_undecided, 95.0),
        share("the proposed experiment then decides", asked, decided, 85.0),
        share(
            "  called undecidable although one is ahead",
            clear,
            lambda one: any(
                one.effects[0] in found for found in one.diagnosis["indistinguishable"]
            ),
        ),
    ]


def calibration(results: Sequence[Result]) -> list[Figure]:
    """How often what is called surely, probably or perhaps missing is: it or one of its class."""
    found = []
    for word, low, high, target in WORDS:
        said = [
            (one, effect)
            for one in results
            for effect, certainty in one.diagnosis.get("certainty", {}).items()
            if low <= certainty < high
        ]
        wrong = tuple(one.name for one, effect in said if not is_there(one, effect))
        value = 100.0 * (1.0 - len(wrong) / len(said)) if said else math.nan
        best = "high" if target is not None else ""
        what = f"called {word} missing, and it is"
        found.append(Figure(what, value, len(said), "%", best, target, wrong))
    return found


def is_there(result: Result, effect: str) -> bool:
    """Whether an effect, or one that explains the noise-free data as well, is in the machine; a
    certainty is that of the effect or of what the tool says these data do not tell from it."""
    if result.family == "outside":
        return False
    said = [group for group in result.diagnosis["indistinguishable"] if effect in group]
    meant = {effect}.union(*said)
    return any(meant & true_class(result, one) for one in result.effects)


def times(results: Sequence[Result]) -> list[Figure]:
    """How long a diagnosis takes."""
    seconds = [one.seconds for one in results]
    slow = tuple(one.name for one in results if one.seconds > 30.0)
    middle = median(seconds) if seconds else math.nan
    return [
        Figure("time of a diagnosis, median", middle, len(seconds), "s"),
        Figure("time, 95th percentile", percentile(seconds, 0.95), len(seconds), "s", "low", 30.0,
               slow),
    ]  # fmt: skip


def beside(results: Sequence[Result]) -> list[Figure]:
    """Right class first where laws, noise, inputs or experiments are harder."""
    effect = [one for one in results if one.family == "effect" and one.ratio >= 0.25]
    rows = [
        ("by other laws", [one for one in results if one.family == "other law"]),
        *(
            (f"{noise} noise", [one for one in effect if one.noise == noise])
            for noise in NOISES
            if noise not in PLAIN
        ),
        ("inputs on straight lines", [one for one in effect if one.interpolation == "linear"]),
        *(
            (f"{kind} only", [one for one in effect if one.experiment == kind])
            for kind in ("static sweep", "free decay", "only slack", "only taut")
        ),
    ]
    return [
        share(f"right class first, {what}", asked, lambda one: class_among(one, 1))
        for what, asked in rows
    ]


def consistent(results: Sequence[Result]) -> Figure:
    """Whether sentence, verdict, tables, ladder and neighbours of each diagnosis agree."""
    return share(
        "says nothing that contradicts itself",
        results,
        lambda one: not contradictions_of(one.diagnosis),
        100.0,
    )


def figures(results: Sequence[Result]) -> list[Figure]:
    """All rows of the table but `consistent`, which needs whole diagnoses."""
    parts = (ranking, heldout, blame, intervals, undecided, calibration, times, beside)
    return [figure for part in parts for figure in part(results)]
