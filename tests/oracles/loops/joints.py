# SPDX-License-Identifier: BSD-3-Clause
"""Joints: what the poses of two bodies must satisfy, from a mark on each.

d is the way from the first mark to the second, e1, e2, e3 are a mark's axes. A joint with an axis has it along
e3. Orientation is held by products of axes, which also vanish half a turn away; a guess decides.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tests.oracles.loops.jets import Drive, End, Flow, Jet
from tests.oracles.loops.records import Ground, Mark, still
from tests.oracles.tree import Array


@dataclass(frozen=True, slots=True)
class Rows:
    """Residuals c of the poses, rows J on twists, of which the first len(c) are the derivative of c.

    rate = J nu + (what is prescribed) must vanish, and so must its derivative J nu' + bias.
    """

    c: Array
    J: Array
    rate: Array
    bias: Array
    point: Array  # about which the torque of the reaction is told


Law = Callable[[tuple[End, ...]], Rows]


@dataclass(frozen=True, slots=True)
class Joint:
    """A law between marks on bodies, -1 for the inertial frame or what `ground` carries.

    The reaction told is that on the last of the bodies.
    """

    bodies: tuple[int, ...]
    marks: tuple[Mark, ...]
    law: Law
    ground: Ground = still


def held(point: Array, *residuals: Jet) -> Rows:
    return moving(point, [np.atleast_1d(jet.x) for jet in residuals], *(jet.flow() for jet in residuals))


def moving(point: Array, c: list[Array], *flows: Flow) -> Rows:
    width = flows[0].J.shape[-1]
    return Rows(
        np.concatenate([*c, np.zeros(0)]),
        np.concatenate([flow.J.reshape(-1, width) for flow in flows]),
        np.concatenate([np.atleast_1d(flow.value) for flow in flows]),
        np.concatenate([np.atleast_1d(flow.bias) for flow in flows]),
        point,
    )


def _gap(ends: tuple[End, ...]) -> Jet:
    one, two = ends
    return two.point() - one.point()


def _aligned(ends: tuple[End, ...]) -> tuple[Jet, Jet]:
    """e3 of both parallel."""
    one, two = ends
    e3 = two.axis(3)
    return e3.dot(one.axis(1)), e3.dot(one.axis(2))


def _on_axis(ends: tuple[End, ...]) -> tuple[Jet, Jet]:
    d, one = _gap(ends), ends[0]
    return d.dot(one.axis(1)), d.dot(one.axis(2))


def _oriented(ends: tuple[End, ...]) -> tuple[Jet, Jet, Jet]:
    one, two = ends
    return *_aligned(ends), two.axis(1).dot(one.axis(2))


def _sine_behind(ends: tuple[End, ...], angle: Jet) -> Jet:
    """Sine of the turn about e3 less `angle`; a residual without branches."""
    one, two = ends
    e1 = two.axis(1)
    return e1.dot(one.axis(2)).times(angle.cosine()) - e1.dot(one.axis(1)).times(angle.sine())


def _held(residuals: Callable[[tuple[End, ...]], tuple[Jet, ...]]) -> Law:
    return lambda ends: held(ends[-1].point().x, *residuals(ends))


ball = _held(lambda ends: (_gap(ends),))
pin = _held(lambda ends: (_gap(ends), *_aligned(ends)))
weld = _held(lambda ends: (_gap(ends), *_oriented(ends)))
slider = _held(lambda ends: (*_on_axis(ends), *_oriented(ends)))
cylindrical = _held(lambda ends: (*_on_axis(ends), *_aligned(ends)))
planar = _held(lambda ends: (_gap(ends).dot(ends[0].axis(3)), *_aligned(ends)))
# the cross has one arm along e3 of the first mark, the other along e1 of the second
universal = _held(lambda ends: (_gap(ends), ends[0].axis(3).dot(ends[1].axis(1))))
point_on_line = _held(_on_axis)
point_on_plane = _held(lambda ends: (_gap(ends).dot(ends[0].axis(3)),))


def screw(pitch: float) -> Law:
    """Advances by `pitch` along e3 for each radian."""

    def residuals(ends: tuple[End, ...]) -> tuple[Jet, ...]:
        turn = _gap(ends).dot(ends[0].axis(3)).scaled(1.0 / pitch)
        return *_on_axis(ends), *_aligned(ends), _sine_behind(ends, turn).scaled(pitch)

    return _held(residuals)


def distance(length: Drive) -> Law:
    """A massless rod between the two points; its multiplier is the push."""
    return _held(lambda ends: (_gap(ends).norm() - ends[0].given(length),))


def turn(angle: Drive) -> Law:
    """One row: the turn about e3 of a pin that is there as well; its multiplier is the driving torque."""
    return _held(lambda ends: (_sine_behind(ends, ends[0].given(angle)),))


def slide(way: Drive) -> Law:
    """One row: the way along e3 of a slider that is there as well."""
    return _held(lambda ends: (_gap(ends).dot(ends[0].axis(3)) - ends[0].given(way),))
