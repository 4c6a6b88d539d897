"""How long a fleet takes, what is found in it, and whether memory grows with the robots.

    python build_scripts/benchmark_fleet.py [--quick]

Robots are drawn around a bundled model; friction and gravity appeared in some of them. Logs are
made by our own simulation, 12 s at 500 Hz with noise: this is about time, not about truth.
"""

import argparse
import io
import sys
import tempfile
from pathlib import Path

import numpy as np
import pandas as pd
import rich

import elastic_tendon as et
from benchmark_sweep import fresh_peak
from benchmarking import Row, at_least, at_most, print_table, seconds
from elastic_tendon.reports.fleet_figure import fleet_figure
from elastic_tendon.reports.fleet_tables import pooled_table, robots_table
from elastic_tendon.sweeps.fleet import HIGH, LOW, SIGNALS, error_columns, units_of
from elastic_tendon.sweeps.formats import NUMBER, ROW_GROUP
from elastic_tendon.sweeps.results import read_fleet
from elastic_tendon.sweeps.task import APPEARED, DRIFTED, FAILURE, ROBOT, RUN, VERDICT

MODEL = et.load_model("biorob_x4_joint_3")
ROBOTS, WORKERS = 20, 2
MOST = 60.0  # s for all of them
FEW, MANY = 100, 100_000  # robots whose answer is put together, for its memory
APPEARED_EFFECT = "coulomb_friction"  # in a quarter of these
GROWTH = 1.5  # of memory from few to a thousand times as many
RATE, DURATION = 500, 12.0  # Hz, s
NOISE = 2e-4  # rad
SCATTER = 0.03  # of a robot's stiffness, inertia and damping, one sigma
VARIED = (
    *(f"transmission.{side}_spring.stiffness" for side in ("upper", "lower")),
    *("link.inertia", "link.damping"),
)
HIDDEN: tuple[tuple[str, dict[str, float]] | None, ...] = (
    None,
    ("coulomb_friction", {"torque": 0.3}),
    None,
    ("gravity_load", {"torque": 0.6}),
)


def robot(number: int, random: np.random.Generator) -> et.Model:
    """A robot as it really is."""
    own = {path: MODEL.values()[path] * random.normal(1.0, SCATTER) for path in VARIED}
    appeared = HIDDEN[number % len(HIDDEN)]
    machine = MODEL.with_values(own)
    return machine if appeared is None else machine.with_effect(*appeared)


def log(machine: et.Model, random: np.random.Generator) -> pd.DataFrame:
    """Slow and fast sines of the motor under a load, from rest."""
    time = np.arange(round(DURATION * RATE)) / RATE
    rise = np.minimum(time, 1.0)
    frequencies = random.uniform(0.2, 3.0, (6, 1))
    phases = random.uniform(0.0, 2.0 * np.pi, (6, 1))
    motor = rise * np.sum(0.15 * np.sin(2.0 * np.pi * frequencies * time + phases), axis=0)
    load = rise * 5.0 * np.sin(np.pi * time + phases[0])
    joint = et.simulate(machine, time, motor, load)["joint_position"]
    return pd.DataFrame(
        {
            "time_s": time,
            "motor_position_rad": motor,
            "load_torque_Nm": load,
            "joint_position_rad": joint + NOISE * random.standard_normal(len(time)),
        }
    )


def rows(quick: bool) -> list[Row]:
    """Time of the fleet and what was named; `quick` has four robots."""
    count = len(HIDDEN) if quick else ROBOTS
    random = np.random.default_rng(1)
    with tempfile.TemporaryDirectory() as work:
        paths = [Path(work) / f"{number:02}.csv" for number in range(count)]
        for number, path in enumerate(paths):
            log(robot(number, random), random).to_csv(path, index=False)
        task, table = et.fleet(MODEL, paths), Path(work) / "fleet.parquet"
        time = seconds(lambda: et.sweep(task, table, workers=WORKERS))
        named = pd.read_parquet(table)["appeared"].str.partition(":")[0]
    hidden = [HIDDEN[number % len(HIDDEN)] for number in range(count)]
    right = [
        name == ("" if appeared is None else appeared[0])
        for name, appeared in zip(named, hidden, strict=True)
    ]
    return [
        memory_row(MANY // 100 if quick else MANY),
        at_most(f"{count} robots on {WORKERS} cores", time, MOST * count / ROBOTS, "s"),
        at_least(f"named as hidden ({count})", 100.0 * float(np.mean(right)), 95.0, "%"),
    ]


def table_of(robots: int) -> pd.DataFrame:
    """Rows as a fleet gives them, of parameters around those given; friction in a quarter."""
    random = np.random.default_rng(2)
    columns: dict[str, object] = {RUN: np.arange(robots), ROBOT: np.char.mod("%06d", range(robots))}
    rubs = np.arange(robots) % 4 == 0
    columns |= {VERDICT: np.where(rubs, "effect_missing", "adequate"), DRIFTED: ""}
    columns |= {APPEARED: np.where(rubs, APPEARED_EFFECT, "")}
    for signal in SIGNALS:
        columns |= dict.fromkeys(error_columns(signal).values(), np.nan)
    for column in error_columns(SIGNALS[0]).values():
        columns[column] = random.uniform(0.9, 1.1, robots)
    values = MODEL.values()
    for path in units_of(MODEL):
        there = rubs if APPEARED_EFFECT in path else path in values
        size = random.normal(values.get(path, 1.0), 0.1, robots)
        for end, moved in (("", 0.0), (LOW, -0.2), (HIGH, 0.2)):
            columns[path + end] = np.where(there, size + moved, np.nan)
    return pd.DataFrame(columns | {FAILURE: ""})


def answer(path: str) -> None:
    """All that is shown of the table of a fleet."""
    table = read_fleet(Path(path))
    found = et.fleet_findings(MODEL, table)
    rich.print(found.summary(), robots_table(MODEL, table), pooled_table(found), file=io.StringIO())
    fleet_figure(MODEL, table).savefig(io.BytesIO())


def memory_row(many: int) -> Row:
    """Largest memory of the answer of many robots over that of few."""
    if not Path("/proc/self/status").is_file():
        return Row("memory of a fleet's answer", "not told here")
    taken = []
    with tempfile.TemporaryDirectory() as work:
        for robots in (FEW, many):
            table = table_of(robots)
            path = Path(work) / f"{robots}.parquet"
            table.to_parquet(path, row_group_size=ROW_GROUP // (NUMBER * table.shape[1]))
            del table
            taken.append(fresh_peak(f"import benchmark_fleet as own\nown.answer({str(path)!r})"))
    beside = ", ".join(f"{part:.0f} MB" for part in taken)
    name = f"largest memory of the answer of {many:.0e} robots / {FEW}"
    return at_most(name, taken[-1] / taken[0], GROWTH, "", beside)


def main() -> int:
    """Print the table; exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="four robots")
    return print_table("A fleet", rows(parser.parse_args().quick))


if __name__ == "__main__":
    sys.exit(main())
