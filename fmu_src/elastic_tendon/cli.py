"""The command line: it parses, calls and shows; physics and statistics live elsewhere.

Exit status: 0 done, 1 the data or the model says no (one line on stderr), 2 wrong usage,
130 stopped by the user. Heavy modules are imported inside the commands so that help comes at once.
"""

import functools
import json
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, ParamSpec

import typer
from rich.console import Console

from elastic_tendon.errors import BuildError, ElasticTendonError
from elastic_tendon.interpolation import Interpolation
from elastic_tendon.output import check_writable, write_file, write_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from elastic_tendon.identify.add import Addition, Report
    from elastic_tendon.measurement import Measurement
    from elastic_tendon.parameters import Model

# before numpy is imported: a fit's matrices are tall and narrow, and threads that wait for one
# another make their decomposition fifty times slower on a busy machine
for variable in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

INTERRUPTED = 130
EXAMPLE = "biorob_x4_joint_3"  # bundled model for which typical values are shown

app = typer.Typer(
    name="elastic-tendon",
    help="The elastic tendon actuator: simulate it, export it as an FMU, compare it with "
    "measurements and find what is missing.",
    no_args_is_help=True,
    add_completion=False,
)
output = Console()
notice = Console(stderr=True, highlight=False)

Parameters = ParamSpec("Parameters")
ModelArgument = Annotated[
    str, typer.Argument(metavar="MODEL", help="A model.toml, or the name of a bundled model.")
]
EffectOption = Annotated[
    list[Path] | None,
    typer.Option(
        "--effect",
        metavar="FILE.py",
        help="Run this Python file, for an effect of your own; repeatable.",
    ),
]
DataArgument = Annotated[
    list[str], typer.Argument(metavar="DATA...", help="file.csv, or file.csv\\[start:end] in s.")
]
MapOption = Annotated[
    list[str] | None,
    typer.Option(
        "--map",
        metavar="SIGNAL=COLUMN",
        help="signal=column[:unit][*scale][+offset], e.g. joint_position=enc2:deg*-1; repeatable.",
    ),
]
InterpolationOption = Annotated[
    Interpolation, typer.Option(help="Of motor position and load between the samples.")
]
ForceOption = Annotated[bool, typer.Option("--force", help="Replace files that exist.")]
JsonOption = Annotated[
    Path | None, typer.Option("--json", metavar="F", help="Write the result as JSON.")
]
PlotOption = Annotated[
    Path | None, typer.Option("--plot", metavar="F", help="Write a picture (.png, .svg, .pdf).")
]


def _reporting(function: Callable[Parameters, None]) -> Callable[Parameters, None]:
    """Turn the errors that users can meet into one line and an exit status."""

    @functools.wraps(function)
    def run(*args: Parameters.args, **kwargs: Parameters.kwargs) -> None:
        try:
            function(*args, **kwargs)
        except ElasticTendonError as error:
            notice.print(f"elastic-tendon: {error}", markup=False, soft_wrap=True)
            raise typer.Exit(1) from None
        except KeyboardInterrupt:
            notice.print("elastic-tendon: stopped, nothing was written")
            raise typer.Exit(INTERRUPTED) from None

    return run


def main() -> None:
    """Entry point of the command ``elastic-tendon``."""
    app()


@app.command()
@_reporting
def demo() -> None:
    """The whole loop on bundled data, in a minute.

    Writes elastic_tendon_demo.png in the current folder, replacing one of an earlier demo.
    """
    from elastic_tendon import demo as bundled
    from elastic_tendon.report import tables
    from elastic_tendon.report.comparison_figures import is_ours

    picture = Path(bundled.PICTURE)
    force = is_ours(picture)
    check_writable(picture, force=force)
    notice.print(
        "A machine was measured twice, and its model does not agree. The model is compared with "
        "the first recording and refitted to it; then Coulomb friction is added. The second "
        "recording is kept apart and only judges.\n"
    )
    with _progress() as report:
        addition = bundled.run(report)
    write_file(picture, lambda path: bundled.draw(addition, path), force=force)
    _show_addition(addition)
    output.print(f"\nThe picture of this is {picture}.", highlight=False)
    output.print(tables.NEXT_AFTER_DEMO, highlight=False, markup=False)
    _stop_if(addition.interrupted)


@app.command()
@_reporting
def simulate(
    model: ModelArgument,
    out: Annotated[Path, typer.Option("--output", "-o", metavar="OUT.csv", help="Table to write.")],
    data: Annotated[
        str | None,
        typer.Argument(metavar="[DATA]", help="Motor position and load; without: a smooth motion."),
    ] = None,
    mapping: MapOption = None,
    interpolation: InterpolationOption = "linear",
    own_effects: EffectOption = None,
    force: ForceOption = False,
) -> None:
    """Simulate a model and write a table.

    With DATA, the motor moves as measured, and the joint starts in the state estimated on the
    first 0.1 s (at rest in equilibrium where its position was not measured). Without DATA, ten
    seconds of a smooth multisine with a slow load that slackens the tendons.
    """
    from elastic_tendon import compiled, simulated

    check_writable(out, force=force)
    loaded = _load(model, own_effects)
    with _progress() as report:
        compiled.library_path(loaded.effect_ids, report)
    if data is None:
        table = simulated.default_table(loaded)
    else:
        from elastic_tendon.measurement import read_measurement

        measurement = read_measurement(
            data, mapping or (), interpolation=interpolation, joint_required=False
        )
        table = simulated.measured_table(loaded, measurement)
    write_text(out, table.to_csv(index=False), force=force)
    output.print(f"{len(table)} samples in {out}", highlight=False)


@app.command()
@_reporting
def export(
    model: ModelArgument,
    out: Annotated[Path, typer.Option("--output", "-o", metavar="X.fmu", help="FMU to write.")],
    fmi: Annotated[
        str, typer.Option("--fmi", metavar="2|3", help="Version of FMI: 2 for 2.0, 3 for 3.0.")
    ] = "2",
    platform: Annotated[
        list[str] | None,
        typer.Option(
            "--platform",
            metavar="NAME",
            help="Platform that the FMU is to run on, as x86_64-windows or win64; repeatable, or a "
            "list with commas, or all. Default: this one.",
        ),
    ] = None,
    source: Annotated[
        bool, typer.Option("--source", help="Pack the C code too, for other platforms.")
    ] = False,
    own_effects: EffectOption = None,
    force: ForceOption = False,
) -> None:
    """Export a model as an FMU for co-simulation and model exchange."""
    from elastic_tendon.compiler import platforms_named
    from elastic_tendon.fmu.export import export_fmu

    fmi_version = _fmi_version(fmi)
    try:
        platforms = platforms_named(platform)
    except BuildError as error:
        raise typer.BadParameter(str(error), param_hint="--platform") from None
    loaded = _load(model, own_effects)
    with _progress() as report:
        export_fmu(
            *(loaded, out),
            fmi_version=fmi_version,
            platforms=[one.name for one in platforms],
            source=source,
            overwrite=force,
            progress=report,
        )
    runs_on = ", ".join(one.name for one in platforms)
    told = f"{loaded.name} is in {out}, FMI {fmi_version}.0, for {runs_on}"
    output.print(told, highlight=False, soft_wrap=True)


@app.command()
@_reporting
def design(
    model: ModelArgument,
    plot: PlotOption = None,
    own_effects: EffectOption = None,
    force: ForceOption = False,
) -> None:
    """The design table of the paper, and the characteristic curves over pretension.

    The curves are drawn in characteristic_curves.png in the current folder unless --plot names
    another file; such a picture of an earlier call is replaced.
    """
    from elastic_tendon.design import design as design_of
    from elastic_tendon.report import tables
    from elastic_tendon.report.comparison_figures import is_ours
    from elastic_tendon.report.figures import characteristic_curves

    picture = plot or Path("characteristic_curves.png")
    force = force or (plot is None and is_ours(picture))
    _check_outputs(picture=picture, force=force)
    loaded = _load(model, own_effects)
    output.print(tables.design_table(loaded.name, design_of(loaded)))
    if loaded.effect_ids:
        output.print("The paper's equations leave out the effects of this model.", highlight=False)
    _save(characteristic_curves(loaded), picture, force)


@app.command()
@_reporting
def compare(
    model: ModelArgument,
    data: DataArgument,
    mapping: MapOption = None,
    interpolation: InterpolationOption = "linear",
    own_effects: EffectOption = None,
    json_file: JsonOption = None,
    plot: PlotOption = None,
    force: ForceOption = False,
) -> None:
    """Compare a model with measurements: how large the error is, and where it lies."""
    from elastic_tendon.identify.compare import compare as compare_with
    from elastic_tendon.report import tables

    _check_outputs(json_file, picture=plot, force=force)
    loaded = _load(model, own_effects)
    comparison = compare_with(loaded, _read(data, mapping, interpolation))
    # files first: a reader that closes the pipe must not cost the user a result
    _save_json(comparison.to_json(), json_file, force)
    if plot is not None:
        from elastic_tendon.report.comparison_figures import overlay

        _save(overlay(comparison), plot, force)
    output.print(tables.comparison_table(comparison))
    for table in tables.where_tables(comparison):
        output.print(table)


@app.command()
@_reporting
def add(
    model: ModelArgument,
    effect: Annotated[str, typer.Argument(metavar="EFFECT", help="Id, see: effects.")],
    out: Annotated[Path, typer.Option("--output", "-o", metavar="NEW.toml", help="New model.")],
    data: Annotated[
        list[str] | None,
        typer.Argument(metavar="[DATA...]", help="Fitted; file.csv or file.csv\\[start:end] in s."),
    ] = None,
    validate: Annotated[
        list[str] | None,
        typer.Option("--validate", metavar="DATA", help="Never fitted, only judges; repeatable."),
    ] = None,
    mapping: MapOption = None,
    interpolation: InterpolationOption = "linear",
    own_effects: EffectOption = None,
    json_file: JsonOption = None,
    plot: PlotOption = None,
    force: ForceOption = False,
) -> None:
    """Add an effect to a model, refit it to DATA, and show how the error falls.

    Without DATA the effect comes in at its typical values. Ctrl-C stops the fit and keeps the
    best so far.
    """
    _check_outputs(out, json_file, picture=plot, force=force)
    loaded = _load(model, own_effects)
    if not data:
        _add_typical(loaded, effect, out, bool(validate or json_file or plot), force)
        return
    from elastic_tendon.identify.add import add as add_to

    measurements, heldout = (
        _read(data, mapping, interpolation),
        _read(validate or [], mapping, interpolation),
    )
    with _progress() as report:
        addition = add_to(loaded, effect, measurements, heldout, report)
    write_text(out, addition.model.to_toml(), force=force)
    _save_json(addition.to_json(), json_file, force)
    if plot is not None:
        from elastic_tendon.report.comparison_figures import story

        _save(story(addition.steps, addition.ladder), plot, force)
    _show_addition(addition)
    output.print(f"The new model is {out}.", highlight=False)
    _stop_if(addition.interrupted)


@app.command()
@_reporting
def effects(
    effect: Annotated[str | None, typer.Argument(metavar="[ID]", help="Explain this one.")] = None,
    own_effects: EffectOption = None,
    plot: PlotOption = None,
    force: ForceOption = False,
) -> None:
    """List the effects that can be added, or explain one.

    How the one shows in torque over deflection and in a step is drawn in effect_ID.png in the
    current folder unless --plot names another file; such a picture of an earlier call is replaced.
    """
    from elastic_tendon.effects import BY_ID
    from elastic_tendon.effects.registry import package
    from elastic_tendon.report.effects import effects_table

    _load_effects(own_effects)
    if effect is not None:
        _explain(effect, plot, force)
        return
    if plot is not None:
        raise typer.BadParameter("--plot needs the ID of an effect")
    elsewhere = {name: package(entries[0]) for name, entries in BY_ID.installed().items()}
    output.print(effects_table(BY_ID.values(), elsewhere))


@app.command()
@_reporting
def cache(
    clear: Annotated[bool, typer.Option("--clear", help="Delete the compiled libraries.")] = False,
) -> None:
    """Show the folder of compiled libraries, or empty it."""
    from elastic_tendon import compiled

    if clear:
        output.print(f"{compiled.clear_cache()} compiled libraries deleted", highlight=False)
    output.print(str(compiled.cache_folder()), highlight=False, soft_wrap=True)


def _fmi_version(text: str) -> Literal[2, 3]:
    known: dict[str, Literal[2, 3]] = {"2": 2, "2.0": 2, "3": 3, "3.0": 3}
    if text not in known:
        fault = f"there is no FMI version {text!r} here; choose 2 or 3"
        raise typer.BadParameter(fault, param_hint="--fmi")
    return known[text]


def _load_effects(files: list[Path] | None) -> None:
    if files:
        from elastic_tendon.effects import load_effect

        for file in files:
            load_effect(file)


def _load(source: str, own_effects: list[Path] | None) -> "Model":
    from elastic_tendon.parameters import load_model

    _load_effects(own_effects)
    model = load_model(source)
    for warning in model.warnings():
        notice.print(f"note: {warning}", markup=False, soft_wrap=True)
    return model


def _read(
    data: list[str], mapping: list[str] | None, interpolation: Interpolation
) -> list["Measurement"]:
    from elastic_tendon.measurement import read_measurement

    measurements = [
        read_measurement(one, mapping or (), interpolation=interpolation) for one in data
    ]
    for measurement in measurements:
        for note in measurement.notes:
            notice.print(f"note: {measurement.name}: {note}", markup=False, soft_wrap=True)
    return measurements


def _add_typical(model: "Model", effect: str, out: Path, more: bool, force: bool) -> None:
    from elastic_tendon.identify.add import add_typical

    if more:
        raise typer.BadParameter("--validate, --json and --plot need DATA to fit")
    write_text(out, add_typical(model, effect).to_toml(), force=force)
    output.print(
        f"{effect} is in {out} at typical values for such an actuator; nothing was fitted. "
        "Give DATA to fit it.",
        highlight=False,
    )


def _explain(effect_id: str, plot: Path | None, force: bool) -> None:
    from elastic_tendon.identify.add import effect_by_id
    from elastic_tendon.parameters import load_model
    from elastic_tendon.report.comparison_figures import is_ours
    from elastic_tendon.report.effects import effect_page
    from elastic_tendon.report.signature_figure import signature_figure
    from elastic_tendon.signature import signature

    effect = effect_by_id(effect_id)
    picture = plot or Path(f"effect_{effect_id}.png")
    force = force or (plot is None and is_ours(picture))
    _check_outputs(picture=picture, force=force)
    example = load_model(EXAMPLE)
    output.print(effect_page(effect, example), highlight=False)
    _save(signature_figure(signature(effect, example)), picture, force)


def _show_addition(addition: "Addition") -> None:
    from elastic_tendon.report import tables

    output.print(tables.ladder_table(addition.ladder))
    output.print(tables.estimates_table(addition.findings))
    if addition.findings.ratios:
        output.print(tables.ratios_table(addition.findings))
    for sentence in (*tables.addition_sentences(addition), *addition.findings.sentences):
        output.print(sentence, highlight=False, markup=False)


@contextmanager
def _progress() -> Iterator["Report"]:
    """A bar on stderr where that is a terminal; yields the function that moves it."""
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    quiet = not notice.is_terminal
    with Progress(*columns, console=notice, transient=True, disable=quiet) as progress:
        task = progress.add_task("", total=1.0)

        def report(text: str, share: float) -> None:
            progress.update(task, description=text, completed=share)

        yield report


def _check_outputs(*paths: Path | None, picture: Path | None, force: bool) -> None:
    if picture is not None:
        from elastic_tendon.report.comparison_figures import check_picture

        check_picture(picture)
    for path in (*paths, picture):
        if path is not None:
            check_writable(path, force=force)


def _save(figure: "Figure", path: Path, force: bool) -> None:
    from elastic_tendon.report.comparison_figures import save

    write_file(path, lambda target: save(figure, target), force=force)
    output.print(f"The picture is {path}.", highlight=False)


def _save_json(content: dict[str, Any], path: Path | None, force: bool) -> None:
    if path is not None:
        write_text(path, json.dumps(content, indent=2, allow_nan=False) + "\n", force=force)


def _stop_if(interrupted: bool) -> None:
    if interrupted:
        notice.print(
            "elastic-tendon: stopped before the fit had converged; these numbers and intervals "
            "are only the best so far"
        )
        raise typer.Exit(INTERRUPTED)


if __name__ == "__main__":
    main()
