"""Which hidden effect a diagnosis finds: cases of the independent truth, their classes, a score.

The tool that is judged gets a model and recordings. What it never gets stands in `cases.Facts`.
"""
