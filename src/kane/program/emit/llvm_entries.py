# SPDX-License-Identifier: BSD-3-Clause
"""The two functions through which Python enters a kernel, as LLVM text.

`<name>.call(block)` works on one contiguous block of doubles that belongs to one thread: [ports of each evaluation | parameters |
parameters as hoisted | h | out], each section padded to a whole number of vectors. It hoists again where a parameter has changed, and
returns 1 where an input is not finite, 2 where a result is not, 3 for both, else 0.

`<name>.batch(n, a, sa, b, sb, …, h, out)` evaluates n rows; the stride (in doubles) of a port is 0 where all rows share its values.
It returns the first row with a result that is not finite, or −1.
"""

from dataclasses import dataclass

from kane.program.emit.llvm_forms import Lanes
from kane.program.emit.llvm_printer import vector
from kane.program.program import Port, Program, Routine

LANES = Lanes(4)
"""The vectors in which entries look through a block."""


@dataclass(frozen=True, slots=True)
class BlockLayout:
    """Where each port's values, in the ports' order, and each other section of the block of `<name>.call` begin, in doubles."""

    ports: tuple[int, ...]
    parameters: int
    hoisted: int
    h: int
    out: int
    size: int


def block(program: Program, routine: Routine) -> BlockLayout:
    """The layout of the routine's block.

    Without parameters too there is room for one: reciprocals of constants are hoisted, and "as hoisted" says whether they are.
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
    """What the entries of all routines call: is a section not finite; do two differ in a bit, as 0.0 and −0.0 do? None is empty."""
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
    """The text of `<name>.call`; `hoist` is the name of the function that gives h."""
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
    """A call with the values of ports at hand; `label` tells the numbers that it loads from those of other calls."""
    loads = [
        f"  {vector(p.name)}.{label} = load double, ptr {vector(p.name)}{at}, align 8\n" for p in ports if p.scalar
    ]
    arguments = [f"double {vector(p.name)}.{label}" if p.scalar else f"ptr {vector(p.name)}{at}" for p in ports]
    return f"{''.join(loads)}  call void @{function}({', '.join([*arguments, f'ptr {rest}'])})"


def batch_entry(program: Program, routine: Routine, hoist: str) -> str:
    """The text of `<name>.batch`; `hoist` is the name of the function that gives h."""
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
