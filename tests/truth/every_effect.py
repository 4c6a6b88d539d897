"""Every effect of the catalogue, at a size that shows."""

EFFECTS = {
    "coulomb_friction": {"torque": 0.6},
    "stribeck_friction": {
        "coulomb_torque": 0.5,
        "static_torque": 0.8,
        "stribeck_velocity": 0.5,
    },
    "lugre_friction": {
        "coulomb_torque": 0.25,
        "static_torque": 0.4,
        "stribeck_velocity": 0.5,
        "bristle_stiffness": 300.0,
        "bristle_damping": 0.5,
    },
    "quadratic_drag": {"coefficient": 0.02},
    "gravity_load": {"torque": 0.8, "angle": 0.4},
    "constant_torque": {"torque": -0.7},
    "joint_stop": {"lower": -0.3, "upper": 0.4, "stiffness": 200.0, "damping": 1.0},
    "overstretch_protection": {"engagement": 0.45, "stiffness": 9000.0},
    "spring_hardening": {"cubic_stiffness": 2.5e7},
    "spring_hysteresis": {"force": 12.0, "yield_length": 0.0011, "exponent": 1.6},
    "spring_relaxation": {"stiffness": 3000.0, "time_constant": 0.13},
    "spring_mass": {"mass": 0.3, "damping": 2.0},
    "tendon_guide_friction": {"wrap_friction": 0.12},
    "tendon_compliance": {"compliance": 1.3e-5},
    "gear_backlash": {"gap": 0.02},
    "pulley_eccentricity": {"amplitude": 0.05, "phase": 0.7},
    "joint_encoder_offset": {"offset": 0.013},
    "motor_encoder_offset": {"offset": 0.013},
    "deflection_gain": {"error": 0.15},
    "measurement_delay": {"delay": 0.0073},
}
