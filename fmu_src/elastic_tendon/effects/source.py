"""The Python file of a user's effect: read, run, and blamed by line for what is wrong with it."""

import ast
import hashlib
import inspect
import sys
import traceback
from collections.abc import Callable
from dataclasses import dataclass, is_dataclass
from pathlib import Path
from types import ModuleType, SimpleNamespace

from elastic_tendon.errors import EffectError

LONGEST_REASON = 200  # characters of another's message that a sentence repeats

_CLEARER = (  # part of a message -> in our words; {} is the message itself
    (
        "truth value of a CasADi",
        "a symbol is neither true nor false; choose with elastic_tendon.effects.symbolic.where, "
        "not with if, max or min",
    ),
    ("No module named", "{}; an effect may import installed packages, but no file beside it"),
)


@dataclass(frozen=True)
class Source:
    """Python as it was read or typed; what runs is `content`, whatever its file holds by then.

    `path` is what the user calls it, `file` what tracebacks call it.
    """

    path: Path
    file: str
    content: bytes

    def error(self, fault: str, line: int | None = None) -> EffectError:
        """Error that names the file, the line where there is one, and the fault."""
        place = str(self.path) if line is None else f"{self.path}, line {line}"
        return EffectError(f"{place}: {fault}", line)

    def blamed(self, error: BaseException, words: str, line: int | None = None) -> EffectError:
        """Error for an exception of the user's code, at the innermost line of this file.

        Parameters
        ----------
        error : what was raised
        words : what failed, such as "the file cannot be run"
        line : where no line of this file took part
        """
        if isinstance(error, SyntaxError) and error.filename == self.file:
            return self.error(f"this is not valid Python: {error.msg}", error.lineno or None)
        frames = traceback.extract_tb(error.__traceback__)
        lines = [frame.lineno for frame in frames if frame.filename == self.file]
        return self.error(f"{words}: {reason(error)}", lines[-1] if lines else line)

    def line_of(self, word: str) -> int | None:
        """Line that declares `word`: the last where it is a keyword or a text, else EFFECT's."""
        named, assigned = [], []
        for node in ast.walk(ast.parse(self.content)):
            if (isinstance(node, ast.keyword) and node.arg == word) or (
                isinstance(node, ast.Constant) and node.value == word
            ):
                named.append(node.lineno)
            elif isinstance(node, ast.Name) and node.id == "EFFECT":
                assigned.append(node.lineno)
        return max(named or assigned, default=None)

    def run(self) -> ModuleType:
        """Run the file as a module; it gets a name by which nothing else is imported.

        Raises
        ------
        EffectError
            where the file is not Python, or raises
        """
        try:
            code = compile(self.content, self.file, "exec", dont_inherit=True)
        except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
            raise self.blamed(error, "this is not valid Python") from None
        digest = hashlib.sha256(self.file.encode() + self.content).hexdigest()
        name = f"elastic_tendon_effect_{digest[:16]}"
        module = ModuleType(name)
        module.__file__ = self.file
        sys.modules[name] = module  # where dataclasses and pickle look for it
        try:
            exec(code, module.__dict__)
        except (Exception, SystemExit) as error:
            del sys.modules[name]
            raise self.blamed(error, "the file cannot be run") from None
        return module


def read_source(path: Path, file: str | None = None) -> Source:
    """Read a file of Python; `file` is what tracebacks call it, by default its real path.

    Raises
    ------
    EffectError
        where it cannot be read
    """
    try:
        if not path.is_dir():
            return Source(path, file or str(path.resolve()), path.read_bytes())
        fault = "this is a folder; give the effect's file in it"
    except (FileNotFoundError, NotADirectoryError):
        fault = "there is no such file; give the path of a Python file that defines EFFECT"
    except (OSError, ValueError) as error:  # ValueError: a NUL in the path
        fault = f"cannot be read: {error}"
    raise EffectError(f"{path}: {fault}")


def blame(function: Callable[..., object], error: BaseException) -> EffectError:
    """Error for an exception in a function of an effect, at the line of the function's file."""
    file = inspect.getfile(function)
    words = f"{getattr(function, '__name__', 'a function')} cannot be evaluated"
    return Source(Path(file), file, b"").blamed(error, words)


def reason(error: BaseException) -> str:
    """What an exception says, on one line, with advice where there is some."""
    if isinstance(error, AttributeError) and hasattr(error, "obj"):
        if isinstance(error.obj, SimpleNamespace):
            declared = ", ".join(vars(error.obj)) or "none"
            return f"no {error.name} is declared in EFFECT; declared here are: {declared}"
        if is_dataclass(error.obj):
            there = ", ".join(name for name in dir(error.obj) if not name.startswith("_"))
            return f"{type(error.obj).__name__} has no {error.name}; it has {there}"
    text = " ".join(str(error).split())
    if len(text) > LONGEST_REASON:
        text = text[: LONGEST_REASON - 3] + "..."
    sentence = f"{type(error).__name__}: {text}" if text else type(error).__name__
    return next((words.format(sentence) for part, words in _CLEARER if part in text), sentence)
