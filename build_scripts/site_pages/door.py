"""The reference of the public door: every name, by the room that it lives in."""

import inspect
from importlib import import_module
from pathlib import Path
from types import ModuleType

import elastic_tendon as et
from elastic_tendon import version
from site_pages import Pages
from site_pages.markdown import code, from_docstrings, from_rst, sidebar, table

PACKAGE = Path(et.__file__).parent
GENERAL = "general"  # the page of what lives in no room
ELSEWHERE = "BaseModel, StateSpace, Exception, Enum, int"  # whose members others document


def pages() -> Pages:
    """A page for each room, and one of all names."""
    public = {name: getattr(et, name) for name in dir(et)}
    rooms: dict[str, list[str]] = {}
    for name, thing in public.items():
        rooms.setdefault(_room(thing), []).append(name)
    for room, names in sorted(rooms.items()):
        about = inspect.getdoc(import_module(f"elastic_tendon.{room}")) if room != GENERAL else ""
        shown = from_docstrings(_directive(public[name], name) for name in names)
        yield f"reference/{room}.md", f"# {_title(room)}\n\n{from_rst(about or '')}\n\n{shown}"
    yield "reference/index.md", _overview(public, sorted(rooms))


def _overview(public: dict[str, object], rooms: list[str]) -> str:
    example = (et.__doc__ or "").partition("\n\n")[2].partition("\n\nWhat")[0]
    rows = [
        (f"{{py:obj}}`{name} <elastic_tendon.{name}>`", _first_line(thing))
        for name, thing in sorted(public.items(), key=lambda item: item[0].lower())
    ]
    parts = ("# Python", code(inspect.cleandoc(example), "python"), table(("name", ""), rows))
    return "\n\n".join([*parts, sidebar(rooms)])


def _room(thing: object) -> str:
    """The package that a public name lives in."""
    module = thing.__name__ if isinstance(thing, ModuleType) else getattr(thing, "__module__", "")
    room = module.split(".")[1] if module.startswith("elastic_tendon.") else GENERAL
    return room if (PACKAGE / room).is_dir() else GENERAL


def _title(room: str) -> str:
    return "FMU" if room == "fmu" else room.capitalize()


def _directive(thing: object, name: str) -> str:
    """What shows a public thing."""
    if inspect.isfunction(thing):
        return f".. autofunction:: {name}"
    if inspect.isclass(thing):
        return f".. autoclass:: {name}\n   :members:\n   :inherited-members: {ELSEWHERE}"
    text = _about(thing).replace("\n", "\n   ")
    functions = vars(thing).items() if isinstance(thing, ModuleType) else ()
    inside = [
        f".. autofunction:: elastic_tendon.{name}.{function}"
        for function, value in functions
        if inspect.isfunction(value) and value.__module__ == getattr(thing, "__name__", "")
    ]
    return "\n\n".join([f".. py:data:: {name}\n\n   {text}", *inside])


def _first_line(thing: object) -> str:
    return from_rst(_about(thing).partition("\n")[0])


def _about(thing: object) -> str:
    """Docstring; a text has only that of the module it stands in."""
    return inspect.getdoc(version if isinstance(thing, str) else thing) or ""
