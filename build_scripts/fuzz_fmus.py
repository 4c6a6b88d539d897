"""Random sequences of calls, legal and illegal, against FMUs of both versions, with sanitizers.

    python build_scripts/fuzz_fmus.py [--sequences 10000000] [--seed 1] [--jobs 1] [--done FILE]

A sequence is the life of an instance for co-simulation or model exchange: 1 to 512 calls, about
100 on the average. The sequences are shared out among both versions of FMI and all effects: none,
each alone, sets of several, and sets at the interfaces where another simulator has the link. Needs
gcc. With `--done` every finished part is noted in a file, and a run that was interrupted goes on
behind them. Exit status: 0 nothing found, 1 a finding, which is printed with what repeats it, 2 not
possible.
"""

import argparse
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from pathlib import Path

from elastic_tendon.actuator.model import build as build_system
from elastic_tendon.actuator.parameters import Model, load_model, typical_value
from elastic_tendon.actuator.variables import Kind
from elastic_tendon.effects import BY_ID
from elastic_tendon.native import compiler
from elastic_tendon.native.binary import write_sources, write_token
from elastic_tendon.native.layout import FmuVariable, Role, layout

FUZZERS = Path(__file__).resolve().parents[1] / "tests" / "fmu"
VERSIONS = (2, 3)
SEVERAL: dict[str, tuple[str, ...]] = {
    "no effect": (),
    "friction and protection": ("coulomb_friction", "overstretch_protection"),
    "rotor": ("motor_friction", "gear_backlash", "joint_stop"),
    "implicit": ("spring_hardening", "spring_relaxation", "tendon_compliance"),
    "springs alone": ("spring_hysteresis",),
    "rotor and springs": ("motor_friction", "spring_hysteresis"),
}
KINDS = {"springs alone": "joint", "rotor and springs": "torque_joint"}  # others: as they need it
EFFECTS = SEVERAL | {effect_id: (effect_id,) for effect_id in BY_ID}
PART = 20_000  # sequences of one run
_VALID = {"motor_position": (-0.5, 0.5), "deflection": (-0.1, 0.1)}  # rad
_TOKEN = "token"
_FLAGS = (
    *("-std=c11", "-O1", "-g", "-Wall", "-Wextra"),
    *("-fsanitize=address,undefined", "-fno-sanitize-recover=all"),
    "-DMAX_STEPS=100000",  # of one call: absurd numbers, as a step of 1e308 s, need more
)


@dataclass(frozen=True)
class Fuzzer:
    """A program that calls one façade of one model; `warnings` are those of hand-written C."""

    program: Path
    warnings: tuple[str, ...]

    def run(self, sequences: int, seed: int) -> tuple[str, str]:
        """What was called, in words, and what that found: nothing, or a text."""
        done = subprocess.run(
            [str(self.program), _TOKEN, str(sequences), str(seed)],
            capture_output=True,
            text=True,
            check=False,
        )
        told = re.search(r"sequences, (\d+ calls: .*)", done.stdout)
        if done.returncode == 0 and told:
            return told[1], ""
        return "", f"exit status {done.returncode}\n{done.stdout}{done.stderr}"


def _model(effect_ids: tuple[str, ...], kind: str) -> Model:
    model = load_model("biorob_x4_joint_3").at(kind)
    for effect_id in effect_ids:
        if not model.kind.has_slot(BY_ID[effect_id].slot):  # it acts on a rotor
            model = model.at("torque")
        parameters = BY_ID[effect_id].parameters
        numbers = {parameter.name: typical_value(model, parameter) for parameter in parameters}
        model = model.with_effect(effect_id, numbers)
    return model


def _first(variables: Sequence[FmuVariable], kind: Kind) -> int:
    """Value reference of the first variable of a type that can be got, behind the inputs."""
    return next(
        variable.value_reference
        for variable in variables
        if variable.variable.kind is kind and variable.role not in (Role.TIME, Role.INPUT)
    )


def _reference(variables: Sequence[FmuVariable], name: str) -> int:
    return next(part.value_reference for part in variables if part.name == name)


def build(
    effect_ids: tuple[str, ...], fmi_version: int, folder: Path, kind: str = "position"
) -> Fuzzer:
    """Compile the library of a model together with the calls of a version of FMI.

    `kind` is the model's interface; effects on a rotor take it to "torque".

    Raises
    ------
    OSError
        without gcc
    subprocess.CalledProcessError
        where gcc refuses
    """
    model = _model(effect_ids, kind)
    system = build_system(*model.structure)
    variables = layout(
        system.interface, model.values(), indicators=fmi_version == 3, validity=_VALID
    )
    write_sources(folder, system, variables, tolerance=1e-8, fmi_version=fmi_version)
    write_token(folder, _TOKEN)
    legal = {f"{kind.value.upper()}_": _first(variables, kind) for kind in Kind}
    sizes = legal | {
        "REFERENCES": len(variables),
        "LAST_INPUT": _reference(variables, system.interface.input_names[-1]),
        "STATES": len(system.interface.states),
        "INDICATORS": sum(mode.indicators for mode in system.interface.modes),
    }
    program = folder / "fuzz"
    command = [
        *("gcc", *_FLAGS),
        *(f"-D{name}={size}" for name, size in sizes.items()),
        *(f"-I{path}" for path in (folder, compiler.RUNTIME, compiler.fmi_headers())),
        *(str(compiler.RUNTIME / "library.c"), str(FUZZERS / f"fuzz_fmi{fmi_version}.c")),
        *("-o", str(program), "-lm"),
    ]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    told = (line for line in done.stderr.splitlines() if "warning:" in line)
    return Fuzzer(program, tuple(line for line in told if "model.c" not in line))


@dataclass(frozen=True)
class _Case:
    """A set of effects in a version of FMI, whose fuzzer is built in a folder when it is needed."""

    name: str
    fmi_version: int
    folder: Path

    @cached_property
    def fuzzer(self) -> Fuzzer:
        """Built once."""
        self.folder.mkdir()
        kind = KINDS.get(self.name, "position")
        return build(EFFECTS[self.name], self.fmi_version, self.folder, kind)


@dataclass(frozen=True)
class _Part:
    """One run: of a case, so many sequences, from a seed of its own."""

    case: _Case
    sequences: int
    seed: int

    @property
    def name(self) -> str:
        """By which it is known when it is done."""
        title = f"FMI {self.case.fmi_version}, {self.case.name}"
        return f"{title}: {self.sequences} sequences from seed {self.seed}"

    def clean(self, note: Path | None) -> bool:
        """Whether nothing was found, which is noted in a file."""
        fuzzer = self.case.fuzzer
        started = time.monotonic()
        told, finding = fuzzer.run(self.sequences, self.seed)
        seconds = time.monotonic() - started
        result = f"FOUND: {finding}" if finding else "nothing found"
        print(f"{self.name}, {told} in {seconds:.1f} s: {result}", flush=True)
        if note and not finding:
            with note.open("a") as file:
                file.write(f"{self.name}\n")
        return not finding


def _all_clean(sequences: int, seed: int, jobs: int, note: Path | None) -> bool:
    """Share the sequences out among all cases, and whether nothing was found."""
    done = set(note.read_text().splitlines()) if note and note.exists() else set()
    with tempfile.TemporaryDirectory() as work, ThreadPoolExecutor(jobs) as pool:
        pairs = enumerate(product(EFFECTS, VERSIONS))
        cases = [_Case(*pair, Path(work) / str(i)) for i, pair in pairs]
        each = -(-sequences // len(cases))
        rounds = -(-each // PART)
        parts = [
            _Part(case, -(-each // rounds), seed + i) for i, case in product(range(rounds), cases)
        ]
        left = [part for part in parts if part.name not in done]
        return all(list(pool.map(lambda part: part.clean(note), left)))


def main() -> int:
    """Exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument(
        *("--sequences",), type=int, default=10_000_000, metavar="N", help="altogether"
    )
    parser.add_argument("--seed", type=int, default=1, metavar="N")
    parser.add_argument("--jobs", type=int, default=1, metavar="N", help="programs at once")
    parser.add_argument("--done", type=Path, metavar="FILE", help="of parts that need not be run")
    chosen = parser.parse_args()
    try:
        return 1 - _all_clean(chosen.sequences, chosen.seed, chosen.jobs, chosen.done)
    except OSError as error:
        print(error, file=sys.stderr)
    except subprocess.CalledProcessError as error:
        print(error.stderr, file=sys.stderr)
    return 2


if __name__ == "__main__":
    sys.exit(main())
