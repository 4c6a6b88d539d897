"""A model beside recordings: how large is the error, where does it lie, what does it look like?

In come a model and `Measurement`s; out goes a `Comparison` (`compare`), then where it fails
(`locate`) and which torque is missing there (`missing_torque`). `residuals` are simulated less
measured signals, `initial_state` where each simulation begins; `patterns` and `in_words` say what
the error looks like.
"""
