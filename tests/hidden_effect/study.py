"""Runs the cases: builds them, asks the tool, keeps what it said on disk."""

import json
import os
import pickle
import time
from collections.abc import Mapping
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

import numpy as np

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.diagnosis.diagnose import diagnose
from elastic_tendon.diagnosis.diagnosis_json import diagnosis_json
from elastic_tendon.measurement import Measurement
from hidden_effect import recordings
from hidden_effect.cases import Case, Order, UnreachableError, build, generator, rivals_of
from hidden_effect.machines import EFFECTS
from hidden_effect.score import Result, called_undecided
from truth.fast import Inputs, Player

Content = dict[str, Any]


def written(path: Path, content: bytes) -> None:
    """Write a file whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    beside = path.with_suffix(f".{os.getpid()}")
    beside.write_bytes(content)
    beside.replace(path)


def all_rivals(case: Case) -> dict[str, dict[str, float]]:
    """ΔBIC of the rivals of every hidden effect of the catalogue."""
    return {one: rivals_of(case, one) for one in case.order.effects if one in EFFECTS}


def facts_of(case: Case, rivals: Mapping[str, Mapping[str, float]]) -> Content:
    """What the score needs to know of a case; `rivals` as of `Result`."""
    order = asdict(case.order)
    known = {field.name for field in fields(Result)} & order.keys()
    # with a torque signal each sample is two values
    count = sum(len(one.time) * len(one.signals) for one in case.fit)
    return {key: order[key] for key in known} | {
        "name": case.name,
        "ratio": case.facts.ratio,
        "samples": count,
        "rivals": rivals,
        "numbers": case.facts.numbers,
        "floor": case.facts.heldout_floor,
    }


def prepared(order: Order, folder: Path) -> tuple[Case, Content]:
    """A case and its facts, from disk where they are kept there.

    Raises
    ------
    UnreachableError : the effect does not show in the experiment
    """
    path = folder / "cases" / f"{order.name}.pickle"
    if path.exists():
        case, facts = pickle.loads(path.read_bytes())
    else:
        case = build(order)
        facts = facts_of(case, all_rivals(case))
        written(path, pickle.dumps((case, facts)))
    return case, facts


def asked(
    given: Model, fit: tuple[Measurement, ...], validation: tuple[Measurement, ...]
) -> tuple[Content, float]:
    """What the tool says, as the JSON that users get, and how long it took, s.

    Raises
    ------
    KeyboardInterrupt : the tool was interrupted; what it has by then is no answer to score
    """
    begin = time.perf_counter()
    answer = diagnose(given, fit, validation)
    seconds = time.perf_counter() - begin
    if not answer.complete:
        raise KeyboardInterrupt
    content = diagnosis_json(answer)
    # through text, as whoever reads the file gets it
    return json.loads(json.dumps(content)), seconds


def proposed_run(case: Case, experiment: Content) -> Measurement:
    """What the machine does in the experiment that the tool proposes."""
    facts = case.facts
    columns = [
        np.array(experiment[key]) for key in ("time_s", "motor_position_rad", "load_torque_Nm")
    ]
    inputs = Inputs(columns[0] - columns[0][0], columns[1], columns[2])
    offset = facts.truth.get("effects", {}).get("motor_encoder_offset", {}).get("offset", 0.0)
    # the motor is moved until its encoder shows what is asked for
    ratio = facts.truth["transmission"]["motor_pulley_radius"]
    ratio /= facts.truth["transmission"]["joint_pulley_radius"]
    start = (ratio * (float(inputs.motor_position[0]) - offset), 0.0)
    run = Player(inputs).run(facts.truth, start)
    rng = generator(case.order, "noise of the proposed experiment")
    return recordings.shown(
        "proposed", inputs, run, run, facts.noise, facts.torque_sigma, rng
    ).measurement


def result_of(
    facts: Content, diagnosis: Content, follow_up: Content | None, seconds: float
) -> Result:
    """A result for the score."""
    return Result(
        **(facts | {"effects": tuple(facts["effects"])}),
        diagnosis=diagnosis,
        follow_up=follow_up,
        seconds=seconds,
    )


def judged(order: Order, folder: Path) -> Result | None:
    """The result of one case, from disk where it is kept there; None for one that cannot be."""
    path = folder / "results" / f"{order.name}.json"
    if path.exists():
        kept = json.loads(path.read_text())
        return None if kept is None else result_of(**kept)
    try:
        case, facts = prepared(order, folder)
    except UnreachableError:
        written(path, b"null")
        return None
    diagnosis, seconds = asked(case.given, case.fit, case.validation)
    result = result_of(facts, diagnosis, None, seconds)
    follow_up = None
    if (
        order.family == "effect"
        and called_undecided(result)
        and "time_s" in diagnosis["next_experiment"]
    ):
        more = proposed_run(case, diagnosis["next_experiment"])
        follow_up, _ = asked(case.given, (*case.fit, more), case.validation)
    # its samples, which nobody scores, are most of the file
    diagnosis["next_experiment"] = "time_s" in diagnosis["next_experiment"]
    kept = {"facts": facts, "diagnosis": diagnosis, "follow_up": follow_up, "seconds": seconds}
    written(path, json.dumps(kept).encode())
    return result_of(**kept)
