# SPDX-License-Identifier: BSD-3-Clause
"""Masses and inertias that no body can have are named; those at the very edge pass."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane.model import check_inertia, check_mass
from kane.numeric import DECLARED

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
q = kn.coordinate("q")
B = N.rotate("B", q, N.z)
m = kn.parameter("m", 2.0)
bare = kn.parameter("bare")
EDGES = {
    "thin disk": kn.thin_disk(B, 2, 0.3, axis=B.z),
    "ring": kn.ring(B, 2, 0.3, axis=(B.x + 2 * B.y - B.z).normalized()),
    "rod": kn.rod(B, 2, 0.3, axis=(B.x + B.y).normalized()),
    "parameters": kn.thin_disk(B, m, kn.parameter("R", 0.1 + 0.2), axis=B.x),
    "two frames": kn.thin_disk(B, 1, 1, axis=B.x) + kn.rod(N, 1, 1, axis=N.x),
    "nothing": kn.Dyadic(),
}


@pytest.mark.parametrize("name", EDGES)
def test_a_thin_disk_meets_the_inequality_with_equality(name):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_inertia("b", EDGES[name])


@pytest.mark.parametrize("share", [1 - 1e-3, 1 - 1e-10, 1 + 1e-10, 1 + 1e-8, 1 + 1e-3])
def test_slack_of_the_inequality(share):
    dyadic = kn.inertia(B, 0.1, 0.2, 0.3 * share)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        check_inertia("b", dyadic)
    assert len(caught) == (share > 1 + DECLARED)


@given(points=st.lists(st.tuples(*[st.floats(-2, 2)] * 3, st.floats(0.1, 3)), min_size=1, max_size=6))
def test_every_cloud_of_particles_passes(points):
    """∫ (r² 1 − r r) dm of any positive masses is an inertia, flat and straight ones included."""
    r, mass = np.array([p[:3] for p in points]), np.array([p[3] for p in points])
    matrix = np.einsum("k,ki,ki", mass, r, r) * np.eye(3) - np.einsum("k,ki,kj->ij", mass, r, r)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_inertia("cloud", kn.Dyadic.of(B, matrix))


@pytest.mark.parametrize(
    ("dyadic", "message"),
    [
        (kn.Dyadic.of(B, [[3, 0.1, 0], [0, 3, 0], [0, 0, 3]]), "symmetric inertia for b, got Ixy = 0.1 and Iyx = 0 along"),
        (kn.Dyadic.of(B, [[3, 0, 0.2], [0, 3, 0], [0.1, 0, 3]]), "got Izx = 0.1 and Ixz = 0.2"),
        (kn.inertia(B, -1, 1, 1), "principal moments of inertia ≥ 0 for b, got -1, 1, 1"),
        (kn.inertia(B, 1, 1, 1, Ixy=2), "≥ 0 for b, got -1, 1, 3"),
        (kn.inertia(B, m, m, -m), "got -2, 2, 2"),
    ],
)  # fmt: skip
def test_inertias_that_no_body_has(dyadic, message):
    with pytest.raises(kn.ModelError, match=message):
        kn.RigidBody("b", frame=B, mass_center=O, mass=1, inertia=dyadic)


def test_the_warning_stands_at_the_users_line():
    with pytest.warns(kn.KaneWarning, match=r"inertia for b .*got 1, 1, 3.*Ixx \+ Iyy ≥ Izz") as caught:
        kn.RigidBody("b", frame=B, mass_center=O, mass=1, inertia=kn.inertia(B, 1, 1, 3))
    assert caught[0].filename == __file__


@pytest.mark.parametrize("dyadic", [kn.inertia(B, bare, 1, 9), kn.inertia(B, 1, 1, 3 + q)])
def test_nothing_is_said_where_nothing_is_known(dyadic):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_inertia("b", dyadic)


def test_masses():
    for mass in (kn.parameter("m", 0.0), bare, m - 2 * bare, m - 1, kn.Expr.__add__(m, 0)):
        check_mass("b", mass)
    for mass, said in (
        (kn.parameter("m", -0.5), "m = -0.5"),
        (1 - m, r"-m \+ 1 = -1|1 - m = -1"),
        (0 * m - 3, "got -3"),
    ):
        with pytest.raises(kn.ModelError, match=f"mass ≥ 0 for b, got .*({said})|{said}"):
            check_mass("b", mass)


@given(st.lists(st.sampled_from("xyz"), min_size=1, max_size=4), st.booleans())
def test_one_moment_alone_is_that_of_a_body_in_a_plane(turns, about_first):
    """Without a word where it turns about that axis alone, through any number of frames; one warning for all that turn otherwise."""
    root = kn.Frame("R")
    origin = kn.Point("R0", fixed_in=root)
    frame, bodies = root, []
    angles = kn.coordinates(f"a1:{len(turns) + 1}")
    for k, (angle, axis) in enumerate(zip(angles, turns, strict=True)):
        frame = frame.rotate(f"F{k}", angle, getattr(frame, turns[0] if about_first else axis))
        moments = [0.2 if x == turns[0] else 0 for x in "xyz"]
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            body = kn.RigidBody(f"b{k}", frame=frame, mass_center=origin, mass=1, inertia=kn.inertia(frame, *moments))
        bodies.append(body)
    planar = about_first or len(set(turns)) == 1
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        kn.System(
            root,
            bodies=bodies,
            speeds={u: a.dt for u, a in zip(kn.speeds(f"w1:{len(turns) + 1}"), angles, strict=True)},
        )
    assert [str(w.message)[:40] for w in said] == ["Expected moments of inertia about all ax"] * (not planar)
