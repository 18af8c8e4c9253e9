# SPDX-License-Identifier: BSD-3-Clause
"""Evaluation of expressions of a file: names, sums, products, powers, matrix elements, calls."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any

from kane.errors import ModelError, alike
from kane.expr.node import ONE, ZERO, Expr, as_expr, constant_value, pi
from kane.expr.symbols import Coordinate, Speed, rate, time
from kane.interop.autolev.grammar import Line, names_of
from kane.interop.autolev.sheet import Sheet, splits
from kane.interop.autolev.units import factor_of
from kane.interop.autolev.values import Dyad, FileMatrix, Unread, Value, Vec

MOST_EXPONENT, MOST_DEEP = 100, 300
Call = Callable[["FileReading", Sequence[Any], Line], Value]


class CallArguments(Sequence[Any]):
    """The arguments of a call; the error for a missing argument names the line."""

    def __init__(self, items: Sequence[Any], line: Line) -> None:
        self._items, self._line = items, line

    def __getitem__(self, k: Any) -> Any:
        if isinstance(k, slice):
            return CallArguments(self._items[k], self._line)
        if k >= len(self._items):
            raise self._line.refuse(f"at least {k + 1} argument{'s' * (k > 0)}", len(self._items) or "none")
        return self._items[k]

    def __len__(self) -> int:
        return len(self._items)

    def __iter__(self) -> Iterator[Any]:
        return iter(self._items)


class FileReading:
    """Evaluates expressions with the symbols of a sheet."""

    def __init__(self, sheet: Sheet, functions: dict[str, Call], members: dict[str, Call]) -> None:
        self.sheet = sheet
        self.functions = functions
        self.members = members
        self._depth = 0

    def value(self, tree: Any, line: Line) -> Value:
        """The value of an expression."""
        if self._depth > MOST_DEEP:
            raise line.refuse("an expression of fewer nested parts", "a deeper one")
        rule: Callable[[list[Any], Line], Value] = getattr(self, f"_{tree.data}")
        self._depth += 1
        try:
            return rule(tree.children, line)
        finally:
            self._depth -= 1

    def scalar(self, tree: Any, line: Line) -> Expr:
        """The value of an expression that must be a scalar."""
        value = self.value(tree, line)
        if isinstance(value, Unread):
            raise line.refuse("a scalar of the model", value.why)
        if isinstance(value, FileMatrix) and len(value.flat()) == 1:
            value = value.flat()[0]
        if not isinstance(value, Expr):
            raise line.refuse("a scalar", _kind(value), "A vector's name ends in “>”, a dyadic's in “>>”.")
        return value

    def vector(self, tree: Any, line: Line) -> Vec:
        """The value of an expression that must be a vector."""
        value = self.value(tree, line)
        if isinstance(value, Unread):
            raise line.refuse("a vector of the model", value.why)
        if isinstance(value, Vec):
            return value
        if isinstance(value, Expr) and constant_value(value) == 0:
            return Vec()
        raise line.refuse("a vector", _kind(value), "Write it along unit vectors, as x*N1>, or 0>.")

    def number(self, tree: Any, line: Line) -> int:
        """The value of an expression that must be an integer."""
        value = constant_value(self.scalar(tree, line))
        if value is None or value != int(value):
            raise line.refuse("a whole number", "another expression")
        return int(value)

    # Rules of the grammar --------------------------------------------------------------------------------------------

    def _sum(self, parts: list[Any], line: Line) -> Value:
        total = self.value(parts[0], line)
        for sign, tree in zip(parts[1::2], parts[2::2], strict=True):
            other = self.value(tree, line)
            total = plus(total, other if sign == "+" else times(as_expr(-1), other, line), line)
        return total

    def _term(self, parts: list[Any], line: Line) -> Value:
        total = self.value(parts[0], line)
        for sign, tree in zip(parts[1::2], parts[2::2], strict=True):
            other = self.value(tree, line)
            total = times(total, other, line) if sign == "*" else over(total, other, line)
        return total

    def _signed(self, parts: list[Any], line: Line) -> Value:
        value = self.value(parts[1], line)
        return value if parts[0] == "+" else times(as_expr(-1), value, line)

    def _power(self, parts: list[Any], line: Line) -> Value:
        base = self.value(parts[0], line)
        if parts[1] is None or isinstance(base, Unread):
            return base
        exponent = self.scalar(parts[1], line)
        number: Any = constant_value(exponent)
        if not isinstance(base, Expr):
            raise line.refuse("a scalar before “^”", _kind(base))
        if number is not None and abs(number) > MOST_EXPONENT:
            raise line.refuse(f"an exponent of at most {MOST_EXPONENT}", number)
        return base**exponent

    def _number(self, parts: list[Any], line: Line) -> Value:
        value = float(parts[0])
        return as_expr(int(value) if value.is_integer() and abs(value) < 1e15 else value)

    def _constant(self, parts: list[Any], line: Line) -> Value:
        text = str(parts[0])
        if text == "0>":
            return Vec()
        if text.endswith(">>"):
            return Dyad(unit=ONE if text[0] == "1" else ZERO)
        raise line.refuse("0>, 0>> or 1>>", text)

    def _name(self, parts: list[Any], line: Line) -> Value:
        return self.named(str(parts[0]), line, getattr(parts[0], "column", 1))

    def _names(self, parts: list[Any], line: Line) -> Value:
        """The values of a name with a range, U{1:3}', as a list."""
        column = getattr(parts[0], "column", 1)
        named = [self.named(name + "'" * primes, line, column) for name, primes in names_of(parts, self.number, line)]
        return next((x for x in named if isinstance(x, Unread)), FileMatrix((tuple(named),)))

    def _function(self, parts: list[Any], line: Line) -> Value:
        call = _called(self.functions, parts[0], "a function of Autolev", line)
        return call(self, CallArguments(parts[1].children, line), line)

    def _member(self, parts: list[Any], line: Line) -> Value:
        call = _called(self.members, parts[1], "a method of MotionGenesis", line)
        return call(self, CallArguments([parts[0], *parts[2].children], line), line)

    def _matrix(self, rows: list[Any], line: Line) -> Value:
        made = [tuple(self.value(x, line) for x in row.children) for row in rows]
        unread = next((x for row in made for x in row if isinstance(x, Unread)), None)
        if unread is not None:
            return unread
        stacked = [part for row in made for part in _beside(row, line)]
        if len({len(row) for row in stacked}) > 1:
            raise line.refuse("rows of one length in a matrix", ", ".join(str(len(row)) for row in stacked))
        return FileMatrix(tuple(stacked))

    def _element(self, parts: list[Any], line: Line) -> Value:
        name = str(parts[0]).lower()
        table = self.sheet.values.get(name)
        if table is None and "_" in name:
            table = self.named(name, line, 1)
        if isinstance(table, Unread):
            return table
        if table is None and self.sheet.formed:
            return Unread(f"{parts[0]}[…], which is given elsewhere")
        if not isinstance(table, FileMatrix):
            raise line.refuse("the name of a matrix before “[”", str(parts[0]), alike(name, self.tables()).strip())
        at = [self.number(x.children[0], line) for x in parts[1].children]
        rows = table.rows if len(at) > 1 or len(table.rows) > 1 else tuple((x,) for x in table.flat())
        i, j = (*at, 1)[:2]
        if not (0 < i <= len(rows) and 0 < j <= len(rows[0])):
            raise line.refuse(f"an element of a matrix of {len(rows)} × {len(rows[0])}", f"[{', '.join(map(str, at))}]")
        return rows[i - 1][j - 1]

    def tables(self) -> list[str]:
        """The names of matrices."""
        return [name for name, x in self.sheet.values.items() if isinstance(x, FileMatrix)]

    # Names -----------------------------------------------------------------------------------------------------------

    def named(self, given: str, line: Line, column: int) -> Value:
        """The value of a name."""
        name = given.lower()
        if name in self.sheet.values:
            return self.sheet.values[name]
        result: Value | None
        if name.endswith(">>"):
            result = self._dyadic(name[:-2])
        elif name.endswith(">"):
            result = self._vector(name[:-1], line)
        else:
            result = self._plain(name)
        if result is not None:
            return result
        known = [self.sheet.say(x) for x in (*self.sheet.symbols, *self.sheet.values)]
        cure = alike(given, known).strip() or "Declare it by Constants, Variables, Specified or MotionVariables'."
        raise line.refuse("a name that is declared or assigned", f"{given} at column {line.column + column - 1}", cure)

    def _plain(self, name: str) -> Value | None:
        base = name.rstrip("'")
        primes = len(name) - len(base)
        if not primes and base in ("t", "pi") and base not in self.sheet.symbols:
            return time if base == "t" else pi
        if base in self.sheet.values or base in self.sheet.symbols:
            return self._derivative(base, primes)
        for a, b in splits(name):
            if a in self.sheet.frames and b in self.sheet.frames:
                return FileMatrix(self.sheet.cosines(a, b))
        return None

    def _derivative(self, base: str, primes: int) -> Value:
        value: Value = self.sheet.values.get(base, self.sheet.symbols.get(base, ZERO))
        for _ in range(primes):
            if isinstance(value, Unread):
                return value
            if not isinstance(value, Expr):
                raise ModelError(f"Expected a scalar before “'”, got {base}.")
            if isinstance(value, Coordinate):
                value = self.sheet.kinematic.get(rate(value), rate(value))
            else:
                value = rate(value) if isinstance(value, Speed) else self.sheet.rate(value)
        return value

    def _vector(self, name: str, line: Line) -> Vec | None:
        axis = self.unit(name)
        if axis is not None:
            return Vec({axis: ONE})
        head, _, rest = name.partition("_")
        pair = self.sheet.pair(head, rest)
        if pair is not None:
            return self.sheet.found(head, *pair)
        for kind, loads in (("force", self.sheet.forces), ("torque", self.sheet.torques)):
            if head == kind and rest:
                return sum((v for place, v, _ in loads if place == rest), start=Vec())
        return None

    def unit(self, name: str) -> tuple[str, int] | None:
        """The frame and axis of the name of a unit vector without “>”."""
        frame, last = name[:-1], name[-1:]
        if frame in self.sheet.frames and last in "123xyz" and last:
            return frame, ("123xyz".index(last)) % 3
        return None

    def _dyadic(self, name: str) -> Value | None:
        head, _, rest = name.partition("_")
        for a, b in splits(rest) if head == "i" else ():
            if a in self.sheet.inertias and b in self.sheet.points:
                dyad, about, _ = self.sheet.inertias[a]
                return dyad if about == b else Unread(f"I_{a}_{b}>>, an inertia about another point")
        return None


def plus(a: Value, b: Value, line: Line) -> Value:
    """a + b, of values of the same kind."""
    if isinstance(a, Unread) or isinstance(b, Unread):
        return a if isinstance(a, Unread) else b
    if isinstance(a, Expr) and isinstance(b, Expr):
        return a + b
    if isinstance(a, Vec) and isinstance(b, Vec):
        return a + b
    if isinstance(a, Dyad) and isinstance(b, Dyad):
        return a + b
    if isinstance(a, FileMatrix) and isinstance(b, FileMatrix) and [len(r) for r in a.rows] == [len(r) for r in b.rows]:
        return FileMatrix(
            tuple(
                tuple(plus(x, y, line) for x, y in zip(p, q, strict=True)) for p, q in zip(a.rows, b.rows, strict=True)
            )
        )
    for x, other in ((a, b), (b, a)):
        if isinstance(x, Expr) and constant_value(x) == 0:
            return other
    raise line.refuse("terms of one kind in a sum", f"{_kind(a)} and {_kind(b)}")


def times(a: Value, b: Value, line: Line) -> Value:
    """The product: a scalar times any value, a product of matrices, or the dyad of two vectors."""
    if isinstance(a, Unread) or isinstance(b, Unread):
        return a if isinstance(a, Unread) else b
    if isinstance(b, Expr) and not isinstance(a, Expr):
        a, b = b, a
    if isinstance(a, Expr):
        if isinstance(b, Expr):
            return a * b
        if isinstance(b, Vec | Dyad):
            return b.times(a)
        factor = a
        return b.map(lambda x: times(factor, x, line))
    if isinstance(a, Vec) and isinstance(b, Vec):
        return Dyad(((a, b),))
    if isinstance(a, FileMatrix) and isinstance(b, FileMatrix) and len(a.rows[0]) == len(b.rows):
        columns = tuple(zip(*b.rows, strict=True))
        return FileMatrix(tuple(tuple(_inner(row, column, line) for column in columns) for row in a.rows))
    raise line.refuse("factors that can be multiplied", f"{_kind(a)} and {_kind(b)}")


def _inner(row: Iterable[Value], column: Iterable[Value], line: Line) -> Value:
    total: Value = ZERO
    for x, y in zip(row, column, strict=True):
        total = plus(total, times(x, y, line), line)
    return total


def over(a: Value, b: Value, line: Line) -> Value:
    """a / b for a scalar b."""
    if isinstance(a, Unread) or isinstance(b, Unread):
        return a if isinstance(a, Unread) else b
    if not isinstance(b, Expr):
        raise line.refuse("a scalar to divide by", _kind(b))
    if constant_value(b) == 0:
        raise line.refuse("a divisor other than zero", "0")
    if isinstance(a, Expr):
        return a / b
    return times(ONE / b, a, line)


def _beside(row: Sequence[Value], line: Line) -> list[tuple[Value, ...]]:
    """Rows of a matrix from blocks next to each other."""
    blocks = [x.rows if isinstance(x, FileMatrix) else ((x,),) for x in row]
    if len({len(b) for b in blocks}) > 1:
        raise line.refuse("blocks of as many rows side by side", ", ".join(str(len(b)) for b in blocks))
    return [tuple(x for part in parts for x in part) for parts in zip(*blocks, strict=True)]


def quantity(reading: FileReading, expr: Any, unit: Any, line: Line) -> Value:
    """An expression followed by a unit, in the file's units; only degrees change its value."""
    value = reading.value(expr, line)
    return value if unit is None else times(value, as_expr(factor_of(unit, reading.sheet.units, line)), line)


def _kind(value: object) -> str:
    words = {Vec: "a vector", Dyad: "a dyadic", FileMatrix: "a matrix", Unread: "an output"}
    return words.get(type(value), "a scalar")


def _called(calls: dict[str, Call], token: Any, what: str, line: Line) -> Call:
    """The table's entry for a name, regardless of case."""
    name = str(token)
    call = calls.get(name.lower())
    if call is None and name.lower().startswith("get"):  # methods named Get… do not change the model
        return lambda r, args, line: Unread(f"what {name}(…) gives")
    if call is None:
        cure = alike(name.lower(), calls).strip()
        raise line.refuse(what, f"{name} at column {_column(token, line)}", cure)
    return call


def _column(token: Any, line: Line) -> int:
    return line.column + int(getattr(token, "column", 1)) - 1
