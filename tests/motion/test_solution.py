# SPDX-License-Identifier: BSD-3-Clause
"""What a solution says of its motion, and that its energy check can fail."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import kane as kn

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
q = kn.coordinate("q")
w = kn.speed("w")
g, L, m, T = kn.parameter("g", 9.81), kn.parameter("L", 0.8), kn.parameter("m", 1.5), kn.input("T")
A = N.rotate("A", q, N.z)
pin = O.at("pin", 0)
bob = pin.at("bob", -L * A.y)
PULL = kn.reaction("R", at=pin, along=N.y)
EOM = kn.derive(
    kn.System(
        N,
        bodies=[kn.Particle("bob", bob, m)],
        speeds={w: 2 * q.dt},
        loads=[kn.gravity(-g * N.y), kn.Torque(A, (T - 0.1 * q.dt) * N.z)],
        reactions=[PULL],
    )
)
SOL = kn.simulate(EOM, (0, 3), q=[0.8], u=[1.0], inputs={T: lambda t: 0.3 * np.sin(t)}, samples=301)
angle, rate = SOL.q[:, 0], SOL.u[:, 0] / 2
second = -9.81 / 0.8 * np.sin(angle) + (0.3 * np.sin(SOL.t) - 0.1 * rate) / (1.5 * 0.64)


def test_expressions():
    assert SOL[q] == pytest.approx(angle, abs=0)
    assert SOL[kn.sin(q) * L] == pytest.approx(0.8 * np.sin(angle))
    assert SOL[0 * q + 3] == pytest.approx(np.full(301, 3.0))
    assert SOL[kn.time] == pytest.approx(SOL.t)
    assert SOL[T] == pytest.approx(0.3 * np.sin(SOL.t))
    assert SOL[m * g] == pytest.approx(np.full(301, 1.5 * 9.81))


def test_rates_and_accelerations():
    assert SOL[q.dt] == pytest.approx(rate)
    assert SOL[w.dt] == pytest.approx(2 * second)
    assert SOL[q.dt.dt] == pytest.approx(second)
    assert np.gradient(SOL[q.dt], SOL.t)[5:-5] == pytest.approx(SOL[q.dt.dt][5:-5], abs=2e-3)


def test_reactions():
    height = 0.8 * (second * np.sin(angle) + rate**2 * np.cos(angle))
    assert SOL[PULL] == pytest.approx(1.5 * (9.81 + height))
    assert SOL[2 * PULL - m * g] == pytest.approx(3 * (9.81 + height) - 1.5 * 9.81)


def test_vectors():
    place = SOL[bob.position(O)]
    assert place.shape == (301, 3)
    assert place == pytest.approx(0.8 * np.stack([np.sin(angle), -np.cos(angle), 0 * angle], -1))
    assert SOL[bob.velocity(N)] == pytest.approx(SOL[EOM.velocities[bob]])
    assert SOL[bob.acceleration(N)] == pytest.approx(SOL[EOM.point_accelerations[bob]])
    assert np.linalg.norm(SOL[2 * A.x], axis=1) == pytest.approx(np.full(301, 2))


def test_names():
    assert SOL["q"] == pytest.approx(angle)
    assert SOL["w"] == pytest.approx(2 * rate)
    assert SOL["R"] == pytest.approx(SOL[PULL])
    assert SOL["L"] == pytest.approx(np.full(301, 0.8))
    assert SOL["T"] == pytest.approx(SOL[T])


def test_several():
    one, two = SOL[q, "w"]
    assert one == pytest.approx(SOL[q])
    assert two == pytest.approx(SOL[w])
    assert len(SOL[[q, q.dt, bob.position(O)]]) == 3


@pytest.mark.parametrize(
    ("what", "error", "message"),
    [
        ("x", kn.ValueMissingError, "Expected one of q, w, R, .*got 'x'"),
        ("qq", kn.ValueMissingError, "got 'qq'. Did you mean q?"),
        (kn.coordinate("x"), kn.ValueMissingError, "got none for x"),
        ({"q"}, TypeError, "expression, vector, name"),
        (None, TypeError, "got NoneType"),
        (q.dt.dt.dt, kn.ExpressionError, "differentiate along the motion"),
        (kn.Frame("M").x, kn.SpaceError, "no common root"),
    ],
)
def test_errors(what, error, message):
    with pytest.raises(error, match=message):
        SOL[what]


def test_shape_and_text():
    assert len(SOL) == 301
    assert SOL.states.shape == (301, 2)
    assert SOL.q.shape == SOL.u.shape == (301, 1)
    assert SOL.evaluations > SOL.steps > 5
    assert repr(SOL).startswith("Solution(t = 0 … 3, 301 samples, ")
    assert repr(SOL).endswith("finished: reached t = 3)")


def test_reading_does_not_write():
    states = SOL.states.copy()
    SOL[q][:] = 0
    _ = SOL.energy_check
    assert np.array_equal(SOL.states, states)


def test_frozen():
    with pytest.raises(AttributeError):
        SOL.t = np.zeros(3)  # type: ignore[misc]


class TestEnergyCheck:
    def test_it_holds(self):
        assert SOL.energy_check.relative < 1e-8
        power = (0.3 * np.sin(SOL.t) - 0.1 * rate) * rate
        work = np.concatenate([[0], np.cumsum((power[1:] + power[:-1]) / 2 * np.diff(SOL.t))])
        assert SOL.work == pytest.approx(work, abs=1e-4)
        energy = 1.5 * (0.64 * rate**2 / 2 - 9.81 * 0.8 * np.cos(angle))
        assert SOL.energy == pytest.approx(energy)
        assert str(SOL.energy_check).startswith("energy minus work constant to ")

    def test_it_fails_on_the_wrong_work(self):
        wrong = replace(SOL, work=SOL.work * 1.1)
        assert wrong.energy_check.drift == pytest.approx(0.1 * np.abs(SOL.work).max(), rel=1e-3)
        assert wrong.energy_check.relative > 1e-3

    def test_it_fails_on_the_wrong_motion(self):
        states = SOL.states.copy()
        states[:, 1] *= 1 + 1e-3 * np.linspace(0, 1, 301)
        assert replace(SOL, states=states).energy_check.relative > 1e-5

    def test_it_fails_on_a_loose_integration(self):
        with pytest.warns(
            kn.KaneWarning, match=r"Expected E − ∫P dt constant .*Tighten rtol= and atol= from 0\.01 and 0\.01"
        ):
            loose = kn.simulate(EOM, (0, 3), q=[0.8], u=[1.0], inputs={T: 0}, rtol=1e-2, atol=1e-2, method="RK23")
        assert loose.energy_check.relative > 100 * SOL.energy_check.relative

    def test_at_rest(self):
        still = kn.simulate(EOM, (0, 1), q=[0.0], u=[0.0], inputs={T: 0})
        assert still.energy_check.relative == 0
        assert still.energy_check.drift == 0


@pytest.mark.parametrize("offset", [0.0, 5e-6, 1e-3])
def test_energy_all_but_at_rest(offset):
    """A load hangs on its spring: E = m u²/2 + k (x − x0)²/2 + const, so that atol leaves (k |x − x0| + m |u|) atol open."""
    x = kn.coordinate("x")
    p = O.at("p", x * N.y)
    loads = [kn.gravity(-9.81 * N.y), kn.linear_spring(p, O, 800.0), kn.linear_damper(p, O, 5.0)]
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("load", p, 2.0)], speeds="rates", loads=loads))
    rest = -2 * 9.81 / 800
    sol = kn.simulate(eom, (0, 5), q=[rest + offset], u=[0.0], samples=101)
    check = sol.energy_check
    assert check.relative < 1e-7
    # the largest is among a few samples, the first included, where it is k x0
    moved = 5e-9  # by which a load at rest may move: a few times atol, since rounding leaves a little force
    assert check.scale == pytest.approx(800 * offset, rel=0.2, abs=800 * moved)
    # the tighter the tolerance, the less is left open
    tight = kn.simulate(eom, (0, 5), q=[rest + offset], u=[0.0], atol=1e-13, rtol=1e-9, samples=101).energy_check
    assert tight.scale <= max(1e-4 * check.scale + 400 * offset**2, 800 * moved)
    assert replace(sol, work=sol.work + np.linspace(0, 1e-3 * check.scale, 101)).energy_check.relative > 1e-4
