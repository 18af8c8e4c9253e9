# SPDX-License-Identifier: BSD-3-Clause
"""What a motion says of its errors, against a closed form."""

import pickle

import numpy as np
import pytest

import kane as kn

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
x = kn.coordinate("x", "m")
v = kn.speed("v", "m/s")
m, k = kn.parameter("m", 2.0, "kg"), kn.parameter("k", 8.0, "N/m")
F = kn.input("F", "N")
P = O.at("P", x * N.x)
EOM = kn.derive(
    kn.System(
        N,
        bodies=[kn.Particle("P", P, m)],
        speeds={v: x.dt},
        loads=[kn.Force(P, (F - k * x) * N.x)],
        events=[kn.Event("far", x, threshold=-0.5, terminal=True)],
    )
)


def oscillation(method, rtol, end=0.9, **more):
    given = {"q": [1], "u": [0], "parameters": {k: 18}, "inputs": {F: lambda t: 0.0}, "samples": 11} | more
    return kn.simulate(EOM, (0, end), method=method, rtol=rtol, atol=rtol, **given)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("method", "rtol", "more"),
    [
        ("RK45", 1e-5, {}),
        ("DOP853", 1e-6, {"inputs": {F: 0}}),
        ("Radau", 1e-5, {}),
        ("dop853", 1e-6, {"inputs": {F: 0}}),
        ("tsit5", 1e-5, {}),
        ("tsitpap8", 1e-6, {"inputs": {F: 0}}),
    ]
    + [("dop853", 1e-3, {"max_step": 0.1}), ("gauss16", 1e-3, {"max_step": 0.5, "inputs": {F: 0}})]
    + [(m, 1e-9, {"max_step": 0.02, "inputs": {F: 0}}) for m in ("rk4", "midpoint")],
)
def test_the_errors_are_those_of_the_closed_form(method, rtol, more):
    eom = kn.derive(EOM.system.replace(events=()))
    given = {"q": [1], "u": [0], "parameters": {k: 18}, "inputs": {F: lambda t: 0.0}, "samples": 41} | more
    sol = kn.simulate(eom, (0, 6), method=method, rtol=rtol, atol=rtol, **given)
    found = sol.accuracy()
    exact = np.array([np.cos(3 * sol.t), -3 * np.sin(3 * sol.t)]).T
    true = np.abs(sol.states - exact)
    assert np.array_equal(found.t, sol.t)
    assert np.abs(found.errors - true).max() < 0.5 * true.max()
    assert found.largest["v"] == found.errors[:, 1].max()
    assert found.relative == pytest.approx((found.errors / np.abs(sol.states).max(axis=0)).max())
    assert found.worst in ("x", "v")


@pytest.mark.slow
def test_a_motion_that_an_event_ended():
    sol = oscillation("RK45", 1e-5)
    assert sol.status == "event"
    found = sol.accuracy()
    assert 0 < found.relative < 1e-3
    assert len(found.t) >= len(sol) - 1


def test_what_says_nothing_is_refused(tmp_path):
    sol = oscillation("DOP853", 1e-6)
    sol.save(tmp_path / "run.npz")
    for again in (pickle.loads(pickle.dumps(sol)), kn.load_solution(tmp_path / "run.npz", EOM)):
        with pytest.raises(
            kn.SimulationError,
            match=r"Expected a motion that this process simulated as a whole, got one that was joined, or read",
        ):
            again.accuracy()
    with pytest.raises(kn.SimulationError, match=r"rtol of 1e-12 or more, got 1e-13: .* rounding"):
        oscillation("DOP853", 1e-13).accuracy()
