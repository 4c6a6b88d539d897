"""Text in figures as a browser draws it: which words lie over others, which are cut."""

from dataclasses import replace

from playwright.sync_api import Page

from elastic_tendon import effects
from elastic_tendon.diagnosis.result import Candidate, Diagnosis, Round
from hand_made_diagnosis import friction_found

# Words that lie over others by more than a hair, or leave their drawing. Labels at an angle have
# boxes that overlap though their words do not, so these are only looked at for being cut.
FAULTS = """() => {
  const hair = 2, lead = 5, found = []; // lead: between lines, where nothing is written
  for (const plot of document.querySelectorAll(".js-plotly-plot")) {
    if (!plot.offsetParent) continue;
    const frame = plot.getBoundingClientRect();
    const title = plot.closest("figure, section, div[id]");
    const where = title && title.innerText ? title.innerText.slice(-60) : "";
    const texts = [...plot.querySelectorAll(".main-svg text")].filter(one => {
      const look = getComputedStyle(one);
      return one.textContent.trim() && look.visibility !== "hidden" && Number(look.opacity) > 0;
    }).map(one => {
      const turn = /rotate\\((-?[\\d.]+)/.exec(one.getAttribute("transform") || "");
      const angle = turn ? Math.abs(Number(turn[1])) % 90 : 0;
      const upright = !turn || Math.abs(Number(turn[1])) % 180 < 1;
      return {
        words: one.textContent, box: one.getBoundingClientRect(), upright, leaning: angle > 1,
      };
    });
    for (const [index, one] of texts.entries()) {
      const a = one.box;
      if (a.left < frame.left - hair || a.right > frame.right + hair
          || a.top < frame.top - hair || a.bottom > frame.bottom + hair) {
        found.push(`cut: ${one.words} (${where})`);
      }
      if (one.leaning) continue;
      for (const other of texts.slice(index + 1)) {
        const b = other.box;
        const across = Math.min(a.right, b.right) - Math.max(a.left, b.left);
        const along = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
        const lines = one.upright && other.upright;
        if (!other.leaning && across > hair && along > (lines ? lead : hair)) {
          found.push(`${one.words} lies over ${other.words} (${where})`);
        }
      }
    }
  }
  return found;
}"""


def longest_titles(count: int) -> list[str]:
    """Ids of the effects whose names are the longest, the longest first."""
    return sorted(effects.BY_ID, key=lambda name: -len(effects.BY_ID[name].title))[:count]


def with_long_names() -> Diagnosis:
    """A diagnosis whose steps and candidates bear the longest names that there are."""
    found = friction_found()
    ids = longest_titles(6)
    titles = [f"+ {effects.BY_ID[name].title}" for name in ids]
    last, last_step = found.ladder[-1], found.steps[-1]
    chosen = tuple(ids[:3])
    rows = tuple(
        Candidate(
            ids=tuple(ids[start : start + 3]),
            probability=0.2,
            expected_parameters={},
            equivalence_class=(),
            evidence=-100.0,
            fitted=True,
            gain=0.95,
            heldout_gain=0.9,
        )
        for start in range(4)
    )
    return replace(
        found,
        ladder=(*found.ladder, *(replace(last, title=title, added=None) for title in titles[:3])),
        steps=(*found.steps, *(replace(last_step, title=title) for title in titles[:3])),
        rounds=(Round(chosen, rows, "they explain more than others do"),),
    )


def faults(page: Page) -> list[str]:
    """What cannot be read of the figures that are drawn."""
    return list(page.evaluate(FAULTS))
