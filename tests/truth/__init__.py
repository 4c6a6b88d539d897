"""An independent simulator of the elastic tendon actuator: the ground truth of the tests.

It shares no code with the product: the paper's equations are written afresh, another integrator
(DOP853 of scipy, restarted at located events) solves them, and friction, overstretch protection
and noise have implementations of their own.

    from truth import actuator, experiments, sampling, solver
"""
