"""Recordings of machines of other kinds, made by `truth.other_machines`."""
