"""Effects that are surely there and too small for anybody to hear of: a note, no verdict."""

from collections.abc import Sequence

from elastic_tendon import effects
from elastic_tendon.diagnosis.answer import Answer
from elastic_tendon.diagnosis.evidence import (
    AT_NOISE,
    DECISIVE,
    DECISIVE_IN_PLACE,
    TOO_LITTLE,
    Evidence,
)


def answers(evidence: Evidence, answer: Answer, refitted: Sequence[Answer]) -> list[Answer]:
    """Answers with one effect more that are surely better and explain too little, the best first
    and what these data do not tell from it; none where more than noise is left.

    Parameters
    ----------
    evidence : Evidence
    answer : what was found
    refitted : all answers, it among them
    """
    if answer.mean_square > AT_NOISE:
        return []
    larger = [
        part
        for part in refitted
        if len(part.added) == len(answer.added) + 1
        and set(part.added) > set(answer.added)
        and evidence.refusal(part, refitted) == TOO_LITTLE
    ]
    own, *values = evidence.of([answer, *larger])
    most = min(own - DECISIVE_IN_PLACE, min(values, default=own) + DECISIVE)
    found = [pair for pair in zip(values, larger, strict=True) if pair[0] < most]
    return [part for _, part in sorted(found, key=lambda pair: pair[0])]


def ids_beside(answer: Answer, larger: Sequence[Answer]) -> tuple[str, ...]:
    """The effect that each of these has beside an answer."""
    return tuple(
        effect_id for part in larger for effect_id in part.added if effect_id not in answer.added
    )


def sentences(answer: Answer, larger: Sequence[Answer]) -> list[str]:
    """What is said of such effects, if there are any."""
    if not larger:
        return []
    titles = [effects.BY_ID[effect_id].title for effect_id in ids_beside(answer, larger)]
    left, before = larger[0].mean_square ** 0.5, answer.mean_square**0.5
    return [
        f"There, but too small to matter: {' or '.join(titles)}; with it {left:.3f} instead "
        f"of {before:.3f} times the noise would be left."
    ]
