"""The report that stands alone: what is in it, in which order, and what it never does."""

import json
import re
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from plotly.offline import get_plotlyjs

from elastic_tendon import demo, simulate
from elastic_tendon.actuator.parameters import Model, load_model
from elastic_tendon.actuator.transmission import characteristic_torque
from elastic_tendon.comparison.compare import compare
from elastic_tendon.comparison.comparison import Comparison
from elastic_tendon.comparison.locate import locate
from elastic_tendon.diagnosis.result import Diagnosis
from elastic_tendon.errors import LinearisationError
from elastic_tendon.measurement import Measurement, read_measurement
from elastic_tendon.reports.comparison_tables import repeats
from elastic_tendon.reports.html import answers
from elastic_tendon.reports.html.document import comparison_document, diagnosis_document
from elastic_tendon.reports.html.origin import Origin, origin_of
from elastic_tendon.reports.html.page import PLOTLY
from hand_made_diagnosis import friction_found, nothing_missing, something_unknown

EVIL = "<script>window.hacked = 1</script><img src=x onerror='window.hacked = 1'>"
CHROMIUM = Path("/usr/bin/chromium")
# bytes per figure; a curve has at most 3000 points, and the longest figures a handful of them
LARGEST_FIGURE = 500_000


class Page(HTMLParser):
    """Elements with their attributes, and the text of each; scripts apart."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.scripts: list[str] = []
        self.text = ""
        self._open = ""
        self.feed(text)

    def handle_starttag(self, tag, attrs) -> None:
        self.elements.append((tag, dict(attrs)))
        self._open = tag
        if tag == "script":
            self.scripts.append("")

    def handle_endtag(self, _tag) -> None:
        self._open = ""

    def handle_data(self, data) -> None:
        if self._open == "script":
            self.scripts[-1] += data
        elif self._open != "style":
            self.text += data

    def of(self, tag: str) -> list[dict[str, str | None]]:
        """Attributes of all elements of a kind."""
        return [attributes for element, attributes in self.elements if element == tag]

    def figures(self) -> list[dict]:
        """Figures as plotly gets them, light."""
        every = zip(self.of("script"), self.scripts, strict=True)
        return [
            json.loads(text)
            for attributes, text in every
            if (attributes.get("id") or "").startswith("figure-")
            and not attributes["id"].endswith("-dark")
        ]


def origin() -> Origin:
    return origin_of(
        "elastic-tendon diagnose 'my model.toml' demo_fit.csv",
        [("fitted", demo.DATA / "demo_fit.csv"), ("model", Path("bundled_model"))],
        ["To ship the model:", "  elastic-tendon export improved.toml -o improved.fmu"],
    )


def document_of(diagnosis: Diagnosis) -> str:
    return diagnosis_document(diagnosis, locate(diagnosis.steps[0].comparison), origin())


def comparison_of(*measurements: Measurement) -> Comparison:
    return compare(load_model(demo.DATA / "demo_model.toml"), measurements)


def document_of_comparison(*measurements: Measurement) -> str:
    found = comparison_of(*measurements)
    return comparison_document(found, locate(found), origin())


@cache
def friction() -> Page:
    return Page(document_of(friction_found()))


@cache
def recording() -> Measurement:
    return read_measurement(str(demo.DATA / "demo_fit.csv"))


def in_order(text: str, *words: str) -> bool:
    """Whether a text says all of these, one after the other; missing ones raise ValueError."""
    places = [text.index(word) for word in words]
    return places == sorted(places)


# ---- what is in it -----------------------------------------------------------------------------


def test_sections_stand_in_the_order_in_which_one_asks() -> None:
    anchors = [tag["id"] for tag in friction().of("h2")]
    assert anchors == [
        *("verdict", "overlay", "live", "where", "effects", "sure", "ladder"),
        *("parameters", "equations", "linear", "data", "papers"),
    ]
    links = [tag["href"] for tag in friction().of("a")]
    assert links == [f"#{anchor}" for anchor in anchors]


def test_the_answer_comes_first_and_the_evidence_after_it() -> None:
    assert in_order(
        friction().text,
        "Coulomb friction is surely missing",
        "Added: Coulomb friction, torque 0.3",
        "These data cannot distinguish",
        "elastic-tendon export improved.toml",
        "demo_fit.csv (fitted data)",
        "demo_validate.csv (held-out data)",
        "where the joint position is off",
        "Round 1",
        "What Coulomb friction explains",
        "Small reversals of the motor",
        "The error after each step (RMS)",
        "What was fitted, with 95 % intervals",
        "-torque sgn(v)",
        "demo_actuator, as given",
        "demo_actuator + coulomb friction, improved",
        "Preparation, as a TOML file",
        "elastic-tendon diagnose 'my model.toml' demo_fit.csv",
        "Dynamic Modeling of Elastic Tendon Actuators",
        "Kass",
    )


def test_what_was_read_can_be_recognised() -> None:
    (file,) = origin().files  # a bundled model is no file
    data = (demo.DATA / "demo_fit.csv").read_bytes()
    assert file.size == len(data)
    assert file.purpose == "fitted"
    assert file.checksum in friction().text
    for program in ("Python", "numpy", "casadi"):
        assert origin().software[program] in friction().text
    assert re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d[+-]\d\d:\d\d", origin().made)


def test_a_file_with_two_uses_is_listed_once(tmp_path: Path) -> None:
    path = tmp_path / "bag"
    path.mkdir()
    (path / "part.db3").write_bytes(b"abc")
    (file,) = origin_of("x", [("fitted", path), ("held-out", path)]).files
    assert (file.purpose, file.size) == ("fitted, held-out", 3)
    assert file.checksum.startswith("ba7816bf")


def test_every_figure_is_described_and_drawn_on_demand() -> None:
    described = [tag for tag in friction().of("div") if tag.get("class") == "drawing"]
    assert {tag["role"] for tag in described} == {"group"}  # it has buttons, which an img has not
    assert len(described) == len(friction().figures()) >= 10
    assert all(tag["aria-label"] for tag in described)
    ladder = next(tag["aria-label"] for tag in described if "noise floor" in tag["aria-label"])
    assert "to 0.229 mrad" in ladder


def test_tables_and_headings_can_be_heard() -> None:
    assert all("scope" in tag for tag in friction().of("th"))
    assert len(friction().of("caption")) == len(friction().of("table"))
    levels = [int(tag[1]) for tag, _ in friction().elements if re.fullmatch("h[1-6]", tag)]
    assert levels[0] == 1
    assert max(np.diff(levels)) <= 1
    assert friction().of("html") == [{"lang": "en"}]


def test_a_sound_model_has_one_run_and_no_equations() -> None:
    page = Page(document_of(nothing_missing()))
    assert "demo_actuator explains these data" in page.text
    assert "No effect was added" in page.text
    names = [trace.get("name", "") for figure in page.figures()[:1] for trace in figure["data"]]
    assert [name.split(":")[0] for name in names if ": RMS " in name] == ["as given"]


def test_the_verdict_has_the_falling_error_beside_it() -> None:
    first = friction().figures()[0]
    assert "fitted data" in [trace.get("name") for trace in first["data"]]
    assert first["layout"]["yaxis"]["title"]["text"] == "RMS error (mrad)"
    assert first["layout"]["height"] < 300


def test_numbers_of_the_model_are_for_people() -> None:
    model = friction().text.partition("as model.toml, to six digits")[2].partition("What was")[0]
    assert "[transmission]" in model
    assert not re.search(r"\d\.\d{10,}", model)


def test_signals_that_repeat_each_other_are_drawn_and_told_once() -> None:
    model = load_model(demo.DATA / "demo_model.toml")
    whole = recording().window(0.0, 2.0)
    moved = simulate(model, whole.time, whole.motor_position)
    both = ("joint_torque", "motor_torque")
    torques = {name: 1.1 * moved[name] for name in both}
    found = comparison_of(replace(whole, signals={**whole.signals, **torques}))
    assert repeats(found.files) == {"joint_position": [], "joint_torque": ["motor_torque"]}
    page = Page(comparison_document(found, locate(found), origin()))
    assert "The motor torque repeats the joint torque at a fixed ratio" in page.text
    assert "Motor torque: " not in page.text
    titles = [figure["layout"].get("yaxis", {}).get("title", {}) for figure in page.figures()]
    drawn = [title.get("text", "").replace("<br>", " ") for title in titles]
    assert "joint torque (N·m)" in drawn
    assert "motor torque (N·m)" not in drawn


def test_an_error_that_the_noise_hides_is_not_drawn_alone() -> None:
    found = friction_found()
    last = found.steps[-1]
    hidden = replace(
        last, **{kind: _ten_times_noise(getattr(last, kind)) for kind in ("comparison", "heldout")}
    )
    page = Page(document_of(replace(found, steps=(*found.steps[:-1], hidden))))
    assert "lost in the noise and not drawn alone" in page.text
    assert "improved alone" in friction().text
    assert "improved alone" not in page.text


def _ten_times_noise(comparison: Comparison) -> Comparison:
    """The same, as if the noise were far above the error."""
    return Comparison(
        comparison.model,
        tuple(
            replace(
                file,
                signals={
                    name: replace(error, noise_ratio=0.05) for name, error in file.signals.items()
                },
            )
            for file in comparison.files
        ),
    )


def test_a_round_that_added_nothing_says_why_it_did_not() -> None:
    first = friction_found().rounds[0]
    nothing = replace(first, chosen=(), reason="no effect was taken")
    page = Page(document_of(friction_found(rounds=(nothing,))))
    assert "Nothing was added although only 0 % are left for “none of them”" in page.text
    assert "Nothing was added although" not in friction().text


def test_long_tables_may_break_on_paper() -> None:
    kinds = [
        tag["class"] for tag in friction().of("div") if (tag.get("class") or "")[:6] == "scroll"
    ]
    assert {"scroll", "scroll long"} == set(kinds)


def test_a_learned_term_is_offered_with_its_law() -> None:
    page = Page(document_of(something_unknown()))
    assert in_order(
        page.text,
        "Something is missing that no effect of the catalogue explains",
        "What the improved model still lacks",
        "What the learned term explains",
        "Learned torque (learned_torque)",
        "torque = -strength velocity^3",
        "offered, not added",
    )


def test_an_interrupted_diagnosis_says_so() -> None:
    stopped = "Coulomb friction is surely missing; the search was stopped before its end."
    found = friction_found(
        complete=False,
        sentence=stopped,
        remaining={},
        next_experiment=None,
        neighbours=(),
        would_show=(),
    )
    text = Page(document_of(found)).text
    assert stopped in text
    assert "This was not tested." in text


def test_without_held_out_data_there_is_one_line() -> None:
    found = friction_found()
    steps = tuple(replace(step, heldout=None) for step in found.steps)
    ladder = tuple(replace(step, heldout_rmse={}) for step in found.ladder)
    page = Page(document_of(replace(found, steps=steps, ladder=ladder)))
    assert "held-out data)" not in page.text
    names = [trace.get("name") for figure in page.figures() for trace in figure["data"]]
    assert "fitted data" in names
    assert "held-out data" not in names


def test_a_state_that_cannot_be_linearised_is_a_sentence(monkeypatch) -> None:
    whole = answers.linearise

    def without_the_first(model: Model, state: str, **others: object) -> object:
        if state == "I":
            raise LinearisationError("demo: no equilibrium is found")
        return whole(model, state, **others)

    monkeypatch.setattr(answers, "linearise", without_the_first)
    page = Page(document_of(friction_found()))
    assert "There is no linear model of state I: demo: no equilibrium is found." in page.text
    assert "upper tendon slack" in page.text


# ---- of a comparison ---------------------------------------------------------------------------


def test_a_comparison_has_the_sections_that_apply() -> None:
    page = Page(document_of_comparison(recording()))
    anchors = [tag["id"] for tag in page.of("h2")]
    assert anchors == ["verdict", "overlay", "live", "where", "data", "papers"]
    assert in_order(
        page.text,
        "The joint position error of demo_actuator is 37.5 mrad RMS",
        "the fit is 95.1 %",
        "demo_fit.csv: torque over deflection",
        "torque that the model lacks",
    )
    assert "Kass" not in page.text


def test_a_static_curve_is_spoken_of_as_deflection() -> None:
    model = load_model(demo.DATA / "demo_model.toml")
    deflection = np.linspace(-0.15, 0.15, 300)
    torque = -1.1 * characteristic_torque(deflection, model.transmission)
    noise = 1e-4 * np.random.default_rng(1).standard_normal(300)
    curve = Measurement(
        1000.0 * np.arange(300),
        np.zeros(300),
        {"joint_position": deflection + noise},
        load_torque=torque,
        static=True,
        name="curve.csv",
    )
    page = Page(document_of_comparison(curve))
    assert "The deflection error of demo_actuator" in page.text
    assert "static curve" in page.text
    titles = [figure["layout"]["xaxis"]["title"]["text"] for figure in page.figures()[:1]]
    assert titles == ["deflection (rad)"]


def test_of_many_recordings_some_are_drawn() -> None:
    short = recording().window(0.0, 1.0)
    page = Page(document_of_comparison(*[replace(short, name=f"{n}.csv") for n in range(10)]))
    assert "2 more recordings are not drawn" in page.text
    assert "How 9.csv was read" in page.text


# ---- what it never does ------------------------------------------------------------------------


def evil() -> str:
    """Every name that a user gives is markup."""
    found = friction_found()
    steps = tuple(
        replace(step, comparison=_renamed(step.comparison), heldout=_renamed(step.heldout))
        for step in found.steps
    )
    changed = replace(
        found,
        given=found.given.model_copy(update={"name": EVIL}),
        model=found.model.model_copy(update={"name": EVIL}),
        steps=steps,
        comparison=steps[-1].comparison,
        ladder=tuple(replace(step, title=EVIL) for step in found.ladder),
    )
    where = locate(changed.steps[0].comparison)
    marked = replace(origin(), command=EVIL, advice=(EVIL, f"  {EVIL}"))
    return diagnosis_document(changed, where, marked)


def _renamed(comparison: Comparison) -> Comparison:
    files = tuple(
        replace(file, measurement=replace(file.measurement, name=EVIL, notes=(EVIL,)))
        for file in comparison.files
    )
    return Comparison(comparison.model, files)


def texts(tree: object) -> Iterator[str]:
    """All that a figure may show; an id of what was zoomed is compared, not shown."""
    if isinstance(tree, dict):
        for key, value in tree.items():
            if key != "uirevision":
                yield from texts(value)
    elif isinstance(tree, list):
        for value in tree:
            yield from texts(value)
    elif isinstance(tree, str):
        yield tree


def test_names_of_users_are_never_markup() -> None:
    page = Page(evil())
    assert "window.hacked" in page.text
    assert page.of("img") == []
    assert len(page.scripts) == len(friction().scripts)
    assert not any("hacked" in script for script in page.scripts if not script.startswith("{"))
    shown = [text for figure in page.figures() for text in texts(figure)]
    assert any("&lt;script&gt;" in passage for passage in shown)
    # plotly would take it for an element
    assert not any("<script" in passage or "<img" in passage for passage in shown)


def test_nothing_is_fetched_from_anywhere() -> None:
    (policy,) = (tag["content"] for tag in friction().of("meta") if "http-equiv" in tag)
    assert policy.startswith("default-src 'none'; script-src 'sha256-")
    assert "http" not in policy
    for _, attributes in friction().elements:
        assert not {"src", "srcset", "action", "data", "poster"} & attributes.keys()
        assert (attributes.get("href") or "#").startswith("#")
    assert friction().of("link") == []


def test_long_recordings_make_no_large_file() -> None:
    time = np.arange(100_000) / 500.0
    motor = 0.3 * np.sin(3.0 * time) + 0.1 * np.sin(17.0 * time)
    model = load_model(demo.DATA / "demo_model.toml")
    noise = 2e-4 * np.random.default_rng(2).standard_normal(len(time))
    machine = model.with_effect("coulomb_friction", {"torque": 0.3})
    signals = {"joint_position": simulate(machine, time, motor)["joint_position"] + noise}
    page = document_of_comparison(Measurement(time, motor, signals, name="long.csv"))
    figures = len(Page(page).figures())
    assert len(page) < PLOTLY.stat().st_size + 100_000 + figures * LARGEST_FIGURE


# ---- in a browser ------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def chromium():
    if not CHROMIUM.exists():
        pytest.skip("chromium is not installed")
    playwright = pytest.importorskip("playwright.sync_api")
    with playwright.sync_playwright() as running:
        chromium = running.chromium.launch(executable_path=str(CHROMIUM), args=["--no-sandbox"])
        yield chromium
        chromium.close()


@pytest.fixture
def browser(chromium):
    """Started once; the pages of a test are closed after it."""
    yield chromium
    for context in chromium.contexts:
        context.close()


DRAWN = "document.querySelectorAll('.drawing .main-svg').length"


# in CI the test of words below looks at a light page
@pytest.mark.parametrize("scheme", [pytest.param("light", marks=pytest.mark.slow), "dark"])
def test_a_browser_draws_all_and_asks_for_nothing(browser, tmp_path: Path, scheme: str) -> None:
    path = tmp_path / "report.html"
    path.write_text(evil(), encoding="utf-8")
    page = browser.new_page(viewport={"width": 1280, "height": 800}, color_scheme=scheme)
    asked: list[str] = []
    said: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    page.on("console", lambda message: said.append(message.text))
    page.on("pageerror", lambda error: said.append(str(error)))
    page.goto(path.as_uri())
    for drawing in page.query_selector_all(".drawing"):
        drawing.scroll_into_view_if_needed()
        drawing.wait_for_selector(".main-svg")
    opened = page.evaluate("performance.getEntriesByName('first-contentful-paint')[0].startTime")
    print(f"{scheme}: text after {opened:.0f} ms, file of {path.stat().st_size / 1e6:.1f} MB")
    assert [address for address in asked if not address.startswith("data:")] == [path.as_uri()]
    assert said == []
    assert page.evaluate("window.hacked") is None
    ink = page.evaluate("getComputedStyle(document.querySelector('.xtick text')).fill")
    assert (ink == "rgb(240, 240, 240)") == (scheme == "dark")


def test_on_paper_all_figures_are_there_before_anybody_scrolled(browser, tmp_path: Path) -> None:
    path = tmp_path / "report.html"
    path.write_text(document_of(friction_found()), encoding="utf-8")
    page = browser.new_page(viewport={"width": 1280, "height": 800}, color_scheme="dark")
    page.goto(path.as_uri())
    before = page.evaluate(f"{DRAWN}")
    page.evaluate("window.addEventListener('beforeprint', () => { window.onpaper = " + DRAWN + "})")
    paper = page.pdf(prefer_css_page_size=True)
    assert paper.startswith(b"%PDF")
    assert page.evaluate("window.onpaper") == 3 * len(friction().figures()) > before


def test_words_of_figures_can_be_read_wide_narrow_and_on_paper(browser, tmp_path: Path) -> None:
    """With the longest names that there are."""
    figure_texts = pytest.importorskip("figure_texts")
    path = tmp_path / "report.html"
    path.write_text(document_of(figure_texts.with_long_names()), encoding="utf-8")
    page = browser.new_page(viewport={"width": 1280, "height": 800})
    page.goto(path.as_uri())
    found = {}
    for width in (1280, 390):
        page.set_viewport_size({"width": width, "height": 800})
        for drawing in page.query_selector_all(".drawing"):
            drawing.scroll_into_view_if_needed()
            drawing.wait_for_selector(".main-svg")
        page.wait_for_timeout(300)  # plotly draws anew what has another width
        found[width] = figure_texts.faults(page)
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    page.set_viewport_size({"width": 680, "height": 960})  # between the margins of A4
    page.emulate_media(media="print")
    page.evaluate("window.dispatchEvent(new Event('beforeprint'))")
    found["paper"] = figure_texts.faults(page)
    assert page.evaluate(DRAWN) >= 3 * len(friction().figures())
    assert {where: faults for where, faults in found.items() if faults} == {}


def test_a_word_that_lies_over_another_or_is_cut_is_found(browser) -> None:
    figure_texts = pytest.importorskip("figure_texts")
    text = '<text x="{}" y="40">{}</text>'
    words = [text.format(10, "one"), text.format(20, "two"), text.format(190, "long")]
    page = browser.new_page()
    page.set_content(
        '<div class="js-plotly-plot" style="width:200px;height:80px"><svg class="main-svg" '
        f'width="200" height="80" style="overflow:visible">{"".join(words)}</svg></div>'
    )
    found = [fault.partition(" (")[0] for fault in figure_texts.faults(page)]
    assert found == ["one lies over two", "cut: long"]


def test_the_figures_are_made_for_the_script_that_draws_them() -> None:
    drawn_by = re.search(r"plotly\.js [^\n]*v([\d.]+)", PLOTLY.read_text("utf-8")[:500])
    assert drawn_by is not None
    made_for = re.search(r"plotly\.js v([\d.]+)", get_plotlyjs()[:500])
    assert made_for is not None
    assert drawn_by[1].split(".")[0] == made_for[1].split(".")[0]
