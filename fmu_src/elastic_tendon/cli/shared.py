"""What the commands share: options, messages, progress, and files that are written whole."""

import functools
import json
import shlex
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ParamSpec

import typer
from rich.console import Console

import elastic_tendon as et
from elastic_tendon.actuator.motion_kind import MotionKind
from elastic_tendon.output import (
    check_writable,
    write_file,
    write_folder,
    write_text,
    written,
)
from elastic_tendon.progress import Progress

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from rich.text import Text

INTERRUPTED = 130

app = typer.Typer(
    name="elastic-tendon",
    no_args_is_help=True,
)


class Worded(Console):
    """A console that writes in the units and words of the machine at hand, see `load`."""

    motion = MotionKind.ROTARY

    def render_str(self, text: str, **how: Any) -> "Text":
        """Text of a string, such as a cell of a table."""
        return super().render_str(self.motion.words(text), **how)


output = Worded()
notice = Console(stderr=True, highlight=False)  # its sentences name units as they were given

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
InterfaceOption = Annotated[
    str | None,
    typer.Option(
        "--interface",
        metavar="position|torque|joint|torque_joint",
        help="What is given and what is computed; default: as the model says.",
    ),
]
ForceOption = Annotated[bool, typer.Option("--force", help="Replace files that exist.")]
JsonOption = Annotated[
    Path | None, typer.Option("--json", metavar="F", help="Write the result as JSON.")
]
PlotOption = Annotated[
    Path | None, typer.Option("--plot", metavar="F", help="Write a picture (.png, .svg, .pdf).")
]

FiguresOption = Annotated[
    Path | None,
    typer.Option("--figures", metavar="FOLDER", help="Draw all figures into a new folder."),
]

ReportOption = Annotated[
    Path | None,
    typer.Option(
        "--report",
        metavar="F.html",
        help="Write all of it as one page that needs no network and can be printed.",
    ),
]


def reporting(function: Callable[Parameters, None]) -> Callable[Parameters, None]:
    """Turn the errors that users can meet into one line and an exit status."""

    @functools.wraps(function)
    def run(*args: Parameters.args, **kwargs: Parameters.kwargs) -> None:
        written.clear()
        try:
            function(*args, **kwargs)
        except et.ElasticTendonError as error:
            notice.print(f"elastic-tendon: {error}", markup=False, soft_wrap=True)
            raise typer.Exit(1) from None
        except KeyboardInterrupt:
            left = ", ".join(map(str, written))
            outcome = f"but {left} had been written" if left else "nothing was written"
            notice.print(f"elastic-tendon: stopped, {outcome}", markup=False, soft_wrap=True)
            raise typer.Exit(INTERRUPTED) from None

    return run


def load_effects(files: list[Path] | None) -> None:
    for file in files or ():
        et.effects.load(file)


def load(source: str, own_effects: list[Path] | None, interface: str | None = None) -> "et.Model":
    load_effects(own_effects)
    model = et.load_model(source)
    if interface is not None:
        model = model.at(interface)
    output.motion = model.motion
    for warning in model.warnings():
        notice.print(f"note: {warning}", markup=False, soft_wrap=True)
    return model


@contextmanager
def progress_bar() -> Iterator["Progress"]:
    """A bar on stderr where that is a terminal; yields the function that moves it."""
    from rich.progress import BarColumn, TextColumn, TimeElapsedColumn
    from rich.progress import Progress as Bar

    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    quiet = not notice.is_terminal
    with Bar(*columns, console=notice, transient=True, disable=quiet) as bar:
        task = bar.add_task("", total=1.0)

        def progress(text: str, share: float) -> None:
            bar.update(task, description=text, completed=share)

        yield progress


def check_outputs(
    *paths: Path | None, picture: Path | None, force: bool, read: Sequence[str] = ()
) -> None:
    """Refuse, before any work is done, outputs that could not be written after it.

    Parameters
    ----------
    paths, picture : to be written; None where they are not asked for
    force : whether files that exist may be replaced
    read : what the command reads, as its user gave it; that is never replaced
    """
    if picture is not None:
        from elastic_tendon.reports.comparison_figures import check_picture

        check_picture(picture)
    asked = [path for path in (*paths, picture) if path is not None]
    places = [path.resolve() for path in asked]
    if len(set(places)) < len(places):
        raise typer.BadParameter("two outputs have the same name; give each its own")
    for source in read:
        if Path(source).resolve() in places or Path(source.split("[")[0]).resolve() in places:
            raise typer.BadParameter(f"{source} is read; give the output another name")
    for path in asked:
        check_writable(path, force=force)


def check_page(path: Path | None) -> None:
    """Refuse, before any work is done, a report that no browser would open."""
    if path is not None and path.suffix.lower() != ".html":
        raise et.OutputError(f"{path}: a report is a page for a browser; let its name end in .html")


def command_line() -> str:
    """The command that runs, to type it again."""
    return shlex.join(["elastic-tendon", *sys.argv[1:]])


def made_by(fitted: Iterable[str] = (), heldout: Iterable[str] = ()) -> list[str]:
    """First lines of what stands at the head of a model.toml, see `reports.provenance`.

    Parameters
    ----------
    fitted, heldout : names of the recordings
    """
    from importlib.metadata import version

    lines = [f"made by elastic-tendon {version('elastic-tendon')}: {command_line()}"]
    for words, names in (("fitted", fitted), ("held out", heldout)):
        if listed := ", ".join(names):
            lines.append(f"{words}: {listed}")
    return lines


def sources(
    model: str,
    read: "Mapping[str, Sequence[et.Measurement]]",
    mapping: Sequence[str],
    own_effects: Sequence[Path] | None,
) -> list[tuple[str, Path]]:
    """What a command read, as purpose and path, for the origin of a report.

    Parameters
    ----------
    model : as given; the name of a bundled one is the path of no file
    read : what measurements were used for, and the measurements
    mapping : values of --map
    own_effects : files of --effect
    """
    paths = [("model", Path(model))]
    for used, measurements in read.items():
        for recording in measurements:
            # beside a recording may lie how to read it
            paths += [
                (used, Path(recording.source)),
                ("how to read it", Path(f"{recording.source}.toml")),
            ]
    paths += [("how to read it", Path(item)) for item in mapping]
    return paths + [("effect", file) for file in own_effects or ()]


def save_picture(figure: "Figure", path: Path, force: bool) -> None:
    from elastic_tendon.reports.comparison_figures import save
    from elastic_tendon.reports.worded import worded_figure

    worded = worded_figure(figure, output.motion)
    write_file(path, lambda target: save(worded, target), force=force)
    output.print(f"The picture is {path}.", highlight=False)


def save_figures(
    drawings: Iterable[tuple[str, Callable[[], "Figure"]]],
    folder: Path,
    force: bool,
    progress: "Progress",
) -> None:
    """Draw into a folder; `drawings` are names of files without suffix, and what draws each."""
    from elastic_tendon.reports.comparison_figures import save
    from elastic_tendon.reports.worded import worded_figure

    def write(target: Path) -> None:
        every = list(drawings)
        for index, (name, draw) in enumerate(every):
            progress(f"drawing {name}", index / len(every))
            save(worded_figure(draw(), output.motion), target / f"{name}.png")

    write_folder(folder, write, force=force)


def save_json(content: dict[str, Any], path: Path | None, force: bool) -> None:
    if path is not None:
        write_text(path, json.dumps(content, indent=2, allow_nan=False) + "\n", force=force)
