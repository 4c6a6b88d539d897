"""Effects of the user's own: same powers as built-in ones, refused with line and reason."""

import inspect
import shutil
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from fmpy import simulate_fmu
from typer.testing import CliRunner

from elastic_tendon import cli, effects
from elastic_tendon.actuator.interfaces import kinds_with
from elastic_tendon.actuator.model import build
from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.effects import CATALOGUE
from elastic_tendon.effects.registry import GROUP, Registry
from elastic_tendon.errors import EffectError, ModelError, SimulationError
from elastic_tendon.estimation.add import _starts
from elastic_tendon.native.library import structure_key
from elastic_tendon.simulation.simulate import simulate

MODEL = "biorob_x4_joint_3"
RIPPLE = Path(__file__).parents[2] / "examples" / "own_effect" / "tooth_ripple.py"
RAN = "import builtins; builtins.runs = getattr(builtins, 'runs', 0) + 1\n"  # counts, see `runs`

GOOD = """
from elastic_tendon.effects.base import Contribution, Effect, Parameter, Relation, Slot, State
from elastic_tendon.effects.symbolic import where

def equations(at, p, state, mode):
    yielding = where(mode.loading, 1 - state.lag, 1)
    return Contribution(
        value=p.force * state.lag,
        rates={"lag": at.rate / p.length * yielding},
        thresholds={"loading": state.lag * at.rate},
    )

EFFECT = Effect(
    id="lagging",
    title="Lag",
    slot=Slot.SPRING_LAW,
    physics="Physics.",
    in_data="In data.",
    parameters=(
        Parameter("force", "N", "of the lag", null=0.0, lower=0.0, upper=10.0, typical=1.0),
        Parameter("length", "m", "of the lag", null=1.0, lower=0.1, upper=2.0, typical=0.5,
            shape=True),
    ),
    equations=equations,
    reference="Reference.",
    states=(State("lag", "1", "of the force", nominal=1.0),),
    relations=(Relation("loading", "force grows"),),
)
"""


@pytest.fixture(autouse=True)
def registry(monkeypatch):
    """The catalogue alone, whatever a test loads."""
    fresh = Registry(CATALOGUE)
    monkeypatch.setattr(effects, "BY_ID", fresh)
    return fresh


@pytest.fixture
def runs(monkeypatch):
    """How often files that begin with RAN were run."""
    import builtins

    monkeypatch.setattr(builtins, "runs", 0, raising=False)
    return lambda: builtins.runs


@pytest.fixture
def run(monkeypatch, tmp_path):
    """Call the command in an empty folder, as a new process would: only the catalogue is known."""
    monkeypatch.chdir(tmp_path)

    def run(*arguments):
        monkeypatch.setattr(effects, "BY_ID", Registry(CATALOGUE))
        return CliRunner().invoke(cli.app, list(arguments), env={"COLUMNS": "200"})

    return run


def line_with(text: str, part: str) -> int:
    (line,) = (n for n, line in enumerate(text.splitlines(), 1) if part in line)
    return line


def written(folder: Path, text: str, name: str = "my_effect.py") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def message(path: Path) -> str:
    with pytest.raises(EffectError) as caught:
        effects.load(path)
    assert "\n" not in str(caught.value)
    return str(caught.value)


# ---- same powers as a built-in -------------------------------------------------------------


@pytest.mark.parametrize("builtin", CATALOGUE, ids=lambda effect: effect.id)
def test_file_of_a_builtin_effect_gives_the_same_equations(builtin, tmp_path):
    text = Path(inspect.getfile(builtin.equations)).read_text(encoding="utf-8")
    renamed = text.replace(f'id="{builtin.id}"', f'id="own_{builtin.id}"')
    own = effects.load(written(tmp_path, renamed))
    kind = kinds_with(builtin.slot)[0]
    expected, found = build((builtin.id,), kind), build((own.id,), kind)
    for part in ("rates", "outputs", "indicators", "next_modes", "reset"):
        assert str(getattr(found, part)) == str(getattr(expected, part))


def test_own_effect_goes_through_every_command(run):
    own = ("--effect", str(RIPPLE))
    assert "tooth_ripple" in run("effects", *own).stdout
    assert "effects.tooth_ripple.phase" in run("effects", "tooth_ripple", *own).stdout
    for command in (
        ("add", MODEL, "tooth_ripple", "-o", "belt.toml"),
        ("design", "belt.toml"),
        ("simulate", "belt.toml", "-o", "out.csv"),
        ("compare", "belt.toml", "out.csv", "--json", "c.json"),
        ("export", "belt.toml", "-o", "belt.fmu"),
    ):
        done = run(*command, *own)
        assert done.exit_code == 0, done.output
    table = pd.read_csv("out.csv")
    names = ("time_s", "motor_position_rad", "load_torque_Nm")
    inputs = np.zeros(len(table), [(name.rsplit("_", 1)[0], float) for name in names])
    for name in names:
        inputs[name.rsplit("_", 1)[0]] = table[name]
    step = table["time_s"][1]
    ends = {"stop_time": 100 * step, "output_interval": step}
    motion = simulate_fmu("belt.fmu", input=inputs, **ends)
    plain = simulate_fmu(
        "belt.fmu", input=inputs, **ends, start_values={"effects.tooth_ripple.amplitude": 0.0}
    )
    assert np.abs(motion["joint_position"] - plain["joint_position"]).max() > 1e-5


def test_own_effect_is_fitted(run):
    own = ("--effect", str(RIPPLE))
    effects.load(RIPPLE)
    machine = load_model(MODEL).with_effect("tooth_ripple", {"amplitude": 0.004, "phase": 1.0})
    Path("machine.toml").write_text(machine.to_toml())
    assert run("simulate", "machine.toml", "-o", "all.csv", *own).exit_code == 0
    pd.read_csv("all.csv").iloc[:1500].to_csv("out.csv", index=False)
    done = run("add", MODEL, "tooth_ripple", "out.csv", "-o", "found.toml", *own)
    assert done.exit_code == 0, done.output
    effects.load(RIPPLE)
    found = load_model("found.toml").effects["tooth_ripple"]
    assert found == pytest.approx(machine.effects["tooth_ripple"], rel=0.02)


@pytest.mark.parametrize("command", ["simulate", "export", "design", "compare", "add", "effects"])
def test_every_command_that_takes_a_model_takes_own_effects(run, command):
    assert "--effect" in run(command, "--help").stdout


def test_changed_file_is_another_library(tmp_path, monkeypatch):
    path = written(tmp_path, GOOD)
    effects.load(path)
    before = structure_key(("lagging",))
    assert structure_key(("lagging",)) == before
    written(tmp_path, GOOD.replace("1 - state.lag", "2 - state.lag"))
    monkeypatch.setattr(effects, "BY_ID", Registry(CATALOGUE))
    effects.load(path)
    assert structure_key(("lagging",)) != before


def test_order_is_that_of_the_ids_after_the_catalogue(tmp_path, registry):
    for name in ("zebra", "ant", "mole"):
        effects.load(written(tmp_path, GOOD.replace("lagging", name), f"{name}.py"))
    assert list(registry) == [*(effect.id for effect in CATALOGUE), "ant", "mole", "zebra"]
    model = load_model(MODEL)
    for name in ("mole", "coulomb_friction", "zebra", "ant"):
        model = model.with_effect(name, None)
    assert model.effect_ids == ("coulomb_friction", "ant", "mole", "zebra")


# ---- nothing is run that the user did not name ---------------------------------------------


def test_file_that_nobody_named_is_not_run(run, runs):
    Path("lagging.py").write_text(RAN + GOOD)
    Path("new.toml").write_text(load_model(MODEL).to_toml() + "[effects.lagging]\nforce = 1.0\n")
    for arguments in (("design", "new.toml"), ("effects",), ("effects", "lagging")):
        done = run(*arguments)
        assert done.exit_code == (0 if arguments == ("effects",) else 1)
    assert runs() == 0
    assert run("design", "new.toml", "--effect", "lagging.py").exit_code == 0
    assert runs() == 1


def test_model_with_an_effect_that_is_not_loaded_says_how(run):
    Path("new.toml").write_text(load_model(MODEL).to_toml() + "[effects.lagging]\nforce = 1.0\n")
    done = run("design", "new.toml")
    assert done.exit_code == 1
    (line,) = done.stderr.strip().splitlines()
    assert "new.toml: effects.lagging: there is no effect 'lagging'" in line
    assert "--effect FILE.py" in line
    assert "effects.load" in line
    assert all(effect.id in line for effect in CATALOGUE)


def test_same_file_twice_runs_once(tmp_path, runs):
    path = written(tmp_path, RAN + GOOD)
    link = tmp_path / "link.py"
    link.symlink_to(path)
    assert effects.load(path) is effects.load(str(path)) is effects.load(link)
    assert runs() == 1


def test_a_text_without_a_file_is_as_good_as_a_file(tmp_path, registry, runs) -> None:
    content = (RAN + GOOD).encode()
    effect = effects.load_text(content, "typed")
    assert effects.load_text(content, "again") is effect
    assert runs() == 1
    assert registry.from_texts == {"lagging"}
    assert registry.own_files(["lagging"]) == (("typed", content),)
    build(("lagging",), kinds_with(effect.slot)[0])
    by_file = effects.load(written(tmp_path, GOOD.replace("lagging", "filed")))
    assert registry.from_texts == {"lagging"}
    assert registry.loaded_from(GOOD.replace("lagging", "filed").encode()) is by_file


def test_what_is_forgotten_can_be_loaded_anew(registry) -> None:
    first = effects.load_text(GOOD.encode(), "typed")
    registry.forget(first.id)
    assert first.id not in registry
    assert registry.loaded_from(GOOD.encode()) is None
    again = effects.load_text(GOOD.replace("Physics.", "Other physics.").encode(), "typed")
    assert again.physics == "Other physics."
    assert registry.from_texts == {again.id}


def test_a_text_is_blamed_by_its_line_and_what_it_is_called() -> None:
    text = GOOD.replace("import where", "import wheer")
    with pytest.raises(EffectError) as caught:
        effects.load_text(text.encode(), "typed")
    assert str(caught.value).startswith(f"typed, line {line_with(text, 'wheer')}: ")
    assert caught.value.line == line_with(text, "wheer")


def test_refused_file_leaves_nothing_behind_and_can_be_mended(tmp_path, registry):
    before, modules = dict(registry), set(sys.modules)
    path = written(tmp_path, GOOD + "1 / 0\n")
    assert "ZeroDivisionError" in message(path)
    assert dict(registry) == before
    assert not [name for name in set(sys.modules) - modules if "elastic_tendon_effect" in name]
    written(tmp_path, GOOD)
    assert effects.load(path).id == "lagging"


# ---- broken files --------------------------------------------------------------------------

NOT_RUNNING = [  # replaced, by, line that is named, words
    ("def equations(", "def equations((", "def equations", "not valid Python"),
    ("where(mode.loading, 1", "where(mode.loading 1", "yielding =", "not valid Python"),
    ("Slot.SPRING_LAW", "Slot.SPRING", "slot=", "cannot be run: AttributeError"),
    ("import where", "import wheer", "symbolic", "cannot be run: ImportError"),
    ("from elastic_tendon.effects.symbolic", "from helper", "helper", "but no file beside it"),
    ('    reference="Reference.",\n', "", "EFFECT =", "'reference'"),
    ("def equations", "import sys; sys.exit(3)\ndef equations", "sys.exit", "SystemExit"),
    ("def equations", "raise KeyError\ndef equations", "raise", "cannot be run: KeyError"),
]
BAD_DECLARATIONS = [
    ('id="lagging"', 'id="joint_stop"', "id=", "the catalogue has an effect joint_stop"),
    ('id="lagging"', 'id="my effect"', "id=", "'my effect' cannot be a name"),
    ('id="lagging"', 'id="lambda"', "id=", "'lambda' cannot be a name"),
    ('id="lagging"', 'id=""', "id=", "'' cannot be a name"),
    ('id="lagging"', "id=3", "id=", "id of Effect is 3; a text is expected"),
    ('title="Lag"', 'title=" "', "title=", "title is empty"),
    ('"Physics."', '""', "physics=", "physics is empty"),
    ('"In data."', '""', "in_data=", "in_data is empty"),
    ('"Reference."', '""', "reference=", "reference is empty"),
    ("slot=Slot.SPRING_LAW", "slot=4", "slot=", "slot of Effect is 4; a Slot is expected"),
    ("null=0.0, lower=0.0, upper=10.0", "null=0, lower=11, upper=10", '"force"', "lower 11 is not"),
    ("null=1.0, lower=0.1", "null=0.0, lower=0.1", '"length"', "null 0 is outside 0.1 to 2"),
    ('"m", "of', '"mm", "of', '"length"', "unit 'mm' of length is not known"),
    ('"m", "of', '"", "of', '"length"', "unit '' of length is not known"),
    ('"length", "m"', '"force", "m"', '"force", "m"', "the name 'force' stands twice"),
    ('"length", "m"', '"le ngth", "m"', '"le ngth"', "'le ngth' cannot be a name"),
    ('"m", "of the lag"', '"m", ""', '"length"', "meaning of 'length' is empty"),
    ("upper=2.0", "upper='2'", '"length"', "upper of Parameter length is '2'; a number"),
    ("typical=0.5", "typical=0", '"length"', "length: typical is 0"),
    ("typical=0.5", "typical=50.0", '"length"', "length: typical 50 is outside 0.1 to 2"),
    ("typical=0.5", "typical=lambda s: s.mass", '"length"', "Sizes has no mass; it has force"),
    ("typical=0.5", "typical=lambda s: None", '"length"', "typical is None"),
    ("nominal=1.0),)", "nominal=1.0))", "states=", "(one alone needs a comma behind it)"),
    ("nominal=1.0)", "nominal=0.0)", '"lag", "1"', "nominal 0 is not"),
    ("nominal=1.0)", "nominal=1.0, start=1e999)", '"lag", "1"', "start inf is not finite"),
    ("nominal=1.0)", "nominal=1.0, start='rest')", '"lag", "1"', "a number or None is expected"),
    ('Relation("loading"', 'Relation("lag"', 'Relation("lag"', "the name 'lag' stands twice"),
    ("equations=equations", "equations=print", "equations=print", "not a function written in this"),
    ("equations=equations", "equations=where", "equations=where", "not a function written in this"),
    ("    states", "    refuses=lambda p: 1 / 0,\n    states", "refuses=", "ZeroDivisionError"),
    ("    states", "    refuses=lambda p: True,\n    states", "refuses=", "refuses returns True"),
    ("    states", '    refuses=lambda p: "No.",\n    states', "refuses=", "its own null values"),
    (
        "    states",
        "    cautions=lambda p: None,\n    states",
        "cautions=",
        "cautions returns None",
    ),
]
BAD_EQUATIONS = [
    ("p.force * state.lag", "p.fore * state.lag", "p.fore", "no fore is declared"),
    ("1 - state.lag, 1)", "1 - state.lag)", "yielding =", "TypeError"),
    ("p.force * state.lag", "p.force - 1", "def equations", "leave -1 where all parameters have"),
    ("at, p, state, mode", "at, p", "def equations", "takes 2 positional arguments but 4"),
    ("where(mode.loading, 1 - state.lag, 1)", "1 if at.rate > 0 else 0", "if at", "symbolic.where"),
    ("p.force * state.lag", "max(p.force, 0)", "max", "symbolic.where"),
    ("p.force *", "p.force * __import__('math').sin(at.rate) *", "def equations", "of math make"),
    ("value=p.force * state.lag", "value=[1, 2]", "def equations", "return 2 values as value"),
    ("value=p.force * state.lag", "value='force'", "def equations", "return 'force' as value"),
    ("value=p.force * state.lag", "value=None", "def equations", "return None as value"),
    (
        "value=p.force * state.lag",
        "value=1e999",
        "def equations",
        "value with a number that is not fin",
    ),
    (
        "return Contribution(",
        "return dict(",
        "def equations",
        "Contribution is expected in Slot.SP",
    ),
    ("SPRING_LAW", "JOINT_TORQUE", 'rates={"lag"', "Joint has no rate; it has position, velocity"),
    ('{"lag": at.rate', '{"lga": at.rate', "def equations", "give no rates for lag"),
    ('        rates={"lag": at.rate / p.length * yielding},\n', "", "def equations", "no rates"),
    ('{"loading": state', '{"slipping": state', "def equations", "no thresholds for loading"),
    (
        '{"lag": at.rate',
        '{"x": 0, "lag": at.rate',
        "def equations",
        "give rates for x, not declared",
    ),
    ("nominal=1.0)", "nominal=1.0, start=None)", "def equations", "no starts for lag"),
    ("p.force * state.lag", "at.rate * at.rate", "def equations", "value that is not affine in"),
    (
        "/ p.length * yielding",
        "* where(at.rate > 0, 1, 2)",
        "def equations",
        "rates['lag'] that is",
    ),
    ("p.force * state.lag", "__import__('casadi').SX.sym('y')", "def equations", "the symbol y"),
    (
        "p.force * state.lag",
        "__import__('casadi').SX.sym('y', 2)",
        "def equations",
        "return 2 values",
    ),
]


@pytest.mark.parametrize(
    ("part", "by", "at", "words"), [*NOT_RUNNING, *BAD_DECLARATIONS, *BAD_EQUATIONS]
)
def test_broken_file_is_refused_with_line_and_reason(part, by, at, words, tmp_path):
    assert GOOD.count(part) == 1
    text = GOOD.replace(part, by)
    path = written(tmp_path, text)
    found = message(path)
    assert found.startswith(f"{path}, line {line_with(text, at)}: "), found
    assert words in found, found


@pytest.mark.parametrize(
    ("slot", "answer", "words"),
    [
        ("DRY_FRICTION", "Contribution(at.velocity)", "FrictionBounds is expected in Slot.DRY_F"),
        ("TENDON_LOSS", "at.radius", "FrictionBounds is expected in Slot.TENDON_LOSS"),
        ("SPRING_MASS", "Contribution(at.parallel)", "HalfTensions is expected in Slot.SPRING_M"),
        ("DRY_FRICTION", "FrictionBounds(-p.x, None)", "return None as upper"),
        ("SPRING_MASS", "HalfTensions(0, 0, rates=[])", "return [] as rates; a dict is expected"),
        ("JOINT_SIGNAL", "None", "return None; Contribution is expected in Slot.JOINT_SIGNAL"),
        ("SIGNAL_DELAY", "Contribution(at.value)", "'NoneType' object has no attribute 'value'"),
    ],
)
def test_each_slot_wants_its_own_answer(slot, answer, words, tmp_path):
    text = f"""
from elastic_tendon.effects.base import *
EFFECT = Effect(
    "mine", "Title", Slot.{slot}, "Physics.", "In data.",
    (Parameter("x", "1", "of a test", 0, 0, 1, 1),),
    lambda at, p, state, mode: {answer},
    "Reference.",
)
"""
    found = message(written(tmp_path, text))
    assert f"line {line_with(text, 'lambda')}: the equations" in found
    assert words in found


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "it defines no EFFECT"),
        (b"x = 1\n", "it defines no EFFECT"),
        (b"EFFECT = {'id': 'x'}\n", "line 1: EFFECT is of type dict"),
        (b"import elastic_tendon as EFFECT\n", "EFFECT is of type module"),
        (b"\0\1\2", "not valid Python"),
        (b"x = '\xff'\n", "not valid Python"),
        (b"x = " + b"[" * 100_000, "not valid Python"),
    ],
)
def test_file_without_an_effect(content, words, tmp_path):
    path = tmp_path / "my_effect.py"
    path.write_bytes(content)
    found = message(path)
    assert found.startswith(str(path))
    assert words in found


def test_path_that_is_no_file(tmp_path):
    assert "there is no such file" in message(tmp_path / "none.py")
    assert "this is a folder" in message(tmp_path)
    with pytest.raises(EffectError, match="cannot be read"):
        effects.load("a\0b")


def test_two_files_with_the_same_id_are_refused(tmp_path):
    first = written(tmp_path, GOOD, "first.py")
    second = written(tmp_path, GOOD, "second.py")
    effects.load(first)
    found = message(second)
    assert found.startswith(f"{second}, line {line_with(GOOD, 'id=')}: {first} has an effect lag")


def test_an_effect_that_chatters_is_refused_and_does_not_hang(tmp_path):
    # dry friction written as a switch of its direction has no rest
    text = """
from elastic_tendon.effects.base import Contribution, Effect, Parameter, Relation, Slot
from elastic_tendon.effects.symbolic import where

EFFECT = Effect(
    "switched_friction", "Switched friction", Slot.JOINT_TORQUE, "Physics.", "In data.",
    (Parameter("torque", "N.m", "of the friction", 0, 0, 10, 1),),
    lambda at, p, state, mode: Contribution(
        where(mode.forward, -p.torque, p.torque), thresholds={"forward": at.velocity}
    ),
    "Reference.",
    relations=(Relation("forward", "the joint moves forward"),),
)
"""
    effects.load(written(tmp_path, text))
    model = load_model(MODEL).with_effect("switched_friction", {"torque": 2.0})
    time = np.linspace(0.0, 4.0, 401)
    with pytest.raises(SimulationError, match="to and fro without end"):
        simulate(model, time, 0.05 * np.sin(2.0 * time))


def test_file_that_changed_is_refused_until_a_new_start(tmp_path, registry):
    path = written(tmp_path, GOOD)
    effect = effects.load(path)
    written(tmp_path, GOOD + "# more\n")
    assert "start Python anew" in message(path)
    assert registry.content(effect) == GOOD.encode()


def test_starts_of_a_fit_that_an_effect_refuses_are_left_out(tmp_path):
    judge = "refuses=lambda p: 'Too much.' if p['force'] * p['length'] > 0.4 else '',\n    states"
    effects.load(
        written(tmp_path, GOOD.replace("    states", f"    {judge}").replace("0.5", "0.3"))
    )
    model = load_model(MODEL)
    starts = [start.effects["lagging"] for start in _starts(model, model, "lagging", {})]
    assert starts[0] == {"force": 0.0, "length": 1.0}
    forces = {round(start["force"], 9) for start in starts}
    assert forces == {0.0, 0.1, 1.0, 3.0}
    assert max(start["force"] * start["length"] for start in starts) <= 0.4


def test_refusal_that_fails_later_is_told_by_its_line(tmp_path):
    judge = "def refuses(p):\n    return '' if 1 / (2 - p['force']) else ''\n\nEFFECT ="
    text = GOOD.replace("EFFECT =", judge).replace("    states", "    refuses=refuses,\n    states")
    path = written(tmp_path, text)
    effects.load(path)
    with pytest.raises(EffectError, match=f"line {line_with(text, '1 / (2')}: .*ZeroDivision"):
        load_model(MODEL).with_effect("lagging", {"force": 2.0})


def test_command_tells_a_broken_file_on_one_line(run):
    Path("bad.py").write_text(GOOD.replace("def equations(", "def equations(("))
    done = run("design", MODEL, "--effect", "bad.py")
    assert done.exit_code == 1
    assert done.stdout == ""
    (line,) = done.stderr.strip().splitlines()
    assert line.startswith("elastic-tendon: bad.py, line ")


# ---- effects of installed packages ---------------------------------------------------------


@pytest.fixture
def install(tmp_path, monkeypatch):
    """Put a package with one effect on the path, as pip would."""
    monkeypatch.syspath_prepend(tmp_path)

    def install(module, text, name="lagging", package="lags", attribute=""):
        written(tmp_path, text, f"{module}.py")
        info = tmp_path / f"{package}-1.2.dist-info"
        info.mkdir()
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {package}\nVersion: 1.2\n")
        (info / "entry_points.txt").write_text(f"[{GROUP}]\n{name} = {module}{attribute}\n")
        monkeypatch.delitem(sys.modules, module, raising=False)

    yield install
    for name in [name for name in sys.modules if name.startswith("test_lags_")]:
        del sys.modules[name]


@pytest.mark.parametrize("attribute", ["", ":EFFECT"])
def test_installed_effect_is_imported_where_it_is_named(install, run, runs, attribute):
    install("test_lags_good", RAN + GOOD, attribute=attribute)
    listed = run("effects").stdout
    assert "lagging" in listed
    assert "lags 1.2" in listed
    assert run("design", MODEL).exit_code == 0
    assert runs() == 0
    assert run("add", MODEL, "lagging", "-o", "new.toml").exit_code == 0
    assert runs() == 1
    assert load_model("new.toml").effects["lagging"] == {"force": 1.0, "length": 0.5}
    assert "Physics." in run("effects", "lagging").stdout


def test_near_miss_of_an_installed_id_is_guessed(install, runs):
    install("test_lags_guess", RAN + GOOD)
    with pytest.raises(ModelError, match=r"did you mean lagging\?"):
        load_model(MODEL).with_effect("laging", None)
    assert runs() == 0


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (GOOD.replace("p.force *", "p.fore *"), "no fore is declared"),
        (GOOD.replace("def equations(", "def equations(("), "not valid Python"),
        ("1 / 0\n", "line 1: the effect lagging of lags 1.2 cannot be imported: ZeroDivisionError"),
        ("x = 1\n", "it defines no EFFECT"),
        (GOOD.replace('"lagging"', '"other"'), "its id is other, but its entry point is called"),
    ],
)
def test_broken_installed_effect_is_refused(install, text, words):
    install("test_lags_broken", text)
    with pytest.raises(EffectError) as caught:
        load_model(MODEL).with_effect("lagging", None)
    assert words in str(caught.value)
    assert "test_lags_broken.py" in str(caught.value)


def test_entry_point_without_a_module_is_refused(install, tmp_path):
    install("test_lags_gone", GOOD)
    (tmp_path / "test_lags_gone.py").unlink()
    with pytest.raises(EffectError, match="cannot be imported: there is no module"):
        load_model(MODEL).with_effect("lagging", None)


def test_two_packages_with_the_same_effect_are_refused(install):
    install("test_lags_one", GOOD)
    install("test_lags_two", GOOD, package="others")
    with pytest.raises(EffectError, match=r"lags 1\.2.* both have an effect lagging"):
        load_model(MODEL).with_effect("lagging", None)


def test_file_with_the_id_of_an_installed_effect_is_refused(install, tmp_path):
    install("test_lags_taken", GOOD)
    copy = Path(shutil.copy(tmp_path / "test_lags_taken.py", tmp_path / "mine.py"))
    assert "lags 1.2 has an effect lagging already" in message(copy)
