"""The proof that an FMU carries: what export gathers, and the command that checks it: verify."""

import shlex
import sys
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Literal

import typer

import elastic_tendon as et
from elastic_tendon.cli.reading import MapOption, read_all, read_options
from elastic_tendon.cli.shared import (
    ForceOption,
    JsonOption,
    app,
    check_outputs,
    output,
    reporting,
    save_json,
)
from elastic_tendon.progress import Progress

EvidenceDataOption = Annotated[
    list[str] | None,
    typer.Option(
        "--with-evidence",
        metavar="DATA",
        help="Pack proof: this recording (file.csv, or file.csv\\[start:end]), what the model "
        "makes of it, its error and the range of motion; for verify. Repeatable.",
    ),
]
EvidenceKeptOption = Annotated[
    Literal["data", "hashes"],
    typer.Option("--evidence", help="Pack what was measured, or only hashes of it and the errors."),
]
EvidenceDiagnosisOption = Annotated[
    Path | None,
    typer.Option(
        "--diagnosis",
        metavar="F.json",
        help="With evidence: what diagnose --json wrote when it found this model.",
    ),
]
SignOption = Annotated[
    Path | None,
    typer.Option(
        "--sign", metavar="KEY.pem", help="Sign the evidence with this Ed25519 key (PEM)."
    ),
]
OutsideValidityOption = Annotated[
    bool,
    typer.Option(
        "--outside-validity",
        help="With evidence: a Boolean output that tells when inputs or motion leave the range of "
        "the recordings.",
    ),
]


@app.command()
@reporting
def verify(
    fmu: Annotated[Path, typer.Argument(metavar="X.fmu", help="An FMU with evidence.")],
    importer: Annotated[
        Literal["fmpy", "ecos", "libcosim"],
        typer.Option(help="What runs it; measured data are replayed by fmpy alone."),
    ] = "fmpy",
    public_key: Annotated[
        Path | None,
        typer.Option("--public-key", metavar="K.pem", help="The key it has to be signed with."),
    ] = None,
    inputs: Annotated[
        str | None,
        typer.Option(
            "--inputs",
            metavar="PLANNED.csv",
            help="Tell whether this motion leaves the range in which the model was validated.",
        ),
    ] = None,
    mapping: MapOption = None,
    json_file: JsonOption = None,
    force: ForceOption = False,
) -> None:
    """Check that an FMU is as it was sealed, and does what its evidence says.

    Its own binary is run beside its reference results and what was measured. Exit status 1 if
    anything differs.
    """
    read = [str(path) for path in (fmu, public_key, inputs) if path is not None]
    check_outputs(json_file, picture=None, force=force, read=read)
    planned = None if inputs is None else _planned(inputs, mapping)
    found = et.verify(fmu, importer=importer, public_key=public_key, inputs=planned)
    output.print(found.summary(), highlight=False, soft_wrap=True, markup=False)
    save_json(found.to_dict(), json_file, force)
    if not found.passed:
        raise typer.Exit(1)


def _planned(inputs: str, mapping: list[str] | None) -> "et.Measurement":
    """A motion that need not have been recorded."""
    from elastic_tendon.measurement.reader import read_measurement

    return read_measurement(inputs, replace(read_options(mapping), joint_required=False))


def check_belonging(
    data: Sequence[str] | None,
    diagnosis: Path | None,
    sign: Path | None,
    *,
    outside_validity: bool,
) -> None:
    """Refuse options that say something of evidence where none was asked for."""
    given = {"--diagnosis": diagnosis, "--sign": sign, "--outside-validity": outside_validity}
    for name, value in given.items():
        if value and not data:
            fault = "it belongs to evidence; name a recording with --with-evidence too"
            raise typer.BadParameter(fault, param_hint=name)


def gathered(
    model: "et.Model",
    data: Sequence[str],
    options: "et.ReadOptions",
    diagnosis: Path | None,
    keep: Literal["data", "hashes"],
    progress: Progress,
) -> "et.Evidence":
    """Evidence of a model and the recordings that were named."""
    return et.gather_evidence(
        model,
        read_all(model, data, options, progress),
        diagnosis=diagnosis,
        keep=keep,
        command=shlex.join(["elastic-tendon", *_names_alone(sys.argv[1:])]),
    )


def _names_alone(words: Sequence[str]) -> Iterator[str]:
    """Words of the command with the names of files alone, wherever these lie."""
    for word in words:
        head, equals, text = word.rpartition("=")
        path = Path(text)
        is_file = path.name != text and path.parent.is_dir()
        yield f"{head}{equals}{path.name if is_file else text}"
