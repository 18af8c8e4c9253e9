# SPDX-License-Identifier: BSD-3-Clause
"""Kernels written as Python: arithmetic on `Term`s adds statements to the block at hand."""

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
    """A value of the kernel that is being written."""

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
        """Whether it is the same number."""
        return (self <= other) & (self >= other)

    def __and__(self, other: Given) -> Term:
        return self.writer.compute("and", self, other)

    def __or__(self, other: Given) -> Term:
        return self.writer.compute("or", self, other)

    def __invert__(self) -> Term:
        return self.writer.compute("not", self)


Given: TypeAlias = Term | float | int | tuple[float, ...]


class Array:
    """An array: `array[i]` reads and writes a number, `lanes(i, width)` reads several."""

    def __init__(self, writer: Writer, argument: language.ArrayOf) -> None:
        self.writer, self.argument = writer, argument

    def __getitem__(self, index: Given) -> Term:
        return self.lanes(index, 1)

    def __setitem__(self, index: Given, value: Given) -> None:
        self.writer.add(language.Write(self.writer.operand(value, FLOAT), *self.at(index)))

    def lanes(self, index: Given, width: int) -> Term:
        """The `width` doubles from an index on."""
        value = self.writer.new(Type("float", width))
        self.writer.add(language.Read(value, *self.at(index)))
        return Term(self.writer, value)

    def store(self, index: Given, value: Term) -> None:
        """The doubles from an index on become those of a value."""
        self.writer.add(language.Write(value.operand, *self.at(index)))

    def at(self, index: Given) -> Address:
        """A place, for calls."""
        return Address(self.argument.name, self.writer.operand(index, INT))


class Variable:
    """A cell."""

    def __init__(self, writer: Writer, cell: language.Cell) -> None:
        self.writer, self.cell = writer, cell

    def get(self) -> Term:
        """What it holds now."""
        value = self.writer.new(self.cell.type)
        self.writer.add(language.Get(value, self.cell))
        return Term(self.writer, value)

    def put(self, value: Given) -> None:
        """It holds `value` from now on."""
        self.writer.add(language.Put(self.cell, self.writer.operand(value, self.cell.type)))


class Writer:
    """A kernel while it is written."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.arguments: list[language.Argument] = []
        self.cells: list[language.Cell] = []
        self.blocks: list[list[language.Statement]] = [[]]
        self.values = 0

    def finished(self, result: Variable) -> language.Kernel:
        """The kernel, verified, without what nothing reads."""
        (body,) = self.blocks
        kernel = language.Kernel(self.name, tuple(self.arguments), tuple(self.cells), tuple(body), result.cell)
        return without_unused(verified_kernel(kernel))

    # ------------------------------------------------------------------------------------------ arguments and cells

    def array(self, name: str) -> Array:
        """An argument: doubles."""
        self.arguments.append(language.ArrayOf(name))
        return Array(self, language.ArrayOf(name))

    def number(self, name: str) -> Term:
        """An argument: an integer."""
        value = self.new(INT)
        self.arguments.append(language.Integer(name, value))
        return Term(self, value)

    def callee(self, name: str, *takes: Literal["float", "array"]) -> Callable[..., None]:
        """An argument: a routine. Called with terms and places it adds the call."""
        callee = language.Callee(name, takes)
        self.arguments.append(callee)

        def call(*given: Given | Address) -> None:
            pairs = zip(given, takes, strict=True)
            own = tuple(g if isinstance(g, Address) else self.operand(g, FLOAT) for g, _ in pairs)
            self.add(language.CallRoutine(callee, own))

        return call

    def variable(self, name: str, type_: Type = FLOAT) -> Variable:
        """A cell, zero at first."""
        cell = language.Cell(name, type_)
        self.cells.append(cell)
        return Variable(self, cell)

    # --------------------------------------------------------------------------------------------------- statements

    def add(self, statement: language.Statement) -> None:
        """One more statement in the block at hand."""
        self.blocks[-1].append(statement)

    def new(self, type_: Type) -> Value:
        """A value with a number of its own."""
        self.values += 1
        return Value(self.values, type_)

    def operand(self, given: Given, type_: Type) -> Operand:
        """A term's operand, or a constant of a type: a number that is given for several lanes is in each."""
        if isinstance(given, Term):
            return given.operand
        if type_.width > 1 and not isinstance(given, tuple):
            return language.Immediate(type_, (float(given),) * type_.width)
        return language.Immediate(type_, given if isinstance(given, tuple) or type_.kind == "int" else float(given))

    def integer(self, value: int) -> Term:
        """A constant."""
        return Term(self, language.Immediate(INT, value))

    def constant(self, value: float) -> Term:
        """A constant."""
        return Term(self, language.Immediate(FLOAT, value))

    def lanes(self, *values: float) -> Term:
        """A constant of several lanes."""
        return Term(self, language.Immediate(Type("float", len(values)), values))

    def compute(self, op: str, *given: Given, lane: int = 0) -> Term:
        """The result of an operation; numbers take the type of the first term."""
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
        """Terms added in pairs, then pairs of pairs: the chain of operations is short."""
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
        """The block for each integer from `start` to before `stop`; these may be known to be `few`."""
        index = self.new(INT)
        with self._block() as body:
            yield Term(self, index)
        self.add(language.Count(index, self.operand(start, INT), self.operand(stop, INT), tuple(body), few))

    def few(self, stop: Given, start: Given = 0) -> AbstractContextManager[Term]:
        """`count`, where the integers are few."""
        return self.count(stop, start, few=True)

    @contextmanager
    def repeat(self, condition: Callable[[], Term]) -> Iterator[None]:
        """The block as long as the condition, computed anew each time, is true."""
        with self._block() as head:
            again = condition()
        with self._block() as body:
            yield
        self.add(language.While(tuple(head), again.operand, tuple(body)))

    @contextmanager
    def when(self, condition: Term) -> Iterator[None]:
        """The block where the condition is true; `otherwise` may follow."""
        with self._block() as then:
            yield
        self.add(language.If(condition.operand, tuple(then), ()))

    @contextmanager
    def otherwise(self) -> Iterator[None]:
        """The block where the condition of the `when` just before is false."""
        last = self.blocks[-1].pop()
        assert isinstance(last, language.If)
        assert not last.other, "a choice has one other block"
        with self._block() as other:
            yield
        self.add(language.If(last.condition, last.then, tuple(other)))
