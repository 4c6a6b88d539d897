"""Give the model an effect of your own and ship it as an FMU.

    python examples/own_effect/run.py [FOLDER]

The effect is tooth_ripple.py, beside this script: a toothed belt makes the pulley's angle ripple
by 2 mrad. The FMU that comes of it is checked with fmpy and driven up to 3.5 rad/s, with the
ripple and without. Draws ripple.png in FOLDER (default: here): where the teeth meet the joint's
natural frequency, the joint shakes.
"""

import sys
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from fmpy import simulate_fmu
from fmpy.validation import validate_fmu

import elastic_tendon as et

HERE = Path(__file__).parent
TEETH = 20
STEP = 5e-4  # s
ACCELERATION = 0.35  # rad/s^2
AMPLITUDE = "effects.tooth_ripple.amplitude"


def driven(fmu: Path, inputs: np.ndarray, amplitude: float) -> np.ndarray:
    """Joint position (rad) for a ripple of this amplitude (rad)."""
    return simulate_fmu(
        str(fmu),
        stop_time=inputs["time"][-1],
        output_interval=STEP,
        input=inputs,
        start_values={AMPLITUDE: amplitude},
        output=["joint_position"],
    )["joint_position"]


def draw(
    inputs: np.ndarray, positions: dict[str, np.ndarray], resonance: float, picture: Path
) -> None:
    speed = ACCELERATION * inputs["time"]
    figure, axes = plt.subplots(figsize=(7, 4), layout="constrained")
    for (label, position), colour in zip(positions.items(), ("#D55E00", "#0072B2"), strict=True):
        deflection = 1e3 * (position - inputs["motor_position"])
        axes.plot(speed, deflection, color=colour, label=label, linewidth=1)
    axes.axvline(resonance, color="0.6", linestyle=":", label="a tooth each natural period")
    axes.set(xlabel="motor speed (rad/s)", ylabel="deflection of the joint (mrad)")
    axes.legend()
    figure.savefig(picture, dpi=110)


def main(folder: Path) -> None:
    et.effects.load(HERE / "tooth_ripple.py")
    given = et.load_model("biorob_x4_joint_3")
    model = given.with_effect("tooth_ripple", {"amplitude": 2e-3})

    names = ("time", "motor_position", "motor_velocity", "load_torque")
    inputs = np.zeros(20001, dtype=[(name, float) for name in names])
    inputs["time"] = STEP * np.arange(inputs.size)
    inputs["motor_position"] = 0.5 * ACCELERATION * inputs["time"] ** 2

    with tempfile.TemporaryDirectory() as work:
        fmu = et.export_fmu(model, Path(work) / "actuator.fmu")
        faults = validate_fmu(str(fmu))
        print("fmpy finds", "; ".join(faults) or "no fault with the FMU")
        positions = {
            "with tooth ripple": driven(fmu, inputs, 2e-3),
            "without": driven(fmu, inputs, 0.0),
        }
    # fmpy holds the inputs from one output to the next
    own = et.simulate(model, inputs["time"], inputs["motor_position"], interpolation="hold")
    apart = np.abs(own["joint_position"] - positions["with tooth ripple"]).max()
    print(f"FMU and simulate() differ by {apart:.1g} rad")

    resonance = et.design(given).frequency_state_3 / TEETH
    draw(inputs, positions, resonance, folder / "ripple.png")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else HERE)
