"""Whether everybody can read and reach a page: WCAG 2.2 AA as axe-core measures it."""

from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Page

Rules = dict[str, object]  # which axe-core looks at

LEVEL_AA: Rules = {
    "type": "tag",
    "values": ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa"],
}
CONTRAST: Rules = {"type": "rule", "values": ["color-contrast"]}
CURVES = {"exclude": [[".main-svg"]]}  # thousands of points, none of which is text of the page
BEYOND = "document.documentElement.scrollWidth - window.innerWidth"


def violations(page: Page, rules: Rules) -> list[str]:
    """What axe-core finds wrong, each with the first place."""
    # axe-core looks for the place of every node that it lists, also where nothing is wrong
    options = {"runOnly": rules, "resultTypes": ["violations"]}
    found = Axe().run(page, context=CURVES, options=options).response["violations"]
    return [f"{rule['id']}: {rule['help']}, {rule['nodes'][0]['target']}" for rule in found]
