# SPDX-License-Identifier: BSD-3-Clause
"""Kane's equations and those of seven other methods give the same accelerations, from other kinematics and by other eliminations."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from benchmarks.methods import SYSTEMS, TABLE, table
from kane import free_symbols
from kane.dynamics import METHODS, OTHERS, InRates
from kane.errors import ModelError
from kane.gallery import double_pendulum, four_bar, free_body, load, rolling_disk, spinning_top
from kane.numeric import values_of

CLOSE, SEED, NEAR = 1e-10, 20106, 0.2
LONG = {"whipple_bicycle", "rattleback"}


def numbers(exprs, values):
    """Values of expressions at several states, (n, states)."""
    count = max(np.size(v) for v in values.values())
    known = {**values_of(free_symbols(exprs), SEED), **values}
    return np.array([np.broadcast_to(x, count) for x in kn.evaluate(list(exprs), known)], dtype=float)


def matrices(m, values):
    """Values of a matrix at several states, (states, m, n)."""
    return numbers(m.entries, values).T.reshape(-1, *m.shape)


def states(eom, count):
    """Coordinates on the configuration constraints, near those at which these were compared, and speeds on all of them."""
    rng = np.random.default_rng(SEED)
    q, u, conditions = eom.coordinates, eom.speeds, eom.derived.conditions
    starts = 2 * count + 10
    place = rng.uniform(-1, 1, (len(q), starts))
    if conditions.f:
        base = eom.derived.compared.at
        if eom.system.holonomic:
            drawn = rng.integers(base.count, size=starts)
            known = [np.broadcast_to(base.values.get(x, 0.5), base.count)[drawn] for x in q]
            place = np.array(known) + NEAR * rng.normal(size=(len(q), starts))
        for _ in range(30):
            values = dict(zip(q, place, strict=True))
            f, j = numbers(conditions.f, values).T, matrices(conditions.gradient, values)
            kept = np.isfinite(j).all(axis=(1, 2))
            place = place[:, kept] - np.einsum("kij,kj->ik", np.linalg.pinv(j[kept]), f[kept])
        left = np.abs(numbers(conditions.f, dict(zip(q, place, strict=True)))).max(axis=0)
        place = place[:, left < 1e-13]
        assert place.shape[1] >= count
    place = place[:, :count]
    values = dict(zip(q, place, strict=True))
    speeds = rng.uniform(-1, 1, (place.shape[1], len(u)))
    if len(eom.b):
        a, b = matrices(eom.A, values), numbers(eom.b, values).T
        speeds = speeds - np.einsum("kij,kj->ki", np.linalg.pinv(a), np.einsum("kij,kj->ki", a, speeds) + b)
    return values | dict(zip(u, speeds.T, strict=True))


def condition(eom, at):
    """Of BᵀMB, about that of A_D squared: which rates are dependent is chosen once, and where they follow poorly B is large."""
    held = InRates(eom.derived, eom.embedding and eom.embedding.partition).held
    if held is None:
        return 1.0
    return np.linalg.cond(matrices(held.a.take(columns=list(held.dependent)), at)) ** 2


def agree(module, count):
    """The methods that take the system; u̇ of each is Kane's."""
    eom = kn.derive(load(module).system())
    at = states(eom, count)
    wanted = numbers(eom.by("kane").accelerations, at)
    regular = np.isfinite(wanted).all(axis=0)
    assert regular.sum() >= 0.5 * count
    size = np.maximum(1, np.abs(wanted).max(axis=0))[regular]
    limit = (np.maximum(CLOSE, 100 * np.finfo(float).eps * condition(eom, at)) * np.ones(len(regular)))[regular]
    found = kn.compare_methods(eom)
    for name, formulation in found.formulations.items():
        off = np.abs(numbers(formulation.accelerations, at) - wanted).max(axis=0)[regular] / size
        assert (off <= limit).all(), name
    return found


@pytest.mark.slow
@pytest.mark.parametrize("module", sorted(set(SYSTEMS.values()) - LONG))
def test_methods_agree(module):
    found = agree(module, 5)
    assert len(found.formulations) == len(METHODS) or set(found.refused) <= {"hamilton", "boltzmann-hamel"}


@pytest.mark.slow
@pytest.mark.parametrize("module", sorted(SYSTEMS.values()))
def test_methods_agree_at_a_hundred_states(module):
    agree(module, 100)


@pytest.mark.slow
def test_operations_are_those_committed():
    assert table() == TABLE.read_text(encoding="utf-8"), "if that is meant: python -m benchmarks.methods --write"


@pytest.mark.slow
@pytest.mark.parametrize("method", [m for m in OTHERS if m != "hamilton"])
def test_equations_vanish_along_the_motion(method):
    """What is printed is zero at the accelerations, multipliers and constraint forces that solve it."""
    for module in (spinning_top, four_bar):
        eom = kn.derive(module.system())
        f = eom.by(method)
        at = states(eom, 3)
        rates = dict(zip((q.dt for q in eom.coordinates), numbers(eom.rates, at), strict=True))
        full = at | rates
        u_dot = dict(zip((u.dt for u in eom.speeds), numbers(eom.accelerations, at), strict=True))
        if method == "boltzmann-hamel":
            full |= u_dot
        else:
            own = [q.dt.dt for q in eom.coordinates]
            second = numbers([kn.time_derivative(x) for x in eom.rates], full | u_dot)
            full |= dict(zip(own, second, strict=True))
            extra = [x for x in f.unknowns if x not in set(own)]
            solved = numbers(f.right_hand_side[2 * len(eom.coordinates) :], full) if extra else []
            full |= dict(zip(extra, solved, strict=True))
        left = numbers(f.equations, full)
        assert np.abs(left).max() <= 1e-9, module.__name__


def test_loads_may_hold_declared_speeds():
    """A damper by the speed that was declared for its ends: right sides hold nothing but what each method has as its state."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    (x, y), (v, apart), c = kn.coordinates("x y"), kn.speeds("v apart"), kn.parameter("c", 0.7)
    P = O.at("P", x * N.x)
    Q = P.at("Q", y * y * N.x)
    damper = [kn.Force(P, c * apart * N.x, name="left"), kn.Force(Q, -c * apart * N.x, name="right")]
    speeds = {v: x.dt, apart: 2 * y * y.dt}
    bodies = [kn.Particle("A", P, 1.5), kn.Particle("B", Q, 0.8)]
    eom = kn.derive(kn.System(N, bodies=bodies, speeds=speeds, loads=damper))
    at = {x: 0.3, y: 0.9, v: -0.4, apart: 1.1, c: 0.7}
    wanted = [0.7 * 1.1 / 1.5, -0.7 * 1.1 * (1 / 0.8 + 1 / 1.5)]
    for method in METHODS:
        f = eom.by(method)
        assert kn.evaluate(list(f.accelerations), at) == pytest.approx(wanted, rel=1e-13), method
        assert set(free_symbols(f.right_hand_side)) <= {*f.state, c}, method


def test_hamilton_has_momenta_and_keeps_the_energy():
    """Ḣ = Q·q̇: along the motion that (q̇, ṗ) give, H of the kinetic energy grows as forces work."""
    eom = kn.derive(spinning_top.system())
    f = eom.by("hamilton")
    n = len(eom.coordinates)
    assert [s.name for s in f.state[n:]] == [f"p_{q.name}" for q in eom.coordinates]
    at = dict(zip(f.state, np.random.default_rng(3).uniform(0.4, 1, (2 * n, 4)), strict=True))
    q_dot, p_dot = np.split(numbers(f.right_hand_side, at), 2)
    half = sum(p * v for p, v in zip(f.state[n:], f.right_hand_side[:n], strict=True)) / 2  # H where T is of degree 2
    slopes = numbers(kn.gradient(half, f.state), at)
    change = (slopes[:n] * q_dot + slopes[n:] * p_dot).sum(axis=0)
    heavy = numbers(kn.gradient(eom.potential_energy, eom.coordinates), at)
    assert change == pytest.approx(-(heavy * q_dot).sum(axis=0), rel=1e-12)


def test_what_a_method_does_not_take_is_named():
    sliding = kn.derive(rolling_disk.system())
    for method in OTHERS:
        with pytest.raises(ModelError, match="contain no reaction"):
            sliding.by(method)
    assert sliding.by("kane").accelerations == sliding.accelerations
    body = kn.derive(free_body.system())
    with pytest.raises(ModelError, match="Euler parameters"):
        body.by("boltzmann-hamel")
    with pytest.raises(ModelError, match="singular everywhere"):
        _ = body.by("hamilton").accelerations
    with pytest.raises(ModelError, match="virtual work"):
        body.by("Gibbs-Appell")


def test_comparison_tells():
    found = kn.compare_methods(free_body.system(), ("kane", "lagrange", "hamilton"))
    assert found.shortest == "kane"
    assert set(found.refused) == {"hamilton"}
    assert repr(found).splitlines()[1].split()[:2] == ["kane", str(found["kane"].operations.total)]
    with pytest.raises(ModelError, match="singular everywhere"):
        _ = found["hamilton"]
    with pytest.raises(ModelError, match="Did you mean"):
        kn.compare_methods(free_body.system(), ("lagrang",))
    with pytest.raises(ModelError, match="System or its Equations"):
        kn.compare_methods(3)
    assert "<table" in found._repr_html_()
    rods = kn.derive(double_pendulum.system())
    assert "0 =" in str(rods.by("lagrange"))
    assert "<table" in rods.by("lagrange")._repr_html_()
