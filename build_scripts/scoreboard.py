"""Known machines, diagnosed as any user would, beside the best published figures.

    python build_scripts/scoreboard.py [--data FOLDER] [--only NAME...] [--keep]

`--keep` writes what was found to scoreboard.json beside this script, of which the site makes the
page "Known machines", and draws the picture of it in the README. A run without it only adds to the
count of calls there.

Rules, the same for every machine: the model is written from the data sheet or from nothing; one
call of `diagnose` with its defaults on the part to fit; a curve that it learned from what remains
is added to the answer, fitted once more to 25 000 samples at most, and has rows of its own; the
test part is simulated after that, once with each model; no option that another machine does not
get; every search draws its random numbers from fixed seeds. scoreboard.json counts the runs of this
script on each test part, kept or not. The count begins with the runs whose results it held; test
parts were simulated during development before that too, so they are not unseen by its authors.
Published figures are quoted from memory of the papers named beside them, of which we could not read
the results again.
"""

import argparse
import json
import re
import sys
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

import elastic_tendon as et
from benchmarking import Row, at_most, print_rows
from elastic_tendon.effects import BY_ID
from site_pages.known_machines import KEPT, summary_figure

DATA = Path(__file__).resolve().parents[2] / "shared" / "data"
PICTURE = Path(__file__).resolve().parents[1] / "examples" / "known_machines" / "errors.png"
Array = NDArray[np.float64]
Content = dict[str, Any]  # of one machine in scoreboard.json
BINS = 300  # of time, of which each shows its largest error
ARROW = 40_700  # samples of Silverbox, before its multisines
AFTER_THE_HAND = 3.3  # s, when nobody touches the muir bench any more
LEARNED_SAMPLES = 25_000  # from the beginning, to which a learned curve is fitted once more
CLOSE = 5.0  # %, by which numbers may differ from the literature's
LOOP_CLOSE = 10.0  # %, by which the width of a hysteresis may
PLACES, PLACES_APART = 20, 400  # at which that is measured; shares of a recording that tell a way


@dataclass(frozen=True)
class Machine:
    """A machine: how its model as given and its recordings come about, and what is hoped for.

    `given` : what the model as given comes from. `published` : best known figure and its source,
    `best` : that of the test part in `unit`, None where there is none. `scale` and `unit` show
    errors of `signal`. `named` : sets of effects each of which is right. `targets` : the most that
    the error of fit and test may be, in `unit`, None where none is set; `learned_target` : that of
    the test part with what remains learned. `bundled` : as which model, or why as none.
    `literature` : numbers as known, by dotted path. `loop` : whether it is driven slowly to and
    fro, so that its hysteresis has a width.
    """

    name: str
    given: str
    source: str
    published: str
    best: float | None
    model: Callable[[], et.Model]
    fitted: Callable[[Path], et.Measurement]
    test: Callable[[Path], et.Measurement]
    named: tuple[frozenset[str], ...]
    targets: tuple[float | None, float | None]
    most_seconds: float
    bundled: str
    scale: float = 1e3
    unit: str = "mrad"
    signal: str = "joint_position"
    literature: Mapping[str, float] = field(default_factory=dict)
    learned_target: float | None = None
    loop: bool = False


@dataclass(frozen=True)
class Learned:
    """A curve learned from what remains: what it is, and the errors (fit, test) with it."""

    title: str
    after: tuple[float, float]


@dataclass(frozen=True)
class Outcome:
    """What one call found: errors (fit, test) in the machine's unit, before and after.

    `unseen` : the test part beside the model as given and the improved one. `learned` : None where
    nothing was.
    """

    machine: Machine
    found: et.Diagnosis
    before: tuple[float, float]
    after: tuple[float, float]
    unseen: tuple[et.Comparison, et.Comparison]
    seconds: float
    learned: Learned | None = None


def shaft(radius: float, stiffness: float, **link: float) -> et.Model:
    """A model of two equal springs that also push, like a shaft, without end stops."""
    spring = {"stiffness": stiffness, "damping": 0.0, "max_deflection": 1.0}
    content: dict[str, Any] = {
        "name": "given",
        "transmission": {
            "joint_pulley_radius": radius,
            "motor_pulley_radius": radius,
            "pretension_force": 0.0,
            "slack": 0,
            "upper_spring": spring,
            "lower_spring": spring,
        },
        "link": link,
        "uncertainty": {"transmission.pretension_force": 0.0},
    }
    return et.load_model(content)


def oscillator() -> et.Model:
    """Silverbox: gain 1 at rest, resonance near 68 Hz; volts stand for rad and N·m."""
    return shaft(0.1, 50.0, inertia=5.4e-6, damping=2e-4)


def axis() -> et.Model:
    """EMPS: mass and viscous friction."""
    link = {"inertia": 95.0, "damping": 203.0}
    return et.load_model({"name": "given", "motion": "linear", "link": link})


def silverbox(part: slice, folder: Path) -> et.Measurement:
    """Samples of Silverbox."""
    table = pd.read_csv(folder / "silverbox.csv")[part]
    time_s = table["time_s"].to_numpy(float)
    return _driven("silverbox.csv", time_s, table["input_V"], table["output_V"])


def emps(name: str, folder: Path) -> et.Measurement:
    """A recording of EMPS, whose force is the load that moves the axis."""
    columns = {"joint_position": "position_m", "load_torque": "force_N"}
    return et.read(str(folder / name), map=columns)


def _driven(name: str, time_s: Any, load: Any, position: Any) -> et.Measurement:
    """A recording of a link that its load drives; the motor stands still."""
    time_s = np.asarray(time_s, float)
    return et.Measurement(
        time=time_s - time_s[0],
        motor_position=np.zeros(len(time_s)),
        load_torque=np.asarray(load, float),
        signals={"joint_position": np.asarray(position, float)},
        name=name,
    )


def recorded(name: str, folder: Path, start: float = 0.0) -> et.Measurement:
    """A recording as it stands, from a time in s on."""
    window = (start, np.inf) if start else None
    return et.read(str(folder / name), window=window)


SLOW, FAST = "mrd_run_04.csv", "mrd_run_44.csv"
JAW = (frozenset(["coulomb_friction", "tendon_guide_friction"]),)
MACHINES = (
    Machine(
        "Silverbox",
        "a linear oscillator of 68 Hz",
        "silverbox.csv",
        "polynomial state space 0.26 mV (Paduart, thesis, Vrije Universiteit Brussel 2008), neural "
        "state space 1.4 mV (Beintema, Tóth and Schoukens, L4DC 2021, arXiv:2012.07697); data of "
        "Wigren and Schoukens, ECC 2013",
        0.26,
        oscillator,
        partial(silverbox, slice(ARROW, None)),
        partial(silverbox, slice(0, ARROW)),
        (frozenset(["spring_hardening"]),),
        (None, 0.32),
        60.0,
        "not, for it is a circuit: its volts only stand for angles and torques",
        unit="mV",
        learned_target=0.26,
    ),
    Machine(
        "EMPS",
        "mass and viscous friction alone",
        "emps_estimation.csv",
        "dynoNet 2.64 mm (Forgione and Piga 2021, arXiv:2006.02250, whose test script on GitHub "
        "loads the recording of the training); data of Janot, Gautier and Brunot 2019",
        2.64,
        axis,
        partial(emps, "emps_estimation.csv"),
        partial(emps, "emps_pulses.csv"),
        (frozenset(["coulomb_friction", "constant_torque"]),),
        (6.5, 6.5),
        60.0,
        "not, for bundled models have springs, and its dry and viscous friction are open by half",
        unit="mm",
        literature={
            "effects.coulomb_friction.torque": 20.4,  # N
            "effects.constant_torque.torque": 3.2,
        },
        learned_target=2.6,
    ),
    Machine(
        "muir",
        "the bundled bench_actuator, from the description of the bench",
        "muir_position_loop_tracking.csv",
        "none; fitted by hand 4.7 mrad, and 9.2 on the fitted part",
        4.7,
        partial(et.load_model, "bench_actuator"),
        partial(recorded, "muir_position_loop_tracking.csv"),
        partial(recorded, "muir_position_loop_disturbed_by_hand.csv", start=AFTER_THE_HAND),
        (frozenset(["coulomb_friction"]), frozenset(["coulomb_friction", "joint_encoder_offset"])),
        (9.2, 4.7),
        60.0,
        "as et.models.muir_bench",
    ),
    Machine(
        "mrd, slow",
        "the bundled mrd_jaw, from the text that comes with the data",
        SLOW,
        "none; data of O'Neill, Stephens and Kowalewski, RA-L 3(4) 2018",
        None,
        partial(et.load_model, "mrd_jaw"),
        partial(recorded, SLOW),
        partial(recorded, FAST),
        JAW,
        (None, None),
        60.0,
        "as et.models.mrd_tool_4",
        loop=True,
    ),
    Machine(
        "mrd, fast",
        "the same",
        FAST,
        "none (as the slow run)",
        None,
        partial(et.load_model, "mrd_jaw"),
        partial(recorded, FAST),
        partial(recorded, SLOW),
        JAW,
        (None, None),
        60.0,
        "as the slow run, of the same jaw",
        loop=True,
    ),
)


def diagnosed(machine: Machine, folder: Path) -> Outcome:
    """One call of `diagnose`, what it learned added; then the test part, once with each model."""
    given, fitted = machine.model(), machine.fitted(folder)
    start = time.perf_counter()
    found = et.diagnose(given, fitted)
    seconds = time.perf_counter() - start
    addition = None if found.learned is None else with_learned(found, fitted)
    test = machine.test(folder)
    count_call(machine.name)

    def shown(rmse: float) -> float:
        return machine.scale * rmse

    unseen = et.compare(given, test), et.compare(found.model, test)
    errors = [part.rmse()[machine.signal] for part in unseen]
    fit = [found.ladder[end].rmse[machine.signal] for end in (0, -1)]
    before, after = zip(map(shown, fit), map(shown, errors), strict=True)
    learned = None
    if addition is not None:
        last, beside = addition.ladder[-1], et.compare(addition.model, test)
        own = shown(last.rmse[machine.signal]), shown(beside.rmse()[machine.signal])
        learned = Learned(last.title.removeprefix("+ "), own)
        BY_ID.forget(addition.effect_ids[-1])  # no candidate of the next machine
    return Outcome(machine, found, before, after, unseen, seconds, learned)


def with_learned(found: et.Diagnosis, fitted: et.Measurement) -> et.Addition:
    """The improved model with the curve that was learned, fitted once more, to so many samples as
    do not take longer than the search."""
    assert found.learned is not None
    effect = et.effects.load_text(found.learned.source.encode(), f"{found.learned.id}.py")
    return et.add(found.model, effect.id, fitted.samples(slice(LEARNED_SAMPLES)))


def rows_of(machine: Machine, found: Content) -> list[Row]:
    """What was named, the errors, numbers and time, each beside what is hoped for.

    `found` : as `as_json` says it, rounded as there.
    """
    right = [" + ".join(sorted(names)) for names in machine.named]
    added = found["added"]
    rows = [
        Row(
            f"{machine.name}: named",
            " + ".join(added) or "nothing",
            " or ".join(right),
            frozenset(added) in machine.named,
            f"published: {machine.published}",
        )
    ]
    parts = zip(("fit", "test"), found["before"], found["after"], machine.targets, strict=True)
    for part, before, after, target in parts:
        what, beside = f"{machine.name}: error, {part}", f"before: {before:.3g} {machine.unit}"
        rows.append(error_row(what, after, target, machine.unit, beside))
    if learned := found.get("learned"):  # rows that were kept earlier were not asked for it
        targets = None, machine.learned_target
        for part, after, target in zip(("fit", "test"), learned["after"], targets, strict=True):
            what = f"{machine.name}: error, {part}, with a curve learned"
            rows.append(error_row(what, after, target, machine.unit, learned["title"]))
    for path, known in machine.literature.items():
        value = found["values"].get(path, 0.0)  # 0 where the effect was not named
        off = 100.0 * abs(value / known - 1.0)
        what = f"{machine.name}: {path} off the literature"
        rows.append(at_most(what, off, CLOSE, "%", f"{value:.3g} beside {known:g}"))
    if widths := found.get("widths"):
        measured, simulated = widths
        beside = f"{simulated:.3g} beside {measured:.3g} {machine.unit}"
        off = 100.0 * abs(simulated / measured - 1.0)
        what = f"{machine.name}: width of the hysteresis, test, off"
        rows.append(at_most(what, off, LOOP_CLOSE, "%", beside))
    rows.append(at_most(f"{machine.name}: time", found["seconds"], machine.most_seconds, "s"))
    return rows


def error_row(what: str, error: float, target: float | None, unit: str, beside: str) -> Row:
    """An error beside the most that it may be, None where nothing is set."""
    if target is None:
        return Row(what, f"{error:.3g} {unit}", beside=beside)
    return at_most(what, error, target, unit, beside)


def as_json(outcome: Outcome) -> Content:
    """An outcome with its ladder and the largest errors on the test part, as plain data."""
    machine, found = outcome.machine, outcome.found
    errors = rounded([machine.scale * step.rmse[machine.signal] for step in found.ladder])
    values, learned = found.model.values(), outcome.learned
    content = {
        "machine": machine.name,
        "given": machine.given,
        "published": machine.published,
        "best": machine.best,
        "unit": machine.unit,
        "bundled": machine.bundled,
        "sentence": found.sentence,
        "added": list(found.added),
        "before": rounded(outcome.before),
        "after": rounded(outcome.after),
        "seconds": round(outcome.seconds, 1),
        "values": {
            path: rounded([values[path]])[0] for path in machine.literature if path in values
        },
        "steps": [step.title for step in found.ladder],
        "errors": errors,
        "learned": learned and {"title": learned.title, "after": rounded(learned.after)},
        "largest": largest_errors(outcome),
    }
    if machine.loop:
        content["widths"] = rounded(loop_widths(outcome))
    missed = [row.what for row in rows_of(machine, content) if row.met is False]
    return content | {"missed": missed}


def loop_widths(outcome: Outcome) -> tuple[float, float]:
    """Width of the hysteresis on the test part, measured and simulated with the improved model."""
    machine, (file,) = outcome.machine, outcome.unseen[1].files
    motor, moved = file.measurement.motor_position, file.trajectory
    shown = file.measurement.signals[machine.signal], moved[moved.measured(machine.signal)]
    measured, simulated = (machine.scale * loop_width(motor, joint) for joint in shown)
    return measured, simulated


def loop_width(motor: Array, joint: Array) -> float:
    """By how much the joint's position differs between the directions of the motor where that
    stands alike: the median over places in the middle half of its way.

    Parameters
    ----------
    motor, joint : (n,) positions
    """
    way = len(motor) // PLACES_APART  # longer than a step of the encoder takes
    direction = np.sign(motor[2 * way :] - motor[: -2 * way])
    motor, joint = motor[way:-way], joint[way:-way]
    low, high = motor.min(), motor.max()
    edges = np.linspace(low + 0.25 * (high - low), high - 0.25 * (high - low), PLACES + 1)
    place = np.digitize(motor, edges)
    widths = []
    for number in range(1, PLACES + 1):
        there, back = (joint[(place == number) & (direction == sign)] for sign in (1.0, -1.0))
        if there.size and back.size:
            widths.append(abs(float(there.mean() - back.mean())))
    return float(np.median(widths))


def rounded(values: Iterable[float]) -> list[float]:
    """To as many digits as are worth keeping."""
    return [float(f"{value:.4g}") for value in values]


def largest_errors(outcome: Outcome) -> dict[str, list[float]]:
    """In each stretch of the test part: when it begins, and the largest error before and after."""
    machine = outcome.machine
    recording = outcome.unseen[0].files[0].measurement
    measured = recording.signals[machine.signal]
    bins = np.array_split(np.arange(len(measured)), min(BINS, len(measured)))
    found = {"time_s": rounded(recording.time[part[0]] for part in bins)}
    for name, comparison in zip(("before", "after"), outcome.unseen, strict=True):
        moved = comparison.files[0].trajectory
        errors = machine.scale * np.abs(moved[moved.measured(machine.signal)] - measured)
        found[name] = rounded(errors[part].max() for part in bins)
    return found


def kept() -> dict[str, Content]:
    """What was kept of each machine, by its name."""
    return {found["machine"]: found for found in json.loads(KEPT.read_text("utf-8"))}


def keep(found: Mapping[str, Content]) -> None:
    """Write what was found of each machine, by its name."""
    text = json.dumps(list(found.values()), indent=1, ensure_ascii=False)
    # a row of numbers is one line
    text = re.sub(r"\[[^\[\]{}]*\]", lambda row: " ".join(row[0].split()), text)
    KEPT.write_text(text + "\n", "utf-8")


def draw() -> None:
    """Draw what was kept for the README."""
    PICTURE.parent.mkdir(exist_ok=True)
    figure = summary_figure(list(kept().values()))
    figure.savefig(PICTURE, dpi=150, metadata={"Software": None})


def count_call(name: str) -> None:
    """Write down that the test part of a machine was simulated once more."""
    content = kept()
    found = content.setdefault(name, {"machine": name})
    found["calls"] = found.get("calls", 0) + 1
    keep(content)


def main() -> int:
    """Print the table; exit status 1 where a target is missed that is no known miss."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--data", type=Path, default=DATA, help="folder of the recordings")
    parser.add_argument("--only", nargs="+", default=[one.name for one in MACHINES])
    parser.add_argument("--keep", action="store_true", help="for the site and the README")
    given = parser.parse_args()
    chosen = [machine for machine in MACHINES if machine.name in given.only]
    missing = [machine.source for machine in chosen if not (given.data / machine.source).is_file()]
    if missing or not chosen:
        where = f"{given.data} has no {missing[0]}; name the folder of the recordings with --data"
        print(where if missing else "no machine of that name", file=sys.stderr)
        return 1
    print((__doc__ or "").split("\n\n")[-1])
    outcomes = [diagnosed(machine, given.data) for machine in chosen]
    for outcome in outcomes:
        print(f"{outcome.machine.name}: {outcome.found.sentence}")
    found = {outcome.machine.name: as_json(outcome) for outcome in outcomes}
    if given.keep:
        before = kept()
        keep({name: one | found.get(name, {}) for name, one in before.items()})
        draw()
    return print_rows([row for machine in chosen for row in rows_of(machine, found[machine.name])])


if __name__ == "__main__":
    sys.exit(main())
