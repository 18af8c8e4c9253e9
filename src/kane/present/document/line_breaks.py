# SPDX-License-Identifier: BSD-3-Clause
r"""Formulas in LaTeX broken into lines of a given width, before a + or − of the outermost sums where possible.

TeX breaks no line between `\left` and `\right`: if a line ends within brackets, these become `\bigl` and `\bigr`. A fraction or
root wider than the line is first written as a product or power of brackets.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

_TOKEN = re.compile(r"\\[A-Za-z]+\s*|\\.|[{}]|\s+|.", re.DOTALL)
_OVER = {"hat", "tilde", "dot", "ddot", "dddot", "mathrm", "mathbf", "boldsymbol", "operatorname", "text", "bar"}
"""Commands with one argument and its width."""
_WIDTHS = {
    r"\,": 0.17, r"\;": 0.28, r"\ ": 0.3, r"\quad": 1.0, r"\qquad": 2.0, r"\sin": 1.35, r"\cos": 1.35, r"\tan": 1.5, r"\ln": 0.9,
    r"\cdot": 0.75, r"\times": 1.25, r"\sum": 1.6, r"\dots": 1.3, r"\arcsin": 2.6, r"\arccos": 2.6, r"\arctan": 2.6, "+": 1.25,
    "-": 1.25, "=": 1.35, "(": 0.42, ")": 0.42, "m": 0.9, "M": 1.0, "w": 0.75, "W": 1.0, "i": 0.36, "l": 0.36, "j": 0.45, "t": 0.4,
    ",": 0.45, ".": 0.28, "|": 0.3, "*": 0.5,
}  # fmt: skip
"""Widths in em; other signs are as wide as a letter."""
_LETTER, _CAPITAL, _DIGIT, _SMALL = 0.58, 0.76, 0.5, 0.72
_BEGINS = {"=", ",", "&", r"\;", r"\quad", r"\cdot", r"\times"}
"""Signs after these are unary."""
_APART = {r"\;", r"\quad", r"\qquad"}
_LEFT = 5.0
"""Width reserved for a left side, in em."""
_LEAST = 3
"""A line is filled to at least this fraction, 1/n, even if an inner sum must be broken."""
_NARROW = 7.0
"""Width of brackets, in em, below which they are not broken."""
_NO_FACTOR = re.compile(
    r"\s*(\\(arc)?(sin|cos|tan)h?\b|\\(ln|min|max|operatorname|big|cdot|q?quad|text)\b|\\[,;]|[=,]|$)"
)
"""Tokens before brackets that are not factors."""
_OPEN, _CLOSE = re.compile(r"\\left\s*(\\.|\S)"), re.compile(r"\\right\s*(\\.|\S)")


@dataclass(frozen=True, slots=True)
class _Unit:
    """A part of a formula that is never broken, with its width in em; `bracket` is 1 for an opening and −1 for a closing bracket.

    `sum` marks the beginning of a term; `apart` follows a comma or a wide space, `depth` is the number of enclosing brackets.
    """

    text: str
    width: float
    bracket: int = 0
    sum: bool = False
    apart: bool = False
    depth: int = 0


def broken_lines(latex: str, width: float, hang: float = 0.0) -> list[str]:
    """Lines of at most `width` em, those after the first `hang` em shorter, as far as sums or products of brackets allow."""
    units = _nested(_units(latex, width - hang - _LEFT))
    ends, start, room = [], 0, width
    while sum(u.width for u in units[start:]) > room:
        at = _line_end(units, start, room)
        if at is None:
            break
        ends.append(at)
        start, room = at, width - hang
    return _joined(units, ends)


def _nested(units: Sequence[_Unit]) -> list[_Unit]:
    """The units with their depths; sums in narrow brackets are not broken."""
    result = list(units)
    opened: list[int] = []
    for i, u in enumerate(units):
        if u.bracket < 0 and opened:
            first = opened.pop()
            if sum(v.width for v in units[first:i]) < _NARROW:
                result[first:i] = [replace(v, sum=False) for v in result[first:i]]
        result[i] = replace(u, depth=len(opened))
        if u.bracket > 0:
            opened.append(i)
    return result


def em_width(latex: str) -> float:
    """The estimated width of a formula, in em."""
    return sum(u.width for u in _units(latex, float("inf")))


def _line_end(units: Sequence[_Unit], start: int, room: float) -> int | None:
    """The end of the line that begins at `start`: an outermost sum that fills it well, or else a product of brackets."""
    reached = 0.0
    fits: list[tuple[bool, int, int, float]] = []
    later: list[tuple[bool, int, int, float]] = []
    for i in range(start + 1, len(units)):
        before, unit = units[i - 1], units[i]
        reached += before.width
        product = unit.bracket > 0 and not (before.bracket > 0 or before.sum or _NO_FACTOR.match(before.text))
        if unit.sum or unit.apart or product:
            (fits if reached <= room else later).append(
                (not (unit.sum or unit.apart), unit.depth - unit.apart, i, reached)
            )
    full = [place for place in fits if place[3] >= room / _LEAST] or fits
    if full:
        return min(full, key=lambda place: (place[0], place[1], -place[2]))[2]
    return later[0][2] if later else None


def _joined(units: Sequence[_Unit], ends: Sequence[int]) -> list[str]:
    """The text of each line; brackets open at a line's end get a fixed size."""
    texts = [u.text for u in units]
    opened: list[int] = []
    cut, broken = set(ends), set()
    for i, u in enumerate(units):
        if i in cut:
            broken.update(opened)
        if u.bracket > 0:
            opened.append(i)
        elif u.bracket < 0 and opened and (first := opened.pop()) in broken:
            texts[first] = _OPEN.sub(r"\\bigl\1", texts[first], count=1)
            texts[i] = _CLOSE.sub(r"\\bigr\1", texts[i], count=1)
    pieces = ["".join(texts[a:b]).strip() for a, b in zip([0, *ends], [*ends, len(units)], strict=True)]
    lead = [("" if units[e].sum or units[e].apart else r"\cdot ") for e in ends]
    return [pieces[0], *(f"{{}}{sign}{piece}" for sign, piece in zip(lead, pieces[1:], strict=True))]


# Parsing ------------------------------------------------------------------------------------------------


def _units(latex: str, room: float, scale: float = 1.0) -> list[_Unit]:
    """The formula as units in one line; fractions and roots wider than `room` are rewritten."""
    tokens = _TOKEN.findall(latex)
    units: list[_Unit] = []
    i = 0
    while i < len(tokens):
        name = tokens[i].strip() if tokens[i] != "\\ " else tokens[i]
        if name == r"\begin":
            i, unit = _environment(tokens, i, scale)
            units.append(unit)
        elif name in (r"\left", r"\right"):
            text, i = tokens[i] + tokens[i + 1], i + 2
            units.append(_Unit(text, 0.5 * scale, 1 if name == r"\left" else -1))
        elif name == r"\frac":
            over, i = _argument(tokens, i + 1)
            under, i = _argument(tokens, i)
            units += _fraction(over, under, room, scale)
        elif name == r"\sqrt":
            within, i = _argument(tokens, i + 1)
            units += _root(within, room, scale)
        elif name in ("^", "_") and units:
            raised, i = _argument(tokens, i + 1)
            last = units.pop()
            more = _sum(raised, scale * _SMALL)
            both = last.text.rstrip().endswith("}") and name == "^" and "_" in last.text  # superscript above subscript
            units.append(
                replace(last, text=f"{last.text}{name}{{{raised}}}", width=last.width + more * (0.5 if both else 1))
            )
        elif name == "{":
            within, i = _argument(tokens, i)
            units.append(_Unit(f"{{{within}}}", _sum(within, scale)))
        elif name.removeprefix("\\") in _OVER and name.startswith("\\"):
            within, i = _argument(tokens, i + 1)
            units.append(_Unit(f"{name}{{{within}}}", _sum(within, scale)))
        else:
            before = next((u for u in reversed(units) if u.text.strip()), None)
            first = before is None or before.sum or before.bracket > 0 or before.text.strip() in _BEGINS
            units.append(_Unit(tokens[i], _width(name) * scale, sum=name in ("+", "-") and not first))
            i += 1
        if len(units) > 1 and units[-2].text.strip() in _APART and units[-1].text.strip() not in _APART:
            units[-1] = replace(units[-1], apart=True)
    return units


def _sum(latex: str, scale: float) -> float:
    return sum(u.width for u in _units(latex, float("inf"), scale))


def _width(token: str) -> float:
    if token in _WIDTHS or not token:
        return _WIDTHS.get(token, 0.0)
    letter = token.removeprefix("\\")
    return _DIGIT if letter.isdigit() else _CAPITAL if letter[0].isupper() else _LETTER


def _argument(tokens: Sequence[str], i: int) -> tuple[str, int]:
    """The argument in braces from token `i` on, or that token, and the index after it."""
    while i < len(tokens) and not tokens[i].strip():
        i += 1
    if i >= len(tokens) or tokens[i] != "{":
        return (tokens[i] if i < len(tokens) else ""), i + 1
    depth, k = 1, i + 1
    while depth and k < len(tokens):
        depth += (tokens[k] == "{") - (tokens[k] == "}")
        k += 1
    return "".join(tokens[i + 1 : k - 1]), k


def _environment(tokens: Sequence[str], i: int, scale: float) -> tuple[int, _Unit]:
    """A matrix or cases environment as one unit, as wide as its columns."""
    depth, k = 0, i
    while k < len(tokens):
        depth += (tokens[k].strip() == r"\begin") - (tokens[k].strip() == r"\end")
        if not depth:
            break
        k += 1
    _, end = _argument(tokens, k + 1)
    _, first = _argument(tokens, i + 1)
    within = "".join(tokens[first:k])
    rows = [[_sum(cell, scale) for cell in re.sub(r"\[3pt\]", "", row).split("&")] for row in re.split(r"\\\\", within)]
    columns = max(map(len, rows))
    wide = sum(max((row[c] for row in rows if c < len(row)), default=0.0) + 1.0 for c in range(columns))
    return end, _Unit("".join(tokens[i:end]), wide + 0.5)


def _fraction(over: str, under: str, room: float, scale: float) -> list[_Unit]:
    above, below = _sum(over, scale), _sum(under, scale)
    if max(above, below) + 0.3 <= room:
        return [_Unit(rf"\frac{{{over}}}{{{under}}}", max(above, below) + 0.3)]
    if below + 0.3 <= room / _LEAST:
        return [_Unit(rf"\frac{{1}}{{{under}}} ", below + 0.3), *_bracketed(over, room, scale)]
    return [*_bracketed(over, room, scale), _Unit(r" \big/ ", 0.6), *_bracketed(under, room, scale)]


def _root(within: str, room: float, scale: float) -> list[_Unit]:
    wide = _sum(within, scale) + 1.0
    if wide <= room:
        return [_Unit(rf"\sqrt{{{within}}}", wide)]
    opened = _bracketed(within, room, scale)
    return [*opened[:-1], _Unit(r"\right)^{1/2}", 1.4, -1)]


def _bracketed(within: str, room: float, scale: float) -> list[_Unit]:
    return [_Unit(r"\left(", 0.5, 1), *_units(within, room, scale), _Unit(r"\right)", 0.5, -1)]
