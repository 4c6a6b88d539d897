"""On what the rest of the error depends, in words; where it lies says `comparison.places`."""

from collections.abc import Iterator, Mapping

from elastic_tendon.diagnosis.lack_of_fit import LackOfFit

WORDS = {
    "velocity_sign": "the direction of motion",
    "history": "how the machine moved before",
    "slack_state": "which tendon is slack",
}


def remaining_sentences(lack: Mapping[str, LackOfFit]) -> Iterator[str]:
    """For each signal that depends on the state of the machine, a sentence.

    Parameters
    ----------
    lack : by signal; what depends on nothing but the time has no sentence
    """
    for name, found in lack.items():
        if found.significant and found.variables != ("time",):
            of = " and ".join(WORDS.get(part, part.replace("_", " ")) for part in found.variables)
            yield (
                f"Of what is left of {name.replace('_', ' ')}, {100.0 * found.explains:.0f} % of "
                f"the squared error can be predicted from {of}, on stretches of time that were "
                "left out."
            )
