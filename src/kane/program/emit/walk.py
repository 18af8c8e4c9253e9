# SPDX-License-Identifier: BSD-3-Clause
"""The functions of a Program as sequences of statements independent of the target language, and the base class of printers.

A `Function` computes results by the instructions of a block; a long block is cut into pieces. The statements of a piece read values
from ports, from the vector h of hoisted values or from the work array w that passes values between pieces, compute, and write results
and slots of w. Constants and scalar ports are operands and need no statement.

`Printer` has a method for each kind of statement, and collects lines and indented blocks.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from kane.expr.ops import COS, OPS, SIN, Op
from kane.program.kernel import language
from kane.program.kernel.language import Compute, Read, SinCos, Statement, Write
from kane.program.passes.limbs import gathered
from kane.program.program import CHUNK, WHOLE, Chunk, Port, Program, Routine, Split, split

KEPT, WORK, RESULTS = "<h>", "<w>", "<out>"
"""The names of the vectors of hoisted values, of values passed between pieces, and of results; no port has such a name."""
VECTORS = {KEPT: "h", WORK: "w", RESULTS: "out"}
"""The names of these vectors in emitted code."""


@dataclass(frozen=True, slots=True, eq=False)
class Function:
    """Computes `results`, in this order, in `target` by the instructions of `block`, reading `ports` and the values `kept` in h.

    `places` maps each value that is read from a vector to the vector and the index in it.
    """

    name: str
    ports: tuple[Port, ...]
    block: tuple[int, ...]
    results: tuple[int, ...]
    labels: tuple[str, ...]
    kept: tuple[int, ...]
    target: str
    places: Mapping[int, tuple[str, int]]


def hoisting(program: Program) -> Function:
    """The function that computes the hoisted values h."""
    ports = tuple(port for port in program.ports if port.hoisted)
    labels, places = ("",) * len(program.kept), _locations(program, ())
    return Function("hoist", ports, program.hoisted, program.kept, labels, (), KEPT, places)


def function_of(program: Program, routine: Routine) -> Function:
    """The function that evaluates a routine."""
    own, kept = (routine.body, routine.results, routine.labels), program.kept
    return Function(routine.name, program.ports, *own, kept, RESULTS, _locations(program, kept))


def _locations(program: Program, kept: Sequence[int]) -> dict[int, tuple[str, int]]:
    """The vector and index of each value of a vector port, and of each value in `kept`."""
    ports = ((port, k) for port in program.ports for k in range(len(port.symbols)))
    vectors = {i: (port.name, k) for i, (port, k) in enumerate(ports) if not port.scalar}
    return vectors | {i: (KEPT, k) for k, i in enumerate(kept)}


@dataclass(frozen=True, slots=True)
class Style:
    """How statements are scheduled for a language.

    `lazy`: a value is read just before its first use and written as soon as it is computed; else all reads come first and writes last.
    `lanes`: 0 if sine and cosine are separate operations; 1 if those of one angle are one statement; n if one statement computes those
    of up to n angles available at that point. A block of more than `whole` instructions is cut into pieces of at most `piece`.
    """

    lazy: bool = False
    lanes: int = 0
    whole: float = WHOLE
    piece: int = CHUNK


def pieces(program: Program, function: Function, style: Style) -> Split:
    """The pieces of a function; a short function is one piece."""
    block = function.block
    if style.lanes > 1 and len(block) > style.whole:
        block = gathered(program, block, style.lanes)
    return split(program, block, style.whole, style.piece, function.results)


def statements(program: Program, function: Function, piece: Chunk, style: Style) -> list[Statement]:
    """The statements of a piece, in order."""
    walk = _Walk(program, function, piece, style)
    if style.lazy:
        for i in piece.instructions:
            walk.compute(i)
            walk.write(i)
        computed = set(piece.instructions)
        for i in [i for i in piece.writes if i not in computed]:
            walk.write(i)
    else:
        walk.read_all()
        for i in piece.instructions:
            walk.compute(i)
        walk.write_all()
    return walk.done


class _Walk:
    """Collects the statements of a piece; `ready` are the values that have been read or computed."""

    def __init__(self, program: Program, function: Function, piece: Chunk, style: Style) -> None:
        self.program, self.function, self.piece, self.style = program, function, piece, style
        read = {a for i in piece.instructions for a in program.arguments(i)}.union(piece.writes)
        self.sources = {a: function.places[a] for a in read if a in function.places}
        self.sources |= {i: (WORK, slot) for i, slot in piece.loads.items()}
        self.done: list[Statement] = []
        self.ready: set[int] = set()
        self.angles: dict[int, dict[Op, int]] = {}
        for i in piece.instructions if style.lanes else ():
            if program.op(i) in (SIN, COS):
                self.angles.setdefault(program.arguments(i)[0], {}).setdefault(program.op(i), i)

    def read(self, *values: int) -> None:
        """Adds reads of the values that are not ready and not operands."""
        for i in values:
            if i in self.sources and i not in self.ready:
                self.ready.add(i)
                self.done.append(Read(i, *self.sources[i]))

    def read_all(self) -> None:
        """Adds reads of everything that the piece needs: inputs and hoisted values by number, then slots."""
        needed = {a for i in self.piece.instructions for a in self.program.arguments(i)}.union(self.piece.writes)
        self.read(*sorted(needed.difference(self.piece.loads)), *self.piece.loads)

    def compute(self, i: int) -> None:
        """Adds the instruction of value i, unless a combined sine and cosine statement has computed it."""
        if i in self.ready:
            return
        op, arguments = self.program.op(i), self.program.arguments(i)
        if self.style.lanes and op in (SIN, COS):
            if arguments[0] not in self.angles:  # an angle may have two instructions for its sine
                self.angles[arguments[0]] = {op: i}
            for angles in self._packs(arguments[0]):
                self.read(*angles)
                values = tuple(self.angles.pop(a) for a in angles)
                self.ready.update(v for own in values for v in own.values())
                self.done.append(SinCos(angles, values))
        else:
            self.read(*arguments)
            self.ready.add(i)
            self.done.append(Compute(i, op, arguments))

    def _packs(self, angle: int) -> Iterator[tuple[int, ...]]:
        """Groups of at most `lanes` available angles; the given angle alone if there is one lane."""
        angles = [a for a in self.angles if self._near(a)] if self.style.lanes > 1 else [angle]
        for k in range(0, len(angles), self.style.lanes):
            pack = tuple(angles[k : k + self.style.lanes])
            for a in pack:
                if not self._known(a):
                    self.compute(a)
            yield pack

    def _known(self, value: int) -> bool:
        """Whether a value is ready or can be read."""
        return value < self.program.first or value in self.ready or value in self.sources

    def _near(self, angle: int) -> bool:
        """Whether an angle is available, or is one operation on available values, such as q + π/2."""
        if self._known(angle):
            return True
        own = self.program.arguments(angle)
        return self.program.op(angle) not in (SIN, COS) and all(self._known(a) for a in own)

    def write(self, i: int) -> None:
        """Adds writes of value i to its slot and to its positions among the results."""
        self._write(i, WORK, [self.piece.stores[i]] if i in self.piece.stores else [])
        self._write(i, self.function.target, self.piece.writes.get(i, []))

    def write_all(self) -> None:
        """Adds writes of all slots, then of all results in order."""
        for i, slot in self.piece.stores.items():
            self._write(i, WORK, [slot])
        for place, i in sorted((place, i) for i, places in self.piece.writes.items() for place in places):
            self._write(i, self.function.target, [place])

    def _write(self, i: int, base: str, places: list[int]) -> None:
        for place in places:
            self.read(i)
            label = "" if base == WORK else self.function.labels[place]
            self.done.append(Write(i, base, place, label))


def values_read(s: Statement) -> Sequence[Any]:
    """The values that arithmetic or a store reads, without indices; a load reads none."""
    if isinstance(s, Compute):
        return s.arguments
    return s.angles if isinstance(s, SinCos) else (s.value,) if isinstance(s, Write) else ()


LIBRARY: dict[Op | str, str] = {
    OPS[n]: n for n in ("pow", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "exp", "log")
}
"""Operations that are scalar calls of C's library or of `Math`, whose last digits depend on it."""


def shared(rows: Mapping[str, str]) -> dict[Op | str, str]:
    """Forms by both the name of an operation, used in kernels, and the operation itself, used in Programs."""
    return {key: form for name, form in rows.items() for key in (name, OPS[name])}


class Printer:
    """Collects the lines of one function; a subclass for each language prints each kind of statement."""

    methods: ClassVar[Mapping[type[Any], str]] = {
        language.Compute: "compute",
        language.SinCos: "sincos",
        language.Read: "load",
        language.Write: "store",
        language.Get: "get",
        language.Put: "put",
        language.CallRoutine: "call",
        language.If: "choice",
        language.While: "loop",
        language.For: "count",
    }

    def __init__(self, depth: int = 1) -> None:
        self.lines: list[str] = []
        self.depth = depth
        # functions of the class: bound methods would make a reference cycle that keeps the printed text alive
        self._print = {kind: getattr(type(self), name, None) for kind, name in self.methods.items()}

    def add(self, *lines: str) -> None:
        """Adds lines to the current block."""
        indent = "    " * self.depth
        self.lines += [f"{indent}{line}" for line in lines]

    def block(self, block: Iterable[language.Statement]) -> None:
        """Prints statements in order."""
        printers: Mapping[type[Any], Any] = self._print
        for s in block:
            printers[type(s)](self, s)

    def indented(self, *blocks: Iterable[language.Statement]) -> None:
        """Prints blocks with one more level of indentation."""
        self.depth += 1
        for block in blocks:
            self.block(block)
        self.depth -= 1


class NamedPrinter(Printer):
    """A printer of a language with expressions; `names` are the identifiers of values, `vectors` those of vectors."""

    def __init__(
        self, depth: int, names: Mapping[int, str] | None = None, vectors: Mapping[str, str] | None = None
    ) -> None:
        super().__init__(depth)
        self.names, self.vectors = names or {}, vectors or {}
