"""The command that finds out what is missing: diagnose; and the demo of it."""

import sys
import time
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

import elastic_tendon as et
from elastic_tendon.cli.reading import (
    DataArgument,
    ValidateOption,
    read_all,
    reading,
    sizes_by_signal,
    words,
)
from elastic_tendon.cli.search_options import (
    HorizonOption,
    NoiseOption,
    OnlyOption,
    RelevanceOption,
    TimeLimitOption,
    WithoutOption,
    options_of,
    repeated,
    with_noise,
)
from elastic_tendon.cli.shared import (
    INTERRUPTED,
    EffectOption,
    FiguresOption,
    ForceOption,
    InterfaceOption,
    JsonOption,
    ModelArgument,
    ReportOption,
    app,
    check_outputs,
    check_page,
    command_line,
    load,
    made_by,
    notice,
    output,
    progress_bar,
    reporting,
    save_figures,
    save_json,
    sources,
)
from elastic_tendon.output import check_folder, check_writable, write_file, write_text
from elastic_tendon.progress import Progress

if TYPE_CHECKING:
    from elastic_tendon.diagnosis.result import Round

StepOption = Annotated[
    bool, typer.Option("--step", help="Show each round and ask whether to go on.")
]
EveryOption = Annotated[
    bool, typer.Option("--all-candidates", help="Show all candidates, not the likeliest only.")
]
ModelOption = Annotated[
    Path | None,
    typer.Option(
        "--save-model",
        metavar="F.toml",
        help="Write the improved model, and beside it F_learned.py if a term was learned.",
    ),
]
ExperimentOption = Annotated[
    Path | None,
    typer.Option(
        "--next-experiment",
        metavar="F.csv",
        help="Write the motion to run next, where one would decide between answers.",
    ),
]


@app.command()
@reporting
def demo() -> None:
    """The whole loop on bundled data, in a minute.

    Writes elastic_tendon_demo.png in the current folder, replacing one of an earlier demo.
    """
    from elastic_tendon import demo as bundled
    from elastic_tendon.reports import tables
    from elastic_tendon.reports.comparison_figures import is_ours

    picture = Path(bundled.PICTURE)
    force = is_ours(picture)
    check_writable(picture, force=force)
    notice.print(
        "A machine was measured twice, and its model does not agree. The model is compared with "
        "the first recording and refitted to it; then every effect of the catalogue is tried. The "
        "second recording is held out.\n"
    )
    with progress_bar() as progress:
        diagnosis = bundled.run(progress)
    write_file(picture, lambda path: bundled.draw(diagnosis, path), force=force)
    _show_answer(diagnosis)
    _show_evidence(diagnosis, every=False)
    output.print(f"\nThe picture of this is {picture}.", highlight=False)
    output.print(tables.NEXT_AFTER_DEMO, highlight=False, markup=False)
    _stop_if(diagnosis)


@app.command()
@reporting
@reading
def diagnose(
    model: ModelArgument,
    data: DataArgument,
    validate: ValidateOption = None,
    *,
    options: "et.ReadOptions",
    noise: NoiseOption = None,
    only: OnlyOption = None,
    without: WithoutOption = None,
    relevance: RelevanceOption = None,
    horizon: HorizonOption = None,
    time_limit: TimeLimitOption = None,
    own_effects: EffectOption = None,
    interface: InterfaceOption = None,
    step: StepOption = False,
    every: EveryOption = False,
    save_model: ModelOption = None,
    experiment: ExperimentOption = None,
    json_file: JsonOption = None,
    figures: FiguresOption = None,
    page: ReportOption = None,
    force: ForceOption = False,
) -> None:
    """Find out whether the model is adequate, its parameters are wrong, or which effect is missing.

    All effects are tried, alone and together; those that explain the error are fitted, until no
    change of the answer does better. Ctrl-C keeps what was found.
    """
    files = Outputs(save_model, experiment, json_file, figures, page, force)
    files.check([model, *data, *(validate or [])])
    if step and not _is_terminal():
        fault = "it asks on the terminal, and there is none; leave it out"
        raise typer.BadParameter(fault, param_hint="--step")
    sigmas = sizes_by_signal("noise", noise)
    loaded = load(model, own_effects, interface)
    search = options_of(only, without, relevance, horizon, time_limit)
    from elastic_tendon.reports.diagnosis_tables import Call, next_lines

    with Stage(every) as stage:
        read = read_all(loaded, data, options, stage.progress)
        held = read_all(loaded, validate or [], options, stage.progress)
        known = with_noise([*read, *held], sigmas)
        measurements, heldout = known[: len(read)], known[len(read) :]
        begin = time.monotonic()
        diagnosis = et.diagnose(
            *(loaded, measurements, heldout),
            options=search,
            progress=stage.progress,
            ask=stage.ask if step else None,
        )
        in_time = time_limit is None or time.monotonic() - begin < time_limit
        # files first: a reader that closes the pipe must not cost the user a result
        files.write(
            diagnosis,
            [recording.name for recording in measurements],
            [recording.name for recording in heldout],
        )
        call = Call(
            model=model,
            data=tuple(data),
            effects=tuple(word for file in own_effects or () for word in ("--effect", str(file))),
            reading=words(options),
            search=repeated(noise, only, without, relevance, horizon),
            saved=_text(save_model),
            learned=_text(files.learned if diagnosis.learned else None),
            experiment=_text(experiment if diagnosis.next_experiment else None),
        )
        used = {"fitted": measurements, "held-out": heldout}
        came = sources(model, used, options.mapping, own_effects)
        advice = next_lines(diagnosis, call)
        files.draw(diagnosis, came, advice, stage.progress)
    _show_answer(diagnosis)
    _say(advice)
    _show_evidence(diagnosis, every)
    files.tell(diagnosis)
    if in_time:  # what a limit of time ends is what was asked for
        _stop_if(diagnosis)


@dataclass(frozen=True)
class Outputs:
    """Files that the user asks for, None where not; `force`: those that exist may be replaced."""

    model: Path | None
    experiment: Path | None
    json: Path | None
    figures: Path | None
    page: Path | None
    force: bool

    @property
    def learned(self) -> Path | None:
        """The effect file of a learned term, beside the model."""
        return self.model and self.model.with_name(f"{self.model.stem}_learned.py")

    def check(self, read: Sequence[str]) -> None:
        """Refuse what could not be written, before the long work; see `check_outputs`."""
        check_page(self.page)
        paths = (self.model, self.learned, self.experiment, self.json, self.page)
        check_outputs(*paths, picture=None, force=self.force, read=read)
        if self.figures is not None:
            check_folder(self.figures, force=self.force)

    def write(
        self, diagnosis: "et.Diagnosis", fitted: Sequence[str], heldout: Sequence[str]
    ) -> None:
        """Write what was found; `fitted` and `heldout` are the names of the recordings."""
        from elastic_tendon.diagnosis.diagnosis_json import diagnosis_json

        if self.model is not None:
            text = _provenance(diagnosis, fitted, heldout) + diagnosis.model.to_toml()
            write_text(self.model, text, force=self.force)
        learned = None
        if diagnosis.learned is not None and self.learned is not None:
            learned = str(self.learned)
            write_text(self.learned, diagnosis.learned.source, force=self.force)
        if self.experiment is not None and diagnosis.next_experiment is not None:
            from elastic_tendon.diagnosis.experiment import experiment_csv

            text = experiment_csv(diagnosis.next_experiment, diagnosis.given.motion)
            write_text(self.experiment, text, force=self.force)
        save_json(diagnosis_json(diagnosis, learned), self.json, self.force)

    def draw(
        self,
        diagnosis: "et.Diagnosis",
        read: Sequence[tuple[str, Path]],
        advice: Sequence[str],
        progress: Progress,
    ) -> None:
        """Write the pictures and the page; what was `read` by purpose, and what to do next."""
        if self.figures is not None:
            from elastic_tendon.reports.diagnosis_figures import all_figures

            save_figures(all_figures(diagnosis), self.figures, self.force, progress)
        if self.page is not None:
            from elastic_tendon.reports.html.document import diagnosis_document
            from elastic_tendon.reports.html.origin import origin_of

            where = et.locate(diagnosis.steps[0].comparison, progress)
            origin = origin_of(command_line(), read, advice)
            text = diagnosis_document(diagnosis, where, origin, progress)
            write_text(self.page, text, force=self.force)

    def tell(self, diagnosis: "et.Diagnosis") -> None:
        """Say what was not written, and where the pictures are."""
        if self.experiment is not None and diagnosis.next_experiment is None:
            notice.print(f"note: no experiment is proposed, so {self.experiment} was not written")
        if self.figures is not None:
            output.print(f"The figures are in {self.figures}.", highlight=False)
        if self.page is not None:
            output.print(f"The report is {self.page}.", highlight=False)


class Stage:
    """The progress bar, which makes room while the user is asked."""

    def __init__(self, every: bool) -> None:
        self._every = every  # candidates are shown
        self._rounds = 0
        self._bar = ExitStack()

    def __enter__(self) -> "Stage":
        self._move = self._bar.enter_context(progress_bar())
        return self

    def __exit__(self, *_raised: object) -> None:
        self._bar.close()

    def progress(self, text: str, share: float) -> None:
        """Move the bar."""
        self._move(text, share)

    def ask(self, search_round: "Round") -> bool:
        """Show a round, and ask whether to go on."""
        self._bar.close()
        self._rounds += 1
        _show_round(self._rounds, search_round, self._every)
        try:
            goes_on = typer.confirm("Go on?", default=True, err=True)
        except typer.Abort:  # Ctrl-C or the end of the input: what was found is kept
            goes_on = False
        self._move = self._bar.enter_context(progress_bar())
        return goes_on


def _is_terminal() -> bool:
    return sys.stdin.isatty()


def _text(path: Path | None) -> str | None:
    return None if path is None else str(path)


def _provenance(diagnosis: "et.Diagnosis", fitted: Sequence[str], heldout: Sequence[str]) -> str:
    """Comments for the head of a model.toml: what made it, from what, and what was found."""
    from elastic_tendon.reports.diagnosis_tables import size_sentences
    from elastic_tendon.reports.first_screen import of_diagnosis
    from elastic_tendon.reports.provenance import comments

    first = of_diagnosis(diagnosis)
    lines = [
        *made_by(fitted, heldout),
        f"verdict: {diagnosis.verdict}",
        f"added: {', '.join(diagnosis.added) or 'nothing'}",
        first.verdict,
        *first.errors,
        *size_sentences(diagnosis),
    ]
    return comments(lines)


def _show_answer(diagnosis: "et.Diagnosis") -> None:
    from elastic_tendon.reports.diagnosis_tables import doubt_sentences, size_sentences
    from elastic_tendon.reports.first_screen import of_diagnosis

    for sentence in of_diagnosis(diagnosis).sentences:
        output.print(sentence, highlight=False, markup=False)
    output.rule()
    _say([*size_sentences(diagnosis), *doubt_sentences(diagnosis)])


def _show_evidence(diagnosis: "et.Diagnosis", every: bool) -> None:
    from elastic_tendon.reports import tables
    from elastic_tendon.reports.neighbours import neighbours_table, would_show_table

    output.print(tables.ladder_table(diagnosis.ladder))
    output.print(tables.estimates_table(diagnosis.findings))
    if diagnosis.findings.ratios:
        output.print(tables.ratios_table(diagnosis.findings))
    for table in (neighbours_table(diagnosis, every=every), would_show_table(diagnosis.would_show)):
        if table is not None:
            output.print(table)
    for index, search_round in enumerate(diagnosis.rounds, start=1):
        _show_round(index, search_round, every)


def _show_round(index: int, search_round: "Round", every: bool) -> None:
    from elastic_tendon.reports import diagnosis_tables as words

    output.print(words.round_title(index, search_round), highlight=False, markup=False)
    if table := words.candidates_table(search_round, every=every):
        output.print(table)
    if sentence := words.unsure_sentence(search_round):
        output.print(sentence, highlight=False, markup=False)


def _say(sentences: Sequence[str]) -> None:
    """Print a paragraph, one sentence or command a line."""
    for sentence in sentences:
        output.print(sentence, highlight=False, markup=False, soft_wrap=sentence.startswith("  "))
    if sentences:
        output.print()


def _stop_if(diagnosis: "et.Diagnosis") -> None:
    if not diagnosis.complete:
        raise typer.Exit(INTERRUPTED)
