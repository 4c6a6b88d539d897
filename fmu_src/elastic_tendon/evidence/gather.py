"""Model, recordings and the JSON of a diagnosis to the evidence that an FMU carries."""

import hashlib
import json
import os
import platform
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, get_args

import numpy as np

from elastic_tendon.actuator.parameters import Model, load_model
from elastic_tendon.actuator.variables import interface, moved_states
from elastic_tendon.comparison.compare import compare
from elastic_tendon.comparison.comparison import Comparison, FileComparison
from elastic_tendon.effects.base import Slot
from elastic_tendon.errors import EvidenceError, ModelError, SimulationError
from elastic_tendon.estimation.coordinates import free_parameters
from elastic_tendon.estimation.determinability import CONFIDENCE
from elastic_tendon.estimation.problem import Problem, problem_of
from elastic_tendon.evidence.experiment import (
    SMOKE_TEST,
    Array,
    Experiment,
    results_of,
    results_table,
    smoke_test,
    to_csv,
    tolerances,
)
from elastic_tendon.evidence.manifest import FOLDER, MANIFEST, Related, manifest
from elastic_tendon.evidence.parameter_set import Uncertainty, parameter_set
from elastic_tendon.evidence.privacy import without_names
from elastic_tendon.measurement import Measurement, Recordings, listed
from elastic_tendon.result import Result, plain
from elastic_tendon.simulation.simulate import given_names

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

SCHEMA = "elastic-tendon/evidence/1"
REPORT = f"{FOLDER}evidence.json"
PARAMETERS = f"{FOLDER}parameters.ssv"
Kept = Literal["data", "hashes"]
_PACKAGES = ("elastic-tendon", "casadi", "numpy", "ziglang")
_CSV, _JSON, _SSV = "text/csv", "application/json", "application/x-ssp-parameter-set"
_MARGIN = 0.02  # of a range of validity, on either side
_ALWAYS = (
    Related("parameters.ssv", _SSV, "parameter", "Values with intervals and covariance"),
    Related("evidence.json", _JSON, "report", "Errors, range of validity, verdict, provenance"),
    Related("seal.json", _JSON, "signature", "Hashes of all files, and a signature of them"),
)


@dataclass(frozen=True, repr=False)
class Evidence(Result):
    """What an FMU of `model` is to carry.

    `comparison` : model beside the recordings. `report` : plain data, schema
    ``elastic-tendon/evidence/1``. `files` : content of all other files by path in the FMU.
    `related` : what the manifest says of each.
    """

    comparison: Comparison
    report: Mapping[str, Any]
    files: Mapping[str, bytes]
    related: tuple[Related, ...]

    def summary(self) -> str:
        """Recordings with their errors, and the verdict."""
        lines = [f"evidence for {self.model.name}"]
        for recording in self.report["recordings"]:
            errors = (
                f"{signal} RMS error {error['rmse']:.3g}, {error['noise_ratio']:.3g} x noise"
                for signal, error in recording["signals"].items()
            )
            lines.append(f"  {recording['name']}: {'; '.join(errors)}")
        found = self.report["diagnosis"]
        lines.append(f"  verdict: {found['verdict'] if found else 'no diagnosis was given'}")
        return "\n".join(lines)

    @property
    def model(self) -> Model:
        """The model that it is evidence of."""
        return self.comparison.model

    @property
    def validity(self) -> dict[str, tuple[float, float]]:
        """Range in which an input or output counts as validated, SI."""
        return widened(self.report["range"])

    def to_dict(self) -> dict[str, Any]:
        """The report."""
        return dict(self.report)

    def to_dataframe(self) -> "pd.DataFrame":
        """Error of each signal in each recording, a row each, SI."""
        return self.comparison.to_dataframe()

    def plot(self) -> "Figure":
        """Draw measured and simulated signals, and the residual below each."""
        return self.comparison.plot()

    def contents(self, signed_by: str | None) -> dict[str, bytes]:
        """All files by their path in the FMU, but the seal.

        Parameters
        ----------
        signed_by : public key, hexadecimal digits; None: it will not be signed
        """
        report = json.dumps({**self.report, "signed_by": signed_by}, indent=1, allow_nan=False)
        return {
            **self.files,
            REPORT: f"{report}\n".encode(),
            MANIFEST: manifest(self.related),
        }


def gather_evidence(
    model: Model,
    recordings: Recordings,
    *,
    diagnosis: str | Path | Mapping[str, Any] | None = None,
    keep: Kept = "data",
    command: str | None = None,
) -> Evidence:
    """Compare a model with recordings, and put together what its FMU carries as proof.

    Nothing is fitted or searched.

    Parameters
    ----------
    model : Model that is exported
    recordings : one or several
    diagnosis : file that `Diagnosis.save_json` wrote, or `Diagnosis.to_dict`, in which `model` was
        found; None: the evidence has no verdict
    keep : "data" packs the measured signals and what the model makes of them, "hashes" neither:
        errors and ranges only, and hashes by which their owner knows the recordings
    command : what was typed, for the record; paths and names are left out

    Returns
    -------
    Evidence

    Raises
    ------
    EvidenceError : there is no recording, or the diagnosis cannot be read or is of another model
    MeasurementError : a recording does not hold what the model's interface needs
    SimulationError : the solver could not go on
    """
    if keep not in get_args(Kept):
        raise EvidenceError(f'evidence keeps "data" or "hashes", not {keep!r}')
    found = None if diagnosis is None else _diagnosis(diagnosis, model)
    # as importers do, who know no curves
    recordings = [recording.with_straight_inputs() for recording in listed(recordings)]
    if not recordings:
        raise EvidenceError("evidence is what a model errs beside recordings; name at least one")
    compared = compare(model, recordings)
    parts = [_experiment(smoke_test(model), model)]
    described = []
    for number, file in enumerate(compared.files, 1):
        role = _role(file.measurement, found)
        part, facts = _recording(number, file, model, keep, role)
        parts.append(part)
        described.append(facts)
    files = {path: content for part in parts for path, content in part.files.items()}
    files[PARAMETERS] = _parameter_set(model, _uncertainty(model, recordings, found))
    related = (*(file for part in parts for file in part.related), *_ALWAYS)
    report = {
        "schema": SCHEMA,
        "model": without_names(model.name),
        "interface": model.kind,
        "motion": model.motion,
        "effects": list(model.effect_ids),
        "date": _date(),
        "recordings": described,
        "smoke_test": {"tolerances": parts[0].tolerances},
        "range": _ranges(compared),
        "diagnosis": without_names(plain(found)),
        "provenance": _provenance(command),
    }
    return Evidence(compared, plain(report), files, related)


# ---- experiments ---------------------------------------------------------------------------


def replayable(model: Model, measurement: Measurement) -> bool:
    """Whether an FMU can be driven as the recording was simulated.

    What sensors read are outputs of an FMU, too. But beside a recording the motor is where its
    encoder must be to read what was recorded, and delays are exact; an FMU is told where the motor
    is, and takes a delay to first order. Cubic inputs no importer knows.
    """
    slots = {effect.slot for effect in interface(*model.structure).effects}
    otherwise = slots & {Slot.MOTOR_SIGNAL, Slot.SIGNAL_DELAY}
    return measurement.input_interpolation != "cubic" and not otherwise


@dataclass(frozen=True)
class _Part:
    """Files of an experiment, what the manifest says of them, and the tolerances of its results."""

    files: Mapping[str, bytes]
    related: tuple[Related, ...]
    tolerances: Mapping[str, float]


def _experiment(experiment: Experiment, model: Model, measured: bytes | None = None) -> _Part:
    """Inputs, reference results and, of a recording, what was measured."""
    role = "smoke-test" if experiment.name == SMOKE_TEST else "validation"
    results = results_of(model, experiment)
    tables = [
        ("inputs", experiment.table(), f"experiment/{role}", "Inputs, held to the next time"),
        ("results", results_table(results), "result", "What the model does under these inputs"),
    ]
    if measured is not None:
        tables.append(("measured", measured, "result", "What was measured under these inputs"))
    label = (f"experiment:{experiment.name}",)
    return _Part(
        {f"{FOLDER}{experiment.name}_{kind}.csv": content for kind, content, *_ in tables},
        tuple(
            Related(f"{experiment.name}_{kind}.csv", _CSV, role, meaning, label)
            for kind, _, role, meaning in tables
        ),
        tolerances(results),
    )


def _recording(
    number: int, file: FileComparison, model: Model, keep: Kept, role: str
) -> tuple[_Part, dict[str, Any]]:
    """Files of a recording, and what the report says of it."""
    recording = file.measurement
    time = recording.time - recording.time[0]
    name, state = f"recording_{number}", file.initial_state
    experiment = Experiment(name, time, recording.inputs, state.as_dict(model.kind))
    measured = to_csv({"time": time, **recording.signals}, "%r")
    part = (
        _experiment(experiment, state.model(model), measured)
        if keep == "data"
        else _Part({}, (), {})
    )
    source = Path(recording.source)
    return part, {
        "name": without_names(recording.name),
        "experiment": name,
        "packed": keep == "data",
        "role": role,
        "replayed": keep == "data" and replayable(model, recording),
        "interpolation": recording.input_interpolation,
        "samples": len(time),
        "duration": float(time[-1]),
        "start": {**experiment.start, **state.own},
        "hashes": {
            "inputs": _hash(experiment.table()),
            "measured": _hash(measured),
            "file": _hash(source.read_bytes()) if source.is_file() else None,
        },
        "signals": {signal: asdict(error) for signal, error in file.signals.items()},
        "tolerances": part.tolerances,
    }


def _hash(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def _ranges(compared: Comparison) -> dict[str, tuple[float, float]]:
    """Least and largest value over all recordings: of inputs, of what is moved as simulated."""
    model = compared.model
    inputs = given_names(model)
    deflection = ("deflection",) if model.kind.has_springs else ()
    found: dict[str, tuple[float, float]] = {}
    for name in (*inputs, *moved_states(model.kind), *deflection):
        columns = [
            file.measurement.inputs.get(name, np.zeros(1))
            if name in inputs
            else file.trajectory[name]
            for file in compared.files
        ]
        found[name] = (
            min(float(values.min()) for values in columns),
            max(float(values.max()) for values in columns),
        )
    return found


def widened(ranges: Mapping[str, Sequence[float]]) -> dict[str, tuple[float, float]]:
    """Ranges with a margin: what goes beyond them by less is not outside."""
    return {
        name: (low - _MARGIN * (high - low), high + _MARGIN * (high - low))
        for name, (low, high) in ranges.items()
    }


# ---- diagnosis and parameters --------------------------------------------------------------


def _diagnosis(given: str | Path | Mapping[str, Any], model: Model) -> dict[str, Any]:
    """What the report keeps of a diagnosis, which has to be that of the model."""
    from elastic_tendon.diagnosis.diagnosis_json import SCHEMA as DIAGNOSIS  # only here needed

    source = "the diagnosis" if isinstance(given, Mapping) else str(given)
    try:
        whole = given if isinstance(given, Mapping) else json.loads(Path(given).read_bytes())
        if whole["schema"] != DIAGNOSIS:
            raise EvidenceError(f"{source}: its schema is not {DIAGNOSIS}; diagnose again")
        _check_same(load_model(whole["model"]), model, source)
        wanted = ("verdict", "sentence", "complete", "added", "certainty", "parameters_changed")
        lists = ("remaining", "ladder", "parameters", "fitted_files", "heldout_files")
        kept = {name: whole[name] for name in (*wanted, *lists)}
        return {**kept, "vetoed": list(_vetoed(whole["rounds"]))}
    except OSError as error:
        raise EvidenceError(f"{source}: cannot be read ({error.strerror})") from None
    except (ValueError, KeyError, TypeError, ModelError):
        raise EvidenceError(
            f"{source}: this is no diagnosis; give the file that diagnose --json wrote"
        ) from None


def _check_same(found: Model, model: Model, source: str) -> None:
    same = found.structure == model.structure and found.motion is model.motion
    values = model.values()
    if not same or any(
        not np.isclose(value, values[path], rtol=1e-9, atol=0.0)
        for path, value in found.values().items()
    ):
        raise EvidenceError(
            f"{source}: it did not find this model; export the one that diagnose --save-model wrote"
        )


def _vetoed(rounds: Sequence[Mapping[str, Any]]) -> Iterator[dict[str, Any]]:
    """Sets of effects that were fitted and not taken, with the reason."""
    for considered in rounds:
        for candidate in considered["candidates"]:
            if candidate["fitted"] and list(candidate["ids"]) != list(considered["chosen"]):
                yield {name: candidate[name] for name in ("ids", "reason", "heldout_gain")}


def _role(recording: Measurement, found: Mapping[str, Any] | None) -> str:
    if found is None:
        return "not told"
    for role, names in (("fitted", "fitted_files"), ("held out", "heldout_files")):
        if recording.name in found[names]:
            return role
    return "not seen by the diagnosis"


def _uncertainty(
    model: Model, recordings: Sequence[Measurement], found: Mapping[str, Any] | None
) -> Uncertainty:
    """Of the parameters that are not known: sizes of the diagnosis, else as the model states them.

    How they are correlated, the recordings and these sizes together tell.
    """
    paths = free_parameters(model)
    basis = "model" if found is None else "diagnosis"
    if not paths:
        return Uncertainty((), (), (), basis)
    problem = problem_of(model, recordings, paths)
    diagnosed = {row["path"]: row for row in (found or {"parameters": ()})["parameters"]}
    declared = {variable.name: variable for variable in interface(*model.structure).parameters}
    values, sigmas, intervals = model.values(), [], []
    stated_sigmas = problem.coordinates.sigma[: len(paths)].tolist()  # the model's come first
    for path, stated in zip(paths, stated_sigmas, strict=True):
        low, high = values[path] - CONFIDENCE * stated, values[path] + CONFIDENCE * stated
        if path in diagnosed:
            stated, (low, high) = diagnosed[path]["sigma"], diagnosed[path]["interval"]
        sigmas.append(stated)
        bounds = declared[path]
        intervals.append((max(low, bounds.lower), min(high, bounds.upper)))
    covariance = _correlation(problem, model) * np.outer(sigmas, sigmas)
    rows = tuple(map(tuple, covariance.tolist()))
    return Uncertainty(tuple(paths), tuple(intervals), rows, basis)


def _correlation(problem: Problem, model: Model) -> Array:
    """Correlation (m, m) of the model's free parameters."""
    count = len(problem.coordinates.of_model)
    try:
        vector = problem.start(model)
        jacobian = problem.data_jacobian(vector, problem.sigmas(vector))
    except SimulationError:  # derivatives can fail where the motion itself does not
        return np.eye(count)
    every = len(problem.coordinates.paths)
    jacobian[:, :every] *= problem.coordinates.sigma
    prior = np.eye(jacobian.shape[1])[:every]
    # not of the product of derivatives, in which the prior would be lost beside data without noise
    inverse = np.linalg.pinv(np.vstack([jacobian, prior]))[:count]
    covariance = inverse @ inverse.T
    size = np.sqrt(np.diag(covariance))
    return np.asarray(covariance / np.outer(size, size))


def _parameter_set(model: Model, uncertainty: Uncertainty) -> bytes:
    units = {quantity.path: quantity.unit for quantity in model.quantities()}
    return parameter_set(without_names(model.name), model.values(), units, uncertainty)


# ---- who, when, with what ------------------------------------------------------------------


def _date() -> str:
    """The day of SOURCE_DATE_EPOCH, else today."""
    epoch = os.environ.get("SOURCE_DATE_EPOCH")
    now = datetime.fromtimestamp(int(epoch), UTC) if epoch else datetime.now(UTC)
    return now.strftime("%Y-%m-%d")


def _provenance(command: str | None) -> dict[str, Any]:
    return {
        "command": without_names(command),
        "python": platform.python_version(),
        "versions": {name: version(name) for name in _PACKAGES},
    }
