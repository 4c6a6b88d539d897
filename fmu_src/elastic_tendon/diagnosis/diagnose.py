"""The loop: noise, base, screen, sets, refits, evidence, neighbours, verdict, experiment."""

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from signal import SIG_IGN, SIGINT, getsignal, signal
from threading import Event, current_thread, main_thread
from types import FrameType

import numpy as np
from threadpoolctl import threadpool_limits

from elastic_tendon import effects
from elastic_tendon.actuator.interfaces import AS_RECORDED
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.diagnosis.answer import Answer, refit
from elastic_tendon.diagnosis.conclude import Found, conclude, judge
from elastic_tendon.diagnosis.confirmation import confirm, leaves_far_more
from elastic_tendon.diagnosis.data import Data, data_of
from elastic_tendon.diagnosis.evidence import AT_NOISE
from elastic_tendon.diagnosis.options import Options
from elastic_tendon.diagnosis.result import Diagnosis, Round
from elastic_tendon.diagnosis.rounds import answers_alike, round_at
from elastic_tendon.diagnosis.search import Search
from elastic_tendon.diagnosis.sets import Set, model_with
from elastic_tendon.diagnosis.straight_inputs import STRAIGHT, with_straight_inputs
from elastic_tendon.diagnosis.windows import horizon_for, input_notes
from elastic_tendon.errors import MeasurementError
from elastic_tendon.estimation.fit import Effort
from elastic_tendon.estimation.ladder import REFIT
from elastic_tendon.measurement import Measurement, Recordings, listed
from elastic_tendon.misreadings.signs import sign_errors
from elastic_tendon.progress import Progress, silent

Ask = Callable[[Round], bool]

# of a fit that was stopped before it had begun
BEGUN = Effort(scouted=0, scouting=0, polished=0, evaluations=1, rounds=0, tolerance=1e-3)

# times the mean square, up to which a fit leaves no more than another that ended a little sooner
NO_MORE = 1.001


def diagnose(
    model: Model,
    measurements: Recordings,
    validate: Recordings = (),
    *,
    options: Options | None = None,
    progress: Progress = silent,
    ask: Ask | None = None,
) -> Diagnosis:
    """Find out whether a model is adequate, its parameters are wrong, or an effect is missing.

    The same call gives the same answer. An interrupt (Ctrl-C) keeps what was found.

    Parameters
    ----------
    model : Model as given; its uncertainties are the prior of every step
    measurements : fitted, one or several
    validate : held out, one or several: never fitted, takes part in every choice; gives its
        initial state on its first 0.1 s
    options : Options; None: the defaults
    progress : called with words and the share of the work at hand that is done
    ask : called after each step of the ladder; False stops there

    Returns
    -------
    Diagnosis

    Raises
    ------
    MeasurementError : a recording is both fitted and held out, a held-out one lacks a signal, or a
        position was not measured
    ModelError : options name effects that do not exist
    SimulationError : the model as given cannot be simulated
    BuildError : the compiler refuses the model as given
    """
    # matrices are tall and narrow: threads that wait for one another make their work far slower
    with threadpool_limits(1, user_api="blas"):
        recordings = listed(measurements), listed(validate)
        return _diagnosed(model, *recordings, options or Options(), progress, ask)


def _check_positions(measurement: Measurement) -> None:
    if lacking := measurement.unmeasured_positions:
        raise MeasurementError(
            f"{measurement.name}: diagnose reads what is missing from the motion of joint and "
            f"motor, and {' and '.join(lacking)} was not measured; name its column with --map "
            f"{lacking[0]}=COLUMN; compare and add work without it"
        )


def for_search(
    model: Model,
    measurements: Sequence[Measurement],
    validation: Sequence[Measurement],
    options: Options,
) -> tuple[list[Measurement], list[Measurement], Options]:
    """Recordings as of the model's interface, and options with the horizon that suits their noise.

    Raises
    ------
    MeasurementError : what drives the model was not measured, nothing that it computes, or a
        position
    """
    fitted, heldout = (
        [part.to_compare(model) for part in parts] for parts in (measurements, validation)
    )
    for part in (*fitted, *heldout):
        _check_positions(part)
    if options.horizon is None:
        options = replace(options, horizon=horizon_for(model, (*fitted, *heldout)))
    return fitted, heldout, options


def _diagnosed(
    model: Model,
    measurements: Sequence[Measurement],
    validation: Sequence[Measurement],
    options: Options,
    progress: Progress,
    ask: Ask | None,
) -> Diagnosis:
    begin = time.monotonic()
    options.check_ids()
    asked = options.horizon
    measurements, validation, options = for_search(model, measurements, validation, options)
    data = data_of(model, measurements, validation, options)
    looked_at = measurements if model.kind in AS_RECORDED else ()
    notes = [finding.sentence for finding in sign_errors(model, looked_at)]
    notes += input_notes(model, measurements, asked, options.horizon)
    recordings = (*measurements, *validation)
    notes += [f"{part.name}: {note}" for part in recordings for note in part.noise_notes]
    found = Found()
    complete = True
    interrupted = Event()

    def begun(data: Data) -> Search:
        search = Search.of(data, progress)
        search.progress = _heeding(search, progress, options.time_limit, begin, interrupted)
        return search

    def again(data: Data, answer: Answer, work: float) -> tuple[Data, Search]:
        """The search once more, from an answer and on other data; what it worked before counts."""
        search = begun(data)
        search.base()
        search.begin_at(answer)
        search.work = work
        for _ in search.climb():
            pass
        search.settle()
        return data, search

    search = begun(data)
    try:
        with _interrupts(interrupted):
            straight = _climbed(
                search, partial(with_straight_inputs, model, measurements, validation, options)
            )
            if straight is not None:
                notes.append(STRAIGHT)
                data = straight
                search = begun(data)
                _climbed(search)
            search.settle()
            nothing = not search.answer.added and search.answer.mean_square < AT_NOISE
            if nothing and options.horizon is None and data.everything is not None:
                data, search = again(data.everything, search.answer, search.work)
            if data.excerpts:
                found.confirmed = confirm(data, search, search.progress)
                whole = found.confirmed[search.answer.added]
                if options.horizon is None and (more := _not_shown(data, search, whole)):
                    wider, resumed = again(more, whole, search.work)
                    resumed.exchange_alike(whole.added, found.confirmed)
                    confirmed = confirm(wider, resumed, resumed.progress)
                    if confirmed[resumed.answer.added].mean_square < NO_MORE * whole.mean_square:
                        data, search, found.confirmed = wider, resumed, confirmed
            _tell(search, found, ask, refit=True)
            judge(data, search, found, options, search.progress)
    except KeyboardInterrupt:
        complete = False
    with _interrupts(None):
        if not complete:
            _begin_at_least(search)
            found.ladder, found.rounds = [], []
            _tell(search, found, None, refit=False)
        return conclude(data, search, found, options, progress, complete=complete, notes=notes)


def _climbed(search: Search, straight: Callable[..., Data | None] | None = None) -> Data | None:
    """Climb as far as a search goes, or until straight inputs do better: the data with these."""
    search.base()
    asked = None
    for _ in search.climb():
        answer = search.answer
        if straight is None or answer is asked or answer.mean_square < AT_NOISE:
            continue
        asked = answer
        if (data := straight(search, final=False)) is not None:
            return data
    return None if straight is None else straight(search, final=True)


def _not_shown(data: Data, search: Search, whole: Answer) -> Data | None:
    """What a search is to go on with, from its answer as fitted to the whole recordings, or None.

    Where that leaves far more than on excerpts, these lack what the machine does elsewhere. Where
    far less, they begin in the midst of a motion that springs or friction remember.
    """
    if leaves_far_more(whole, search.answer):
        return data.with_worst(whole.errors)
    return data.everything if leaves_far_more(search.answer, whole) else None


@contextmanager
def _interrupts(event: Event | None) -> Iterator[None]:
    """Set the event at Ctrl-C, which libraries may swallow: CasADi has handlers that catch
    everything. None ignores Ctrl-C: who presses it once more does not lose what was found."""
    usual = getsignal(SIGINT)
    if current_thread() is not main_thread() or not callable(usual):
        yield
        return

    def heed(number: int, frame: FrameType | None) -> None:
        if event is not None:
            event.set()
        usual(number, frame)

    signal(SIGINT, SIG_IGN if event is None else heed)
    try:
        yield
    finally:
        signal(SIGINT, usual)


def _heeding(
    search: Search, progress: Progress, limit: float | None, begin: float, interrupted: Event
) -> Progress:
    """Progress that tells the best so far, and ends the work where somebody interrupted it or its
    time since `begin` is up."""
    end = np.inf if limit is None else begin + limit
    told: dict[tuple[int, ...], str] = {}

    def heeding(text: str, share: float) -> None:
        answers = tuple(map(id, search.answers.values()))
        if answers not in told:
            told.clear()
            told[answers] = _best(search) if answers else ""
        progress(text + told[answers], share)
        if interrupted.is_set() or time.monotonic() > end:
            raise KeyboardInterrupt

    return heeding


def _best(search: Search) -> str:
    """The best so far, as "; best so far: Gravity load, 1.02 times the noise"."""
    answer = search.answer
    titles = " + ".join(effects.BY_ID[effect_id].title for effect_id in answer.added)
    ratio = f"{answer.mean_square**0.5:.3g} times the noise"
    return f"; best so far: {titles or 'no effect'}, {ratio}"


def _begin_at_least(search: Search) -> None:
    """Where not even the parameters were refitted: what they begin at, which is an answer too."""
    if () in search.answers:
        return
    data, known = search.data, search.estimates.get(())
    starts = [] if known is None else [model_with(data.given, (), known.values)]
    search.answers[()] = refit(data.given, (), data.fitted, starts, BEGUN)


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
