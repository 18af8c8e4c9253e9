# SPDX-License-Identifier: BSD-3-Clause
"""Kernels from kernels: specialization to known integers, and scalarization. The results are the same bits.

Where integers are known, constants are propagated, branches on them resolved, and array offsets made constant. Floating-point
operations and their order are unchanged. An index at a constant distance from another one is computed at its use, because the targets
add constant offsets to addresses at no cost.

In a scalarized kernel vector values are several scalar values, so that lanes can hold instances of the kernel instead.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from kane.program.kernel import language
from kane.program.kernel.language import INT, Block, Compute, Immediate, Kernel, Operand, Statement, Value, type_of

_FOLDED: Mapping[str, Callable[..., Any]] = {
    "add": lambda a, b: a + b,
    "sub": lambda a, b: a - b,
    "mul": lambda a, b: a * b,
    "less": lambda a, b: a < b,
    "at_most": lambda a, b: a <= b,
    "and": lambda a, b: a and b,
    "or": lambda a, b: a or b,
    "not": lambda a: not a,
    "float": float,
}
"""The folding of operations on integers and truth values."""


def specialized(kernel: Kernel, integers: Mapping[str, int]) -> Kernel:
    """The kernel with constants for these integers, which are no longer arguments, and without unused arguments."""
    known = {
        a.value: integers[a.name] for a in kernel.arguments if isinstance(a, language.Integer) and a.name in integers
    }
    body = _Specializer(kernel, {v: Immediate(INT, k) for v, k in known.items()}).block(kernel.body)
    arguments = tuple(a for a in kernel.arguments if not (isinstance(a, language.Integer) and a.name in integers))
    found = language.without_unused(replace(kernel, arguments=arguments, body=body))
    used = _names(found.body)
    own = tuple(a for a in arguments if isinstance(a, language.Integer) or a.name in used)
    return language.verified_kernel(replace(found, arguments=own))


class _Specializer:
    """The replacements of values, and the values at a constant distance from another one."""

    def __init__(self, kernel: Kernel, known: dict[Value, Operand]) -> None:
        self.known = known
        self.apart: dict[Value, tuple[Value, int]] = {}
        self.last = max(language.numbers(kernel.body), default=0) + len(kernel.arguments)
        self.done: list[Statement] = []

    def block(self, block: Block) -> Block:
        """The specialized block."""
        outer, self.done = self.done, []
        for s in block:
            self.statement(s)
        own, self.done = self.done, outer
        return tuple(own)

    def operand(self, operand: Operand) -> Operand:
        """The replacement of an operand; adds the statement that computes it from another value and a distance, if any."""
        operand = self.plain(operand)
        if isinstance(operand, Value) and operand in self.apart:
            base, distance = self.apart[operand]
            self.last += 1
            operand = Value(self.last, INT)
            self.done.append(Compute(operand, "add", (base, Immediate(INT, distance))))
        return operand

    def plain(self, operand: Operand) -> Operand:
        """The constant or value that replaces an operand."""
        return self.known.get(operand, operand) if isinstance(operand, Value) else operand

    def statement(self, s: Statement) -> None:
        """Adds the specialized statement."""
        if isinstance(s, Compute):
            self.compute(s)
        elif isinstance(s, language.If):
            self.choice(s)
        elif isinstance(s, language.For):
            self.count(s)
        elif isinstance(s, language.While):
            outer, self.done = self.done, []
            for one in s.head:
                self.statement(one)
            condition = self.operand(s.condition)
            head, self.done = tuple(self.done), outer
            self.done.append(language.While(head, condition, self.block(s.body)))
        elif isinstance(s, language.Read):
            self.done.append(s._replace(offset=self.operand(s.offset)))
        elif isinstance(s, language.Write):
            self.done.append(s._replace(offset=self.operand(s.offset), value=self.operand(s.value)))
        elif isinstance(s, language.Put):
            self.done.append(s._replace(value=self.operand(s.value)))
        elif isinstance(s, language.CallRoutine):
            given = tuple(
                a._replace(offset=self.operand(a.offset)) if isinstance(a, language.Address) else self.operand(a)
                for a in s.arguments
            )
            self.done.append(s._replace(arguments=given))
        else:
            self.done.append(s)

    def choice(self, s: language.If) -> None:
        """Adds an if statement, or the branch taken if its condition is known."""
        condition = self.operand(s.condition)
        if isinstance(condition, Immediate):
            for one in s.then if condition.value else s.other:
                self.statement(one)
        else:
            self.done.append(language.If(condition, self.block(s.then), self.block(s.other)))

    def count(self, s: language.For) -> None:
        """Adds a for loop, unless it has no iteration."""
        start, stop = self.operand(s.start), self.operand(s.stop)
        if isinstance(start, Immediate) and isinstance(stop, Immediate) and start.value >= stop.value:  # type: ignore[operator]
            return
        self.done.append(s._replace(start=start, stop=stop, body=self.block(s.body)))

    def compute(self, s: Compute) -> None:
        """Adds an operation, unless its result is known."""
        value, op = s.value, str(s.op)
        assert isinstance(value, Value)
        given = [self.plain(a) for a in s.arguments]
        if type_of(given[0]) in (INT, language.BOOL) and value.type in (INT, language.BOOL, language.FLOAT):
            found = self.result(op, value, given)
            if found is not None:
                self.known[value] = found
                return
            if op in ("add", "sub") and isinstance(given[1], Immediate) and isinstance(given[0], Value):
                self.at_distance(value, given[0], given[1], 1 if op == "add" else -1)
                return
            if op == "add" and isinstance(given[0], Immediate) and isinstance(given[1], Value):
                self.at_distance(value, given[1], given[0], 1)
                return
        self.done.append(s._replace(arguments=tuple(map(self.operand, s.arguments))))

    def at_distance(self, value: Value, base: Value, distance: Immediate, sign: int) -> None:
        """Records a value at a constant distance from another one."""
        before, between = self.apart.get(base, (base, 0))
        assert isinstance(distance.value, int)
        self.apart[value] = before, between + sign * distance.value

    def result(self, op: str, value: Value, given: list[Operand]) -> Operand | None:
        """The known result of an operation on integers or truth values, else None."""
        numbers = [a.value for a in given if isinstance(a, Immediate)]
        if op == "select" and isinstance(given[0], Immediate):
            return given[1] if given[0].value else given[2]
        if len(numbers) == len(given) and op in _FOLDED:
            return Immediate(value.type, _FOLDED[op](*numbers))
        if op in ("and", "or") and numbers:
            other = next(a for a in given if not isinstance(a, Immediate))
            return other if bool(numbers[0]) == (op == "and") else Immediate(language.BOOL, op == "or")
        if op in ("add", "sub") and isinstance(given[1], Immediate) and given[1].value == 0:
            return given[0]
        return None


def _names(block: Block) -> set[str]:
    """The names of the arrays and routines that a block uses."""
    result: set[str] = set()
    for s in block:
        if isinstance(s, language.Read | language.Write):
            result.add(s.base)
        elif isinstance(s, language.CallRoutine):
            result |= {s.callee.name, *(a.base for a in s.arguments if isinstance(a, language.Address))}
        for inner in language.blocks(s):
            result |= _names(inner)
    return result


_FOLDS = {"sum": "add", "largest": "max", "any": "or"}
"""The binary operation of each reduction over lanes."""


def narrowed(kernel: Kernel) -> Kernel:
    """The kernel with values and cells of width 1 only, which computes the same bits."""
    narrow = _Narrow(max(language.numbers(kernel.body), default=0))
    body = narrow.block(kernel.body)
    return replace(kernel, body=body, cells=tuple(one for cell in kernel.cells for one in _cells(cell)))


def _cells(cell: language.Cell) -> list[language.Cell]:
    if cell.type.width == 1:
        return [cell]
    return [language.Cell(f"{cell.name}_{k}", language.Type(cell.type.kind)) for k in range(cell.type.width)]


class _Narrow:
    """The values so far; `parts` maps the number of a vector value to its scalar values."""

    def __init__(self, last: int) -> None:
        self.last = last
        self.parts: dict[int, list[Operand]] = {}

    def new(self, type_: language.Type) -> Value:
        """A new value."""
        self.last += 1
        return Value(self.last, language.Type(type_.kind))

    def apart(self, operand: Operand) -> list[Operand]:
        """The scalar operands of an operand, lane by lane."""
        if isinstance(operand, Immediate) and isinstance(operand.value, tuple):
            return [Immediate(language.FLOAT, v) for v in operand.value]
        return self.parts[operand.number] if isinstance(operand, Value) and operand.number in self.parts else [operand]

    def split(self, value: Operand) -> list[Operand]:
        """New scalar values for a vector value."""
        assert isinstance(value, Value)
        self.parts[value.number] = [self.new(value.type) for _ in range(value.type.width)]
        return self.parts[value.number]

    def block(self, block: Block) -> Block:
        """The statements of a block, scalarized."""
        return tuple(one for s in block for one in self.statement(s))

    def statement(self, s: Statement) -> list[Statement]:
        """One or more scalar statements for a statement."""
        if isinstance(s, Compute):
            return self.compute(s)
        if isinstance(s, language.Read | language.Write):
            return self.pair_access(s)
        if isinstance(s, language.Get | language.Put) and s.cell.type.width > 1:
            own = self.split(s.value) if isinstance(s, language.Get) else self.apart(s.value)
            pairs = zip(_cells(s.cell), own, strict=True)
            return [
                language.Get(v, c) if isinstance(s, language.Get) and isinstance(v, Value) else language.Put(c, v)
                for c, v in pairs
            ]
        if isinstance(s, language.If):
            return [s._replace(then=self.block(s.then), other=self.block(s.other))]
        if isinstance(s, language.While):
            return [s._replace(head=self.block(s.head), body=self.block(s.body))]
        return [s._replace(body=self.block(s.body))] if isinstance(s, language.For) else [s]

    def pair_access(self, s: language.Read | language.Write) -> list[Statement]:
        """Loads or stores of consecutive elements of an array."""
        width = type_of(s.value).width
        if width == 1:
            return [s]
        own, done = self.split(s.value) if isinstance(s, language.Read) else self.apart(s.value), list[Statement]()
        for k, value in enumerate(own):
            at = self.new(INT)
            done += [Compute(at, "add", (s.offset, Immediate(INT, k))), s._replace(value=value, offset=at)]
        return done

    def compute(self, s: Compute) -> list[Statement]:
        """An operation lane by lane, or an operation that selects or combines lanes."""
        arguments = [self.apart(a) for a in s.arguments]
        if s.op == "lane":
            return [Compute(s.value, "max", (arguments[0][s.lane],) * 2)]  # a copy
        if s.op in _FOLDS:
            return self.fold(s, arguments[0])
        if type_of(s.value).width == 1:
            return [s]
        if str(s.op).startswith("splat"):
            assert isinstance(s.value, Value)
            self.parts[s.value.number] = arguments[0] * s.value.type.width
            return []
        own = zip(self.split(s.value), *arguments, strict=True)
        return [Compute(value, s.op, tuple(given)) for value, *given in own]

    def fold(self, s: Compute, parts: list[Operand]) -> list[Statement]:
        """A reduction over lanes by repeated halving."""
        done: list[Statement] = []
        while len(parts) > 1:
            half = len(parts) // 2
            made: list[Operand] = [self.new(type_of(parts[0])) for _ in range(half)] if half > 1 else [s.value]
            done += [Compute(v, _FOLDS[str(s.op)], (parts[k], parts[half + k])) for k, v in enumerate(made)]
            parts = made
        return done
