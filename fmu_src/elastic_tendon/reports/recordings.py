"""What each recording says of the answer: which one does not fit in with it, and why."""

from collections.abc import Iterator, Sequence

from elastic_tendon.diagnosis.result import RecordingSummary


def recording_sentences(recordings: Sequence[RecordingSummary]) -> Iterator[str]:
    """Recordings whose error one constant explains, and those that contradict one another.

    Parameters
    ----------
    recordings : RecordingSummary of each
    """
    for summary in recordings:
        if summary.sentence:
            yield f"{summary.sentence.rstrip('.')}."
    yield from _contradictions(recordings)


def _contradictions(recordings: Sequence[RecordingSummary]) -> Iterator[str]:
    named: set[frozenset[str]] = set()
    for summary in recordings:
        files = [
            file for file in summary.contradicts if frozenset((summary.file, file)) not in named
        ]
        named |= {frozenset((summary.file, file)) for file in files}
        if files:
            yield (
                f"{summary.file} contradicts {' and '.join(files)}: no parameters of the model "
                "suit both, so see whether the machine, its zero or its load was changed meanwhile."
            )
