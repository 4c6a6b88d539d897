"""What a diagnosis says: data classes only."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from elastic_tendon.identify.compare import Comparison
from elastic_tendon.identify.determinability import Estimate, Findings
from elastic_tendon.identify.ladder import Rung, Step
from elastic_tendon.identify.locate import Location
from elastic_tendon.measurement.noise import NoiseFloor
from elastic_tendon.parameters import Model

Array = NDArray[np.float64]

Verdict = Literal["adequate", "wrong_parameter", "missing_effect", "unknown_effect"]
Kind = Literal["effect", "parameter"]


@dataclass(frozen=True)
class Candidate:
    """One answer that a round considered, and the evidence for it.

    `id` : of an effect, or the dotted path of a parameter.
    `score` : chi-squared of the score test at the refitted model, scaled to what the errors really
    tell; `probability` : weight of this answer among all of the round, from its BIC, 0 to 1.
    `expected` : parameters that the score test expects, dotted path -> value in its unit.
    `fitted` : estimates after its own refit, empty where the score made a refit needless.
    `p_value` : of a gain as large from nothing, errors that hang together counted by blocks; None
    where it was not tested. `gain` and `heldout_gain` : share (0 to 1) by which the sum of squared
    errors falls on fitted and on held-out data, negative where it grows; None where not judged.
    `equivalence_class` : ids that explain this data equally well, this one among them.
    `verdict` : in words why it was taken or not.
    """

    id: str
    kind: Kind
    score: float
    probability: float
    expected: Mapping[str, float]
    fitted: tuple[Estimate, ...]
    p_value: float | None
    gain: float | None
    heldout_gain: float | None
    equivalence_class: tuple[str, ...]
    verdict: str


@dataclass(frozen=True)
class Round:
    """Candidates of one round, the likeliest first; `chosen` is an id, or None where none was."""

    chosen: str | None
    candidates: tuple[Candidate, ...]
    reason: str


@dataclass(frozen=True)
class Remaining:
    """What is left of the error of one signal.

    `noise_ratio` : RMS over the noise floor. `share_of_initial` : squared error above the floor,
    of that of the model as given. `significant` : it depends on the state of the machine, by more
    than chance, with `p_value`; or it is far too large for noise.
    """

    noise_ratio: float
    share_of_initial: float
    significant: bool
    p_value: float


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
    """A motor motion and load to run on the machine, within what the actuator may do.

    `time` (n,) s, `motor_position` (n,) rad, `load_torque` (n,) N·m. `text` : what it is and which
    answers it separates; `power` : predicted probability that it decides between them.
    """

    text: str
    time: Array
    motor_position: Array
    load_torque: Array
    power: float


@dataclass(frozen=True)
class Diagnosis:
    """The whole answer.

    `given` and `model` are the model as given and as improved (its uncertainties are those of the
    estimates). `added` : ids in the order added. `steps` and `ladder` : as given, refitted, then
    each effect added or taken out again. `findings` : of the final fit; `parameters_changed` :
    dotted paths whose value moved significantly. `indistinguishable` : ids of answers that this
    data cannot tell apart. `comparison` and `location` : of the final model with the fitted data.
    `interrupted` : stopped by the user, holds what was found so far; `remaining` is empty where
    that was not judged. `words` : why no experiment decides, where none does.
    """

    verdict: Verdict
    words: tuple[str, ...]
    given: Model
    model: Model
    added: tuple[str, ...]
    parameters_changed: tuple[str, ...]
    findings: Findings
    steps: tuple[Step, ...]
    ladder: tuple[Rung, ...]
    rounds: tuple[Round, ...]
    remaining: Mapping[str, Remaining]
    noise: Mapping[str, NoiseFloor]
    comparison: Comparison
    location: Location
    indistinguishable: tuple[tuple[str, ...], ...]
    next_experiment: Experiment | None
    learned: LearnedTerm | None
    interrupted: bool
