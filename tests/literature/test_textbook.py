# SPDX-License-Identifier: BSD-3-Clause
"""Nonholonomic problems as the literature prints them: the same values, and little more operations than on the page."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane import free_symbols
from kane.expr import ZERO, as_expr
from tests.literature.textbook import (
    bearing,
    between_panes,
    cart,
    contact_oscillator,
    differential_drive,
    disk_by_rates,
    disk_from_contact,
    rolling_disk,
    sleigh,
    stone,
    turntable,
    vertical_disk,
)
from tests.literature.textbook.problem import READ

MARGIN = 1.3
PROBLEMS = {
    "rolling disk": rolling_disk.problem,
    "cart": cart.problem,
    "cart with uniform wheels": cart.with_uniform_wheels,
    "between panes": between_panes.problem,
    "bearing": bearing.problem,
    "disk from its contact": disk_from_contact.problem,
    "disk by rates": disk_by_rates.problem,
    "sleigh": sleigh.problem,
    "vertical disk": vertical_disk.problem,
    "sphere on a turntable": turntable.problem,
    "differential drive": differential_drive.by_its_own_speeds,
    "differential drive by its wheels": differential_drive.by_its_wheels,
    "rattleback": stone.problem,
    "contact oscillator": contact_oscillator.problem,
}


SLOW = {"bearing"}


@pytest.fixture(
    scope="module",
    params=[pytest.param(name, marks=[pytest.mark.slow] if name in SLOW else []) for name in PROBLEMS],
)
def solved(request):
    problem = PROBLEMS[request.param]()
    return problem, kn.derive(problem.system)


def random_values(eom, exprs, rng):
    """Values of every symbol that satisfy the constraints."""
    dependent = dict(
        zip(eom.dependent_speeds, map(kn.expr.add, eom.A_n @ eom.independent_speeds, eom.b_n), strict=True)
    )
    symbols = free_symbols([*exprs, *dependent.values()])
    values = {s: rng.uniform(0.3, 1.7) for s in symbols if s not in dependent}
    return values | {u: kn.evaluate(x, values) for u, x in dependent.items()}


@pytest.mark.slow
def test_the_published_forms_hold(solved, rng):
    problem, eom = solved
    for name, wanted in problem.published.items():
        found, wanted = list(READ[name](eom)), [as_expr(x) for x in wanted]
        assert [x is ZERO for x in found] == [x is ZERO for x in wanted], name
        for _ in range(5):
            values = random_values(eom, [*found, *wanted], rng)
            here, there = (np.array([kn.evaluate(x, values) for x in xs], dtype=float) for xs in (found, wanted))
            assert here == pytest.approx(there, rel=1e-10, abs=1e-10 * np.abs(there).max()), name


def test_they_are_about_as_short_as_on_the_page(solved):
    problem, eom = solved
    for name, wanted in problem.published.items():
        found, page = (kn.count_operations([as_expr(x) for x in xs]).total for xs in (READ[name](eom), wanted))
        assert found <= MARGIN * page, (name, found, page, [str(x) for x in READ[name](eom)])


def test_forces_that_contribute_nothing_are_absent(solved):
    problem, eom = solved
    for name in ("F̃", "f̃", "u̇"):
        assert not set(free_symbols(map(as_expr, READ[name](eom)))) & set(problem.noncontributing), name
