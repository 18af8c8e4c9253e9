# SPDX-License-Identifier: BSD-3-Clause
"""The two functions through which Python enters a kernel, as LLVM text.

`<name>.call(block)` works on one contiguous block of doubles that belongs to one thread: [t, x, r, p | p as hoisted | h | out],
each section padded to a whole number of vectors. It hoists again where p has changed, and returns 1 where an input is not
finite, 2 where a result is not, 3 for both, else 0.

`<name>.batch(n, t, st, x, sx, p, sp, r, sr, h, out)` evaluates n rows; an input's stride (in doubles) is 0 where all rows share
it. It returns the first row with a result that is not finite, or −1.
"""

from __future__ import annotations

from dataclasses import dataclass

from kane.program.program import Program, Routine

_LANES = 4
_VECTOR = f"<{_LANES} x double>"


def _padded(count: int) -> int:
    return -(-count // _LANES) * _LANES


@dataclass(frozen=True, slots=True)
class Block:
    """Where each section of the block of `<name>.call` begins, in doubles, and the block's length."""

    x: int
    r: int
    p: int
    hoisted: int
    h: int
    out: int
    size: int


def block(program: Program, routine: Routine) -> Block:
    """The layout of the routine's block; t stands at 0.

    Without parameters too p has room for one: reciprocals of constants are hoisted, and "p as hoisted" says whether they are.
    """
    x, r, p = (len(program.port(name).symbols) for name in ("x", "r", "p"))
    width = _padded(max(1, p))
    at_p = _padded(1 + x + r)
    hoisted = at_p + width
    at_h = hoisted + width
    out = at_h + _padded(len(program.kept))
    return Block(1, 1 + x, at_p, hoisted, at_h, out, out + _padded(max(1, len(routine.results))))


SHARED = f"""
declare double @llvm.vector.reduce.fadd.v{_LANES}f64(double, {_VECTOR})
declare i1 @llvm.vector.reduce.or.v{_LANES}i1(<{_LANES} x i1>)
declare void @llvm.memcpy.p0.p0.i64(ptr, ptr, i64, i1)

define internal i1 @kane.bad(ptr %a, i64 %n) nounwind {{
  br label %loop
loop:
  %i = phi i64 [0, %0], [%j, %loop]
  %sum = phi {_VECTOR} [zeroinitializer, %0], [%more, %loop]
  %at = getelementptr double, ptr %a, i64 %i
  %v = load {_VECTOR}, ptr %at, align 32
  %zero = fmul {_VECTOR} %v, zeroinitializer
  %more = fadd {_VECTOR} %sum, %zero
  %j = add i64 %i, {_LANES}
  %on = icmp ult i64 %j, %n
  br i1 %on, label %loop, label %end
end:
  %all = call double @llvm.vector.reduce.fadd.v{_LANES}f64(double 0.0, {_VECTOR} %more)
  %bad = fcmp uno double %all, 0.0
  ret i1 %bad
}}

define internal i1 @kane.differ(ptr %a, ptr %b, i64 %n) nounwind {{
  br label %loop
loop:
  %i = phi i64 [0, %0], [%j, %loop]
  %any = phi <{_LANES} x i1> [zeroinitializer, %0], [%more, %loop]
  %a.at = getelementptr double, ptr %a, i64 %i
  %b.at = getelementptr double, ptr %b, i64 %i
  %v = load <{_LANES} x i64>, ptr %a.at, align 32
  %w = load <{_LANES} x i64>, ptr %b.at, align 32
  %new = icmp ne <{_LANES} x i64> %v, %w
  %more = or <{_LANES} x i1> %any, %new
  %j = add i64 %i, {_LANES}
  %on = icmp ult i64 %j, %n
  br i1 %on, label %loop, label %end
end:
  %all = call i1 @llvm.vector.reduce.or.v{_LANES}i1(<{_LANES} x i1> %more)
  ret i1 %all
}}
"""
"""What the entries of all routines call: is a section not finite; do two differ in a bit, as 0.0 and −0.0 do? None is empty."""


def call_entry(program: Program, routine: Routine) -> str:
    """The text of `<name>.call`."""
    b = block(program, routine)
    sections = {"x": b.x, "r": b.r, "p": b.p, "q": b.hoisted, "h": b.h, "out": b.out}
    pointers = "\n".join(f"  %{name} = getelementptr double, ptr %block, i64 {at}" for name, at in sections.items())
    width = b.hoisted - b.p
    hoist = f"""  %new = call i1 @kane.differ(ptr %p, ptr %q, i64 {width})
  br i1 %new, label %hoist, label %run
hoist:
  call void @hoist(ptr %p, ptr %h)
  call void @llvm.memcpy.p0.p0.i64(ptr align 32 %q, ptr align 32 %p, i64 {8 * width}, i1 false)
  br label %run
run:
"""
    return f"""
define i32 @{routine.name}.call(ptr noalias align 64 %block) nounwind {{
{pointers}
  %t = load double, ptr %block, align 64
{hoist if program.kept else ""}  call void @{routine.name}(double %t, ptr %x, ptr %p, ptr %r, ptr %h, ptr %out)
  %from.bad = call i1 @kane.bad(ptr %block, i64 {b.hoisted})
  %to.bad = call i1 @kane.bad(ptr %out, i64 {b.size - b.out})
  %one = zext i1 %from.bad to i32
  %two = select i1 %to.bad, i32 2, i32 0
  %flags = or i32 %one, %two
  ret i32 %flags
}}"""


def batch_entry(program: Program, routine: Routine) -> str:
    """The text of `<name>.batch`."""
    size = len(routine.results)
    moves = "\n".join(
        f"  %{s}.k = mul i64 %i, %{s}.stride\n  %{s}.at = getelementptr double, ptr %{s}, i64 %{s}.k" for s in "txpr"
    )
    inputs = ", ".join(f"ptr %{s}, i64 %{s}.stride" for s in "txpr")
    return f"""
define i64 @{routine.name}.batch(i64 %n, {inputs}, ptr %h, ptr %out) nounwind {{
  %shared = icmp eq i64 %p.stride, 0
  br i1 %shared, label %once, label %head
once:
  call void @hoist(ptr %p, ptr %h)
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
  call void @hoist(ptr %p.at, ptr %h)
  br label %run
run:
  %t.value = load double, ptr %t.at, align 8
  call void @{routine.name}(double %t.value, ptr %x.at, ptr %p.at, ptr %r.at, ptr %h, ptr %out.at)
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
