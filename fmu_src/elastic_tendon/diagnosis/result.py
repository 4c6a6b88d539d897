"""What a diagnosis says: data classes only."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import PlainValidator

from elastic_tendon.actuator.interfaces import InterfaceKind
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.comparison.comparison import Comparison
from elastic_tendon.comparison.locate import Location
from elastic_tendon.estimation.determinability import Estimate, Findings
from elastic_tendon.estimation.ladder import FittedStep, Step, steps_text
from elastic_tendon.measurement.noise import NoiseFloor
from elastic_tendon.result import Result

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

# from JSON, as the app keeps results, lists become arrays
Array = Annotated[NDArray[np.float64], PlainValidator(lambda given: np.asarray(given, float))]

Verdict = Literal["adequate", "wrong_parameter", "missing_effect", "unexplained"]
Role = Literal["fitted", "validation"]


@dataclass(frozen=True)
class Candidate:
    """A set of effects that a round considered, and the evidence for it.

    `ids` : the effects that would come in, one or several. `evidence` : see
    `diagnosis.evidence`, less that of the model before the round (negative: better); of a set
    without a refit what the screen expects. `probability` : weight among all of the round, 0 to 1.
    `expected_parameters` : as the screen expects them, dotted path -> value in its unit.
    `fitted` : whether the set was refitted; `fitted_parameters` then. `gain` and
    `heldout_gain` : share (0 to 1) by which the sum of squared errors falls on fitted and on
    held-out data, negative where it grows; None where not judged. `equivalence_class` : sets that
    explain these data equally well, this one among them. `reason` : in words why it was taken or
    not.
    """

    ids: tuple[str, ...]
    probability: float
    expected_parameters: Mapping[str, float]
    equivalence_class: tuple[tuple[str, ...], ...]
    evidence: float | None = None
    fitted: bool = False
    fitted_parameters: tuple[Estimate, ...] = ()
    gain: float | None = None
    heldout_gain: float | None = None
    reason: str = ""


@dataclass(frozen=True)
class Round:
    """Candidates of one round, the likeliest first; `chosen` are the ids of what was taken, none
    where nothing was."""

    chosen: tuple[str, ...]
    candidates: tuple[Candidate, ...]
    reason: str


@dataclass(frozen=True)
class Neighbour:
    """A set that differs from the answer by one change, and how it does.

    `change` : "+id", "-id" or "id -> id". `evidence` : less that of the answer, positive where it
    is worse; `refitted` false: as the screen expects it, None where that cannot say. `probability`
    beside the answer, 0 to 1. `rmse` : signal -> its unit; empty where not refitted. `reason` :
    why it could not be refitted, or was refused; "" where neither.
    """

    change: str
    evidence: float | None
    probability: float
    rmse: Mapping[str, float]
    refitted: bool
    reason: str = ""


@dataclass(frozen=True)
class WouldShow:
    """The size from which the recordings would have revealed an effect that was not found (95 %).

    `id` of the effect; `path` of the parameter that measures it, `unit`; `smallest` size, None
    where no size that is plausible would show.
    """

    id: str
    path: str
    unit: str
    smallest: float | None


@dataclass(frozen=True)
class RecordingSummary:
    """How the answer does on one recording.

    `rmse` : signal -> its unit. `explained_by` : kind of constant ("offset", "sign", "load",
    "gain", "delay", "stiffness") that explains most of its error, None where none does, and the
    `sentence` that says so. `contradicts` : names of recordings that call for other parameters.
    """

    file: str
    role: Role
    rmse: Mapping[str, float]
    explained_by: str | None = None
    sentence: str = ""
    contradicts: tuple[str, ...] = ()


@dataclass(frozen=True)
class Remaining:
    """What is left of the error of one signal.

    `noise_ratio` : RMS over the noise floor. `share_of_initial` : squared error above the floor,
    of that of the model as given. `significant` : it depends on the state of the machine, by more
    than chance, with `p_value`; or it is far too large for noise; or that was not judged, `p_value`
    None, and it is above 1.5 times the noise. `matters` : it is larger than what anybody wants to
    hear of: 1.5 times the noise, and the share of the error as given that the user asked for.
    """

    noise_ratio: float
    share_of_initial: float
    significant: bool
    matters: bool
    p_value: float | None


@dataclass(frozen=True)
class LearnedTerm:
    """A smooth function in a slot, learned from what remains, as an effect of its own.

    `source` is the text of its effect file, `values` its parameters by name; `explains` the share
    of the remaining squared error that it explains on segments it was not fitted to.
    """

    id: str
    slot: str
    variables: tuple[str, ...]
    source: str
    values: Mapping[str, float]
    explains: float


@dataclass(frozen=True)
class Experiment:
    """A motion and load to run on the machine, within what the actuator may do.

    `time` (n,) s, `motor_position` (n,) rad, `load_torque` (n,) N·m. `kind` : interface of the
    model; `driving` : what else its machine does, by name, (n,) rad or N·m: the joint's position
    where that is given or there are no springs, the motor torque where that drives; a torque that
    drives is that under which the answer taken first follows the motion. `text` : what it is and
    which answers it separates; `power` : predicted probability that it decides between them.
    `signal` : the one that tells most; `predictions` : of it, by the answers as they are fitted
    now, (n,) in its unit, the answer taken first.
    """

    text: str
    time: Array
    motor_position: Array
    load_torque: Array
    power: float
    signal: str
    predictions: Mapping[str, Array]
    kind: InterfaceKind = InterfaceKind.POSITION
    driving: Mapping[str, Array] = field(default_factory=dict)

    @property
    def columns(self) -> dict[str, Array]:
        """What is run, by name, (n,) SI each: motor position, load and `driving`, as far as the
        interface has them."""
        motor = {"motor_position": self.motor_position} if self.kind.has_springs else {}
        load = {"load_torque": self.load_torque} if self.kind.has_link else {}
        return motor | load | dict(self.driving)


@dataclass(frozen=True, repr=False)
class Diagnosis(Result):
    """The whole answer.

    `verdict` and `sentence`, the same in words. `given` and `model` are the model as given and as
    improved (its uncertainties are those of the estimates). `added` : ids in the order added;
    `certainty` : probability that each, or what cannot be told from it, is there, 0 to 1.
    `steps` and `ladder` : as given, refitted, then each effect added. `findings` : of the final
    fit; `parameters_changed` : dotted paths whose value moved significantly and matters; `notes` :
    what is worth knowing and no verdict, one sentence each. `rounds` : what was considered;
    `neighbours` of the answer, none of which does better. `would_show`, `recordings`.
    `indistinguishable` : sets of effects that these data do not distinguish, "+" between the ids
    of a set. `comparison` and `location` : of the final model with the fitted data. `complete`
    false: stopped by the user or at the time limit, the best answer so far. `no_experiment` : why
    no experiment decides, "" where one does or none is needed.
    """

    verdict: Verdict
    sentence: str
    notes: tuple[str, ...]
    given: Model
    model: Model
    added: tuple[str, ...]
    certainty: Mapping[str, float]
    parameters_changed: tuple[str, ...]
    findings: Findings
    steps: tuple[FittedStep, ...]
    ladder: tuple[Step, ...]
    rounds: tuple[Round, ...]
    neighbours: tuple[Neighbour, ...]
    would_show: tuple[WouldShow, ...]
    recordings: tuple[RecordingSummary, ...]
    remaining: Mapping[str, Remaining]
    noise: Mapping[str, NoiseFloor]
    comparison: Comparison
    location: Location
    indistinguishable: tuple[tuple[str, ...], ...]
    next_experiment: Experiment | None
    no_experiment: str
    learned: LearnedTerm | None
    complete: bool

    def summary(self) -> str:
        """Verdict, its sentence, and the error after each step."""
        added = ", ".join(self.added) or "nothing"
        steps = steps_text(self.ladder, self.model.motion)
        return f"{self.verdict}: {self.sentence}\nadded: {added}\n{steps}"

    def to_dataframe(self) -> "pd.DataFrame":
        """Every parameter as given and as fitted, with its 95 % interval, a row each, SI."""
        return self.findings.to_dataframe()

    def plot(self) -> "Figure":
        """Draw the error after each step, and measured beside simulated."""
        from elastic_tendon.reports.comparison_figures import story
        from elastic_tendon.reports.worded import worded_figure

        return worded_figure(story(self.steps, self.ladder), self.given.motion)

    def to_dict(self) -> dict[str, Any]:
        """As of the contract ``elastic-tendon/diagnosis/2``."""
        from elastic_tendon.diagnosis.diagnosis_json import diagnosis_json

        return diagnosis_json(self)
