# SPDX-License-Identifier: BSD-3-Clause
"""Constraints kept in machine code: motions are those of SciPy's steps, and every sample is on the constraints."""

import numpy as np
import pytest

import kane as kn
from kane.gallery import load
from kane.motion import KernelSolver, constraint_projection
from tests.lanes import SMOOTH
from tests.systems import four_bar
from tests.systems.parallelogram import Parallelogram

NATIVE = (*SMOOTH, "dop853")
EACH = [*NATIVE, pytest.param("radau9", marks=pytest.mark.slow)]
MODELS = {
    "car_with_trailer": 1,
    "chaplygin_sleigh": 1,
    "flyball_governor": 0.5,
    "four_bar": 0.2,
    "knife_edge": 1,
    "rattleback": 0.1,
    "slider_crank": 0.1,
    "snakeboard": 1,
    "sphere_on_turntable": 1,
}
SLOW = ("car_with_trailer", "flyball_governor", "four_bar", "rattleback", "sphere_on_turntable", "slider_crank")
TIGHT = {"rtol": 1e-11, "atol": 1e-11}


def left(eom, sol):
    """What is left of the constraints at the samples, over the sizes of their terms."""
    numbers, p = constraint_projection(eom.numeric()).numbers, np.array([sol.parameters[s] for s in eom.parameters])
    worst = 0.0
    for k, (t, x) in enumerate(zip(sol.t, np.hstack([sol.q, sol.u]), strict=True)):
        r = np.array([sol[s][k] for s in eom.inputs])
        now, u = numbers(t, x, p, r), x[len(eom.coordinates) :]
        sizes = np.append(now.terms, np.abs(now.a).max(axis=1, initial=0) * np.abs(u).max() + np.abs(now.b))
        worst = max(worst, *np.abs(np.append(now.f, now.a @ u + now.b)) / np.where(sizes > 0, sizes, 1.0))
    return worst


@pytest.mark.parametrize("name", [pytest.param(n, marks=pytest.mark.slow) if n in SLOW else n for n in MODELS])
def test_the_gallerys_constrained_motions_run_in_machine_code(name):
    """Closures, rolling, blades, Euler parameters, redundant ones: to 1e-10 at every sample; the motion is SciPy's."""
    model = load(name)
    eom = kn.derive(model.system())
    own, other = (
        kn.simulate(eom, (0, MODELS[name]), **model.START, **TIGHT, samples=12, method=m) for m in ("auto", "DOP853")
    )
    assert own.method in NATIVE
    assert left(eom, own) < 1e-12
    scale = np.abs(other.states).max(axis=0) + 1e-3
    assert np.abs((own.states - other.states) / scale).max() < 1e-7
    assert not own.energy_check.exceeds(1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("method", EACH)
@pytest.mark.parametrize("samples", [2, 700])
def test_a_long_motion_stays_on_its_constraints(method, samples):
    """Thirty turns of a crank at a loose tolerance, few and many samples a step; other dependent speeds are taken on the way."""
    eom = kn.derive(load("four_bar").system())
    start = {"q": {"q1": 1.2, "q2": kn.guess(0.4), "q3": kn.guess(-1.5)}, "u": {"u1": 15.0}}
    sol = kn.simulate(eom, (0, 12), **start, method=method, rtol=1e-6, atol=1e-6, samples=samples)
    assert (sol.status, sol.method) == ("finished", method)
    assert sol["q1"][-1] > 60 * np.pi
    assert left(eom, sol) < 1e-12
    assert sol.segments


@pytest.mark.slow
@pytest.mark.parametrize("method", EACH)
def test_closures_that_are_driven_are_closed_at_all_times(method):
    """A crank led by an expression, and by functions of time that Python is asked for: the same motion."""
    q2, q3 = kn.coordinates("q2 q3")
    N, r = kn.Frame("N"), kn.input("r")
    O = kn.Point("O", fixed_in=N)
    at = O.at("pin", 0.3 * N.rotate("crank", r, N.z).x)
    bodies = []
    for name, angle, length in (("B", q2, 0.8), ("C", q3, 0.7)):
        frame = N.rotate(name, angle, N.z)
        center = at.at(f"{name}*", length / 2 * frame.x)
        inertia = kn.rod(frame, 1, length, axis=frame.x)
        bodies.append(kn.RigidBody(name, frame=frame, mass_center=center, mass=1, inertia=inertia))
        at = at.at(f"end {name}", length * frame.x)
    close = kn.coincident(at, O.at("far", 1.0 * N.x), along=(N.x, N.y), name="far pin")
    eom = kn.derive(kn.System(N, bodies=bodies, speeds="rates", holonomic=close))
    start = {"q": {q2: kn.guess(0.8), q3: kn.guess(-1.0)}, "u": {}, "samples": 40, **TIGHT}
    functions = tuple(lambda t, k=k: 3.0**k * np.sin(3 * t + k * np.pi / 2) for k in range(3))
    other = kn.simulate(eom, (0, 2), **start, inputs={r: functions}, method="DOP853")
    inputs = [kn.sin(3 * kn.time)] + ([functions] if method == "dop853" else [])
    for given in inputs:
        own = kn.simulate(eom, (0, 2), **start, inputs={r: given}, method=method, breakpoints=[0.5])
        assert own.method == method
        assert left(eom, own) < 1e-12
        assert own.states == pytest.approx(other.states, abs=1e-7)


@pytest.mark.slow
def test_events_are_met_at_states_on_the_constraints():
    """The rocker's angle, passed again and again, and the crank's, which ends the motion."""
    eom = four_bar.EOM
    q = eom.coordinates
    events = [kn.Event("rocker", q[2] + 1.5, terminal=False), kn.Event("crank", q[0] - 30)]
    watched = kn.derive(eom.system.replace(events=events))
    start = four_bar.state()
    own, other = (kn.simulate(watched, (0, 10), **start, **TIGHT, method=m) for m in ("gauss16", "DOP853"))
    assert own.status == "event"
    assert own.event.name == "crank"
    met = [(e.name, t) for e, t in own.events if e.name == "rocker"]
    assert len(met) >= 5
    assert [t for _, t in met] == pytest.approx([t for e, t in other.events if e.name == "rocker"], abs=1e-8)
    assert own.states[-1] == pytest.approx(other.states[-1], abs=1e-6)
    assert left(watched, own) < 1e-12


class TestSingularPositions(Parallelogram):
    """Where constraints lose rank SciPy's steps lead past the place, and machine code goes on."""

    @pytest.mark.slow
    @pytest.mark.parametrize("method", EACH)
    def test_machine_code_goes_on_beyond(self, method, monkeypatch):
        eom = self.derive()
        flat = {self.q[0]: -0.3, self.q[1]: 0.0, self.q[2]: np.pi - 0.3}
        found = kn.assemble(eom, q=flat, u={eom.speeds[0]: 1.0})
        taken_up = []
        own = KernelSolver._take_up
        monkeypatch.setattr(KernelSolver, "_take_up", lambda self, t: taken_up.append(t) or own(self, t))
        sol = kn.simulate(eom, (0, 2), q=found.q, u=found.u, method=method, samples=12, rtol=1e-10, atol=1e-11)
        assert sol.method == f"{method}, DOP853"
        assert max(taken_up) > 0.3
        assert len(set(taken_up)) == len(taken_up)  # SciPy has led on in between
        assert sol["u1"] == pytest.approx(1, abs=1e-6)
        assert sol.accuracy().largest["q1"] < 1e-4

    def test_events_that_were_at_their_thresholds_before_are_met_once(self):
        """The quantity leaves its threshold and passes it while SciPy leads on: machine code goes on from the other side."""
        flat = {self.q[0]: -0.002, self.q[1]: 0.0, self.q[2]: np.pi - 0.002}
        wave = kn.Event("wave", kn.sin(700 * (self.q[0] + 0.002)), terminal=False)
        eom = self.derive(events=[wave])
        found = kn.assemble(eom, q=flat, u={eom.speeds[0]: 1.0})
        sol = kn.simulate(eom, (0, 0.02), q=found.q, u=found.u, method="gauss16", samples=3, rtol=1e-9, atol=1e-10)
        assert sol.method == "gauss16, DOP853"
        met = [t for event, t in sol.events if event.name == "wave"]
        assert met == pytest.approx(np.pi / 700 * np.arange(1, 5), abs=1e-8)
