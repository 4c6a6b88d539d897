"""The contract ``elastic-tendon/diagnosis/1``: a diagnosis as plain data."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from math import sqrt
from typing import Any

from elastic_tendon.diagnosis.result import Candidate, Diagnosis, Experiment, LearnedTerm, Round
from elastic_tendon.identify.bins import Bin
from elastic_tendon.identify.compare import Comparison
from elastic_tendon.identify.comparison_json import plain

SCHEMA = "elastic-tendon/diagnosis/1"


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
            "words": diagnosis.words,
            "interrupted": diagnosis.interrupted,
            "fitted_files": _names(diagnosis.comparison),
            "heldout_files": _names(diagnosis.steps[-1].heldout),
            "added": diagnosis.added,
            "parameters_changed": diagnosis.parameters_changed,
            "remaining": {name: asdict(one) for name, one in diagnosis.remaining.items()},
            "noise": {name: asdict(one) for name, one in diagnosis.noise.items()},
            "parameters": [asdict(one) for one in found.estimates],
            "ratios": [asdict(one) for one in found.ratios],
            "undetermined": found.sentences,
            "ladder": [rung.to_json() for rung in diagnosis.ladder],
            "rounds": [_round(one) for one in diagnosis.rounds],
            "indistinguishable": diagnosis.indistinguishable,
            "where": list(_where(diagnosis)),
            "learned": _learned(diagnosis.learned, learned_file),
            "next_experiment": _experiment(diagnosis.next_experiment),
            "model": diagnosis.model.model_dump(mode="json", exclude_none=True),
        }
    )
    return content


def _names(comparison: Comparison | None) -> list[str]:
    files = () if comparison is None else comparison.files
    return [file.measurement.name for file in files]


def _round(one: Round) -> dict[str, Any]:
    return {
        "chosen": one.chosen,
        "reason": one.reason,
        "candidates": [_candidate(candidate) for candidate in one.candidates],
    }


def _candidate(one: Candidate) -> dict[str, Any]:
    return {
        "id": one.id,
        "kind": one.kind,
        "probability": one.probability,
        "score": one.score,
        "expected_parameters": dict(one.expected),
        "fitted_parameters": [asdict(estimate) for estimate in one.fitted],
        "p_value": one.p_value,
        "gain": one.gain,
        "heldout_gain": one.heldout_gain,
        "equivalence_class": one.equivalence_class,
        "verdict": one.verdict,
    }


def _learned(term: LearnedTerm | None, file: str | None) -> dict[str, Any] | None:
    return None if term is None else asdict(term) | {"file": file}


def _experiment(one: Experiment | None) -> dict[str, Any] | None:
    if one is None:
        return None
    return {
        "text": one.text,
        "power": one.power,
        "time_s": one.time,
        "motor_position_rad": one.motor_position,
        "load_torque_Nm": one.load_torque,
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
            for one in bins:
                alike.setdefault((signal, one.by, one.bin), []).append((one, one.share * error))
    for (signal, by, name), parts in alike.items():
        held = sum(squares for _, squares in parts)
        alike_bins = [one for one, _ in parts]
        yield {
            "signal": signal,
            "by": by,
            "bin": name,
            **_pooled(alike_bins),
            "share": held / errors[signal] if errors[signal] else 0.0,
        }


def _pooled(bins: Sequence[Bin]) -> dict[str, Any]:
    """Figures of all samples in some bins; significances are added as normal variables are."""
    count = sum(one.count for one in bins)
    judged = [(one.significance, one.count) for one in bins if one.significance is not None]
    significance = None
    if judged:
        total = sum(value * sqrt(samples) for value, samples in judged)
        significance = total / sqrt(sum(samples for _, samples in judged))
    return {
        "count": count,
        "rmse": sqrt(sum(one.count * one.rmse**2 for one in bins) / count),
        "bias": sum(one.count * one.bias for one in bins) / count,
        "significance": significance,
        "stands_out": any(one.stands_out for one in bins),
    }
