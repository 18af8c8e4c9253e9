# SPDX-License-Identifier: BSD-3-Clause
"""Solutions at ordinary states where an order of elimination that is fixed would divide by zero, see also `laws/test_regular_states`.

The multiplier form [M −Aᵀ; A 0] [u̇; λ] = [f; −(Ȧ u + ḃ)], solved in numbers by least squares, is the independent route: it holds
wherever A has its rank, whatever speeds are dependent.
"""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import kane as kn
from kane.equations import program
from kane.gallery import andrews_squeezer, four_bar, snakeboard
from tests.program.emitted import from_c, from_numpy
from tests.systems.closed_states import closed, speeds, states

EPS = np.finfo(float).eps


def derived(system, dependent=None):
    """Equations with dependent speeds by place; that constraints are redundant is known."""
    if dependent is not None:
        own = tuple(system.speeds)
        system = system.replace(dependent_speeds=[own[k] for k in dependent])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", kn.KaneWarning)
        return kn.derive(system)


def numbers(eom, what, q, u):
    return np.array(eom.evaluate(what, q=q, u=u, inputs=[0.3] * len(eom.inputs)), dtype=float)


def by_multipliers(eom, q, u):
    """u̇ from M, A, f and the drift."""
    M, A = (numbers(eom, x, q, u) for x in (eom.mass_matrix, eom.A))
    f, drift = numbers(eom, list(eom.forcing), q, u), numbers(eom, list(eom.constraints.drift), q, u)
    n, m = len(M), len(A)
    whole = np.block([[M, -A.T], [A, np.zeros((m, m))]])
    return np.linalg.lstsq(whole, np.concatenate([f, -drift]), rcond=1e-13)[0][:n]


def limit_at(eom, q, u):
    """What rounding leaves: of u_D by cond A_D, of u̇ also by the mass matrix of the independent speeds, which holds A_n twice."""
    p = eom.embedding.partition
    block = numbers(eom, eom.A, q, u)[np.ix_(p.rows, p.dependent)]
    solution = numbers(eom, eom.A_n, q, u)
    return max(1e-10, 100 * EPS * np.linalg.cond(block) * max(1.0, np.abs(solution).max(initial=0)))


def check(eom, q, u, compiled=None):
    """`evaluate` and the compiled right-hand side give what the multiplier form gives."""
    wanted = by_multipliers(eom, q, u)
    limit = limit_at(eom, q, u) * max(1.0, np.abs(wanted).max())
    assert np.abs(numbers(eom, list(eom.accelerations), q, u) - wanted).max() <= limit
    run = compiled or kn.compile(eom).rhs
    found = run(0.0, np.concatenate([q, u]), None, np.full(len(eom.inputs), 0.3))[len(q) :]
    assert np.abs(found - wanted).max() <= limit


MECHANISMS: dict[str, tuple[Any, list[Any]]] = {
    "four-bar": (four_bar.system, [(0, 1), (0, 2), (1, 2), None]),
    "squeezer": (andrews_squeezer.system, [(0, 1, 2, 3, 4, 5), None]),
    "snakeboard": (snakeboard.system, [None]),
}
CHOICES = [pytest.param(m, k, id=f"{m}, {k}") for m, (_, choices) in MECHANISMS.items() for k in choices]
QUICK = CHOICES[::2]


def regular_states(eom, rng, count):
    """Those at which the dependent speeds follow, too."""
    found = 0
    for q, u in states(eom, rng, 4 * count):
        try:
            share = 1 / limit_at(eom, q, u)
        except kn.SingularError:
            continue
        if share > 1e8:
            yield q, u
            found += 1
        if found == count:
            return
    assert found


def check_states(name, dependent, rng, count):
    make, _ = MECHANISMS[name]
    eom = derived(make(), dependent)
    run = kn.compile(eom).rhs
    for q, u in regular_states(eom, rng, count):
        check(eom, q, u, run)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "dependent"), QUICK)
def test_mechanisms_at_random_states(name, dependent, rng):
    check_states(name, dependent, rng, 3)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "dependent"), CHOICES)
def test_mechanisms_at_50_states(name, dependent, rng):
    check_states(name, dependent, rng, 50)


def test_a_crank_along_its_ground_link(rng):
    """a sin q1, by which an order of elimination would divide, is zero; the determinant a c sin(q1 − q3) is not."""
    eom = derived(four_bar.system(), (0, 2))
    q = closed(eom, [0.0, 0.9, 1.9], [1, 2])
    check(eom, q, speeds(eom, q, rng)[0])


@pytest.mark.parametrize("dependent", [(0, 2), pytest.param((1, 2), marks=pytest.mark.slow)])
def test_emitted_code_gives_the_same_numbers_and_nan_where_the_determinant_vanishes(dependent, rng, tmp_path):
    """Folded flat on its ground pins a link gives no speed: every language says NaN."""
    eom = derived(four_bar.system(), dependent)
    made = program(eom.solved, ("rhs",), name="bar")
    c, python = from_c(made, tmp_path, True), from_numpy(made, tmp_path)
    p = [s.default for s in made.port("p").symbols]
    run = kn.compile(eom, not_finite="ignore").rhs
    q = closed(eom, [0.0, 0.9, 1.9], [1, 2])
    u = speeds(eom, q, rng)[0]
    wanted = by_multipliers(eom, q, u)
    flat = np.array([0.3, 0.3, 0.3, 1.0, 0.5, 0.2])
    for x, expected in ((np.concatenate([q, u]), wanted), (flat, np.full(3, np.nan))):
        found = [
            run(0.0, x),
            run(0.0, np.array([x] * 5))[3],
            c("rhs", [np.array([0.0, *x, *p])])[0],
            python.rhs(0.0, x),
            python.rhs(0.0, np.array([x] * 5))[3],
        ]
        for numbers_of in found:
            np.testing.assert_allclose(numbers_of[3:], expected, rtol=1e-9, atol=1e-9)
    with pytest.raises(kn.NotFiniteError, match=r"which the constraints give divided by .* zero beside its terms of"):
        kn.compile(eom, not_finite="raise").rhs(0.0, flat)


def test_a_motion_of_a_second_keeps_its_loop_closed(rng):
    eom = derived(four_bar.system())
    run, count = kn.compile(eom).rhs, len(eom.coordinates)
    q, u = next(iter(regular_states(eom, rng, 1)))
    motion = solve_ivp(lambda t, x: run(t, x), (0, 1), np.concatenate([q, 0.1 * u]), rtol=1e-9, atol=1e-10)
    assert motion.success
    f = [c.expr for c in eom.system.holonomic]
    end = dict(zip(eom.coordinates, motion.y[:count, -1], strict=True))
    assert np.abs(np.array(kn.evaluate(f, end), dtype=float)).max() < 1e-6
