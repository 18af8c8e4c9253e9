# SPDX-License-Identifier: BSD-3-Clause
"""Generalized momenta and impulses, momenta of the rates, cyclic coordinates."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.gallery import chaplygin_sleigh, free_body, spherical_pendulum, spinning_top

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)


def test_they_are_derivatives_of_the_kinetic_energy():
    """p_r = ∂K/∂u_r, and ∂K/∂q̇_s = Σ p_r Y_rs (Kane & Levinson 1985, sec. 6.8)."""
    for system in (spinning_top.system(), spherical_pendulum.system(), chaplygin_sleigh.system()):
        eom = kn.derive(system)
        rng = np.random.default_rng(5)
        q = rng.uniform(0.2, 0.9, len(eom.coordinates))
        u = rng.uniform(-1, 1, len(eom.independent_speeds))
        state = {"q": q, "u": dict(zip(eom.independent_speeds, u, strict=True))}
        by_speeds, slopes, by_rates, y = eom.evaluate(
            [
                list(eom.generalized_momenta),
                list(kn.gradient(eom.kinetic_energy, eom.speeds)),
                list(eom.conjugate_momenta),
                eom.Y,
            ],
            **state,
        )
        assert np.array(by_speeds) == pytest.approx(np.array(slopes), rel=1e-12, abs=1e-12)
        assert np.array(by_rates) == pytest.approx(np.array(by_speeds) @ y[: len(by_speeds)], rel=1e-12, abs=1e-12)
    independent = eom.evaluate(
        [*eom.generalized_momenta_nh, *kn.gradient(eom.kinetic_energy_nh, eom.independent_speeds)], **state
    )
    half = len(independent) // 2
    assert np.array(independent[:half]) == pytest.approx(np.array(independent[half:]), rel=1e-12)


def test_impulses_change_momenta():
    """I_r = Δp_r: a blow J across the end of a rod on ice gives it v = J/m and ω = J l/(2 I)."""
    a, x, y = kn.coordinates("a x y")
    A, m, l = N.rotate("A", a, N.z), 3.0, 0.8
    S = O.at("S", x * N.x + y * N.y)
    E = S.at("E", l / 2 * A.x)
    rod = kn.RigidBody("rod", frame=A, mass_center=S, mass=m, inertia=kn.rod(A, m, l, axis=A.x))
    eom = kn.derive(kn.System(N, bodies=[rod], speeds="rates", loads=[kn.Force(E, 0 * N.x)], coordinates=(a, x, y)))
    blow = 0.7
    impulses = eom.evaluate(
        list(eom.generalized_impulses([(E, blow * A.y), (A, 0.1 * N.z)])), q=[0.0, 0, 0], u=[0, 0, 0]
    )
    change = np.linalg.solve(eom.evaluate(eom.mass_matrix, q=[0.0, 0, 0], u=[0, 0, 0]), np.array(impulses))
    assert change == pytest.approx([(blow * l / 2 + 0.1) / (m * l**2 / 12), 0, blow / m], abs=1e-14)
    with pytest.raises(kn.ArgumentError, match=r"Expected \(point, impulse\)"):
        eom.generalized_impulses([blow * A.y])
    with pytest.raises(kn.ArgumentError, match=r"Expected \(point, impulse\)"):
        eom.generalized_impulses([("E", blow * A.y)])
    elsewhere = kn.Point("Z", fixed_in=kn.Frame("other"))
    with pytest.raises(kn.ModelError, match="got Z, whose root Z is fixed in other"):
        eom.generalized_impulses([(elsewhere, blow * A.y)])


def test_cyclic_coordinates():
    assert [str(q) for q in kn.derive(spinning_top.system()).cyclic_coordinates] == ["psi", "phi"]
    assert [str(q) for q in kn.derive(spherical_pendulum.system()).cyclic_coordinates] == ["phi"]
    assert [str(q) for q in kn.derive(free_body.system()).cyclic_coordinates] == ["x", "y", "z"]


def test_a_force_along_it_is_no_cyclic_coordinate():
    q = kn.coordinate("s")
    bead = kn.Particle("bead", O.at("B", q * N.x), 2.0)
    free = kn.System(N, bodies=[bead], speeds="rates")
    assert kn.derive(free).cyclic_coordinates == (q,) or str(kn.derive(free).cyclic_coordinates[0]) == "s"
    pushed = free.replace(loads=[kn.Force(bead.point, 1e-9 * N.x)])
    assert kn.derive(pushed).cyclic_coordinates == ()


def test_central_angular_momentum_is_that_about_the_centre():
    eom = kn.derive(free_body.system())
    rng = np.random.default_rng(8)
    e = rng.normal(size=4)
    q = dict(zip(eom.coordinates, rng.uniform(0.2, 0.9, len(eom.coordinates)), strict=True))
    for s in eom.system.euler_parameters:
        q.update(zip(s.coordinates, e / np.linalg.norm(e), strict=True))
    state = {"q": q, "u": rng.uniform(-1, 1, len(eom.speeds))}
    root = eom.points[0].root()
    h, p, r, own = (
        eom.evaluate(v, **state)
        for v in (
            eom.angular_momentum(root),
            eom.linear_momentum(),
            eom.mass_center(root),
            eom.central_angular_momentum,
        )
    )
    assert own == pytest.approx(h - np.cross(r, p), abs=1e-13)
