"""Known machines: what `build_scripts/scoreboard.py --keep` found, as a page and as pictures.

Simulated machines of other kinds follow, as `build_scripts/study_other_machines.py --keep` wrote.
"""

import ast
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from benchmarking import known_misses
from elastic_tendon.reports.comparison_figures import BLUE, VERMILLION, tidy
from site_pages import Pages
from site_pages.markdown import plain, table

SCRIPT = Path(__file__).resolve().parents[1] / "scoreboard.py"
KEPT = SCRIPT.with_suffix(".json")
OTHER_KINDS = SCRIPT.with_name("other_machines.json")
GREY = "0.6"
PICTURES = "known_machines"

Outcome = Mapping[str, Any]  # of one machine, as `scoreboard.as_json` writes it


def pages(folder: Path) -> Pages:
    """The page of all machines; its pictures go to a folder beside it."""
    outcomes = json.loads(KEPT.read_text("utf-8"))
    (folder / PICTURES).mkdir()
    _save(summary_figure(outcomes), folder / PICTURES / "all.svg")
    parts = ["# Known machines", _rules(), f"![Errors on the test parts]({PICTURES}/all.svg)"]
    heading = ("machine", "named", "test part: as given", "improved", "published", "time")
    parts.append(table(heading, map(_row, outcomes)))
    for number, outcome in enumerate(outcomes):
        picture = f"{PICTURES}/{number}.svg"
        _save(errors_figure(outcome), folder / picture)
        parts += [*_section(outcome), f"![Largest errors on the test part]({picture})"]
    parts += _other_kinds(json.loads(OTHER_KINDS.read_text("utf-8")))
    yield "known_machines.md", "\n\n".join(parts)


def _rules() -> str:
    """As the script that keeps them says, without how it is called."""
    text = ast.get_docstring(ast.parse(SCRIPT.read_text())) or ""
    first, *_, rules = text.split("\n\n")
    return f"{first} {rules}"


def _row(outcome: Outcome) -> list[str]:
    unit = outcome["unit"]
    before, after = (f"{outcome[name][1]:.3g} {unit}" for name in ("before", "after"))
    named = " and ".join(f"[{name}](effects/{name}.md)" for name in outcome["added"]) or "nothing"
    time = f"{outcome['seconds']} s"
    return [outcome["machine"], named, before, after, plain(outcome["published"]), time]


def _section(outcome: Outcome) -> list[str]:
    """What was given and said, the error of the fitted part after each step, and what is missed."""
    ladder = zip(outcome["steps"], outcome["errors"], strict=True)
    steps = [(plain(title), f"{error:.3g} {outcome['unit']}") for title, error in ladder]
    calls = f"The test part was simulated {outcome['calls']} times by this script."
    bundled = f"Bundled: {plain(outcome['bundled'])}."
    return [
        f"## {outcome['machine']}",
        f"Given: {plain(outcome['given'])}. {plain(outcome['sentence'])} {calls} {bundled}",
        *_missed(outcome),
        table(("step", "error of the fitted part"), steps),
        *_learned(outcome),
    ]


def _learned(outcome: Outcome) -> list[str]:
    """What was learned from what remains, and what it leaves."""
    if not (learned := outcome.get("learned")):
        return []
    fit, test = (f"{error:.3g} {outcome['unit']}" for error in learned["after"])
    return [
        f"{plain(learned['title'])}. Added to these and fitted once more, it leaves {fit} of the "
        f"fitted part and {test} of the test part."
    ]


def _missed(outcome: Outcome) -> list[str]:
    """Each target that is missed, and why."""
    known = known_misses()
    sentences = [
        f"* {plain(what.removeprefix(outcome['machine'] + ': '))}: {plain(known[what])}"
        for what in outcome["missed"]
    ]
    return ["Missed:\n\n" + "\n".join(sentences)] if sentences else []


def _other_kinds(rows: Sequence[Outcome]) -> list[str]:
    """What was named on simulated machines that are no tendon arms."""
    right = sum(row["right"] for row in rows)
    cells = (
        [
            plain(row["kind"]),
            row["hidden"],
            plain(" + ".join(row["named"]) or "nothing"),
            "yes" if row["right"] else "no",
            f"{row['ratio']:.3g}",
        ]
        for row in rows
    )
    heading = ("kind", "hidden", "named", "right", "error over noise")
    return [
        "## Simulated machines of other kinds",
        "Seven kinds of machine, three of each, whose laws are not those of the catalogue, with "
        "seeds from which nothing was tuned (`build_scripts/study_other_machines.py --seeds "
        f"report`). Of the {len(rows)} that were run {right} are named rightly.",
        table(heading, cells),
    ]


def _save(figure: Figure, path: Path) -> None:
    with mpl.rc_context({"svg.hashsalt": path.name}):
        figure.savefig(path, metadata={"Date": None})


def summary_figure(outcomes: Sequence[Outcome]) -> Figure:
    """Errors on the test parts, each over that of the model as given, beside the published ones."""
    figure = Figure(figsize=(7.0, 0.9 + 0.42 * len(outcomes)), layout="constrained")
    axes = figure.subplots()
    for number, outcome in enumerate(outcomes):
        (_, before), (_, after), best = outcome["before"], outcome["after"], outcome["best"]
        axes.plot([after / before, 1.0], [number, number], color=GREY, linewidth=1.5, zorder=1)
        axes.plot(1.0, number, "o", color=GREY, label=_once("model as given", number))
        axes.plot(after / before, number, "o", color=BLUE, label=_once("after diagnose", number))
        if best is not None:
            label = _once("published, or fitted by hand", number)
            axes.plot(best / before, number, "D", color=VERMILLION, fillstyle="none", label=label)
        text = f"{before:.3g} to {after:.3g} {outcome['unit']}"
        axes.annotate(text, (1.0, number), (8, 0), textcoords="offset points", va="center")
    axes.set_yticks(range(len(outcomes)), [outcome["machine"] for outcome in outcomes])
    axes.invert_yaxis()
    axes.set_xscale("log")
    axes.set_xlim(right=6.0)  # the figures in words stand there
    axes.xaxis.set_major_formatter(lambda share, _place: f"{100.0 * share:g} %")
    axes.set_xlabel("error on a recording that no fit has seen, over that of the model as given")
    _legend_above(axes)
    tidy(axes)
    return figure


def _legend_above(axes: Axes) -> None:
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3, frameon=False)


def _once(label: str, number: int) -> str | None:
    """A label for the legend, of the first row alone."""
    return label if number == 0 else None


def errors_figure(outcome: Outcome) -> Figure:
    """Largest errors on the test part over time, before and after."""
    figure = Figure(figsize=(7.0, 2.6), layout="constrained")
    axes, largest = figure.subplots(), outcome["largest"]
    for name, colour, label in (("before", GREY, "model as given"), ("after", BLUE, "improved")):
        axes.step(largest["time_s"], largest[name], color=colour, where="post", label=label)
    axes.set_xlabel("time (s)")
    axes.set_ylabel(f"largest error ({outcome['unit']})")
    axes.set_yscale("log")
    _legend_above(axes)
    tidy(axes)
    return figure
