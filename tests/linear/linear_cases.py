"""Models of the tests of linear models."""

from elastic_tendon.actuator.parameters import load_model, typical_value
from elastic_tendon.effects import BY_ID

MODELS = ("biorob_x4_joint_3", "figure_7", "bench_actuator")
STATES = ("I", "II", "III", "both")
TAUT = {"I": (1, 0), "II": (0, 1), "III": (1, 1), "both": (0, 0)}


def damped(name):
    """A bundled model whose springs have dampers that differ."""
    dampings = {"upper": 20.0, "lower": 35.0}
    return load_model(name).with_values(
        {f"transmission.{side}_spring.damping": value for side, value in dampings.items()}
    )


def with_typical(model, *effect_ids):
    """The model with effects of typical size."""
    for effect_id in effect_ids:
        numbers = {
            parameter.name: typical_value(model, parameter)
            for parameter in BY_ID[effect_id].parameters
        }
        model = model.with_effect(effect_id, numbers)
    return model


def closed_form(model, state):
    """Stiffness (19), (23), (25) and damping (20), (23), (25) on the joint."""
    t = model.transmission
    square = t.joint_pulley_radius**2
    springs = (t.upper_spring, t.lower_spring)
    taut = [spring for spring, counts in zip(springs, TAUT[state], strict=True) if counts]
    stiffness = square * sum(spring.parallel * spring.stiffness for spring in taut)
    damping = square * sum(spring.parallel * spring.damping for spring in taut)
    return stiffness, damping
