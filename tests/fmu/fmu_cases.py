"""Models and motions of the FMU tests, and the versions of FMI they are for."""

import numpy as np
import pytest

from elastic_tendon.actuator.parameters import load_model, typical_value
from elastic_tendon.effects import BY_ID
from fmu_driver import Segments

# marks of modules or tests
BOTH = pytest.mark.parametrize("version", [2, 3], ids=["fmi2", "fmi3"], indirect=True)
FMI3 = pytest.mark.parametrize("version", [3], ids=["fmi3"], indirect=True)

# equations solved at run time, starts that are calculated
IMPLICIT_EFFECTS = ("spring_hardening", "spring_relaxation", "tendon_compliance")


def with_typical(model, effect_id):
    """The model with an effect at numbers of a typical machine."""
    numbers = {one.name: typical_value(model, one) for one in BY_ID[effect_id].parameters}
    return model.with_effect(effect_id, numbers)


def models():
    """Models by name: as in the paper, with spring damping, and with effects."""
    base = load_model("biorob_x4_joint_3")
    damping = {f"transmission.{side}_spring.damping": 20.0 for side in ("upper", "lower")}
    effects = base.with_effect("coulomb_friction", {"torque": 0.35})
    effects = effects.with_effect("overstretch_protection", {"engagement": 0.4, "stiffness": 2e4})
    implicit = base
    for effect_id in IMPLICIT_EFFECTS:
        implicit = with_typical(implicit, effect_id)
    return {
        "base": base,
        "damped": base.with_values(damping),
        "effects": effects,
        "implicit": implicit,
    }


MODELS = models()
PAPER_AND_EFFECTS = ("base", "damped", "effects")


def motion(linear, n=151, rate=100.0, amplitude=0.3):
    """Motor motion that takes the tendons through slack, N samples at `rate` Hz."""
    time = np.zeros(n)
    for i in range(1, n):
        time[i] = time[i - 1] + 1 / rate  # the sums that an importer makes
    position = amplitude * (
        np.sin(23.0 * time) + 0.5 * np.sin(57.0 * time + 1.0) - 0.5 * np.sin(1.0)
    )
    return Segments(time, position, linear)
