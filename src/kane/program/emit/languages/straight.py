# SPDX-License-Identifier: BSD-3-Clause
"""Shared parts of the emitters of straight-line text: forms of statements, identifiers, the comment at the head of the file.

A `Language` describes how operations, numbers and vector elements are written; the module of the language adds the text around them.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

from kane.expr.ops import GONE, OPS, Op
from kane.program.emit import walk
from kane.program.emit.identifiers import (
    ARITHMETIC,
    IsFree,
    Names,
    c_comment,
    distinct,
    identifier,
    local_names,
    made_by,
)
from kane.program.emit.walk import hoisting
from kane.program.kernel import language
from kane.program.program import Program

WHOLE = walk.Style(whole=float("inf"))
"""Each routine in one piece, with separate operations for sines and cosines."""


def forms(rows: Mapping[str, str], functions: str = "", spelled: str = "{}({{0}})") -> dict[Op, str]:
    """Forms by operation: arithmetic, one-argument `functions` written as `spelled`, and the additional or different `rows`."""
    calls = {name: spelled.format(name) for name in functions.split()}
    return {OPS[name]: form for name, form in {**ARITHMETIC, **calls, **rows}.items()}


@dataclass(frozen=True, slots=True, eq=False)
class Language:
    """How a language writes statements.

    `forms` are in terms of {0}, {1}, …. Constant operands are `wrapped` if all operands of the operation are constants, or, with
    `all_wrapped`, if it is not arithmetic. `load` and `at_kept`, unless empty, replace `define` for loads and `at` for hoisted values.
    `first` is the index of a vector's first element. A function returns a list of results if `listed`, else it stores them.
    """

    forms: Mapping[Op, str]
    number: Callable[[float], str]
    is_free: IsFree
    comment: str
    define: str = "{0} = {1}"
    store: str = "{0} = {1}"
    at: str = "{0}[{1}]"
    at_kept: str = ""
    first: int = 0
    listed: bool = False
    load: str = ""
    wrapped: str = "{0}"
    all_wrapped: bool = False


class StraightPrinter(walk.NamedPrinter):
    """Prints the statements of one function; in a `listed` language `results` are those to return, each with its label."""

    def __init__(
        self, spoken: Language, names: Mapping[int, str], vectors: Mapping[str, str], constants: range, depth: int
    ) -> None:
        super().__init__(depth, names, vectors)
        self.spoken, self.constants = spoken, constants
        self.results: list[tuple[str, str]] = []
        self.used: set[str] = set()

    def compute(self, s: language.Compute) -> None:
        """Adds an operation."""
        constant = [a in self.constants for a in s.arguments]
        arithmetic = isinstance(s.op, Op) and s.op.name in ARITHMETIC
        wrap = all(constant) or (self.spoken.all_wrapped and not arithmetic)
        operands = [
            self.spoken.wrapped.format(self.names[int(str(a))]) if wrap and c else self.names[int(str(a))]
            for a, c in zip(s.arguments, constant, strict=True)
        ]
        assert isinstance(s.op, Op)
        self.used.add(s.op.name)
        self.add(self.spoken.define.format(self.names[int(str(s.value))], self.spoken.forms[s.op].format(*operands)))

    def load(self, s: language.Read) -> None:
        """Adds a load from a vector."""
        name = self.names[int(str(s.value))]
        self.add((self.spoken.load or self.spoken.define).format(name, self._at(s.base, s.offset)))

    def store(self, s: language.Write) -> None:
        """Adds a result."""
        name, label = self.names[int(str(s.value))], f"{self.spoken.comment} {c_comment(s.label)}" if s.label else ""
        if self.spoken.listed:
            self.results.append((name, label))
        else:
            self.add(f"{self.spoken.store.format(self._at(s.base, s.offset), name)} {label}".rstrip())

    def _at(self, base: str, offset: object) -> str:
        at = self.spoken.at_kept if base == walk.KEPT and self.spoken.at_kept else self.spoken.at
        return at.format(self.vectors[base], int(str(offset)) + self.spoken.first)


@dataclass(frozen=True, slots=True, eq=False)
class Emitted:
    """A function as printed in one language: the lines of its parts, and `used`, the names of its operations.

    `given` are the names of its arguments, `hoisting` is the call that gives h, "" in the hoisting function itself, `shape` that of a
    routine's result. `slots` is the length of the work array that passes values between parts; `results` are (value, label) in a
    listed language.
    """

    function: walk.Function
    name: str
    given: str
    hoisting: str
    shape: tuple[int, ...]
    parts: tuple[tuple[str, ...], ...]
    slots: int
    results: tuple[tuple[str, str], ...]
    used: frozenset[str]

    @property
    def target(self) -> str:
        """The name of the vector of results."""
        return walk.VECTORS[self.function.target]

    @property
    def lines(self) -> tuple[str, ...]:
        """The lines of all parts."""
        return tuple(line for part in self.parts for line in part)

    def listed(self, indent: str, name: str = "out") -> list[str]:
        """The results as a list literal, one per line."""
        rows = [f"{indent}    {text},  {label}".rstrip() for text, label in self.results]
        return [f"{indent}{name} = [", *rows, f"{indent}]"] if rows else [f"{indent}{name} = []"]


@dataclass(frozen=True, slots=True, eq=False)
class File:
    """A program in one language: the names and bodies of its functions, the hoisting function first; `names` are those of values."""

    program: Program
    prefix: str
    names: Names
    functions: tuple[Emitted, ...]

    @property
    def first(self) -> Emitted:
        """The first routine, the example in the comment at the head of the file."""
        return self.functions[min(1, len(self.program.routines))]

    @property
    def used(self) -> set[str]:
        """Names of the operations in all functions."""
        return {name for f in self.functions for name in f.used}

    @property
    def arguments(self) -> str:
        """The names of the ports, the arguments of routines."""
        return ", ".join(self.names.arguments[port.name] for port in self.program.ports)


def file_of(
    program: Program,
    spoken: Language,
    own: Iterable[str] = (),
    depth: int = 1,
    whole: bool = False,
    style: walk.Style = WHOLE,
    printer: type[StraightPrinter] = StraightPrinter,
) -> File:
    """The functions of a program; `own` are reserved names. With `whole`, each routine computes the hoisted values that it needs."""
    reserved = set(own)

    def free(name: str) -> bool:
        return spoken.is_free(name) and name not in reserved

    prefix, *called = distinct(
        [identifier(program.name) or "system", "hoist", *(identifier(r.name) or "routine" for r in program.routines)],
        free,
    )
    names = local_names(program, lambda name: free(name) and name not in {prefix, *called})
    wanted = [hoisting(program), *(walk.function_of(program, r) for r in program.routines)]
    if whole:
        wanted = [unhoisted(program, f) for f in wanted]
    given = [", ".join(names.arguments[port.name] for port in f.ports) for f in wanted]
    shapes, hoist = [(), *(r.shape for r in program.routines)], f"{called[0]}({given[0]})"
    written = []
    for f, name, own_given, shape in zip(wanted, called, given, shapes, strict=True):
        found = walk.pieces(program, f, style)
        numbers = range(len(program.inputs), program.first)
        parts, results, used = [], [], set[str]()
        for piece in found.chunks:
            own_lines = printer(spoken, names.of(f, spoken.number), names.arguments, numbers, depth)
            own_lines.block(walk.statements(program, f, piece, style))
            parts.append(tuple(own_lines.lines))
            results += own_lines.results
            used |= own_lines.used
        heading = (f, name, own_given, hoist if f is not wanted[0] else "", shape)
        written.append(Emitted(*heading, tuple(parts), found.slots, tuple(results), frozenset(used)))
    return File(program, prefix, names, tuple(written))


def unhoisted(program: Program, function: walk.Function) -> walk.Function:
    """The function with the hoisted instructions that it needs in its own block."""
    needed = {a for i in function.block for a in program.arguments(i)}.union(function.results)
    block = (*program.below(needed, False), *function.block)
    places = {i: place for i, place in function.places.items() if i < len(program.inputs)}
    block = tuple(dict.fromkeys(block))
    return walk.Function(
        function.name, function.ports, block, function.results, function.labels, (), function.target, places
    )


def head(file: File, version: str, call: Sequence[str], first: int = 0, brackets: str = "[]") -> list[str]:
    """The comment at the head of the file: its purpose, how to call its functions, the contents of its vectors."""
    program, names, k = file.program, file.names, 0
    lines = [f"{program.name}: {program.subject}. {made_by(version)}", *call]
    if program.lost:
        lines += ["", *program.lost]
    for port in program.ports:
        for place, s in enumerate(port.symbols):
            vector, own = names.arguments[port.name], names.inputs[k]
            at = vector if port.scalar else f"{vector}{brackets[0]}{place + first}{brackets[1]}"
            unit = f", {s.unit}" if s.unit else ""
            default = f" ({float(s.default)!r} unless told)" if port.hoisted and s.default is not None else ""
            renamed = "" if own == s.name or port.scalar else f"; its name here is {own}"
            text = f"{': ' if s.description else ''}{s.description}"
            lines.append(f"{at:7} {s.name}{unit}{default}{renamed}{text}")
            k += 1
    return [c_comment(line) for line in lines]


def numbers_of(program: Program, spoken: Language) -> str:
    """The defaults of the parameters as literals, NaN where there is none."""
    values = [s.default for port in program.hoisted_ports for s in port.symbols]
    return ", ".join(spoken.number(float("nan") if v is None else float(v)) for v in values)


GONE_TEXT = repr(GONE)
