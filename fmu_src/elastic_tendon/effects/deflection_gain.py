"""A deflection sensor that shows more or less than the deflection."""

from types import SimpleNamespace

from elastic_tendon.effects.base import Contribution, Effect, Parameter, Signal, Slot


def equations(
    at: Signal, p: SimpleNamespace, _state: SimpleNamespace, _mode: SimpleNamespace
) -> Contribution:
    """What the sensor shows beyond the deflection."""
    return Contribution(p.error * at.value)


EFFECT = Effect(
    id="deflection_gain",
    title="Deflection gain",
    slot=Slot.DEFLECTION_SIGNAL,
    catalogue_order=165,
    physics="A deflection is measured by a strain gauge, a Hall sensor or a short encoder whose "
    "scale is not what the data sheet says, or it follows from a torque and a spring's stiffness.",
    in_data="The springs seem stiffer or softer by the same share at every deflection, in every "
    "slack state and direction; what the joint's inertia does to the motion is not changed with "
    "it, so the error is largest where the joint swings against the motor.",
    law="measured deflection = (1 + error) δ",
    confused_with="Tendon compliance: it makes the drive softer too, but also where the joint "
    "swings by its own inertia. A wrong stiffness of the springs: the same as long as the load is "
    "known and the joint's own motion is slow.",
    confirm="Hold the motor, turn the joint by a known angle and compare the reading with it.",
    cure="Calibrate the sensor over its range; put it into the scale of the column "
    "(--map joint_deflection=COLUMN:rad*FACTOR).",
    magnitude="1 to 3 % for encoders and calibrated gauges, 10 to 30 % from a data sheet.",
    parameters=(
        Parameter(
            name="error",
            unit="1",
            meaning="share by which the reading of the deflection is too large",
            null=0.0,
            lower=-0.9,
            upper=10.0,
            typical=0.1,
        ),
    ),
    equations=equations,
    reference="G. A. Pratt, M. M. Williamson, Series elastic actuators, IEEE/RSJ International "
    "Conference on Intelligent Robots and Systems, 1995",
)
