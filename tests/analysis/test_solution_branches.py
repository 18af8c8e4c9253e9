# SPDX-License-Identifier: BSD-3-Clause
"""Branches of steady motions: turning points and stability against closed forms."""

import numpy as np
import pytest

import kane as kn
from kane.analysis import tracked
from kane.gallery import whipple_bicycle
from tests.systems import steady as systems
from tests.systems.steady import driven_pendulum
from tests.systems.whipple import BIKE_C1, BIKE_K0, BIKE_K2, BIKE_M


@pytest.fixture(scope="module")
def branch():
    return kn.continuation(driven_pendulum(), "tau", [0, 4, 8, 9.9, 12], q={"q1": kn.guess(0)}, u={"u1": 0})


@pytest.mark.slow
def test_the_branch_turns_back_where_the_torque_is_largest(branch):
    """sin q = τ/(m g l): up to τ = 10, and back on the unstable side to q = π."""
    np.testing.assert_allclose(branch.values, [0, 4, 8, 9.9, 10, 9.9, 8, 4, 0], atol=1e-9)
    assert branch.turning == (4,)
    assert branch.turning_points == pytest.approx((10.0,), rel=1e-10)
    angles = [p["q1"] for p in branch.points]
    np.testing.assert_allclose(np.sin(angles), branch.values / 10, atol=1e-9)
    assert angles[-1] == pytest.approx(np.pi, rel=1e-9)
    assert branch.message == "the first value was reached again"
    assert "turning points: 10" in repr(branch)


def test_eigenvalues_along_the_branch(branch):
    """λ² + b λ + m g l cos q = 0, each root in one column; stability is lost at the turning point."""
    q = np.array([p["q1"] for p in branch.points])
    for values, angle in zip(branch.eigenvalues, q, strict=True):
        expected = np.roots([1, 0.5, 10 * np.cos(angle)])
        # a double root moves with the square root of the angle's last digits
        np.testing.assert_allclose(np.sort_complex(values), np.sort_complex(expected), atol=1e-6)
    (crossing,) = branch.crossings
    assert crossing.value == pytest.approx(10, rel=1e-10)
    assert crossing.point["q1"] == pytest.approx(np.pi / 2, abs=1e-6)
    assert (crossing.between, crossing.grows) == ((4, 5), True)
    assert crossing.eigenvalue == 0
    assert [at.states for at in branch.linear] == [("q1", "u1")] * 9


def test_columns_follow_their_roots():
    t = np.linspace(0, 1, 21)
    roots = np.array([[1j + s, -1j + s, 2 - 4 * s, -2 + 4 * s] for s in t])
    shuffled = [row[np.random.default_rng(i).permutation(4)] for i, row in enumerate(roots)]
    found = tracked(shuffled)
    order = [int(np.argmin(np.abs(roots[0] - v))) for v in found[0]]
    np.testing.assert_allclose(found, roots[:, order])


def bicycle_branch(speeds):
    eom = kn.derive(whipple_bicycle.system())
    q = dict.fromkeys((s.name for s in eom.coordinates), 0.0) | {"delta": kn.guess(0), "theta": kn.guess(0)}
    return kn.continuation(
        eom,
        "u5",
        -np.array(speeds) / 0.3,
        q=q,
        u={"u1": 0, "u4": 0},
        inputs={"T_phi": 0, "T_delta": 0},
        independent=("u1", "u4", "u5"),
    )


@pytest.mark.parametrize(
    ("speeds", "between"),
    [
        pytest.param([4.0, 4.29, 4.293, 5.0, 6.02, 6.03, 7.0], ((1, 2), (4, 5)), marks=pytest.mark.slow),
        pytest.param([7.0, 4.0], ((0, 1), (0, 1)), marks=pytest.mark.slow),
    ],
)
def test_bicycle_is_stable_between_weave_and_capsize_speed(speeds, between):
    """4.29238253634111 and 6.02426201538837 m/s (Meijaard et al. 2007, sec. 5), however far apart the points are."""
    found = bicycle_branch(speeds)
    np.testing.assert_allclose(found.values * -0.3, speeds, rtol=1e-12)
    assert found.linear[0].states == ("phi", "delta", "u1", "u4", "u5")
    assert tuple(c.between for c in found.crossings) == between
    weave, capsize = sorted(found.crossings, key=lambda c: -c.value)
    assert -0.3 * weave.value == pytest.approx(4.29238253634111, rel=1e-11)
    assert -0.3 * capsize.value == pytest.approx(6.02426201538837, rel=1e-11)
    assert capsize.eigenvalue == 0
    assert (weave.grows, capsize.grows) == ((False, True) if speeds[0] < speeds[-1] else (True, False))
    # on the imaginary axis det(−ω² M + i ω v C1 + g K0 + v² K2) = 0
    w, v = weave.eigenvalue.imag, -0.3 * weave.value
    assert abs(np.linalg.det(-(w**2) * BIKE_M + 1j * w * v * BIKE_C1 + 9.81 * BIKE_K0 + v**2 * BIKE_K2)) < 1e-9


@pytest.mark.slow
def test_a_mode_that_comes_to_grow_twice_between_two_values():
    """m ẍ + (p − 1)(p − 3) ẋ + 4 x = 0 grows for 1 < p < 3: at both ends of (0, 4) it does not."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, p = kn.coordinate("x"), kn.parameter("p", 0.0)
    P = O.at("P", x * N.x)
    force = kn.Force(P, (-(p - 1) * (p - 3) * x.dt - 4 * x) * N.x)
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("m", P, 1.0)], speeds="rates", loads=[force]))
    found = kn.continuation(eom, p, [0, 4], q={x: kn.guess(0.0)}, u=[0])
    assert [c.value for c in found.crossings] == pytest.approx([1, 3], rel=1e-9)
    assert [c.eigenvalue for c in found.crossings] == pytest.approx([2j, 2j])
    assert [(c.between, c.grows) for c in found.crossings] == [((0, 1), True), ((0, 1), False)]


@pytest.mark.parametrize(
    "values",
    [[-4, 4], *(pytest.param(v, marks=pytest.mark.slow) for v in ([-4, -1, 2, 4], np.linspace(-4, 4, 9)))],
)
def test_a_branch_that_turns_twice(values):
    """x³ − 3x + p = 0 turns at p = ±2, where x = ±1 and 3x² − 3 = 0, whether or not a value asked for lies there."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, p = kn.coordinate("x"), kn.parameter("p", 0.0)
    P = O.at("P", x * N.x)
    force = kn.Force(P, (-(x**3 - 3 * x + p) - 0.5 * x.dt) * N.x)
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("m", P, 1.0)], speeds="rates", loads=[force]))
    found = kn.continuation(eom, p, values, q={x: kn.guess(2.2)}, u=[0])
    assert found.turning_points == pytest.approx((2, -2), rel=1e-9)
    places = np.array([at["x"] for at in found.points])
    np.testing.assert_allclose(places[list(found.turning)], [1, -1], atol=1e-6)
    np.testing.assert_allclose(found.values, 3 * places - places**3, atol=1e-9)
    # every value on each of the three stretches, at a turning point on two at once
    inside = sum(abs(v) < 2 for v in values)
    assert len(found) == 3 * inside + 2 + sum(abs(v) > 2 for v in values) + sum(abs(v) == 2 for v in values)
    assert [(c.value, c.grows) for c in found.crossings] == [
        (pytest.approx(2, rel=1e-9), True),
        (pytest.approx(-2, rel=1e-9), False),
    ]
    assert [found.turning[k] in c.between for k, c in enumerate(found.crossings)] == [True, True]


@pytest.mark.slow
def test_turning_disk_by_its_lean():
    """A coordinate may be what changes; every point satisfies the closed-form relation of steady turning."""
    eom = systems.rolling_disk()
    found = kn.continuation(eom, "q2", [0.1, 0.3, 0.5], u={"u3": -9.0, "u2": kn.guess(0.5)})
    assert [p["q2"] for p in found.points] == pytest.approx([0.1, 0.3, 0.5])
    for p in found.points:
        assert max(np.abs(eom.evaluate(list(eom.accelerations[:3]), q=p.q, u=p.u))) < 1e-9


def test_what_cannot_be_followed():
    eom = driven_pendulum()
    with pytest.raises(kn.SimulationError, match=r"increasing or decreasing values to follow, got \[1, 3, 2\]"):
        kn.continuation(eom, "tau", [1, 3, 2], q={"q1": kn.guess(0)}, u={"u1": 0})
    with pytest.raises(
        kn.ValueMissingError, match=r"a value of the system to change, one of q1, u1, (b, )?tau(, b)?, got 'sigma'"
    ):
        kn.continuation(eom, "sigma", [1, 2], q={"q1": kn.guess(0)}, u={"u1": 0})
    with pytest.raises(kn.SimulationError, match=r"the residuals are u1' = 2"):
        kn.continuation(eom, "tau", [12, 14], q={"q1": kn.guess(0)}, u={"u1": 0})
    with pytest.raises(kn.SimulationError, match=r"q= by symbol or name where q1 changes"):
        kn.continuation(eom, "q1", [0, 1], q=[0], u={"u1": 0}, inputs={"tau": kn.guess(0)})
    disk = systems.rolling_disk()
    with pytest.raises(kn.ValueMissingError, match=r"determine one branch, got a family of branches: .*u2.*u3"):
        kn.continuation(disk, "q2", [0.1, 0.3], u={"u3": kn.guess(-9.0), "u2": kn.guess(0.5)})


@pytest.mark.parametrize(
    "range_", [8.0, *(pytest.param(r, marks=pytest.mark.slow) for r in (40.0, 600.0)), 120.0, 5000.0]
)
def test_two_turning_points_close_to_each_other(range_):
    """A shallow von Mises truss snaps through: f = 2 k y (l/r − 1) is largest at r³ = l w²."""
    N, (w, long, k) = kn.Frame("N"), (1.0, 1.02, 1000.0)
    y, u, F = kn.coordinate("y"), kn.speed("u"), kn.input("F")
    top = kn.Particle("top", kn.Point("O", fixed_in=N).at("P", y * N.y), 2.0)
    r = kn.sqrt(w**2 + y**2)
    pull = kn.Force(top.point, (2 * k * y * (long / r - 1) - 3 * u - F) * N.y)
    eom = kn.derive(kn.System(N, bodies=[top], speeds={u: y.dt}, loads=[pull]))
    values = np.linspace(-range_ / 2, range_ / 2, 5)
    branch = kn.analysis.continuation(eom, F, values, q={y: kn.guess(0.3)})
    at = np.sqrt((long * w**2) ** (2 / 3) - w**2)
    most = 2 * k * at * (long / np.sqrt(w**2 + at**2) - 1)
    np.testing.assert_allclose(branch.turning_points, [most, -most], rtol=1e-7)
    assert len(branch) == 5 + 2 + 2 * (np.abs(values) < most).sum()  # values between them occur three times


@pytest.mark.parametrize("metre", [1.0, 1e5, 1e-6])
def test_a_branch_that_begins_where_nothing_has_a_size(metre):
    """k x + c x³ = F from rest at x = 0, F = 0, in other units of length and of time: x is the real root at each F."""
    second = 1e6 if metre < 1 else 1.0
    N, k, c = kn.Frame("N"), 3.0, 1.0
    x, F = kn.coordinate("x"), kn.parameter("F", 0.0)
    own = kn.Particle("own", kn.Point("O", fixed_in=N).at("P", x * N.x), 1.0)
    hard = kn.Force(own.point, (F - k / second**2 * x - c / second**2 / metre**2 * x**3) * N.x)
    eom = kn.derive(kn.System(N, bodies=[own], speeds="rates", loads=[hard]))
    forces = np.array([0.0, 1.0, 5.0, 100.0])
    branch = kn.continuation(eom, F, forces * metre / second**2, q={x: kn.guess(0)}, u=[0])
    roots = [np.roots([c, 0, k, -f]) for f in forces]
    expected = [float(r[np.abs(r.imag) < 1e-9].real[0]) for r in roots]
    np.testing.assert_allclose([p["x"] / metre for p in branch.points], expected, rtol=1e-9, atol=1e-12)


def test_a_linkage_from_its_unloaded_position():
    """A torque turns a crank whose slider hangs on a spring: T = k (x − x₀) dx/dα is largest where its derivative vanishes."""
    N, (r, l, k, x0) = kn.Frame("N"), (0.3, 0.8, 100.0, 0.9)
    a, b, x, T = kn.coordinate("a"), kn.coordinate("b"), kn.coordinate("x"), kn.parameter("T", 0.0)
    A, B, O = N.rotate("A", a, N.z), N.rotate("B", b, N.z), kn.Point("O", fixed_in=N)
    P, S = O.at("P", r * A.x), O.at("S", x * N.x)
    closing = kn.coincident(P.at("Q", l * B.x), S, along=(N.x, N.y))
    bodies = [kn.Particle("p", P, 1.0), kn.Particle("s", S, 1.0)]
    loads = [kn.Force(S, -k * (x - x0) * N.x), kn.Torque(A, T * N.z)]
    eom = kn.derive(kn.System(N, bodies=bodies, speeds="rates", holonomic=closing, loads=loads))
    branch = kn.continuation(eom, T, [0, 5, 60], q={a: kn.guess(0.5), b: kn.guess(-0.2), x: kn.guess(0.9)}, u=[0, 0, 0])

    def torque(angle):
        across = np.sqrt(l**2 - r**2 * np.sin(angle) ** 2)
        place = r * np.cos(angle) + across
        return k * (place - x0) * (-r * np.sin(angle) * (1 + r * np.cos(angle) / across))

    most = torque(np.linspace(0, np.pi, 200001)).max()
    np.testing.assert_allclose(branch.values, [0, 5, most, 5, 0], rtol=1e-8, atol=1e-9)
    np.testing.assert_allclose([torque(p["a"]) for p in branch.points], branch.values, rtol=1e-8, atol=1e-9)
    assert branch.turning == (2,)
