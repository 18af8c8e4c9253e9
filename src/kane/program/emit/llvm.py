# SPDX-License-Identifier: BSD-3-Clause
"""Programs and kernels as the text of LLVM modules.

The functions of each Program are `hoist(parameters, h)`, and for each routine

    <name>(ports, h, out)       one evaluation
    <name>.call(block)          one evaluation in a private memory block of the caller (see `BlockLayout`)
    <name>.batch(n, …)          n evaluations, with a stride for each port

Vectors are passed as pointers to doubles. Sines and cosines of several available angles are computed in the lanes of one vector.

A routine at several states at once is one function, `<name>.lanes<width>(ports, h, out)`, in which every port is a pointer; with
different parameters in each lane it is `<name>.own<width>(mask, ports, h, out)`.

Python enters a routine through two of these functions.

`<name>.call(block)` works on one contiguous block of doubles that belongs to one thread: [ports of each evaluation | parameters |
parameters at the last hoisting | h | out], each section padded to a multiple of the vector width. It computes h again if a parameter
has changed, and returns the sum of 1 if an input and 2 if a result is not finite.

`<name>.batch(n, a, sa, b, sb, …, h, out)` evaluates n rows; the stride (in doubles) of a port is 0 if all rows share its values. It
returns the first row with a result that is not finite, or −1.
"""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from kane.program.emit import walk
from kane.program.emit.llvm_lanes import LanesPrinter, varying
from kane.program.emit.llvm_limbs import limbs_body
from kane.program.emit.llvm_printer import FEW, Calls, Lanes, LlvmPrinter, Near, pointed, typed, vector
from kane.program.emit.sincos import llvm_sincos
from kane.program.kernel.language import ArrayOf, Integer, Kernel, Read, Statement
from kane.program.program import WHOLE, Port, Program, Routine

LANES = Lanes(4)
"""The vector type with which entries check and compare the sections of a block."""


@dataclass(frozen=True, slots=True)
class BlockLayout:
    """The offsets, in doubles, of the ports' values, in the order of the ports, and of the sections of the block of `<name>.call`."""

    ports: tuple[int, ...]
    parameters: int
    hoisted: int
    h: int
    out: int
    size: int


def block(program: Program, routine: Routine) -> BlockLayout:
    """The layout of the routine's block.

    Without parameters their sections still have one vector: reciprocals of constants are hoisted too, and the section "parameters at
    the last hoisting" tells whether they have been computed.
    """
    at, end = dict[str, int](), 0
    for port in program.ports:
        if not port.hoisted:
            at[port.name], end = end, end + len(port.symbols)
    parameters = end = LANES.padded(end)
    for port in program.ports:
        if port.hoisted:
            at[port.name], end = end, end + len(port.symbols)
    width = LANES.padded(max(1, end - parameters))
    hoisted = parameters + width
    h = hoisted + width
    out = h + LANES.padded(len(program.kept))
    size = out + LANES.padded(max(1, len(routine.results)))
    return BlockLayout(tuple(at[port.name] for port in program.ports), parameters, hoisted, h, out, size)


def helpers() -> str:
    """The checks that entries call: whether a section is not finite, whether two differ in a bit (as 0.0, −0.0). None is empty."""
    n, double, integer, truth = LANES.width, LANES.double, LANES.of("i64"), LANES.of("i1")
    return f"""
declare double @llvm.vector.reduce.fadd.{LANES.suffix}(double, {double})
declare i1 @llvm.vector.reduce.or.v{n}i1({truth})
declare void @llvm.memcpy.p0.p0.i64(ptr, ptr, i64, i1)

define internal i1 @kane.bad(ptr %a, i64 %n) nounwind {{
  br label %loop
loop:
  %i = phi i64 [0, %0], [%j, %loop]
  %sum = phi {double} [zeroinitializer, %0], [%more, %loop]
  %at = getelementptr double, ptr %a, i64 %i
  %v = load {double}, ptr %at, align {8 * n}
  %zero = fmul {double} %v, zeroinitializer
  %more = fadd {double} %sum, %zero
  %j = add i64 %i, {n}
  %on = icmp ult i64 %j, %n
  br i1 %on, label %loop, label %end
end:
  %all = call double @llvm.vector.reduce.fadd.{LANES.suffix}(double 0.0, {double} %more)
  %bad = fcmp uno double %all, 0.0
  ret i1 %bad
}}

define internal i1 @kane.differ(ptr %a, ptr %b, i64 %n) nounwind {{
  br label %loop
loop:
  %i = phi i64 [0, %0], [%j, %loop]
  %any = phi {truth} [zeroinitializer, %0], [%more, %loop]
  %a.at = getelementptr double, ptr %a, i64 %i
  %b.at = getelementptr double, ptr %b, i64 %i
  %v = load {integer}, ptr %a.at, align {8 * n}
  %w = load {integer}, ptr %b.at, align {8 * n}
  %new = icmp ne {integer} %v, %w
  %more = or {truth} %any, %new
  %j = add i64 %i, {n}
  %on = icmp ult i64 %j, %n
  br i1 %on, label %loop, label %end
end:
  %all = call i1 @llvm.vector.reduce.or.v{n}i1({truth} %more)
  ret i1 %all
}}
"""


def call_entry(program: Program, routine: Routine, hoist: str) -> str:
    """The text of `<name>.call`; `hoist` is the name of the function that computes h."""
    b = block(program, routine)
    sections = {vector(port.name): at for port, at in zip(program.ports, b.ports, strict=True)}
    sections |= {"%parameters": b.parameters, "%hoisted": b.hoisted, "%h": b.h, "%out": b.out}
    places = "\n".join(f"  {name} = getelementptr double, ptr %block, i64 {at}" for name, at in sections.items())
    width, align = b.hoisted - b.parameters, 8 * LANES.width
    copied = f"ptr align {align} %hoisted, ptr align {align} %parameters, i64 {8 * width}, i1 false"
    hoisting = f"""  %new = call i1 @kane.differ(ptr %parameters, ptr %hoisted, i64 {width})
  br i1 %new, label %hoist, label %run
hoist:
{_call(hoist, program.hoisted_ports, "%h", "hoist")}
  call void @llvm.memcpy.p0.p0.i64({copied})
  br label %run
run:
"""
    return f"""
define i32 @{routine.name}.call(ptr noalias align 64 %block) nounwind {{
{places}
{hoisting if program.kept else ""}{_call(routine.name, program.ports, "%h, ptr %out", "run")}
  %from.bad = call i1 @kane.bad(ptr %block, i64 {b.hoisted})
  %to.bad = call i1 @kane.bad(ptr %out, i64 {b.size - b.out})
  %one = zext i1 %from.bad to i32
  %two = select i1 %to.bad, i32 2, i32 0
  %flags = or i32 %one, %two
  ret i32 %flags
}}"""


def _call(function: str, ports: tuple[Port, ...], rest: str, label: str, at: str = "") -> str:
    """A call with the values of ports as arguments; `label` is a unique prefix of the names of the scalars that it loads."""
    loads = [
        f"  {vector(p.name)}.{label} = load double, ptr {vector(p.name)}{at}, align 8\n" for p in ports if p.scalar
    ]
    arguments = [f"double {vector(p.name)}.{label}" if p.scalar else f"ptr {vector(p.name)}{at}" for p in ports]
    return f"{''.join(loads)}  call void @{function}({', '.join([*arguments, f'ptr {rest}'])})"


def batch_entry(program: Program, routine: Routine, hoist: str) -> str:
    """The text of `<name>.batch`; `hoist` is the name of the function that computes h."""
    size, hoisted = len(routine.results), program.hoisted_ports
    names = [vector(port.name) for port in program.ports]
    moves = "\n".join(
        f"  {s}.k = mul i64 %i, {s}.stride\n  {s}.at = getelementptr double, ptr {s}, i64 {s}.k" for s in names
    )
    inputs = "".join(f"ptr {s}, i64 {s}.stride, " for s in names)
    strides, stride = "", "0"
    for k, s in enumerate(vector(p.name) for p in hoisted):
        strides, stride = f"{strides}  %strides.{k} = or i64 {stride}, {s}.stride\n", f"%strides.{k}"
    return f"""
define i64 @{routine.name}.batch(i64 %n, {inputs}ptr %h, ptr %out) nounwind {{
{strides}  %shared = icmp eq i64 {stride}, 0
  br i1 %shared, label %once, label %head
once:
{_call(hoist, hoisted, "%h", "once")}
  br label %head
head:
  %some = icmp sgt i64 %n, 0
  br i1 %some, label %row, label %none
none:
  ret i64 -1
row:
  %i = phi i64 [0, %head], [%j, %checked]
  %first = phi i64 [-1, %head], [%first.now, %checked]
{moves}
  %out.k = mul i64 %i, {size}
  %out.at = getelementptr double, ptr %out, i64 %out.k
  br i1 %shared, label %run, label %hoist
hoist:
{_call(hoist, hoisted, "%h", "hoist", ".at")}
  br label %run
run:
{_call(routine.name, program.ports, "%h, ptr %out.at", "run", ".at")}
  br i1 {"true" if size else "false"}, label %check, label %checked
check:
  %c = phi i64 [0, %run], [%d, %check]
  %sum = phi double [0.0, %run], [%more, %check]
  %value.at = getelementptr double, ptr %out.at, i64 %c
  %value = load double, ptr %value.at, align 8
  %zero = fmul double %value, 0.0
  %more = fadd double %sum, %zero
  %d = add i64 %c, 1
  %on = icmp ult i64 %d, {size}
  br i1 %on, label %check, label %checked
checked:
  %all = phi double [0.0, %run], [%more, %check]
  %bad = fcmp uno double %all, 0.0
  %unmet = icmp slt i64 %first, 0
  %here = and i1 %bad, %unmet
  %first.now = select i1 %here, i64 %i, i64 %first
  %j = add i64 %i, 1
  %again = icmp slt i64 %j, %n
  br i1 %again, label %row, label %done
done:
  ret i64 %first.now
}}"""


_WHOLE, _MATRIX = 2_500, 6_000
"""Maximum numbers of instructions of a routine, and of one whose result is a matrix, that is not split. One function runs up to a
fifth faster than several and up to these lengths compiles as fast; columns of a matrix share little. Longer code exceeds the cache."""


def emit_llvm(programs: Sequence[Program], contract: bool = True, lanes: int = 4) -> str:
    """The module's text, a deterministic function of programs and options. The names of all routines must differ.

    `contract` permits one rounding of a·b + c; `lanes` is the vector width of the machine in doubles.
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

    An element of a port of the tier "parameter", or of h, is one double for all states; an element of another port or of the results
    is `width` consecutive doubles, one for each state.
    """
    module = _LlvmModule(contract, 1, width)
    return module.text(
        [module.function(program, walk.function_of(program, routine), wide_name(routine.name, width), WHOLE)]
    )


def emit_masked(program: Program, routine: Routine, width: int, contract: bool = True) -> str:
    """The module of a routine at `width` states at once, each with its own parameters, and of the corresponding hoisting function.

    The first argument of each function is an integer whose bits select the lanes in which it writes.
    """
    module = _LlvmModule(contract, 1, width, masked=True)
    (hoist,) = hoists([program])
    functions = ((walk.hoisting(program), hoist), (walk.function_of(program, routine), routine.name))
    return module.text([module.function(program, f, masked_name(name, width), WHOLE) for f, name in functions])


def emit_kernel_llvm(kernel: Kernel, contract: bool = True) -> str:
    """The text of a module with the one function `i64 @<name>(arguments)`; arrays and routines are pointers."""
    calls = Calls()
    printer = LlvmPrinter(calls, "contract " * contract)
    types = [(f"%cell.{c.name}", typed(c.type)) for c in kernel.cells]
    printer.block(kernel.body)
    back = [f"  %result = load i64, ptr %cell.{kernel.result.name}"]
    return _kernel_text(kernel, kernel.name, calls, types, [], [*printer.lines, *back])


def emit_kernel_lanes(kernel: Kernel, width: int, shared: Collection[str] = (), contract: bool = True) -> str:
    """The module of `i64 @<name>.own<width>(arguments)`, the kernel for `width` instances at once; it returns the largest result.

    An array element, unless `shared`, is `width` consecutive doubles, one per instance. Routines are those of `emit_masked`.
    """
    calls = Calls()
    printer = LanesPrinter(calls, "contract " * contract, width, varying(kernel, shared))
    types = [(f"%cell.{c.name}", printer.cell_type(c)) for c in kernel.cells]
    printer.block(kernel.body)
    back = printer.largest(kernel.result)
    return _kernel_text(kernel, masked_name(kernel.name, width), calls, types, printer.rooms, [*printer.lines, *back])


def _kernel_text(
    kernel: Kernel, name: str, calls: Calls, cells: Sequence[tuple[str, str]], rooms: Sequence[str], body: Sequence[str]
) -> str:
    """The module of a kernel; `cells` are (name, LLVM type)."""
    arguments = ", ".join(
        f"i64 %v{a.value}"
        if isinstance(a, Integer)
        else f"ptr noalias {vector(a.name)}"
        if isinstance(a, ArrayOf)
        else f"ptr %{a.name}"
        for a in kernel.arguments
    )
    head = f"define i64 @{name}({arguments}) nounwind {{"
    places = [f"  {cell} = alloca {kind}" for cell, kind in cells]
    zeros = [f"  store {kind} zeroinitializer, ptr {cell}" for cell, kind in cells]
    end = ["  ret i64 %result", "}"]
    return "\n".join([*sorted(calls.declared), head, *places, *rooms, *zeros, *body, *end, *FEW, ""])


def selection() -> str:
    """The module of `select.one`, `select.wide` and `select.hoist`, which call one of several routines with the same ports.

    Their h is a table: the index in p of the number that selects the routine, the number of routines, and for each routine the
    addresses of its code, of its hoisting function and of its h.
    """
    take = """  %place = load i64, ptr %h
  %at = getelementptr double, ptr %p, i64 %place
  %number = load double, ptr %at
  %which = fptosi double %number to i64
  %three = mul i64 %which, 3
  %row = add i64 %three, 2
  %routine.at = getelementptr i64, ptr %h, i64 %row
  %routine = load ptr, ptr %routine.at
  %own.at = getelementptr i64, ptr %routine.at, i64 2
  %own = load ptr, ptr %own.at
"""
    calls = "".join(
        f"""
define void @select.{name}({time} %t, ptr %x, ptr %p, ptr %r, ptr %h, ptr %out) nounwind {{
{take}  call void %routine({time} %t, ptr %x, ptr %p, ptr %r, ptr %own, ptr %out)
  ret void
}}
"""
        for name, time in (("one", "double"), ("wide", "ptr"))
    )
    return calls + _for_each_known("select.hoist", ("p", "h"), "", "hoist", 1)


def masked_selection(width: int) -> str:
    """The module of `select.own<width>`: each of `width` lanes enabled by the first argument, a bit mask, selects its own routine.

    h is that of `selection`, with routines of `emit_masked`.
    """
    kind = f"<{width} x double>"
    lanes = f"""  %place = load i64, ptr %h
  %first = mul i64 %place, {width}
  %numbers.at = getelementptr double, ptr %p, i64 %first
  %numbers = load {kind}, ptr %numbers.at, align 8
"""
    wanted = f"""  %number = sitofp i64 %k to double
  %one = insertelement {kind} poison, double %number, i64 0
  %every = shufflevector {kind} %one, {kind} poison, <{width} x i32> zeroinitializer
  %alike = fcmp oeq {kind} %numbers, %every
  %bits = bitcast <{width} x i1> %alike to i{width}
  %long = zext i{width} %bits to i64
  %own.mask = and i64 %mask, %long
  %some = icmp ne i64 %own.mask, 0
"""
    run, hoist = (masked_name(f"select{name}", width) for name in ("", ".hoist"))
    return _for_each_known(
        run, ("mask", "t", "x", "p", "r", "h", "out"), lanes, "routine", 0, wanted
    ) + _for_each_known(hoist, ("mask", "p", "h"), "", "hoist", 1)


def _for_each_known(name: str, names: Sequence[str], before: str, what: str, column: int, wanted: str = "") -> str:
    """A function that calls the function in `column` of the table of a selection for each routine that is set and `wanted`."""
    own = {"h": "own"} | ({"mask": "own.mask"} if wanted else {})
    kinds = ["i64" if n == "mask" else "ptr" for n in names]
    arguments, given = (
        ", ".join(f"{kind} %{of.get(n, n)}" for kind, n in zip(kinds, names, strict=True)) for of in ({}, own)
    )
    wanted += "  %both = and i1 %known, %some\n" * bool(wanted)
    return f"""
define void @{name}({arguments}) nounwind {{
  %count.at = getelementptr i64, ptr %h, i64 1
  %count = load i64, ptr %count.at
{before}  br label %head
head:
  %k = phi i64 [0, %0], [%next, %done]
  %on = icmp slt i64 %k, %count
  br i1 %on, label %row, label %end
row:
  %three = mul i64 %k, 3
  %place.of = add i64 %three, {2 + column}
  %{what}.at = getelementptr i64, ptr %h, i64 %place.of
  %{what} = load ptr, ptr %{what}.at
  %known = icmp ne ptr %{what}, null
{wanted}  br i1 %{"both" if wanted else "known"}, label %call, label %done
call:
  %own.at = getelementptr i64, ptr %{what}.at, i64 {2 - column}
  %own = load ptr, ptr %own.at
  call void %{what}({given})
  br label %done
done:
  %next = add i64 %k, 1
  br label %head
end:
  ret void
}}
"""


def bound_call(count: int) -> str:
    """The module of `kept.call<count>`, which calls a kernel with `count` arguments and returns its result.

    Its argument is a block: the address of this function, the address of the kernel, the arguments.
    """
    lines = [
        f"  %at{k} = getelementptr i64, ptr %block, i64 {k + 2}\n  %a{k} = load i64, ptr %at{k}" for k in range(count)
    ]
    given = ", ".join(f"i64 %a{k}" for k in range(count))
    return f"""define i64 @kept.call{count}(ptr %block) nounwind {{
  %own.at = getelementptr i64, ptr %block, i64 1
  %own = load ptr, ptr %own.at
{chr(10).join(lines)}
  %back = call i64 %own({given})
  ret i64 %back
}}
"""


def _bound_call_row(which: int) -> str:
    """The beginning of a function that uses a call in the table %h; %row is the entry `which` (0 to 2) of the current call."""
    return f"""  %number = load double, ptr %h
  %k = fptosi double %number to i64
  %three = mul i64 %k, 3
  %place = add i64 %three, {2 + which}
  %row.at = getelementptr i64, ptr %h, i64 %place
  %row = load ptr, ptr %row.at
"""


def bound_calls() -> str:
    """The module of `kept.make`, `hoist`, `look` and `drive`, which use one of the calls in a table (`KeptCalls`)."""
    looks = "\n".join(
        f"""define void @kept.{name}(double %t, ptr %x, ptr %r, ptr %h, ptr %out) nounwind {{
{_bound_call_row(2)}  %p = load ptr, ptr %row
  %own.at = getelementptr i64, ptr %row, i64 {1 + 2 * k}
  %own = load ptr, ptr %own.at
  %own.h.at = getelementptr i64, ptr %row, i64 {2 + 2 * k}
  %own.h = load ptr, ptr %own.h.at
  call void %own(double %t, ptr %x, ptr %p, ptr %r, ptr %own.h, ptr %out)
  ret void
}}
"""
        for k, name in enumerate(("look", "drive"))
    )
    return f"""
define void @kept.make(ptr %h) nounwind {{
{_bound_call_row(0)}  %call = load ptr, ptr %row
  %back = call i64 %call(ptr %row)
  %result = sitofp i64 %back to double
  %result.at = getelementptr double, ptr %h, i64 1
  store double %result, ptr %result.at
  ret void
}}

{looks}
define void @kept.hoist(ptr %h) nounwind {{
{_bound_call_row(1)}  %count = load i64, ptr %row
  %p.at = getelementptr i64, ptr %row, i64 1
  %p = load ptr, ptr %p.at
  br label %head
head:
  %i = phi i64 [0, %0], [%next, %body]
  %on = icmp slt i64 %i, %count
  br i1 %on, label %body, label %end
body:
  %two = mul i64 %i, 2
  %hoist.place = add i64 %two, 2
  %hoist.at = getelementptr i64, ptr %row, i64 %hoist.place
  %hoist = load ptr, ptr %hoist.at
  %own.at = getelementptr i64, ptr %hoist.at, i64 1
  %own = load ptr, ptr %own.at
  call void %hoist(ptr %p, ptr %own)
  %next = add i64 %i, 1
  br label %head
end:
  ret void
}}
"""


def hoists(programs: Sequence[Program]) -> list[str]:
    """The names of the hoisting functions, one for each Program."""
    return [f"{program.routines[0].name}.hoist" for program in programs]


def wide_name(routine: str, width: int) -> str:
    """The name of the function that evaluates a routine at several states."""
    return f"{routine}.lanes{width}"


def masked_name(routine: str, width: int) -> str:
    """The name of the function of several states, each with its own parameters, or of a kernel for several instances."""
    return f"{routine}.own{width}"


@dataclass(frozen=True, slots=True)
class _LlvmModule:
    """Collects the functions of a module for `width` states at once, with vectors of up to `lanes` sines.

    If `masked`, each state has its own parameters, and results are written only in selected lanes.
    """

    contract: bool
    lanes: int
    width: int = 1
    masked: bool = False
    calls: Calls = field(default_factory=Calls)

    def text(self, functions: Iterable[str]) -> str:
        """The module: declarations and functions that others call, then `functions`."""
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
        """The definition of a function, or, if it is long, of several and one that calls them in turn."""
        style = walk.Style(lazy=True, lanes=self.lanes, whole=whole)
        parts = walk.pieces(program, function, style)
        scalars = _scalars(program) if self.width == 1 else {}
        common = _constants(program, self.width) | scalars
        shared = set() if self.masked else {walk.KEPT, *(port.name for port in program.ports if port.hoisted)}
        target = function.target if self.masked else ""
        mask = _mask(self.width) * self.masked
        texts, calls, own = [], [], self._arguments(function)
        for k, part in enumerate(parts.chunks):
            body = self._loaded(program, walk.statements(program, function, part, style))
            if len(parts.chunks) == 1:
                lines = self._printer(common, shared, masked=target).body(body)
                return _definition(f"define void @{name}({_signature(own)})", [*mask, *lines])
            near = pointed(body) if self.width == 1 else {}
            given = [(kind, value, "") for kind, value in [*own, ("ptr", vector(walk.WORK))]]
            if self.width == 1:
                given = [*_passed(scalars, body, near)]
            head = f"define internal void @{name}.{k}({_signature((kind, value) for kind, value, _ in given)})"
            lines = self._printer(common, shared, near, target).body(body)
            texts.append(_definition(head, [*mask, *lines], " noinline"))
            calls += [f"  {value}.{k} = {address}" for _, value, address in given if address]
            passed = ", ".join(f"{kind} {value}{f'.{k}' * bool(address)}" for kind, value, address in given)
            calls.append(f"  call void @{name}.{k}({passed})")
        work = f"  %w = alloca [{self.width * max(1, parts.slots)} x double], align 64"
        return "\n".join([*texts, _definition(f"define void @{name}({_signature(own)})", [work, *calls])])

    def _arguments(self, function: walk.Function) -> list[tuple[str, str]]:
        kinds = [("double" if p.scalar and self.width == 1 else "ptr", vector(p.name)) for p in function.ports]
        vectors = [("ptr", vector(base)) for base in dict.fromkeys((walk.KEPT, function.target))]
        return [("i64", "%mask")] * self.masked + kinds + vectors

    def _printer(
        self,
        common: Mapping[int, str],
        shared: Iterable[str] = (),
        near: Mapping[str, Near] | None = None,
        masked: str = "",
    ) -> LlvmPrinter:
        flags = "contract " * self.contract
        return LlvmPrinter(self.calls, flags, common, self.width, frozenset(shared), near, masked)

    def _loaded(self, program: Program, body: list[Statement]) -> list[Statement]:
        """The statements, preceded by loads of the scalars that they read where scalars are passed by pointer."""
        if self.width == 1:
            return body
        read = {a for s in body for a in walk.values_read(s)}
        ports = enumerate(port for port in program.ports for _ in port.symbols)
        return [*(Read(i, port.name, 0) for i, port in ports if port.scalar and i in read), *body]


def _mask(width: int) -> list[str]:
    """The lines that convert the bits of a mask to a vector of truth values."""
    return [f"  %mask.own = trunc i64 %mask to i{width}", f"  %lanes = bitcast i{width} %mask.own to <{width} x i1>"]


def _definition(head: str, lines: Sequence[str], attributes: str = "") -> str:
    return "\n".join([f"{head} nounwind{attributes} {{", *lines, "  ret void", "}"])


def _constants(program: Program, width: int = 1) -> dict[int, str]:
    return {len(program.inputs) + k: Lanes(width).number(value) for k, value in enumerate(program.constants)}


def _scalars(program: Program) -> dict[int, str]:
    """The names of the scalar ports, by value."""
    ports = (port for port in program.ports for _ in port.symbols)
    return {i: vector(port.name) for i, port in enumerate(ports) if port.scalar}


def _passed(
    scalars: Mapping[int, str], body: Sequence[Statement], near: Mapping[str, Near]
) -> Iterator[tuple[str, str, str]]:
    """The arguments of a piece: kind, name, and how the caller computes it, if it must. Scalars that it does not read are omitted."""
    for base, own in near.items():
        for k, place in enumerate(own.places):
            yield "ptr", f"{vector(base)}.{k}", f"getelementptr double, ptr {vector(base)}, i64 {place}"
    read = {a for s in body for a in walk.values_read(s)}
    yield from (("double", name, "") for i, name in scalars.items() if i in read)


def _signature(arguments: Iterable[tuple[str, str]]) -> str:
    return ", ".join(f"{kind}{' noalias' * (kind == 'ptr')} {value}" for kind, value in arguments)
