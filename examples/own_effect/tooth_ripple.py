"""Tooth ripple: a toothed belt runs over its pulley as over a polygon."""

from elastic_tendon import effects

TEETH = 20  # of the motor pulley
sin = effects.symbolic.sin


def equations(at, p, _state, _mode):
    """Angle of the motor pulley: the motor's, and a ripple that repeats with every tooth."""
    ripple = p.amplitude * (sin(TEETH * at.motor_position + p.phase) - sin(p.phase))
    return effects.Contribution(at.motor_position + ripple)


EFFECT = effects.Effect(
    id="tooth_ripple",
    title="Tooth ripple",
    slot=effects.Slot.ANGLE_MAP,
    physics="A toothed belt bends at the teeth of its pulley, so its lever changes a little.",
    in_data="The joint shakes at one motor speed, where the teeth meet its natural frequency.",
    parameters=(
        effects.Parameter(
            "amplitude", "rad", "ripple's size", null=0, lower=0, upper=0.1, typical=2e-3
        ),
        effects.Parameter(
            "phase", "rad", "at 0 rad", null=0, lower=-4, upper=4, typical=1, shape=True
        ),
    ),
    equations=equations,
    law="pulley angle = θ + amplitude (sin(20 θ + phase) - sin(phase))",
    reference="the polygonal action of chains and belts",
)
