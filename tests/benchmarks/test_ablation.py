# SPDX-License-Identifier: BSD-3-Clause
"""What a rule buys: left out of its table it is not applied, the others are, and the numbers stay."""

import numpy as np
import pytest

import kane as kn
from benchmarks import ablation
from kane.equations import program
from kane.gallery import four_bar, rolling_disk
from kane.program import RULES, values

ROUTES = ablation.searches()
PASSES = ablation.options()


@pytest.fixture(scope="module", params=[four_bar, rolling_disk])
def eom(request) -> kn.Equations:
    return kn.derive(request.param.system())


def test_the_whole_search_is_that_of_derive(eom):
    assert ablation.routes()[""](eom) == eom.operations.total
    assert ablation.passes()[""](eom) == eom.compile().operations["rhs"].total


@pytest.mark.parametrize("left_out", [name for name in ROUTES if name])
def test_accelerations_are_the_same_without_a_route(left_out, eom, rng):
    found = ROUTES[left_out](eom.derived, None if eom.embedding is None else eom.embedding.partition)
    q = {s: kn.guess(rng.uniform(0.2, 0.6)) for s in eom.coordinates}
    start = kn.assemble(eom, q=q, u={u: rng.normal() for u in eom.independent_speeds})
    wanted, other = (
        np.array(eom.evaluate(list(s.accelerations), q=start.q, u=start.u), dtype=float) for s in (eom.solved, found)
    )
    np.testing.assert_allclose(other, wanted, rtol=1e-10, atol=1e-10 * np.abs(wanted).max())


@pytest.mark.parametrize("left_out", [name for name in PASSES if name])
def test_programs_give_the_same_without_a_rule(left_out, eom, rng):
    every = [program(eom.solved, ("rhs",), **PASSES[name]) for name in ("", left_out)]
    inputs = rng.uniform(0.4, 0.9, len(every[0].inputs))
    wanted, found = (np.array(list(map(values(p, r.body, inputs).get, r.results))) for p in every for r in p.routines)
    np.testing.assert_allclose(found, wanted, rtol=1e-10, atol=1e-10 * np.abs(wanted).max())


def test_what_is_left_out_is_not_applied(eom):
    costs = ablation.costs(["point at rest", "divisors", "optimize"], ("gallery", "four_bar"))
    assert costs["routes: declared: before, point at rest, momenta"] > 0, "bars turn about the frame's points"
    none = program(eom.solved, ("rhs",), rules=RULES._replace(divisors=(), rows=(), starts=("as read",)))
    whole, usual = (ablation.passes()[name](eom) for name in ("optimize", ""))
    assert usual < ablation.operations(none) <= whole


def test_a_row_says_where_an_entry_buys_most():
    found = {
        ("gallery", "a"): {"routes: x": 3, "routes: y": 0},
        ("gallery", "b"): {"routes: x": 5, "routes: y": 0},
        ("random", "7"): {"routes: x": -1, "routes: y": 0},
        ("random", "8"): {},
    }
    head, x, y = ablation.rows(found)
    assert head.split("  ") == ["gallery: 2 systems", "counted: 0 systems", "random: 1 systems"]
    assert x.split() == ["routes:", "x", "2", "+8", "(+5", "b)", "|", "0", "+0", "|", "1", "-1", "(-1", "7)"]
    assert y.split()[2:] == ["0", "+0", "|"] * 2 + ["0", "+0"]
