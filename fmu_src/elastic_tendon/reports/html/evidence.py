"""The evidence of a diagnosis: candidates of each round, what they explain, how the error falls."""

from collections.abc import Callable, Iterator, Sequence
from functools import partial

import plotly.graph_objects as go

from elastic_tendon.diagnosis.explained import (
    Explained,
    explained_by_effect,
    explained_by_learned,
    is_told,
    told_effects,
)
from elastic_tendon.diagnosis.result import Diagnosis, Round
from elastic_tendon.errors import ElasticTendonError
from elastic_tendon.estimation.ladder import Step
from elastic_tendon.reports.diagnosis_tables import (
    called,
    called_set,
    candidates_table,
    round_title,
    unsure_sentence,
)
from elastic_tendon.reports.html.blocks import Block, Heading, Paragraphs, Plot, as_table, plot
from elastic_tendon.reports.html.recordings import Alike
from elastic_tendon.reports.interactive.candidates import candidates
from elastic_tendon.reports.interactive.experiment import experiment
from elastic_tendon.reports.interactive.explained import explained
from elastic_tendon.reports.interactive.ladder import ladder
from elastic_tendon.reports.interactive.theme import Theme
from elastic_tendon.reports.neighbours import neighbours_table, would_show_table
from elastic_tendon.reports.tables import ladder_table
from elastic_tendon.reports.units import shown, times_noise

GLANCE = 240  # height of a ladder beside sentences, pixels


def rounds(diagnosis: Diagnosis) -> Iterator[Block]:
    """Candidates of each round, what those added explain, and the next experiment."""
    for number, candidate_round in enumerate(diagnosis.rounds, start=1):
        yield Heading(f"Round {number}")
        unsure = unsure_sentence(candidate_round)
        yield Paragraphs((round_title(number, candidate_round), *([unsure] if unsure else [])))
        if (table := candidates_table(candidate_round, every=True)) is not None:
            yield _bars(number, candidate_round)
            yield as_table(table, f"Candidates of round {number}, the likeliest first")
    for effect_id in told_effects(diagnosis):
        yield from _explains(called(effect_id), partial(explained_by_effect, diagnosis, effect_id))
    if diagnosis.learned is not None and is_told(diagnosis):
        yield from _explains("the learned term", partial(explained_by_learned, diagnosis))
    if diagnosis.next_experiment is not None:
        proposed = diagnosis.next_experiment
        yield Heading("The experiment to run next")
        yield Paragraphs((proposed.text,))
        yield plot(lambda theme: experiment(proposed, theme=theme), proposed.text)


def sureness(diagnosis: Diagnosis) -> Iterator[Block]:
    """What comes nearest to the answer, and what would have shown had it been there."""
    tables = (
        neighbours_table(diagnosis, every=True),
        would_show_table(diagnosis.would_show),
    )
    parts = [as_table(table) for table in tables if table is not None]
    yield from parts
    if not parts:
        yield Paragraphs(("This was not tested.",))


def _bars(number: int, candidate_round: Round) -> Plot:
    first = candidate_round.candidates[0]
    return plot(
        lambda theme: candidates(candidate_round, theme=theme),
        f"Round {number}: probability of the likeliest candidates, and what they gain; "
        f"{called_set(first)} has {100.0 * first.probability:.0f} %.",
    )


def _explains(name: str, find: Callable[[], Explained]) -> Iterator[Block]:
    title = f"What {name} explains"
    yield Heading(title)
    try:
        explanation = find()
    except ElasticTendonError as error:  # without it, the model may not move at all
        yield Paragraphs((f"It is not drawn: {error}.",))
        return
    yield plot(
        lambda theme: explained(explanation, title, theme=theme),
        f"Torque that the model lacks without {name}, over {explanation.by.replace('_', ' ')}, "
        "with the torque of the effect over it; below, what it lacks with it.",
    )


def steps(steps: Sequence[Step], alike: Alike, *, static: bool) -> Iterator[Block]:
    """The ladder of each signal that repeats no other, and the numbers of all.

    `static` : the errors are those of static curves.
    """
    for signal in alike:
        yield _falling(steps, signal, static=static)
    yield as_table(ladder_table(steps))


def glance(steps: Sequence[Step], *, static: bool) -> Plot:
    """The ladder of the first signal, small enough to stand beside sentences; see `steps`."""
    signal = next(iter(steps[0].rmse))

    def draw(theme: Theme) -> go.Figure:
        figure = ladder(steps, signal, static=static, theme=theme)
        figure.update_layout(height=GLANCE)
        return figure.update_yaxes(title=f"RMS error ({shown(signal).small_unit})", dtick=1)

    return plot(draw, _words_of(steps, signal, static=static), head=36)


def _falling(steps: Sequence[Step], signal: str, *, static: bool) -> Plot:
    return plot(
        lambda theme: ladder(steps, signal, static=static, theme=theme),
        _words_of(steps, signal, static=static),
    )


def _words_of(steps: Sequence[Step], signal: str, *, static: bool) -> str:
    quantity = shown(signal, static=static)
    first, last = (quantity.error(step.rmse[signal]) for step in (steps[0], steps[-1]))
    ratio = times_noise(steps[-1].noise_ratio[signal])
    return (
        f"RMS error of the {quantity.words} after each step, beside the noise floor: from {first} "
        f"to {last}, {ratio}."
    )
