"""Motions of a model: arrays in, arrays out, one call of the compiled library.

`simulate` has simulations, their exact derivatives and many at once; `excitation` a motion that
shows all of an actuator, `signature` those that show an effect; `work` counts what is simulated.
"""
