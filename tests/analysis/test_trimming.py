# SPDX-License-Identifier: BSD-3-Clause
"""Equilibria and steady motions against closed forms; what is said where there is none."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane.gallery import flexible_arm, knife_edge, whipple_bicycle
from tests.examples import examples
from tests.systems import steady as systems

UNIT = st.floats(-6, 6).map(lambda k: 10.0**k)
RATIO = st.floats(-2, 2).map(lambda k: 10.0**k)


@pytest.fixture(scope="module")
def disk():
    return systems.rolling_disk()


@pytest.mark.parametrize(("lean", "rate"), [(0.2, 1.0), (0.5, 2.5), (-0.7, 1.7), (1.1, 4.0)])
def test_steady_turning_of_the_disk(disk, lean, rate):
    """With the yaw rate Ω, 5 Ω² sin q2 cos q2 + 6 Ω q̇3 cos q2 + 4 (g/R) sin q2 = 0 for the thin disk, by moments about the contact."""
    u2 = rate * np.cos(lean)
    point = kn.trim(disk, q={"q2": lean}, u={"u2": u2, "u3": kn.guess(-3.0)})
    rates = dict(zip("12345", disk.evaluate(disk.rates, q=point.q, u=point.u), strict=True))
    assert rates["1"] == pytest.approx(rate, rel=1e-12)
    assert rates["2"] == pytest.approx(0, abs=1e-12)
    left = 5 * rate**2 * np.sin(lean) * np.cos(lean) + 6 * rate * rates["3"] * np.cos(lean)
    assert left == pytest.approx(-4 * 9.81 / 0.3 * np.sin(lean), rel=1e-10)


def test_the_steady_circle_is_kept_by_a_simulation(disk):
    point = kn.trim(disk, q={"q2": 0.4, "q1": 0.0}, u={"u3": -9.0, "u2": kn.guess(1.0)})
    sol = kn.simulate(disk, (0, 2), **point.arguments, rtol=1e-11, atol=1e-11)
    lean = next(i for i, q in enumerate(disk.coordinates) if q.name == "q2")
    assert np.abs(sol.q[:, lean] - 0.4).max() < 1e-7
    assert np.ptp(sol.q[:, -1]) > 0.1


def test_trim_of_an_inverted_pendulum_with_its_motor():
    eom = systems.double_pendulum()
    q = {"q1": np.pi - 0.3, "q2": 0.5}
    point = kn.trim(eom, q=q, u=[0, 0], inputs={"s1": kn.guess(0), "s2": kn.guess(0)})
    g = 9.81
    second = 0.7 * g * 0.4 * np.sin(q["q1"] + q["q2"])
    first = (1.0 * 0.5 + 0.7 * 1.0) * g * np.sin(q["q1"])
    assert point["s2"] == pytest.approx(second, rel=1e-12)
    assert point["s1"] == pytest.approx(first + second, rel=1e-12)
    assert max(np.abs(eom.evaluate(eom.accelerations, **point.arguments))) < 1e-11


def test_equilibrium_of_a_four_bar_holds_its_constraints():
    eom = systems.four_bar()
    point = kn.equilibrium(
        eom, q={"q1": kn.guess(-1.2), "q2": kn.guess(0.5), "q3": kn.guess(-1.0)}, inputs={"tau": 0.4}
    )
    assert max(np.abs(eom.evaluate([c.expr for c in eom.system.holonomic], q=point.q))) < 1e-14
    assert max(np.abs(eom.evaluate(eom.accelerations, **point.arguments))) < 1e-10
    step, best = 1e-5, []  # stationary: V − τ q1 along the constraints
    for d in (-step, step):
        near = kn.assemble(eom, q={s: v + d if s.name == "q1" else kn.guess(v) for s, v in point.q.items()})
        best.append(eom.evaluate(eom.potential_energy, q=near.q, u=near.u) - 0.4 * (point["q1"] + d))
    assert abs(best[1] - best[0]) / (2 * step) < 1e-7


def test_a_parameter_can_be_solved_for():
    """The mass that stretches a spring by 0.3 m."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x = kn.coordinate("x")
    k, m, g = kn.parameter("k", 50.0), kn.parameter("m", 1.0), kn.parameter("g", 9.81)
    P = O.at("P", -x * N.y)
    system = kn.System(
        N, bodies=[kn.Particle("p", P, m)], speeds="rates", loads=[kn.gravity(-g * N.y), kn.Force(P, k * x * N.y)]
    )
    point = kn.equilibrium(kn.derive(system), q={"x": 0.3}, parameters={"m": kn.guess(1.0)})
    assert point["m"] == pytest.approx(50 * 0.3 / 9.81, rel=1e-12)


def test_orientation_by_euler_parameters():
    """A body on springs turns until its spring arm hangs towards the origin."""
    eom = systems.free_body(torsion=4.0)
    values = {"e0": 1.0, "e1": 0.3, "e2": 0.2, "e3": -0.1, "x": -0.5, "y": 0.0, "z": 0.1}
    guess = {name: kn.guess(v) for name, v in values.items()}
    point = kn.equilibrium(eom, q=guess, inputs={"T": 0})
    assert sum(point[f"e{k}"] ** 2 for k in range(4)) == pytest.approx(1, abs=1e-14)
    assert max(np.abs(eom.evaluate(eom.accelerations, **point.arguments))) < 1e-11


@pytest.mark.slow
def test_steady_turning_of_the_bicycle():
    """In a steady turn the contact points follow circles about one vertical axis, and a simulation keeps the lean."""
    eom = kn.derive(whipple_bicycle.system())
    q = dict.fromkeys(("x", "y", "psi", "theta_R", "theta_F"), 0.0) | {
        "phi": 0.2,
        "delta": kn.guess(0.1),
        "theta": kn.guess(0.0),
    }
    point = kn.trim(
        eom,
        q=q,
        u={"u1": 0.0, "u4": 0.0, "u5": -6.0 / 0.3, **{f"u{k}": kn.guess(0.0) for k in (2, 3)}},
        inputs={"T_phi": 0, "T_delta": kn.guess(0.0)},
        independent=("u1", "u4", "u5"),
    )
    assert abs(point["delta"]) > 0.01
    sol = kn.simulate(eom, (0, 0.5), **point.arguments, rtol=1e-10, atol=1e-10)
    lean = next(i for i, s in enumerate(eom.coordinates) if s.name == "phi")
    assert np.abs(sol.q[:, lean] - 0.2).max() < 1e-6
    yaw = next(i for i, s in enumerate(eom.coordinates) if s.name == "psi")
    assert abs(sol.q[-1, yaw]) > 0.1


# Messages -----------------------------------------------------------------------------------------------------------------


def test_which_acceleration_remains(disk):
    with pytest.raises(
        kn.SimulationError,
        match=r"after \d+ steps the residuals are u1' = -10\.18.*The unknowns were .*u4, u5\. Give better guesses",
    ):
        kn.trim(disk, q={"q2": 0.4}, u={"u1": 0, "u3": -9.0, "u2": 0.0})
    eom = systems.cart()
    with pytest.raises(kn.SimulationError, match=r"the residuals are u1' = 1, u2' = -1\.42857"):
        kn.equilibrium(eom, q={"q1": 0, "q2": 0}, inputs={"F": 2.0})


def test_too_little_is_given(disk):
    with pytest.raises(kn.ValueMissingError, match=r"got too few: u2 can still have other values"):
        kn.trim(disk, q={"q2": kn.guess(0.4)}, u={"u3": 3})
    with pytest.raises(kn.ValueMissingError, match=r"got none for F: give a number to keep it, or kn\.guess"):
        kn.trim(systems.cart(), q=[0, 0], u=[0, 0])
    with pytest.raises(kn.ValueMissingError, match=r"moving= to name coordinates, speeds or states, got z"):
        kn.trim(systems.cart(), q=[0, 0], u=[0, 0], inputs={"F": 0}, moving=["z"])


def test_moving_lets_an_acceleration_remain():
    """A cart that is pushed accelerates steadily while its pendulum hangs back: tan q2 = −F/((M + m) g)."""
    eom = systems.cart()
    point = kn.trim(eom, q={"q1": 0, "q2": kn.guess(0)}, u=[0, 0], inputs={"F": 3.0}, moving=["u1"])
    assert np.tan(point["q2"]) == pytest.approx(-3.0 / (2.5 * 9.81), rel=1e-12)


def test_the_time_of_a_point_goes_with_it():
    """m ẍ = −k(t) (x − sin t), k(t) = 2 + cos t: about x = 0 it swings with k = 1 at t = π, with k = 3 at t = 0."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x = kn.coordinate("x")
    P = O.at("P", x * N.x)
    pull = kn.Force(P, -(2 + kn.cos(kn.time)) * (x - kn.sin(kn.time)) * N.x)
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("p", P, 1.0)], speeds="rates", loads=[pull]))
    point = kn.trim(eom, q={x: kn.guess(0.3)}, u=[0], t=np.pi)
    assert point.arguments["t"] == np.pi
    np.testing.assert_allclose(np.abs(kn.linearize(eom, **point.arguments, steady=False).eigenvalues), 1, rtol=1e-9)
    assert eom.evaluate(eom.accelerations[0], **point.arguments) == pytest.approx(0, abs=1e-12)
    first = kn.trim(eom, q={x: kn.guess(0.3)}, u=[0])
    assert "t" not in first.arguments
    np.testing.assert_allclose(
        np.abs(kn.linearize(eom, **first.arguments, steady=False).eigenvalues), np.sqrt(3), rtol=1e-9
    )
    with pytest.raises(
        kn.SimulationError, match=r"begins at the time of the start values, t = 3\.14159265, got one from 0\."
    ):
        kn.simulate(eom, (0, 1), **point.arguments)
    assert kn.simulate(eom, (np.pi, 4), **point.arguments).t[0] == np.pi


@examples(0.1)
@given(
    st.sampled_from(["polynomials", "legendre"]),
    st.integers(3, 6),
    st.floats(0, 5),
    st.sampled_from([0.0, 1e-3, 0.1]),
    st.floats(-9, -3).map(lambda k: 10.0**k),
    st.tuples(UNIT, UNIT, UNIT),
    st.booleans(),
)
def test_a_cantilever_under_its_weight(family, count, heavy, soft, bent, units, guessed):
    """w L⁴/(8 EI) + w L²/(2 k_s GA) by the weight w per length, P L³/(3 EI) + P L/(k_s GA) by a body at the tip, in any units.

    Polynomials have both shapes. `heavy` is the mass of the body over the beam's, `soft` is EI/(k_s GA L²), `bent` is w L³/EI.
    """
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    length, mass, time = units
    g = length / time**2
    EI = mass * g * length**2 / bent
    more = {}
    if soft:
        shapes = kn.mode_shapes("rod polynomials", count - 1)
        more = {"shear": EI / (soft * length**2), "shear_modes": shapes, "rotary": 1e-3 * mass * length}
    shapes = kn.mode_shapes(family, count)
    beam = kn.Beam(
        "beam",
        O,
        frame=N,
        axis=N.x,
        along=N.y,
        length=length,
        mass_per_length=mass / length,
        EI=EI,
        modes=shapes,
        **more,
    )
    tip = beam.point_at(1)
    bodies = [beam, kn.Particle("body", tip, heavy * mass)] if heavy else [beam]
    eom = kn.derive(kn.System(N, bodies=bodies, loads=[kn.gravity(-g * N.y)]))
    q = {c: kn.guess(0.0) for c in eom.coordinates} if guessed else None
    expected = -bent * length * (1 / 8 + soft / 2 + heavy * (1 / 3 + soft))
    for point in (kn.equilibrium(eom, q=q), kn.trim(eom, q=q)):
        assert eom.evaluate(tip.position(O).dot(N.y), **point.arguments) == pytest.approx(expected, rel=1e-9)


@examples(0.3)
@given(st.lists(st.tuples(RATIO, RATIO), min_size=1, max_size=6), st.tuples(UNIT, UNIT, UNIT))
def test_masses_that_hang_on_springs(links, units):
    """A spring is stretched by the weight below it over its stiffness, in any units."""
    length, mass, time = units
    g = length / time**2
    links = [(stiffness * mass / time**2, m * mass) for stiffness, m in links]
    N = kn.Frame("N")
    above, bodies, loads = kn.Point("O", fixed_in=N), [], [kn.gravity(-g * N.y)]
    x = kn.coordinates(f"x1:{len(links) + 1}")
    for i, (stretch, (stiffness, mass)) in enumerate(zip(x, links, strict=True), 1):
        below = above.at(f"P{i}", -stretch * N.y)
        bodies.append(kn.Particle(f"b{i}", below, mass))
        loads += [kn.Force(below, stiffness * stretch * N.y), kn.Force(above, -stiffness * stretch * N.y)]
        above = below
    eom = kn.derive(kn.System(N, bodies=bodies, loads=loads, speeds="rates"))
    weights = np.cumsum([g * m for _, m in links[::-1]])[::-1]
    for point in (kn.equilibrium(eom), kn.trim(eom)):
        np.testing.assert_allclose([point[c] for c in x], weights / [k for k, _ in links], rtol=1e-9)


def test_contacts_that_are_closed_are_said():
    """Equations of no mode have no force of contacts: a warning where one is closed, none of a stop that is open, none in a mode."""
    x, u = kn.coordinate("x"), kn.speed("u")
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    P = O.at("P", x * N.x)
    stop = kn.joints.stop("wall", x + 1)
    system = kn.System(
        N, bodies=[kn.Particle("A", P, 1.0)], speeds={u: x.dt}, loads=[kn.Force(P, -x * N.x)], contacts=[stop]
    )
    eom = kn.derive(system)
    assert kn.trim(eom).q[x] == 0
    with pytest.warns(kn.KaneWarning, match="Expected contacts that are open, got 'wall' closed"):
        kn.linearize(eom, q=[-1], u=[0], steady=False)
    held = kn.derive(system.in_modes({"wall": "stick"}))
    assert kn.trim(held, q=[-1]).q[x] == -1


@pytest.mark.parametrize("metre", [1.0, 1e3, 1e-5])
def test_what_nothing_depends_on_stays_where_it_starts(metre):
    """A knife edge on a slope rests across it at any place: one that is left out is the origin, and a guessed one is kept."""
    eom = kn.derive(knife_edge.system())
    units = {"m/s^2": metre, "kg*m^2": metre**2, "m": metre}
    parameters = {p: p.default * units.get(p.unit, 1.0) for p in eom.parameters}
    across = kn.equilibrium(eom, parameters=parameters)
    assert (across["x"], across["y"]) == (0, 0)
    assert abs(np.sin(across["theta"])) == pytest.approx(1)
    there = kn.equilibrium(eom, q={"x": kn.guess(0.4 * metre), "y": -2 * metre}, parameters=parameters)
    assert (there["x"], there["y"]) == (0.4 * metre, -2 * metre)


@pytest.mark.parametrize("metre", [1.0, 1e3, 1e-3, 1e-6])
def test_an_arm_without_weight_rests_straight_at_any_angle_of_its_elbow(metre):
    eom = kn.derive(flexible_arm.system())
    length = {"m": 1, "kg": 0, "kg/m": -1, "N*m": 2, "N*m^2": 3}
    parameters = {p: p.default * metre ** length[p.unit] for p in eom.parameters}
    with pytest.raises(kn.ValueMissingError, match="too few: q_2 can still have other values"):
        kn.equilibrium(eom, parameters=parameters)
    assert list(kn.equilibrium(eom, q={"q_2": 0.4}, parameters=parameters).q.values()) == [0, 0.4, 0, 0, 0, 0]
