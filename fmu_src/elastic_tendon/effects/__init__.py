"""The catalogue of physical effects; a new effect is a file of this folder.

An effect of the user's own comes in by `load`, or from an installed package by its id. It is
written with the classes that are imported here from `base`, and the functions of `symbolic`.
"""

from pathlib import Path

from elastic_tendon.effects import symbolic as symbolic
from elastic_tendon.effects.base import Contribution as Contribution
from elastic_tendon.effects.base import Effect as Effect
from elastic_tendon.effects.base import FrictionBounds as FrictionBounds
from elastic_tendon.effects.base import HalfTensions as HalfTensions
from elastic_tendon.effects.base import Parameter as Parameter
from elastic_tendon.effects.base import Relation as Relation
from elastic_tendon.effects.base import Slot as Slot
from elastic_tendon.effects.base import Spread as Spread
from elastic_tendon.effects.base import State as State
from elastic_tendon.effects.catalogue import *
from elastic_tendon.effects.catalogue import BY_ID as BY_ID
from elastic_tendon.effects.catalogue import CATALOGUE as CATALOGUE


def load(path: str | Path) -> Effect:
    """Run a Python file that defines ``EFFECT``; models can name its id from then on.

    Parameters
    ----------
    path : of the file; one that is loaded already is not run again

    Returns
    -------
    Effect

    Raises
    ------
    EffectError
        for a file that cannot be used, with the line and the reason
    """
    return BY_ID.load(path)


def load_text(content: bytes, name: str) -> Effect:
    """As `load`, of the text of such a file; see `Registry.load_text`."""
    return BY_ID.load_text(content, name)
