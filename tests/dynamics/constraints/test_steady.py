# SPDX-License-Identifier: BSD-3-Clause
"""Dependent speeds that are chosen follow everywhere, where any do, and their equations are as short as those named by hand."""

from __future__ import annotations

import warnings
from itertools import combinations

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

import kane as kn
from kane.dynamics import steadiest
from tests.examples import examples
from tests.systems.wheels import disk, free_disk, named, segway, vehicle

EPS = np.finfo(float).eps


def names(eom):
    return {u.name for u in eom.dependent_speeds}


@pytest.mark.parametrize(
    ("system", "by_hand"),
    [
        (disk, ["v_x", "v_y"]),
        (free_disk, ["v_x_wheel", "v_y_wheel", "v_z_wheel"]),
        (segway, ["s", "w1", "w2"]),
    ],
)
def test_what_is_chosen_is_as_short_as_by_hand(system, by_hand):
    chosen, hand = kn.derive(system()), kn.derive(system(by_hand))
    assert names(chosen) == set(by_hand)
    assert chosen.operations == hand.operations


def determinants(eom, rng):
    """√det(A_Dᵀ A_D) of every set of as many speeds as are dependent, by their names, at random configurations."""
    count, rank = 12, len(eom.dependent_speeds)
    values = {p: p.default for p in eom.parameters} | {q: rng.uniform(-3, 3, count) for q in eom.coordinates}
    a = [np.broadcast_to(x, count) for x in kn.evaluate(list(eom.A.entries), values)]
    a = np.stack(a, axis=-1).reshape(count, *eom.A.shape)
    for places in combinations(range(a.shape[2]), rank):
        yield {eom.speeds[k].name for k in places}, np.linalg.svd(a[:, :, places], compute_uv=False).prod(axis=-1)


@given(seed=st.integers(0, 10**6))
@example(56424)  # every exchange of one speed makes the determinant vary more
@example(230667)  # a shorter set is nearly singular everywhere
@examples(0.2, 4)
def test_vehicles_have_a_constant_determinant_where_any_has(seed):
    rng = np.random.default_rng(seed)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", kn.KaneWarning)  # blades may hold more than the plane leaves open
        eom = kn.derive(vehicle(rng))
    found = list(determinants(eom, rng))
    steady = [s for s, x in found if np.ptp(x) < 1e4 * EPS * x.max() and x.min() > 1e-3]
    assert not steady or names(eom) in steady


@given(seed=st.integers(0, 10**6), shape=st.sampled_from([(2, 4), (3, 6), (3, 7), (4, 8), (5, 9), (6, 12)]))
def test_the_one_set_that_follows_everywhere_is_found_from_any(seed, shape):
    """All columns are random but those of one set, which are those of rotations: exchanges seldom lead there one by one."""
    rng = np.random.default_rng(seed)
    rank, count = shape
    a = rng.normal(size=(13, rank, count))
    steady, start = (tuple(sorted(rng.permutation(count)[:rank].tolist())) for _ in range(2))
    a[:, :, steady] = np.linalg.qr(a[:, :, steady])[0]
    kept = [u for u in steady if u in start][:1]
    # units of rows and of speeds
    a *= np.exp(rng.normal(size=(rank, 1))) * np.exp(rng.normal(size=count))
    assert steadiest(a, start, kept, lambda _: 0.0) == steady
    assert steadiest(np.concatenate([a, a[:, :1]], axis=1), start, kept, lambda _: 0.0) == steady
    gone = [u for u in start if u not in steady][:1]
    assert not gone or steadiest(a, start, gone, lambda _: 0.0) is None


def test_a_shorter_set_that_is_nearly_singular_everywhere_is_not_taken():
    c, s = np.cos(np.linspace(0, 3, 13)), np.sin(np.linspace(0, 3, 13))
    a = np.array([[c, -s, c - 1e-3 * s], [s, c, s + 1e-3 * c]]).transpose(2, 0, 1)
    assert steadiest(a, (0, 2), (), lambda d: float(sum(d) != 2)) in {(0, 1), (1, 2)}
    assert steadiest(a, (0, 2), (0, 2), lambda _: 0.0) == (0, 2)


def test_what_is_named_stays():
    assert names(kn.derive(segway(["turn"]))) >= {"turn"}
    assert names(kn.derive(disk(["w2"]))) >= {"w2"}


def test_a_block_that_turns_with_time_is_not_constant():
    """A blade on a turntable of given angle, which lifts as it slips: only the speed upwards follows at all times."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, y, z = kn.coordinates("x y z")
    T = N.rotate("T", kn.parameter("Omega", 0.7) * kn.time, N.z)
    C = O.at("C", x * N.x + y * N.y + z * N.z)
    a, b, c = kn.speeds("a b c")
    v = C.velocity(N)
    slips = kn.motion_constraint("lifts", v.dot(T.y) + v.dot(N.z))
    speeds = {a: x.dt, b: y.dt, c: z.dt + y.dt}
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("p", C, 1.0)], speeds=speeds, nonholonomic=[slips]))
    assert names(eom) == {"c"}


def test_named_systems_are_left_alone():
    eom = kn.derive(named(segway(), ["v", "s", "turn"]))
    assert names(eom) == {"v", "s", "turn"}
