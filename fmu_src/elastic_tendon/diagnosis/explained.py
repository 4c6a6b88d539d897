"""What an effect of the final model explains: its torque beside the one that is missing without.

The effect is taken out of the model and nothing else is changed. The torque under which that model
moves as *measured* is what the machine shows of the effect; the torque under which it moves as the
model *with* the effect is what the model makes of it. Both are found in the same way, see
`missing_torque`, so they are comparable for any effect, of springs and sensors too.
"""

from dataclasses import dataclass, replace

import numpy as np

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.variables import FORCE_READINGS
from elastic_tendon.comparison.compare import compare
from elastic_tendon.comparison.comparison import FileComparison
from elastic_tendon.comparison.missing_torque import MissingTorque, TorqueCurve, missing_torque
from elastic_tendon.comparison.residuals import Array
from elastic_tendon.diagnosis.learned import learned_effect
from elastic_tendon.diagnosis.result import Diagnosis
from elastic_tendon.effects import BY_ID

# they order everything a little: a motion is smooth, every torque accelerates the joint, and the
# load deflects it
TELL_NOTHING = ("time", "joint_acceleration", "load_torque")
PARTS = 40  # over which the mean of a torque is taken
LEAST_IN_PART = 5  # samples


@dataclass(frozen=True)
class Explained:
    """One effect in one recording.

    `by` is the variable that orders the effect's torque best, `unit` its unit. `measured` and
    `modelled` are torques that the model lacks without the effect, N·m, beside `variable` and
    `modelled_variable`; `remaining` with `remaining_variable` is what it lacks with the effect.
    """

    by: str
    unit: str
    variable: Array
    measured: MissingTorque
    modelled_variable: Array
    modelled: MissingTorque
    remaining_variable: Array
    remaining: MissingTorque


def is_told(diagnosis: Diagnosis) -> bool:
    """Whether the torque that an effect explains can be told: not of a joint that is given, whose
    motion no effect changes."""
    return diagnosis.model.kind.has_link


def told_effects(diagnosis: Diagnosis) -> tuple[str, ...]:
    """Ids of those added whose torque can be told: not of the sensor of a torque or a force, which
    changes no motion."""
    added = diagnosis.added if is_told(diagnosis) else ()
    return tuple(name for name in added if BY_ID[name].slot not in FORCE_READINGS)


def explained_by_effect(diagnosis: Diagnosis, effect_id: str) -> Explained:
    """What an effect that was added explains of the first fitted recording.

    Parameters
    ----------
    diagnosis : Diagnosis
    effect_id : one of those added
    """
    without = diagnosis.model.without([effect_id])
    return explained(without, diagnosis.comparison.files[0], diagnosis.model)


def explained_by_learned(diagnosis: Diagnosis) -> Explained:
    """What the learned term would explain of the first fitted recording.

    Parameters
    ----------
    diagnosis : Diagnosis with a learned term
    """
    model = with_learned(diagnosis)
    (compared,) = compare(model, [diagnosis.comparison.files[0].measurement]).files
    return explained(diagnosis.model, compared, model)


def with_learned(diagnosis: Diagnosis) -> Model:
    """The improved model with the learned term, which there has to be."""
    assert diagnosis.learned is not None
    effect = learned_effect(diagnosis.learned)
    return diagnosis.model.with_effect(effect.id, diagnosis.learned.values)


def explained(without: Model, compared: FileComparison, model: Model) -> Explained:
    """What the difference between two models explains of a recording.

    Parameters
    ----------
    without : Model without the effect
    compared : the recording beside `model`
    model : Model with the effect

    Returns
    -------
    Explained
    """
    measurement = compared.measurement
    motion = replace(measurement, signals=_as_noisy(compared))
    (before,), (own,) = (compare(without, recording).files for recording in (measurement, motion))
    measured, variables, _ = missing_torque(without, before)
    modelled, modelled_variables, _ = missing_torque(without, own)
    remaining, remaining_variables, _ = missing_torque(model, compared)
    best = _best_ordered(modelled)
    return Explained(
        by=best.by,
        unit=best.unit,
        variable=variables[best.by],
        measured=measured,
        modelled_variable=modelled_variables[best.by],
        modelled=modelled,
        remaining_variable=remaining_variables[best.by],
        remaining=remaining,
    )


def _as_noisy(compared: FileComparison) -> dict[str, Array]:
    """The simulated signals with noise as large as measured, so that they are smoothed alike."""
    rng = np.random.default_rng(0)
    trajectory = compared.trajectory
    return {
        name: trajectory[trajectory.measured(name)]
        + error.noise.sigma * rng.standard_normal(error.count)
        for name, error in compared.signals.items()
    }


def _best_ordered(torque: MissingTorque) -> TorqueCurve:
    """The curve that explains most of the torque's square."""

    def explains(curve: TorqueCurve) -> float:
        return float(curve.count @ curve.mean**2) / float(np.sum(curve.count))

    telling = [curve for curve in torque.curves if curve.by not in TELL_NOTHING]
    return max(telling or torque.curves, key=explains)


def mean_curve(variable: Array, values: Array) -> tuple[Array, Array]:
    """Mean of values over equal parts of a variable's range; parts with few samples are out.

    Parameters
    ----------
    variable, values : (n,) arrays, any unit

    Returns
    -------
    two (m,) arrays, at most `PARTS` long: means of the variable and of the values
    """
    edges = np.linspace(np.min(variable), np.max(variable), PARTS + 1)
    part = np.searchsorted(edges[1:-1], variable, side="right")
    count = np.bincount(part, minlength=PARTS)
    kept = count >= LEAST_IN_PART
    sums = [np.bincount(part, weights, PARTS)[kept] for weights in (variable, values)]
    return sums[0] / count[kept], sums[1] / count[kept]
