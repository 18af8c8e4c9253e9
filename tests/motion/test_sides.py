# SPDX-License-Identifier: BSD-3-Clause
"""Which side of its switches a motion is on at each sample, and where friction slides."""

import numpy as np
import pytest

import kane as kn
from tests.peer import require

N = kn.Frame("N")
x, v = kn.coordinate("x"), kn.speed("v")
P = kn.Point("O", fixed_in=N).at("P", x * N.x)
PARTICLE = kn.Particle("p", P, 1)


def test_each_swing_has_its_sign(tmp_path):
    """Sliding friction of 3 N on 50 N/m: the sign turns at half periods; in tables and out of a file it is the same."""
    load = kn.Force(P, (-50 * x - 3 * kn.sign(v) - kn.max(0, x - 9)) * N.x)
    eom = kn.derive(kn.System(N, bodies=[PARTICLE], speeds={v: x.dt}, loads=[load]))
    sol = kn.simulate(eom, (0, 1.5), q=[0.5], u=[0], samples=np.linspace(0, 1.5, 200))
    half = np.pi / np.sqrt(50)
    (name,) = sol.regimes
    assert name == "sign(v)"
    own = sol.regimes[name]
    assert own[0] == 0
    assert np.array_equal(own[1:], np.where((sol.t[1:] // half).astype(int) % 2, 1, -1))
    sol.save(tmp_path / "run.npz")
    assert np.array_equal(kn.load_solution(tmp_path / "run.npz", eom).regimes[name], own)
    require("xarray")
    table = sol.to_xarray()
    assert np.array_equal(table["regime sign(v)"].values, own)
    assert "regime of sign(v)" in table["regime sign(v)"].attrs["long_name"]


@pytest.mark.parametrize("threshold", [None, 1e-6])
def test_friction_slides_until_it_does_not(threshold):
    """A block pushed on a table slides until its speed is at the threshold, where the motion ends; smooth friction has no such end."""
    normal = kn.reaction("N", at=P, along=N.y)
    rub = kn.friction(P, normal, 0.3, name="rub", threshold=threshold)
    model = kn.System(N, bodies=[PARTICLE], speeds={v: x.dt}, reactions=[normal], loads=[kn.gravity(-9.81 * N.y), rub])
    sol = kn.simulate(kn.derive(model), (0, 5), q=[0], u=[2.0], samples=np.arange(0, 5, 0.01))
    assert sol.status == "event"
    assert list(sol.regimes) == ["rub"]
    assert sol.regimes["rub"].tolist() == [1] * (len(sol) - 1) + [0]


def test_nothing_that_switches_has_no_regimes():
    eom = kn.derive(kn.System(N, bodies=[PARTICLE], speeds={v: x.dt}, loads=[kn.Force(P, -abs(x) * x * N.x)]))
    assert kn.simulate(eom, (0, 1), q=[1], u=[0], samples=3).regimes == {}
