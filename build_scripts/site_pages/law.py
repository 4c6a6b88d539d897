"""The law of an effect, which its file says in a line of text, as formulas for the site.

A law is prose and formulas in turn: ``c' = (e - c) / time_constant; c starts at e``. Names of
parameters, single letters and what has a digit or an underscore in it are formulas; other words
are prose.
"""

import re
from collections.abc import Collection, Iterator
from dataclasses import dataclass

_WORD = r"[A-Za-zθτ][A-Za-z0-9_]*(?:'s\b|'*)"
_TOKEN = re.compile(rf"\s*({_WORD}\(?|\d+(?:\.\d+)?|.)")  # "sgn(" is one
_FUNCTIONS = {"exp": r"\exp", "sin": r"\sin", "max": r"\max", "sgn": r"\operatorname{sgn}"}
_SIGNS = {"-": "-", "±": r"\pm ", "+": "+", "=": "=", "<": "<", ">": ">"}
_POWERS = {"²": "2", "³": "3"}
_STYLE = r"\displaystyle "  # fractions in full size
_GREEK = {"θ": r"\theta", "τ": r"\tau"}
_SYMBOL = re.compile(r"[b-zA-Zθτ]'*|[a-z]\d|\w+_\w+")  # "a" is an article


@dataclass(frozen=True)
class Piece:
    """A piece of a law: prose, or LaTeX of a factor or an operator."""

    text: str
    is_prose: bool = False
    is_factor: bool = False


def typeset(law: str, parameters: Collection[str]) -> list[str]:
    """Lines of MyST Markdown, one for each equation or sentence of a law.

    Parameters
    ----------
    law : as `Effect.law`
    parameters : names of the effect's parameters
    """
    return [_line(part, parameters) for part in _sentences(law)]


def _sentences(law: str) -> Iterator[str]:
    """A law at its semicolons, and at commas after which another equation begins."""
    equation = re.compile(r",\s+(?=\w+(?:'|\(\w\))*\s=\s)")
    for sentence in law.split(";"):
        yield from equation.split(sentence.strip())


def _line(sentence: str, parameters: Collection[str]) -> str:
    heading, colon, rest = sentence.rpartition(": ")
    pieces = _Parser(rest, parameters).pieces()
    return heading + colon + _markdown(pieces)


def _markdown(pieces: list[Piece]) -> str:
    """Prose as it is, and each run of formulas between as one."""
    parts: list[str] = []
    formula = ""
    for piece in [*pieces, Piece("", is_prose=True)]:
        if not piece.is_prose:
            formula += piece.text
            continue
        if formula.strip():
            parts.append(f"{{math}}`{_STYLE}{formula.strip()}`")
        formula = ""
        parts.append(piece.text)
    return re.sub(r" ([,;])", r"\1", " ".join(part for part in parts if part))


class _Parser:
    """From left to right; what stands in parentheses is parsed by the same rules."""

    def __init__(self, law: str, parameters: Collection[str]) -> None:
        self.tokens = _TOKEN.findall(law)
        self.parameters = parameters

    def pieces(self, end: str = "") -> list[Piece]:
        """Pieces up to a closing sign; a fraction's numerator is all factors before the slash."""
        found: list[Piece] = []
        while self.tokens and (token := self.tokens.pop(0)) != end:
            if token == "/":
                found = _with_fraction(found, self._powered(self._factor(self.tokens.pop(0))))
            elif (piece := self._factor(token)).is_prose and found and found[-1].is_prose:
                found[-1] = Piece(f"{found[-1].text} {piece.text}", is_prose=True)
            else:
                found.append(self._powered(piece))
        return found

    def _factor(self, token: str) -> Piece:
        if token == "(":
            return Piece(rf"\left({self._inner(')')}\right)", is_factor=True)
        if token == "|":
            return Piece(rf"\left|{self._inner('|')}\right|", is_factor=True)
        if token.endswith("("):
            name = self._named(token[:-1]).strip()
            return Piece(rf"{name}\left({self._inner(')')}\right)", is_factor=True)
        if token in _SIGNS:
            return Piece(_SIGNS[token])
        is_formula = token in self.parameters or token[0].isdigit() or _SYMBOL.fullmatch(token)
        return Piece(self._named(token), is_factor=True) if is_formula else Piece(token, True)

    def _named(self, token: str) -> str:
        """LaTeX of a name: letters slanted, words upright, what follows a letter below it."""
        name, order = token.rstrip("'"), token.count("'")
        primes = "^{" + order * r"\prime " + "}" if order else ""
        letter, below = name[:1], name[1:].lstrip("_")
        if name in _FUNCTIONS:
            return _FUNCTIONS[name]
        is_word = len(name.partition("_")[0]) > 1 and not below.isdigit()
        if name in self.parameters or is_word:
            return rf"\text{{{name}}}{primes}\,"
        mark = below if below.isdigit() else rf"\text{{{below}}}"
        subscript = f"_{{{mark}}}" if below else ""
        return _GREEK.get(letter, letter) + subscript + primes + " "

    def _inner(self, end: str) -> str:
        texts = {",": r",\ "}
        return "".join(
            texts.get(part.text, rf"\text{{ {part.text} }}") if part.is_prose else part.text
            for part in self.pieces(end)
        )

    def _powered(self, piece: Piece) -> Piece:
        """The factor with the power that follows it."""
        following, base = self.tokens[0] if self.tokens else "", piece.text.strip()
        if following in _POWERS:
            return Piece(f"{base}^{{{_POWERS[self.tokens.pop(0)]}}}", is_factor=True)
        if following == "^":
            self.tokens.pop(0)
            power = self._factor(self.tokens.pop(0))
            return Piece(f"{base}^{{{power.text}}}", is_factor=True)
        return piece


def _with_fraction(found: list[Piece], denominator: Piece) -> list[Piece]:
    """The factors before a slash become a numerator."""
    first = len(found)
    while first and found[first - 1].is_factor:
        first -= 1
    numerator = "".join(piece.text for piece in found[first:])
    fraction = rf"\frac{{{_bare(numerator)}}}{{{_bare(denominator.text)}}}"
    return [*found[:first], Piece(fraction, is_factor=True)]


def _bare(formula: str) -> str:
    """A formula without the one pair of parentheses that is all around it."""
    match = re.fullmatch(r"\\left\((.*)\\right\)", formula)
    return match[1] if match and r"\left(" not in match[1] else formula
