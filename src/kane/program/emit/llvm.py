# SPDX-License-Identifier: BSD-3-Clause
"""Programs and kernels as the text of LLVM modules.

The functions of Programs are, for each Program, `hoist(parameters, h)`, and for each routine

    <name>(ports, h, out)       the kernel
    <name>.call(block)          one evaluation in a caller's private block (see `BlockLayout`)
    <name>.batch(n, …)          many, with a stride in rows for each port

Vectors are passed as pointers to doubles. Sines and cosines of angles that are known at the same time are computed side by side
in the lanes of a vector.

A routine at several states at once is one function, `<name>.lanes<width>(ports, h, out)`, in which every port is a pointer.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from kane.program.emit import walk
from kane.program.emit.llvm_entries import batch_entry, call_entry, helpers
from kane.program.emit.llvm_forms import Lanes, typed
from kane.program.emit.llvm_limbs import limbs_body
from kane.program.emit.llvm_near import Near, pointed
from kane.program.emit.llvm_printer import FEW, Calls, LlvmPrinter, vector
from kane.program.emit.sincos import llvm_sincos
from kane.program.kernel.language import ArrayOf, Compute, Integer, Kernel, Read, SinCos, Statement, Write
from kane.program.passes.split import WHOLE
from kane.program.program import Program, Routine

_WHOLE, _MATRIX = 2_500, 6_000
"""Instructions up to which a routine is one function, and one whose results are a matrix: it runs up to a fifth faster than in pieces,
and is compiled as soon up to there; the columns of a matrix have little to tell each other. Longer ones no longer fit the cache."""


def emit_llvm(programs: Sequence[Program], contract: bool = True, lanes: int = 4) -> str:
    """The module's text; the same programs and options give the same text. The names of all routines must differ.

    `contract` allows a·b + c in one rounding, `lanes` is the width of the machine's vectors in doubles.
    """
    module = _LlvmModule(contract, lanes)
    texts = [helpers()]
    for program, hoist in zip(programs, hoists(programs), strict=True):
        texts.append(module.function(program, walk.hoisting(program), hoist, WHOLE))
        for routine in program.routines:
            texts.append(module.routine(program, routine))
            texts += [call_entry(program, routine, hoist), batch_entry(program, routine, hoist)]
    return module.text(texts)


def emit_wide(program: Program, routine: Routine, width: int, contract: bool = True) -> str:
    """The module of a routine at `width` states at once.

    Of ports of the tier "parameter", and of h, a number stands for all states; of the others, and of the results, each number is
    `width` doubles side by side, one a state.
    """
    module = _LlvmModule(contract, 1, width)
    return module.text(
        [module.function(program, walk.function_of(program, routine), wide_name(routine.name, width), WHOLE)]
    )


def emit_kernel_llvm(kernel: Kernel, contract: bool = True) -> str:
    """The text of a module with the one function `i64 @<name>(arguments)`; addresses of arrays and routines are pointers."""
    calls = Calls()
    printer = LlvmPrinter(calls, "contract " * contract)
    printer.add(*(f"%cell.{c.name} = alloca {typed(c.type)}" for c in kernel.cells))
    printer.add(*(f"store {typed(c.type)} zeroinitializer, ptr %cell.{c.name}" for c in kernel.cells))
    printer.block(kernel.body)
    arguments = ", ".join(
        f"i64 {printer.names[a.value]}"
        if isinstance(a, Integer)
        else f"ptr noalias {vector(a.name)}"
        if isinstance(a, ArrayOf)
        else f"ptr %{a.name}"
        for a in kernel.arguments
    )
    head = f"define i64 @{kernel.name}({arguments}) nounwind {{"
    back = [f"  %result = load i64, ptr %cell.{kernel.result.name}", "  ret i64 %result", "}"]
    return "\n".join([*sorted(calls.declared), head, *printer.lines, *back, *FEW, ""])


def hoists(programs: Sequence[Program]) -> list[str]:
    """The names of the functions that hoist, one a Program."""
    return [f"hoist{k or ''}" for k in range(len(programs))]  # its pieces are hoist.0, hoist.1, …


def wide_name(routine: str, width: int) -> str:
    """The name of the function of several states."""
    return f"{routine}.lanes{width}"


@dataclass(frozen=True, slots=True)
class _LlvmModule:
    """The functions so far, of `width` states at once; sines are up to `lanes` side by side."""

    contract: bool
    lanes: int
    width: int = 1
    calls: Calls = field(default_factory=Calls)

    def text(self, functions: Iterable[str]) -> str:
        """Functions, after what they call."""
        sines = [llvm_sincos(width, self.contract) for width in sorted(self.calls.sines)]
        for name in ("sin", "cos") if sines else ():
            self.calls.declare(name, "double", 1)
        return "\n".join([*sorted(self.calls.declared), *sines, *functions])

    def routine(self, program: Program, routine: Routine) -> str:
        """The function of a routine."""
        function = walk.function_of(program, routine)
        if routine.packs:
            body = limbs_body(program, function, routine.packs, self._printer(_constants(program) | _scalars(program)))
            return _definition(f"define void @{routine.name}({_signature(self._arguments(function))})", body)
        return self.function(program, function, routine.name, _MATRIX if len(routine.shape) > 1 else _WHOLE)

    def function(self, program: Program, function: walk.Function, name: str, whole: float) -> str:
        """One function, or several with one that calls them in turn."""
        style = walk.Style(lazy=True, lanes=self.lanes, whole=whole)
        parts = walk.pieces(program, function, style)
        scalars = _scalars(program) if self.width == 1 else {}
        common = _constants(program, self.width) | scalars
        shared = {walk.KEPT, *(port.name for port in program.ports if port.hoisted)}
        texts, calls, own = [], [], self._arguments(function)
        for k, part in enumerate(parts.chunks):
            body = self._loaded(program, walk.statements(program, function, part, style))
            if len(parts.chunks) == 1:
                lines = self._printer(common, shared).body(body)
                return _definition(f"define void @{name}({_signature(own)})", lines)
            near = pointed(body) if self.width == 1 else {}
            given = [(kind, value, "") for kind, value in [*own, ("ptr", vector(walk.WORK))]]
            if self.width == 1:
                given = [*_passed(scalars, body, near)]
            head = f"define internal void @{name}.{k}({_signature((kind, value) for kind, value, _ in given)})"
            texts.append(_definition(head, self._printer(common, shared, near).body(body), " noinline"))
            calls += [f"  {value}.{k} = {address}" for _, value, address in given if address]
            passed = ", ".join(f"{kind} {value}{f'.{k}' * bool(address)}" for kind, value, address in given)
            calls.append(f"  call void @{name}.{k}({passed})")
        work = f"  %w = alloca [{self.width * max(1, parts.slots)} x double], align 64"
        return "\n".join([*texts, _definition(f"define void @{name}({_signature(own)})", [work, *calls])])

    def _arguments(self, function: walk.Function) -> list[tuple[str, str]]:
        kinds = [("double" if p.scalar and self.width == 1 else "ptr", vector(p.name)) for p in function.ports]
        return kinds + [("ptr", vector(base)) for base in dict.fromkeys((walk.KEPT, function.target))]

    def _printer(
        self, common: Mapping[int, str], shared: Iterable[str] = (), near: Mapping[str, Near] | None = None
    ) -> LlvmPrinter:
        return LlvmPrinter(self.calls, "contract " * self.contract, common, self.width, frozenset(shared), near)

    def _loaded(self, program: Program, body: list[Statement]) -> list[Statement]:
        """The statements, after loads of the scalars that they read where these are pointers."""
        if self.width == 1:
            return body
        read = {a for s in body for a in _read(s)}
        ports = enumerate(port for port in program.ports for _ in port.symbols)
        return [*(Read(i, port.name, 0) for i, port in ports if port.scalar and i in read), *body]


def _definition(head: str, lines: Sequence[str], attributes: str = "") -> str:
    return "\n".join([f"{head} nounwind{attributes} {{", *lines, "  ret void", "}"])


def _constants(program: Program, width: int = 1) -> dict[int, str]:
    return {len(program.inputs) + k: Lanes(width).number(value) for k, value in enumerate(program.constants)}


def _scalars(program: Program) -> dict[int, str]:
    """Ports that are scalars."""
    ports = (port for port in program.ports for _ in port.symbols)
    return {i: vector(port.name) for i, port in enumerate(ports) if port.scalar}


def _passed(
    scalars: Mapping[int, str], body: Sequence[Statement], near: Mapping[str, Near]
) -> Iterator[tuple[str, str, str]]:
    """The arguments of a piece: kind, name, and for those that the caller computes how. Scalars that it does not read are left out."""
    for base, own in near.items():
        for k, place in enumerate(own.places):
            yield "ptr", f"{vector(base)}.{k}", f"getelementptr double, ptr {vector(base)}, i64 {place}"
    read = {a for s in body for a in _read(s)}
    yield from (("double", name, "") for i, name in scalars.items() if i in read)


def _read(s: Statement) -> Sequence[object]:
    """The values that a statement of a Program reads."""
    if isinstance(s, Compute):
        return s.arguments
    return s.angles if isinstance(s, SinCos) else (s.value,) if isinstance(s, Write) else ()


def _signature(arguments: Iterable[tuple[str, str]]) -> str:
    return ", ".join(f"{kind}{' noalias' * (kind == 'ptr')} {value}" for kind, value in arguments)
