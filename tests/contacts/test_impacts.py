# SPDX-License-Identifier: BSD-3-Clause
"""Impacts: a rod in closed form by three laws, energy, turning slip beside a second route, several at one instant."""

import warnings

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from kane.contacts import ContactStatus, ImpactPhase, Law, Rule, impact, impacts
from kane.errors import ArgumentError, ContactError, KaneWarning
from tests.oracles.contact_impacts import stronge

SEEDS = st.integers(0, 2**32 - 1)


def rod(degrees):
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[1 + 3 * c * c, -3 * c * s], [-3 * c * s, 1 + 3 * s * s]])


def in_space(w, v):
    """The same with a second tangent across, along which nothing happens."""
    wide = np.eye(3)
    wide[:2, :2] = w
    return wide, [*v, 0.0]


def turned(w, v, angle):
    """With tangents that are turned about the normal."""
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    return turn @ w @ turn.T, turn @ v


HITS = [  # Routh's process by hand: angle, v⁻, μ, e, law; v_n⁺, v_t⁺, ΔE, phases
    (60, [-1, 0.75], 0.5, 0.9, Law.NEWTON, 0.9, 0.0, 0.043335269814, (ImpactPhase.SLIP, ImpactPhase.STICK)),
    (
        60,
        [-1, 0.75],
        0.5,
        0.9,
        Law.POISSON,
        0.630199778052,
        0.0,
        -0.124384327581,
        (ImpactPhase.SLIP, ImpactPhase.STICK),
    ),
    (
        60,
        [-1, 0.75],
        0.5,
        0.9,
        Law.STRONGE,
        0.688336122294,
        0.0,
        -0.093243291926,
        (ImpactPhase.SLIP, ImpactPhase.STICK),
    ),
    (
        45,
        [-1, 0.5],
        0.3,
        0.5,
        Law.NEWTON,
        0.5,
        -0.308943089431,
        -0.153100006610,
        (ImpactPhase.SLIP, ImpactPhase.SLIP_AGAIN),
    ),
    (
        45,
        [-1, 0.5],
        0.3,
        0.5,
        Law.POISSON,
        0.4,
        -0.272357723577,
        -0.170797805539,
        (ImpactPhase.SLIP, ImpactPhase.SLIP_AGAIN),
    ),
    (
        45,
        [-1, 0.5],
        0.3,
        0.5,
        Law.STRONGE,
        0.427525177946,
        -0.282427910631,
        -0.166359609006,
        (ImpactPhase.SLIP, ImpactPhase.SLIP_AGAIN),
    ),
]


@pytest.mark.parametrize("space", [False, True])
@pytest.mark.parametrize(("degrees", "v", "mu", "e", "law", "normal", "slip", "energy", "phases"), HITS)
def test_a_rod_hits_a_rough_floor(space, degrees, v, mu, e, law, normal, slip, energy, phases):
    w = rod(degrees)
    if space:
        w, v = turned(*in_space(w, v), 0.8)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore" if energy > 0 else "error", KaneWarning)
        found = impact(w, v, mu, e, law)
    assert found.phases == phases
    assert found.law is law
    along = found.velocity[1:] @ ([np.cos(0.8), np.sin(0.8)] if space else [1.0])
    np.testing.assert_allclose([found.velocity[0], along, found.energy], [normal, slip, energy], rtol=0, atol=1e-10)
    np.testing.assert_allclose(w @ found.impulse, found.velocity - v, atol=1e-12)


def test_a_gain_of_energy_is_named():
    with pytest.warns(
        KaneWarning, match=r"increases the kinetic energy by 0\.04334, which Newton's law .* Use Law\.STRONGE"
    ):
        impact(rod(60), [-1, 0.75], 0.5, 0.9, Law.NEWTON)


def drawn(rng, d):
    """W, v⁻, μ and e of one contact."""
    a = rng.normal(size=(d, d + int(rng.integers(2))))
    w = a @ a.T
    v = rng.normal(size=d)
    v[0] = -abs(v[0])
    return w + 0.01 * np.trace(w) * np.eye(d), v, rng.uniform(0, 3) * rng.random(), rng.random()


@given(seed=SEEDS, d=st.sampled_from([2, 3]))
def test_energy_never_grows_by_the_energetic_law(seed, d):
    rng = np.random.default_rng(seed)
    for _ in range(3):
        w, v, mu, e = drawn(rng, d)
        found = impact(w, v, mu, e)
        before = v @ np.linalg.solve(w, v) / 2
        after = found.velocity @ np.linalg.solve(w, found.velocity) / 2
        assert found.energy == pytest.approx(after - before, abs=1e-11 * before)
        assert found.energy <= 1e-13 * before
        assert found.velocity[0] >= 0
        assert np.linalg.norm(found.impulse[1:]) <= mu * found.impulse[0] * (1 + 1e-9)


@given(seed=SEEDS, law=st.sampled_from(Law), mass=st.integers(-6, 6), length=st.integers(-6, 6))
def test_units_change_nothing(seed, law, mass, length):
    rng = np.random.default_rng(seed)
    w, v, mu, e = drawn(rng, int(rng.integers(2, 4)))
    m, s = 10.0**mass, 10.0**length
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", KaneWarning)
        one, other = impact(w, v, mu, e, law), impact(w / m, v * s, mu, e, law)
    assert other.phases == one.phases
    np.testing.assert_allclose(other.velocity / s, one.velocity, rtol=0, atol=1e-10 * np.abs(v).max())
    assert other.energy / (m * s * s) == pytest.approx(one.energy, rel=1e-8, abs=1e-10)


@given(seed=SEEDS)
def test_slip_that_turns_beside_a_second_route(seed):
    """An ellipsoid that strikes a floor with its lowest point."""
    rng = np.random.default_rng(seed)
    axes = rng.uniform(0.3, 2, 3)
    inertia = (np.sum(axes**2) - axes**2) / 5
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    n = turn.T @ [0, 0, -1.0]
    x, y, z = turn @ (axes**2 * n / np.linalg.norm(axes * n))
    lever = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    mobility = np.eye(3) - lever @ (turn @ np.diag(1 / inertia) @ turn.T) @ lever
    order = [2, 0, 1]
    w, v = mobility[np.ix_(order, order)], np.array([-rng.uniform(0.2, 2), *rng.normal(size=2)])
    mu, e = rng.uniform(0.05, 1), rng.random()
    np.testing.assert_allclose(impact(w, v, mu, e).velocity, stronge(w, v, mu, e), rtol=0, atol=2e-7)


@pytest.mark.parametrize("law", Law)
def test_an_impact_without_approach(law):
    """A rod that slides into its jam is stopped, and thrown up, at v_n = 0; one that does not jam is not touched."""
    w = rod(60)
    jams = impact(w, [0.0, -1.0], 1.8, 0.5, law)
    assert jams.phases == (ImpactPhase.SLIP, ImpactPhase.STICK)
    assert jams.impulse[0] > 0
    assert jams.velocity[1] == 0
    assert jams.energy < 0
    free = impact(w, [0.0, 1.0], 1.8, 0.5, law)
    np.testing.assert_array_equal(free.velocity, [0.0, 1.0])
    assert not free.impulse.any()


def test_a_wedge_that_can_move_no_other_way_stops():
    """One freedom along (1, 1): friction holds it, and nothing gives the energy back."""
    found = impact([[1.0, 1.0], [1.0, 1.0]], [-1.0, -1.0], 2.0, 0.7)
    np.testing.assert_allclose(found.velocity, [0, 0], atol=1e-15)
    with pytest.raises(ContactError, match="v = J u and W = J M⁻¹ Jᵀ of the same J"):
        impact([[1.0, 1.0], [1.0, 1.0]], [-1.0, 0.0], 2.0, 0.7)


def cradle(n):
    """W of n equal balls in a row, normals between neighbours, and a tangent along which nothing moves."""
    jacobian = np.zeros((2 * n - 2, n))
    for i in range(n - 1):
        jacobian[2 * i, i : i + 2] = -1, 1
    return jacobian, jacobian @ jacobian.T


@pytest.mark.parametrize(("e", "count", "last"), [(1.0, 4, 1.0), (0.9, 10, 0.81450625)])
def test_a_cradle_one_after_the_other(e, count, last):
    jacobian, w = cradle(5)
    u = np.array([1.0, 0, 0, 0, 0])
    found = impacts(w, jacobian @ u, [0.0] * 4, e)
    assert [hit.contact for hit in found.hits][:4] == [0, 1, 2, 3]
    assert (len(found.hits), found.rule, found.law, found.at_once) == (count, Rule.SEQUENTIAL, Law.STRONGE, None)
    u = u + jacobian.T @ found.impulse
    assert u[-1] == pytest.approx(last, abs=1e-12)
    assert found.energy == pytest.approx((u @ u - 1) / 2, abs=1e-14)
    assert found.energy == pytest.approx(sum(hit.impact.energy for hit in found.hits), abs=1e-14)
    if e == 1:
        np.testing.assert_array_equal(u, [0, 0, 0, 0, 1])


@pytest.mark.parametrize("e", [0.0, 0.4, 1.0])
@pytest.mark.parametrize("rule", Rule)
def test_a_pair_of_balls(rule, e):
    jacobian, w = cradle(2)
    found = impacts(w, jacobian @ [1.0, 0.0], [0.0], e, rule=rule)
    np.testing.assert_allclose([1, 0] + jacobian.T @ found.impulse, [(1 - e) / 2, (1 + e) / 2], atol=1e-15)


def test_a_cradle_at_once():
    """By Moreau's rule each gap opens as e says: the first ball rebounds and the others move together."""
    jacobian, w = cradle(3)
    found = impacts(w, jacobian @ [1.0, 0, 0], [0.0, 0.0], 1.0, rule=Rule.SIMULTANEOUS)
    assert (found.rule, found.law, found.hits) == (Rule.SIMULTANEOUS, Law.NEWTON, ())
    np.testing.assert_allclose([1, 0, 0] + jacobian.T @ found.impulse, [-1 / 3, 2 / 3, 2 / 3])
    assert found.energy == pytest.approx(0, abs=1e-14)


def test_a_sequence_without_end_closes_without_restitution():
    """A light ball between two heavy ones that near each other bounces thousands of times; after 400 all close at once."""
    jacobian, _ = cradle(3)
    inverse, u = np.diag([1.0, 1000.0, 1.0]), np.array([1.0, 0, -1])
    found = impacts(jacobian @ inverse @ jacobian.T, jacobian @ u, [0.0, 0.0], 0.5)
    assert len(found.hits) == 400
    assert found.at_once is not None
    assert ContactStatus.OPEN not in found.at_once.modes
    np.testing.assert_allclose(u + inverse @ jacobian.T @ found.impulse, [0, 0, 0], atol=1e-12)
    assert found.energy == pytest.approx(-1.0, abs=1e-12)


@given(seed=SEEDS)
def test_several_impacts_lose_energy_and_end(seed):
    rng = np.random.default_rng(seed)
    d, k = int(rng.integers(2, 4)), int(rng.integers(2, 4))
    n = d * k + int(rng.integers(0, 3))
    jacobian, u = rng.normal(size=(d * k, n)), rng.normal(size=n)
    v = jacobian @ u
    assume((v[::d] < 0).any())
    e = rng.uniform(0, 1, k)
    found = impacts(jacobian @ jacobian.T, v, rng.uniform(0, 1, k), e)
    after = u + jacobian.T @ found.impulse
    np.testing.assert_allclose(jacobian @ after, found.velocity, atol=1e-10 * np.abs(jacobian).sum())
    assert found.energy == pytest.approx((after @ after - u @ u) / 2, abs=1e-10 * (u @ u))
    assert found.energy <= 0
    assert found.velocity[::d].min() > -1e-10 * np.abs(v).max()


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"restitution": 1.2}, "a coefficient of restitution from 0 to 1, got 1.2"),
        ({"restitution": -0.1}, "a coefficient of restitution from 0 to 1"),
        ({"friction": -0.5}, "μ ≥ 0"),
        ({"velocity": [0.1, 0.0]}, "v_n ≤ 0, got 0.1. It needs no impact"),
        ({"velocity": [-1.0, 0, 0, 0]}, "two or three entries"),
        ({"mobility": [[0.0, 0], [0, 1]]}, "W_nn > 0"),
        ({"law": "stronge"}, "Law.NEWTON, POISSON or STRONGE"),
    ],
)
def test_what_is_no_impact(given, message):
    right = {"mobility": np.eye(2), "velocity": [-1.0, 0.3], "friction": 0.2, "restitution": 0.5}
    with pytest.raises(ArgumentError, match=message):
        impact(**{**right, **given})


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (
            {"restitution": [0.5, 0.5]},
            r"coefficients of restitution, one per contact, got an array of the shape \(2,\)",
        ),
        ({"restitution": [1.5]}, "from 0 to 1"),
        ({"law": Law.STRONGE, "rule": Rule.SIMULTANEOUS}, "Law.NEWTON where impacts are simultaneous"),
        ({"rule": "first"}, "Rule.SEQUENTIAL or SIMULTANEOUS"),
    ],
)
def test_what_are_no_impacts(given, message):
    right = {"mobility": np.eye(2), "velocity": [-1.0, 0.3], "friction": [0.2], "restitution": 0.5}
    with pytest.raises(ArgumentError, match=message):
        impacts(**{**right, **given})


def test_contacts_that_leave_take_no_part_until_they_are_thrown_back():
    """A light bar between hands: the end that leaves is not held, and where it comes back it closes in its turn; energy stays."""
    w = np.zeros((4, 4))
    w[::2, ::2] = [[11.0, -9.0], [-9.0, 11.0]]
    w += np.diag([0, 1.0, 0, 1.0])
    for e in (1.0, 0.5):
        hit = impacts(w, [-1.0, 0, 0.4, 0], [0, 0], e, rule=Rule.SIMULTANEOUS)
        v, first = np.array([-1.0, 0.4]), True
        while first or v.min() < -1e-12:
            i = int(np.argmin(v))
            v = v - w[::2, 2 * i] * (1 + e) * v[i] / w[2 * i, 2 * i]
            first = False
        np.testing.assert_allclose(hit.velocity[::2], v, rtol=0, atol=1e-12)
        assert hit.energy <= 1e-14


def test_a_slip_too_small_for_its_square_is_none():
    hit = impact(rod(60), [-1.0, 5e-224], 0.5, 0.9)
    assert hit.phases == impact(rod(60), [-1.0, 0.0], 0.5, 0.9).phases
    np.testing.assert_array_equal(hit.velocity, impact(rod(60), [-1.0, 0.0], 0.5, 0.9).velocity)
