"""The manifest of the layered standard LS-REF: which files an FMU brings along, and what for."""

import posixpath
from collections.abc import Iterable
from dataclasses import dataclass
from urllib.parse import unquote, urlsplit
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from elastic_tendon.errors import EvidenceError
from elastic_tendon.evidence.xml_content import one_line, parse

STANDARD = "org.fmi-standard.fmi-ls-ref"
FOLDER = f"extra/{STANDARD}/"
MANIFEST = f"{FOLDER}fmi-ls-manifest.xml"
_VERSION = "1.0.0-alpha.1"
_NAMESPACE = "http://fmi-standard.org/fmi-ls-manifest"
_DESCRIPTION = (
    "Layered Standard providing information on related files included in an FMU."  # fixed there
)


@dataclass(frozen=True)
class Related:
    """One file: its path in the FMU, its MIME type, its role, in words, and labels.

    `path` is None of a file that is elsewhere, which `source` then says.
    """

    source: str
    type: str
    role: str
    description: str = ""
    labels: tuple[str, ...] = ()

    @property
    def path(self) -> str | None:
        """Path in the FMU, None of a file that is not in it.

        Raises
        ------
        EvidenceError : the source is no address
        """
        try:
            parts = urlsplit(self.source)
        except ValueError:
            raise EvidenceError(
                f"the manifest has {self.source!r}, which is no address of a file"
            ) from None
        if parts.scheme or parts.netloc:
            return None
        return posixpath.normpath(posixpath.join(FOLDER, unquote(parts.path)))


def manifest(files: Iterable[Related]) -> bytes:
    """The manifest as XML."""
    ElementTree.register_namespace("fmi-ls", _NAMESPACE)
    attributes = {"name": STANDARD, "version": _VERSION, "description": _DESCRIPTION}
    root = Element(
        "fmiReferences",
        {f"{{{_NAMESPACE}}}fmi-ls-{name}": value for name, value in attributes.items()},
    )
    for file in files:
        facts = {"type": file.type, "source": file.source, "role": file.role}
        related = SubElement(root, "Related", facts, description=file.description)
        for label in file.labels:
            SubElement(related, "Label", name=label)
    ElementTree.indent(root)
    return bytes(ElementTree.tostring(root, "utf-8", xml_declaration=True)) + b"\n"


def read_manifest(content: bytes, source: str) -> tuple[Related, ...]:
    """The files of a manifest, whoever made it.

    Raises
    ------
    EvidenceError : it is no manifest of LS-REF
    """
    root = parse(content, f"{source}: the manifest")
    if root.tag != "fmiReferences" or root.get(f"{{{_NAMESPACE}}}fmi-ls-name") != STANDARD:
        raise EvidenceError(f"{source}: the manifest is not one of {STANDARD}")
    return tuple(
        Related(
            source=one_line(related.get("source", "")),
            type=related.get("type", "application/octet-stream"),
            role=one_line(related.get("role", "other")),
            description=related.get("description", ""),
            labels=tuple(label.get("name", "") for label in related.findall("Label")),
        )
        for related in root.findall("Related")
    )
