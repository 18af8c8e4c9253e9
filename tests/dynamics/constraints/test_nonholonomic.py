# SPDX-License-Identifier: BSD-3-Clause
"""Partial velocities, forces, masses and K in the independent speeds: those of the textbook, and what A_n makes of all."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane import free_symbols
from kane.expr import as_expr, rate
from kane.gallery import load, rolling_disk
from tests.dynamics.formulation.test_shortest import CONSTRAINED, admissible

EACH = [n for n in CONSTRAINED if n not in ("whipple_bicycle", "bricard")]


def pushed_disk(size=1e12):
    m = rolling_disk.model(contact="rolling")
    push = kn.Force(m.Ch, kn.parameter("push", size, "N") * (m.N.x + 2 * m.N.y), name="push")
    return m, kn.derive(m.system.replace(loads=[*m.system.loads, *m.system.gravities, push]))


def test_those_of_the_rolling_disk_are_the_textbook_s():
    m, eom = pushed_disk()
    u1, u2, u3 = eom.independent_speeds
    center, contact = eom.partial_velocities_nh[m.Cs], eom.partial_velocities_nh[m.Ch]
    assert [str(center[u]) for u in (u1, u2, u3)] == ["R B.z", "0", "-R B.x"]
    assert all(contact[u].is_zero for u in (u1, u2, u3))
    assert [str(eom.partial_angular_velocities_nh[m.C][u]) for u in (u1, u2, u3)] == ["B.x", "B.y", "B.z"]
    diagonal = [eom.mass_matrix_nh[k, k] for k in range(3)]
    assert [str(x) for x in diagonal] == ["5*m*R^2/4", "m*R^2/4", "3*m*R^2/2"]
    told = {str(quantity): str(x) for quantity, x in eom.steps[6].results}
    assert (told["~M[u1, u1]"], told["~M[u3, u3]"]) == ("5*m*R^2/4", "3*m*R^2/2")
    assert told["~f[u3]"] == "m*R^2*u1*u2"
    assert all(x is as_expr(0) for k, row in enumerate(eom.mass_matrix_nh.rows) for j, x in enumerate(row) if j != k)


def test_a_force_at_the_contact_is_exactly_absent_from_them():
    _, eom = pushed_disk()
    names = {s.name for s in free_symbols(eom.Fr_nh[:3])}
    assert "push" not in names
    assert "g" in names
    assert "push" in {s.name for s in free_symbols(eom.Fr_nh[3:])}


@pytest.mark.slow
@pytest.mark.parametrize("name", EACH)
def test_they_are_what_the_dependent_ones_leave(name, rng):
    """F̃_r = F_r + A_nᵀ F_D, likewise F̃*_r where u̇_D follows, M̃ = BᵀMB, and K."""
    eom = kn.derive(load(name).system())
    own = [eom.speeds.index(u) for u in eom.independent_speeds]
    rest = [eom.speeds.index(u) for u in eom.dependent_speeds]
    inputs = dict.fromkeys(eom.inputs, 0.3)
    zero = dict.fromkeys(eom.reactions, 0.0)
    for q, u in admissible(eom, name, rng, 2):
        at = {"q": q, "u": u, "inputs": inputs}
        u_dot = eom.evaluate(list(eom.accelerations), **at)
        known = dict(zip(map(rate, eom.speeds), map(float, u_dot), strict=True)) | zero
        a_n = np.array(eom.evaluate(eom.A_n, **at), dtype=float).reshape(len(rest), len(own))
        for found, every in ((eom.Fr_nh, eom.Fr), (eom.Fr_star_nh, eom.Fr_star)):
            plain = [kn.substitute(x, {s: as_expr(v) for s, v in known.items()}) for x in (*found, *every)]
            numbers = np.array(eom.evaluate(plain, **at), dtype=float)
            mine, all_ = numbers[: len(own)], numbers[len(found) :]
            wanted = all_[own] + a_n.T @ all_[rest]
            assert np.abs(mine - wanted).max(initial=0) <= 1e-9 * max(1, np.abs(all_).max())
        mass = np.array(eom.evaluate(eom.mass_matrix, **at), dtype=float)
        b = np.zeros((len(eom.speeds), len(own)))
        b[own], b[rest] = np.eye(len(own)), a_n
        own_mass = np.array(eom.evaluate(eom.mass_matrix_nh, **at), dtype=float)
        assert (
            np.abs(own_mass - b.T @ mass @ b).max()
            <= 1e-10 * np.abs(mass).max() * max(1, np.abs(a_n).max(initial=0)) ** 2
        )
        if not eom.reactions:
            left = own_mass @ np.array(u_dot, dtype=float)[own]
            right = np.array(eom.evaluate(list(eom.forcing_nh), **at), dtype=float)
            assert np.abs(left - right).max() <= 1e-9 * max(1, np.abs(mass).max() * np.abs(u_dot).max())
        k, usual = eom.evaluate([eom.kinetic_energy_nh, eom.kinetic_energy], **at)
        assert k == pytest.approx(usual, rel=1e-10)


def test_without_constraints_they_are_the_usual_ones():
    eom = kn.derive(rolling_disk.system())
    assert [str(x) for x in eom.Fr_nh] == [str(x) for x in eom.Fr]
    assert eom.mass_matrix_nh.shape == eom.mass_matrix.shape
