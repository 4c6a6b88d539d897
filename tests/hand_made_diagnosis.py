"""A diagnosis made by hand from a real fit, so that what shows it is tested without the loop."""

from dataclasses import replace
from functools import cache

import numpy as np

from elastic_tendon import demo
from elastic_tendon.diagnosis.result import (
    Candidate,
    Diagnosis,
    Experiment,
    LearnedTerm,
    Remaining,
    Round,
)
from elastic_tendon.identify.add import Addition, add
from elastic_tendon.identify.compare import Comparison
from elastic_tendon.identify.locate import Location, locate
from elastic_tendon.measurement import read_measurement
from elastic_tendon.parameters import load_model

COULOMB = "coulomb_friction"
TORQUE = f"effects.{COULOMB}.torque"

LEARNED_SOURCE = '''"""A drag that was learned."""

from elastic_tendon.effects.base import Contribution, Effect, Parameter, Slot


def equations(at, p, _state, _mode):
    """Torque against the motion."""
    return Contribution(-p.strength * at.velocity * at.velocity * at.velocity)


EFFECT = Effect(
    id="learned_torque",
    title="Learned torque",
    slot=Slot.JOINT_TORQUE,
    physics="Learned from what remained of the error.",
    in_data="As it was learned.",
    parameters=(Parameter("strength", "1", "factor", null=0, lower=0, upper=10, typical=1),),
    equations=equations,
    law="torque = -strength velocity^3",
    reference="learned from a recording",
)
'''


@cache
def fitted() -> tuple[Addition, Location]:
    """Coulomb friction added to the bundled model, and where that still fails."""
    addition = add(
        load_model(demo.DATA / "demo_model.toml"),
        COULOMB,
        *([read_measurement(str(demo.DATA / f"demo_{one}.csv"))] for one in ("fit", "validate")),
    )
    return addition, locate(addition.steps[-1].comparison)


def _candidate(candidate_id: str, **changed: object) -> Candidate:
    plain = Candidate(
        id=candidate_id,
        kind="effect",
        score=300.0,
        probability=0.0,
        expected={},
        fitted=(),
        p_value=None,
        gain=None,
        heldout_gain=None,
        equivalence_class=(candidate_id,),
        verdict="explains less",
    )
    return replace(plain, **changed)


def _first_round() -> Round:
    torque = [one for one in fitted()[0].findings.estimates if one.path == TORQUE]
    alike = (COULOMB, "lugre_friction")
    weak = ("gravity_load", "quadratic_drag", "spring_hysteresis", "gear_backlash", "joint_stop")
    return Round(
        chosen=COULOMB,
        candidates=(
            _candidate(
                COULOMB,
                score=12345.6,
                probability=0.93,
                expected={TORQUE: 0.33},
                fitted=tuple(torque),
                p_value=1e-9,
                gain=0.984,
                heldout_gain=0.979,
                equivalence_class=alike,
                verdict="taken: the simplest of its class",
            ),
            _candidate(
                "lugre_friction",
                score=12348.0,
                probability=0.07,
                gain=0.984,
                heldout_gain=0.979,
                equivalence_class=alike,
                verdict="explains the same with more numbers",
            ),
            _candidate("link.inertia", kind="parameter", expected={"link.inertia": 0.0311}),
            *(_candidate(one, score=200.0 - 10.0 * n) for n, one in enumerate(weak)),
        ),
        reason="Coulomb friction explains 98 % of the squared error",
    )


def friction_found(**changed: object) -> Diagnosis:
    """Coulomb friction is missing, and LuGre friction would do as well."""
    addition, location = fitted()
    comparison = addition.steps[-1].comparison
    diagnosis = Diagnosis(
        verdict="missing_effect",
        words=("No motion tells the two apart.",),
        given=addition.steps[0].comparison.model,
        model=addition.model,
        added=(COULOMB,),
        parameters_changed=("link.inertia",),
        findings=addition.findings,
        steps=addition.steps,
        ladder=addition.ladder,
        rounds=(
            _first_round(),
            Round(chosen=None, candidates=(), reason="nothing is left but noise"),
        ),
        remaining={"joint_position": Remaining(1.01, 0.0004, False, 0.4)},
        noise=comparison.files[0].measurement.noise,
        comparison=comparison,
        location=location,
        indistinguishable=((COULOMB, "lugre_friction"),),
        next_experiment=next_experiment(),
        learned=None,
        interrupted=False,
    )
    return replace(diagnosis, **changed)


def next_experiment() -> Experiment:
    """Small reversals, which tell bristles from dry friction."""
    time = np.arange(2001) / 500.0
    window = np.sin(np.pi * time / time[-1]) ** 2
    return Experiment(
        text="Small reversals of the motor for 4 s separate Coulomb friction from LuGre friction.",
        time=time,
        motor_position=0.02 * window * np.sin(12.0 * time),
        load_torque=np.zeros(len(time)),
        power=0.91,
    )


def something_unknown() -> Diagnosis:
    """Nothing named explains the error; a term was learned. The fit is that of the parameters."""
    addition, _ = fitted()
    step = addition.steps[1]
    location = locate(Comparison(step.comparison.model, step.comparison.files))
    return friction_found(
        verdict="unknown_effect",
        model=step.comparison.model,
        added=(),
        findings=addition.fits[0].findings,
        steps=addition.steps[:2],
        ladder=addition.ladder[:2],
        remaining={"joint_position": Remaining(9.1, 0.7, True, 1e-6)},
        comparison=step.comparison,
        location=location,
        indistinguishable=(),
        next_experiment=None,
        learned=LearnedTerm(
            id="learned_torque",
            slot="JOINT_TORQUE",
            variables=("joint_velocity",),
            source=LEARNED_SOURCE,
            values={"strength": 0.02},
            explains=0.83,
        ),
    )


def nothing_missing() -> Diagnosis:
    """The final model of `friction_found`, given as it is."""
    addition, _ = fitted()
    last = replace(addition.steps[-1], title="as given", added=None)
    rung = replace(addition.ladder[-1], title="as given", added=None, p_value=None)
    return friction_found(
        verdict="adequate",
        given=addition.model,
        added=(),
        parameters_changed=(),
        steps=(last,),
        ladder=(rung,),
        rounds=(Round(chosen=None, candidates=(), reason="nothing is left but noise"),),
        indistinguishable=(),
        next_experiment=None,
    )
