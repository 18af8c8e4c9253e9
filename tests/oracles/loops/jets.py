# SPDX-License-Identifier: BSD-3-Clause
"""Quantities with their exact derivatives along the motion, as rows on the twists nu of the bodies in a joint.

A `Jet` depends on poses and time: rate = J nu + (what is prescribed), second derivative = J nu' + bias. A
`Flow` is of the level of velocities: derivative = J nu' + bias. Points, axes and velocities of a body are
written down from v and w; everything else follows by the product rule.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tests.oracles.loops.records import Carried, Mark, cross
from tests.oracles.tree import Array, skew


@dataclass(frozen=True, slots=True)
class Flow:
    """A velocity or angular velocity, or a component of one."""

    value: Array
    J: Array
    bias: Array

    def __add__(self, other: Flow) -> Flow:
        return Flow(self.value + other.value, self.J + other.J, self.bias + other.bias)

    def __sub__(self, other: Flow) -> Flow:
        return self + other.scaled(-1.0)

    def scaled(self, k: float) -> Flow:
        return Flow(k * self.value, k * self.J, k * self.bias)

    def along(self, e: Jet) -> Flow:
        """Component along a direction that moves."""
        return Flow(self.value @ e.x, e.x @ self.J, self.bias @ e.x + self.value @ e.rate)


@dataclass(frozen=True, slots=True)
class Jet:
    """A vector, or a scalar with J as one row."""

    x: Array
    J: Array
    rate: Array
    bias: Array

    def __add__(self, other: Jet) -> Jet:
        return Jet(self.x + other.x, self.J + other.J, self.rate + other.rate, self.bias + other.bias)

    def __sub__(self, other: Jet) -> Jet:
        return self + other.scaled(-1.0)

    def scaled(self, k: float) -> Jet:
        return Jet(k * self.x, k * self.J, k * self.rate, k * self.bias)

    def dot(self, other: Jet) -> Jet:
        return Jet(
            self.x @ other.x,
            other.x @ self.J + self.x @ other.J,
            self.rate @ other.x + self.x @ other.rate,
            self.bias @ other.x + self.x @ other.bias + 2.0 * self.rate @ other.rate,
        )

    def times(self, s: Jet) -> Jet:
        """Product with a scalar."""
        return Jet(
            s.x * self.x,
            np.multiply.outer(self.x, s.J) + s.x * self.J,
            s.rate * self.x + s.x * self.rate,
            s.bias * self.x + s.x * self.bias + 2.0 * s.rate * self.rate,
        )

    def through(self, f: float, first: float, second: float) -> Jet:
        """A function of a scalar, of which value and derivatives are given."""
        return Jet(np.float64(f), first * self.J, first * self.rate, first * self.bias + second * self.rate**2)

    def norm(self) -> Jet:
        square = self.dot(self)
        root = float(np.sqrt(square.x))
        return square.through(root, 0.5 / root, -0.25 / root**3)

    def unit(self) -> Jet:
        size = self.norm()
        f = 1.0 / float(size.x)
        return self.times(size.through(f, -(f**2), 2.0 * f**3))

    def sine(self) -> Jet:
        s, c = float(np.sin(self.x)), float(np.cos(self.x))
        return self.through(s, c, -s)

    def cosine(self) -> Jet:
        s, c = float(np.sin(self.x)), float(np.cos(self.x))
        return self.through(c, -s, -c)

    def flow(self) -> Flow:
        """Its derivative."""
        return Flow(self.rate, self.J, self.bias)


Drive = Callable[[float], tuple[float, float, float]]  # a function of time and its two derivatives


def constant(value: float) -> Drive:
    return lambda t: (value, 0.0, 0.0)


_NONE, _ALL = np.zeros((3, 3)), np.eye(3)


@dataclass(frozen=True, slots=True)
class End:
    """A mark on one of the bodies of a joint, in motion; `slot` says where among `slots` its twist stands."""

    mark: Mark
    motion: Carried  # a and alpha are what of the accelerations is prescribed, nothing for a free body
    slot: int
    slots: int
    t: float

    def _columns(self, linear: Array, angular: Array) -> Array:
        J = np.zeros((3, 6 * self.slots))
        J[:, 6 * self.slot : 6 * self.slot + 3] = linear
        J[:, 6 * self.slot + 3 : 6 * self.slot + 6] = angular
        return J

    def _fixed(self, arm: Array) -> Jet:
        w = self.motion.twist.w
        rate = cross(w, arm)
        J = self._columns(_NONE, -skew(arm))
        return Jet(arm, J, rate, cross(w, rate) + cross(self.motion.alpha, arm))

    def point(self) -> Jet:
        m, arm = self.motion, self._fixed(self.motion.pose.R @ self.mark.point)
        J = arm.J + self._columns(_ALL, _NONE)
        return Jet(m.pose.r + arm.x, J, m.twist.v + arm.rate, m.a + arm.bias)

    def axis(self, k: int) -> Jet:
        """e1, e2 or e3 by its number."""
        return self._fixed(self.motion.pose.R @ self.mark.axes[:, k - 1])

    def omega(self) -> Flow:
        return Flow(self.motion.twist.w, self._columns(_NONE, _ALL), self.motion.alpha)

    def velocity(self, p: Jet) -> Flow:
        """Of the material point of the body at the place p, which may wander over the body."""
        m = self.motion
        arm, w = p.x - m.pose.r, m.twist.w
        bias = m.a + cross(m.alpha, arm) + cross(w, p.rate - m.twist.v)
        return Flow(m.twist.v + cross(w, arm), self._columns(_ALL, -skew(arm)), bias)

    def given(self, drive: Drive) -> Jet:
        """A scalar prescribed in time."""
        f, first, second = drive(self.t)
        return Jet(np.float64(f), np.zeros(6 * self.slots), np.float64(first), np.float64(second))
