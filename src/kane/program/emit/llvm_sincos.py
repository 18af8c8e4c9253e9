# SPDX-License-Identifier: BSD-3-Clause
"""Sine and cosine of the angles in the lanes of a vector, as LLVM text."""

from kane.program.emit.llvm_lanes import Lanes
from kane.program.emit.sincos import LIMIT, STEPS, constant

# Sine and cosine change places where n is odd. Bit 1 of n turns the sign of the sine, bit 1 xor bit 0 that of the cosine.
# Masks and not `select`: for one double LLVM makes a jump of it, which is mispredicted half the time.
_QUADRANT = """\
  %t.bits = bitcast {v} %t to {i}
  %half = shl {i} %t.bits, {n62}
  %odd = shl {i} %t.bits, {n63}
  %mask = ashr {i} %odd, {n63}
  %flip = and {i} %half, {sign}
  %s.bits = bitcast {v} %sine to {i}
  %c.bits = bitcast {v} %cosine to {i}
  %differ = xor {i} %s.bits, %c.bits
  %swap = and {i} %differ, %mask
  %s.change = xor {i} %swap, %flip
  %c.change = xor {i} %s.change, %odd
  %s.turned = xor {i} %s.bits, %s.change
  %c.turned = xor {i} %c.bits, %c.change
  %s.near = bitcast {i} %s.turned to {v}
  %c.near = bitcast {i} %c.turned to {v}"""

_FAR = """\
  %x.bits = bitcast {v} %x to {i}
  %x.size = and {i} %x.bits, {unsigned}
  %x.abs = bitcast {i} %x.size to {v}
  %far = fcmp ugt {v} %x.abs, {limit}"""

_ANY = """\
  %bits = bitcast {b} %far to i{width}
  %any = icmp ne i{width} %bits, 0"""

_LIBRARY = """\
  br i1 {any}, label %library, label %done
library:
  %both = call {pair} @kane.sincos.far.{width}({v} %x)
  %s.library = extractvalue {pair} %both, 0
  %c.library = extractvalue {pair} %both, 1
  %s.far = select {b} %far, {v} %s.library, {v} %s.near
  %c.far = select {b} %far, {v} %c.library, {v} %c.near
  br label %done
done:
  %s = phi {v} [ %s.near, %entry ], [ %s.far, %library ]
  %c = phi {v} [ %c.near, %entry ], [ %c.far, %library ]"""

_RETURN = """\
  %result.s = insertvalue {pair} poison, {v} {s}, 0
  %result = insertvalue {pair} %result.s, {v} {c}, 1
  ret {pair} %result
}}"""

_LANE = """\
  %x{k} = extractelement {v} %x, i32 {k}
  %sin{k} = call double @sin(double %x{k})
  %cos{k} = call double @cos(double %x{k})
  %s{k} = insertelement {v} {s}, double %sin{k}, i32 {k}
  %c{k} = insertelement {v} {c}, double %cos{k}, i32 {k}"""


def llvm_sincos(width: int, contract: bool) -> str:
    """The functions of `width` angles at a time, `{V, V} @kane.sincos.<width>(V)` with V = double or <width x double>.

    Lanes are independent of each other: one beyond LIMIT has the library's values, the others keep theirs. The module must
    declare `double @sin(double)` and `double @cos(double)`. With `contract`, products and sums may become FMA.
    """
    lanes = Lanes(width)
    fields = {
        "width": str(width),
        "v": lanes.double,
        "i": lanes.of("i64"),
        "b": lanes.of("i1"),
        "n62": lanes.all("i64", 62),
        "n63": lanes.all("i64", 63),
        "sign": lanes.all("i64", -(2**63)),
        "unsigned": lanes.all("i64", 2**63 - 1),
        "limit": lanes.number(LIMIT),
        "any": "%any" if width > 1 else "%far",
        "pair": f"{{{lanes.double}, {lanes.double}}}",
    }
    lines = [
        "define internal {pair} @kane.sincos.{width}({v} %x) alwaysinline nounwind {{",
        "entry:",
        *_steps(lanes, "contract " if contract else ""),
        _QUADRANT,
        _FAR,
        *([_ANY] if width > 1 else []),
        _LIBRARY,
        _RETURN,
    ]
    near = "\n".join(lines).format(**fields, s="%s", c="%c")
    return f"{near}\n{_far(width, fields)}"


def _far(width: int, fields: dict[str, str]) -> str:
    """The library's values of all lanes: apart and cold, so that little of it is in the callers."""
    lines = ["define internal {pair} @kane.sincos.far.{width}({v} %x) noinline cold nounwind {{".format(**fields)]
    s, c = "poison", "poison"
    if width == 1:
        s, c = "%sin", "%cos"
        lines += ["  %sin = call double @sin(double %x)", "  %cos = call double @cos(double %x)"]
    else:
        for k in range(width):
            lines.append(_LANE.format(**fields, k=k, s=s, c=c))
            s, c = f"%s{k}", f"%c{k}"
    return "\n".join([*lines, _RETURN.format(**fields, s=s, c=c), ""])


def _steps(lanes: Lanes, flags: str) -> list[str]:
    lines = []
    for name, form, *operands in STEPS:
        x, y, *added = (_operand(o, lanes) for o in operands)
        if added:
            lines.append(f"  %{name}.product = fmul {flags}{{v}} {x}, {y}")
            form, x, y = "add", f"%{name}.product", added[0]
        lines.append(f"  %{name} = f{form} {flags}{{v}} {x}, {y}")
    return lines


def _operand(operand: str, lanes: Lanes) -> str:
    value = constant(operand)
    return f"%{operand}" if value is None else lanes.number(value)
