"""What is told beside the verdict."""

from types import SimpleNamespace

import pytest

from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.diagnosis.answer import Answer, refit
from elastic_tendon.diagnosis.conclude import different, doubtful_values
from elastic_tendon.diagnosis.confirmation import on_everything
from elastic_tendon.effects import BY_ID
from elastic_tendon.estimation.fit import QUICK

GIVEN = load_model("biorob_x4_joint_3")
LEAST = next(
    one.lower for one in BY_ID["stribeck_friction"].parameters if one.name == "stribeck_velocity"
)


@pytest.mark.parametrize(("velocity", "doubted"), [(0.05, False), (LEAST, True)])
def test_values_that_hardly_can_be_are_told(velocity: float, doubted: bool) -> None:
    values = {"coulomb_torque": 0.3, "static_torque": 0.4, "stribeck_velocity": velocity}
    model = GIVEN.with_effect("stribeck_friction", values)
    problem = SimpleNamespace(coordinates=SimpleNamespace(sizes={}))
    result = SimpleNamespace(model=model, problem=problem)
    told = list(doubtful_values(Answer(("stribeck_friction",), result)))
    assert [
        part.startswith("Stribeck friction: stribeck velocity 0.0001 rad/s is ") for part in told
    ] == [True] * doubted


def test_an_interrupt_that_the_confirming_fit_swallows_is_heeded(frictionless) -> None:
    known, recording = frictionless
    answer = refit(known.model, (), [recording], effort=QUICK)
    data = SimpleNamespace(given=known.model, whole=(recording,))
    told = []

    def interrupting(_text: str, share: float) -> None:
        told.append(share)
        if len(told) > 1:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        on_everything(data, answer, interrupting)
    assert len(told) > 2  # the fit was interrupted first, and went on quietly


def test_what_tells_sets_apart_is_named_whole() -> None:
    """One effect of two is no answer where the other has to stay."""
    both = ("coulomb_friction", "joint_encoder_offset")
    guided = ("tendon_guide_friction", "joint_encoder_offset")
    turned = ("coulomb_friction", "constant_torque")
    assert different([both, turned]) == ["joint_encoder_offset", "constant_torque"]
    assert different([both, guided, turned]) == [
        "coulomb_friction+joint_encoder_offset",
        "tendon_guide_friction+joint_encoder_offset",
        "coulomb_friction+constant_torque",
    ]
    assert different([]) == []
