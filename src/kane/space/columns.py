# SPDX-License-Identifier: BSD-3-Clause
"""What freedoms that move several parts of a tree add to an inertia until these are all known.

At the accelerations (α, a) of an origin and λ_k of such freedoms the moment, the force and the generalized forces are

    n = J α + H a + Σ n_k λ_k + …,   f = Hᵀ α + M a + Σ f_k λ_k + …,   Q_k = n_k·α + f_k·a + Σ m_kl λ_l + e_k

with the columns n_k, f_k, their mass matrix m and what e_k is there at no acceleration.
"""

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import NamedTuple

from kane.expr.build import add
from kane.expr.matrix import dot
from kane.expr.node import ZERO, Expr
from kane.space.rotation import NOTHING, Triple, cross3


class Column(NamedTuple):
    """n_k, f_k, the row of m by freedom, and e_k."""

    n: Triple = NOTHING
    f: Triple = NOTHING
    row: Mapping[Expr, Expr] = MappingProxyType({})
    force: Expr = ZERO

    def along(self, spin: Triple, slide: Triple) -> Expr:
        """n_k·spin + f_k·slide."""
        return add(dot(spin, self.n), dot(slide, self.f))


Columns = Mapping[Expr, Column]
"""Columns by the rate that a freedom has λ of."""
NO_COLUMNS: Columns = MappingProxyType({})


def joined(a: Columns, b: Columns) -> Columns:
    """Both together."""
    if not a or not b:
        return a or b
    return {k: _sum(a[k], b[k]) if k in a and k in b else a.get(k) or b[k] for k in {**a, **b}}


def _sum(a: Column, b: Column) -> Column:
    return Column(_summed(a.n, b.n), _summed(a.f, b.f), with_entries(a.row, b.row), add(a.force, b.force))


def _summed(a: Triple, b: Triple) -> Triple:
    return add(a[0], b[0]), add(a[1], b[1]), add(a[2], b[2])


def with_entries(row: Mapping[Expr, Expr], more: Mapping[Expr, Expr]) -> dict[Expr, Expr]:
    """A row with more entries added to it."""
    whole = dict(row)
    for k, x in more.items():
        whole[k] = add(whole.get(k, ZERO), x)
    return whole


def turned(columns: Columns, up: Callable[[Triple], Triple]) -> Columns:
    """Along another basis."""
    return {k: c._replace(n=up(c.n), f=up(c.f)) for k, c in columns.items()} if columns else columns


def moved(columns: Columns, r: Triple) -> Columns:
    """About the point from which the origin lies at r."""
    return {k: c._replace(n=_summed(c.n, cross3(r, c.f))) for k, c in columns.items()} if columns else columns


def at(columns: Columns, alpha: Triple, a: Triple) -> Columns:
    """With what known parts of the acceleration add to e."""
    return {k: c._replace(force=add(c.force, c.along(alpha, a))) for k, c in columns.items()} if columns else columns
