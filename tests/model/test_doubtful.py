# SPDX-License-Identifier: BSD-3-Clause
"""Models that are surely not meant are warned of; sound ones pass without a word."""

from __future__ import annotations

import warnings
from typing import Any

import pytest

import kane as kn
from kane.gallery import GALLERY, load

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
q1, q2, q3, x, y = kn.coordinates("q1 q2 q3 x y")
R, g = kn.parameter("R", 0.3), kn.parameter("g")
Y = N.rotate("Y", q1, N.z)
B = Y.rotate("B", q2, Y.x)
C = B.rotate("C", q3, B.y)
P = O.at("P", x * N.x + y * N.y)
CENTER = P.at("C*", R * B.z)
DISK = kn.RigidBody("disk", frame=C, mass_center=CENTER, mass=2, inertia=kn.thin_disk(C, 2, R, axis=C.y))


def said(
    point: kn.Point | None, normal: kn.Vector = N.z, gravity: Any = None, bodies: Any = (DISK,), held: Any = ()
) -> list[str]:
    held = kn.rolling(point, normal=normal) if point is not None else held
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        kn.System(N, bodies=bodies, speeds="rates", nonholonomic=held, loads=[kn.gravity(gravity or -g * N.z)])
    return [str(w.message) for w in caught]


RIGHT = {
    "below the centre": CENTER.fixed_in(C, "D", -R * B.z),
    "of a frame fixed in the wheel": CENTER.fixed_in(C.rotate("C'", 0.3, C.x), "D", -R * B.z),
}


@pytest.mark.parametrize("name", RIGHT)
def test_a_particle_of_the_wheel(name):
    assert said(RIGHT[name]) == []


@pytest.mark.parametrize(
    ("point", "message"),
    [
        (
            CENTER.fixed_in(B, "D", -R * B.z),
            "the particle of 'disk' .*got D, a particle of B, which does not.*C\\*.fixed_in.C",
        ),
        (P.fixed_in(Y, "D"), "got D, a particle of Y"),
        (CENTER.at("D", -R * B.z), "got D, a geometric point"),
        (P, "got P, a geometric point.*O.fixed_in"),
        (
            P.fixed_in(C, "D"),
            "D placed from a point that moves with 'disk', got P, which does not.*such as C.: C..fixed_in.C, ",
        ),
        (CENTER.fixed_in(C, "D", R * B.z), "got D beyond its mass centre. Change the sign"),
    ],
)
def test_another_frame_or_side(point, message):
    (told,) = said(point)
    with pytest.raises(kn.KaneWarning, match=message):
        raise kn.KaneWarning(told)


@pytest.mark.parametrize(
    ("point", "along", "message"),
    [
        (
            CENTER.fixed_in(B, "D", -R * B.z),
            Y.x,
            "particle of 'disk' that touches the ground in 'edge', got D, a particle of B.*fixed_in.C",
        ),
        (CENTER.fixed_in(N, "D", -R * N.z), Y.x, "got D, a particle of N, which does not turn with it"),
        (CENTER.at("D", -R * B.z), N.x, "got D, a geometric point"),
        (CENTER.fixed_in(C, "D", -R * B.z), Y.x, ""),
        (CENTER.fixed_in(C, "D", R * B.z), Y.x, ""),  # a ceiling
        (CENTER.at("D", -R * B.z), Y.y, ""),  # across the heading the trace moves as the particle there
        (CENTER, Y.x, ""),
        (P, Y.y, ""),
    ],
)
def test_an_edge_is_a_particle_of_the_wheel(point, along, message):
    told = said(None, held=kn.no_slip(point, along=along, name="edge"))
    assert bool(told) == bool(message)
    if message:
        with pytest.raises(kn.KaneWarning, match=message):
            raise kn.KaneWarning(*told)


def test_a_plate_is_met_by_its_own_particle():
    plate = N.rotate("plate", q3, N.z)
    S = N.rotate_body("S", kn.coordinates("a b c"), "xyz")
    G = O.at("G", x * N.x + y * N.y + R * N.z)
    ball = kn.RigidBody("ball", frame=S, mass_center=G, mass=1, inertia=kn.solid_sphere(S, 1, R))
    disk = kn.RigidBody("plate", frame=plate, mass_center=O, mass=1, inertia=kn.thin_disk(plate, 1, R, plate.z))
    met = G.fixed_in(S, "S^", -R * N.z)
    right = kn.rolling(met, O.fixed_in(plate, "T^", x * N.x + y * N.y), normal=N.z)
    wrong = kn.rolling(met, G.fixed_in(plate, "T^", -R * N.z), normal=N.z)
    assert said(None, bodies=[ball, disk], held=right) == []
    (told,) = said(None, bodies=[ball, disk], held=wrong)
    assert "Expected T^ placed from a point that moves with 'plate', got G, which does not" in told
    assert "such as O: O.fixed_in(plate, …)" in told


def test_a_blade_on_a_frame_without_mass():
    blade, wheel = N.rotate("blade", q1, N.z), N.rotate("rotor", q2, N.z)
    G = O.at("G", x * N.x + y * N.y)
    rotor = kn.RigidBody("rotor", frame=wheel, mass_center=G, mass=1, inertia=kn.thin_disk(wheel, 1, R, wheel.z))
    held = kn.no_slip(G.at("edge", -R * blade.x), along=blade.y)
    assert said(None, bodies=[rotor], held=held) == []


def test_the_normal_to_the_other_side():
    (told,) = said(CENTER.fixed_in(C, "D", -R * B.z), normal=-N.z)
    assert "beyond its mass centre" in told


@pytest.mark.parametrize("along", [B.z, C.x, Y.x, (N.z + C.z)])
def test_gravity_that_turns(along):
    (told,) = said(None, gravity=-g * along)
    assert "along a fixed direction" in told
    assert "Write it along N" in told


@pytest.mark.parametrize(
    "along", [N.z, Y.z, N.rotate("slope", 0.3, N.y).z, B.z.dot(N.z) * N.z - (B.z.dot(N.z) - 1) * N.z]
)
def test_gravity_that_stays(along):
    assert said(None, gravity=-g * along) == []
    assert said(None, gravity=-g * kn.sin(kn.time) * along) == []


@pytest.mark.parametrize("name", GALLERY)
def test_the_gallery_is_sound(name):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        load(name).system()


@pytest.mark.parametrize("above", [False, True])
def test_a_corner_may_be_above_the_mass_centre_where_it_does_not_touch(above):
    """It turns with its body: on which side of the floor it is, the attitude says."""
    turn, level, height = kn.coordinates("turn level height")
    T = N.rotate("T", turn, N.z)
    G = O.at("G", level * N.x + height * N.y)
    corner = G.fixed_in(T, "corner", (1 if above else -1) * (T.x + T.y))
    body = kn.RigidBody("plate", frame=T, mass_center=G, mass=1, inertia=kn.inertia(T, 1, 1, 1))
    place = kn.joints.point_on_plane("floor", corner, O, normal=N.y)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        kn.System(N, bodies=[body], speeds="rates", holonomic=place.height, nonholonomic=place.rolling)
