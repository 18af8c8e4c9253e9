# SPDX-License-Identifier: BSD-3-Clause
"""Expressions and vectors as Python text that recreates the same nodes; calls, lists and long statements broken into lines.

The text follows the graph, one operator per node: executing it performs the same operations. Long shared subexpressions are assigned
to names Z1, Z2, … before their use.
"""

import json
import keyword
import re
import textwrap
from collections.abc import Callable, Iterable, Sequence
from fractions import Fraction

from kane.errors import ModelError
from kane.expr.node import ONE, Expr, Number, number_of, postorder
from kane.expr.numbers import Surd
from kane.expr.ops import ADD, CONST, DIV, MUL, NEG, PI, POW, SUB
from kane.expr.piecewise import Piecewise, Table, table_of
from kane.expr.regular import unguarded
from kane.expr.symbols import QuasiRate, Rate, Symbol, Time
from kane.interop.imported import FreeNames
from kane.space.vector import Parts, Vector

WIDTH = 118
"""The maximum line length."""
INDENT = "    "


def wrapped(text: str) -> list[str]:
    """The lines of a comment."""
    return textwrap.wrap(" ".join(text.split()), WIDTH - 2, break_long_words=False, break_on_hyphens=False) or [""]


_TOKEN = re.compile(r'"(?:[^"\\]|\\.)*"|[()\[\]{}]| [+-] |, ?|[^"()\[\]{},]+?(?= [+-] |["()\[\]{},]|$)')
"""A string, a bracket, a sign or comma at which a line may end, or the text between."""


def folded(statement: str) -> str:
    """A statement broken at commas and signs in brackets into lines of at most `WIDTH` columns."""
    width = WIDTH - len(INDENT)
    if all(len(line) <= width for line in statement.split("\n")):
        return statement
    name, equals, value = statement.partition(" = ")
    if "(" not in value and equals:
        statement = f"{name} = ({value})"
    out, depth = [], 0
    for line in statement.split("\n"):
        margin = " " * (len(line) - len(line.lstrip()) + len(INDENT))
        chunks, depth = _chunks(line, depth)
        out.append(chunks[0])
        for chunk in chunks[1:]:
            if len(out[-1]) + len(chunk.rstrip()) > width:
                out[-1] = out[-1].rstrip()
                out.append(margin + chunk.lstrip())
            else:
                out[-1] += chunk
    return "\n".join(out)


def _chunks(line: str, depth: int) -> tuple[list[str], int]:
    """The parts between possible line ends, and the number of brackets open at the end."""
    chunks = [""]
    for token in _TOKEN.findall(line):
        if token in (" + ", " - ") and depth:
            chunks.append(token)
        else:
            chunks[-1] += token
            depth += (token in ("(", "[", "{")) - (token in (")", "]", "}"))
            if token.startswith(",") and depth:
                chunks.append("")
    return chunks, depth


def call(function: str, arguments: Sequence[str]) -> str:
    """A call in one line if it fits, else one argument per line."""
    line = f"{function}({', '.join(arguments)})"
    if len(line) + len(INDENT) <= WIDTH and "\n" not in line:
        return line
    inner = "".join(f"\n{_deeper(a)}," for a in arguments)
    return f"{function}({inner}\n)"


def listed(items: Sequence[str], brackets: str = "[]") -> str:
    """Items in brackets, in one line if they fit, else one per line."""
    line = ", ".join(items)
    comma = "," if brackets == "()" and len(items) == 1 else ""
    if len(line) + 2 * len(INDENT) + 16 <= WIDTH and "\n" not in line:
        return f"{brackets[0]}{line}{comma}{brackets[1]}"
    return f"{brackets[0]}{''.join(f'{chr(10)}{_deeper(x)},' for x in items)}\n{brackets[1]}"


def _deeper(text: str) -> str:
    return "\n".join(INDENT + line for line in text.split("\n"))


WORTH = 6
"""The minimum number of operations of a shared subexpression that is assigned to a name."""
DEEP = 20
"""The nesting depth beyond which a subexpression is assigned to a name even if it is used once."""
_SUM, _PRODUCT, _SIGN, _POWER, _ATOM = range(5)
"""Precedence of operators in Python, lowest first."""
_BINARY = {ADD: (" + ", _SUM), SUB: (" - ", _SUM), MUL: (" * ", _PRODUCT), DIV: (" / ", _PRODUCT)}
_FUNCTIONS = frozenset(
    (
        *("sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "exp", "log", "sqrt"),
        *("abs", "sign", "min", "max", "less", "where"),
    )
)
_MARKS = {"*": "_star", "^": "_hat", "'": "_1", "″": "_2"}
_TAKEN = frozenset(keyword.kwlist) | {"kn", "system", "START", "TITLE", "SOURCES", "SPAN", "print", "dict"}
Text = tuple[str, int]


class ObjectNames:
    """Python names, one for each named object; equal names of different objects are made distinct."""

    def __init__(self) -> None:
        self._by_object: dict[int, str] = {}
        self._kept: list[object] = []
        self._names = FreeNames(_TAKEN)

    def give(self, item: object, wanted: str, kind: str) -> str:
        """The name of a new object: `wanted` if it is a free identifier, else with `kind` appended."""
        name = self._names.identifier("".join(_MARKS.get(c, c) for c in wanted), kind)
        self.alias(item, name)
        return name

    def alias(self, item: object, text: str) -> None:
        """Records the text that refers to an object without a name."""
        self._by_object[id(item)] = text
        self._kept.append(item)  # keeps the object alive, because an id is unique only during its lifetime

    def __getitem__(self, item: object) -> str:
        return self._by_object[id(item)]

    def __contains__(self, item: object) -> bool:
        return id(item) in self._by_object


class Expressions:
    """Writes expressions.

    `define` is called with the name and text of an assignment that must precede, `owner` with a symbol that has no name yet.
    """

    def __init__(
        self,
        names: ObjectNames,
        define: Callable[[str, str], None],
        shared: Iterable[Expr] = (),
        owner: Callable[[Symbol], None] = lambda s: None,
    ) -> None:
        self.names, self.define, self.owner = names, define, owner
        self.quasi: dict[Symbol, str] = {}
        """The text of quasi-rates of Euler parameters."""
        self.asked: list[Expr] = []
        """The expressions written, in order."""
        self._shared = frozenset(shared)
        self._texts: dict[Expr, Text] = {}
        self._count = 0

    def __call__(self, e: Expr, least: int = _SUM) -> str:
        """The text of `e`, in brackets if its precedence is lower than `least`."""
        (e,) = unguarded((e,))
        self.asked.append(e)
        for node in postorder((e,)):
            if node not in self._texts:
                self._texts[node] = self._made(node)
        return _within(self._texts[e], least)

    def _made(self, node: Expr) -> Text:
        text = self._written(node)
        if node not in self._shared:
            return text
        self._count += 1
        name = self.names.give(node, f"Z{self._count}", "shared")
        self.define(name, text[0])
        return name, _ATOM

    def _written(self, node: Expr) -> Text:
        op, texts = node.op, self._texts
        if op is MUL and (part := self._part(node)):
            return part
        if op in _BINARY:
            sign, level = _BINARY[op]
            a, b = (texts[x] for x in node.args)
            return f"{_within(a, level)}{sign}{_within(b, level + 1)}", level
        if op is NEG:
            return f"-{_within(texts[node.args[0]], _SIGN)}", _SIGN
        if op is POW:
            a, b = (texts[x] for x in node.args)
            return f"{_within(a, _ATOM)} ** {_within(b, _POWER)}", _POWER
        if isinstance(node, Symbol):
            return self._symbol(node), _ATOM
        if op is CONST:
            return _number(number_of(node))
        if op is PI:
            return "kn.pi", _ATOM
        if isinstance(op, Piecewise) and (table := table_of(op)) is not None:
            return f"{self._table(table, op.order)}({texts[node.args[0]][0]})", _ATOM
        if op.name not in _FUNCTIONS:
            raise ModelError(
                f"Expected expressions of operators and functions of kane to write as Python, got {op.label or op.name!r}, "
                "which is data. Keep the file that declares it."
            )
        return f"kn.{op.name}({', '.join(texts[a][0] for a in node.args)})", _ATOM

    def _table(self, table: Table, order: int) -> str:
        """The name of a table, which is defined first, or of its derivative."""
        op = table.op
        if op not in self.names:
            named = {"name": op.label, "unit": op.unit, "of": op.of}
            told = [f"{key}={literal(x)}" for key, x in named.items() if x and (key, x) != ("name", "table")]
            points = [f"[{', '.join(map(repr, x.tolist()))}]" for x in table.points]
            name = self.names.give(op, op.label, "table")
            self.define(name, call("kn.table", [*points, literal(table.kind), *told]))
        return self.names[op] + (f".derivative({order})" if order else "")

    def _part(self, node: Expr) -> Text | None:
        """The product of a fraction n/d and another factor as n*x/d, if that makes the same node."""
        a, b = node.args
        value = number_of(a) if a.op is CONST else 0
        if not isinstance(value, Fraction) or value.denominator == 1:
            return None
        over, under = value.numerator, value.denominator
        if (b if over == 1 else -b if over == -1 else b * over) / under is not node:
            return None
        size = _within(self._texts[b], _PRODUCT if over == 1 else _SIGN)  # n*(x*y) is not (n*x)*y
        return f"{'' if over == 1 else '-' if over == -1 else f'{over} * '}{size} / {under}", _PRODUCT

    def _symbol(self, s: Symbol) -> str:
        if s not in self.names:
            self.owner(s)
        if s in self.names:
            return self.names[s]
        if isinstance(s, Rate) and isinstance(s.place, Symbol):
            return f"{self._symbol(s.place)}.dt"
        if isinstance(s, Time):
            return "kn.time"
        if isinstance(s, QuasiRate) and s in self.quasi:
            name = self.names.give(s, s.name, "turning")
            self.define(name, self.quasi[s])
            return name
        raise ModelError(f"Expected symbols that the system declares, got {s} ({type(s).__name__}).")

    def vector(self, v: Vector, least: int = _SUM) -> str:
        """The sum of measure numbers times unit vectors."""
        text = ""
        for unit, x in _terms(v.parts, self.names):
            minus = x.op is NEG or (x.op is CONST and number_of(x) < 0)
            size = -x if minus else x
            along = unit if size is ONE else f"{self(size, _PRODUCT)} * {unit}"
            text += (" - " if minus else " + ") + along if text else ("-" if minus else "") + along
        single = text.count(".") == 1 and " " not in text and not text.startswith("-")
        return f"({text})" if least > _SUM and not single else text or "kn.Vector()"


def _terms(parts: Parts, names: ObjectNames) -> Iterable[tuple[str, Expr]]:
    for frame, numbers in parts:
        for axis, x in zip("xyz", numbers, strict=True):
            if x.op is not CONST or number_of(x) != 0:
                yield f"{names[frame]}.{axis}", x


def literal(value: object) -> str:
    """A value as a Python literal, strings in double quotes."""
    return json.dumps(value, ensure_ascii=False) if isinstance(value, str) else repr(value)


def _within(text: Text, least: int) -> str:
    return f"({text[0]})" if text[1] < least else text[0]


def _number(value: Number) -> Text:
    if isinstance(value, Surd):
        ratio, root = value.ratio, f"kn.sqrt({value.radicand})"
        if abs(ratio) == 1:
            return (root, _ATOM) if ratio > 0 else (f"-{root}", _SIGN)
        return f"{_number(int(ratio) if ratio.denominator == 1 else ratio)[0]} * {root}", _PRODUCT
    if isinstance(value, Fraction):
        return f"kn.Rational({value.numerator}, {value.denominator})", _ATOM
    return repr(value), _ATOM if value >= 0 else _SIGN


def same(first: Iterable[object], second: Iterable[object]) -> bool:
    """Whether both contain the same objects in the same order."""
    a, b = list(first), list(second)
    return len(a) == len(b) and all(x is y for x, y in zip(a, b, strict=True))


def same_vectors(first: Iterable[Vector], second: Iterable[Vector]) -> bool:
    """Whether vectors have the same measure numbers along the same frames."""
    return same(*((x for v in vs for f, numbers in v.parts for x in (f, *numbers)) for vs in (first, second)))


def shared_among(asked: Iterable[Expr]) -> tuple[Expr, ...]:
    """The subexpressions to assign to names: those used more than once and long enough, and deeply nested ones."""
    roots = tuple(asked)
    order = postorder(roots)
    uses: dict[Expr, int] = dict.fromkeys(order, 0)
    for root in roots:
        uses[root] += 1
    for node in order:
        for a in node.args:
            uses[a] += 1
    cost: dict[Expr, int] = {}
    depth: dict[Expr, int] = {}
    chosen = []
    for node in order:
        cost[node] = node.op.cost + sum(cost[a] for a in node.args)
        depth[node] = max((depth[a] + 1 for a in node.args), default=0)
        if node.args and ((uses[node] > 1 and cost[node] >= WORTH) or depth[node] >= DEEP) and node.op is not NEG:
            chosen.append(node)
            cost[node] = depth[node] = 0
    return tuple(chosen)
