"""Parameters from recordings: a fit, and what the data say about each parameter.

In come a model with its prior and `Measurement`s; out goes a `FitResult` (`fit`), or a whole ladder
of errors with effects that a user names (`add`). `problem` holds the residuals and derivatives of a
fit, `determinability` intervals and what the data leave open.
"""
