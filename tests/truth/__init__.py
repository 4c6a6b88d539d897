"""An independent simulator of the elastic tendon actuator: the ground truth of the tests.

It shares no code with the product: the paper's equations are written afresh, another integrator
(DOP853 of scipy, restarted at located events) solves them, and every effect of the catalogue and
the noise have implementations of their own; `catalogue` makes the truth of a model.toml.

    from truth import actuator, experiments, sampling, solver
"""
