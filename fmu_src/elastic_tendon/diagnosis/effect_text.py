"""A learned curve as the text of an effect file, such as a user would write."""

import inspect
from hashlib import sha256
from itertools import product

from elastic_tendon.diagnosis import splines
from elastic_tendon.diagnosis.forms import UNITS, Curve
from elastic_tendon.effects.base import Slot

IN_A_LINE = 6  # numbers
_ID = "<id>"  # stands for the id until that is known

_LAW = '''\
{imports}

CENTRES = {centres}
WIDTHS = {widths}


{functions}

def total(p, shapes, first=0):
    """Sum of coefficients, from number `first` on, times shapes."""
    return sum(getattr(p, f"c{{first + i + 1}}") * shape for i, shape in enumerate(shapes))


def equations(at, p, _state, _mode):
    """{law}"""
    shapes = {shapes}
    return {answer}
'''

_OVER = '''
def over(value, axis=0):
    """Bumps around the centres of one variable."""
    return [bump((value - x) / WIDTHS[axis]) for x in CENTRES[axis]]
'''

_UNTIL = '''
def until(value):
    """Integrals of bumps around the centres, from 0."""
    width = WIDTHS[0]
    return [width * (rise((value - x) / width) - rise(-x / width)) for x in CENTRES[0]]
'''

_EFFECT = '''\
"""Learned from measurements: {words}."""

{law}

def coefficient(name, meaning):
    return Parameter(
        name, "{unit}", meaning, null=0.0, lower={lower}, upper={upper}, typical={typical}
    )


EFFECT = Effect(
    id="{id}",
    title="Learned: {title}",
    slot=Slot.{slot},
    physics="Learned from measurements: {words}. "
    "It says what is missing, not why: cubic splines where there were measurements, nothing far "
    "beyond.",
    in_data="The model without it errs as this function of {variables} makes it err.",
    law="{formula}",
    parameters=(
{parameters}
    ),
    equations=equations,
    reference="Learned from {data}; on stretches that it was not fitted to it explains {share} of "
    "the squared error.",
)
'''


def law_text(curve: Curve) -> str:
    """The part of an effect file that holds the equations."""
    form = curve.form
    friction = form.slot in (Slot.DRY_FRICTION, Slot.TENDON_LOSS)
    answer = "FrictionBounds" if friction else "Contribution"
    names = ", ".join(sorted(("Effect", answer, "Parameter", "Slot")))
    bumps = "over(" in form.shapes
    kind, shapes = (splines.bump, _OVER) if bumps else (splines.rise, _UNTIL)
    imports = (
        f"from elastic_tendon.effects.base import {names}\n"
        "from elastic_tendon.effects.symbolic import absolute, where"
    )
    return _LAW.format(
        imports=imports,
        centres=_centres(curve),
        widths=tuple(grid.width for grid in curve.grids),
        functions=_source_of(kind) + "\n" + shapes,
        law=form.law[0].upper() + form.law[1:] + ".",
        shapes=form.shapes,
        answer=form.answer,
    )


def _source_of(function: object) -> str:
    """Text of a function without its annotations, which the file has no imports for."""
    return inspect.getsource(function).replace("u: Symbol) -> Symbol", "u)")  # type: ignore[arg-type]


def _centres(curve: Curve) -> str:
    """Centres of each axis, a line for a few of them."""
    lines = []
    for grid in curve.grids:
        texts = [f"{x!r}," for x in grid.centres]
        rows = [" ".join(texts[i : i + IN_A_LINE]) for i in range(0, len(texts), IN_A_LINE)]
        lines += ["    (", *(f"        {row}" for row in rows), "    ),"]
    return "\n".join(["(", *lines, ")"])


def effect_text(
    curve: Curve, bounds: tuple[float, float], typical: float, data: str, explains: float
) -> tuple[str, str]:
    """Id and text of the effect file of a curve; files that differ have different ids.

    Parameters
    ----------
    curve : Curve
    bounds : least and largest coefficient
    typical : magnitude of a coefficient
    data : names of the recordings that it was learned from
    explains : share of the squared error, 0 to 1

    Returns
    -------
    id; text of a Python file
    """
    form = curve.form
    listed = zip(curve.names, _places(curve), strict=True)
    lines = [f"        coefficient({name!r}, {meaning!r})," for name, meaning in listed]
    text = _EFFECT.format(
        words=form.words,
        law=law_text(curve),
        unit=form.unit,
        lower=float(f"{bounds[0]:.4g}"),
        upper=float(f"{bounds[1]:.4g}"),
        typical=min(float(f"{typical:.2g}"), float(f"{bounds[1]:.4g}")),
        id=_ID,
        title=form.words.split(" ", 1)[1],
        slot=form.slot.name,
        variables=" and ".join(variable.replace("_", " ") for variable in form.variables),
        formula=form.law,
        parameters="\n".join(lines).replace("'", '"'),
        data=data.replace("\\", "/").replace('"', "'"),
        share=f"{explains:.0%}",
    )
    digest = sha256(text.encode()).hexdigest()[:8]
    effect_id = f"learned_{form.slot.name.lower()}_{digest}"
    return effect_id, text.replace(_ID, effect_id)


def _places(curve: Curve) -> list[str]:
    """What each coefficient is, by the centre of its bump."""
    centres = list(product(*(grid.centres for grid in curve.grids)))
    units = [UNITS[axis] for axis in curve.form.axes]
    return [
        "height of the bump at "
        + " and ".join(f"{x:g} {unit}" for x, unit in zip(place, units, strict=True))
        + side
        for side in curve.form.sides
        for place in centres
    ]
