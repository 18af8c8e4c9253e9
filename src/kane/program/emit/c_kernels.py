# SPDX-License-Identifier: BSD-3-Clause
"""Kernels as C99 functions: one per kernel, and one for each long block within it.

The functions of a kernel share its cells in a struct. Each loop has a counter and ends after `TURNS` iterations at the latest, more
than any kernel needs. There is no recursion and no allocation. Arrays that a kernel does not write are declared const.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field

from kane.program.emit.c import KINDS, CPrinter, each, extent
from kane.program.kernel import language
from kane.program.kernel.language import Argument, ArrayOf, Callee, Integer, Kernel, Value

TURNS = 1_000_000_000
"""The bound on the iterations of every loop."""
LONGEST = 40
"""The number of lines beyond which a block becomes a function."""


def emit_kernel_c(
    kernel: Kernel,
    routines: Mapping[str, str] | None = None,
    linkage: str = "",
    whose: tuple[str, str] = ("", ""),
    asking: Collection[str] = (),
) -> str:
    """The text of the function `int64_t <name>(arguments)`; it needs <math.h>, <stdbool.h> and <stdint.h>.

    Routines that the kernel calls are function pointers among the arguments, except those in `routines`, which maps them to the names
    of C functions. `linkage` is a prefix such as "static". `whose`, a name and its declaration, identifies the motion: it is the first
    argument of the kernel and of the routines in `asking`.
    """
    printer = _KernelPrinter(kernel, routines, whose, asking)
    printer.block(kernel.body)
    record = f"{kernel.name}_cells"
    cells = [f"    {KINDS[c.type.kind]} cell_{c.name}{extent(c.type)};" for c in kernel.cells]
    zeros = [f"    {each(c.type, f'{_cell(c)} = {_ZEROS[c.type.kind]};')}" for c in kernel.cells]
    arguments = [a for a in kernel.arguments if not isinstance(a, Callee) or a.name not in printer.routines]
    unused = [
        f"    (void){_name(a)};"
        for a in arguments
        if not printer.scope.names.keys() & {_name(a)} and not isinstance(a, Callee)
    ]
    parts = [
        "\n".join(["typedef struct {", *cells, f"}} {record};", ""]),
        *printer.functions,
        "\n".join(
            [
                f"{linkage}int64_t {kernel.name}({', '.join([*filter(None, whose[1:]), *map(printer.declared, arguments)])})",
                "{",
                f"    {record} cells;",
                f"    {record} *const c = &cells;",
                *unused,
                *zeros,
                *printer.lines,
                f"    return {_cell(kernel.result)};",
                "}",
                "",
            ]
        ),
    ]
    return "\n".join(parts)


_ZEROS = {"float": "0.0", "int": "0", "bool": "false"}


def _cell(cell: language.Cell) -> str:
    return f"c->cell_{cell.name}{'[k]' * (cell.type.width > 1)}"


def _name(a: Argument) -> str:
    return f"v{a.value}" if isinstance(a, Integer) else a.name


@dataclass(frozen=True, slots=True)
class _BlockNames:
    """The identifiers in a block: the argument declarations of outer names, and the values that the block defines."""

    names: dict[str, str] = field(default_factory=dict)
    defined: set[str] = field(default_factory=set)

    def note(self, name: str, declared: str) -> None:
        """Records the use of a name; an array that is written anywhere is declared without const."""
        if name not in self.names or self.names[name].startswith("const "):
            self.names[name] = declared

    def outer(self) -> dict[str, str]:
        """The names that the block uses and does not define, with their declarations."""
        return {name: declared for name, declared in self.names.items() if name not in self.defined}


class _KernelPrinter(CPrinter):
    """Prints a kernel; `functions` are those of its long blocks."""

    def __init__(
        self, kernel: Kernel, routines: Mapping[str, str] | None, whose: tuple[str, str], asking: Collection[str]
    ) -> None:
        super().__init__()
        self.kernel, self.routines, self.whose, self.asking = kernel, routines or {}, whose, asking
        self.functions: list[str] = []
        self.scope = _BlockNames()
        self.turns = 0

    def declared(self, a: Argument) -> str:
        """The declaration of an argument."""
        if isinstance(a, Integer):
            return f"int64_t v{a.value}"
        if isinstance(a, ArrayOf):
            return self.scope.names.get(a.name, f"const double *{a.name}")
        last = len(a.takes) - 1
        takes = (
            "double" if t == "float" else "double *" if k == last else "const double *" for k, t in enumerate(a.takes)
        )
        return f"void (*{a.name})({', '.join(takes)})"

    # ------------------------------------------------------------------------------------------------------ names

    def text(self, operand: language.Operand, lane: str = "k") -> str:
        """The text of an operand; its use is recorded."""
        if isinstance(operand, Value):
            kind = KINDS[operand.type.kind]
            wide = operand.type.width > 1
            self.scope.note(f"v{operand}", f"const {kind} *v{operand}" if wide else f"{kind} v{operand}")
        return super().text(operand, lane)

    def define(self, value: language.Operand, text: str) -> None:
        """Adds the definition of a value, and records it."""
        self.scope.defined.add(f"v{value}")
        super().define(value, text)

    def at(self, s: language.Address | language.Read | language.Write, type_: language.Type) -> str:
        """An element of an array; its use is recorded."""
        self.scope.note(s.base, f"{'' if isinstance(s, language.Write) else 'const '}double *{s.base}")
        return super().at(s, type_)

    def cell(self, s: language.Get | language.Put) -> str:
        """A cell; its use is recorded."""
        self.scope.note("c", f"{'const ' if isinstance(s, language.Get) else ''}{self.kernel.name}_cells *c")
        return _cell(s.cell)

    # ------------------------------------------------------------------------------------------------- statements

    def get(self, s: language.Get) -> None:
        """Adds a read of a cell."""
        self.define(s.value, self.cell(s))

    def put(self, s: language.Put) -> None:
        """Adds an assignment to a cell."""
        self.add(each(s.cell.type, f"{self.cell(s)} = {self.text(s.value)};"))

    def call(self, s: language.CallRoutine) -> None:
        """Adds a call of a routine; it writes to the last address among its arguments."""
        for a in [a for a in s.arguments if isinstance(a, language.Address)][-1:]:
            self.scope.note(a.base, f"double *{a.base}")
        given = [
            f"&{self.at(a, language.INT)}" if isinstance(a, language.Address) else self.text(a) for a in s.arguments
        ]
        name = s.callee.name
        if name not in self.routines:
            self.scope.note(name, self.declared(s.callee))
        else:
            if name in self.asking:
                self.scope.note(*self.whose)
                given = [self.whose[0], *given]
            name = self.routines[name]
        self.add(f"{name}({', '.join(given)});")

    def choice(self, s: language.If) -> None:
        """Adds an if statement."""
        self.add(f"if ({self.text(s.condition)}) {{")
        self.within(s.then)
        if s.other:
            self.add("} else {")
            self.within(s.other)
        self.add("}")

    def loop(self, s: language.While) -> None:
        """Adds a while loop."""
        self.turns += 1
        turn = f"turn{self.turns}"
        self.add(f"for (int64_t {turn} = 0; {turn} < {TURNS}; {turn}++) {{")
        self.indented(s.head)
        self.add(f"    if (!{self.text(s.condition)}) {{", "        break;", "    }")
        self.within(s.body)
        self.add("}")

    def count(self, s: language.For) -> None:
        """Adds a for loop."""
        start, stop, index = (self.text(x) for x in (s.start, s.stop, s.counter))
        self.scope.defined.add(index)
        self.add(f"for (int64_t {index} = {start}; {index} < {stop}; {index}++) {{")
        self.within(s.body)
        self.add("}")

    def within(self, block: language.Block) -> None:
        """Adds a block in braces, or, if it is long, the call of a function with its lines."""
        lines, depth, scope = self.lines, self.depth, self.scope
        self.lines, self.scope = [], _BlockNames()
        self.depth = depth + 1
        self.block(block)
        own, inner = self.lines, self.scope
        self.lines, self.depth, self.scope = lines, depth, scope
        given = inner.outer()
        if len(own) <= LONGEST:
            self.lines += own
        else:
            name = f"{self.kernel.name}_part{len(self.functions) + 1}"
            indent = "    " * depth
            text = [f"static void {name}({', '.join(given.values())})", "{", *(x[len(indent) :] for x in own), "}", ""]
            self.functions.append("\n".join(text))
            self.lines.append(f"{indent}    {name}({', '.join(given)});")
        for name, declared in given.items():
            scope.note(name, declared)
