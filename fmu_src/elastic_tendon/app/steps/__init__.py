"""The steps of the loop, in the order of the page; one file each."""

from elastic_tendon.app.steps import add, compare, data, effect, model, take_away, where

STEPS = (
    model.STEP,
    data.STEP,
    compare.STEP,
    where.STEP,
    effect.STEP,
    add.STEP,
    take_away.STEP,
)
