# SPDX-License-Identifier: BSD-3-Clause
"""Normal modes where some motion is held by nothing: λ is zero and not what rounding leaves."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy.linalg import eigh, expm

import kane as kn


def chain(masses, stiffness, unit=1.0):
    """Masses on a line with springs between them, free at both ends."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x = kn.coordinates(f"x1:{len(masses) + 1}")
    points = [O.at(f"P{i}", (s + i * unit) * N.x) for i, s in enumerate(x)]
    springs = [kn.linear_spring(a, b, stiffness, unit) for a, b in itertools.pairwise(points)]
    bodies = [kn.Particle(f"p{i}", p, m) for i, (p, m) in enumerate(zip(points, masses, strict=True))]
    return kn.derive(kn.System(N, bodies=bodies, speeds="rates", loads=springs))


@pytest.mark.slow
@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e9])
@pytest.mark.parametrize("masses", [(1.0, 2.0, 1.0), (0.3, 7.0, 1.1, 2.3, 0.9)])
def test_what_nothing_holds_has_no_frequency(masses, scale, rng):
    n = len(masses)
    modes = kn.normal_modes(kn.linearize(chain(masses, 3.0 * scale), q=[0.0] * n, u=[0.0] * n))
    d = np.diff(np.eye(n), axis=0)
    k, m = 3.0 * scale * d.T @ d, np.diag(masses)
    assert modes.squares[0] == modes.frequencies[0] == 0.0
    assert not modes.stable
    assert "; 0, " in repr(modes)
    assert modes.squares[1:] == pytest.approx(eigh(k, m)[0][1:], rel=1e-12)
    x, v, t = rng.normal(size=n), rng.normal(size=n), 1.3 / np.sqrt(scale)
    block = np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(m, k), np.zeros((n, n))]])
    expected = (expm(block * t) @ np.concatenate([x, v]))[:n]
    assert modes.motion(t, x=x, rates=v) == pytest.approx(expected, abs=1e-9 * np.abs(expected).max())


def test_what_swings_is_not_stable_and_shapes_keep_their_signs():
    """Whatever rounding leaves of Re λ = 0, and of components that are alike."""
    eom = chain((1.0, 1.0, 1.0), kn.parameter("k", 1.0, "N/m"))
    found = [kn.linearize(eom, q=[0] * 3, u=[0] * 3, parameters={"k": k}) for k in np.linspace(0.5, 3, 30)]
    assert not any(linear.stable for linear in found)
    shapes = [kn.normal_modes(linear).shapes for linear in found]
    np.testing.assert_allclose(shapes, np.tile(shapes[0], (30, 1, 1)), atol=1e-7)
    vectors = [linear.modes[0].vector for linear in found]
    assert [np.abs(v - 1).argmin() for v in vectors] == [np.abs(vectors[0] - 1).argmin()] * 30
    assert all(np.all(np.diff([mode.frequency for mode in linear.modes[:3]]) < 0) for linear in found)


def test_the_least_stable_comes_first_beside_any_frequency():
    """Masses that know nothing of each other, of which one leaves slowly."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    q = kn.coordinates("x y z")
    springs = [(1e9, 1e3), (4.0, 2e-3), (-1e-6, 0.0)]
    P = [O.at(f"P{k}", s * N.x) for k, s in enumerate(q)]
    loads = [kn.Force(p, -(k * s + c * s.dt) * N.x) for p, s, (k, c) in zip(P, q, springs, strict=True)]
    bodies = [kn.Particle(f"b{k}", p, 1.0) for k, p in enumerate(P)]
    linear = kn.linearize(kn.derive(kn.System(N, bodies=bodies, speeds="rates", loads=loads)), q=[0] * 3, u=[0] * 3)
    assert linear.eigenvalues[0] == pytest.approx(1e-3, rel=1e-6)
    assert not linear.stable
    assert linear.modes[0].eigenvalue == linear.eigenvalues[0]


def test_soft_springs_are_held():
    """A spring of a billionth of another's stiffness is no rounding."""
    soft = chain((1.0, 1.0), 1.0)
    linear = kn.linearize(soft, q=[0, 0], u=[0, 0]).second_order()
    weak = kn.normal_modes(
        type(linear)(linear.names, linear.inputs, linear.M, linear.C, np.diag([1.0, 1e-9]), linear.F)
    )
    assert weak.squares == pytest.approx([1e-9, 1.0], rel=1e-6)
    assert weak.stable


def stiff_and_slow():
    """A mass on a spring of 2 · 10⁹ N/m, one on a spring of 1 N/m to it, and a free one."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, y, z = kn.coordinates("x y z")
    A, B = O.at("A", x * N.x), O.at("B", y * N.x)
    bodies = [kn.Particle("a", A, 1.0), kn.Particle("b", B, 1.0), kn.Particle("c", O.at("C", z * N.y), 1.0)]
    loads = [kn.Force(A, -2e9 * x * N.x), kn.Force(B, (x - y) * N.x)]
    return kn.derive(kn.System(N, bodies=bodies, speeds="rates", loads=loads)), (x, y, z)


def test_what_depends_on_a_state_is_told_beside_its_own_row():
    """A slow mass beside a stiff spring, a place among outputs of forces: they were taken for independent of what was left out."""
    eom, (x, y, z) = stiff_and_slow()
    linear = kn.linearize(eom, q=0, u=0, outputs={"force": 2e9 * x, "place": z})
    with pytest.raises(kn.SimulationError, match=r"got y: .* depends on it"):
        linear.without(y)
    with pytest.raises(kn.SimulationError, match="got z: the output place depends on it"):
        linear.without("cyclic")
    with pytest.raises(kn.SimulationError, match="do not depend on others, got y, which depends on x"):
        linear.second_order(y)
    np.testing.assert_allclose(linear.second_order([x, y]).K, [[2e9, 0], [-1, 1]])


def test_states_are_named_by_symbols_by_names_and_alone():
    eom, (x, _, z) = stiff_and_slow()
    linear = kn.linearize(eom, q=0, u=0)
    for gone in (z, "z", [z]):
        assert kn.linearize(eom, q=0, u=0, leave_out=gone).coordinates == ("x", "y")
    assert linear.without(z).coordinates == linear.without("z").coordinates == ("x", "y")
    for own in (x, "x", [x], ["x"]):
        assert linear.second_order(own).names == ("x",)
    assert linear.second_order([]).names == ()
    for chosen in (x, "x"):
        with pytest.raises(kn.SimulationError, match="contain 3 of x, y, z that determine the others, got x"):
            kn.linearize(eom, q=0, u=0, independent=chosen)
    for wrong in ({"independent": 3}, {"leave_out": 3}, {"side": "x"}, {"side": [1]}, {"tolerance": "small"}):
        with pytest.raises(kn.KaneError, match=r"Expected .*, got"):
            kn.linearize(eom, q=0, u=0, **wrong)
    for wrong in ({"moving": 3}, {"independent": 3}, {"tolerance": "small"}):
        with pytest.raises(kn.KaneError, match=r"Expected .*, got"):
            kn.trim(eom, q=0, u=0, **wrong)
    assert kn.trim(eom, q=0, u=0, moving=z).q[z] == 0
    for any_size in (np.inf, np.array(1e-8)):
        assert kn.linearize(eom, q=0, u=0, tolerance=any_size).states == linear.states
        assert kn.trim(eom, q=0, u=0, tolerance=any_size).q[z] == 0
