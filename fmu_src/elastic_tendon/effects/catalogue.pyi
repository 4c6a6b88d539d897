from elastic_tendon.effects.base import Effect
from elastic_tendon.effects.registry import Registry

CATALOGUE: tuple[Effect, ...]
BY_ID: Registry
coulomb_friction: Effect
stribeck_friction: Effect
lugre_friction: Effect
quadratic_drag: Effect
gravity_load: Effect
joint_stop: Effect
overstretch_protection: Effect
spring_hardening: Effect
spring_hysteresis: Effect
spring_relaxation: Effect
spring_mass: Effect
tendon_guide_friction: Effect
tendon_compliance: Effect
pulley_eccentricity: Effect
gear_backlash: Effect
joint_encoder_offset: Effect
joint_encoder_gain: Effect
deflection_gain: Effect
motor_encoder_offset: Effect
motor_encoder_gain: Effect
constant_torque: Effect
measurement_delay: Effect
directional_damping: Effect
spring_asymmetry: Effect
cubic_damping: Effect
motor_friction: Effect
gear_loss: Effect
motor_stiction: Effect
motor_cogging: Effect
motor_torque_gain: Effect
motor_torque_offset: Effect
joint_torque_gain: Effect
joint_torque_offset: Effect
motor_reading_gain: Effect
motor_reading_offset: Effect
upper_force_gain: Effect
upper_force_offset: Effect
lower_force_gain: Effect
lower_force_offset: Effect
