"""Commands about a model alone: export it, design it, look up effects."""

from pathlib import Path
from typing import Annotated, Literal

import typer

import elastic_tendon as et
from elastic_tendon.cli.evidence import (
    EvidenceDataOption,
    EvidenceDiagnosisOption,
    EvidenceKeptOption,
    OutsideValidityOption,
    SignOption,
    check_belonging,
    gathered,
)
from elastic_tendon.cli.reading import reading
from elastic_tendon.cli.shared import (
    EffectOption,
    ForceOption,
    InterfaceOption,
    ModelArgument,
    PlotOption,
    app,
    check_outputs,
    load,
    load_effects,
    output,
    progress_bar,
    reporting,
    save_picture,
)

EXAMPLE = "biorob_x4_joint_3"  # bundled model for which typical values are shown


@app.command()
@reporting
@reading
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
    with_evidence: EvidenceDataOption = None,
    keep: EvidenceKeptOption = "data",
    diagnosis: EvidenceDiagnosisOption = None,
    sign: SignOption = None,
    outside_validity: OutsideValidityOption = False,
    *,
    options: "et.ReadOptions",
    own_effects: EffectOption = None,
    interface: InterfaceOption = None,
    force: ForceOption = False,
) -> None:
    """Export a model as an FMU for co-simulation and model exchange.

    A model with many effects of springs and tendons together compiles for minutes.
    """
    from elastic_tendon.fmu.packing import checked_path
    from elastic_tendon.native.compiler import platforms_named

    fmi_version = _fmi_version(fmi)
    try:
        platforms = platforms_named(platform)
    except et.BuildError as error:
        raise typer.BadParameter(str(error), param_hint="--platform") from None
    check_belonging(with_evidence, diagnosis, sign, outside_validity=outside_validity)
    checked_path(out, overwrite=force)
    loaded = load(model, own_effects, interface)
    with progress_bar() as progress:
        evidence = (
            gathered(loaded, with_evidence, options, diagnosis, keep, progress)
            if with_evidence
            else None
        )
        et.export_fmu(
            *(loaded, out),
            fmi_version=fmi_version,
            platforms=[target.name for target in platforms],
            source=source,
            evidence=evidence,
            sign=sign,
            outside_validity=outside_validity,
            overwrite=force,
            progress=progress,
        )
    runs_on = ", ".join(target.name for target in platforms)
    sentence = f"{loaded.name} is in {out}, FMI {fmi_version}.0, for {runs_on}"
    output.print(sentence, highlight=False, soft_wrap=True)
    if evidence is not None:
        output.print(repr(evidence), highlight=False, soft_wrap=True, markup=False)


@app.command()
@reporting
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
    from elastic_tendon.reports import tables
    from elastic_tendon.reports.comparison_figures import is_ours
    from elastic_tendon.reports.figures import characteristic_curves

    picture = plot or Path("characteristic_curves.png")
    force = force or (plot is None and is_ours(picture))
    check_outputs(picture=picture, force=force)
    loaded = load(model, own_effects)
    output.print(tables.design_table(loaded.name, et.design(loaded)))
    if loaded.effect_ids:
        output.print("The paper's equations leave out the effects of this model.", highlight=False)
    save_picture(characteristic_curves(loaded), picture, force)


@app.command()
@reporting
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
    from elastic_tendon.reports.effects import effects_table

    load_effects(own_effects)
    if effect is not None:
        _explain(effect, plot, force)
        return
    if plot is not None:
        raise typer.BadParameter("--plot needs the ID of an effect")
    elsewhere = {name: package(entries[0]) for name, entries in BY_ID.installed().items()}
    output.print(effects_table(BY_ID.values(), elsewhere))


@app.command()
@reporting
def cache(
    clear: Annotated[bool, typer.Option("--clear", help="Delete the compiled libraries.")] = False,
) -> None:
    """Show the folder of compiled libraries, or empty it."""
    from elastic_tendon.native.library import cache_folder, clear_cache

    if clear:
        output.print(f"{clear_cache()} compiled libraries deleted", highlight=False)
    output.print(str(cache_folder()), highlight=False, soft_wrap=True)


def _fmi_version(text: str) -> Literal[2, 3]:
    known: dict[str, Literal[2, 3]] = {"2": 2, "2.0": 2, "3": 3, "3.0": 3}
    if text not in known:
        fault = f"there is no FMI version {text!r} here; choose 2 or 3"
        raise typer.BadParameter(fault, param_hint="--fmi")
    return known[text]


def _explain(effect_id: str, plot: Path | None, force: bool) -> None:
    from elastic_tendon.estimation.add import effect_by_id
    from elastic_tendon.reports.comparison_figures import is_ours
    from elastic_tendon.reports.effects import effect_page
    from elastic_tendon.reports.signature_figure import signature_figure
    from elastic_tendon.simulation.signature import signature

    effect = effect_by_id(effect_id)
    picture = plot or Path(f"effect_{effect_id}.png")
    force = force or (plot is None and is_ours(picture))
    check_outputs(picture=picture, force=force)
    example = et.load_model(EXAMPLE)
    output.print(effect_page(effect, example), highlight=False)
    save_picture(signature_figure(signature(effect, example)), picture, force)
