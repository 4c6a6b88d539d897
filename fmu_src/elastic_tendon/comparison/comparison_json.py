"""The contract ``elastic-tendon/comparison/1``: a comparison as plain data."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from elastic_tendon.comparison.comparison import Comparison, FileComparison
from elastic_tendon.comparison.correlations import Correlation
from elastic_tendon.comparison.locate import FileLocation, Location
from elastic_tendon.comparison.missing_torque import MissingTorque
from elastic_tendon.comparison.tolerance import ToleranceCheck
from elastic_tendon.measurement.preparation import COMPARISON
from elastic_tendon.result import plain


def comparison_json(
    comparison: Comparison, location: Location, checks: Sequence[ToleranceCheck] = ()
) -> dict[str, Any]:
    """Everything that was compared and located, as plain data for `json.dumps`.

    Parameters
    ----------
    comparison : Comparison
    location : Location of the same comparison
    checks : of its signals against tolerances; a signal's says so under ``tolerance``

    Returns
    -------
    dict; SI units, numbers are finite or None
    """
    files = zip(comparison.files, location.files, strict=True)
    content: dict[str, Any] = plain(
        {
            "schema": COMPARISON,
            "model": comparison.model.name,
            "files": [_file(compared, located, checks) for compared, located in files],
        }
    )
    return content


def _file(
    compared: FileComparison, located: FileLocation, checks: Sequence[ToleranceCheck]
) -> dict[str, Any]:
    measurement = compared.measurement
    tolerances = {
        check.signal: {"tolerance": _tolerance(check)}
        for check in checks
        if check.recording == measurement.name
    }
    return {
        "name": measurement.name,
        "source": measurement.source,
        "notes": list(measurement.notes),
        "static": measurement.static,
        "preparation": measurement.preparation.model_dump(mode="json", exclude_none=True),
        **_selected(compared),
        "initial_state": compared.initial_state.as_dict(measurement.kind),
        "missing_torque": _missing_torque(located.missing_torque),
        "signals": {
            name: {
                **asdict(error),
                "where": [asdict(bin_) for bin_ in located.bins[name]],
                "in_words": located.in_words[name],
                "residual_tests": list(map(_residual_test, located.correlations.get(name, ()))),
                **tolerances.get(name, {}),
            }
            for name, error in compared.signals.items()
        },
    }


def _selected(compared: FileComparison) -> dict[str, Any]:
    """Over which samples the figures of the signals are; all else is of the whole recording."""
    if compared.selection is None:
        return {}
    conditions = [condition.text for condition in compared.selection.conditions]
    return {"only_where": conditions, "samples": len(compared.measurement.time)}


def _tolerance(check: ToleranceCheck) -> dict[str, Any]:
    return {
        "value": check.tolerance,
        "met": check.met,
        "time_of_largest": check.time,
        "share_beyond": check.share_beyond,
    }


def _residual_test(correlation: Correlation) -> dict[str, Any]:
    """Whether a residual follows its own past, or an input, by more than chance."""
    at = correlation.strongest
    return {
        "with": correlation.signal or "itself",
        "more_than_chance": bool(correlation.surely_beyond.any()),
        "lags": len(correlation.lag),
        "beyond": int(correlation.beyond.sum()),
        "beyond_by_chance": correlation.beyond_by_chance,
        "strongest": {
            "lag": correlation.lag[at],
            "correlation": correlation.values[at],
            "expected": correlation.expected[at],
            "bound": correlation.bound[at],
        },
    }


def _missing_torque(missing: MissingTorque) -> dict[str, Any]:
    return {
        "rms": float(np.sqrt(np.mean(missing.torque**2))),
        "sigma": float(np.sqrt(np.mean(missing.sigma**2))),
        "notes": list(missing.notes),
        "curves": [asdict(curve) for curve in missing.curves],
    }
