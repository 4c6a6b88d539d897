"""Tendons that stretch themselves, in series with their springs."""

from types import SimpleNamespace

from elastic_tendon.effects.base import Alias, Contribution, Effect, Parameter, Slot, Tendon


def equations(
    _at: Tendon, p: SimpleNamespace, _state: SimpleNamespace, _mode: SimpleNamespace
) -> Contribution:
    """The tendon's compliance is a number."""
    return Contribution(p.compliance)


EFFECT = Effect(
    id="tendon_compliance",
    title="Tendon compliance",
    slot=Slot.SERIES_ELEMENT,
    catalogue_order=130,
    physics="Steel or polymer ropes are springs too: they lengthen with their force, in series "
    "with the springs proper.",
    in_data="The joint is softer than the springs say, by the same share in every slack state, in "
    "both directions and at any speed. Only springs that are damped or not linear let the tendon "
    "show otherwise: it gives way first in fast motions, and it softens what lies beyond a corner "
    "of the curve.",
    law="elongation of a side = e + compliance F, F force of its parallel springs",
    confused_with="Softer springs: only springs that are damped or not linear distinguish the two. "
    "Spring relaxation: the same law in other numbers where the springs are damped. Deflection "
    "gain: where the deflection is what is measured, a sensor that shows too much looks as soft; "
    "the joint swings no slower for it.",
    confirm="Hold the motor, load the link and read the length of the spring itself beside the "
    "joint encoder: what the joint yields beyond the spring's elongation over R belongs to the "
    "tendon. Or block the springs and load the link: what still yields is the tendon.",
    cure="A shorter or thicker tendon, steel instead of polymer, stretched before use. Or count it "
    "into the springs: one softer stiffness does as well where the springs are linear and "
    "undamped.",
    magnitude="Length over elastic modulus times metal area: about 3e-6 m/N for 0.5 m of 2 mm "
    "steel rope, several times more for polymer ropes. Knots, clamps and loose lays add to it, and "
    "it falls with tension.",
    parameters=(
        Parameter(
            name="compliance",
            unit="m/N",
            meaning="elongation of the tendon of one side per force",
            null=0.0,
            lower=0.0,
            upper=1.0,
            typical=lambda sizes: 0.1 / (sizes.parallel * sizes.stiffness),
        ),
    ),
    equations=equations,
    reference="K. Feyrer, Wire Ropes: Tension, Endurance, Reliability, 2nd edition, Springer, 2015",
    aliases=(
        Alias(
            of=("transmission.upper_spring.stiffness", "transmission.lower_spring.stiffness"),
            when="the springs are linear and have no damping: softer springs are then the same",
        ),
    ),
)
