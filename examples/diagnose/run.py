"""Find out in Python what a model is missing: the function behind `elastic-tendon diagnose`.

    python examples/diagnose/run.py [FOLDER]

A joint whose torque depends on gravity was recorded twice, and nobody told its model. The script
makes the recordings, diagnoses them, prints the answer and the candidates, and writes improved.toml
and the figures in FOLDER (default: here).
"""

import sys
from pathlib import Path

import numpy as np

from elastic_tendon import load_model, simulate
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.diagnosis.diagnose import diagnose
from elastic_tendon.measurement import Measurement
from elastic_tendon.reports.comparison_figures import save
from elastic_tendon.reports.diagnosis_figures import all_figures
from elastic_tendon.reports.diagnosis_tables import called_set, verdict_sentences
from elastic_tendon.reports.neighbours import change_words

NOISE = 2e-4  # rad, of the joint's encoder
RATE, DURATION = 500, 10.0  # Hz, s


def record(machine: Model, seed: int) -> Measurement:
    """Slow and fast sines of the motor under a load, as a noisy encoder sees them."""
    lot = np.random.default_rng(seed)
    time = np.arange(round(DURATION * RATE)) / RATE
    rise = np.minimum(time, 1.0)  # from rest
    frequencies = lot.uniform(0.2, 3.0, 6)[:, None]
    phases = lot.uniform(0.0, 2.0 * np.pi, (6, 1))
    motor_position = rise * np.sum(0.15 * np.sin(2.0 * np.pi * frequencies * time + phases), axis=0)
    load_torque = rise * 4.0 * np.sin(2.0 * np.pi * 0.3 * time + phases[0])
    motion = simulate(machine, time, motor_position, load_torque)
    seen = motion["joint_position"] + NOISE * lot.standard_normal(len(time))
    return Measurement(
        time, motor_position, {"joint_position": seen}, load_torque, name=f"recording {seed}"
    )


def main(folder: Path) -> None:
    believed = load_model("biorob_x4_joint_3")
    machine = believed.with_values({"link.inertia": 1.1 * believed.link.inertia})
    machine = machine.with_effect("gravity_load", {"torque": 0.8, "angle": 0.3})

    # the second recording is never fitted, it only judges
    found = diagnose(believed, [record(machine, 1)], [record(machine, 2)])
    for sentence in verdict_sentences(found):
        print(sentence)
    for number, judged in enumerate(found.rounds, start=1):
        likeliest = ", ".join(
            f"{called_set(candidate)} {100.0 * candidate.probability:.0f} %"
            for candidate in judged.candidates[:3]
        )
        print(f"round {number}: {likeliest or 'no candidates'}; {judged.reason}")
    for neighbour in found.neighbours[:3]:
        if neighbour.evidence is not None:
            print(f"{change_words(neighbour.change)}: worse by {neighbour.evidence:.0f}")

    (folder / "improved.toml").write_text(found.model.to_toml(), encoding="utf-8")
    for name, draw in all_figures(found):
        save(draw(), folder / f"{name}.png")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
