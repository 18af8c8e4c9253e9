# SPDX-License-Identifier: BSD-3-Clause
"""A kernel whose values of several numbers side by side are as many values: so its instances may be side by side instead."""

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
"""What gives one number of the halves of several, again and again."""


def narrowed(kernel: Kernel) -> Kernel:
    """The kernel with values and cells of width 1 alone, which computes the same bits."""
    narrow = _Narrow(_last(kernel.body))
    body = narrow.block(kernel.body)
    return replace(kernel, body=body, cells=tuple(one for cell in kernel.cells for one in _cells(cell)))


def _last(block: Block) -> int:
    """A number beyond those of all values."""
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
    """The values so far: of each wide one its `parts`, by its number."""

    def __init__(self, last: int) -> None:
        self.last = last
        self.parts: dict[int, list[Operand]] = {}

    def new(self, type_: Type) -> Value:
        """A value that nothing else is."""
        self.last += 1
        return Value(self.last, Type(type_.kind))

    def apart(self, operand: Operand) -> list[Operand]:
        """The numbers of an operand, one after the other."""
        if isinstance(operand, Immediate) and isinstance(operand.value, tuple):
            return [Immediate(FLOAT, v) for v in operand.value]
        return self.parts[operand.number] if isinstance(operand, Value) and operand.number in self.parts else [operand]

    def split(self, value: Operand) -> list[Operand]:
        """New values for a wide one."""
        assert isinstance(value, Value)
        self.parts[value.number] = [self.new(value.type) for _ in range(value.type.width)]
        return self.parts[value.number]

    def block(self, block: Block) -> Block:
        """The statements of a block."""
        return tuple(one for s in block for one in self.statement(s))

    def statement(self, s: Statement) -> list[Statement]:
        """A statement as one or several."""
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
        """Numbers side by side in an array."""
        width = type_of(s.value).width
        if width == 1:
            return [s]
        own, done = self.split(s.value) if isinstance(s, Read) else self.apart(s.value), list[Statement]()
        for k, value in enumerate(own):
            at = self.new(INT)
            done += [Compute(at, "add", (s.offset, Immediate(INT, k))), s._replace(value=value, offset=at)]
        return done

    def compute(self, s: Compute) -> list[Statement]:
        """An operation on each number, or one that gives one number of several."""
        arguments = [self.apart(a) for a in s.arguments]
        if s.op == "lane":
            return [Compute(s.value, "max", (arguments[0][s.lane],) * 2)]  # itself
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
        """The halves combined, until one number is left."""
        done: list[Statement] = []
        while len(parts) > 1:
            half = len(parts) // 2
            made: list[Operand] = [self.new(type_of(parts[0])) for _ in range(half)] if half > 1 else [s.value]
            done += [Compute(v, _FOLDS[str(s.op)], (parts[k], parts[half + k])) for k, v in enumerate(made)]
            parts = made
        return done
