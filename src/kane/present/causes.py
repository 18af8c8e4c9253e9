# SPDX-License-Identifier: BSD-3-Clause
"""Each u̇ expanded into products, one for each contribution of a load or of the inertia of a body, if that is short.

    u̇_r = Σ_s M⁻¹_rs (F_s + F*_s at u̇ = 0)

M⁻¹ is written in closed form for speeds that M couples at most in pairs; systems with constraints or contacts are excluded.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from kane.equations.equations import Equations
from kane.expr.build import div, mul, neg, sub, sum_of
from kane.expr.forms.collect import expanded, factored
from kane.expr.node import ONE, ZERO, Expr
from kane.expr.symbols import Symbol, rate
from kane.expr.visit import substitute
from kane.write.latex import to_latex

_TERMS, _SPEEDS, _LETTERS = 8, 4, 90
"""Limits of what is short: terms of an equation, equations, and letters of a term in LaTeX."""


@dataclass(frozen=True, slots=True, eq=False)
class Cause:
    """A term of u̇: the load or body from which it comes, its kind, "active" or "inertia", and its LaTeX."""

    source: str
    kind: str
    term: Expr
    latex: str


def multiplied_out(eom: Equations) -> Mapping[Symbol, Sequence[Cause]] | None:
    """The terms of each u̇; None if they are too many or too long."""
    if eom.embedding or eom.system.contacts or len(eom.speeds) > _SPEEDS:
        return None
    inverse = _inverse(eom)
    forces = None if inverse is None else [_forces(eom, u) for u in eom.speeds]
    if inverse is None or forces is None:
        return None
    result: dict[Symbol, Sequence[Cause]] = {}
    for r, u in enumerate(eom.speeds):
        shares = [(inverse[r, s], own) for s, own in enumerate(forces) if (r, s) in inverse]
        terms = list(_terms(shares))
        if None in terms or len(terms) > _TERMS:
            return None
        result[u] = [t for t in terms if t is not None]
    return result


def _forces(eom: Equations, u: Symbol) -> Mapping[tuple[str, str], Expr]:
    """Contributions of loads and bodies to the equation of u, except M u̇."""
    still = {rate(s): ZERO for s in eom.speeds}
    own = eom.contributions(u)
    found: dict[tuple[str, str], list[Expr]] = {}
    for kind, parts in (("active", own.active), ("inertia", own.inertia)):
        for c in parts:
            found.setdefault((c.source.name, kind), []).append(substitute(c.term, still))
    return {which: sum_of(parts) for which, parts in found.items()}


def _terms(shares: Sequence[tuple[Expr, Mapping[tuple[str, str], Expr]]]) -> Iterator[Cause | None]:
    """The products that each load and body adds to u̇; None in place of long ones."""
    for which in dict.fromkeys(which for _, own in shares for which in own):
        products = expanded(sum_of([mul(m, own[which]) for m, own in shares if which in own]))
        for product in [None] if products is None else products:
            term = ZERO if product is None else factored([product])
            latex = to_latex(term)
            yield Cause(*which, term, latex) if product is not None and len(latex) <= _LETTERS else None


def _inverse(eom: Equations) -> Mapping[tuple[int, int], Expr] | None:
    """The nonzero entries of M⁻¹; None if M couples more than two speeds."""
    m, n = eom.mass_matrix, len(eom.speeds)
    result: dict[tuple[int, int], Expr] = {}
    for i in range(n):
        others = [j for j in range(n) if j != i and m[i, j] is not ZERO]
        if len(others) > 1:
            return None
        if not others:
            result[i, i] = div(ONE, m[i, i])
            continue
        (j,) = others
        squares = sub(mul(m[i, i], m[j, j]), mul(m[i, j], m[i, j]))
        short = expanded(squares)
        squares = squares if short is None else factored(short)
        result[i, i], result[i, j] = div(m[j, j], squares), neg(div(m[i, j], squares))
    return result
