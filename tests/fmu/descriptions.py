"""Descriptions of models with every effect, made without exporting an FMU."""

from functools import cache
from importlib.util import find_spec
from pathlib import Path

from lxml import etree

from effects_at import IDS_AT_POSITION
from elastic_tendon.actuator.model import build
from elastic_tendon.fmu import fmi2_description, fmi3_description
from elastic_tendon.fmu.dependencies import dependencies
from elastic_tendon.fmu.description import Description, seal, to_bytes
from elastic_tendon.native.layout import layout

SCHEMAS = Path(find_spec("fmpy").origin).parent / "schema"
VERSIONS = {2: fmi2_description, 3: fmi3_description}
MANY = (  # implicit equations, dry friction, calculated starts, measured signals
    *("coulomb_friction", "tendon_compliance", "spring_hardening", "spring_relaxation"),
    *("gear_backlash", "motor_encoder_offset", "measurement_delay"),
)
STRUCTURES = [(), *((effect_id,) for effect_id in IDS_AT_POSITION), MANY]


def structure_name(effect_ids):
    """Name of a structure for pytest."""
    return "+".join(effect_ids) or "base" if len(effect_ids) < 3 else "many"


@cache
def described(effect_ids, version):
    """Description of the model with these effects, at its defaults."""
    system = build(effect_ids)
    values = {one.name: one.start for one in system.interface.parameters}
    return Description(
        name="model",
        identifier="model",
        interface=system.interface,
        variables=layout(system.interface, values, indicators=version == 3),
        dependencies=dependencies(system),
        co_simulation=VERSIONS[version].CO_SIMULATION,
        model_exchange=VERSIONS[version].MODEL_EXCHANGE,
    )


def content(effect_ids, version):
    """The file as it lies in an FMU."""
    root = VERSIONS[version].model_description(described(effect_ids, version))
    seal(root, "binary")
    return to_bytes(root)


def strict_schema(version, name, folder):
    """A schema of the standard without its permission to add unknown attributes.

    That is how a capability with a misspelt name passes the usual checkers: it counts as unknown.
    """
    for path in (SCHEMAS / f"fmi{version}").glob("*.xsd"):
        tree = etree.parse(str(path))
        for wildcard in list(tree.iter("{http://www.w3.org/2001/XMLSchema}anyAttribute")):
            wildcard.getparent().remove(wildcard)
        tree.write(str(folder / path.name))
    return etree.XMLSchema(etree.parse(str(folder / name)))
