"""Recordings that look as if they were read wrongly, reported before anything rests on them.

In come a model and `Measurement`s; out go sentences, each with what would put it right: units,
signs, swapped columns, gear ratios (`suspicion`), impossible joints (`plausibility`), late sensors
(`time_shift`), slow sampling (`sampling`), one constant that explains an error (`constants`).
"""
