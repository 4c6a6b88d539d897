"""Write the bundled models of real machines, with the numbers that their recordings say.

    python build_scripts/make_identified_models.py [--data FOLDER] [--only NAME...] [--output DIR]

Each begins from the model of `scoreboard.py`, takes the effects that are named here and is fitted
to the part of the recordings that is to be fitted; the other part is simulated once, after that.
Numbers that the recordings determine stand in the file with their 95 % intervals, the others as
they were given.
"""

import argparse
import re
import sys
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import elastic_tendon as et
from scoreboard import DATA, MACHINES, Machine

MODELS = Path(et.__file__).parent / "models"
DIGITS = 6  # of a number in a file, far finer than its interval
WIDTH = 96  # of a comment


@dataclass(frozen=True)
class Identified:
    """A bundled model: of which machine of the scoreboard, with which effects, what is told of it.

    `about` : the machine, who recorded it, and what its numbers mean where that is not plain.
    """

    name: str
    machine: str
    effects: tuple[str, ...]
    about: str


MODELS_MADE = (
    Identified(
        "muir_bench",
        "muir",
        ("coulomb_friction",),
        "Bench actuator with two springs between a motor pulley and an output pulley, of the UW "
        "Mechatronics Capstone 2020 series elastic actuator (GitHub: "
        "jamesdarrenmuir/Mechatronics-Capstone, MIT licence). bench_actuator is the same before "
        "it was fitted.",
    ),
    Identified(
        "mrd_tool_4",
        "mrd, slow",
        ("tendon_guide_friction",),
        "Cable-driven jaw of a surgical tool, a Maryland dissector (GitHub: "
        "MRDLab/mis-tool-characterization, Tool_4_Maryland_L_4, ODbL 1.0; O'Neill, Stephens and "
        "Kowalewski, IEEE RA-L 3(4), 2018). mrd_jaw is the same before it was fitted.",
    ),
)


def made(entry: Identified, folder: Path) -> str:
    """The content of the model.toml."""
    machine = next(one for one in MACHINES if one.name == entry.machine)
    fitted, test = machine.fitted(folder), machine.test(folder)
    found = et.add(machine.model(), entry.effects, fitted)
    values = {path: rounded(value, DIGITS) for path, value in found.model.values().items()}
    sigmas = {path: rounded(sigma, 2) for path, sigma in found.model.uncertainty.items()}
    model = found.model.with_values(values)
    model = model.model_copy(update={"name": entry.name, "uncertainty": sigmas})
    errors = machine.scale * found.ladder[-1].rmse[machine.signal], error_on(model, test, machine)
    return (
        f"{comment(entry, machine, (fitted, test), errors)}{ratios(found)}{annotated(model, found)}"
    )


def error_on(model: et.Model, recording: et.Measurement, machine: Machine) -> float:
    """RMS error of a simulation in the machine's unit."""
    return machine.scale * et.compare(model, recording).rmse()[machine.signal]


def comment(
    entry: Identified,
    machine: Machine,
    parts: tuple[et.Measurement, et.Measurement],
    errors: tuple[float, float],
) -> str:
    """Where the machine and its numbers come from, as lines of a comment."""
    (fitted, test), (seen, unseen) = parts, errors
    found = (
        f"Identified by build_scripts/make_identified_models.py with {', '.join(entry.effects)}. "
        f"RMS error of {machine.signal} on what was fitted ({fitted.name}): {seen:.3g} "
        f"{machine.unit}; on what was not ({test.name}): {unseen:.3g} {machine.unit}. Intervals "
        "are of 95 %; numbers without one are as they were given, or the recording leaves them "
        "open."
    )
    lines = [line for text in (entry.about, found) for line in textwrap.wrap(text, WIDTH)]
    return "".join(f"# {line}\n" for line in lines)


def ratios(found: et.Addition) -> str:
    """What a recording without known loads says although it leaves a common scale open."""
    said = [
        f"# {one.name} = {one.value:.4g} {one.unit}, {low:.4g} to {high:.4g}\n"
        for one in found.findings.ratios
        for low, high in [one.interval]
    ]
    return "".join(["# Without a known load only ratios are determined:\n", *said]) if said else ""


def annotated(model: et.Model, found: et.Addition) -> str:
    """The model.toml with the interval of each number that the recording determines."""
    determined = {one.path: one for one in found.findings.estimates if one.determined}
    lines, section = [], ""
    for line in model.to_toml().splitlines():
        if table := re.fullmatch(r"\[(.*)\]", line):
            section = f"{table[1]}."
        key = line.partition(" = ")[0]
        estimate = determined.get(f"{section}{key}")
        if estimate is not None:
            low, high = (rounded(end, 4) for end in estimate.interval)
            line += f"  # {estimate.unit}, {low:g} to {high:g}"
        lines.append(line)
    return "\n".join(lines) + "\n"


def rounded(value: float, digits: int) -> float:
    """To so many significant digits."""
    return float(f"{value:.{digits}g}")


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the files; exit status 1 where a recording is not at hand."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--data", type=Path, default=DATA, help="folder of the recordings")
    parser.add_argument("--only", nargs="+", default=[one.name for one in MODELS_MADE])
    parser.add_argument("--output", type=Path, default=MODELS, help="folder to write to")
    given = parser.parse_args(arguments)
    sources = {one.name: one.source for one in MACHINES}
    for entry in MODELS_MADE:
        if entry.name not in given.only:
            continue
        if not (given.data / sources[entry.machine]).is_file():
            print(f"{given.data} has no {sources[entry.machine]}; name its folder with --data")
            return 1
        path = given.output / f"{entry.name}.toml"
        path.write_text(made(entry, given.data), "utf-8")
        print(path)
    return 0


if __name__ == "__main__":
    sys.exit(main())
