"""Commands that hold recordings against a model: simulate, compare, add."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

import elastic_tendon as et
from elastic_tendon.cli.reading import (
    DataArgument,
    ValidateOption,
    check_conditions,
    read_all,
    read_motion,
    reading,
    sizes_by_signal,
)
from elastic_tendon.cli.shared import (
    INTERRUPTED,
    EffectOption,
    FiguresOption,
    ForceOption,
    InterfaceOption,
    JsonOption,
    ModelArgument,
    PlotOption,
    ReportOption,
    app,
    check_outputs,
    check_page,
    command_line,
    load,
    load_effects,
    made_by,
    notice,
    output,
    progress_bar,
    reporting,
    save_figures,
    save_json,
    save_picture,
    sources,
)
from elastic_tendon.output import check_folder, write_text
from elastic_tendon.progress import Progress

if TYPE_CHECKING:
    from elastic_tendon.comparison.comparison import FileComparison
    from elastic_tendon.comparison.tolerance import ToleranceCheck


@app.command()
@reporting
@reading
def simulate(
    model: ModelArgument,
    out: Annotated[Path, typer.Option("--output", "-o", metavar="OUT.csv", help="Table to write.")],
    data: Annotated[
        str | None,
        typer.Argument(metavar="[DATA]", help="Motor position and load; without: a smooth motion."),
    ] = None,
    *,
    options: "et.ReadOptions",
    own_effects: EffectOption = None,
    interface: InterfaceOption = None,
    force: ForceOption = False,
) -> None:
    """Simulate a model and write a table.

    With DATA, the motor moves as measured, and the joint starts in the state estimated on the
    first 0.1 s (at rest in equilibrium where its position was not measured). Without DATA, ten
    seconds of a smooth multisine with a slow load that slackens the tendons.
    """
    from elastic_tendon.comparison import simulated
    from elastic_tendon.native.library import library_path

    check_outputs(out, picture=None, force=force, read=[model, *([data] if data else [])])
    loaded = load(model, own_effects, interface)
    with progress_bar() as progress:
        library_path(*loaded.structure, progress)
        if data is None:
            table = simulated.default_table(loaded)
        else:
            measurement = read_motion(loaded, data, options, progress)
            table = simulated.measured_table(loaded, measurement)
    write_text(out, table.to_csv(index=False), force=force)
    output.print(f"{len(table)} samples in {out}", highlight=False)


@app.command()
@reporting
@reading
def compare(
    model: ModelArgument,
    data: DataArgument,
    *,
    options: "et.ReadOptions",
    own_effects: EffectOption = None,
    interface: InterfaceOption = None,
    tolerance: Annotated[
        list[str] | None,
        typer.Option(
            "--tolerance",
            metavar="SIGNAL=SIZE",
            help="Largest error to accept, e.g. joint_position=2mrad: the exit status is 1 where a "
            "sample lies beyond it; repeatable.",
        ),
    ] = None,
    where: Annotated[
        list[str] | None,
        typer.Option(
            "--where",
            metavar="CONDITION",
            help='Only samples where it holds, e.g. "slack_state=I", "joint_velocity>0", '
            '"deflection<5deg" or "time=3..5"; repeatable, and all must hold.',
        ),
    ] = None,
    all_bins: Annotated[
        bool, typer.Option("--all-bins", help="Show the error in all bins, not the worst only.")
    ] = False,
    json_file: JsonOption = None,
    plot: PlotOption = None,
    figures: FiguresOption = None,
    page: ReportOption = None,
    force: ForceOption = False,
) -> None:
    """Compare a model with measurements: how large the error is, and where it lies.

    The JSON holds how each file was read: give it to --map, and the same is done again.
    """
    from elastic_tendon.comparison.comparison_json import comparison_json

    tolerances = sizes_by_signal("tolerance", tolerance)
    check_conditions(where or ())
    check_page(page)
    check_outputs(json_file, page, picture=plot, force=force, read=[model, *data])
    if figures is not None:
        check_folder(figures, force=force)
    loaded = load(model, own_effects, interface)
    with progress_bar() as progress:
        measurements = read_all(loaded, data, options, progress)
        comparison = _only_where(_compared(loaded, measurements, progress), where or ())
        checks = comparison.within(tolerances)
        location = et.locate(comparison, progress)
        # files first: a reader that closes the pipe must not cost the user a result
        if figures is not None:
            from elastic_tendon.reports.location_figures import all_figures

            save_figures(all_figures(comparison, location), figures, force, progress)
        if page is not None:
            from elastic_tendon.reports.html.document import comparison_document
            from elastic_tendon.reports.html.origin import origin_of

            read = sources(model, {"compared": measurements}, options.mapping, own_effects)
            text = comparison_document(
                comparison, location, origin_of(command_line(), read), progress
            )
            write_text(page, text, force=force)
    save_json(comparison_json(comparison, location, checks), json_file, force)
    if plot is not None:
        from elastic_tendon.reports.comparison_figures import overlay

        save_picture(overlay(comparison, tolerances), plot, force)
    _show_comparison(comparison, location, all_bins)
    if figures is not None:
        output.print(f"The figures are in {figures}.", highlight=False)
    if page is not None:
        output.print(f"The report is {page}.", highlight=False)
    _show_tolerances(checks)


@app.command()
@reporting
@reading
def add(
    model: ModelArgument,
    effects_and_data: Annotated[
        list[str],
        typer.Argument(
            metavar="EFFECT... [DATA...]",
            help="Ids, see: effects; then what is fitted: file.csv or file.csv\\[start:end] in s.",
        ),
    ],
    out: Annotated[Path, typer.Option("--output", "-o", metavar="NEW.toml", help="New model.")],
    validate: ValidateOption = None,
    *,
    options: "et.ReadOptions",
    own_effects: EffectOption = None,
    interface: InterfaceOption = None,
    json_file: JsonOption = None,
    plot: PlotOption = None,
    force: ForceOption = False,
) -> None:
    """Add effects to a model, refit it to DATA after each, and show how the error falls.

    Without DATA the effects come in at their typical values. Ctrl-C stops the fit and keeps the
    best so far.
    """
    load_effects(own_effects)
    wanted, data = _split(effects_and_data)
    read = [model, *data, *(validate or [])]
    check_outputs(out, json_file, picture=plot, force=force, read=read)
    loaded = load(model, None, interface)
    if not data:
        _add_typical(loaded, wanted, out, bool(validate or json_file or plot), force)
        return
    from elastic_tendon.reports.provenance import comments

    with progress_bar() as progress:
        measurements = read_all(loaded, data, options, progress)
        heldout = read_all(loaded, validate or [], options, progress)
        addition = et.add(loaded, wanted, measurements, heldout, progress)
    made = made_by(
        (recording.name for recording in measurements), (recording.name for recording in heldout)
    )
    added = [effect_id for effect_id in wanted if effect_id in addition.model.effects]
    lines = [*made, f"added: {', '.join(added) or 'nothing'}"]
    write_text(out, comments(lines) + addition.model.to_toml(), force=force)
    save_json(addition.to_dict(), json_file, force)
    if plot is not None:
        from elastic_tendon.reports.comparison_figures import story

        save_picture(story(addition.steps, addition.ladder), plot, force)
    _show_addition(addition)
    output.print(f"The new model is {out}.", highlight=False)
    _stop_if(addition.interrupted)


def _split(words: Sequence[str]) -> tuple[list[str], list[str]]:
    """Ids of effects, and the recordings after them; what follows is data from the first word
    that is no effect and that there is a file of, or that ends as a file does."""
    from elastic_tendon.effects import BY_ID
    from elastic_tendon.measurement.reader import split_window

    ids = [words[0]]
    for word in words[1:]:
        path, window = split_window(word)
        if BY_ID.find(word) is None and (window or path.suffix or path.exists()):
            break
        ids.append(word)
    return ids, list(words[len(ids) :])


def _add_typical(
    model: "et.Model", wanted: "Sequence[str]", out: Path, more: bool, force: bool
) -> None:
    from elastic_tendon.estimation.add import add_typical
    from elastic_tendon.reports.provenance import comments

    if more:
        raise typer.BadParameter("--validate, --json and --plot need DATA to fit")
    lines = [*made_by(), f"added: {', '.join(wanted)}, at typical values; nothing was fitted"]
    write_text(out, comments(lines) + add_typical(model, wanted).to_toml(), force=force)
    names = f"{' and '.join(wanted)} {'is' if len(wanted) == 1 else 'are'}"
    output.print(
        f"{names} in {out} at typical values for such an actuator; nothing was fitted. "
        "Give DATA to fit it.",
        highlight=False,
    )


def _compared(
    model: "et.Model", measurements: "Sequence[et.Measurement]", progress: "Progress"
) -> "et.Comparison":
    """`compare`, which fits call as well, one recording at a time to tell how far it is."""
    files: list[FileComparison] = []
    for index, recording in enumerate(measurements):
        progress(f"{recording.name}: simulating", index / len(measurements))
        files.extend(et.compare(model, [recording]).files)
    return et.Comparison(model, tuple(files))


def _only_where(comparison: "et.Comparison", where: "Sequence[str]") -> "et.Comparison":
    """The comparison over the samples for which conditions hold; tells what was left out."""
    from elastic_tendon.comparison.selection import only_where

    chosen = only_where(comparison, where)
    kept = [file.measurement for file in chosen.files]
    for file in comparison.files:
        if not any(file.measurement is measurement for measurement in kept):
            told = f"no sample meets {chosen.condition}; it is left out"
            notice.print(f"note: {file.measurement.name}: {told}", markup=False, soft_wrap=True)
    return chosen


def _show_comparison(comparison: "et.Comparison", location: "et.Location", all_bins: bool) -> None:
    from elastic_tendon.reports import comparison_tables as tables

    for file, file_location in zip(comparison.files, location.files, strict=True):
        output.print(tables.error_table(comparison, file))
        if file.selection is not None:
            output.print(tables.OVER_ALL, highlight=False)
        for sentence in tables.sentences(file, file_location):
            output.print(sentence, highlight=False, markup=False)
        output.print()
        for table in tables.bin_tables(
            file, file_location, all_bins=all_bins, advice=", see --all-bins"
        ):
            output.print(table)


def _show_tolerances(checks: Sequence["ToleranceCheck"]) -> None:
    """Say of each whether it is met; the exit status says whether all are."""
    from elastic_tendon.reports.comparison_tables import tolerance_sentence

    for check in checks:
        output.print(tolerance_sentence(check), highlight=False, markup=False)
    if not all(check.met for check in checks):
        raise typer.Exit(1)


def _show_addition(addition: "et.Addition") -> None:
    from elastic_tendon.reports import tables

    output.print(tables.ladder_table(addition.ladder))
    output.print(tables.estimates_table(addition.findings))
    if addition.findings.ratios:
        output.print(tables.ratios_table(addition.findings))
    for sentence in (*tables.addition_sentences(addition), *addition.findings.sentences):
        output.print(sentence, highlight=False, markup=False)


def _stop_if(interrupted: bool) -> None:
    if interrupted:
        notice.print(
            "elastic-tendon: stopped before the fit had converged; these estimates and intervals "
            "are only the best so far"
        )
        raise typer.Exit(INTERRUPTED)
