# SPDX-License-Identifier: BSD-3-Clause
"""Contacts: what the velocities of bodies must satisfy, and their poses where they touch.

The relation of velocities at the material contact points of the instant is differentiated as it stands, with
the place of contact wandering over both bodies. The residual of touching is the height of the lowest point;
its derivative is the normal velocity of that material point, as the lowest point wanders level.
"""

from __future__ import annotations

import numpy as np

from tests.oracles.loops.jets import End, Jet
from tests.oracles.loops.joints import Law, Rows, moving


def _rolling(ends: tuple[End, ...], contact: Jet) -> Rows:
    """No slip on the plane of the first mark, whose normal is e3."""
    floor, body = ends
    slip = body.velocity(contact) - floor.velocity(contact)
    height = (contact - floor.point()).dot(floor.axis(3))
    return moving(contact.x, [np.atleast_1d(height.x)], *(slip.along(floor.axis(k)) for k in (3, 1, 2)))


def rolling_sphere(radius: float) -> Law:
    """About the point of the second mark."""
    return lambda ends: _rolling(ends, ends[1].point() - ends[0].axis(3).scaled(radius))


def rolling_wheel(radius: float, rim: float = 0.0) -> Law:
    """A circle about e3 of the second mark, thin or the core of a torus of rim radius `rim`."""

    def law(ends: tuple[End, ...]) -> Rows:
        up, axle = ends[0].axis(3), ends[1].axis(3)
        down = (axle.times(up.dot(axle)) - up).unit()
        return _rolling(ends, ends[1].point() + down.scaled(radius) - up.scaled(rim))

    return law


def knife_edge(ends: tuple[End, ...]) -> Rows:
    """The point of the second mark does not move, against the first body, along e1 of the second mark."""
    floor, body = ends
    place = body.point()
    return moving(place.x, [], (body.velocity(place) - floor.velocity(place)).along(body.axis(1)))


def groove(ends: tuple[End, ...]) -> Rows:
    """The same along e1 of the first mark: a direction of the floor."""
    floor, body = ends
    place = body.point()
    return moving(place.x, [], (body.velocity(place) - floor.velocity(place)).along(floor.axis(1)))


def gears(teeth: tuple[float, float]) -> Law:
    """Among (carrier, one, two): teeth[0] turns of one and teeth[1] of two, seen from the carrier, cancel.

    Each wheel turns about e3 of its own mark. The reaction is a torque; the push of the teeth is not told.
    """

    def law(ends: tuple[End, ...]) -> Rows:
        carrier, one, two = ends
        turns = [
            (wheel.omega() - carrier.omega()).along(wheel.axis(3)).scaled(k)
            for wheel, k in zip((one, two), teeth, strict=True)
        ]
        return moving(two.point().x, [], turns[0] + turns[1])

    return law
