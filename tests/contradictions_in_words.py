"""Whether a diagnosis contradicts itself: sentence, verdict, tables, ladder and neighbours."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from elastic_tendon import effects

SURELY = 0.99  # probability from which the sentence says so
DECISIVE = 10.0  # in evidence


def contradictions_of(document: Mapping[str, Any]) -> list[str]:
    """What is said in two places, and not the same; each a sentence.

    Parameters
    ----------
    document : by the contract ``elastic-tendon/diagnosis/2``
    """
    return [*_of_verdict(document), *_of_ladder(document), *_of_rounds(document)]


def _of_verdict(document: Mapping[str, Any]) -> Iterator[str]:
    verdict, sentence, added = (document[name] for name in ("verdict", "sentence", "added"))
    for effect_id in added:
        if effects.BY_ID[effect_id].title.lower() not in sentence.lower():
            yield f"the sentence is silent of {effect_id}"
    if verdict == "missing_effect" and not added:
        yield "an effect is missing and none is named"
    if verdict in ("adequate", "wrong_parameter") and added:
        yield f"{verdict}, and yet effects are named"
    left = any(part["matters"] and part["significant"] for part in document["remaining"].values())
    if left and verdict != "unexplained":
        yield f"{verdict}, and yet what is left is significant and matters"
    if "surely" in sentence and max(document["certainty"].values(), default=1.0) < SURELY:
        yield "surely, and yet no effect is that certain"
    for near in document["neighbours"]:
        better = near["evidence"] is not None and near["evidence"] < -DECISIVE
        if better and near["refitted"] and not near["reason"]:
            yield f"{near['change']} does better, and no reason speaks against it"


def _of_ladder(document: Mapping[str, Any]) -> Iterator[str]:
    first, last = document["ladder"][0], document["ladder"][-1]
    model = set(document["model"].get("effects", {}))
    if not set(document["added"]) <= model:
        yield "the model lacks an effect that was added"
    for name, left in document["remaining"].items():
        if abs(last["noise_ratio"][name] / left["noise_ratio"] - 1.0) > 1e-9:
            yield f"the ladder ends elsewhere than what remains of {name}"
    if document["verdict"] != "adequate" and all(
        last["rmse"][name] > first["rmse"][name] for name in first["rmse"]
    ):
        yield "the ladder rises"


def _of_rounds(document: Mapping[str, Any]) -> Iterator[str]:
    taken = [effect_id for entry in document["rounds"] for effect_id in entry["chosen"]]
    if set(taken) != set(document["added"]):
        yield "the rounds chose others than were added"
    of_class = {part: group[0] for group in document["indistinguishable"] for part in group}

    def classes(ids: Iterable[str]) -> set[str]:
        return {of_class.get(effect_id, effect_id) for effect_id in ids}

    for entry in document["rounds"]:
        rows = {tuple(row["ids"]): row for row in entry["candidates"]}
        total = sum(row["probability"] for row in rows.values())
        if total > 1.0 + 1e-9:
            yield f"probabilities of a round sum to {total:.3g}"
        chosen = rows.get(tuple(entry["chosen"]))
        if chosen is None:
            continue
        alike = [rows[tuple(ids)] for ids in chosen["equivalence_class"] if tuple(ids) in rows]
        sure = min(document["certainty"][effect_id] for effect_id in entry["chosen"])
        if chosen["probability"] > sure + 1e-9:
            yield f"{entry['chosen']} is likelier in its round than in the verdict"
        if sure >= SURELY and sum(row["probability"] for row in alike) < 0.5:
            yield f"{entry['chosen']} is surely there, and unlikely in its round"
        for ids, row in rows.items():
            # the sentence says that data do not tell it from what was found in the end
            told = classes(entry["chosen"]) <= classes(ids) <= classes(document["added"])
            if not told and row not in alike and row["probability"] > chosen["probability"]:
                yield f"{ids} is likelier than {entry['chosen']}, which was chosen"
