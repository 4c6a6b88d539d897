"""What is missing in a model: nothing, wrong parameters, a named effect, or something unknown.

In come a model and `Measurement`s, fitted and held out; out goes a `Diagnosis` (`diagnose`). Its
files in the order of the loop: `data`, `torque_screen`, `search`, `refits`, `evidence`, `rounds`,
`lack_of_fit`, `verdict`, `experiment`, `conclude`.
"""
