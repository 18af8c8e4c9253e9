# SPDX-License-Identifier: BSD-3-Clause
r"""Vectors and dyadics as LaTeX: u_{1}\,\hat{b}_{x} + u_{2}\,\hat{b}_{y}."""

from collections.abc import Sequence

from kane.expr.build import add, mul
from kane.expr.node import ZERO, Expr
from kane.present.notebook.typeset import Typeset, typeset
from kane.space.rotation import Basis
from kane.space.vector import Dyadic, Vector
from kane.write.latex import LATEX, unit_vector_latex


def vector(v: Vector) -> Typeset:
    """A vector, as it is written: along the axes of all its frames."""
    terms = _terms(v)
    return _linear([x for x, _, _ in terms], [unit_vector_latex(f.name, axis) for _, f, axis in terms])


def dyadic(d: Dyadic) -> Typeset:
    """A dyadic multiplied out, a term for each pair of unit vectors."""
    terms: dict[tuple[Basis, str, Basis, str], Expr] = {}
    for a, b in d.dyads:
        for x, f, i in _terms(a):
            for y, g, k in _terms(b):
                terms[f, i, g, k] = add(terms.get((f, i, g, k), ZERO), mul(x, y))
    kept = {key: x for key, x in terms.items() if x is not ZERO}
    pairs = [f"{unit_vector_latex(f.name, i)} {unit_vector_latex(g.name, k)}" for f, i, g, k in kept]
    return _linear(list(kept.values()), pairs)


def _terms(v: Vector) -> list[tuple[Expr, Basis, str]]:
    return [(x, f, axis) for f, t in v.parts for x, axis in zip(t, "xyz", strict=True) if x is not ZERO]


def _linear(factors: Sequence[Expr], units: Sequence[str]) -> Typeset:
    return typeset(factors, lambda trees: [LATEX.along(trees, units)])
