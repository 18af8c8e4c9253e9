# SPDX-License-Identifier: BSD-3-Clause
"""Errors by the variational equations, against motions at 1e-13 by another method."""

import numpy as np
import pytest

import kane as kn
from kane.gallery import load, pendulums
from tests.motion.test_stiff import derived

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
x, v = kn.coordinate("x"), kn.speed("v")
P = O.at("P", x * N.x)
F = kn.input("F")


def line(force, events=()):
    """A particle of 1 kg on a line."""
    loads = [kn.Force(P, force * N.x)]
    return kn.derive(kn.System(N, bodies=[kn.Particle("p", P, 1)], speeds={v: x.dt}, loads=loads, events=events))


def both(eom, end, given, other="vern9"):
    """What the motion says of its largest error, over the one that it has."""
    sol = kn.simulate(eom, (0, end), **given, samples=41)
    fine = {"rtol": 1e-13, "atol": 1e-13 * given["atol"] / given["rtol"], "method": other}
    true = np.abs(sol.states - kn.simulate(eom, (0, end), **given | fine, samples=41).states)
    found = sol.accuracy(method="variational")
    assert np.array_equal(found.t, sol.t)
    assert not found.errors[0].any()
    size = np.abs(sol.states).max(axis=0)
    assert found.relative == pytest.approx((found.errors / size).max())
    return found.relative / (true / size).max(), np.abs(found.errors - true).max() / true.max()


@pytest.mark.slow
@pytest.mark.parametrize("method", ["gauss16", "dop853", "tsitpap8", "tsit5", "vern9", "radau9", "DOP853", "BDF"])
@pytest.mark.parametrize("seed", range(3))
def test_random_pendulums(method, seed):
    """One to three rods at tolerances from 1e-4 to 1e-9: the errors at all samples, to a tenth of the largest where it is small."""
    rng = np.random.default_rng([seed, len(method)])
    n, rtol = seed + 1, 10.0 ** rng.uniform(-9, -4 - seed)
    if method == "BDF":
        rtol = max(rtol, 1e-6)
    start = {"q": rng.uniform(-1.5, 1.5, n), "u": rng.uniform(-1, 1, n)}
    ratio, rest = both(
        PENDULUMS[n],
        4.0,
        start | {"rtol": rtol, "atol": rtol, "method": method},
        "dop853" if method == "vern9" else "vern9",
    )
    assert 0.7 < ratio < 1.5
    assert rest < 0.3


PENDULUMS = {n: kn.derive(pendulums.system(n)) for n in (1, 2, 3)}


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(40))
def test_many_random_pendulums(seed):
    rng = np.random.default_rng([seed, 5])
    n, rtol = int(rng.integers(1, 4)), 10.0 ** rng.uniform(-10, -6)
    method = str(rng.choice(["gauss16", "dop853", "tsit5", "radau9"]))
    start = {"q": rng.uniform(-2, 2, n), "u": rng.uniform(-3, 3, n), "parameters": {}}
    ratio, _ = both(PENDULUMS[n], 5.0, start | {"rtol": rtol, "atol": rtol, "method": method})
    assert 1 / 3 < ratio < 3


@pytest.mark.slow
@pytest.mark.parametrize(
    "force", [kn.sin(3 * kn.time), kn.exp(-((kn.time - 2) ** 2) / 0.01), kn.where(kn.less(kn.time, 1.7), 0, 5) - v]
)
@pytest.mark.parametrize("method", ["auto", "tsit5"])
def test_drives(force, method):
    given = {"q": [1], "u": [0], "inputs": {F: force}, "rtol": 1e-6, "atol": 1e-6, "method": method}
    ratio, rest = both(line(F - x - x**3), 5.0, given)
    assert 0.9 < ratio < 1.1
    assert rest < 0.1


@pytest.mark.slow
def test_a_function_that_follows_from_the_state():
    given = {"q": [1], "u": [0], "inputs": {F: lambda t, s: -4 * s[0] - 0.1 * s[1]}, "rtol": 1e-6, "atol": 1e-6}
    ratio, rest = both(line(F), 5.0, given | {"method": "DOP853"}, "Radau")
    assert 0.9 < ratio < 1.1
    assert rest < 0.1


@pytest.mark.slow
@pytest.mark.parametrize("method", ["gauss16", "dop853", "DOP853"])
def test_constraints_beyond_other_dependent_speeds(method):
    """A four-bar linkage whose dependent speeds change on the way: the errors of all coordinates and speeds."""
    eom = kn.derive(load("four_bar").system())
    begin = kn.assemble(eom, q={eom.coordinates[0]: 1.0}, u={eom.speeds[0]: 3.0})
    given = {"q": begin.q, "u": begin.u, "rtol": 1e-7, "atol": 1e-7, "method": method}
    sol = kn.simulate(eom, (0, 2), **given)
    assert len(sol.segments) > 1
    ratio, rest = both(eom, 2.0, given)
    assert 0.7 < ratio < 1.4
    assert rest < 0.4


def test_stiff_equations():
    eom, given = derived(), {"q": [0.0] * 4, "u": [0.0] * 4, "rtol": 1e-7, "atol": 1e-11, "method": "radau9"}
    ratio, rest = both(eom, 5.0, given, "radau9")
    assert 0.9 < ratio < 1.1
    assert rest < 0.1


def test_what_is_refused(tmp_path):
    eom = line(-x, [kn.Event("bounce", x, direction=-1, then={v: -v})])
    bounced = kn.simulate(eom, (0, 9), q=[1], u=[0])
    with pytest.raises(
        kn.SimulationError, match=r"events change the state or motions are joined. Use sol.accuracy\(\)"
    ):
        bounced.accuracy(method="variational")
    rubbed = kn.simulate(line(-x - 0.1 * kn.sign(v)), (0, 3), q=[1], u=[0])
    with pytest.raises(kn.SimulationError, match="loads or inputs jump with the state"):
        rubbed.accuracy(method="variational")
    held = kn.simulate(line(F), (0, 1), q=[1], u=[0], inputs={F: kn.sampled(lambda t, s: -s[0], 0.1)})
    with pytest.raises(kn.SimulationError, match="a sampled controller acts"):
        held.accuracy(method="variational")
    free = line(-x)
    sol = kn.simulate(free, (0, 1), q=[1], u=[0])
    with pytest.raises(kn.ArgumentError, match=r"Expected method to be one of repeated, variational, got 'exact'"):
        sol.accuracy(method="exact")
    driven = kn.simulate(line(F), (0, 1), q=[1], u=[0], inputs={F: lambda t: np.sin(t)})
    driven.save(tmp_path / "driven.npz")
    with pytest.raises(kn.SimulationError, match="got one that was joined, or read"):
        kn.load_solution(tmp_path / "driven.npz", driven.equations).accuracy(method="variational")


def test_motions_out_of_files(tmp_path):
    """Where nothing but numbers went in, as of the motion itself."""
    eom = line(-x)
    sol = kn.simulate(eom, (0, 1), q=[1], u=[0])
    sol.save(tmp_path / "run.npz")
    found, own = (s.accuracy(method="variational") for s in (kn.load_solution(tmp_path / "run.npz", eom), sol))
    assert found.relative == own.relative
    assert np.array_equal(found.errors, own.errors)
