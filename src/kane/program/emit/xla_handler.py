# SPDX-License-Identifier: BSD-3-Clause
"""The entry through which XLA, the compiler of JAX, calls the machine code of a routine, as LLVM text.

`<name>.xla(frame)` implements XLA's foreign function interface, version 0 (`xla/ffi/api/c_api.h`, 64-bit addresses): the frame gives
the buffers and shapes of the arguments and of the result. Each port, also a scalar, is a buffer of doubles with its values on the last
axis; all have the same number of leading axes, and axes of size 1 are broadcast. Values that are not finite propagate without an
error.
"""

from kane.program.emit.llvm import emit_llvm
from kane.program.program import Program, Routine

_HELPERS = """
define internal i64 @kane.xla.rows(ptr %sizes, i64 %lead) {
entry:
  br label %head
head:
  %k = phi i64 [0, %entry], [%k.next, %body]
  %n = phi i64 [1, %entry], [%n.next, %body]
  %some = icmp slt i64 %k, %lead
  br i1 %some, label %body, label %done
body:
  %at = getelementptr i64, ptr %sizes, i64 %k
  %size = load i64, ptr %at
  %n.next = mul i64 %n, %size
  %k.next = add i64 %k, 1
  br label %head
done:
  ret i64 %n
}

define internal i64 @kane.xla.place(ptr %sizes, ptr %whole, i64 %lead, i64 %row) {
entry:
  br label %head
head:
  %k = phi i64 [%lead, %entry], [%k.next, %body]
  %rest = phi i64 [%row, %entry], [%rest.next, %body]
  %apart = phi i64 [1, %entry], [%apart.next, %body]
  %place = phi i64 [0, %entry], [%place.next, %body]
  %some = icmp sgt i64 %k, 0
  br i1 %some, label %body, label %done
body:
  %k.next = sub i64 %k, 1
  %at = getelementptr i64, ptr %sizes, i64 %k.next
  %size = load i64, ptr %at
  %whole.at = getelementptr i64, ptr %whole, i64 %k.next
  %all = load i64, ptr %whole.at
  %own = urem i64 %rest, %all
  %rest.next = udiv i64 %rest, %all
  %alone = icmp eq i64 %size, 1
  %step = select i1 %alone, i64 0, i64 %own
  %moved = mul i64 %step, %apart
  %place.next = add i64 %place, %moved
  %apart.next = mul i64 %apart, %size
  br label %head
done:
  ret i64 %place
}"""


def emit_xla(program: Program, routine: Routine, contract: bool = True, lanes: int = 4) -> str:
    """The module of a program, with the XLA entry of one of its routines."""
    return emit_llvm([program], contract, lanes) + _HELPERS + _handler(program, routine)


def _handler(program: Program, routine: Routine) -> str:
    count = len(program.ports)
    buffers = "\n".join(
        f"""  %buffer.{k}.at = getelementptr ptr, ptr %arguments, i64 {k}
  %buffer.{k} = load ptr, ptr %buffer.{k}.at
{_field(f"%data.{k}", f"%buffer.{k}", 24)}
{_field(f"%sizes.{k}", f"%buffer.{k}", 40)}"""
        for k in range(count)
    )
    strides, plain = "", "true"
    for k, port in enumerate(program.ports):
        strides += f"""  %rows.{k} = call i64 @kane.xla.rows(ptr %sizes.{k}, i64 %lead)
  %alone.{k} = icmp eq i64 %rows.{k}, 1
  %full.{k} = icmp eq i64 %rows.{k}, %n
  %stride.{k} = select i1 %alone.{k}, i64 0, i64 {len(port.symbols)}
  %easy.{k} = or i1 %alone.{k}, %full.{k}
  %plain.{k} = and i1 {plain}, %easy.{k}
"""
        plain = f"%plain.{k}"
    places = "".join(
        f"""  %place.{k} = call i64 @kane.xla.place(ptr %sizes.{k}, ptr %sizes.out, i64 %lead, i64 %row)
  %shift.{k} = mul i64 %place.{k}, {len(port.symbols)}
  %at.{k} = getelementptr double, ptr %data.{k}, i64 %shift.{k}
"""
        for k, port in enumerate(program.ports)
    )
    whole = "".join(f"ptr %data.{k}, i64 %stride.{k}, " for k in range(count))
    single = "".join(f"ptr %at.{k}, i64 0, " for k in range(count))
    return f"""

define ptr @{routine.name}.xla(ptr %frame) nounwind {{
{_asked()}run:
{_field("%arguments", "%frame", 72)}
{_field("%results", "%frame", 112)}
  %result = load ptr, ptr %results
{_field("%out", "%result", 24)}
{_field("%sizes.out", "%result", 40)}
{buffers}
{_field("%axes", "%buffer.0", 32, "i64")}
  %lead = sub i64 %axes, 1
  %n = call i64 @kane.xla.rows(ptr %sizes.out, i64 %lead)
  %h = alloca double, i64 {max(1, len(program.kept))}, align 64
{strides}  br i1 {plain}, label %straight, label %head
straight:
  %first = call i64 @{routine.name}.batch(i64 %n, {whole}ptr %h, ptr %out)
  br label %done
head:
  %row = phi i64 [0, %run], [%row.next, %row.run]
  %some = icmp slt i64 %row, %n
  br i1 %some, label %row.run, label %done
row.run:
{places}  %out.shift = mul i64 %row, {len(routine.results)}
  %out.at = getelementptr double, ptr %out, i64 %out.shift
  %met = call i64 @{routine.name}.batch(i64 1, {single}ptr %h, ptr %out.at)
  %row.next = add i64 %row, 1
  br label %head
done:
  ret ptr null
}}
"""


def _asked() -> str:
    """The code that answers a query of the interface version; calls for stages other than execution return without effect."""
    return f"""entry:
{_field("%asked", "%frame", 8)}
  %is.asked = icmp ne ptr %asked, null
  br i1 %is.asked, label %extension, label %stage
extension:
{_field("%kind", "%asked", 8, "i32")}
  %is.metadata = icmp eq i32 %kind, 1
  br i1 %is.metadata, label %metadata, label %stage
metadata:
{_field("%told", "%asked", 24)}
{_field("%api", "%frame", 16)}
{_field("%minor", "%api", 36, "i32")}
  %major.at = getelementptr i8, ptr %told, i64 24
  store i32 0, ptr %major.at
  %minor.at = getelementptr i8, ptr %told, i64 28
  store i32 %minor, ptr %minor.at
  %traits.at = getelementptr i8, ptr %told, i64 32
  store i32 0, ptr %traits.at
  ret ptr null
stage:
{_field("%now", "%frame", 32, "i32")}
  %is.run = icmp eq i32 %now, 3
  br i1 %is.run, label %run, label %done
"""


def _field(name: str, record: str, at: int, kind: str = "ptr") -> str:
    """The load of a field at an offset in bytes of a record."""
    return f"  {name}.place = getelementptr i8, ptr {record}, i64 {at}\n  {name} = load {kind}, ptr {name}.place"
