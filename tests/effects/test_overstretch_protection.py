"""Overstretch protection: the static curve of the paper's Fig. 6."""

import numpy as np

from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.simulation.simulate import simulate

ENGAGEMENT, STIFFNESS = 0.6, 3.0e4  # share of max_deflection, N/m for one spring


def test_static_torque_is_the_papers_plus_that_of_the_string():
    base = load_model("biorob_x4_joint_3").with_values({"link.damping": 5.0})
    model = base.with_effect(
        "overstretch_protection", {"engagement": ENGAGEMENT, "stiffness": STIFFNESS}
    )
    transmission, spring = model.transmission, model.transmission.lower_spring
    time = np.array([0.0, 60.0])
    for load in np.linspace(0.5, 12.0, 12):
        # settle under a constant load that stretches the lower spring
        motion = simulate(model, time, 0 * time, np.full(2, load), tolerance=1e-12)
        deflection = motion["deflection"][-1]
        radius = transmission.joint_pulley_radius
        rest = transmission.pretension_force / spring.combined_stiffness
        below = spring.combined_stiffness * (rest + radius * deflection)
        above = spring.combined_stiffness * max(rest - radius * deflection, 0.0)
        taut = rest + radius * deflection - ENGAGEMENT * spring.max_deflection
        string = spring.parallel * STIFFNESS * max(taut, 0.0)
        assert np.isclose(radius * (below + string - above), load, rtol=1e-6)
