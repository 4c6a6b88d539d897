"""Whether anything in the catalogue beats what the diagnosis answers.

    python build_scripts/study_dominance.py [--count 100] [--seeds dev|report] [--jobs 2]

By brute force and without the search: every effect, and every pair of the ten best, is refitted
from many starts, and held against the answer. Cases are those of study_fresh.py and study_engine.py
in turn, and real recordings where the folder of bench_real_data.py is at hand. Results are kept:
interrupt and go on at will.
"""

import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import combinations, zip_longest
from math import log
from pathlib import Path

# the truth simulator and the cases belong to the tests and are not installed
sys.path.append(str(Path(__file__).resolve().parents[1] / "tests"))

import numpy as np
from threadpoolctl import threadpool_limits

import bench_real_data as real
from benchmarking import at_least, print_table
from elastic_tendon import effects
from elastic_tendon.actuator.parameters import Model, load_model
from elastic_tendon.comparison.compare import compare
from elastic_tendon.diagnosis.answer import Answer, bounded, refit
from elastic_tendon.diagnosis.candidates import candidates, starts
from elastic_tendon.diagnosis.diagnose import diagnose
from elastic_tendon.diagnosis.inputs import smoothed
from elastic_tendon.errors import ElasticTendonError
from elastic_tendon.estimation.fit import Effort
from elastic_tendon.estimation.stretches import independent_facts
from elastic_tendon.measurement import Measurement, read_measurement
from engine.cases import build
from engine.cases import orders as engine_orders
from hidden_effect.fresh import build_fresh
from hidden_effect.fresh import orders as fresh_orders
from kept_answers import Content, collected, kept, parser_of, print_columns, print_faults

TARGET = 99.0  # %
BEST = 10  # singles of which all pairs are tried
SHARES = (0.1, 1.0)  # of typical strengths, from which refits start
MOST_STARTS = 12
DECISIVE = 10.0  # evidence by which one answer beats another
HELD_OUT = 1.01  # times the held-out error that counts as no worse
FAILURES = (ElasticTendonError, ArithmeticError, ValueError)  # of a refit
BRUTE = Effort(scouted=MOST_STARTS, scouting=6, polished=1, evaluations=40, rounds=1)


@dataclass(frozen=True)
class Question:
    """What the tool is asked."""

    name: str
    given: Model
    fit: tuple[Measurement, ...]
    validation: tuple[Measurement, ...]


@dataclass(frozen=True)
class Order:
    """Which question: of which study, and its order there."""

    study: str
    of: object

    @property
    def name(self) -> str:
        """For tables and files."""
        named = self.of.fitted if isinstance(self.of, real.Climb) else getattr(self.of, "name", "")
        return Path(named).stem

    def question(self) -> Question:
        """The question, always the same."""
        if self.study == "real":
            assert isinstance(self.of, real.Climb)
            recordings = (
                (real.read(real.DATA, self.of.fitted),),
                (read_measurement(str(real.DATA / self.of.heldout)),),
            )
            return Question(self.of.fitted, load_model(self.of.model), *recordings)
        make = partial(build_fresh, judge=False) if self.study == "fresh" else build
        case = make(self.of)  # type: ignore[arg-type]
        return Question(self.name, case.given, case.fit, case.validation)


def orders(reported: bool, count: int) -> Iterator[Order]:
    """Real recordings, then so many cases of both studies in turn."""
    if real.DATA.is_dir():
        for climb in real.CLIMBS:
            yield Order("real", climb)
    both = zip_longest(
        (Order("fresh", one) for one in fresh_orders(reported, count)),
        (Order("engine", one) for one in engine_orders(reported, rounds=count)),
    )
    flat = (one for pair in both for one in pair if one is not None)
    yield from (one for _, one in zip(range(count), flat, strict=False))


def refitted(question: Question, added: tuple[str, ...], models: Sequence[Model]) -> Answer | None:
    """The best refit of a set from some starts, None where none can be."""
    recordings = [smoothed(part) for part in question.fit]
    try:
        with threadpool_limits(1, user_api="blas"):
            return refit(question.given, added, recordings, models, BRUTE)
    except FAILURES:
        return None


def single(question: Question, effect_id: str, beside: Sequence[Model]) -> Answer | None:
    """The best refit with one effect, from many starts beside some models."""
    effect, recordings = effects.BY_ID[effect_id], [smoothed(part) for part in question.fit]
    models = [
        bounded(model, effect_id, start)
        for model in beside
        for start in starts(model, effect, recordings, SHARES)
    ]
    return refitted(question, (effect_id,), models[:: max(len(models) // MOST_STARTS, 1)])


def pair(question: Question, one: Answer, other: Answer) -> Answer | None:
    """The best refit with the effects of both, beside the parameters of either."""
    (first,), (second,) = one.added, other.added
    try:
        models = [
            bounded(one.result.model, second, other.values(second)),
            bounded(other.result.model, first, one.values(first)),
        ]
    except FAILURES:
        return None  # these do not go together
    return refitted(question, (first, second), models)


def everything(question: Question) -> list[Answer]:
    """Refits of the model as given, of all effects, and of the pairs of the best."""
    recordings = [smoothed(part) for part in question.fit]
    base = refit(question.given, (), recordings, (), BRUTE)
    beside = [base.result.model, question.given]
    ids = candidates(question.given, recordings)
    singles = [one for one in (single(question, each, beside) for each in ids) if one is not None]
    best = sorted(singles, key=square)[:BEST]
    pairs = [pair(question, one, other) for one, other in combinations(best, 2)]
    return [base, *singles, *(one for one in pairs if one is not None)]


def square(answer: Answer) -> float:
    """Mean square error in units of the noise."""
    return float(np.mean(answer.floored**2))


def size(added: Sequence[str]) -> int:
    """Number of parameters of effects."""
    return sum(len(effects.BY_ID[effect_id].parameters) for effect_id in added)


def row_of(order: Order) -> Content:
    """What the tool answers, and the best that brute force finds against it."""
    question = order.question()
    said = diagnose(question.given, question.fit, question.validation)
    ratio = max(said.comparison.noise_ratio().values())
    rivals = everything(question)
    best = min(rivals, key=square)
    measurements = best.result.problem.measurements
    facts = max(independent_facts(best.result.model, measurements, best.floored), 2.0)

    def gain(answer: Answer) -> float:
        """Evidence against the tool's answer; above `DECISIVE` it is beaten."""
        more = size(answer.added) - size(said.added)
        return facts * (2.0 * log(ratio) - log(square(answer))) - more * log(facts)

    strongest = max(rivals, key=gain)
    return {
        "name": question.name,
        "verdict": str(said.verdict),
        "named": sorted(said.added),
        "ratio": ratio,
        "rival": sorted(strongest.added),
        "rival_ratio": square(strongest) ** 0.5,
        "gain": gain(strongest),
        "beaten": gain(strongest) > DECISIVE and lasts(question, said.model, strongest),
    }


def lasts(question: Question, answer: Model, rival: Answer) -> bool:
    """Whether the rival errs no more on held-out recordings than the answer."""
    if not question.validation:
        return True
    errors = []
    for model in (rival.result.model, answer):
        try:
            errors.append(max(compare(model, question.validation).noise_ratio().values()))
        except ElasticTendonError:
            errors.append(np.inf)
    return bool(errors[0] <= HELD_OUT * errors[1])


def judged(order: Order, folder: Path) -> Content:
    """The row of one case, from disk where it is kept there."""
    return kept(folder / f"{order.study}_{order.name}.json", lambda: row_of(order))


def line_of(row: Content) -> list[str]:
    """A row as text."""
    return [
        row["name"],
        row["verdict"],
        "+".join(row["named"]) or "none",
        f"{row['ratio']:.3f}",
        "+".join(row["rival"]) or "none",
        f"{row['rival_ratio']:.3f}",
        f"{row['gain']:.0f}",
        "BEATEN" if row["beaten"] else "",
    ]


def main() -> int:
    """Run what is not yet done and print the table; exit status 1 where a target is missed."""
    parser = parser_of(__doc__, "elastic-tendon-study-dominance")
    parser.add_argument("--count", type=int, default=100, help="cases beside real recordings")
    chosen = parser.parse_args()
    every = orders(chosen.seeds == "report", chosen.count)
    wanted = [candidate_set for candidate_set in every if chosen.only in candidate_set.name]
    rows, faults = collected(wanted, partial(judged, folder=chosen.folder), chosen.jobs)
    rows.sort(key=lambda row: str(row["name"]))
    heads = ["case", "verdict", "named", "error/noise", "rival", "error/noise", "gain", ""]
    print_columns([heads, *map(line_of, rows)])
    print_faults(faults)
    if not rows:
        return 1
    unbeaten = 100.0 * sum(not row["beaten"] for row in rows) / len(rows)
    return print_table(
        "Nothing in the catalogue does better",
        [at_least(f"not beaten ({len(rows)})", unbeaten, TARGET, "%")],
    )


if __name__ == "__main__":
    sys.exit(main())
