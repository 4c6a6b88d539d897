"""The contract ``elastic-tendon/diagnosis/2``: a diagnosis as plain data."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from math import sqrt
from typing import Any

from elastic_tendon.actuator.variables import SIGNALS
from elastic_tendon.comparison.bins import Bin
from elastic_tendon.comparison.comparison import Comparison
from elastic_tendon.comparison.simulated import SUFFIXES
from elastic_tendon.diagnosis.evidence import is_plausible
from elastic_tendon.diagnosis.experiment_text import undisputed_text
from elastic_tendon.diagnosis.result import Diagnosis, LearnedTerm
from elastic_tendon.estimation.coordinates import sizes_in
from elastic_tendon.result import plain

SCHEMA = "elastic-tendon/diagnosis/2"


def diagnosis_json(diagnosis: Diagnosis, learned_file: str | None = None) -> dict[str, Any]:
    """Everything that was found, as plain data for `json.dumps`.

    Parameters
    ----------
    diagnosis : Diagnosis
    learned_file : where the effect file of the learned term was written, None where it was not

    Returns
    -------
    dict; numbers are finite or None, in SI units where no other stands beside them
    """
    found = diagnosis.findings
    content: dict[str, Any] = plain(
        {
            "schema": SCHEMA,
            "verdict": diagnosis.verdict,
            "sentence": diagnosis.sentence,
            "notes": diagnosis.notes,
            "complete": diagnosis.complete,
            "fitted_files": _names(diagnosis.comparison),
            "heldout_files": _names(diagnosis.steps[-1].heldout),
            "added": diagnosis.added,
            "certainty": diagnosis.certainty,
            "parameters_changed": diagnosis.parameters_changed,
            "remaining": {name: asdict(left) for name, left in diagnosis.remaining.items()},
            "noise": {name: asdict(floor) for name, floor in diagnosis.noise.items()},
            "parameters": list(_parameters(diagnosis)),
            "parameters_of_recordings": [asdict(part) for part in found.of_recordings],
            "ratios": [asdict(ratio) for ratio in found.ratios],
            "undetermined": found.sentences,
            "ladder": [step.to_dict() for step in diagnosis.ladder],
            "rounds": [asdict(considered) for considered in diagnosis.rounds],
            "neighbours": [asdict(neighbour) for neighbour in diagnosis.neighbours],
            "would_show": [asdict(limit) for limit in diagnosis.would_show],
            "recordings": [asdict(summary) for summary in diagnosis.recordings],
            "indistinguishable": diagnosis.indistinguishable,
            "where": list(_where(diagnosis)),
            "learned": _learned(diagnosis.learned, learned_file),
            "next_experiment": _next_experiment(diagnosis),
            "model": diagnosis.model.model_dump(mode="json", exclude_none=True),
        }
    )
    return content


def _names(comparison: Comparison | None) -> list[str]:
    files = () if comparison is None else comparison.files
    return [file.measurement.name for file in files]


def _parameters(diagnosis: Diagnosis) -> Iterator[dict[str, Any]]:
    model = diagnosis.model
    files = diagnosis.steps[-1].comparison.files
    sizes = sizes_in(model, [file.measurement for file in files])
    for estimate in diagnosis.findings.estimates:
        plausible = is_plausible(model, estimate.path, estimate.fitted, sizes)
        yield asdict(estimate) | {"plausible": plausible}


def _learned(term: LearnedTerm | None, file: str | None) -> dict[str, Any] | None:
    return None if term is None else asdict(term) | {"file": file}


def _next_experiment(diagnosis: Diagnosis) -> dict[str, Any]:
    proposed = diagnosis.next_experiment
    if proposed is None:
        return {"reason": diagnosis.no_experiment or undisputed_text(complete=diagnosis.complete)}
    return {
        "text": proposed.text,
        "power": proposed.power,
        "time_s": proposed.time,
        **{name + SUFFIXES[SIGNALS[name].unit]: v for name, v in proposed.columns.items()},
    }


def _where(diagnosis: Diagnosis) -> Iterator[dict[str, Any]]:
    """Bins of all recordings, those with the same name as one.

    Their ranges differ from one recording to the next, but the slack states and the direction of
    motion do not.
    """
    alike: dict[tuple[str, str, str], list[tuple[Bin, float]]] = {}
    errors: dict[str, float] = {}  # signal -> sum of squares over all recordings
    for file, found in zip(diagnosis.comparison.files, diagnosis.location.files, strict=True):
        for signal, bins in found.bins.items():
            error = file.signals[signal].count * file.signals[signal].rmse ** 2
            errors[signal] = errors.get(signal, 0.0) + error
            for part in bins:
                alike.setdefault((signal, part.by, part.bin), []).append((part, part.share * error))
    for (signal, by, name), parts in alike.items():
        held = sum(squares for _, squares in parts)
        yield {
            "signal": signal,
            "by": by,
            "bin": name,
            **_pooled([part for part, _ in parts]),
            "share": held / errors[signal] if errors[signal] else 0.0,
        }


def _pooled(bins: Sequence[Bin]) -> dict[str, Any]:
    """Figures of all samples in some bins; significances are added as normal variables are."""
    count = sum(part.count for part in bins)
    judged = [(part.significance, part.count) for part in bins if part.significance is not None]
    significance = None
    if judged:
        total = sum(value * sqrt(samples) for value, samples in judged)
        significance = total / sqrt(sum(samples for _, samples in judged))
    return {
        "count": count,
        "rmse": sqrt(sum(part.count * part.rmse**2 for part in bins) / count),
        "bias": sum(part.count * part.bias for part in bins) / count,
        "significance": significance,
        "stands_out": any(part.stands_out for part in bins),
    }
