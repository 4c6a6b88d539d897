"""Find out in Python what a model is missing: the function behind `elastic-tendon diagnose`.

    python examples/diagnose/run.py [FOLDER]

A joint whose torque depends on gravity was recorded twice, and nobody told its model. The script
makes the recordings, diagnoses them, prints the answer and the candidates, and writes
improved.toml, report.html and ladder.png in FOLDER (default: here).
"""

import sys
from pathlib import Path

import numpy as np

import elastic_tendon as et

NOISE = 2e-4  # rad, of the joint's encoder
RATE, DURATION = 500, 10.0  # Hz, s
UNITS = {"N.m": "N·m", "rad": "rad"}


def record(machine: et.Model, seed: int) -> et.Measurement:
    """Slow and fast sines of the motor under a load, as a noisy encoder sees them."""
    lot = np.random.default_rng(seed)
    time = np.arange(round(DURATION * RATE)) / RATE
    rise = np.minimum(time, 1.0)  # from rest
    frequencies = lot.uniform(0.2, 3.0, 6)[:, None]
    phases = lot.uniform(0.0, 2.0 * np.pi, (6, 1))
    motor_position = rise * np.sum(0.15 * np.sin(2.0 * np.pi * frequencies * time + phases), axis=0)
    load_torque = rise * 4.0 * np.sin(2.0 * np.pi * 0.3 * time + phases[0])
    motion = et.simulate(machine, time, motor_position, load_torque)
    seen = motion["joint_position"] + NOISE * lot.standard_normal(len(time))
    return et.Measurement(
        time, motor_position, {"joint_position": seen}, load_torque, name=f"recording {seed}"
    )


def print_added(found: et.Diagnosis) -> None:
    """Every effect that was added, its numbers and half of their 95 % confidence intervals."""
    table = found.to_dataframe().set_index("path")
    for effect_id in found.added:
        rows = table[table.index.str.startswith(f"effects.{effect_id}.")]
        numbers = ", ".join(
            f"{path.split('.')[-1]} {row.fitted:.4g} ± {np.ptp(row.interval) / 2:.2g}"
            f" {UNITS[row.unit]}"
            for path, row in rows.iterrows()
        )
        print(f"Added: {getattr(et.effects, effect_id).title}, {numbers}")


def main(folder: Path) -> None:
    believed = et.load_model("biorob_x4_joint_3")
    machine = believed.with_values({"link.inertia": 1.1 * believed.link.inertia})
    machine = machine.with_effect("gravity_load", {"torque": 0.8, "angle": 0.3})

    # no fit sees the second recording: it only judges
    found = et.diagnose(believed, record(machine, 1), validate=record(machine, 2))
    print(found)
    print_added(found)
    for number, tried in enumerate(found.rounds, start=1):
        likeliest = ", ".join(
            f"{'+'.join(candidate.ids)} {100.0 * candidate.probability:.0f} %"
            for candidate in tried.candidates[:3]
        )
        print(f"round {number}: {likeliest or 'no candidates'}; {tried.reason}")
    for neighbour in found.neighbours[:3]:
        if neighbour.evidence is not None:
            print(f"{neighbour.change}: evidence worse by {neighbour.evidence:.0f}")

    (folder / "improved.toml").write_text(found.model.to_toml(), encoding="utf-8")
    et.report(found, folder / "report.html", force=True)
    found.plot().savefig(folder / "ladder.png")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
