# SPDX-License-Identifier: BSD-3-Clause
"""Motions on constraints: residuals, energy, the dependent speeds changed under way, positions where rank is lost."""

from __future__ import annotations

import re

import numpy as np
import pytest

import kane as kn
from tests.systems.four_bar import BAR, EOM, G, N, O
from tests.systems.parallelogram import Parallelogram

q1, q2, q3 = BAR.q


def start(eom, crank=3.0, angle=1.2):
    found = kn.assemble(eom, q={q1: angle, q2: kn.guess(-0.2), q3: kn.guess(-1.5)}, u={eom.speeds[0]: crank})
    return {"q": found.q, "u": found.u}


def residual(sol):
    return max(np.abs(r).max() for r in sol.constraint_residuals.values())


def run(eom, span=(0, 3), **given):
    return kn.simulate(eom, span, rtol=1e-10, atol=1e-10, **{**start(eom), **given})


def test_a_crank_that_turns_over():
    sol = run(EOM, samples=61)
    assert np.ptp(sol["q1"]) > 2 * np.pi
    assert residual(sol) < 1e-12
    assert sol.energy_check.relative < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("method", ["RK45", "DOP853", "Radau", "BDF", "LSODA"])
def test_every_method_keeps_the_constraints(method):
    sol = kn.simulate(EOM, (0, 0.5), method=method, rtol=1e-7, atol=1e-7, samples=11, **start(EOM))
    assert sol.status == "finished"
    assert residual(sol) < 1e-6
    assert sol.energy_check.relative < 1e-4


@pytest.mark.parametrize("dependent", [(0, 1), (0, 2), (1, 2)])
def test_named_dependent_speeds_give_the_same_motion(dependent):
    """Each of these pivots vanishes somewhere in a turn: others take its place."""
    eom = BAR.derive(dependent_speeds=[EOM.speeds[k] for k in dependent])
    sol, plain = run(eom, samples=31), run(EOM, samples=31)
    np.testing.assert_allclose(sol.states, plain.states, atol=1e-6)
    assert residual(sol) < 1e-12
    assert sol.segments[0].start == 0
    changes = [(e.name, t) for e, t in sol.events if e.name.startswith("dependent speeds")]
    assert len(changes) == len(sol.segments) - 1 + (sol.segments[0].equations is not eom)
    if dependent == (0, 1):
        assert changes, "the crank's speed cannot be told where coupler and rocker are in line"


def test_a_pivot_that_vanishes_at_the_start():
    """x² + y² = 1 at (1, 0): the speed of y cannot follow from that of x; the other is taken, and the motion says so.

    Position and tension are those of a pendulum by its angle.
    """
    x, y, theta = kn.coordinates("x y theta")
    p = O.at("p", x * N.x + y * N.y)
    rod = kn.distance(p, O, 1)
    tension = kn.reaction("T", constraint=rod)
    ux, uy = kn.speeds("u_x u_y")
    gravity = kn.gravity(-G * N.y)
    system = kn.System(
        N, bodies=[kn.Particle("p", p, 2)], speeds="rates", loads=[gravity], holonomic=rod, reactions=[tension],
        dependent_speeds=[uy],
    )  # fmt: skip
    sol = kn.simulate(kn.derive(system), (0, 2), q={x: 1, y: 0}, rates={x: 0, y: 0.5}, rtol=1e-10, atol=1e-10)
    first, t = sol.events[0]
    assert (first.name, t, first.terminal) == ("dependent speeds u_x", 0, False)
    assert sol.segments[0].equations.dependent_speeds == (ux,)
    assert sol.equations.dependent_speeds == (uy,)

    free = kn.System(
        N,
        bodies=[kn.Particle("p", O.at("p", N.rotate("R", theta, N.z).x), 2)],
        speeds="rates",
        loads=[gravity],
    )
    plain = kn.simulate(kn.derive(free), (0, 2), q=[0], u=[0.5], rtol=1e-10, atol=1e-10)
    np.testing.assert_allclose(np.unwrap(np.arctan2(sol["y"], sol["x"])), plain["theta"], atol=1e-7)
    pull = 2 * G * np.sin(plain["theta"]) - 2 * plain["u_theta"] ** 2
    np.testing.assert_allclose(sol[tension], pull, atol=1e-5)
    assert residual(sol) < 1e-12


def test_a_linkage_that_cannot_turn_over_swings_back():
    """The shortest and the longest link together are longer than the others: the crank comes to a stop in line and returns."""
    eom = BAR.derive(holonomic=kn.coincident(BAR.tip, O.at("far", 1.9 * N.x), along=(N.x, N.y), name="far"))
    found = kn.assemble(eom, q={q1: 0.3, q2: kn.guess(0.4), q3: kn.guess(-0.8)}, u={eom.speeds[0]: 4.0})
    sol = kn.simulate(eom, (0, 3), q=found.q, u=found.u, rtol=1e-10, atol=1e-10)
    assert sol.status == "finished"
    # in line with the coupler: the angle at the ground of a triangle of sides 1.8 (coupler and rocker), 0.4 and 1.9
    most = np.arccos((0.4**2 + 1.9**2 - 1.8**2) / (2 * 0.4 * 1.9))
    turned = (sol["q1"] + np.pi) % (2 * np.pi) - np.pi
    assert np.abs(turned).max() < most + 1e-9
    assert np.abs(turned).max() > 0.9 * most
    assert residual(sol) < 1e-12
    assert sol.energy_check.relative < 1e-8


@pytest.mark.slow
@pytest.mark.parametrize("dependent", [0, 1])
def test_samples_where_the_dependent_speed_is_not_determined(dependent):
    """Round a circle without a load, x = cos t: a step leads across x = 0 or y = 0, where samples lie.

    There one speed does not follow from the other, however small the step; the pull is m v²/r all along.
    """
    x, y = kn.coordinates("x y")
    p = O.at("p", x * N.x + y * N.y)
    rod = kn.distance(p, O, 1)
    pull = kn.reaction("T", constraint=rod)
    speeds = kn.speeds("u_x u_y")
    system = kn.System(
        N, bodies=[kn.Particle("p", p, 2)], speeds=dict(zip(speeds, (x.dt, y.dt), strict=True)), holonomic=rod,
        reactions=[pull], dependent_speeds=[speeds[dependent]],
    )  # fmt: skip
    at = {"q": {x: np.cos(0.1), y: np.sin(0.1)}, "u": [-np.sin(0.1), np.cos(0.1)]}
    quarters = np.arange(1, 9) * np.pi / 2
    sol = kn.simulate(kn.derive(system), (0.1, 13), **at, samples=quarters, rtol=1e-8, atol=1e-8)
    np.testing.assert_allclose(sol[speeds[0].dt], -np.cos(sol.t), atol=1e-5)
    np.testing.assert_allclose(sol[speeds[1].dt], -np.sin(sol.t), atol=1e-5)
    np.testing.assert_allclose(np.abs(sol[pull]), 2, atol=1e-5)
    np.testing.assert_allclose(np.linalg.norm(sol.reaction(rod)[0], axis=1), 2, atol=1e-5)


@pytest.mark.parametrize("method", ["RK45", pytest.param("BDF", marks=pytest.mark.slow)])
def test_a_pull_across_changes_of_the_dependent_speeds(method):
    """From rest at y = 0 a pendulum pulls with −3 m g y/l, here with a mass and a length other than those declared."""
    x, y = kn.coordinates("x y")
    m, length = kn.parameter("m", 1.0), kn.parameter("l", 1.0)
    p = O.at("p", x * N.x + y * N.y)
    rod = kn.distance(p, O, length)
    eom = kn.derive(
        kn.System(N, bodies=[kn.Particle("p", p, m)], speeds="rates", loads=[kn.gravity(-G * N.y)], holonomic=rod)
    )
    sol = kn.simulate(
        eom, (0, 5), q={x: 0.7, y: 0.0}, u=[0, 0], parameters={m: 3.0, length: 0.7}, samples=101, method=method,
        rtol=1e-8, atol=1e-8,
    )  # fmt: skip
    assert len(sol.segments) > 2
    pull = -3 * 3.0 * G * sol["y"] / 0.7
    np.testing.assert_allclose(np.linalg.norm(sol.reaction(rod)[0], axis=1), pull, atol=1e-6 * pull.max())
    assert residual(sol) < 1e-12


def test_euler_parameters_stay_of_unit_length():
    e = kn.coordinates("e0:4")
    B = N.rotate_euler_parameters("B", e)
    body = kn.RigidBody("b", frame=B, mass_center=O.at("b*", 0.5 * B.x), mass=1, inertia=kn.inertia(B, 0.1, 0.2, 0.3))
    eom = kn.derive(
        kn.System(N, bodies=[body], speeds="rates", loads=[kn.gravity(-G * N.z)], holonomic=kn.perpendicular(B.y, N.z))
    )
    half = np.sqrt(0.5)
    found = kn.assemble(
        eom,
        q=dict(zip(e, (half, 0, half, 0), strict=True)),
        u={eom.speeds[1]: 2.0, eom.speeds[0]: kn.guess(1), eom.speeds[2]: kn.guess(0)},
    )
    sol = kn.simulate(eom, (0, 3), q=found.q, u=found.u)
    np.testing.assert_allclose((sol.q**2).sum(axis=1), 1, atol=1e-14)
    assert residual(sol) < 1e-12


def test_a_start_by_rates():
    sol = kn.simulate(EOM, (0, 0.1), q=start(EOM)["q"], rates={q1: 3.0}, samples=3)
    np.testing.assert_allclose(sol.u[0], list(start(EOM)["u"].values()), atol=1e-10)


class TestRankDrops(Parallelogram):
    """A parallelogram laid flat may open either way: there the constraints lose a row."""

    def test_it_swings_through(self):
        """Without gravity crank and rocker turn on alike: the energy is that of the start, and so is the speed."""
        eom = self.derive()
        flat = {self.q[0]: -0.3, self.q[1]: 0.0, self.q[2]: np.pi - 0.3}
        found = kn.assemble(eom, q=flat, u={eom.speeds[0]: 1.0})
        sol = kn.simulate(eom, (0, 1), q=found.q, u=found.u, rtol=1e-12, atol=1e-12)
        assert residual(sol) < 1e-9
        # where they lie in one line, at t = 0.3 s, the constraints do not give the dependent speeds
        elsewhere = np.abs(sol["q1"]) > 1e-9
        np.testing.assert_allclose(sol["u1"][elsewhere], 1, atol=1e-6)
        np.testing.assert_allclose(sol["u1"], 1, atol=1e-4)
        np.testing.assert_allclose(sol["q2"], 0, atol=1e-6)

    def test_accelerations_there_are_told_and_reactions_are_not(self):
        """Under gravity crank, coupler and rocker set off as one: (2 (J + m l²/4) + m l²) u1' = −(2 m g l/2 + m g l)."""
        close = self.closed()
        force = kn.reaction("T", constraint=close[0])
        eom = self.derive(close, loads=[kn.gravity(-G * N.y)], reactions=[force])
        flat = {self.q[0]: 0.0, self.q[1]: 0.0, self.q[2]: np.pi}
        sol = kn.simulate(eom, (0, 0.2), q=flat, u=[1, 0, 1], rtol=1e-10, atol=1e-10, samples=5)
        first = -2 * G / (2 * (0.1 + 0.25) + 1)
        np.testing.assert_allclose([sol[u.dt][0] for u in eom.speeds], [first, 0, first], atol=1e-8)
        # on as they set off: an arm of moment of inertia 1.7 under the moment 2 g cos q1
        np.testing.assert_allclose(sol[eom.speeds[0].dt], first * np.cos(sol["q1"]), atol=1e-6)
        assert np.isnan(sol[force]).tolist() == [True, False, False, False, False]
        assert np.isnan(sol.reaction("close 1")[0]).all(axis=1).tolist() == [True, False, False, False, False]
        assert np.isfinite(sol.energy).all()

    def test_loads_that_hold_reactions_are_refused_there(self):
        """What the reaction is cannot be told, and so neither what friction makes of it."""
        close = self.closed()
        force = kn.reaction("T", constraint=close[0])
        drag = kn.Torque(self.bodies[0].frame, -0.01 * force * N.z)
        eom = self.derive(close, loads=[kn.gravity(-G * N.y), drag], reactions=[force])
        message = (
            r"Expected constraints of constant rank, got a drop at t = 0\.3, where loads that contain reactions leave the "
            r"accelerations undetermined\. Start elsewhere, or leave out the loads that depend on reactions\."
        )
        with pytest.raises(kn.SimulationError, match=message):
            kn.simulate(eom, (0.3, 1), q={self.q[0]: 0.0, self.q[1]: 0.0, self.q[2]: np.pi}, u=[1, 0, 1])
        away = {self.q[0]: -0.3, self.q[1]: 0.0, self.q[2]: np.pi - 0.3}
        assert kn.simulate(eom, (0, 0.1), q=away, u=[1, 0, 1]).status == "finished"

    def test_a_start_there_takes_the_least_accelerations_and_says_so(self):
        eom = self.derive()
        flat = {self.q[0]: 0.0, self.q[1]: 0.0, self.q[2]: np.pi}
        sol = kn.simulate(eom, (0, 0.5), q=flat, u=[1, 0, 1], rtol=1e-10, atol=1e-10)
        assert ("rank of the constraints drops", 0) in [(e.name, t) for e, t in sol.events]
        np.testing.assert_allclose(sol["u1"], 1, atol=1e-6)


@pytest.mark.slow
def test_a_parallelogram_passes_its_change_points():
    """Laid flat, its constraints lose a row, and steps must not leap over that unseen: the drift was 9e-6 of the energy.

    Crank and rocker turn as one bar, I = 2 m a²/3 + m a² under 2 m g a cos q1: it lies flat at times that energy alone gives.
    """
    a, b = 0.4, 1.0
    q = kn.coordinates("q1:4")
    bodies = []
    point = O.at("pivot", 0)
    for name, angle, length in zip("ABC", q, (a, b, a), strict=True):
        frame = N.rotate(name, angle, N.z)
        center = point.at(f"{name}*", length / 2 * frame.x)
        bodies.append(
            kn.RigidBody(name, frame=frame, mass_center=center, mass=1, inertia=kn.rod(frame, 1, length, axis=frame.x))
        )
        point = point.at(f"end {name}", length * frame.x)
    close = kn.coincident(point, O.at("G", b * N.x), along=(N.x, N.y), name="pin G")
    eom = kn.derive(kn.System(N, bodies=bodies, speeds="rates", loads=[kn.gravity(-G * N.y)], holonomic=close))
    given = {"q": {"q1": 1.2, "q2": kn.guess(0), "q3": kn.guess(-1.9)}, "u": {"u1": 8.0}, "samples": 41}

    inertia, weight = 5 / 3 * a**2, 2 * G * a
    fine = np.linspace(1.2, 2 * np.pi + 0.1, 200_001)
    pace = np.sqrt(64 - 2 * weight / inertia * (np.sin(fine) - np.sin(1.2)))
    time = np.concatenate([[0], np.cumsum((1 / pace[1:] + 1 / pace[:-1]) / 2 * np.diff(fine))])
    for tolerance in (1e-9, 1e-10):
        sol = kn.simulate(eom, (0, 0.6), rtol=tolerance, atol=tolerance, **given)
        drops = [t for e, t in sol.events if e.name == "rank of the constraints drops"]
        np.testing.assert_allclose(drops, np.interp([np.pi, 2 * np.pi], fine, time), atol=2e-5)
        np.testing.assert_allclose(sol["q2"], 0, atol=1e-9)
        assert sol.energy_check.drift < 10 * tolerance * (0.5 * inertia * 64 + weight * (1 + np.sin(1.2)))
        assert residual(sol) < 1e-12


@pytest.mark.slow
def test_a_drive_into_a_lock_says_where_and_why():
    """The crank's end at 0.3 + 2 t leaves the reach 0.6 + 0.7 of coupler and rocker: 0.5² + 1.4² − 1.4 cos θ = 1.3²."""
    q2, q3 = kn.coordinates("q2 q3")
    at = O.at("crank pin", 0.5 * N.rotate("crank", 0.3 + 2 * kn.time, N.z).x)
    bodies = []
    for name, angle, length in (("B", q2, 0.6), ("C", q3, 0.7)):
        frame = N.rotate(name, angle, N.z)
        center = at.at(f"{name}*", length / 2 * frame.x)
        bodies.append(
            kn.RigidBody(name, frame=frame, mass_center=center, mass=1, inertia=kn.rod(frame, 1, length, axis=frame.x))
        )
        at = at.at(f"end {name}", length * frame.x)
    close = kn.coincident(at, O.at("far", 1.4 * N.x), along=(N.x, N.y), name="far pin")
    # derived without a warning: at t = 0 the parts do reach each other
    eom = kn.derive(kn.System(N, bodies=bodies, speeds="rates", holonomic=close))
    given = {"q": {q2: kn.guess(0.4), q3: kn.guess(-1.0)}, "u": {}, "samples": 3, "rtol": 1e-6}
    end = (np.arccos((0.25 + 1.96 - 1.69) / 1.4) - 0.3) / 2
    sol = kn.simulate(eom, (0, 3), **given)
    assert (sol.status, sol.t[-1]) == ("stopped", pytest.approx(end, abs=1e-6))
    assert re.match(
        rf"'far pin \d' cannot be satisfied beyond t = {end:.6g}, where the constraints lose rank \(.*\): at t = {end + 3e-3:.6g} its "
        r"residual is .* in the nearest configuration\. The prescribed motion leads beyond the reach of the parts: end the motion "
        r"earlier, prescribe",
        sol.message,
    )
