"""The loop: noise, base, screen, sets, refits, evidence, neighbours, verdict, experiment."""

import time
from collections.abc import Callable, Sequence

from elastic_tendon import effects
from elastic_tendon.diagnosis.conclude import Found, conclude, judge
from elastic_tendon.diagnosis.data import data_of
from elastic_tendon.diagnosis.options import Options
from elastic_tendon.diagnosis.refits import Progress
from elastic_tendon.diagnosis.result import Diagnosis, Round
from elastic_tendon.diagnosis.rounds import answers_alike, round_at
from elastic_tendon.diagnosis.search import Search
from elastic_tendon.diagnosis.sets import Set
from elastic_tendon.identify.ladder import REFIT
from elastic_tendon.identify.signs import sign_errors
from elastic_tendon.measurement import Measurement
from elastic_tendon.parameters import Model

Ask = Callable[[Round], bool]


def _silent(_text: str, _share: float) -> None:
    """Progress that nobody asked for."""


def diagnose(
    model: Model,
    measurements: Sequence[Measurement],
    validation: Sequence[Measurement] = (),
    *,
    options: Options | None = None,
    report: Progress = _silent,
    ask: Ask | None = None,
) -> Diagnosis:
    """Find out whether a model is adequate, its parameters are wrong, or an effect is missing.

    The same call gives the same answer. An interrupt (Ctrl-C) keeps what was found.

    Parameters
    ----------
    model : Model as given; its uncertainties are the prior of every step
    measurements : fitted
    validation : never fitted, takes part in every choice; gives its initial state on its first
        0.1 s
    options : Options; None: the defaults
    report : called with words and the share of the work at hand that is done
    ask : called after each step of the ladder; False stops there

    Returns
    -------
    Diagnosis

    Raises
    ------
    MeasurementError : a recording is both fitted and held out, or a held-out one lacks a signal
    ModelError : options name effects that do not exist
    SimulationError : the model as given cannot be simulated
    BuildError : the compiler refuses the model as given
    """
    begin = time.monotonic()
    options = options or Options()
    options.check_ids()
    data = data_of(model, measurements, validation, options)
    notes = [finding.sentence for finding in sign_errors(model, measurements)]
    notes += [note for part in measurements for note in part.noise_notes]
    search = Search.of(data, report)
    found = Found()
    search.base()
    search.progress = progress = _limited(report, options.time_limit, begin)
    complete = True
    try:
        search.run()
        _tell(search, found, ask, refit=True)
        judge(data, search, found, progress)
    except KeyboardInterrupt:
        complete = False
        found.ladder, found.rounds = [], []
        _tell(search, found, None, refit=False)
    return conclude(data, search, found, options, report, complete=complete, notes=notes)


def _limited(report: Progress, limit: float | None, begin: float) -> Progress:
    """Progress that ends the work when its time since the beginning is up."""
    if limit is None:
        return report
    end = begin + limit

    def progress(text: str, share: float) -> None:
        report(text, share)
        if time.monotonic() > end:
            raise KeyboardInterrupt

    return progress


def _tell(search: Search, found: Found, ask: Ask | None, *, refit: bool) -> None:
    """The ladder to the answer, one effect a step, and what was considered at each."""
    before: Set = ()
    found.ladder.append((REFIT, None, search.answers[()]))
    for added in search.ladder(refit=refit):
        came = tuple(effect_id for effect_id in added if effect_id not in before)
        entry = round_at(search, before, came)
        found.rounds.append(entry)
        title = " ".join(f"+ {effects.BY_ID[effect_id].title}" for effect_id in came)
        found.ladder.append((title, came[0], search.answers[added]))
        if ask is not None and not ask(entry):
            return
        before = added
    found.rounds.append(round_at(search, before, ()))
    found.alike = answers_alike(search, search.answers[before])
