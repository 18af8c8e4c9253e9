# SPDX-License-Identifier: BSD-3-Clause
"""Dependent speeds that are chosen follow everywhere, where any do, and their equations are as short as those named by hand."""

from __future__ import annotations

import warnings
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
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
@examples(0.2, 4)
def test_vehicles_have_a_constant_determinant_where_any_has(seed):
    rng = np.random.default_rng(seed)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", kn.KaneWarning)  # blades may hold more than the plane leaves open
        eom = kn.derive(vehicle(rng))
    found = list(determinants(eom, rng))
    steady = [s for s, x in found if np.ptp(x) < 1e4 * EPS * x.max() and x.min() > 1e-3]
    assert not steady or names(eom) in steady


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
