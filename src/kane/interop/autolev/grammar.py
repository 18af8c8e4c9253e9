# SPDX-License-Identifier: BSD-3-Clause
"""From a text to parsed statements: lines are joined and cut, then parsed by a grammar; size, number and nesting are bounded."""

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from itertools import product
from math import prod
from typing import TYPE_CHECKING, Any

from kane.errors import ModelError, cut

if TYPE_CHECKING:
    from lark import Lark

MOST_LETTERS, MOST_STATEMENTS, MOST_LONG, MOST_NESTED = 2_000_000, 20_000, 100_000, 40

GRAMMAR = r"""
statement: expr [ASSIGN expr [unit]]
declaration: (item ("," item?)*)?
item: NAME [ranges] [PRIMES] ["(" [NAME] ")"] [SIGN] ["=" expr [unit]]
ranges: ("{" range ("," range)* "}")+ [NAME]
range: expr [":" expr]
?expr: term (SIGN term)* -> sum
?term: unary (OVER unary)* -> term
?unary: SIGN unary -> signed
      | power
?power: atom ["^" exponent] -> power
?exponent: SIGN exponent -> signed
         | power
?atom: NUMBER -> number
     | CONSTANT -> constant
     | NAME -> name
     | NAME "(" args ")" -> function
     | NAME "[" args "]" -> element
     | NAME ranges [PRIMES] -> names
     | "(" expr ")"
     | "[" row (";" row)* ";"? "]" -> matrix
     | atom "." NAME "(" args ")" -> member
row: expr ("," expr)*
args: (argument ("," argument)* ","?)?
argument: expr [unit]
        | expr ASSIGN expr [unit] -> named
        | expr ASSIGN NAME ASSIGN expr [unit] -> chained
        | expr [ASSIGN expr] ":" expr (":" expr)? -> span
unit: NAME (UNIT_SIGN (NAME | [SIGN] NUMBER))*
NAME: /[A-Za-z_][A-Za-z0-9_]*'*(>>|>)?/
CONSTANT.2: /[01]>>?/
NUMBER: /(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?/
PRIMES: /'+/
SIGN: /[+-]/
OVER: /[*\/]/
UNIT_SIGN: /[*\/^]/
ASSIGN: /[:+*\/-]?=/
%ignore /[ \t\f\r]+/
"""


@dataclass(frozen=True, slots=True)
class Line:
    """A statement's text and its position in the file."""

    text: str
    number: int
    column: int

    @property
    def where(self) -> str:
        """The position, for remarks."""
        return f"line {self.number}"

    def refuse(self, expected: str, got: object, cure: str = "") -> ModelError:
        """The error that names this line."""
        return ModelError(f"Expected {expected}, got {got} in {self.where}, “{cut(self.text)}”.{cure and ' '}{cure}")


def lines_of(text: str) -> Iterator[Line]:
    """The statements: without comments, continued lines joined, cut at semicolons outside brackets."""
    if len(text) > MOST_LETTERS:
        raise ModelError(f"Expected a file of at most {MOST_LETTERS} letters, got {len(text)}. Cut it into models.")
    held, first, count = "", 0, 0
    for number, raw in enumerate(text.splitlines(), 1):
        line = re.split(r"%|//", raw, maxsplit=1)[0].rstrip()
        first = first if held else number
        held += (line.lstrip() if held else line).removesuffix("&")  # words may be split between lines
        if line.endswith("&"):
            continue
        for at, piece in _pieces(held, first):
            count += 1
            if count > MOST_STATEMENTS:
                raise ModelError(f"Expected at most {MOST_STATEMENTS} statements, got more at line {first}.")
            yield Line(piece.strip(), first, at + len(piece) - len(piece.lstrip()) + 1)
        held = ""
    if held.strip():
        raise ModelError(f"Expected a line after the “&” that ends line {first}, got the end of the text.")


def _pieces(text: str, number: int) -> Iterator[tuple[int, str]]:
    """The pieces between semicolons, with their columns; raises on unbalanced brackets."""
    if len(text) > MOST_LONG:
        raise ModelError(f"Expected a statement of at most {MOST_LONG} letters, got {len(text)} at line {number}.")
    depth, start = 0, 0
    for k, letter in enumerate(text):
        depth += (letter in "([{") - (letter in ")]}")
        if depth > MOST_NESTED or depth < 0:
            fault = f"more than {MOST_NESTED} nested brackets" if depth > 0 else "a bracket that closes none"
            raise ModelError(f"Expected brackets in pairs, got {fault} in line {number}, column {k + 1}.")
        if letter == ";" and depth == 0:
            if text[start:k].strip():
                yield start, text[start:k]
            start = k + 1
    if text[start:].strip():
        yield start, text[start:]


@cache
def parser() -> "Lark":
    """The parser, constructed on first use, which imports lark."""
    try:
        lark = import_module("lark")
    except ImportError as error:
        raise ModelError("Expected lark, which reads Autolev's language, got none. Install kane[models].") from error
    return lark.Lark(GRAMMAR, parser="lalr", start=["statement", "declaration", "args"], maybe_placeholders=True)  # type: ignore[no-any-return]


def bare(tree: Any) -> Any:
    """The expression without enclosing grammar nodes that have a single child."""
    while getattr(tree, "data", "") in ("argument", "sum", "term", "power") and all(
        x is None for x in tree.children[1:]
    ):
        tree = tree.children[0]
    return tree


def tokens(tree: Any) -> Iterator[Any]:
    """The names in a tree, in order."""
    stack = [tree]
    while stack:
        node = stack.pop()
        if hasattr(node, "children"):
            stack += reversed(node.children)
        elif getattr(node, "type", "") == "NAME":
            yield node


MOST_NAMES = 2_000
Number = Callable[[Any, Line], int]
"""A function that reads an integer."""


def names_of(item: Sequence[Any], number: Number, line: Line) -> Iterator[tuple[str, int]]:
    """The names denoted by a name with ranges and primes, Q{3}' for q1, q2, q3, each with the number of primes."""
    name, ranges, primes = str(item[0]), item[1], item[2]
    *told, end = ranges.children if ranges is not None else (None,)
    whole = name + (end or "") + (primes or "")
    count = whole.count("'")
    base, tail = name.rstrip("'"), (end or "").rstrip("'")
    if not told:
        yield base, count
        return
    spans = [_span(x, number, line) for x in told]
    if len(spans) > 1 and all(x.children[1] is None for x in told):
        spans = [range(1, span[-1] + 1) for span in spans]
    total = prod(map(len, spans))
    if total > MOST_NAMES:
        raise line.refuse(f"at most {MOST_NAMES} names of one declaration", total)
    for indices in product(*spans):
        yield base + "".join(map(str, indices)) + tail, count


def _span(tree: Any, number: Number, line: Line) -> range:
    first = number(tree.children[0], line)
    if tree.children[1] is None:
        return range(1, first + 1)
    last = number(tree.children[1], line)
    if not 0 <= last - first < MOST_NAMES:
        raise line.refuse(f"a range of at most {MOST_NAMES} that goes up", f"{first}:{last}")
    return range(first, last + 1)
