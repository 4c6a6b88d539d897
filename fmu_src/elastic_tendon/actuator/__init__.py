"""The actuator as equations: the paper's, and the effects in their slots.

In comes a model.toml (`parameters`); out goes a `HybridSystem` of symbols (`model`), which `native`
turns into C and `linear` into matrices. `transmission` and `design` hold the paper's equations, for
numbers, arrays and symbols alike; `tendon` one tendon with all that effects make of it;
`variables` names and order of all that a system has. No input or output.
"""
