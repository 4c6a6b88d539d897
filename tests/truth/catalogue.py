"""The actuator of a model.toml: the contract's numbers as the parts of the truth.

The numbers of a spring and of its effects count for one spring; here they are added up over the
parallel springs.
"""

from collections.abc import Mapping
from typing import Any

from truth.actuator import Actuator, Eccentricity
from truth.friction import Coulomb, Friction, LuGre, Stribeck
from truth.hysteresis import BoucWen
from truth.link import Gravity, Link, Stop
from truth.recording import SignalMaps
from truth.spring import LumpedMass, Overstretch, Relaxation, Spring

Numbers = Mapping[str, Any]


def friction_of(effects: Numbers) -> Friction | None:
    """The one law of friction of velocity, if there is any."""
    found: list[Friction] = []
    if "coulomb_friction" in effects:
        found.append(Coulomb(**effects["coulomb_friction"]))
    if "stribeck_friction" in effects:
        found.append(Stribeck(**effects["stribeck_friction"]))
    if "lugre_friction" in effects:
        numbers = dict(effects["lugre_friction"])
        stiffness, damping = numbers.pop("bristle_stiffness"), numbers.pop("bristle_damping")
        found.append(LuGre(**numbers, stiffness=stiffness, damping=damping))
    assert len(found) <= 1, "laws of friction exclude one another"
    return found[0] if found else None


def overstretch_of(spring: Numbers, effects: Numbers) -> Overstretch | None:
    """Protective strings of one side."""
    if "overstretch_protection" not in effects:
        return None
    numbers = effects["overstretch_protection"]
    return Overstretch(
        engagement=numbers["engagement"] * spring["max_deflection"],
        stiffness=spring.get("parallel", 1) * numbers["stiffness"],
    )


def spring_of(spring: Numbers, effects: Numbers, sign: float) -> Spring:
    """All springs of one side with their tendon; `sign` is 1 of the upper, -1 of the lower."""
    count = spring.get("parallel", 1)
    hysteresis, relaxation, lumped = (
        effects.get(name) for name in ("spring_hysteresis", "spring_relaxation", "spring_mass")
    )
    return Spring(
        stiffness=count * spring["stiffness"],
        max_deflection=spring["max_deflection"],
        damping=count * spring.get("damping", 0.0),
        overstretch=overstretch_of(spring, effects),
        square_stiffness=sign
        * count
        * effects.get("spring_asymmetry", {}).get("square_stiffness", 0.0),
        cubic_stiffness=count * effects.get("spring_hardening", {}).get("cubic_stiffness", 0.0),
        hysteresis=hysteresis
        and BoucWen(
            count * hysteresis["force"],
            hysteresis["yield_length"],
            hysteresis.get("exponent", 1.0),
        ),
        relaxation=relaxation
        and Relaxation(count * relaxation["stiffness"], relaxation["time_constant"]),
        compliance=effects.get("tendon_compliance", {}).get("compliance", 0.0),
        lumped=lumped and LumpedMass(count * lumped["mass"], count * lumped["damping"]),
    )


def link_of(link: Numbers, effects: Numbers) -> Link:
    """The link with the torques of its surroundings."""
    gravity, stop = effects.get("gravity_load"), effects.get("joint_stop")
    return Link(
        inertia=link["inertia"],
        damping=link.get("damping", 0.0),
        friction=friction_of(effects),
        drag=effects.get("quadratic_drag", {}).get("coefficient", 0.0),
        cubic_damping=effects.get("cubic_damping", {}).get("coefficient", 0.0),
        damping_difference=effects.get("directional_damping", {}).get("difference", 0.0),
        constant_torque=effects.get("constant_torque", {}).get("torque", 0.0),
        gravity=gravity and Gravity(**gravity),
        stop=stop and Stop(**stop),
    )


def actuator_of(tree: Numbers) -> Actuator:
    """The actuator of the content of a model.toml."""
    transmission, effects = tree["transmission"], tree.get("effects", {})
    eccentricity = effects.get("pulley_eccentricity")
    return Actuator(
        joint_pulley_radius=transmission["joint_pulley_radius"],
        motor_pulley_radius=transmission["motor_pulley_radius"],
        pretension_force=transmission["pretension_force"],
        upper=spring_of(transmission["upper_spring"], effects, 1.0),
        lower=spring_of(transmission["lower_spring"], effects, -1.0),
        link=link_of(tree["link"], effects),
        wrap_friction=effects.get("tendon_guide_friction", {}).get("wrap_friction", 0.0),
        gap=effects.get("gear_backlash", {}).get("gap", 0.0),
        eccentricity=eccentricity and Eccentricity(**eccentricity),
    )


# effects of what measures a torque or a force, by the beginning of their ids
CELLS = {
    "joint_torque": "joint_torque",
    "motor_reading": "motor_torque",
    "upper_force": "upper_spring_force",
    "lower_force": "lower_spring_force",
}


def signal_maps_of(tree: Numbers) -> SignalMaps:
    """What the sensors of a model.toml make of the true signals."""
    effects = tree.get("effects", {})
    return SignalMaps(
        joint_offset=effects.get("joint_encoder_offset", {}).get("offset", 0.0),
        motor_offset=effects.get("motor_encoder_offset", {}).get("offset", 0.0),
        joint_share=effects.get("joint_encoder_gain", {}).get("error", 0.0),
        motor_share=effects.get("motor_encoder_gain", {}).get("error", 0.0),
        delay=effects.get("measurement_delay", {}).get("delay", 0.0),
        deflection_share=effects.get("deflection_gain", {}).get("error", 0.0),
        cells={
            signal: (
                effects.get(f"{cell}_gain", {}).get("error", 0.0),
                effects.get(f"{cell}_offset", {}).get("offset", 0.0),
            )
            for cell, signal in CELLS.items()
        },
    )
