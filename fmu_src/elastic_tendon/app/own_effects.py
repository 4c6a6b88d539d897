"""Effects that a user types on the page: tried in a process of their own, then run in the app's.

What is typed is Python and may do all that the app's user may. So it is run only where the app lets
nobody else in, and only when its user asks; a session that brings such effects is shown first.
"""

import subprocess
import sys
from collections.abc import Iterable

from elastic_tendon import effects
from elastic_tendon.app.document import Document, OwnEffect
from elastic_tendon.effects.base import Effect
from elastic_tendon.errors import EffectError

NAME = "your effect"  # what messages call a text that has no file
PATTERN = effects.quadratic_drag  # of the template: the shortest file of a whole effect
REFUSED = (
    "This app lets other machines in, and what they type would run on this one, so it runs no "
    "effects that are typed on the page. Start it with --effect FILE.py, or without "
    "--open-to-the-network"
)
PATIENCE = 120.0  # s that a text is given to be loaded, on a busy machine too
_TRY = f"""
import sys
from elastic_tendon import effects
from elastic_tendon.errors import ElasticTendonError
try:
    effects.load_text(sys.stdin.buffer.read(), {NAME!r})
except ElasticTendonError:
    pass
"""


def template() -> str:
    """An effect that works, to begin with: one of the catalogue under a name of its own."""
    text = effects.BY_ID.content(PATTERN).decode()
    for declared, own in (
        (f'id="{PATTERN.id}"', 'id="my_effect"'),
        (f'title="{PATTERN.title}"', 'title="My effect"'),
        (f"    catalogue_order={PATTERN.catalogue_order},\n", ""),
    ):
        text = text.replace(declared, own)
    return text


def typed(text: str, *, shared: bool, name: str = NAME) -> Effect:
    """Run the text of an effect; models can name its id from then on.

    Parameters
    ----------
    text : of a Python file
    shared : other machines may use the app, see `Workspace`
    name : what messages call it

    Raises
    ------
    EffectError : it cannot be used, with the line, or the app runs none
    """
    if shared:
        raise EffectError(REFUSED)
    content = text.encode()
    if effects.BY_ID.loaded_from(content) is None:
        _check_harmless(content, name)
    return effects.load_text(content, name)


def _check_harmless(content: bytes, name: str) -> None:
    """Refuse what would not end, or would end the whole app; tried in a process."""
    command = [sys.executable, "-P", "-c", _TRY]
    try:
        done = subprocess.run(
            command, input=content, capture_output=True, timeout=PATIENCE, check=False
        )
    except subprocess.TimeoutExpired:
        raise EffectError(
            f"{name}: it does not end within {PATIENCE:.0f} s; look for a loop without end"
        ) from None
    if done.returncode != 0:
        raise EffectError(f"{name}: it ends Python; leave out what does")


def waiting(document: Document) -> tuple[OwnEffect, ...]:
    """Effects of a session that nobody asked to run since the app was started."""
    return tuple(
        own for own in document.own_effects if effects.BY_ID.loaded_from(own.text.encode()) is None
    )


def run_all(document: Document, *, shared: bool) -> None:
    """Run the effects of a session, and see that its models can be used with them.

    Parameters
    ----------
    document : Document
    shared : as of `typed`

    Raises
    ------
    ElasticTendonError : one of them cannot
    """
    for own in waiting(document):
        typed(own.text, shared=shared, name=own.file_name)
    for version in document.versions:
        version.loaded()


def of_others(document: Document) -> tuple[str, ...]:
    """Ids of effects that were typed in other sessions of this app, or learned from data."""
    own = {own.id for own in document.own_effects}
    return tuple(sorted(effects.BY_ID.from_texts - own))


def known(document: Document) -> Iterable[Effect]:
    """The catalogue of a session: that of everybody, what the command line named, and its own."""
    others = of_others(document)
    return (effect for effect in effects.BY_ID.values() if effect.id not in others)


def welcome(effect: Effect) -> str:
    """What becomes of an effect that can be used."""
    search = "" if effect.on_request else ", and every search tries it"
    return f"{effect.title} is known to this session from now on: it can be added by hand{search}."


def would_be_lost(text: str, document: Document) -> bool:
    """Whether somebody wrote a text that is nowhere else."""
    kept = {"", template().strip(), *(own.text.strip() for own in document.own_effects)}
    return text.strip() not in kept


def fault(error: EffectError, text: str) -> tuple[str, str]:
    """A sentence on why a text cannot be used, and its line that is at fault, "" where none is."""
    line = error.line or 0
    quoted = "".join(text.splitlines()[line - 1 : line]) if line else ""
    return f"{error}.", f"{line} │ {quoted}" if quoted else ""
