"""The command that opens the app in the user's browser."""

import webbrowser
from contextlib import suppress
from math import inf, isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

import elastic_tendon as et
from elastic_tendon.cli.reading import ValidateOption, reading
from elastic_tendon.cli.shared import (
    EffectOption,
    InterfaceOption,
    app,
    load,
    load_effects,
    notice,
    output,
    reporting,
)

if TYPE_CHECKING:
    from elastic_tendon.app.document import Source

EXAMPLE = "biorob_x4_joint_3"  # what the app begins with where no model is named
LOOPBACK = "127.0.0.1"


@app.command(name="app")
@reporting
@reading
def open_app(
    model: Annotated[
        str | None,
        typer.Argument(metavar="[MODEL]", help="A model.toml, or the name of a bundled model."),
    ] = None,
    data: Annotated[
        list[str] | None,
        typer.Argument(metavar="[DATA...]", help="file.csv, or file.csv\\[start:end] in s."),
    ] = None,
    validate: ValidateOption = None,
    demo: Annotated[
        bool, typer.Option("--demo", help="Begin with the demo's model and recordings.")
    ] = False,
    *,
    options: "et.ReadOptions",
    own_effects: EffectOption = None,
    interface: InterfaceOption = None,
    session: Annotated[
        Path | None,
        typer.Option(
            "--session",
            metavar="FILE",
            help="Keep the session in FILE after each step. Where FILE has one, it goes on where "
            "it was, and a model and data named here are left out.",
        ),
    ] = None,
    port: Annotated[
        int, typer.Option(min=0, max=65535, help="To listen on; 0: any that is free.")
    ] = 0,
    browser: Annotated[
        bool, typer.Option("--browser/--no-browser", help="Open the page in the browser.")
    ] = True,
    network: Annotated[
        str | None,
        typer.Option(
            "--open-to-the-network",
            metavar="ADDRESS",
            help="Let other machines in, by this address of this machine. Whoever has the URL can "
            "use the app, and what is sent is not encrypted.",
        ),
    ] = None,
) -> None:
    """Walk the loop on a page in your browser: compare, see where, find which effect, add it.

    Only this machine can reach the page, by the URL that is printed. Ctrl-C ends it.
    """
    if demo and (model or data or validate):
        raise typer.BadParameter("--demo brings its own model and data; leave yours out")
    try:
        from elastic_tendon.app.document import new_document
        from elastic_tendon.app.server import listen
        from elastic_tendon.app.session_file import open_session
    except ModuleNotFoundError as error:
        raise et.ElasticTendonError(
            f'the app needs {error.name}, which is not installed; pip install "elastic-tendon[app]"'
        ) from None
    from elastic_tendon import demo as bundled

    if demo:
        model = str(bundled.DATA / "demo_model.toml")
        data = [str(bundled.DATA / "demo_fit.csv")]
        validate = [str(bundled.DATA / "demo_validate.csv")]
    load_effects(own_effects)
    kept = None if session is None else open_session(session)
    before = None if kept is None else kept.reopen()
    if before is not None:
        start, files = before.document, dict(before.files)
        for note in (*_left_out(session, model), *before.notes):
            notice.print(f"note: {note}", markup=False, soft_wrap=True)
    else:
        files = {}
        sources = [_source(recording, "fit", options, files) for recording in data or []]
        sources += [_source(recording, "validate", options, files) for recording in validate or []]
        start = new_document(load(model or EXAMPLE, None, interface), sources)
        if kept is not None:
            kept.begin(start, files)
    served = listen(start, files, address=network or LOOPBACK, port=port, kept=kept)
    if network is not None:
        notice.print("note: other machines can reach the app, and what is sent is not encrypted")
    try:
        with suppress(KeyboardInterrupt):  # the way to end it
            output.print(f"The app is at {served.url}", highlight=False, soft_wrap=True)
            output.print("Ctrl-C ends it.", highlight=False)
            if browser:
                webbrowser.open(served.url)
            served.run()
    finally:
        served.close()


def _left_out(session: Path | None, model: str | None) -> list[str]:
    """What becomes of a model that is named beside a session that goes on."""
    words = f"{session} goes on where it was; the model and data named beside it are left out"
    return [] if model is None else [words]


def _source(data: str, role: str, options: "et.ReadOptions", files: dict[str, Path]) -> "Source":
    """A recording of the command line as the app keeps it; its path stays here."""
    from elastic_tendon.app.document import Source
    from elastic_tendon.measurement.reader import split_window

    path, window = split_window(data)
    key = f"named-{len(files)}"
    files[key] = path.resolve()
    return Source.model_validate(
        {
            "key": key,
            "name": path.name,
            "role": role,
            "options": options,
            "window": tuple(end if isfinite(end) else None for end in window or (inf, inf)),
        }
    )
