"""The reference site, as static pages that need no network.

    python build_scripts/build_site.py [FOLDER]

Its pages are made of the code and the texts that are there already (see `site_pages`), beside few
that are written for it, in fmu_src/site. Sphinx turns them into HTML (default: build/site), and
warnings are errors. Then every link is followed. Needs the extra `docs`.
"""

import re
import shutil
import sys
import tempfile
from collections.abc import Iterator
from html.parser import HTMLParser
from itertools import chain
from pathlib import Path
from urllib.parse import unquote, urlsplit

from sphinx.cmd.build import build_main

from site_pages import contracts, door, effects, guides, known_machines

SITE = guides.TEXTS / "site"
ADDRESS = re.compile(r"(?:url\(|@import)\s*['\"]?((?:https?:)?//[^'\")]+)")  # in style sheets
LOADED = {"src", "srcset", "data", "poster"}  # attributes that a browser follows by itself


def write_sources(folder: Path) -> None:
    """All pages, as Sphinx reads them."""
    shutil.copytree(SITE, folder, dirs_exist_ok=True, ignore=guides.SKIPPED)
    made = chain(
        *(guides.readme(), guides.architecture(folder), guides.examples(folder)),
        *(guides.commands(), contracts.pages(folder), contracts.equations()),
        *(door.pages(), effects.pages(folder), known_machines.pages(folder)),
    )
    for name, content in made:
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(content)


def build(output: Path) -> list[str]:
    """Build the site; what is wrong with it, a sentence each."""
    with tempfile.TemporaryDirectory() as work:
        sources = Path(work) / "sources"
        write_sources(sources)
        options = ["-q", "-W", "--keep-going", "-b", "html", "-d", f"{work}/doctrees"]
        if build_main([*options, str(sources), str(output)]) != 0:
            return ["Sphinx has warned, see above"]
    return list(problems(output))


# ---- links ---------------------------------------------------------------------------------


class _Page(HTMLParser):
    """Places of a page, where it leads to, and what it loads."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.places: set[str] = set()
        self.links: set[str] = set()
        self.loaded: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            if name in ("id", "name"):
                self.places.add(value or "")
            elif name in LOADED or (tag, name) == ("link", "href"):
                self.loaded.add(value or "")
            elif name == "href":
                self.links.add(value or "")


def problems(folder: Path) -> Iterator[str]:
    """Links of the site that lead nowhere, and whatever would be loaded from a network."""
    folder = folder.resolve()
    pages = {path: _Page(path.read_text()) for path in sorted(folder.rglob("*.html"))}
    for path, page in pages.items():
        for link in sorted(page.links | page.loaded):
            if fault := _fault(link, path, pages):
                yield f"{path.relative_to(folder)}: {fault}"
            if link in page.loaded and _is_elsewhere(link):
                yield f"{path.relative_to(folder)} loads {link}"
    for path in sorted(folder.rglob("*.css")):
        for address in ADDRESS.findall(path.read_text()):
            yield f"{path.relative_to(folder)} loads {address}"


def _is_elsewhere(link: str) -> bool:
    parts = urlsplit(link)
    return parts.scheme != "data" and bool(parts.scheme or parts.netloc)


def _fault(link: str, path: Path, pages: dict[Path, _Page]) -> str:
    """Why a link from a page leads nowhere, "" where it leads somewhere or off the site."""
    parts = urlsplit(link)
    if parts.scheme or parts.netloc:
        return ""
    target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
    if not target.exists():
        return f"{link} is not there"
    known = target not in pages or unquote(parts.fragment) in {"", *pages[target].places}
    return "" if known else f"{link} is no place of that page"


def main() -> None:
    """Build into the folder that is named; exit status 1 where something is wrong."""
    output = Path(sys.argv[1] if len(sys.argv) > 1 else "build/site")
    found = build(output)
    print("\n".join(found) or f"the site begins at {output / 'index.html'}")
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
