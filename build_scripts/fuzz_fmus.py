"""Random legal and illegal calls against FMUs of both versions, built with sanitizers.

    python build_scripts/fuzz_fmus.py [--calls 10000000] [--seed 1] [--jobs 2]

The calls are shared out among both versions of FMI and three sets of effects. Needs gcc. Exit
status: 0 nothing found, 1 a finding, which is printed with what repeats it, 2 not possible.
"""

import argparse
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
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
EFFECTS: dict[str, tuple[str, ...]] = {
    "base": (),
    "friction and protection": ("coulomb_friction", "overstretch_protection"),
    "implicit": ("spring_hardening", "spring_relaxation", "tendon_compliance"),
}
PART = 200_000  # calls of one run
_TOKEN = "token"
_FLAGS = (
    *("-std=c11", "-O1", "-g", "-Wall", "-Wextra"),
    *("-fsanitize=address,undefined", "-fno-sanitize-recover=all"),
)


@dataclass(frozen=True)
class Fuzzer:
    """A program that calls one façade of one model; `warnings` are those of hand-written C."""

    program: Path
    warnings: tuple[str, ...]

    def run(self, calls: int, seed: int) -> str:
        """What it found: nothing, or a text."""
        done = subprocess.run(
            [str(self.program), _TOKEN, str(calls), str(seed)],
            capture_output=True,
            text=True,
            check=False,
        )
        if done.returncode == 0 and " calls: " in done.stdout:
            return ""
        return f"exit status {done.returncode}\n{done.stdout}{done.stderr}"


def _model(effect_ids: tuple[str, ...]) -> Model:
    model = load_model("biorob_x4_joint_3")
    for effect_id in effect_ids:
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


def build(effect_ids: tuple[str, ...], fmi_version: int, folder: Path) -> Fuzzer:
    """Compile the library of a model together with the calls of a version of FMI.

    Raises
    ------
    OSError
        without gcc
    subprocess.CalledProcessError
        where gcc refuses
    """
    model = _model(effect_ids)
    system = build_system(model.effect_ids)
    variables = layout(system.interface, model.values(), indicators=fmi_version == 3)
    write_sources(folder, system, variables, tolerance=1e-8, fmi_version=fmi_version)
    write_token(folder, _TOKEN)
    legal = {f"{kind.value.upper()}_": _first(variables, kind) for kind in Kind}
    sizes = legal | {
        "REFERENCES": len(variables),
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
class _Part:
    """One run: of a fuzzer, so many calls, from a seed of its own."""

    title: str
    fuzzer: Fuzzer
    calls: int
    seed: int

    def clean(self) -> bool:
        """Whether nothing was found."""
        started = time.monotonic()
        finding = self.fuzzer.run(self.calls, self.seed)
        seconds = time.monotonic() - started
        result = f"FOUND: {finding}" if finding else "nothing found"
        print(
            f"{self.title}: {self.calls} calls from seed {self.seed} in {seconds:.1f} s: {result}",
            flush=True,
        )
        return not finding


def _all_clean(calls: int, seed: int, jobs: int) -> bool:
    """Build all fuzzers, share the calls out among them, and whether nothing was found."""
    cases = [(name, fmi_version) for name in EFFECTS for fmi_version in VERSIONS]
    each = -(-calls // len(cases))
    rounds = -(-each // PART)
    with tempfile.TemporaryDirectory() as work, ThreadPoolExecutor(jobs) as pool:
        folders = [Path(work) / str(i) for i in range(len(cases))]
        for folder in folders:
            folder.mkdir()
        built = pool.map(lambda case, at: build(EFFECTS[case[0]], case[1], at), cases, folders)
        fuzzers = list(zip(cases, built, strict=True))
        parts = [
            _Part(f"FMI {version}, {name}", fuzzer, -(-each // rounds), seed + i)
            for i in range(rounds)
            for (name, version), fuzzer in fuzzers
        ]
        return all(list(pool.map(_Part.clean, parts)))


def main() -> int:
    """Exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--calls", type=int, default=10_000_000, metavar="N", help="altogether")
    parser.add_argument("--seed", type=int, default=1, metavar="N")
    parser.add_argument("--jobs", type=int, default=2, metavar="N", help="programs at once")
    chosen = parser.parse_args()
    try:
        return 0 if _all_clean(chosen.calls, chosen.seed, chosen.jobs) else 1
    except OSError as error:
        print(error, file=sys.stderr)
    except subprocess.CalledProcessError as error:
        print(error.stderr, file=sys.stderr)
    return 2


if __name__ == "__main__":
    sys.exit(main())
