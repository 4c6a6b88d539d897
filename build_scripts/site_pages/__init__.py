"""Pages of the reference site, in MyST Markdown, made of the product's own code and texts.

Each module has functions that give pages: path below the site's folder, and content.
"""

from collections.abc import Iterator
from typing import TypeAlias

Pages: TypeAlias = Iterator[tuple[str, str]]
