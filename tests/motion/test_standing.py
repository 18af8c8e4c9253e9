# SPDX-License-Identifier: BSD-3-Clause
"""Bodies that stand on more points of a plane than determine their forces: they move where no forces hold them."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy import sparse

import kane as kn
from tests.peer import require

G, MASS, HEIGHT, MU = 9.81, 2.0, 0.5, 0.5
FEET = ((0.3, 0.0), (-0.2, 0.3), (-0.2, -0.3))
CORNERS = ((0.3, 0.2), (0.3, -0.2), (-0.3, 0.2), (-0.3, -0.2))
LINE = ((0.3, 0.0), (0.0, 0.0), (-0.3, 0.0))
NEARLY = ((0.3, -0.1), (-0.3, -0.1), (0.05, -0.1 + 1e-5), (0.0, 0.3))
"""Three of them nearly in a line: which hold the fourth is not told by the first three."""
TIGHT = {"rtol": 1e-10, "atol": 1e-12}
P = kn.parameter("P", 0.0, "N/s")
AT = (0.1, -0.15)
"""Where a force P t along x pulls, at the height of the mass centre's foot point."""


@cache
def box(points: Sequence[tuple[float, float]], static: float = MU) -> kn.Equations:
    """A body on an incline of a given slope, on points below its mass centre."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    I = N.rotate("I", kn.parameter("slope", 0.0), N.y)
    x, y, z, a, b, c = kn.coordinates("x y z a b c")
    B = I.rotate_body("B", [a, b, c], "321")
    C = O.at("C", x * I.x + y * I.y + z * I.z)
    contacts = []
    for k, (px, py) in enumerate(points):
        foot = C.fixed_in(B, f"F{k}", px * B.x + py * B.y - HEIGHT * B.z)
        contacts.append(kn.contact(kn.joints.point_on_plane(f"c{k}", foot, O, normal=I.z), MU, static=static))
    pulled = C.fixed_in(B, "A", AT[0] * B.x + AT[1] * B.y - HEIGHT * B.z)
    body = kn.RigidBody("box", frame=B, mass_center=C, mass=MASS, inertia=kn.inertia(B, 0.2, 0.3, 0.4))
    loads = [kn.gravity(-G * N.z), kn.Force(pulled, P * kn.time * I.x)]
    return kn.derive(kn.System(N, bodies=[body], speeds="rates", loads=loads, contacts=contacts))


REST = {"q": [0, 0, HEIGHT, 0, 0, 0], "u": [0] * 6}


def forces(sol: kn.Solution, k: int = -1) -> tuple[Any, Any]:
    """N (n) and F (n × 2) at an output."""
    contacts = sol.equations.system.contacts
    n = [float(sol[c.normal_force][k]) for c in contacts]
    return np.array(n), np.array([[float(sol[f][k]) for f in c.friction_forces] for c in contacts])


@pytest.mark.parametrize("points", [*(pytest.param(p, marks=pytest.mark.slow) for p in (FEET, LINE)), CORNERS, NEARLY])
def test_what_stands_moves_exactly_zero(points: Any) -> None:
    sol = kn.simulate(box(points), (0, 1000), parameters={"slope": 0.2}, **REST)
    assert sol.status == "finished"
    assert set(np.unique([sol.modes[f"c{k}"] for k in range(len(points))])) == {"stick"}
    np.testing.assert_array_equal(sol.q - sol.q[0], 0)
    n, f = forces(sol)
    r = np.array(points)
    assert n.sum() == pytest.approx(MASS * G * np.cos(0.2), rel=1e-12)
    assert f.sum(axis=0) == pytest.approx([-MASS * G * np.sin(0.2), 0], abs=1e-11)
    assert (np.linalg.norm(f, axis=1) < MU * n).all()
    # moments about the mass centre
    assert n @ r[:, 0] == pytest.approx(-HEIGHT * f.sum(axis=0)[0], abs=1e-11)
    assert n @ r[:, 1] == pytest.approx(0, abs=1e-11)
    assert (r[:, 0] * f[:, 1] - r[:, 1] * f[:, 0]).sum() == pytest.approx(0, abs=1e-11)


@pytest.mark.parametrize("points", [FEET, pytest.param(CORNERS, marks=pytest.mark.slow)])
def test_a_body_slides_down_and_stops(points: Any) -> None:
    a = G * (np.sin(0.55) - MU * np.cos(0.55))
    sol = kn.simulate(box(points), (0, 1), parameters={"slope": 0.55}, **REST, **TIGHT)
    assert sol["x"][-1] == pytest.approx(a / 2, abs=1e-10)
    a = G * (MU * np.cos(0.1) - np.sin(0.1))
    sol = kn.simulate(box(points), (0, 1), parameters={"slope": 0.1}, q=REST["q"], u=[0.5, 0, 0, 0, 0, 0], **TIGHT)
    assert sol["x"][-1] == pytest.approx(0.125 / a, abs=1e-10)
    assert np.abs(sol.u[-1]).max() < 1e-11


@pytest.mark.parametrize("beside", [0.0, 1e-12, 1e-9])
def test_slips_that_end_together_end_whatever_rounding_leaves(beside: float) -> None:
    """A tripod slides on two feet: one sticks first by rounding, and the slow slip of the other has an end, too."""
    along = 1.3 * np.array([-np.cos(beside), np.sin(beside)])
    sol = kn.simulate(box(FEET), (0, 0.25), q=REST["q"], u=[*along, 0, 0, 0, 0], rtol=1e-6, atol=1e-8, max_seconds=60)
    assert sol.status == "finished", sol.message
    assert [list(m.values()) for _, m in sol.mode_history][-1] == ["separated", "stick", "stick"]
    assert sol["y"][-1] == pytest.approx(0, abs=1e-9)
    assert len({round(t, 7) for t, m in sol.mode_history if "stick" in m.values()}) == 1
    held = sol.modes["c1"] == "stick"
    np.testing.assert_allclose(sol.energy[held], sol.energy[-1], atol=1e-6)  # it turns about both feet


def largest(points: Any) -> float:
    """The largest pull that forces within the cones hold: a conic problem in the pull, N and F."""
    k = len(points)
    width = 1 + 3 * k
    at, r = np.array(AT), np.array(points)
    sums = np.zeros((6, width))
    given = np.array([0, 0, MASS * G, 0, 0, 0])
    for i, (x, y) in enumerate(r):
        n, fx, fy = 1 + 3 * i + np.arange(3)
        sums[0, fx] = sums[1, fy] = sums[2, n] = 1
        sums[3, n], sums[3, fy] = y, HEIGHT
        sums[4, n], sums[4, fx] = -x, -HEIGHT
        sums[5, fy], sums[5, fx] = x, -y
    sums[:, 0] = [1, 0, 0, 0, -HEIGHT, -at[1]]
    cone = np.zeros((3 * k, width))
    for i in range(k):
        cone[3 * i, 1 + 3 * i], cone[3 * i + 1, 2 + 3 * i], cone[3 * i + 2, 3 + 3 * i] = -MU, -1, -1
    clarabel = require("clarabel")
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    for name in ("tol_gap_abs", "tol_gap_rel", "tol_feas"):
        setattr(settings, name, 1e-12)
    cones = [clarabel.ZeroConeT(6), *[clarabel.SecondOrderConeT(3)] * k]
    cost = np.zeros(width)
    cost[0] = -1.0
    rows = sparse.csc_matrix(np.vstack([sums, cone]))
    right = np.append(given, np.zeros(3 * k))
    solver = clarabel.DefaultSolver(sparse.csc_matrix((width, width)), cost, rows, right, cones, settings)
    return float(solver.solve().x[0])


@pytest.mark.slow
@pytest.mark.filterwarnings(
    "ignore:Expected one mode of the contacts:kane.KaneWarning"
)  # how corners share N is one of many
@pytest.mark.parametrize("points", [FEET, CORNERS])
def test_a_pull_beside_the_middle_moves_it_where_no_forces_hold(points: Any) -> None:
    """The limit of all distributions, not of one: beside a conic solver."""
    most = largest(points)
    sol = kn.simulate(box(points, 0.500001), (0, 2 * most), parameters={"P": 1.0}, max_seconds=60, **REST, **TIGHT)
    slips = [t for e, t in sol.events if e.name.endswith(("slips", "opens"))]
    moves = sol.t[np.flatnonzero(np.abs(sol.u).max(axis=1) > 0)[0]]
    assert slips
    last = max(t for t in slips if t <= moves + 1e-9)
    assert last == pytest.approx(most, rel=3e-6)  # μ_s is so much larger


DROPPED = (
    # a foot rebounds while another lands; its gap is less than rounding of it, its speed is upward
    (
        0.08925840733949875,
        [0, 0, 0.794525762764591, 0.23396133343231235, 0.19342429652584225, -0.012007245715300707],
        [0.5026828498748657, 0.989713033285805, 0, 0, 0, 0],
    ),
    # a foot's slip ends while another's normal force, which depends on its direction, vanishes; then slips begin that turn
    (
        0.050409206149430896,
        [0, 0, 0.7665288295306796, 0.17225898449321003, -0.1563783342042287, 0.22589053848642232],
        [-1.2883614637495544, 0.39512206018200824, 0, 0.42986369482223, 0.6960427239628685, -1.184117966757189],
    ),
)


@pytest.mark.slow
@pytest.mark.parametrize(("slope", "q", "u"), DROPPED, ids=["rebounds", "turns"])
def test_a_dropped_tripod_does_not_hop(slope: float, q: list[float], u: list[float]) -> None:
    """Feet without restitution: the motion goes on past the instants at which feet close, open and stick together."""
    sol = kn.simulate(box(FEET), (0, 2), parameters={"slope": slope}, q=q, u=u, **TIGHT)
    assert sol.status == "finished", sol.message
    size = np.abs(sol.energy).max()
    assert np.diff(sol.energy).max() < 1e-8 * size
    times = np.array([t for _, t in sol.events])
    assert np.diff(np.sort(times)[::10]).min() > 0  # no ten changes at one instant
    for c in sol.equations.system.contacts:
        assert c.gap is not None
        modes, gap, n = sol.modes[c.name], sol[c.gap.expr], sol[c.normal_force]
        assert gap.min() > -1e-10
        assert np.abs(gap[modes != "separated"]).max(initial=0) < 1e-10
        f = np.linalg.norm([sol[x] for x in c.friction_forces], axis=0)
        inside = sol.phase == np.append(
            sol.phase[1:], -1
        )  # where a slip ends its direction turns within rounding of times, and normal forces change with it
        assert n[inside].min() > -1e-9 * size
        assert n.min() > -1e-8 * size
        assert (f <= MU * n * (1 + 1e-9) + 1e-9 * size)[inside].all()


@cache
def table(feet: int) -> kn.Equations:
    """A body of 2 kg that falls on feet, whose places, inertia, friction and restitution are parameters."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, y, z, a, b, c = kn.coordinates("x y z a b c")
    B = N.rotate_body("B", [a, b, c], "312")
    C = O.at("C", x * N.x + y * N.y + z * N.z)
    inertia = kn.inertia(B, *(kn.parameter(f"I{k}", 0.1 + 0.02 * k, "kg*m^2") for k in range(3)))
    mu, e, h = kn.parameter("mu", 0.5, "1"), kn.parameter("e", 0.0, "1"), kn.parameter("h", 0.3, "m")
    contacts = []
    for k, (px, py) in enumerate(((0.5, 0.07), (-0.31, 0.43), (-0.22, -0.45), (0.3, -0.33))[:feet]):
        place = kn.parameter(f"x{k}", px, "m") * B.x + kn.parameter(f"y{k}", py, "m") * B.y - h * B.z
        foot = kn.joints.point_on_plane(f"f{k}", C.fixed_in(B, f"F{k}", place), O, normal=N.z)
        contacts.append(kn.contact(foot, mu, restitution=e))
    body = kn.RigidBody("table", frame=B, mass_center=C, mass=MASS, inertia=inertia)
    return kn.derive(kn.System(N, bodies=[body], speeds="rates", loads=[kn.gravity(-G * N.z)], contacts=contacts))


def thrown(seed: int, feet: int) -> tuple[dict[str, float], list[float], list[float]]:
    """Parameters of a table, and how it is thrown."""
    rng = np.random.default_rng(seed)
    angles = 2 * np.pi * np.arange(feet) / feet + rng.uniform(-0.3, 0.3, feet)
    radii = rng.uniform(0.3, 0.8, feet) if feet == 3 else np.full(feet, rng.uniform(0.3, 0.8))
    h, off = rng.uniform(0.1, 0.6), rng.uniform(-0.1, 0.1, 2)
    i1, i2 = rng.uniform(0.05, 0.3, 2)
    given = {"I0": i1, "I1": i2, "I2": 0.7 * (i1 + i2), "mu": rng.uniform(0.2, 0.8), "e": rng.uniform(0, 0.5), "h": h}
    given |= {f"x{k}": float(x) for k, x in enumerate(radii * np.cos(angles) - off[0])}
    given |= {f"y{k}": float(y) for k, y in enumerate(radii * np.sin(angles) - off[1])}
    q = [0, 0, h + 0.15, rng.uniform(-1, 1), *rng.uniform(-0.1, 0.1, 2)]
    u = [*rng.uniform(-1.5, 1.5, 2), rng.uniform(-1, 0), rng.uniform(-3, 3), *rng.uniform(-1, 1, 2)]
    return given, q, u


@pytest.mark.slow
@pytest.mark.parametrize("feet", [3, 4])
@pytest.mark.parametrize("seed", [*range(6), 19])
def test_laws_hold_of_tables_that_are_thrown(feet: int, seed: int) -> None:
    """They turn about feet that stick while others slip: at each output N ≥ 0, |F| ≤ μ N, no foot below the floor, energy falls."""
    eom = table(feet)
    given, q, u = thrown(seed, feet)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", kn.KaneWarning)  # that several modes agree with the laws
        sol = kn.simulate(eom, (0, 2), q=q, u=u, parameters=given)
    assert sol.status == "finished", sol.message
    for c in eom.system.contacts:
        assert c.gap is not None
        n, f = sol[c.normal_force], np.hypot(*(sol[f] for f in c.friction_forces))
        assert sol[c.gap.expr].min() > -1e-10
        slack = 3e-6 * MASS * G  # where a slip is slow its direction, and N with it, has few digits
        assert n.min() > -slack
        assert (f - given["mu"] * n).max() < slack
    assert np.diff(sol.energy).max() < 1e-5
