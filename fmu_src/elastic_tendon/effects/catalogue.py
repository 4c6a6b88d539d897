"""The catalogue: the effects of this folder, each by the name of its file.

A new file is found by itself; `catalogue.pyi` tells its name to editors and type checkers, and is
written by build_scripts/name_effects.py.
"""

from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules

from elastic_tendon.effects.base import Effect
from elastic_tendon.effects.registry import Registry

# modules of this folder that hold no effect
WITHOUT = {"base", "catalogue", "checks", "readings", "registry", "source", "symbolic", "units"}


def _effects() -> tuple[Effect, ...]:
    names = {module.name for module in iter_modules([str(Path(__file__).parent)])} - WITHOUT
    effects = [import_module(f"elastic_tendon.effects.{name}").EFFECT for name in names]
    return tuple(sorted(effects, key=lambda effect: (effect.catalogue_order, effect.id)))


CATALOGUE: tuple[Effect, ...] = _effects()
BY_ID = Registry(CATALOGUE)  # these, and what is loaded later
__all__ = ["BY_ID", "CATALOGUE", *(effect.id for effect in CATALOGUE)]
globals().update({effect.id: effect for effect in CATALOGUE})
