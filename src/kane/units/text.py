# SPDX-License-Identifier: BSD-3-Clause
"""A unit as text, in the spelling of the symbols at hand where one of them has that unit."""

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from itertools import product as choices

from kane.expr.evaluation import free_symbols
from kane.expr.node import Expr, postorder
from kane.units.algebra import NONE, Exponent, Unit
from kane.units.parser import parse

_NAMED = {parse(p + s): p + s for s in "NJW" for p in ("", "m", "k", "M")} | {
    parse(text): text for text in ("N/m", "N*s/m", "N*m*s")
}
_USUAL = (("kg", "g", "t"), ("m", "mm", "cm", "km"), ("s", "ms", "min", "h"), ("A",), ("K",), ("mol",), ("cd",))
_SI = tuple(names[0] for names in _USUAL)
_LINEAR = {"add", "sub", "neg", "symbol", "const", "pi"}


def spelled(unit: Unit, e: Expr | None = None) -> str:
    """A unit as text that `parse` reads; a symbol's spelling where one in `e` has this unit, for an angle in rad too."""
    leaves = () if e is None else free_symbols((e,))
    written = {parse(s.unit): s.unit for s in reversed(leaves) if s.unit}
    own = written.get(unit, "")
    if unit.is_bare and unit.scale == 1:
        linear = e is not None and all(_keeps_angles(node) for node in postorder((e,)))
        return own if own and linear else "1"
    plain = f"{unit.scale:.6g} {_joined(_SI, unit.exponents)}"
    return own or _NAMED.get(unit) or next(_composed(unit, written), plain)


def _keeps_angles(node: Expr) -> bool:
    return node.op.name in _LINEAR or (node.op.name == "mul" and node.args[0].op.name in ("const", "pi"))


def _composed(unit: Unit, written: Mapping[Unit, str]) -> Iterator[str]:
    """Products of base units that have its scale, those of the symbols at hand first, then those of SI."""
    options: list[list[str]] = []
    for i, names in enumerate(_USUAL):
        base = (*NONE[:i], 1, *NONE[i + 1 :])
        options.append([*(t for u, t in written.items() if u.exponents == base), *names] if unit.exponents[i] else [""])
    for chosen in choices(*options):
        scale = math.prod(parse(n).scale ** float(e) for n, e in zip(chosen, unit.exponents, strict=True) if e)
        if math.isclose(scale, unit.scale, rel_tol=1e-9):
            yield _joined(chosen, unit.exponents)


def _joined(names: Sequence[str], exponents: tuple[Exponent, ...]) -> str:
    pairs = list(zip(names, exponents, strict=True))
    above = "*".join(_powered(n, e) for n, e in pairs if e > 0)
    below = "".join(f"/{_powered(n, -e)}" for n, e in pairs if e < 0)
    return (above or "1") + below


def _powered(name: str, exponent: Exponent) -> str:
    if exponent == 1:
        return name
    return f"{name}^({exponent})" if isinstance(exponent, Fraction) else f"{name}^{exponent}"


def unit_text(unit: str) -> str:
    """A unit with raised exponents: m/s², N·m."""
    return re.sub(r"\^(-?\d+)", lambda m: m[1].translate(_RAISED), unit).replace("*", "·").replace(" ", " ")


_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
