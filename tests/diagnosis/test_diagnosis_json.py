"""The contract ``elastic-tendon/diagnosis/2``."""

import json
from dataclasses import replace

import numpy as np
import pytest

from elastic_tendon.actuator.parameters import parse_model
from elastic_tendon.comparison.comparison import Comparison
from elastic_tendon.comparison.locate import Location
from elastic_tendon.diagnosis.diagnosis_json import diagnosis_json
from hand_made_diagnosis import friction_found, next_experiment, nothing_missing, something_unknown

VERDICTS = {"adequate", "wrong_parameter", "missing_effect", "unexplained"}
NUMBER = (int, float)
MAYBE_NUMBER = (int, float, type(None))
# what each part must hold, and of which type; more is allowed
CONTRACT = {
    "remaining": {
        "noise_ratio": NUMBER,
        "share_of_initial": NUMBER,
        "significant": bool,
        "matters": bool,
    },
    "parameters": {
        "path": str,
        "given": NUMBER,
        "fitted": NUMBER,
        "interval": list,
        "determined": bool,
        "plausible": bool,
    },
    "ladder": {
        "added": (str, type(None)),
        "rmse": dict,
        "heldout_rmse": dict,
        "noise_ratio": dict,
        "evidence": NUMBER,
        "probability": NUMBER,
    },
    "rounds": {"chosen": list, "candidates": list},
    "candidates": {
        "ids": list,
        "probability": NUMBER,
        "evidence": MAYBE_NUMBER,
        "expected_parameters": dict,
        "heldout_gain": MAYBE_NUMBER,
        "equivalence_class": list,
        "fitted": bool,
        "reason": str,
    },
    "neighbours": {
        "change": str,
        "evidence": MAYBE_NUMBER,
        "probability": NUMBER,
        "rmse": dict,
        "refitted": bool,
    },
    "would_show": {"id": str, "path": str, "smallest": MAYBE_NUMBER},
    "recordings": {
        "file": str,
        "role": str,
        "rmse": dict,
        "explained_by": (str, type(None)),
        "contradicts": list,
    },
    "where": {
        "by": str,
        "bin": str,
        "rmse": NUMBER,
        "share": NUMBER,
        "significance": MAYBE_NUMBER,
    },
    "noise": {"sigma": NUMBER, "kind": str, "source": str},
}
LISTS = (
    *("parameters", "ladder", "rounds", "where"),
    *("neighbours", "would_show", "recordings"),
)


def expect(part: str, entries) -> None:
    for entry in entries:
        for key, kind in CONTRACT[part].items():
            assert isinstance(entry[key], kind), f"{part}: {key} is {entry[key]!r}"


def written(diagnosis, file=None):
    return json.loads(json.dumps(diagnosis_json(diagnosis, file), allow_nan=False))


@pytest.mark.parametrize("make", [friction_found, something_unknown, nothing_missing])
def test_every_verdict_keeps_the_contract(make) -> None:
    content = written(make())
    assert content["schema"] == "elastic-tendon/diagnosis/2"
    assert content["verdict"] in VERDICTS
    assert content["sentence"] == make().sentence
    assert content["complete"] is True
    for part in ("remaining", "noise"):
        assert content[part]
        expect(part, content[part].values())
    for part in LISTS:
        assert content[part]
        expect(part, content[part])
    for one in content["rounds"]:
        expect("candidates", one["candidates"])
    assert all(isinstance(one, str) for one in content["added"] + content["parameters_changed"])
    assert content["ladder"][0]["added"] is None
    assert parse_model(content["model"], "json") == make().model


def test_candidates_come_with_their_evidence() -> None:
    content = written(friction_found())
    first = content["rounds"][0]["candidates"][0]
    assert first["expected_parameters"] == {"effects.coulomb_friction.torque": 0.33}
    assert first["ids"] == ["coulomb_friction"]
    assert first["equivalence_class"] == [["coulomb_friction"], ["lugre_friction"]]
    assert first["fitted_parameters"][0]["path"] == "effects.coulomb_friction.torque"
    assert content["indistinguishable"] == [["coulomb_friction", "lugre_friction"]]


def test_experiment_and_learned_term_are_there_or_null() -> None:
    content = written(friction_found())
    assert content["learned"] is None
    experiment = next_experiment()
    assert content["next_experiment"]["text"] == experiment.text
    assert content["next_experiment"]["motor_position_rad"] == pytest.approx(
        experiment.motor_position
    )
    unknown = written(something_unknown(), "better_learned.py")
    assert set(unknown["next_experiment"]) == {"reason"}
    reasons = written(friction_found(next_experiment=None))["next_experiment"]
    assert reasons == {"reason": "No motion tells the two apart."}
    assert unknown["learned"]["file"] == "better_learned.py"
    assert unknown["learned"]["variables"] == ["joint_velocity"]


def test_numbers_that_are_not_finite_are_null() -> None:
    diagnosis = friction_found()
    endless = replace(diagnosis.ladder[0], evidence=float("inf"))
    content = written(replace(diagnosis, ladder=(endless, *diagnosis.ladder[1:])))
    assert content["ladder"][0]["evidence"] is None


def test_where_counts_all_recordings() -> None:
    one = friction_found()
    twice = replace(
        one,
        comparison=Comparison(one.model, one.comparison.files * 2),
        location=Location(one.location.files * 2),
    )
    single, double = (written(each)["where"] for each in (one, twice))
    assert len(single) == len(double)
    for alone, both in zip(single, double, strict=True):
        assert both["count"] == 2 * alone["count"]
        assert both["share"] == pytest.approx(alone["share"])
        assert both["rmse"] == pytest.approx(alone["rmse"])
    by_state = [entry["share"] for entry in single if entry["by"] == "slack_state"]
    assert np.sum(by_state) == pytest.approx(1.0)
