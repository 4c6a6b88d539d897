"""Whether an FMU is as sealed, does what its evidence says, and is used where it is valid."""

import json
import tempfile
import zipfile
import zlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from fmpy import read_model_description

from elastic_tendon.actuator.interfaces import InterfaceKind
from elastic_tendon.actuator.motion_kind import MotionKind
from elastic_tendon.actuator.quantity import unit_text
from elastic_tendon.actuator.variables import (
    LOAD_TORQUE,
    POSITION_OF,
    SIGNALS,
    interface,
    moved_states,
    reading_of,
)
from elastic_tendon.comparison.residuals import rms
from elastic_tendon.errors import EvidenceError
from elastic_tendon.evidence.experiment import (
    SMOKE_TEST,
    Array,
    Experiment,
    from_csv,
    result_names,
)
from elastic_tendon.evidence.gather import PARAMETERS, REPORT, SCHEMA, widened
from elastic_tendon.evidence.manifest import FOLDER, MANIFEST, Related, read_manifest
from elastic_tendon.evidence.parameter_set import read_values
from elastic_tendon.evidence.replay import IMPORTERS, by_another, run_held, run_straight
from elastic_tendon.evidence.seal import SEAL, check_seal, load_public_key
from elastic_tendon.evidence.xml_content import one_line, parse
from elastic_tendon.measurement import Measurement
from elastic_tendon.result import Result, plain

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

_LARGEST = 2**30  # bytes of an FMU when unpacked; more is no FMU but a way to fill a disk
# of an error that is stated: what rounding and other processors may change of it
_SAME = 1e-3


@dataclass(frozen=True, repr=False)
class Verification(Result):
    """What was found out about an FMU; it `passed` where there are no `faults`.

    `faults` : what differs, a sentence each. `differences` : result -> largest difference from the
    reference results, SI; None: nothing was run. `signed_by` : public key, hexadecimal digits.
    `ranges` : quantity -> least and largest value, SI, in which the model was validated. `errors` :
    recording -> signal -> stated and replayed RMS error (None: not replayed). `lines` : all of it
    in five lines.
    """

    name: str
    faults: tuple[str, ...]
    differences: Mapping[str, float] | None
    signed_by: str | None
    ranges: Mapping[str, tuple[float, float]]
    errors: Mapping[str, Mapping[str, tuple[float, float | None]]]
    lines: tuple[str, ...]

    @property
    def passed(self) -> bool:
        """Whether nothing differs."""
        return not self.faults

    def summary(self) -> str:
        """Five lines, and what differs."""
        return "\n".join([*self.lines, *(f"DIFFERS: {fault}" for fault in self.faults)])

    def to_dataframe(self) -> "pd.DataFrame":
        """Stated and replayed RMS error of each signal in each recording, a row each, SI."""
        import pandas as pd

        rows = [
            (recording, signal, *errors)
            for recording, signals in self.errors.items()
            for signal, errors in signals.items()
        ]
        return pd.DataFrame(rows, columns=["recording", "signal", "stated", "replayed"])

    def plot(self) -> "Figure":
        """Draw the stated error beside the replayed one."""
        from elastic_tendon.reports.evidence_figure import evidence_figure

        return evidence_figure(self)

    def to_dict(self) -> dict[str, Any]:
        """Everything, schema ``elastic-tendon/verification/1``."""
        content: dict[str, Any] = plain(
            {
                "schema": "elastic-tendon/verification/1",
                "name": self.name,
                "passed": self.passed,
                "faults": self.faults,
                "differences": self.differences,
                "signed_by": self.signed_by,
                "ranges": self.ranges,
                "errors": self.errors,
            }
        )
        return content


def verify(
    path: str | Path,
    *,
    importer: str = "fmpy",
    public_key: str | Path | None = None,
    inputs: Measurement | None = None,
) -> Verification:
    """Check an FMU with evidence: bytes, signature, and what its own binary does.

    A binary that is not as it was sealed is not run.

    Parameters
    ----------
    path : of an FMU, by `export_fmu`, or of another maker with content of LS-REF
    importer : what runs it: "fmpy", "ecos" or "libcosim"; errors are replayed by fmpy alone
    public_key : file of the Ed25519 key (PEM) that it has to be signed with
    inputs : motion that is planned; whether it leaves the range of validity is told

    Returns
    -------
    Verification

    Raises
    ------
    EvidenceError : it is no FMU, has no evidence, or cannot be run here
    MeasurementError : `inputs` do not hold what the FMU's interface needs
    """
    if importer not in IMPORTERS:
        raise EvidenceError(f"there is no importer {importer!r} here; {', '.join(IMPORTERS)} are")
    path = Path(path)
    whole, files = read_fmu(path)
    if MANIFEST not in files and REPORT not in files and SEAL not in files:
        raise EvidenceError(
            f"{path.name}: it carries no evidence; export it with --with-evidence DATA"
        )
    if REPORT not in files and SEAL not in files:
        return _of_another_maker(path, files)
    try:
        return _Check(path, files, importer).run(whole, public_key, inputs)
    except (LookupError, TypeError, ValueError, AttributeError, ArithmeticError) as error:
        raise EvidenceError(f"{path.name}: its evidence is incomplete ({error!r})") from None


def read_fmu(path: Path) -> tuple[bytes, dict[str, bytes]]:
    """All bytes of an FMU, and the content of its files."""
    try:
        whole = path.read_bytes()
        with zipfile.ZipFile(path) as archive:
            if sum(entry.file_size for entry in archive.infolist()) > _LARGEST:
                raise EvidenceError(f"{path.name}: unpacked it is larger than any FMU")
            files = {
                name: archive.read(name) for name in archive.namelist() if not name.endswith("/")
            }
    except OSError as error:
        raise EvidenceError(f"{path}: cannot be read ({error.strerror})") from None
    except (
        zipfile.BadZipFile,
        zipfile.LargeZipFile,
        ValueError,
        NotImplementedError,  # a kind of compression that zipfile does not know
        EOFError,
        RuntimeError,
        zlib.error,
    ) as error:
        raise EvidenceError(f"{path.name}: it is no FMU, or damaged ({error})") from None
    if "modelDescription.xml" not in files:
        raise EvidenceError(f"{path.name}: it is no FMU, it has no modelDescription.xml")
    return whole, files


@contextmanager
def _unpacked(files: Mapping[str, bytes]) -> Iterator[str]:
    with tempfile.TemporaryDirectory() as folder:
        for name, content in files.items():
            target = Path(folder, name)
            if ".." in target.parts or not target.is_relative_to(folder):
                raise EvidenceError(f"{name!r}: a file of an FMU has to stay in its folder")
            try:
                target.parent.mkdir(parents=True, exist_ok=True)
                target.write_bytes(content)
            except (OSError, ValueError) as error:
                raise EvidenceError(f"{name!r} cannot be unpacked ({error})") from None
        yield folder


# ---- other makers --------------------------------------------------------------------------


def _of_another_maker(path: Path, files: Mapping[str, bytes]) -> Verification:
    """What its manifest lists has to be there; parameter sets have to fit its variables."""
    related = read_manifest(files[MANIFEST], path.name)
    inside = [file for file in related if file.path is not None]
    faults = [f"{file.source} is listed and missing" for file in inside if file.path not in files]
    there = [file for file in inside if file.path in files]
    sets = [file for file in there if file.type.endswith("ssp-parameter-set")]
    names = _variable_names(files["modelDescription.xml"], path.name)
    for file in sets:
        unknown = read_values(files[str(file.path)], file.source).keys() - names
        if unknown:
            faults.append(
                f"{file.source} sets {', '.join(sorted(unknown))}, which it does not have"
            )
    return Verification(
        *(path.name, tuple(faults), None, None, {}, {}),
        lines=(
            f"{path.name}: content of LS-REF by another maker, {len(related)} files listed",
            "reproduces: not run, as LS-REF leaves the form of experiments to their makers",
            "valid for: not told in a form that is read here",
            f"brings along: {_by_role(related)}",
            "unsigned, in a form that is read here",
        ),
    )


def _by_role(related: tuple[Related, ...]) -> str:
    counts: dict[str, int] = {}
    for file in related:
        counts[file.role] = counts.get(file.role, 0) + 1
    return ", ".join(f"{count} {role}" for role, count in counts.items()) or "nothing"


def _variable_names(description: bytes, name: str) -> set[str]:
    root = parse(description, f"{name}: its modelDescription.xml")
    groups = root.findall("ModelVariables")
    return {one_line(variable.get("name", "")) for group in groups for variable in group}


def _starts(folder: str, name: str) -> dict[str, Any]:
    try:
        variables = read_model_description(folder).modelVariables
    except Exception as error:  # it raises what its parser of XML does, and more
        reason = (str(error).splitlines() or [type(error).__name__])[0]
        raise EvidenceError(f"{name}: its modelDescription.xml cannot be read ({reason})") from None
    return {variable.name: variable.start for variable in variables}


# ---- our own -------------------------------------------------------------------------------


class _Check:
    """One FMU that is checked; collects what differs."""

    def __init__(self, path: Path, files: Mapping[str, bytes], importer: str) -> None:
        self.path, self.name, self.files, self.importer = path, path.name, files, importer
        self.kind, self.motion = InterfaceKind.POSITION, MotionKind.ROTARY
        self.faults: list[str] = []
        self.differences: dict[str, float] = {}
        self.errors: dict[str, dict[str, tuple[float, float | None]]] = {}

    def run(
        self, whole: bytes, public_key: str | Path | None, inputs: Measurement | None
    ) -> Verification:
        faults, signed_by = check_seal(whole, self.files)
        self.faults += faults
        report = self._report()
        if report.get("signed_by") and signed_by != report["signed_by"]:
            self.faults.append("it was signed, and the signature was taken out or replaced")
        if public_key is not None:
            self._check_signer(signed_by, load_public_key(public_key))
        planned, leaves = "", None
        if not self.faults:
            with _unpacked(self.files) as folder:
                self._check_parameters(folder)
                self._reproduce(folder, report)
                if self.importer == "fmpy":
                    self._replay(folder, report)
                if inputs is not None:
                    planned, leaves = self._planned(folder, report["range"], inputs)
        ran = bool(self.differences)
        ranges = {name: (low, high) for name, (low, high) in report.get("range", {}).items()}
        return Verification(
            name=self.name,
            faults=tuple(map(one_line, [*self.faults, *([leaves] if leaves else [])])),
            differences=self.differences if ran else None,
            signed_by=signed_by,
            ranges=ranges,
            errors=self.errors,
            lines=self._lines(report, ranges, signed_by, planned),
        )

    def _report(self) -> dict[str, Any]:
        """The report; empty where it cannot be read, which is a fault then."""
        try:
            report = json.loads(self.files[REPORT])
        except (KeyError, ValueError):
            report = None
        if not isinstance(report, dict) or report.get("schema") != SCHEMA:
            self.faults.append(f"{REPORT} is missing or not of schema {SCHEMA}")
            return {}
        # evidence of before there were others does not tell them
        self.kind = InterfaceKind(report.get("interface", self.kind))
        self.motion = MotionKind(report.get("motion", self.motion))
        return report

    def _unit(self, name: str) -> str:
        return self.motion.words(unit_text(SIGNALS[name].unit))

    def _check_signer(self, signed_by: str | None, wanted: str) -> None:
        if signed_by is None:
            self.faults.append("it is not signed, and a signature was asked for")
        elif signed_by != wanted:
            self.faults.append("it is signed with another key than the one that was asked for")

    def _check_parameters(self, folder: str) -> None:
        """What is stated of the parameters has to be what the FMU starts with."""
        values = read_values(self.files[PARAMETERS], PARAMETERS)
        starts = _starts(folder, self.name)
        for name, value in values.items():
            if not np.isclose(float(starts.get(name) or np.nan), value, rtol=1e-9, atol=0.0):
                self.faults.append(f"{name} is {starts.get(name)} in the FMU, stated is {value!r}")

    def _experiment(self, name: str, start: Mapping[str, float]) -> Experiment:
        given = [variable.name for variable in interface((), self.kind).inputs]
        needed = [name for name in given if name not in (*POSITION_OF, LOAD_TORQUE.name)]
        columns = self._table(f"{name}_inputs", ("time", *needed))
        return Experiment(name, columns.pop("time"), columns, start)

    def _table(self, name: str, wanted: Sequence[str] = ("time",)) -> dict[str, Array]:
        path = f"{FOLDER}{name}.csv"
        return from_csv(self.files[path], path, wanted)

    def _reproduce(self, folder: str, report: Mapping[str, Any]) -> None:
        """Run all experiments with held inputs beside their reference results."""
        names, states = result_names(self.kind), moved_states(self.kind)
        experiments: list[tuple[str, Mapping[str, float], Mapping[str, float]]]
        experiments = [(SMOKE_TEST, {}, report["smoke_test"]["tolerances"])]
        if self.importer == "fmpy":
            experiments += [
                (recording["experiment"], recording["start"], recording["tolerances"])
                for recording in report["recordings"]
                if recording["packed"]
            ]
        for name, start, tolerances in experiments:
            experiment = self._experiment(name, start)
            if self.importer == "fmpy":
                results = run_held(folder, self.name, experiment).outputs
            else:
                path = str(self.path.resolve())
                results = by_another(self.importer, path, experiment, states)
            reference = self._table(f"{name}_results", ("time", *names))
            at = np.searchsorted(experiment.time, reference["time"])
            for signal in names if self.importer == "fmpy" else states:
                apart = float(np.max(np.abs(results[signal][at] - reference[signal])))
                self.differences[signal] = max(apart, self.differences.get(signal, 0.0))
                if not apart <= tolerances[signal]:
                    unit = self._unit(signal)
                    self.faults.append(
                        f"{name}: {signal} is {apart:.3g} {unit} from the reference results, "
                        f"{tolerances[signal]:.3g} {unit} are allowed"
                    )

    def _replay(self, folder: str, report: Mapping[str, Any]) -> None:
        """Run the recordings as they were compared, beside what was measured."""
        for recording in report["recordings"]:
            stated = {signal: error["rmse"] for signal, error in recording["signals"].items()}
            self.errors[recording["name"]] = {
                signal: (rmse, None) for signal, rmse in stated.items()
            }
            if not recording["replayed"]:
                continue
            experiment = self._experiment(recording["experiment"], recording["start"])
            runner = run_held if recording["interpolation"] == "hold" else run_straight
            run = runner(folder, self.name, experiment)
            measured = self._table(f"{recording['experiment']}_measured", ("time", *stated))
            for signal, rmse in stated.items():
                reading = reading_of(signal, run.outputs)
                replayed = rms(run.outputs[reading] - measured[signal])
                self.errors[recording["name"]][signal] = rmse, replayed
                noise = recording["signals"][signal]["noise"]["sigma"]
                if not abs(replayed - rmse) <= _SAME * (rmse + noise) + run.off[reading]:
                    self.faults.append(
                        f"{recording['name']}: the RMS error of {signal} is {replayed:.6g} "
                        f"{self._unit(signal)}, stated is {rmse:.6g}"
                    )

    def _planned(
        self, folder: str, ranges: Mapping[str, tuple[float, float]], inputs: Measurement
    ) -> tuple[str, str | None]:
        """Run a planned motion; whether it leaves the range of validity, in one line, and where.

        Nothing is wrong with the FMU then, but with its use.
        """
        inputs = inputs.of_motion(self.motion).at(self.kind)
        time = inputs.time - inputs.time[0]
        start = self._at_rest(folder, inputs)
        run = run_straight(folder, self.name, Experiment("planned", time, inputs.inputs, start))
        outside = np.zeros(len(time), dtype=bool)
        leaves = []
        for name, (low, high) in widened(ranges).items():
            values = inputs.inputs.get(name, run.outputs.get(name))
            if values is None:
                continue
            beyond = (values < low) | (values > high)
            outside |= beyond
            if beyond.any():
                leaves.append(f"{name} from {inputs.time[np.argmax(beyond)]:.6g} s")
        if not leaves:
            return "planned inputs: stay in the range in which it was validated", None
        share = f"{100.0 * np.mean(outside):.3g} % of the samples"
        return (
            f"planned inputs: leave the range in which it was validated, {share}",
            f"the planned inputs leave the range of validity: {', '.join(leaves)}",
        )

    def _at_rest(self, folder: str, inputs: Measurement) -> dict[str, float]:
        """Where what is moved rests at first, opposite a position that is given, (10)."""
        if self.kind not in (InterfaceKind.POSITION, InterfaceKind.TORQUE_JOINT):
            return {}
        starts = _starts(folder, self.name)
        motor, joint = (
            float(starts[f"transmission.{end}_pulley_radius"]) for end in ("motor", "joint")
        )
        if self.kind is InterfaceKind.POSITION:
            return {"joint_position": float(inputs.motor_position[0]) * motor / joint}
        return {"motor_position": float(inputs.joint_position[0]) * joint / motor}

    def _lines(
        self,
        report: Mapping[str, Any],
        ranges: Mapping[str, tuple[float, float]],
        signed_by: str | None,
        planned: str,
    ) -> tuple[str, ...]:
        apart = ", ".join(
            f"{name} within {size:.2g} {self._unit(name)}"
            for name, size in self.differences.items()
        )
        valid = ", ".join(
            f"{name} {low:.3g} to {high:.3g} {self._unit(name)}"
            for name, (low, high) in ranges.items()
        )
        told = (
            f"{self.name}: {'as it was sealed' if not self.faults else 'NOT as it should be'}",
            f"reproduces: {apart or 'not run'}{f' ({self.importer})' if apart else ''}",
            f"valid for: {valid or 'not told'}",
            f"validated against: {self._validated(report)}",
            f"signed by {signed_by}" if signed_by else "unsigned",
            *([planned] if planned else []),
        )
        return tuple(map(one_line, told))

    def _validated(self, report: Mapping[str, Any]) -> str:
        """Recordings with the errors that are stated, and which of them were not replayed."""
        parts = []
        for recording in report.get("recordings", ()):
            told = [
                f"{signal} {error['rmse']:.3g} {self._unit(signal)} RMS, "
                f"{error['noise_ratio']:.3g} x noise"
                for signal, error in recording["signals"].items()
            ]
            replayed = self.errors.get(recording["name"], {}).values()
            if None in [again for _, again in replayed] or not replayed:
                told.append("as stated, not replayed")
            parts.append(f"{recording['name']} ({'; '.join(told)})")
        if not parts:
            return "not told"
        found = report.get("diagnosis")
        verdict = f"; diagnosis: {found['verdict']}" if found else ""
        return f"{', '.join(parts)}, {report['date']}{verdict}"
