"""XML that others have written: read, or refused in one sentence."""

from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from elastic_tendon.errors import EvidenceError


def parse(content: bytes, source: str) -> Element:
    """Root of a document; `source` is what messages call it.

    Raises
    ------
    EvidenceError : it is no XML, or in an encoding that there is not
    """
    try:
        return ElementTree.fromstring(content)
    except (ElementTree.ParseError, LookupError, ValueError) as error:
        raise EvidenceError(f"{source} is no XML ({error})") from None


def one_line(text: str) -> str:
    """Text in which line feeds, tabs and rows of blanks are one blank each."""
    return " ".join(text.split())
