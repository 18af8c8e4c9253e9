# SPDX-License-Identifier: BSD-3-Clause
"""Numbers at states where a pivot of the partition vanishes: named, never NaN or rounding's without a word."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import kane as kn

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
G, L, M = 9.81, 0.7, 2.0
x, y = kn.coordinates("x y")
u, v = kn.speeds("u v")
BOB = O.at("bob", x * N.x + y * N.y)
ROD = kn.distance(BOB, O, L, name="rod")


def pendulum(**more):
    """A bob on a rod in Cartesian coordinates; A = (x, y)/L."""
    speeds = {u: x.dt, v: y.dt}
    loads = [kn.gravity(-G * N.y)]
    return kn.derive(
        kn.System(N, bodies=[kn.Particle("bob", BOB, M)], speeds=speeds, loads=loads, holonomic=ROD, **more)
    )


LEVEL = {"q": [L, 0.0], "u": [0.0, 1.4]}
HANGING = {"q": [0.0, -L], "u": [1.4, 0.0]}


def by_hand(q, speeds):
    """r̈ = g + λ r/(m L) with r·r̈ = −v²."""
    r, w = np.array(q, dtype=float), np.array(speeds, dtype=float)
    thrust = M * (-(w @ w) + G * r[1]) / L
    return np.array([0, -G]) + thrust * r / (M * L), thrust


def test_a_vanishing_pivot_is_named_with_the_cure():
    eom = pendulum(dependent_speeds=[u])
    told = (
        r"dependent speeds that the constraints determine at this state, got u, which they give divided by [^ ]*x = 0\. "
        r"Name others, here System\(dependent_speeds=…\) of v; kn.simulate changes them automatically"
    )
    for wanted in (list(eom.accelerations), v.dt, eom.multipliers[ROD], eom.A_n, eom.power + u.dt):
        with pytest.raises(kn.SingularError, match=told):
            eom.evaluate(wanted, **HANGING)
    with pytest.raises(kn.SingularError, match=r"got u, which they give divided by [^ ]*x = "):
        eom.evaluate(list(eom.accelerations), q=[L * np.cos(np.pi / 2), -L], u=[1.4, 0.0])  # 4e-17, rounding's zero
    with pytest.raises(kn.SingularError, match=r"got u, which they give divided by [^ ]*x = "):
        eom.evaluate(eom.reaction(ROD).force.dot(N.y), **HANGING)


def test_the_cure_works():
    eom = pendulum(dependent_speeds=[v])
    found = np.array(eom.evaluate([*eom.accelerations, eom.multipliers[ROD]], **HANGING))
    acceleration, thrust = by_hand(HANGING["q"], HANGING["u"])
    np.testing.assert_allclose(found, [*acceleration, thrust], atol=1e-13)


def test_what_divides_by_no_pivot_is_left_alone():
    eom = pendulum(dependent_speeds=[u])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        energy, mass = eom.evaluate(eom.energy, **HANGING), eom.evaluate(eom.mass_matrix, **HANGING)
        assert eom.evaluate([x, eom.A[0, 1]], **HANGING) == pytest.approx([0, -1])
        assert not np.isfinite(eom.evaluate(1 / kn.sin(x), **HANGING))
        assert np.isnan(eom.evaluate(list(eom.accelerations), q=[np.nan, 0.1], u=[0, 0])).all()
    assert energy == pytest.approx(M * (1.4**2 / 2 - G * L))
    np.testing.assert_allclose(mass, M * np.eye(2))


def test_of_a_sweep_the_first_place_is_named_and_the_values_are_nan():
    eom = pendulum(dependent_speeds=[u])
    angle = np.linspace(-np.pi, np.pi, 9)  # 0 and ±π hang and stand
    state = {"q": [L * np.sin(angle), -L * np.cos(angle)], "u": [1.4 * np.cos(angle), 1.4 * np.sin(angle)]}
    with pytest.warns(
        kn.KaneWarning, match="got u, which .* at index 0 and 2 more: the values there are NaN. Name others, here"
    ):
        found = np.array(eom.evaluate([*eom.accelerations, eom.energy], **state))
    bad = np.arange(9) % 4 == 0
    assert np.isnan(found[:2, bad]).all()
    assert np.isfinite(found[2]).all()
    for k in np.flatnonzero(~bad):
        q, w = ([float(z[k]) for z in state[s]] for s in "qu")
        np.testing.assert_allclose(found[:2, k], by_hand(q, w)[0], atol=1e-12)


def test_a_singular_configuration_has_no_cure():
    """Two equal links back on themselves: the rows of A are one there, whichever speeds are dependent."""
    a, b, c = kn.coordinates("a b c")
    arm = O.at("elbow", kn.cos(a) * N.x + kn.sin(a) * N.y).at("tip", kn.cos(b) * N.x + kn.sin(b) * N.y)
    bead = O.at("bead", c * N.x)
    bodies = [kn.Particle("tip", arm, 1), kn.Particle("bead", bead, 1)]
    eom = kn.derive(kn.System(N, bodies=bodies, speeds="rates", holonomic=kn.coincident(arm, bead, (N.x, N.y))))
    with pytest.raises(
        kn.SingularError, match=r"No other choice is possible: .* a singular configuration. Use a nearby state"
    ):
        eom.evaluate(list(eom.accelerations), q=[np.pi / 2, -np.pi / 2, 0], u=[0, 0, 0])
