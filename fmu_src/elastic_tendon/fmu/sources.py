"""The source code in an FMU: what an importer compiles for a platform of its own.

One translation unit, `library.c`, includes everything else. The headers of the FMI standard come
with the importer. As the standard has it, a macro given to the compiler puts the model's
identifier before the functions' names, for linking statically; a shared library is built without.
"""

from pathlib import Path
from xml.etree.ElementTree import Element, SubElement

from elastic_tendon.fmu.description import to_bytes
from elastic_tendon.native import compiler
from elastic_tendon.native.binary import LIBRARY, PAGE, SIMULATION

_LANGUAGE = "C11"
_WITH_LIBM = ("x86_64-linux", "aarch64-linux")  # elsewhere it is no library of its own


def source_files(generated: Path, identifier: str, fmi_version: int) -> dict[str, bytes]:
    """Files of the folder ``sources`` by their path in the FMU.

    Parameters
    ----------
    generated : folder filled by `binary.write_sources`
    identifier : the FMU's model identifier
    fmi_version : 2 or 3; files of the other one, and those for Python and pages, are left out
    """
    left_out = (f"fmi{5 - fmi_version}", SIMULATION, PAGE)
    files = [
        *(path for path in compiler.RUNTIME.glob("*.[ch]") if not path.name.startswith(left_out)),
        *generated.glob("*.[ch]"),
    ]
    contents = {f"sources/{path.name}": path.read_bytes() for path in files}
    if fmi_version == 3:
        contents["sources/buildDescription.xml"] = to_bytes(_build_description(identifier))
    return contents


def declare_sources(root: Element) -> None:
    """List the source code in a model description of FMI 2.0, before it is sealed."""
    for interface in ("ModelExchange", "CoSimulation"):
        for element in root.findall(interface):
            SubElement(SubElement(element, "SourceFiles"), "File", name=LIBRARY)


def _build_description(identifier: str) -> Element:
    """Root of buildDescription.xml of FMI 3.0.

    The last configuration names no platform and is for all that the others are not for; it would
    fit Linux too, so those that link libm there stand before it.
    """
    root = Element("fmiBuildDescription", fmiVersion="3.0")
    for platform in (*_WITH_LIBM, None):
        where = {} if platform is None else {"platform": platform}
        configuration = SubElement(
            root, "BuildConfiguration", {"modelIdentifier": identifier, **where}
        )
        unit = SubElement(configuration, "SourceFileSet", language=_LANGUAGE)
        SubElement(unit, "SourceFile", name=LIBRARY)
        if platform is not None:
            SubElement(configuration, "Library", name="m", external="true")
    return root
