# SPDX-License-Identifier: BSD-3-Clause
"""Damping of a beam: C = α M + β K (Rayleigh), or a ratio ζ for each mode of the beam with its root held.

With M = ρA L m and K = k EI/L³ in numbers m, k and their modes mΦ: ΦᵀmΦ = 1, ΦᵀkΦ = λ², the ratio ζ has
C = 2 ζ √(ρA L EI/L³) · mΦ diag(λ) Φᵀm.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from kane.errors import ModelError, alike, cut
from kane.expr.build import mul, sqrt
from kane.expr.node import Expr, as_expr, constant_value
from kane.expr.symbols import Parameter
from kane.model.beams.deformation import SHEAR, Field, Fields
from kane.model.beams.elastic import Gauges, damper, stiffness, stiffness_value
from kane.model.beams.integrals import fine
from kane.model.beams.masses import Matter
from kane.model.loads import Load
from kane.numeric.arrays import Array
from kane.numeric.scale import ROUNDED, ROUNDED_CHAIN

_DIGITS = 30
UNITS = {"mass": ("alpha", "1/s"), "stiffness": ("beta", "s"), "ratio": ("zeta", "1")}
"""Symbol and unit of the parameters that numbers become."""


def damping_of(
    name: str, gauges: Gauges, whole: Fields, matter: Matter, damping: Mapping[str, Any] | None
) -> tuple[Load, ...]:
    """The load of the damping, if there is any."""
    if damping is None:
        return ()
    given: object = damping
    if not isinstance(given, Mapping) or not damping:
        raise ModelError(
            f'Expected damping= of {name} as {{"mass": α, "stiffness": β}} or {{"ratio": ζ}}, got {cut(repr(damping))}.'
        )
    for kind in damping:
        if kind not in UNITS:
            raise ModelError(
                f"Expected damping= of {name} by some of {', '.join(UNITS)}, got {kind!r}.{alike(str(kind), UNITS)}"
            )
    if any(f.stem in SHEAR.values() for f in whole.fields) and set(damping) != {"stiffness"}:
        raise ModelError(
            f'Expected damping= of {name}, which shears, as {{"stiffness": β}}, got {", ".join(map(repr, damping))}: its modes are '
            "those of bending and shear together."
        )
    values = {kind: _parameter(name, kind, x) for kind, x in damping.items()}
    return (damper(name, gauges, [(f, _terms(f, whole, matter, values)) for f in whole.fields]),)


def _parameter(name: str, kind: str, given: Any) -> Expr:
    """A value in parameters; a number becomes one, so that its unit is known. Not below zero."""
    value = as_expr(given)
    number = constant_value(value)
    known = value.default if isinstance(value, Parameter) else number
    if known is not None and not float(known) >= 0:
        raise ModelError(f"Expected damping {kind!r} of {name} not below zero, got {float(known):g}. Check its sign.")
    if number is None:
        return value
    symbol, unit = UNITS[kind]
    return Parameter.declare(f"{symbol}_{'_'.join(name.split())}", float(number), unit, f"damping of {name}")


def _terms(f: Field, whole: Fields, matter: Matter, damping: Mapping[str, Expr]) -> list[tuple[Expr, Array]]:
    share = matter.polar if f.stem == "t" else matter.mass
    assert share is not None
    rule = fine([f.shapes])
    values = f.shapes.evaluate(rule.places, 0)
    m, k = rule.gram(values, values, share.share(rule.places)), stiffness(f)
    size = np.sqrt(np.diag(m))
    m[np.abs(m) < ROUNDED * np.multiply.outer(size, size)] = 0.0
    mass, stiff = mul(share.value, whole.length), stiffness_value(f, whole.length)
    terms = []
    if "mass" in damping:
        terms.append((mul(damping["mass"], mass), m))
    if "stiffness" in damping:
        terms.append((mul(damping["stiffness"], stiff), k))
    if "ratio" in damping:
        terms.append((mul(2 * damping["ratio"], sqrt(mul(mass, stiff))), _critical(m, k)))
    return terms


def _critical(m: Array, k: Array) -> Array:
    """mΦ diag(λ) Φᵀm, in more digits than are kept, which LAPACK's last ones depend on the machine."""
    import mpmath

    with mpmath.workdps(_DIGITS):
        lower = mpmath.cholesky(mpmath.matrix(m.tolist()))
        inverse = lower**-1
        squares, modes = mpmath.eigsy(inverse * mpmath.matrix(k.tolist()) * inverse.T)
        half = lower * modes
        c = half * mpmath.diag([mpmath.sqrt(max(x, 0)) for x in squares]) * half.T
        found = np.array(c.tolist(), dtype=float)
    found[np.abs(found) < ROUNDED_CHAIN * np.abs(found).max()] = 0.0
    return found
