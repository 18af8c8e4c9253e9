# SPDX-License-Identifier: BSD-3-Clause
"""Velocities, partial velocities and accelerations in speeds, against those in rates and against added coordinates."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from tests.paths import Path

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
q = kn.coordinates("q1:7")
u = kn.speeds("u1:7")


def array(values):
    return np.array([np.asarray(v, dtype=float) for v in values])


class Arm:
    """A mechanism with every kind of step: coaxial and skew rotations, slides, prescribed motion, a particle.

    With `slide` and `turn` (expressions) it is moved further at the places where reactions may cut it.
    """

    def __init__(self, slide=0, turn=0, along="x", about="y", middle=False):
        self.A = N.rotate("A", q[0], N.z)
        self.M = self.A.rotate("M", kn.sin(kn.time) + q[1], self.A.z)
        cut = self._turned(self.M, turn, about) if middle else self.M
        self.B = cut.rotate("B", q[2], cut.z)
        far = self.B if middle else self._turned(self.B, turn, about)
        self.C = far.rotate("C", q[3], (far.x + 2 * far.y - 2 * far.z) / 3)
        direction = {"x": N.x, "A": self.A.y, "skew": (N.x + 2 * N.y + 2 * N.z) / 3}[along]
        self.P = O.at("P", q[4] * self.A.x + kn.time**2 * N.z)
        moved = self.P if not isinstance(slide, kn.Expr) else self.P.at("P'", slide * direction)
        self.direction = direction
        self.G = moved.at("G", (1 + q[5]) * far.y + 0.5 * far.z)
        self.T = self.G.at("T", 0.7 * self.C.x)
        self.X = self.G.fixed_in(self.C, "X", q[4] * N.x + self.C.z)
        self.far = far
        bodies = [
            kn.RigidBody("a", frame=self.A, mass_center=O, mass=1, inertia=kn.inertia(self.A, 1, 1, 2)),
            kn.RigidBody("m", frame=cut, mass_center=O, mass=1, inertia=kn.inertia(cut, 1, 2, 3)),
            kn.RigidBody("b", frame=far, mass_center=self.G, mass=2, inertia=kn.inertia(far, 1, 2, 3)),
            kn.RigidBody("c", frame=self.C, mass_center=self.T, mass=1, inertia=kn.inertia(self.C, 0.1, 0.2, 0.3)),
            kn.Particle("p", self.P, 0.5),
        ]
        self.bodies = bodies
        self.loads = [kn.Force(self.X, N.x + N.y)]
        self.places = (self.P, self.G, self.T, self.X)
        self.frames = (self.A, self.M, self.B, self.C)

    @staticmethod
    def _turned(frame, turn, about):
        return frame if not isinstance(turn, kn.Expr) else frame.rotate(frame.name + "'", turn, getattr(frame, about))


def choices(arm):
    w, v = arm.C.angular_velocity(N), arm.G.velocity(N)
    return {
        "rates": [x.dt for x in q],
        "components": [w.dot(arm.C.x), w.dot(arm.C.y), q[2].dt, q[1].dt, v.dot(arm.B.x), v.dot(arm.B.y)],
        "shifted": [q[0].dt + 2, q[1].dt + kn.cos(kn.time), q[2].dt + q[0].dt, q[3].dt - q[4], q[5].dt, q[4].dt * 2],
    }


def system_of(arm, name, **more):
    return kn.System(
        N, bodies=arm.bodies, loads=arm.loads, speeds=dict(zip(u, choices(arm)[name], strict=True)), **more
    )


STATE = Path(q, 51, t0=0.35)
SPEEDS = np.random.default_rng(2).normal(size=6)
RATES = np.random.default_rng(3).normal(size=6)


def at_state(eom, exprs, speeds=SPEEDS, u_dots=RATES):
    """Numbers at a state with u̇ chosen freely: q̇ from W u + X, nothing solved for."""
    values = {kn.time: 0.35, **dict(zip(q, STATE.q, strict=True)), **dict(zip(u, speeds, strict=True))}
    values.update({s.dt: r for s, r in zip(u, u_dots, strict=True)})
    return array(kn.evaluate([eom.in_speeds(e) for e in exprs], values))


@pytest.fixture(scope="module", params=["rates", "components", "shifted"])
def case(request):
    arm = Arm()
    return arm, kn.derive(system_of(arm, request.param))


def test_velocities_are_those_in_rates(case):
    arm, eom = case
    for p in arm.places:
        assert at_state(eom, eom.velocities[p].components(N)) == pytest.approx(
            at_state(eom, p.velocity(N).components(N))
        )
    for f in arm.frames:
        expected = at_state(eom, f.angular_velocity(N).components(N))
        assert at_state(eom, eom.angular_velocities[f].components(N)) == pytest.approx(expected, abs=1e-12)


@pytest.mark.slow
def test_accelerations_are_those_in_rates(case):
    """Σ v_r u̇_r + bias at u̇ drawn at random is the derivative in rates, with q̈ from q̇ = W u + X."""
    arm, eom = case
    for p in arm.places:
        expected = at_state(eom, p.acceleration(N).components(N))
        assert at_state(eom, eom.point_accelerations[p].components(N)) == pytest.approx(expected, abs=1e-10)
    for f in arm.frames:
        expected = at_state(eom, f.angular_acceleration(N).components(N))
        assert at_state(eom, eom.angular_accelerations[f].components(N)) == pytest.approx(expected, abs=1e-10)


def test_partial_velocities_are_the_slopes(case):
    """A velocity is linear in u: its change with one speed is the partial velocity, for accelerations with one u̇."""
    arm, eom = case
    units = np.eye(6)
    for table, partials, places in (
        (eom.velocities, eom.partial_velocities, arm.places),
        (eom.angular_velocities, eom.partial_angular_velocities, arm.frames),
    ):
        for place in places:
            v = table[place].components(N)
            start = at_state(eom, v, np.zeros(6))
            for r, s in enumerate(u):
                slope = at_state(eom, v, units[r]) - start
                assert at_state(eom, partials[place][s].components(N)) == pytest.approx(slope, abs=1e-12)
    a = eom.point_accelerations[arm.T].components(N)
    start = at_state(eom, a, u_dots=np.zeros(6))
    for r, s in enumerate(u):
        slope = at_state(eom, a, u_dots=units[r]) - start
        assert at_state(eom, eom.partial_velocities[arm.T][s].components(N)) == pytest.approx(slope, abs=1e-11)


def test_reading_order_does_not_matter():
    """Partials read in any order, from equations derived in any order, are the same objects."""
    arm = Arm()
    first, second = kn.derive(system_of(arm, "components")), kn.derive(system_of(arm, "components"))
    for p in reversed(arm.places):
        _ = second.partial_velocities[p][u[3]]
    for p in arm.places:
        for s in u:
            one, two = first.partial_velocities[p][s], second.partial_velocities[p][s]
            assert all(x is y for x, y in zip(one.components(N), two.components(N), strict=True))


class TestAuxiliarySpeeds:
    """Partial velocities for an auxiliary speed are those for a coordinate added at the cut, at its value zero."""

    s, us = kn.coordinate("s"), kn.speed("us")

    def added(self, name, **options):
        moved = Arm(**options)
        # the speeds' definitions know nothing of the added coordinate, as they know nothing of auxiliary speeds
        definitions = dict(zip(u, choices(Arm())[name], strict=True)) | {self.us: self.s.dt}
        eom = kn.derive(kn.System(N, bodies=moved.bodies, loads=moved.loads, speeds=definitions))
        return moved, eom

    def numbers(self, eom, exprs):
        values = {kn.time: 0.35, self.s: 0.0, self.us: 0.0} | dict(zip(q, STATE.q, strict=True))
        return array(kn.evaluate([eom.in_speeds(e) for e in exprs], values | dict(zip(u, SPEEDS, strict=True))))

    def check(self, name, reaction, arm, options):
        eom = kn.derive(system_of(arm, name, reactions=[reaction]))
        (ua,) = eom.auxiliary_speeds
        moved, more = self.added(name, **options)
        for place, other in zip(arm.places, moved.places, strict=True):
            expected = self.numbers(more, more.partial_velocities[other][self.us].components(N))
            if place is arm.P:
                expected = self.numbers(more, arm.direction.components(N)) if reaction.place.at is arm.P else expected
            found = self.numbers(eom, eom.partial_velocities[place][ua].components(N))
            assert found == pytest.approx(expected, abs=1e-12), place
        for frame, other in zip(arm.frames, moved.frames, strict=True):
            if frame is reaction.place.at:
                continue
            expected = self.numbers(more, more.partial_angular_velocities[other][self.us].components(N))
            found = self.numbers(eom, eom.partial_angular_velocities[frame][ua].components(N))
            assert found == pytest.approx(expected, abs=1e-12), frame

    @pytest.mark.parametrize("along", ["x", "skew"])
    def test_at_a_point(self, along):
        arm = Arm(along=along)
        with pytest.raises(kn.ReactionError, match="moves freely"):
            kn.derive(system_of(arm, "rates", reactions=[kn.reaction("R", at=arm.P, along=arm.direction)]))
        cut = Arm(along=along)
        cut.P = cut.P.at("pin", 0)
        cut.direction = arm.direction
        cut.G = cut.P.at("G", (1 + q[5]) * cut.B.y + 0.5 * cut.B.z)
        cut.T = cut.G.at("T", 0.7 * cut.C.x)
        cut.X = cut.G.fixed_in(cut.C, "X", q[4] * N.x + cut.C.z)
        cut.places = (cut.P, cut.G, cut.T, cut.X)
        cut.bodies = [
            *cut.bodies[:2],
            kn.RigidBody("b", frame=cut.B, mass_center=cut.G, mass=2, inertia=kn.inertia(cut.B, 1, 2, 3)),
            kn.RigidBody("c", frame=cut.C, mass_center=cut.T, mass=1, inertia=kn.inertia(cut.C, 0.1, 0.2, 0.3)),
        ]
        cut.loads = [kn.Force(cut.X, N.x + N.y)]
        for name in ("rates", "shifted"):
            self.check(name, kn.reaction("R", at=cut.P, along=cut.direction), cut, {"slide": self.s, "along": along})

    @pytest.mark.slow
    @pytest.mark.parametrize("name", ["rates", "components", "shifted"])
    @pytest.mark.parametrize("middle", [False, True])
    @pytest.mark.parametrize("about", ["x", "y"])
    def test_on_a_frame(self, name, middle, about):
        """`middle`: a cut between two rotations about one axis, which are one rotation by the sum of their angles."""
        arm = Arm()
        place = arm.M if middle else arm.B
        options = {"turn": self.s, "about": about, "middle": middle}
        self.check(name, kn.reaction("R", frame=place, along=getattr(place, about)), arm, options)

    def test_velocities_accelerations_and_energies_are_without_them(self):
        arm = Arm()
        plain = kn.derive(system_of(arm, "rates"))
        cut = kn.derive(system_of(arm, "rates", reactions=[kn.reaction("R", frame=arm.B, along=arm.B.x)]))
        for p in arm.places:
            for table in ("velocities", "point_accelerations"):
                one, two = getattr(plain, table)[p], getattr(cut, table)[p]
                assert all(x is y for x, y in zip(one.components(N), two.components(N), strict=True))
        assert plain.kinetic_energy is cut.kinetic_energy
        assert plain.power is cut.power
