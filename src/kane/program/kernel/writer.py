# SPDX-License-Identifier: BSD-3-Clause
"""A builder of kernels in Python: arithmetic on `Term`s adds statements to the current block.

Linear algebra below works on small square matrices, stored in row-major order in an array from an index on.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from typing import Literal, TypeAlias

from kane.program.kernel import language
from kane.program.kernel.language import (
    FLOAT,
    INT,
    Address,
    Operand,
    Type,
    Value,
    result_type,
    verified_kernel,
    without_unused,
)


class Term:
    """A value of the kernel under construction."""

    __slots__ = ("operand", "writer")

    def __init__(self, writer: Writer, operand: Operand) -> None:
        self.writer, self.operand = writer, operand

    def __add__(self, other: Given) -> Term:
        return self.writer.compute("add", self, other)

    def __radd__(self, other: Given) -> Term:
        return self.writer.compute("add", other, self)

    def __sub__(self, other: Given) -> Term:
        return self.writer.compute("sub", self, other)

    def __rsub__(self, other: Given) -> Term:
        return self.writer.compute("sub", other, self)

    def __mul__(self, other: Given) -> Term:
        return self.writer.compute("mul", self, other)

    def __rmul__(self, other: Given) -> Term:
        return self.writer.compute("mul", other, self)

    def __truediv__(self, other: Given) -> Term:
        return self.writer.compute("div", self, other)

    def __rtruediv__(self, other: Given) -> Term:
        return self.writer.compute("div", other, self)

    def __neg__(self) -> Term:
        return self.writer.compute("neg", self)

    def __lt__(self, other: Given) -> Term:
        return self.writer.compute("less", self, other)

    def __le__(self, other: Given) -> Term:
        return self.writer.compute("at_most", self, other)

    def __gt__(self, other: Given) -> Term:
        return self.writer.compute("less", other, self)

    def __ge__(self, other: Given) -> Term:
        return self.writer.compute("at_most", other, self)

    def equals(self, other: Given) -> Term:
        """Whether two numbers are equal."""
        return (self <= other) & (self >= other)

    def __and__(self, other: Given) -> Term:
        return self.writer.compute("and", self, other)

    def __or__(self, other: Given) -> Term:
        return self.writer.compute("or", self, other)

    def __invert__(self) -> Term:
        return self.writer.compute("not", self)


Given: TypeAlias = Term | float | int | tuple[float, ...]


class Array:
    """An array: `array[i]` reads and writes an element, `lanes(i, width)` reads consecutive ones."""

    def __init__(self, writer: Writer, argument: language.ArrayOf) -> None:
        self.writer, self.argument = writer, argument

    def __getitem__(self, index: Given) -> Term:
        return self.lanes(index, 1)

    def __setitem__(self, index: Given, value: Given) -> None:
        self.writer.add(language.Write(self.writer.operand(value, FLOAT), *self.at(index)))

    def lanes(self, index: Given, width: int) -> Term:
        """The `width` consecutive doubles from an index."""
        value = self.writer.new(Type("float", width))
        self.writer.add(language.Read(value, *self.at(index)))
        return Term(self.writer, value)

    def store(self, index: Given, value: Term) -> None:
        """Stores the lanes of a value to consecutive elements from an index."""
        self.writer.add(language.Write(value.operand, *self.at(index)))

    def at(self, index: Given) -> Address:
        """A pointer to an element, as an argument of calls."""
        return Address(self.argument.name, self.writer.operand(index, INT))


class Variable:
    """A cell."""

    def __init__(self, writer: Writer, cell: language.Cell) -> None:
        self.writer, self.cell = writer, cell

    def get(self) -> Term:
        """Its current value."""
        value = self.writer.new(self.cell.type)
        self.writer.add(language.Get(value, self.cell))
        return Term(self.writer, value)

    def put(self, value: Given) -> None:
        """Assigns `value` to it."""
        self.writer.add(language.Put(self.cell, self.writer.operand(value, self.cell.type)))


class Writer:
    """A kernel under construction."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.arguments: list[language.Argument] = []
        self.cells: list[language.Cell] = []
        self.blocks: list[list[language.Statement]] = [[]]
        self.values = 0
        self.hoists: dict[str, Callable[..., None] | None] = {}

    def finished(self, result: Variable) -> language.Kernel:
        """The kernel, without dead code and verified; `result` is the cell of the returned integer."""
        (body,) = self.blocks
        kernel = language.Kernel(self.name, tuple(self.arguments), tuple(self.cells), tuple(body), result.cell)
        return without_unused(verified_kernel(kernel))

    # ------------------------------------------------------------------------------------------ arguments and cells

    def array(self, name: str) -> Array:
        """Adds an argument: an array of doubles."""
        self.arguments.append(language.ArrayOf(name))
        return Array(self, language.ArrayOf(name))

    def number(self, name: str) -> Term:
        """Adds an argument: an integer."""
        value = self.new(INT)
        self.arguments.append(language.Integer(name, value))
        return Term(self, value)

    def callee(self, name: str, *takes: Literal["float", "array"]) -> Callable[..., None]:
        """Adds an argument: a routine. Calling the result with terms and addresses adds a call."""
        callee = language.Callee(name, takes)
        self.arguments.append(callee)

        def call(*given: Given | Address) -> None:
            pairs = zip(given, takes, strict=True)
            own = tuple(g if isinstance(g, Address) else self.operand(g, FLOAT) for g, _ in pairs)
            self.add(language.CallRoutine(callee, own))

        return call

    def hoisted(self, name: str) -> Array:
        """Adds an argument: the array of hoisted values h of a routine."""
        self.hoists[name] = None
        return self.array(name)

    def rehoist(self, p: Array) -> None:
        """Adds calls that compute the hoisted values of all routines for the parameters p; adds an argument `hoist_…` for each."""
        for name, hoist in self.hoists.items():
            self.hoists[name] = known = hoist or self.callee(f"hoist_{name}", "array", "array")
            known(p.at(0), Address(name, self.operand(0, INT)))

    def variable(self, name: str, type_: Type = FLOAT) -> Variable:
        """Adds a cell, initially zero."""
        cell = language.Cell(name, type_)
        self.cells.append(cell)
        return Variable(self, cell)

    # --------------------------------------------------------------------------------------------------- statements

    def add(self, statement: language.Statement) -> None:
        """Adds a statement to the current block."""
        self.blocks[-1].append(statement)

    def new(self, type_: Type) -> Value:
        """A new value."""
        self.values += 1
        return Value(self.values, type_)

    def operand(self, given: Given, type_: Type) -> Operand:
        """A term's operand, or a constant of the given type; a number for a vector type is in each lane."""
        if isinstance(given, Term):
            return given.operand
        if type_.width > 1 and not isinstance(given, tuple):
            return language.Immediate(type_, (float(given),) * type_.width)
        return language.Immediate(type_, given if isinstance(given, tuple) else (int if type_ == INT else float)(given))

    def integer(self, value: int) -> Term:
        """An integer constant."""
        return Term(self, language.Immediate(INT, value))

    def constant(self, value: float) -> Term:
        """A double constant."""
        return Term(self, language.Immediate(FLOAT, value))

    def lanes(self, *values: float) -> Term:
        """A vector constant."""
        return Term(self, language.Immediate(Type("float", len(values)), values))

    def compute(self, op: str, *given: Given, lane: int = 0) -> Term:
        """The result of an operation; Python numbers get the type of the first term."""
        types = (language.type_of(g.operand) for g in given if isinstance(g, Term))
        type_ = next((t for t in types if t.kind != "bool"), FLOAT)
        operands = tuple(self.operand(g, type_) for g in given)
        value = self.new(result_type(op, [language.type_of(o) for o in operands]))
        self.add(language.Compute(value, op, operands, lane))
        return Term(self, value)

    def select(self, condition: Term, a: Given, b: Given) -> Term:
        """a where the condition is true, else b."""
        return self.compute("select", condition, a, b)

    def sum(self, terms: Sequence[Term]) -> Term:
        """The sum of terms by pairwise summation, which shortens the chain of dependent operations."""
        terms = list(terms)
        while len(terms) > 1:
            pairs = [terms[k] + terms[k + 1] for k in range(0, len(terms) - 1, 2)]
            terms = pairs + terms[len(pairs) * 2 :]
        return terms[0]

    @contextmanager
    def _block(self) -> Iterator[list[language.Statement]]:
        block: list[language.Statement] = []
        self.blocks.append(block)
        yield block
        assert self.blocks.pop() is block

    @contextmanager
    def count(self, stop: Given, start: Given = 0, few: bool = False) -> Iterator[Term]:
        """A for loop from `start` to before `stop`; `few` marks a loop known to be short."""
        index = self.new(INT)
        with self._block() as body:
            yield Term(self, index)
        self.add(language.For(index, self.operand(start, INT), self.operand(stop, INT), tuple(body), few))

    def few(self, stop: Given, start: Given = 0) -> AbstractContextManager[Term]:
        """`count` with few=True."""
        return self.count(stop, start, few=True)

    @contextmanager
    def repeat(self, condition: Callable[[], Term]) -> Iterator[None]:
        """A while loop; the condition is computed before each iteration."""
        with self._block() as head:
            again = condition()
        with self._block() as body:
            yield
        self.add(language.While(tuple(head), again.operand, tuple(body)))

    @contextmanager
    def when(self, condition: Term) -> Iterator[None]:
        """A block that runs if the condition is true; `otherwise` may follow."""
        with self._block() as then:
            yield
        self.add(language.If(condition.operand, tuple(then), ()))

    @contextmanager
    def otherwise(self) -> Iterator[None]:
        """A block that runs if the condition of the preceding `when` is false."""
        last = self.blocks[-1].pop()
        assert isinstance(last, language.If)
        assert not last.other, "a choice has one other block"
        with self._block() as other:
            yield
        self.add(language.If(last.condition, last.then, tuple(other)))


def total(w: Writer, count: Given, term: Callable[[Term], Term]) -> Term:
    """The sum of a term over the integers below `count`."""
    cell = w.variable(f"total{len(w.cells)}")
    cell.put(0.0)
    with w.few(count) as k:
        cell.put(cell.get() + term(k))
    return cell.get()


def unit(i: Term, j: Term) -> Term:
    """Entry (i, j) of the unit matrix."""
    return i.writer.select(i.equals(j), 1.0, 0.0)


def largest_below(a: Array, rows: Callable[[Term], Term], stop: Term, k: Term, best: Variable, place: Variable) -> None:
    """Puts the row from k on with the largest entry in column k to `place`; `rows` gives the index of a row's first element."""
    w = a.writer
    with w.few(stop, k) as i:
        tall = w.compute("abs", a[rows(i) + k])
        with w.when(tall > best.get()):
            best.put(tall)
            place.put(i)


def factor(a: Array, at: Term, width: Term, count: Term) -> None:
    """Replaces the lower triangle of the leading `count` rows, of length `width`, by the Cholesky factor L; the rest is not read."""
    w = a.writer
    with w.few(count) as i, w.few(i + 1) as j:
        row, above = at + i * width, at + j * width
        rest = a[row + j] - total(w, j, lambda k: a[row + k] * a[above + k])
        with w.when(j < i):
            a[row + j] = rest / a[above + j]
        with w.otherwise():
            a[row + j] = w.compute("sqrt", rest)


def solve(a: Array, at: Term, width: Term, count: Term, x: Term) -> None:
    """Replaces the `count` doubles b at `x`, in the same array, by the solution of L Lᵀ x = b."""
    w = a.writer
    with w.few(count) as i:
        row = at + i * width
        a[x + i] = (a[x + i] - total(w, i, lambda k: a[row + k] * a[x + k])) / a[row + i]
    with w.few(count) as done:
        i = count - done - 1
        below = total(w, done, lambda k: a[at + (i + k + 1) * width + i] * a[x + i + k + 1])
        a[x + i] = (a[x + i] - below) / a[at + i * width + i]


def invert(a: Array, at: Term, size: Term) -> None:
    """Replaces the right half of the rows [B | 1], of length 2 `size`, by B⁻¹: Gauss–Jordan elimination with partial pivoting."""
    w, width = a.writer, size * 2
    best, place = w.variable(f"best{len(w.cells)}"), w.variable(f"place{len(w.cells)}", INT)
    with w.few(size) as k:
        best.put(-1.0)
        largest_below(a, lambda i: at + i * width, size, k, best, place)
        row, other = at + k * width, at + place.get() * width
        with w.few(width) as j:
            mine, theirs = a[row + j], a[other + j]
            a[other + j] = mine
            a[row + j] = theirs
        pivot = 1.0 / a[row + k]
        with w.few(width) as j:
            a[row + j] = a[row + j] * pivot
        with w.few(size) as i, w.when((i < k) | (k < i)):
            share = a[at + i * width + k]
            with w.few(width) as j:
                a[at + i * width + j] = a[at + i * width + j] - share * a[row + j]


def decompose(a: Array, at: Term, size: Term, swaps: Term) -> None:
    """Replaces the square matrix at `at` by its factors L and U with partial pivoting; row exchanges are stored at `swaps`."""
    w = a.writer
    best, place = w.variable(f"best{len(w.cells)}"), w.variable(f"place{len(w.cells)}", INT)
    with w.few(size) as k:
        best.put(-1.0)
        place.put(k)
        largest_below(a, lambda i: at + i * size, size, k, best, place)
        row, other = at + k * size, at + place.get() * size
        a[swaps + k] = w.compute("float", place.get())
        with w.when(k < place.get()), w.count(size) as j:
            mine, theirs = a[row + j], a[other + j]
            a[other + j] = mine
            a[row + j] = theirs
        pivot = 1.0 / a[row + k]
        with w.few(size, k + 1) as i:
            below = at + i * size
            share = a[below + k] * pivot
            a[below + k] = share
            with w.count(size, k + 1) as j:
                a[below + j] = a[below + j] - share * a[row + j]


def substitute(a: Array, at: Term, size: Term, swaps: Term, x: Term) -> None:
    """Replaces the doubles b at `x`, in the same array, by the solution for the matrix that `decompose` has factored."""
    w = a.writer
    with w.few(size) as k:
        other = w.compute("int", a[swaps + k])
        mine, theirs = a[x + k], a[x + other]
        a[x + other] = mine
        a[x + k] = theirs
    with w.few(size) as i:
        a[x + i] = a[x + i] - total(w, i, lambda k: a[at + i * size + k] * a[x + k])
    with w.few(size) as done:
        i = size - done - 1
        behind = total(w, done, lambda k: a[at + i * size + i + 1 + k] * a[x + i + 1 + k])
        a[x + i] = (a[x + i] - behind) / a[at + i * size + i]
