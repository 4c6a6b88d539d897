"""An effect typed on the page: tried, kept, searched with, and never run unasked."""

import builtins
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path
from threading import Event

import pytest

pytest.importorskip("dash")

from elastic_tendon import demo, effects
from elastic_tendon.actuator.parameters import load_model, quantities
from elastic_tendon.app import own_effects, ranking, takeaway, walk
from elastic_tendon.app.document import Document, OwnEffect, Source, Version, new_document
from elastic_tendon.app.own_effects import REFUSED, template, typed
from elastic_tendon.app.server import Served, listen
from elastic_tendon.app.session_file import open_session
from elastic_tendon.app.workspace import Cache, Failure, Workspace
from elastic_tendon.effects import CATALOGUE
from elastic_tendon.effects.registry import Registry
from elastic_tendon.errors import EffectError
from searched_session import served_session

# counts how often a text was run in this process
RAN = "import builtins; builtins.runs = getattr(builtins, 'runs', 0) + 1\n"
MODEL = load_model(demo.DATA / "demo_model.toml")
FILES = {"fit": demo.DATA / "demo_fit.csv"}
SOURCES = (Source(key="fit", name="demo_fit.csv", window=(0.0, 1.0)),)


@pytest.fixture(autouse=True)
def registry(monkeypatch) -> Registry:
    """The catalogue alone, as in an app that was just started."""
    fresh = Registry(CATALOGUE)
    monkeypatch.setattr(effects, "BY_ID", fresh)
    monkeypatch.setattr(own_effects, "PATIENCE", 1800.0)  # s; a machine that tests may be busy
    return fresh


@pytest.fixture
def runs(monkeypatch) -> Callable[[], int]:
    """How often texts that begin with RAN were run."""
    monkeypatch.setattr(builtins, "runs", 0, raising=False)
    return lambda: builtins.runs


def quiet(_words: str, _share: float) -> None:
    pass


def with_effect(text: str) -> Document:
    """A session whose model has an effect that is loaded."""
    effect = typed(text, shared=False)
    model = MODEL.with_effect(effect.id, None)
    document = new_document(MODEL, SOURCES).with_own_effect(OwnEffect(id=effect.id, text=text))
    return document.adding(Version(id="", parent="1", title="+ own", model=model.to_toml()))


def started_anew(monkeypatch) -> None:
    monkeypatch.setattr(effects, "BY_ID", Registry(CATALOGUE))


# ---- trying --------------------------------------------------------------------------------------


def test_the_template_works_as_it_is() -> None:
    effect = typed(template(), shared=False)
    assert (effect.id, effect.title) == ("my_effect", "My effect")
    assert "on: it can be added by hand, and every search tries it" in own_effects.welcome(effect)


@pytest.mark.parametrize(
    ("replaced", "by", "words", "quoted"),
    [
        ("def equations(", "def equations((", "not valid Python", "def equations(("),
        ("* absolute(", "* absoute(", "name 'absoute' is not defined", "absoute(at.velocity))"),
        (
            'id="my_effect"',
            'id="gravity_load"',
            "the catalogue has an effect",
            'id="gravity_load",',
        ),
    ],
)
def test_a_fault_is_told_with_its_line(replaced: str, by: str, words: str, quoted: str) -> None:
    text = template().replace(replaced, by)
    with pytest.raises(EffectError) as caught:
        typed(text, shared=False)
    sentence, line = own_effects.fault(caught.value, text)
    number = str(caught.value.line)
    assert sentence.startswith(f"your effect, line {number}: ")
    assert words in sentence
    assert line.startswith(f"{number} │ ")
    assert line.endswith(quoted)
    assert typed(template(), shared=False).id == "my_effect"  # it can be mended


def test_a_fault_without_a_line_quotes_none() -> None:
    with pytest.raises(EffectError) as caught:
        typed("x = 1\n", shared=False)
    assert own_effects.fault(caught.value, "x = 1\n")[1] == ""


def test_a_loop_without_end_does_not_hang_the_app(monkeypatch) -> None:
    monkeypatch.setattr(own_effects, "PATIENCE", 0.5)
    with pytest.raises(EffectError, match="loop without end"):
        typed("while True:\n    pass\n", shared=False)


def test_what_ends_python_does_not_end_the_app() -> None:
    with pytest.raises(EffectError, match="it ends Python"):
        typed("import os\nos._exit(3)\n", shared=False)


def test_a_changed_text_takes_another_id() -> None:
    typed(template(), shared=False)
    with pytest.raises(EffectError, match="my_effect already; give this one another id"):
        typed(template() + "# changed\n", shared=False)


def test_where_others_are_let_in_nothing_is_run(runs) -> None:
    with pytest.raises(EffectError, match="lets other machines in") as caught:
        typed(RAN + template(), shared=True)
    assert own_effects.fault(caught.value, "") == (f"{REFUSED}.", "")
    assert runs() == 0


# ---- in the session ------------------------------------------------------------------------------


def test_it_is_a_candidate_of_its_own_session_only() -> None:
    document, other = with_effect(template()), new_document(MODEL, SOURCES)
    for own, known in ((document.at("1"), True), (other, False)):
        data = walk.given_data(own, own.version, FILES).compute(Cache(), quiet)
        assert ("my_effect" in data.candidates) is known
        assert ("my_effect" in {one["value"] for one in ranking.choices(own, MODEL)}) is known


def test_what_was_searched_without_it_is_searched_again() -> None:
    before = new_document(MODEL, SOURCES)
    key = before.data_key()
    assert before.search_key() == key
    fitted = before.adding(
        Version(id="", parent="1", title="", model=MODEL.to_toml(), fitted_to=key, searched=key)
    )
    assert walk.was_searched(fitted, fitted.version)
    after = fitted.with_own_effect(OwnEffect(id="my_effect", text=template()))
    assert walk.is_fitted(after, after.version)
    assert not walk.was_searched(after, after.version)
    for make, same in ((walk.ranked, False), (walk.answer, True)):
        keys = [make(one, one.version, FILES).key for one in (fitted, after)]
        assert (keys[0] == keys[1]) is same


def test_a_text_that_is_nowhere_else_is_not_overwritten() -> None:
    document = with_effect(template() + "# mine\n")
    for text, lost in (
        ("\n", False),
        (template(), False),
        (template() + "# mine", False),
        (template() + "# changed", True),
    ):
        assert own_effects.would_be_lost(text, document) is lost


def test_it_is_removed_unless_a_version_has_it() -> None:
    document = with_effect(template())
    with pytest.raises(EffectError, match=r"^my_effect is in \+ own; delete that in the step Add"):
        document.without_own_effect("my_effect")
    removed = document.without("2").without_own_effect("my_effect")
    assert removed.own_effects == ()
    assert "my_effect" not in {one["value"] for one in ranking.choices(removed, MODEL)}


def test_the_id_of_a_removed_effect_is_free_once_no_session_has_it(registry) -> None:
    document, changed = with_effect(template()), template().replace("drag torque at", "air at")
    workspace = Workspace(document.without("2"), FILES)
    try:
        first, second = workspace.open(None), workspace.open(None)
        before = quantities(["my_effect"])[-1].meaning
        drawn = walk.shows("my_effect")
        second.cache.put(drawn, Failure("as it was"))
        workspace.forget_effect(first, "my_effect")
        assert first.document.own_effects == ()
        assert "my_effect" in registry  # the other session has it
        workspace.forget_effect(second, "my_effect")
        assert "my_effect" not in registry
        assert second.cache.find(drawn) is None
        assert typed(changed, shared=False).id == "my_effect"
        after = quantities(["my_effect"])[-1].meaning
        assert (before, after) == ("drag torque at 1 rad/s", "air at 1 rad/s")
    finally:
        workspace.close()


def test_what_may_be_in_use_is_not_removed() -> None:
    workspace, go_on = Workspace(with_effect(template()).without("2"), FILES), Event()
    session = workspace.open(None)
    try:
        session.start("effect", "searching", lambda _: go_on.wait(60.0) and None)
        with pytest.raises(EffectError, match="something is being computed"):
            workspace.forget_effect(session, "my_effect")
        assert session.document.own_effects
    finally:
        go_on.set()
        workspace.close()


def test_the_command_that_comes_to_the_same_names_its_file() -> None:
    assert "--effect my_effect.py" in takeaway._command(with_effect(template()))


# ---- opening a session ---------------------------------------------------------------------------


def served(document: Document, path: Path) -> AbstractContextManager[Served]:
    """The app with a session's file that another one wrote."""
    if not path.exists():
        file = open_session(path)
        file.begin(document, FILES)
        file.close()
    return served_session(open_session(path))


def test_a_session_of_somebody_else_is_opened_without_running_it(
    tmp_path: Path, runs, monkeypatch
) -> None:
    document = with_effect(RAN + template())
    assert runs() == 1
    started_anew(monkeypatch)
    path = tmp_path / "theirs.session"
    file = open_session(path)
    file.begin(document, FILES)
    before = file.reopen()
    file.close()
    assert before is not None
    assert before.document == document
    assert before.notes == (f"{path} brings effects of its own; the page runs them when asked to",)
    assert [own.id for own in own_effects.waiting(document)] == ["my_effect"]
    assert runs() == 1
    own_effects.run_all(before.document, shared=False)
    assert runs() == 2
    assert own_effects.waiting(document) == ()


def test_what_the_command_line_named_is_not_asked_for_again(tmp_path: Path, monkeypatch) -> None:
    document = with_effect(template())
    started_anew(monkeypatch)
    file = tmp_path / "my_effect.py"
    file.write_text(document.own_effects[0].text)
    effects.load(file)
    assert own_effects.waiting(document) == ()


def test_an_effect_of_a_session_that_fails_here_is_told_by_its_file(monkeypatch) -> None:
    document = with_effect(template())
    broken = OwnEffect(id="my_effect", text="import nowhere\n")
    started_anew(monkeypatch)
    with pytest.raises(EffectError, match=r"^my_effect\.py, line 1: .*nowhere"):
        own_effects.run_all(document.model_copy(update={"own_effects": (broken,)}), shared=False)


def test_it_is_written_kept_and_asked_for_on_the_page(tmp_path: Path, runs, monkeypatch) -> None:
    pytest.importorskip("playwright")
    from app_driver import CHROMIUM, Walk, browser

    if CHROMIUM is None:
        pytest.skip("chromium is not installed")
    path = tmp_path / "mine.session"
    with browser() as chromium:
        with served(new_document(MODEL, SOURCES), path) as app:
            tab = Walk(chromium, app.url)
            tab.step("Which effect")
            tab.settle()
            tab.page.get_by_text("Write an effect of your own").click()
            editor = tab.page.get_by_label("The effect, in Python")
            editor.fill(template().replace("* absolute(", "* absoute("))
            tab.button("Try it").click()
            tab.page.get_by_text("name 'absoute' is not defined").wait_for()
            editor.fill(RAN + template())
            tab.button("Try it").click()
            tab.button("Add My effect").wait_for()
            tab.settle()
            assert tab.page.locator("#own-effect-refusal").inner_text() == ""
            written = tab.save(tab.button("Download my_effect.py"), tmp_path)
            assert written.read_text() == RAN + template()
            tab.page.get_by_role("button", name="Remove my_effect").click()
            tab.page.get_by_text("my_effect is no longer known to this session").wait_for()
            tab.settle()
            assert tab.document()["own_effects"] == []
            assert tab.button("Add My effect").count() == 0
            assert editor.input_value() == RAN + template()
            editor.fill(RAN + template() + "# changed\n")  # under the id that is free again
            tab.button("Try it").click()
            tab.button("Add My effect").wait_for()
            tab.settle()
            tab.close()
            assert tab.faults == []
        assert runs() == 2
        started_anew(monkeypatch)
        with served(new_document(MODEL), path) as app:
            page = chromium.new_page()
            page.goto(app.url)
            page.get_by_role("heading", name="This session brings effects of its own").wait_for()
            assert "def equations(" in page.locator("#gate pre").inner_text()
            assert page.locator("section.step:visible").count() == 0
            assert runs() == 2
            page.get_by_role("button", name="Run them and open the session").click()
            page.locator("section.step:visible h2").wait_for()
            assert runs() == 3
            page.close()


def test_an_app_that_others_can_reach_runs_nothing_of_a_session_either(runs, monkeypatch) -> None:
    document = with_effect(RAN + template())
    started_anew(monkeypatch)
    for address, shared in (("127.0.0.1", False), ("0.0.0.0", True)):
        app = listen(new_document(MODEL), {}, address=address)
        app.close()
        assert app.workspace.shared is shared
    with pytest.raises(EffectError, match="lets other machines in"):
        own_effects.run_all(document, shared=True)
    assert runs() == 1
