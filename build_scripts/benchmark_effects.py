"""How much slower effects make a simulation, and an export; prints one table.

    python build_scripts/benchmark_effects.py [--triples N | --all]

Each effect alone at typical numbers, then N (default 30) of all triples that exclude neither each
other, drawn with a fixed seed, or all of them (1275, most of the time compiling); what load cells
read is in no triple. The figure is the time for 10 s of motion at 500 Hz through slack over that of
the base model. Effects that add states faster than the actuator's own (bristles, spring masses,
stops) need smaller steps and are listed apart.
"""

import argparse
import os
import resource
import sys
import tempfile
import time
from collections.abc import Sequence
from itertools import combinations
from pathlib import Path
from unittest.mock import patch

import numpy as np

from benchmarking import Row, at_most, fastest, print_table
from elastic_tendon.actuator.parameters import Model, load_model, typical_value
from elastic_tendon.actuator.variables import FORCE_READINGS
from elastic_tendon.effects import CATALOGUE
from elastic_tendon.effects.base import Effect
from elastic_tendon.errors import ModelError
from elastic_tendon.fmu.export import export_fmu
from elastic_tendon.native.library import library_path
from elastic_tendon.simulation.simulate import simulate

ALLOWED = 3.0  # × the base model
EXPORT_ALLOWED = 1.5  # × the base model's export
FAST = {"lugre_friction", "spring_mass", "joint_stop"}
FOUR = ("coulomb_friction", "overstretch_protection", "gravity_load", "joint_stop")
SIXTEEN = (
    *FOUR,
    *("spring_hardening", "spring_hysteresis", "spring_mass", "spring_relaxation"),
    *("tendon_compliance", "tendon_guide_friction", "gear_backlash", "pulley_eccentricity"),
    *("quadratic_drag", "directional_damping", "measurement_delay", "joint_encoder_offset"),
)
REPETITIONS = 7
SEED = 11

TIME = np.arange(0.0, 10.0, 0.002)
MOTOR = 0.3 * np.sin(2 * np.pi * 1.1 * TIME) * np.sin(np.pi * TIME / 10.0)
LOAD = 4.0 * np.sin(3.0 * TIME)


def run_time(model: Model) -> float:
    """Time of one simulation, s."""
    return fastest(lambda: simulate(model, TIME, MOTOR, LOAD), REPETITIONS)


def slower(base: Model, effects: Sequence[Effect]) -> float:
    """Time over that of the base model, both taken now."""
    model = base
    for effect in effects:
        numbers = {
            parameter.name: typical_value(base, parameter) for parameter in effect.parameters
        }
        model = model.with_effect(effect.id, numbers)
    library_path(model.effect_ids)
    return run_time(model) / run_time(base)


def triples(base: Model) -> list[tuple[Effect, ...]]:
    """All sets of three effects that a model can have together, but of what load cells read.

    These add nothing to the motion, and two in three sets have one of them.
    """
    found: list[tuple[Effect, ...]] = []
    moving = [effect for effect in CATALOGUE if effect.slot not in FORCE_READINGS]
    for three in combinations(moving, 3):
        try:
            model = base
            for effect in three:
                model = model.with_effect(effect.id, None)
        except ModelError:
            continue
        found.append(three)
    return found


def is_fast(effects: Sequence[Effect]) -> bool:
    """Whether one of the effects adds faster dynamics."""
    return any(effect.id in FAST for effect in effects)


def name(effects: Sequence[Effect]) -> str:
    """Ids in one line."""
    return " + ".join(effect.id for effect in effects)


def export_rows(base: Model) -> list[Row]:
    """Time of a first export of the base model, and of one with three effects."""
    three = base
    for effect_id in ("stribeck_friction", "spring_hysteresis", "gear_backlash"):
        three = three.with_effect(effect_id, None)
    times = []
    with tempfile.TemporaryDirectory() as folder:
        for i, model in enumerate((base, base, three)):  # the first warms the compiler up
            begin = time.perf_counter()
            export_fmu(model, Path(folder) / f"{i}.fmu")
            times.append(time.perf_counter() - begin)
    rows = [Row("export of the base model", f"{times[1]:.2f} s")]
    return [*rows, at_most("… with three effects / base", times[2] / times[1], EXPORT_ALLOWED)]


def compile_rows() -> list[Row]:
    """What the library of a set that was never met costs, the compiler warm."""
    times = []
    for effects in (FOUR, FOUR, SIXTEEN):  # the first warms the compiler up
        with (
            tempfile.TemporaryDirectory() as cache,
            patch.dict(os.environ, {"ELASTIC_TENDON_CACHE": cache}),
        ):
            begin = time.perf_counter()
            library_path(effects)
            times.append(time.perf_counter() - begin)
    memory = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024  # of the largest process
    return [
        at_most("compile four effects", times[1], 2.0, "s"),
        at_most("compile sixteen effects", times[2], 45.0, "s"),
        at_most("… with a memory of", memory, 600.0, "MB"),
    ]


def main() -> int:
    """Print the table; exit status."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--triples", type=int, default=30)
    parser.add_argument("--all", action="store_true")
    arguments = parser.parse_args()
    base = load_model("biorob_x4_joint_3")
    rows = compile_rows() + export_rows(base)
    for effect in CATALOGUE:
        if not base.kind.has_slot(effect.slot):  # it acts on a rotor, which this model lacks
            continue
        ratio = slower(base, [effect])
        rows.append(
            Row(name([effect]), f"{ratio:.2f}")
            if effect.id in FAST
            else at_most(effect.id, ratio, ALLOWED)
        )
    sets = triples(base)
    if not arguments.all:
        chosen = np.random.default_rng(SEED).permutation(len(sets))[: arguments.triples]
        sets = [sets[i] for i in chosen]
    ratios = {three: slower(base, three) for three in sets}
    slow = sorted(
        (effect_set for effect_set in sets if not is_fast(effect_set)),
        key=lambda effect_set: -ratios[effect_set],
    )
    fast = sorted(
        (effect_set for effect_set in sets if is_fast(effect_set)),
        key=lambda effect_set: -ratios[effect_set],
    )
    values = np.array([ratios[effect_set] for effect_set in slow])
    rows.append(at_most(f"median of {len(slow)} triples", float(np.median(values)), ALLOWED))
    rows.append(Row("triples within the target", f"{100 * np.mean(values <= ALLOWED):.0f} %"))
    rows += [at_most(name(effect_set), ratios[effect_set], ALLOWED) for effect_set in slow[:10]]
    rows += [
        Row(f"with fast dynamics: {name(effect_set)}", f"{ratios[effect_set]:.1f}")
        for effect_set in fast[:3]
    ]
    return print_table("Time of a simulation with effects / base model", rows)


if __name__ == "__main__":
    sys.exit(main())
