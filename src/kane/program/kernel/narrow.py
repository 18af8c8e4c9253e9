# SPDX-License-Identifier: BSD-3-Clause
"""Scalarization of a kernel: vector values become several scalar values, so that lanes can hold instances of the kernel instead."""

from dataclasses import replace

from kane.program.kernel.language import (
    FLOAT,
    INT,
    Block,
    Cell,
    Compute,
    For,
    Get,
    If,
    Immediate,
    Kernel,
    Operand,
    Put,
    Read,
    Statement,
    Type,
    Value,
    While,
    Write,
    type_of,
)

_FOLDS = {"sum": "add", "largest": "max", "any": "or"}
"""The binary operation of each reduction over lanes."""


def narrowed(kernel: Kernel) -> Kernel:
    """The kernel with values and cells of width 1 only, which computes the same bits."""
    narrow = _Narrow(_last(kernel.body))
    body = narrow.block(kernel.body)
    return replace(kernel, body=body, cells=tuple(one for cell in kernel.cells for one in _cells(cell)))


def _last(block: Block) -> int:
    """A number larger than those of all values."""
    result = 0
    for s in block:
        for value in (getattr(s, "value", None), getattr(s, "counter", None)):
            result = max(result, value.number if isinstance(value, Value) else 0)
        for inner in ("then", "other", "head", "body"):
            result = max(result, _last(getattr(s, inner, ())))
    return result


def _cells(cell: Cell) -> list[Cell]:
    if cell.type.width == 1:
        return [cell]
    return [Cell(f"{cell.name}_{k}", Type(cell.type.kind)) for k in range(cell.type.width)]


class _Narrow:
    """The values so far; `parts` maps the number of a vector value to its scalar values."""

    def __init__(self, last: int) -> None:
        self.last = last
        self.parts: dict[int, list[Operand]] = {}

    def new(self, type_: Type) -> Value:
        """A new value."""
        self.last += 1
        return Value(self.last, Type(type_.kind))

    def apart(self, operand: Operand) -> list[Operand]:
        """The scalar operands of an operand, lane by lane."""
        if isinstance(operand, Immediate) and isinstance(operand.value, tuple):
            return [Immediate(FLOAT, v) for v in operand.value]
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
        if isinstance(s, Read | Write):
            return self.pair_access(s)
        if isinstance(s, Get | Put) and s.cell.type.width > 1:
            own = self.split(s.value) if isinstance(s, Get) else self.apart(s.value)
            pairs = zip(_cells(s.cell), own, strict=True)
            return [Get(v, c) if isinstance(s, Get) and isinstance(v, Value) else Put(c, v) for c, v in pairs]
        if isinstance(s, If):
            return [s._replace(then=self.block(s.then), other=self.block(s.other))]
        if isinstance(s, While):
            return [s._replace(head=self.block(s.head), body=self.block(s.body))]
        return [s._replace(body=self.block(s.body))] if isinstance(s, For) else [s]

    def pair_access(self, s: Read | Write) -> list[Statement]:
        """Loads or stores of consecutive elements of an array."""
        width = type_of(s.value).width
        if width == 1:
            return [s]
        own, done = self.split(s.value) if isinstance(s, Read) else self.apart(s.value), list[Statement]()
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
