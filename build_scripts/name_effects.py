"""Tell the names of effects to editors and type checkers: writes effects/catalogue.pyi.

The catalogue finds the files of its folder when it is imported, which no type checker does. Run it
when an effect has come or gone; tests/effects/test_texts.py compares the file with what is written
here.
"""

from pathlib import Path

from elastic_tendon.effects import CATALOGUE, catalogue

STUB = Path(catalogue.__file__).with_suffix(".pyi")
BEGINNING = """from elastic_tendon.effects.base import Effect
from elastic_tendon.effects.registry import Registry

CATALOGUE: tuple[Effect, ...]
BY_ID: Registry
"""


def names() -> str:
    """The content of the file."""
    return BEGINNING + "".join(f"{effect.id}: Effect\n" for effect in CATALOGUE)


if __name__ == "__main__":
    STUB.write_text(names(), encoding="utf-8")
