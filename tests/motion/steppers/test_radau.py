# SPDX-License-Identifier: BSD-3-Clause
"""Radau's collocation: its numbers, its order on closed forms, stiff motions, and all that is looked after along a step."""

import numpy as np
import pytest

import kane as kn
from kane import Settings
from kane.gallery import pendulums
from kane.motion import ReturnCode, Slot, compiled, radau, radau_stages, right_hand_side
from tests.motion.steppers.runs import arguments, spring

STAGES = [3, 5, 7]


@pytest.mark.parametrize("stages", STAGES)
def test_nodes_and_weights_meet_the_order_conditions(stages):
    """B(2s − 1), C(s) and D(s − 1), which give order 2s − 1: Hairer & Wanner, sec. IV.5; the last stage is the end of the step."""
    nodes = radau(stages)
    b, c, a = np.array(nodes.b), np.array(nodes.c), np.array(nodes.a).T
    for k in range(1, 2 * stages):
        assert b @ c ** (k - 1) == pytest.approx(1 / k, rel=1e-14)
    for k in range(1, stages + 1):
        assert a @ c ** (k - 1) == pytest.approx(c**k / k, rel=1e-14)
    for k in range(1, stages):
        assert (b * c ** (k - 1)) @ a == pytest.approx(b * (1 - c**k) / k, abs=1e-15)
    assert a[-1] == pytest.approx(b, rel=1e-14)


@pytest.mark.parametrize("stages", STAGES)
def test_newtons_equations_fall_apart(stages):
    m = radau_stages(stages)
    a, split, joined = np.array(radau(stages).a).T, np.array(m.split), np.array(m.joined)
    assert np.array(m.inverse) @ a == pytest.approx(np.eye(stages), abs=1e-12)
    assert split @ joined == pytest.approx(np.eye(stages), abs=1e-12)
    blocks = np.zeros((stages, stages))
    blocks[0, 0] = m.eigenvalues[0].real
    for k, z in enumerate(m.eigenvalues[1:]):
        at = slice(2 * k + 1, 2 * k + 3)
        blocks[at, at] = [[z.real, -z.imag], [z.imag, z.real]]
    assert split @ np.array(m.inverse) @ joined == pytest.approx(blocks, abs=1e-11)


def test_the_estimate_is_the_published_one():
    """Of three stages: Hairer & Wanner, sec. IV.8, eq. (8.20)."""
    root = np.sqrt(6)
    expected = [(-13 - 7 * root) / 3, (-13 + 7 * root) / 3, -1 / 3]
    assert radau_stages(3).estimate == pytest.approx(expected, rel=1e-13)


def shaken():
    """q'' = −q − q' / 5 + sin 2t from rest."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    q = kn.coordinate("q")
    p = O.at("P", q * N.x)
    load = kn.Force(p, (-q - q.dt / 5 + kn.sin(2 * kn.time)) * N.x)
    return kn.derive(kn.System(N, bodies=[kn.Particle("P", p, 1)], loads=[load], speeds="rates"))


def moved(t):
    """Its q: what is forced, and a decaying oscillation."""
    forced = np.linalg.solve([[-3, -0.4], [0.4, -3]], [1, 0])  # of sin 2t and cos 2t
    omega = np.sqrt(1 - 0.01)
    b = -forced[1]
    a = (0.1 * b - 2 * forced[0]) / omega
    decay = np.exp(-0.1 * t) * (a * np.sin(omega * t) + b * np.cos(omega * t))
    return forced[0] * np.sin(2 * t) + forced[1] * np.cos(2 * t) + decay


@pytest.mark.parametrize(
    ("eom", "start", "exact"), [(spring(), 1.0, np.cos), (shaken(), 0.0, moved)], ids=["spring", "shaken"]
)
def test_the_order_is_9_at_the_ends_and_5_between(eom, start, exact):
    def error(h, at):
        given, _ = arguments(eom, Settings(), "radau9", [start, 0.0], at[-1], h, 1e3, at)
        assert compiled("radau9", Settings())(given) == ReturnCode.END
        assert given["s"][Slot.STEPS] == round(at[-1] / h)
        return np.abs(given["rows"][:, 0] - exact(np.array(at))).max()

    coarse, fine = 1.0, 0.5
    assert 8.6 < np.log2(error(coarse, [8.0]) / error(fine, [8.0])) < 10.3
    between = [*(np.arange(1, 80) / 10 + 0.03), 8.0]
    assert np.log2(error(coarse, between) / error(fine, between)) > 5


@pytest.mark.parametrize("tolerance", [1e-4, 1e-8, 1e-12])
@pytest.mark.parametrize("rate", [1.0, 1e4, 1e9])
def test_a_stiff_speed_follows_what_draws_it(rate, tolerance):
    """u' = −λ (u − sin t) + cos t, of which sin t is a solution whatever λ is: Prothero and Robinson's."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    q, lam = kn.coordinate("q"), kn.parameter("lambda")
    p = O.at("P", q * N.x)
    load = kn.Force(p, (-lam * (q.dt - kn.sin(kn.time)) + kn.cos(kn.time)) * N.x)
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("P", p, 1)], loads=[load], speeds="rates"))
    given = {"q": [0.0], "u": [0.0], "parameters": {lam: rate}, "rtol": tolerance, "atol": tolerance}
    sol = kn.simulate(eom, (0, 10), **given, method="radau9")
    assert sol.steps < 20 + 6 * tolerance ** (-1 / 6)
    assert np.abs(sol.u[:, 0] - np.sin(sol.t)).max() < 10 * tolerance
    assert np.abs(sol.q[:, 0] - (1 - np.cos(sol.t))).max() < 30 * tolerance


def test_a_motion_that_is_not_stiff_is_as_exact_as_it_is_asked_to_be():
    eom = kn.derive(pendulums.system(2))
    start = {"q": [1.0, 2.0], "u": [0.0, 0.0], "samples": 101}
    exact = kn.simulate(eom, (0, 5), **start, method="gauss16", rtol=1e-13, atol=1e-13)
    for tolerance in (1e-5, 1e-8, 1e-11):
        sol = kn.simulate(eom, (0, 5), **start, method="radau9", rtol=tolerance, atol=tolerance)
        assert np.abs(sol.q - exact.q).max() < 100 * tolerance


def test_events_are_met():
    half = spring(lambda q: [kn.Event("half", q - 0.5)])
    met = kn.simulate(half, (0, 3), q=[1], u=[0], method="radau9")
    assert met.status == "event"
    assert met.t[-1] == pytest.approx(np.pi / 3, abs=1e-8)


def test_inputs_are_asked_at_the_stages():
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    q, f = kn.coordinate("q"), kn.input("F")
    p = O.at("P", q * N.x)
    loads = [kn.Force(p, f * N.x)]
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("P", p, 1)], loads=loads, speeds="rates"))
    sol = kn.simulate(eom, (0, 3), q=[0], u=[-1], inputs={f: lambda t: np.sin(t)}, method="radau9", max_step=0.5)
    assert (sol.method, sol.status) == ("radau9", "finished")
    assert sol.q[:, 0] == pytest.approx(-np.sin(sol.t), abs=1e-8)


def test_derivatives_come_as_entries_or_column_by_column(monkeypatch):
    eom = kn.derive(pendulums.system(3))
    start = {"q": [1.0, 2.0, 0.5], "u": [0.0] * 3, "samples": 11, "method": "radau9"}
    entries = kn.simulate(eom, (0, 2), **start)
    monkeypatch.setattr(right_hand_side, "_LONG", 0)
    columns = kn.simulate(eom, (0, 2), **start)
    assert columns.steps == entries.steps
    assert columns.q == pytest.approx(entries.q, abs=1e-9)
