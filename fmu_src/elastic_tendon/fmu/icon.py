"""The pictures of the FMUs, which `build_scripts/draw_icon.py` has drawn."""

from pathlib import Path

PAGES = Path(__file__).parent / "pages"  # what an FMU shows to people


def icon() -> dict[str, bytes]:
    """Pictures of the actuator by file name: ``icon.svg`` and ``icon.png``."""
    return {name: (PAGES / name).read_bytes() for name in ("icon.svg", "icon.png")}


def flanges() -> dict[str, bytes]:
    """Pictures of the terminals by file name."""
    return {name: (PAGES / name).read_bytes() for name in ("flange_a.png", "flange_b.png")}
