"""The evidence of a diagnosis: answers of each round, what they explain, how the error falls."""

from collections.abc import Callable, Iterator, Sequence
from functools import partial

from elastic_tendon.diagnosis.explained import (
    Explained,
    explained_by_effect,
    explained_by_learned,
)
from elastic_tendon.diagnosis.result import Diagnosis, Round
from elastic_tendon.errors import ElasticTendonError
from elastic_tendon.identify.ladder import Rung
from elastic_tendon.report.diagnosis_tables import called, candidates_table, round_title
from elastic_tendon.report.html.blocks import Block, Heading, Paragraphs, Plot, as_table, plot
from elastic_tendon.report.interactive.candidates import candidates
from elastic_tendon.report.interactive.experiment import experiment
from elastic_tendon.report.interactive.explained import explained
from elastic_tendon.report.interactive.ladder import ladder
from elastic_tendon.report.tables import ladder_table
from elastic_tendon.report.units import shown, times_noise


def rounds(diagnosis: Diagnosis) -> Iterator[Block]:
    """Answers that each round considered, what those added explain, and the next experiment."""
    for number, one in enumerate(diagnosis.rounds, start=1):
        yield Heading(f"Round {number}")
        yield Paragraphs((round_title(number, one),))
        if (table := candidates_table(one, every=True)) is not None:
            yield _bars(number, one)
            yield as_table(table, f"Answers of round {number}, the likeliest first")
    for effect_id in diagnosis.added:
        yield from _explains(called(effect_id), partial(explained_by_effect, diagnosis, effect_id))
    if diagnosis.learned is not None:
        yield from _explains("the learned term", partial(explained_by_learned, diagnosis))
    if diagnosis.next_experiment is not None:
        proposed = diagnosis.next_experiment
        yield Heading("The experiment to run next")
        yield Paragraphs((proposed.text,))
        yield plot(lambda theme: experiment(proposed, theme=theme), proposed.text)


def _bars(number: int, one: Round) -> Plot:
    first = one.candidates[0]
    return plot(
        lambda theme: candidates(one, theme=theme),
        f"Round {number}: probability and gains of the likeliest answers; {called(first.id)} has "
        f"{100.0 * first.probability:.0f} %.",
    )


def _explains(name: str, find: Callable[[], Explained]) -> Iterator[Block]:
    title = f"What {name} explains"
    yield Heading(title)
    try:
        found = find()
    except ElasticTendonError as error:  # without it, the model may not move at all
        yield Paragraphs((f"It is not drawn: {error}.",))
        return
    yield plot(
        lambda theme: explained(found, title, theme=theme),
        f"Torque that the model lacks without {name}, over {found.by.replace('_', ' ')}, with the "
        "torque of the effect over it; below, what it lacks with it.",
    )


def steps(rungs: Sequence[Rung]) -> Iterator[Block]:
    """The ladder of each signal, and its numbers."""
    for signal in rungs[0].rmse:
        yield _ladder(rungs, signal)
    yield as_table(ladder_table(rungs))


def _ladder(rungs: Sequence[Rung], signal: str) -> Plot:
    quantity = shown(signal)
    first, last = (quantity.error(one.rmse[signal]) for one in (rungs[0], rungs[-1]))
    ratio = times_noise(rungs[-1].noise_ratio[signal])
    return plot(
        lambda theme: ladder(rungs, signal, theme=theme),
        f"RMS error of the {quantity.words} after each step, beside the noise floor: from {first} "
        f"to {last}, {ratio}.",
    )
