"""A diagnosis made by hand from a real fit, so that what shows it is tested without the loop."""

from dataclasses import replace
from functools import cache

import numpy as np

from elastic_tendon import demo
from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.comparison.comparison import Comparison
from elastic_tendon.comparison.locate import Location, locate
from elastic_tendon.diagnosis.result import (
    Candidate,
    Diagnosis,
    Experiment,
    LearnedTerm,
    Neighbour,
    RecordingSummary,
    Remaining,
    Round,
    WouldShow,
)
from elastic_tendon.estimation.add import Addition, add
from elastic_tendon.measurement import read_measurement

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


def _candidate(*ids: str, **changed: object) -> Candidate:
    plain = Candidate(
        ids=ids,
        probability=0.0,
        evidence=None,
        expected_parameters={},
        fitted=False,
        fitted_parameters=(),
        gain=None,
        heldout_gain=None,
        equivalence_class=(ids,),
        reason="the screen expects too little of it for a refit",
    )
    return replace(plain, **changed)


def _first_round() -> Round:
    torque = [estimate for estimate in fitted()[0].findings.estimates if estimate.path == TORQUE]
    alike = ((COULOMB,), ("lugre_friction",))
    weak = ("gravity_load", "quadratic_drag", "spring_hysteresis", "gear_backlash", "joint_stop")
    return Round(
        chosen=(COULOMB,),
        candidates=(
            _candidate(
                COULOMB,
                probability=0.93,
                evidence=-12345.6,
                expected_parameters={TORQUE: 0.33},
                fitted=True,
                fitted_parameters=tuple(torque),
                gain=0.984,
                heldout_gain=0.979,
                equivalence_class=alike,
                reason="taken: the simplest of its class",
            ),
            _candidate(
                "lugre_friction",
                probability=0.07,
                evidence=-12340.4,
                fitted=True,
                gain=0.984,
                heldout_gain=0.979,
                equivalence_class=alike,
                reason="explains the same with more numbers",
            ),
            _candidate(
                "quadratic_drag",
                "spring_mass",
                evidence=-160.0,
                expected_parameters={"effects.quadratic_drag.coefficient": 0.0311},
            ),
            *(_candidate(weak_id, evidence=-150.0 + 10.0 * n) for n, weak_id in enumerate(weak)),
        ),
        reason="Coulomb friction explains 98 % of the squared error",
    )


NEIGHBOURS = (
    Neighbour(
        change=f"{COULOMB} -> lugre_friction",
        evidence=5.2,
        probability=0.07,
        rmse={"joint_position": 0.00023},
        refitted=True,
    ),
    Neighbour(
        change="+gravity_load",
        evidence=8.1,
        probability=0.02,
        rmse={"joint_position": 0.00023},
        refitted=True,
        reason="Gravity load may be chance, p = 0.4",
    ),
    Neighbour(change="+gear_backlash", evidence=9.9, probability=0.007, rmse={}, refitted=False),
    Neighbour(
        change="+spring_mass",
        evidence=None,
        probability=0.0,
        rmse={},
        refitted=False,
        reason="it cannot be simulated",
    ),
    Neighbour(
        change=f"-{COULOMB}",
        evidence=12345.6,
        probability=0.0,
        rmse={"joint_position": 0.0021},
        refitted=True,
    ),
    Neighbour(change="+joint_stop", evidence=30.0, probability=0.0, rmse={}, refitted=False),
)
WOULD_SHOW = (
    WouldShow("gravity_load", "effects.gravity_load.torque", "N.m", 0.0123),
    WouldShow("tendon_compliance", "effects.tendon_compliance.compliance", "m/N", 2.5e-6),
    WouldShow("spring_mass", "effects.spring_mass.mass", "kg", None),
)
RECORDINGS = (
    RecordingSummary("demo_fit.csv", "fitted", {"joint_position": 0.00023}),
    RecordingSummary(
        file="demo_validate.csv",
        role="validation",
        rmse={"joint_position": 0.00022},
        explained_by="offset",
        sentence=(
            "demo_validate.csv: the zero of the joint's encoder is 3 mrad off; the model then errs "
            "by 0.2 mrad RMS instead of 0.22"
        ),
        contradicts=("demo_fit.csv",),
    ),
)


def friction_found(**changed: object) -> Diagnosis:
    """Coulomb friction is missing, and LuGre friction would do as well."""
    addition, location = fitted()
    comparison = addition.steps[-1].comparison
    diagnosis = Diagnosis(
        verdict="missing_effect",
        sentence=(
            "Coulomb friction is surely missing: the error falls from 162 to 0.99 times the noise."
        ),
        notes=("demo_fit.csv: its noise is known badly.",),
        given=addition.steps[0].comparison.model,
        model=addition.model,
        added=(COULOMB,),
        certainty={COULOMB: 0.995},
        parameters_changed=("link.inertia",),
        findings=addition.findings,
        steps=addition.steps,
        ladder=addition.ladder,
        rounds=(
            _first_round(),
            Round(chosen=(), candidates=(), reason="nothing is left but noise"),
        ),
        neighbours=NEIGHBOURS,
        would_show=WOULD_SHOW,
        recordings=RECORDINGS,
        remaining={"joint_position": Remaining(1.01, 0.0004, False, False, 0.4)},
        noise=comparison.files[0].measurement.noise,
        comparison=comparison,
        location=location,
        indistinguishable=((COULOMB, "lugre_friction"),),
        next_experiment=next_experiment(),
        no_experiment="No motion tells the two apart.",
        learned=None,
        complete=True,
    )
    return replace(diagnosis, **changed)


def next_experiment() -> Experiment:
    """Small reversals, which tell bristles from dry friction."""
    time = np.arange(2001) / 500.0
    motor = 0.02 * np.sin(np.pi * time / time[-1]) ** 2 * np.sin(12.0 * time)
    return Experiment(
        text="Small reversals of the motor for 4 s separate Coulomb friction from LuGre friction.",
        time=time,
        motor_position=motor,
        load_torque=np.zeros(len(time)),
        power=0.91,
        signal="joint_position",
        predictions={COULOMB: 0.9 * motor, "lugre_friction": 0.92 * motor},
    )


def something_unknown() -> Diagnosis:
    """Nothing named explains the error; a term was learned. The fit is that of the parameters."""
    addition, _ = fitted()
    step = addition.steps[1]
    location = locate(Comparison(step.comparison.model, step.comparison.files))
    return friction_found(
        verdict="unexplained",
        sentence=(
            "Something is missing that no effect of the catalogue explains: 9.10 times the noise "
            "is left."
        ),
        model=step.comparison.model,
        added=(),
        certainty={},
        findings=addition.fits[0].findings,
        steps=addition.steps[:2],
        ladder=addition.ladder[:2],
        remaining={"joint_position": Remaining(9.1, 0.7, True, True, 1e-6)},
        comparison=step.comparison,
        location=location,
        indistinguishable=(),
        next_experiment=None,
        no_experiment="",
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
    step = replace(addition.ladder[-1], title="as given", added=None)
    return friction_found(
        verdict="adequate",
        sentence="demo_actuator explains these data: what is left is 0.99 times the noise.",
        given=addition.model,
        added=(),
        certainty={},
        parameters_changed=(),
        steps=(last,),
        ladder=(step,),
        rounds=(Round(chosen=(), candidates=(), reason="nothing is left but noise"),),
        indistinguishable=(),
        next_experiment=None,
        no_experiment="",
    )
