"""Time of a whole diagnosis, beside one simulation by scipy of the same model and data.

    python build_scripts/benchmark_diagnosis.py

12 s at 500 Hz with white noise; the machine has Coulomb friction, or spring hysteresis, that the
model lacks, and all other effects of the catalogue are candidates. Libraries are cached; what
compiling them adds the first time is measured in an empty cache of its own. Scipy integrates the
model without effects once, to 1e-7, on a right-hand side in plain Python.
"""

import os
import sys
import tempfile
from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from benchmark_simulate import python_rates
from benchmarking import Row, at_most, print_table, seconds
from elastic_tendon.actuator.parameters import Model, load_model
from elastic_tendon.diagnosis.candidates import candidates
from elastic_tendon.diagnosis.diagnose import diagnose
from elastic_tendon.diagnosis.torque_screen import Screen
from elastic_tendon.measurement import Measurement
from elastic_tendon.native.library import clear_cache
from elastic_tendon.simulation.excitation import default_excitation
from elastic_tendon.simulation.simulate import simulate

HIDDEN: dict[str, Mapping[str, float]] = {
    "coulomb_friction": {"torque": 0.1},
    "spring_hysteresis": {"force": 5.0, "yield_length": 0.002},
}
NOISE = 5e-4  # rad
DURATION, RATE = 12.0, 500.0  # s, Hz
TOLERANCE = 1e-7  # of scipy


def recording(model: Model, effect_id: str) -> Measurement:
    """What a machine with the effect shows in the default excitation."""
    excitation = default_excitation(model)
    now = np.arange(int(DURATION * RATE)) / RATE
    motor = np.interp(now, excitation.time, excitation.motor_position)
    load = np.interp(now, excitation.time, excitation.load_torque)
    machine = model.with_effect(effect_id, HIDDEN[effect_id])
    shown = simulate(machine, now, motor, load, as_measured=True)["joint_position"]
    noise = NOISE * np.random.default_rng(1).standard_normal(len(now))
    return Measurement(
        name=effect_id,
        time=now,
        motor_position=motor,
        signals={"joint_position": shown + noise},
        load_torque=load,
        interpolation="linear",
    )


def scipy_seconds(model: Model, measured: Measurement) -> float:
    """Time of one simulation by solve_ivp, s."""
    rates: Any = python_rates(model, measured.time, measured.motor_position, cubic=False)
    span = (0.0, float(measured.time[-1]))
    return seconds(
        lambda: solve_ivp(
            rates, span, [0.0, 0.0], "LSODA", measured.time, rtol=TOLERANCE, atol=TOLERANCE / 10
        )
    )


def screened(model: Model, measured: Measurement) -> int:
    """Estimate every effect alone, without a refit; the number of effects."""
    screen = Screen(model, [measured])
    seen = [effect_id for effect_id in candidates(model, [measured]) if screen.sees(effect_id)]
    for effect_id in seen:
        screen.single(effect_id)
    return len(seen)


def rows(model: Model, effect_id: str) -> list[Row]:
    """Screen, whole diagnosis and the ratio for one hidden effect."""
    measured = recording(model, effect_id)
    count = screened(model, measured)
    screening = seconds(lambda: screened(model, measured))
    found = diagnose(model, [measured])  # fills the cache, as an earlier call would have
    whole = seconds(lambda: diagnose(model, [measured]))
    peer = scipy_seconds(model, measured)
    name = effect_id.replace("_", " ")
    return [
        at_most(f"{name}: screen of {count} effects", screening, 1.0, "s"),
        at_most(f"{name}: whole diagnosis, {found.verdict} {found.added}", whole, 30.0, "s"),
        Row(f"{name}: whole diagnosis / one solve_ivp", f"{whole / peer:.3g}"),
    ]


def first_time(model: Model, effect_id: str) -> Row:
    """What compiling adds, in an empty cache."""
    measured = recording(model, effect_id)
    whole = seconds(lambda: diagnose(model, [measured]))
    with tempfile.TemporaryDirectory() as folder:
        kept = os.environ.get("ELASTIC_TENDON_CACHE")
        os.environ["ELASTIC_TENDON_CACHE"] = folder
        clear_cache()
        cold = seconds(lambda: diagnose(model, [measured]))
        if kept is None:
            del os.environ["ELASTIC_TENDON_CACHE"]
        else:
            os.environ["ELASTIC_TENDON_CACHE"] = kept
    return at_most("the first time: what compiling adds", cold - whole, 60.0, "s")


def main() -> int:
    """Print it all; exit status."""
    model = load_model("biorob_x4_joint_3")
    table = [row for effect_id in HIDDEN for row in rows(model, effect_id)]
    table.append(first_time(model, "coulomb_friction"))
    return print_table("A diagnosis of 12 s at 500 Hz", table)


if __name__ == "__main__":
    sys.exit(main())
