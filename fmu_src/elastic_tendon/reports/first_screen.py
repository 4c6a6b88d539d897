"""What answers in ten seconds, the same wherever a diagnosis is shown: what is wrong with the model
and how surely, how far the error falls, and what it is worth doing next."""

from collections.abc import Sequence
from dataclasses import dataclass

from elastic_tendon import effects
from elastic_tendon.diagnosis.result import Diagnosis
from elastic_tendon.estimation.ladder import Step
from elastic_tendon.reports.diagnosis_tables import called, percent
from elastic_tendon.reports.tables import fall_sentences

UNFINISHED = "let the search come to its end; this is the best so far."


@dataclass(frozen=True)
class FirstScreen:
    """The verdict in a sentence, one for the error of each signal, and what to do next."""

    verdict: str
    errors: tuple[str, ...]
    advice: str

    @property
    def sentences(self) -> tuple[str, ...]:
        """All of it, as it is read."""
        return (self.verdict, *self.errors, f"Next: {self.advice}")


def first_screen(
    verdict: str, steps: Sequence[Step], advice: str, *, static: bool = False
) -> FirstScreen:
    """The first screen of whatever led from a model to another.

    Parameters
    ----------
    verdict : what is wrong with the model, in a sentence
    steps : from the model as given to the last; none where its error is not known yet
    advice : what is worth doing next
    static : the errors are those of static curves
    """
    errors = fall_sentences(steps[0], steps[-1], static=static) if steps else ()
    return FirstScreen(verdict, tuple(errors), advice)


def of_diagnosis(diagnosis: Diagnosis) -> FirstScreen:
    """The first screen of a diagnosis."""
    static = all(file.measurement.static for file in diagnosis.comparison.files)
    return first_screen(
        diagnosis.sentence, diagnosis.ladder, _worth_doing(diagnosis), static=static
    )


def _worth_doing(diagnosis: Diagnosis) -> str:
    """What is worth doing next, as the end of a sentence that begins with "Next:"."""
    if not diagnosis.complete:
        return UNFINISHED
    if (proposed := diagnosis.next_experiment) is not None:
        return (
            f"run the proposed experiment of {proposed.time[-1]:.3g} s. With a chance of "
            f"{percent(proposed.power)} it decides between answers that these data leave open."
        )
    if diagnosis.learned is not None:
        return (
            "look at the function that was learned of what remains; it explains "
            f"{percent(diagnosis.learned.explains)} of that."
        )
    if diagnosis.verdict == "unexplained":
        return "look where the error lies, and record the machine in other motions too."
    if diagnosis.added:
        return f"make sure of {called(diagnosis.added[0])} on the machine. {_check(diagnosis)}"
    if diagnosis.verdict == "wrong_parameter":
        return "take the refitted model, and measure on the machine what is off by much."
    return "take the model as it is; nothing needs to be mended."


def _check(diagnosis: Diagnosis) -> str:
    """How to begin with that: the first sentence of what the catalogue advises."""
    first, dot, _ = effects.BY_ID[diagnosis.added[0]].confirm.partition(". ")
    return f"{first}." if dot else first
