"""Models and motions of the FMU tests."""

import numpy as np

from elastic_tendon.parameters import load_model
from fmu_driver import Segments


def models():
    """Models by name: as in the paper, with spring damping, and with both effects."""
    base = load_model("biorob_x4_joint_3")
    damping = {f"transmission.{side}_spring.damping": 20.0 for side in ("upper", "lower")}
    effects = base.with_effect("coulomb_friction", {"torque": 0.35})
    effects = effects.with_effect("overstretch_protection", {"engagement": 0.4, "stiffness": 2e4})
    return {"base": base, "damped": base.with_values(damping), "effects": effects}


MODELS = models()


def motion(linear, n=151, rate=100.0, amplitude=0.3):
    """Motor motion that takes the tendons through slack, N samples at `rate` Hz."""
    time = np.zeros(n)
    for i in range(1, n):
        time[i] = time[i - 1] + 1 / rate  # the sums that an importer makes
    position = amplitude * (
        np.sin(23.0 * time) + 0.5 * np.sin(57.0 * time + 1.0) - 0.5 * np.sin(1.0)
    )
    return Segments(time, position, linear)
