# SPDX-License-Identifier: BSD-3-Clause
"""Limit cycles: derivatives beside differences of whole motions, constraints, branches, sections, what is refused."""

import numpy as np
import pytest
from scipy.linalg import expm

import kane as kn
from kane.gallery import mass_on_belt, rimless_wheel, simplest_walker

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)


def differenced(cycle, step=1e-4):
    """∂P/∂x over all components, by central differences of fourth order of whole motions."""
    run, constants = cycle.map, cycle.shooting.constants

    def column(e):
        ends = [run(cycle.x + k * step * e, constants).states[-1] for k in (-2, -1, 1, 2)]
        return (ends[0] - 8 * ends[1] + 8 * ends[2] - ends[3]) / (12 * step)

    return np.column_stack([column(e) for e in np.eye(len(cycle.x))])


def oscillator(force, **more):
    x, u = kn.coordinate("x"), kn.speed("u")
    P = O.at("P", x * N.x)
    own = force(x, u)
    bodies = [kn.Particle("P", P, 1)]
    return kn.derive(kn.System(N, bodies=bodies, speeds={u: x.dt}, loads=[kn.Force(P, own * N.x)], **more)), x, u


def van_der_pol(**more):
    return oscillator(lambda x, u: kn.parameter("mu", 1.0) * (1 - x**2) * u - x, **more)


def turns(u):
    return kn.Event("turns", u, direction=-1)


# Forced -----------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["in the load", "expression", "function"])
def test_forced_oscillator(kind):
    """Multipliers are exp(A T), the start is that of the closed form."""
    w, damping, k = 1.7, 0.3, 2.0
    F = kn.input("F")
    law = kn.cos(w * kn.time)
    eom, _, _ = oscillator(lambda x, u: (law if kind == "in the load" else F) - k * x - damping * u)
    inputs = {"expression": {F: law}, "function": {F: lambda t: np.cos(w * t)}}.get(kind)
    length = 2 * np.pi / w
    cycle = kn.limit_cycle(eom, q=[0], u=[0], period=length, inputs=inputs)
    swing = 1 / (k - w**2 + 1j * w * damping)
    assert np.allclose(cycle.x, [swing.real, (1j * w * swing).real], rtol=0, atol=1e-12)
    assert np.allclose(cycle.matrix, expm(np.array([[0, 1], [-k, -damping]]) * length), rtol=0, atol=1e-12)
    assert cycle.stable


def test_impacts_by_an_action_and_a_function():
    """A driven mass against a stop: an action by expressions, the same by a function, and differences of motions."""
    u = kn.speed("u")

    def swung(then):
        x = kn.coordinate("x")
        P = O.at("P", x * N.x)
        hit = kn.Event("hit", x - 0.3, direction=1, then=then)
        loads = [kn.Force(P, (kn.cos(2 * kn.time) - x - 0.2 * u) * N.x)]
        return kn.derive(kn.System(N, bodies=[kn.Particle("P", P, 1)], speeds={u: x.dt}, loads=loads, events=[hit]))

    first = kn.limit_cycle(swung({u: -0.6 * u}), q=[0.0], u=[-0.5], period=np.pi)
    assert len(first.solution.events) > 0
    assert np.allclose(first.matrix, differenced(first), rtol=0, atol=1e-7)
    other = kn.limit_cycle(swung(lambda u, **_: {name: -0.6 * v for name, v in u.items()}), first.start, period=np.pi)
    assert np.allclose(first.matrix, other.matrix, rtol=0, atol=1e-10)


def test_impact_with_friction():
    """A ball with spin on a table that shakes up and down: impacts with friction, beside differences of motions."""
    x, y, a = kn.coordinate("x", "m"), kn.coordinate("y", "m"), kn.coordinate("a", "rad")
    B = N.rotate("B", a, N.z)
    C = O.at("C", x * N.x + y * N.y)
    ball = kn.RigidBody("ball", frame=B, mass_center=C, mass=1, inertia=kn.inertia(B, 0.004, 0.004, 0.004))
    table = O.at("table", kn.parameter("A", 0.01, "m") * kn.sin(kn.parameter("W", 40.0, "rad/s") * kn.time) * N.y)
    floor = kn.contact(
        kn.joints.sphere_on_plane("floor", B, C, table, radius=kn.parameter("R", 0.1, "m"), normal=N.y),
        0.3,
        restitution=0.4,
    )
    pull = kn.Force(C, (-kn.parameter("k", 30.0, "N/m") * x - kn.parameter("c", 4.0, "N*s/m") * x.dt) * N.x)
    brake = kn.Torque(B, -kn.parameter("d", 0.02, "N*m*s") * a.dt * N.z)
    loads = [kn.gravity(-kn.parameter("g", 9.81, "m/s^2") * N.y), pull, brake]
    eom = kn.derive(kn.System(N, bodies=[ball], speeds="rates", loads=loads, contacts=[floor], coordinates=(x, y, a)))
    length = 2 * np.pi / 40
    phase = np.arccos(9.81 * length / 2 * 0.6 / 1.4 / 0.4)
    top = 0.1 + 0.01 * np.sin(phase) + 9.81 * length**2 / 8
    cycle = kn.limit_cycle(eom, q=[0, top, 0], u=[0, 0, 0], period=length, t=phase / 40 + length / 2, cyclic=[a])
    assert abs(cycle.x[1] - top) < 1e-12
    whole = cycle.map.differential(cycle.solution).x
    kept = [0, 1, 3, 4, 5]
    assert np.allclose(whole[np.ix_(kept, kept)], differenced(cycle, 1e-5)[np.ix_(kept, kept)], rtol=0, atol=1e-6)


# Constraints ------------------------------------------------------------------------------------------------------------


def swing(constrained):
    """A damped pendulum whose pivot is shaken sideways, by its angle or by two coordinates with a rod between them."""
    m, l, g, c, w = 1.0, kn.parameter("l", 1.0, "m"), 9.81, 0.4, kn.parameter("w", 2.0, "rad/s")
    shake = 0.2 * kn.parameter("b", 1.0, "m") * kn.sin(w * kn.time)
    pivot = O.at("pivot", shake * N.x)
    gravity = kn.gravity(-kn.parameter("g", g, "m/s^2") * N.y)
    drag = kn.parameter("c", c, "N*s/m")
    mass = kn.parameter("m", m, "kg")
    if not constrained:
        a = kn.coordinate("a", "rad")
        P = pivot.at("P", -l * N.rotate("A", a, N.z).y)
        loads = [gravity, kn.Force(P, -drag * P.velocity(N))]
        return kn.derive(kn.System(N, bodies=[kn.Particle("P", P, mass)], speeds="rates", loads=loads))
    x, y = kn.coordinate("x", "m"), kn.coordinate("y", "m")
    P = O.at("P", x * N.x + y * N.y)
    loads = [gravity, kn.Force(P, -drag * P.velocity(N))]
    rod = kn.distance(pivot, P, l)
    system = kn.System(N, bodies=[kn.Particle("P", P, mass)], speeds="rates", loads=loads, holonomic=[rod])
    return kn.derive(system, near={x: 0.0, y: -1.0})


def test_constraints_leave_the_same_multipliers():
    """By one angle, and by two coordinates on a circle."""
    plain = kn.limit_cycle(swing(False), q=[0.0], u=[0.0], period=np.pi)
    held = kn.limit_cycle(
        swing(True), q={"x": kn.guess(0), "y": kn.guess(-1)}, u={"u_x": 0, "u_y": kn.guess(0)}, period=np.pi
    )
    assert len(held.names) == len(held.multipliers) == 2
    assert np.allclose(held.multipliers, plain.multipliers, rtol=0, atol=1e-10)
    assert np.isclose(held.x[0], np.sin(plain.x[0]), rtol=0, atol=1e-11)


def test_actions_under_constraints():
    """A blow that takes 30 % of the speed where the pendulum passes a line, by one angle and by two coordinates."""
    plain, held = swing(False), swing(True)
    (a,) = plain.coordinates
    (u,) = plain.speeds
    x, _ = held.coordinates
    v, w = held.speeds
    place = 0.2 * kn.parameter("b", 1.0, "m") * kn.sin(kn.parameter("w", 2.0, "rad/s") * kn.time)
    hit = kn.Event("blow", a, direction=1, then={u: 0.7 * u})
    one = kn.limit_cycle(kn.derive(plain.system.replace(events=[hit])), q=[0.1], u=[0.2], period=np.pi)
    # along the rod's tangent at the line, where y' vanishes beside the pivot's speed
    pivot = kn.expr.time_derivative(place)
    hit = kn.Event("blow", x - place, direction=1, then={v: 0.7 * v + 0.3 * pivot})
    two = kn.derive(held.system.replace(events=[hit]), near={"x": 0.0, "y": -1.0})
    start = np.array([0.2 * 0 + np.sin(one.x[0]), -np.cos(one.x[0])])
    speeds = np.array([0.4 + np.cos(one.x[0]) * one.x[1], np.sin(one.x[0]) * one.x[1]])
    other = kn.limit_cycle(two, q=start, u=speeds, period=np.pi)
    assert len(other.solution.events) == len(one.solution.events) > 0
    assert np.allclose(other.multipliers, one.multipliers, rtol=0, atol=1e-9)
    assert w is not v


# Sections, branches ---------------------------------------------------------------------------------------------------------


def test_the_section_does_not_change_the_multipliers():
    """Of one cycle by two sections, and by one that is given and one of the system."""
    eom, x, u = van_der_pol()
    one = kn.limit_cycle(eom, q=[2.0], u=[0], section=turns(u))
    two = kn.limit_cycle(eom, q=[0], u=[2.2], section=kn.Event("passes", x, direction=1))
    assert abs(one.period - two.period) < 1e-11
    assert np.allclose(one.multipliers, two.multipliers, rtol=1e-9)


def test_parameter_slopes():
    """The derivative of the return map by a parameter, beside differences."""
    eom = kn.derive(simplest_walker.system())
    cycle = kn.limit_cycle(eom, section="strike", **simplest_walker.START)
    (gamma,) = [p for p in eom.parameters if p.name == "gamma"]
    found = cycle.map.differential(cycle.solution, (gamma,))
    constants, h = cycle.shooting.constants, 1e-5
    ends = [cycle.map(cycle.x, {**constants, gamma: 0.009 + k * h}) for k in (-2, -1, 1, 2)]
    weights = np.array([1, -8, 8, -1]) / (12 * h)
    assert np.allclose(found.x[:, -1], weights @ [m.states[-1] for m in ends], rtol=1e-7)
    assert np.isclose(found.t[-1], weights @ [m.t[-1] for m in ends], rtol=1e-7)
    # an angle alone would leave the feet above each other
    assert np.allclose(found.x[:, [1, 3]], differenced(cycle, 2e-5)[:, [1, 3]], rtol=0, atol=1e-8)


@pytest.mark.slow
def test_a_branch_turns_back():
    """Duffing's oscillator by its forcing: the folds are where the response of first order turns, to a few percent."""
    w = kn.parameter("w", 1.0)
    eom, _, _ = oscillator(lambda x, u: 0.3 * kn.cos(w * kn.time) - 0.1 * u - x - x**3)
    cycle = kn.limit_cycle(eom, q=[0.4], u=[0], period=2 * kn.pi / w)
    branch = cycle.follow(w, 2.2)
    assert len(branch.turning_points) == 2
    high, low = branch.turning_points
    assert [c.kind for c in branch.changes] == ["fold", "fold"]
    assert np.allclose([c.value for c in branch.changes], [high, low], rtol=1e-8)
    assert high > low > 1.2
    assert branch.stable.tolist().count(False) > 0
    assert "turning points" in repr(branch)
    assert len(kn.figures.root_locus(branch).axes) >= 3


def test_poincare():
    eom = kn.derive(simplest_walker.system())
    points = kn.poincare(eom, section="strike", count=40, q=[0.19], u=[-0.195], states=[0.38, -0.0139])
    assert len(points) == 40
    assert abs(points["theta"][-1] - 0.20031090054424708936) < 1e-7
    assert np.all(np.diff(points.t) > 3)
    falls = kn.poincare(eom, section="strike", count=40, q=[0.19], u=[-0.05], states=[0.38, 0.0])
    assert len(falls) < 40
    assert "section" in falls.message


def test_a_start_that_sticks():
    """The cycle of the mass on a belt from a section where it sticks: the constraint leaves one component, which the section takes."""
    eom = kn.derive(mass_on_belt.system())
    x, u = eom.coordinates[0], eom.speeds[0]
    slips = kn.limit_cycle(eom, q=[0.16], u=[0], section=turns(u))
    sticks = kn.limit_cycle(eom, q=[0.05], u=[0.2], section=kn.Event("passes", x, threshold=0.05, direction=1))
    assert abs(slips.period - sticks.period) < 1e-11
    assert sticks.names == ("x",)
    assert len(sticks.multipliers) == 0
    assert sticks.stable


def test_what_goes_on_is_cyclic():
    """A rimless wheel that counts its steps."""
    n = kn.state("n")
    system = rimless_wheel.system()
    (strike,) = system.events
    counted = kn.Event("strike", strike.quantity, direction=1, then={**strike.then, n: n + 1})
    eom = kn.derive(system.replace(events=[counted], states={n: 0 * n}))
    cycle = kn.limit_cycle(eom, section="strike", cyclic=["n"], **rimless_wheel.START)
    assert np.allclose(cycle.multipliers, [0.5], rtol=1e-10)
    assert cycle.solution["n"][-1] == 1
    walker = kn.derive(simplest_walker.system())
    with pytest.raises(kn.SimulationError, match="on which nothing else depends"):
        kn.limit_cycle(walker, section="strike", cyclic=["u_theta"], **simplest_walker.START)


# What is refused ------------------------------------------------------------------------------------------------------------


def test_bad_input():
    eom, x, u = van_der_pol()
    start = {"q": [2.0], "u": [0.0]}
    cases = [
        (start, {"section": kn.Event("far", x - 50, direction=1)}, "start on the section 'far'"),
        ({"q": [2.0], "u": [0.3]}, {"section": turns(u)}, "start on the section 'turns'"),
        (start, {"period": -1.0}, "period > 0"),
        (start, {"period": 6.66}, "Expected equations that depend on time"),
        (start, {}, "got neither"),
        (start, {"section": turns(u), "period": 1.0}, "got both"),
        (start, {"section": "no"}, "section= as an event"),
        (start, {"period": "long"}, "period= as a number"),
        (start, {"section": turns(u), "within": "long"}, "within as a number"),
        (start, {"section": turns(u), "rtol": 0.0}, "rtol > 0"),
        (start, {"section": turns(u), "max_steps": 0.5}, "max_steps"),
        ({"q": [0.5], "u": [0.0]}, {"section": turns(u), "max_steps": 1}, "away from its start in"),
        (
            {"q": [50.0], "u": [0.0]},
            {"section": kn.Event("far", x - 50, direction=1), "within": 5},
            "reaches the section",
        ),
    ]
    for at, given, told in cases:
        with pytest.raises(kn.SimulationError, match=told):
            kn.limit_cycle(eom, **at, **given)
    cycle = kn.limit_cycle(eom, **start, section=turns(u))
    for parameter, to, told in (("mu", "far", "to= as a value other than"), ("mu", 1.0, "to= as"), ("nu", 2.0, "nu")):
        with pytest.raises(kn.KaneError, match=told):
            cycle.follow(parameter, to)
    with pytest.raises(kn.KaneError, match="one of x, u"):
        kn.limit_cycle(eom, **start, section=turns(u), cyclic=["nothing"])


def test_parameters_come_back():
    """A mass that an event has changed is another system."""
    eom, x, u = van_der_pol()
    mu = eom.parameters[0]
    grows = kn.Event("grows", x, direction=1, then={mu: 1.1})
    with pytest.raises(kn.SimulationError, match="initial values of parameters at the end"):
        kn.limit_cycle(kn.derive(eom.system.replace(events=[grows])), q=[2.0], u=[0], section=turns(u))


def test_a_section_that_is_met_at_once_is_refused():
    """Feet that are on the slope together, before they have passed each other: a fixed point, and no gait."""
    eom = kn.derive(simplest_walker.system())
    with pytest.raises(kn.SimulationError, match="meets it again right where it began"):
        kn.limit_cycle(eom, section="strike", q=[0.2], u=[-0.2], states=[0.3999, -0.0158])


def test_grazing_is_refused():
    eom, x, u = van_der_pol()
    top = kn.limit_cycle(eom, q=[2.0], u=[0], section=turns(u)).x[0]
    touch = kn.Event("touch", x, threshold=-top + 1e-14, direction=-1, then={u: -u})
    with pytest.raises(kn.SimulationError, match="grazes"):
        kn.limit_cycle(kn.derive(eom.system.replace(events=[touch])), q=[top], u=[0], section=turns(u))


def test_families_of_cycles_are_refused():
    """At resonance without damping there is none, and every start comes back alike."""
    eom, _, _ = oscillator(lambda x, u: kn.cos(kn.time) - x)
    with pytest.raises(kn.SimulationError, match="multiplier 1"):
        kn.limit_cycle(eom, q=[1.0], u=[0], period=2 * np.pi)


def test_loads_that_jump_are_refused():
    eom, _, u = oscillator(lambda x, u: 0.3 * kn.cos(kn.time) - x - 0.1 * kn.sign(u))
    with pytest.raises(kn.SimulationError, match="smooth between events"):
        kn.limit_cycle(eom, q=[0.3], u=[0.1], period=2 * np.pi)
    assert u.name == "u"


# Inputs -----------------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_parameters_of_inputs_alone_have_the_values_that_are_given():
    """x = Re(A e^{iwt}/(k − w² + i c w)), by values of A and w that are not their defaults; along a branch too."""
    A, w, F = kn.parameter("A", 1.0), kn.parameter("w", 2.0), kn.input("F")
    eom, x, _ = oscillator(lambda x, u: F - 4 * x - 0.2 * u)
    given = {"q": [0], "u": [0], "inputs": {F: A * kn.cos(w * kn.time)}, "parameters": {A: 3.0, w: 1.0}}
    cycle = kn.limit_cycle(eom, period=2 * kn.pi / w, **given)
    assert cycle.period == pytest.approx(2 * np.pi, abs=1e-12)
    assert cycle.x[0] == pytest.approx((3 / (3 + 0.2j)).real, abs=1e-11)
    assert cycle.start.parameters[A] == 3.0
    last = cycle.follow(w, 1.5, locate=False).cycles[-1]
    assert last.x[0] == pytest.approx((3 / (4 - 1.5**2 + 0.3j)).real, abs=1e-10)
    assert last.period == pytest.approx(2 * np.pi / 1.5, abs=1e-12)
    points = kn.poincare(eom, section=kn.Event("period", kn.sin(kn.time / 2)), count=40, **given)
    assert points[x][-1] == pytest.approx((3 / (3 + 0.2j)).real, abs=1e-8)


@pytest.mark.parametrize("rest", [0, np.int64(0), kn.parameter("rest", 0.0)])
def test_inputs_that_follow_from_the_state_are_no_forcing(rest):
    """Van der Pol's equation by an input is that by a load, and has its cycle at a section."""
    mu, F = kn.parameter("mu", 1.0), kn.input("F")
    eom, x, u = oscillator(lambda x, u: F - x)
    cycle = kn.limit_cycle(eom, q=[2], u=[0], section=turns(u), inputs={F: mu * (1 - x**2) * u + rest})
    own, _, speed = van_der_pol()
    other = kn.limit_cycle(own, q=[2], u=[0], section=turns(speed))
    assert (cycle.period, cycle.multipliers[0].real) == pytest.approx(
        (other.period, other.multipliers[0].real), abs=1e-9
    )
    with pytest.raises(kn.SimulationError, match="Expected equations that do not depend on time"):
        kn.limit_cycle(eom, q=[2], u=[0], section=turns(u), inputs={F: lambda t: 0.0})


def test_what_is_waited_for_is_a_time():
    eom, _, u = van_der_pol()
    for within in (-1, "long"):
        with pytest.raises(kn.SimulationError, match="Expected within as a number above zero"):
            kn.poincare(eom, q=[2], u=[0], section=turns(u), within=within)


def slide(size):
    """A slide that excites itself, with a pendulum: lengths beside angles, so that nothing but their own size may judge them."""
    x, v, th, om = kn.coordinate("x", "m"), kn.speed("v", "m/s"), kn.coordinate("th", "rad"), kn.speed("om", "rad/s")
    P, A = O.at("slide", x * N.x), N.rotate("arm", th, N.z)
    Q = P.at("bob", -0.5 * size * A.y)
    a, b = kn.parameter("a", 2.0, "N*s/m"), kn.parameter("b", 3.0 / size**2, "N*s/m^3")
    k, c = kn.parameter("k", 20.0, "N/m"), kn.parameter("c", 0.05 * size**2, "N*m*s")
    loads = [
        kn.gravity(-9.81 * size * N.y),
        kn.Force(P, ((a - b * x**2) * v - k * x) * N.x),
        kn.Torque(A, -c * om * A.z),
    ]
    bodies = [kn.Particle("slide", P, 2), kn.Particle("bob", Q, 0.5)]
    return kn.derive(kn.System(N, bodies=bodies, speeds={v: x.dt, om: th.dt}, loads=loads)), x


@pytest.mark.parametrize("size", [1.0, 1e-9, pytest.param(1e7, marks=pytest.mark.slow), 1e9])
def test_cycles_are_the_same_in_other_units(size):
    eom, x = slide(size)
    up = kn.Event("up", x, direction=1)
    for begin in (0.3, 0.32, 0.48):  # where Newton's steps leave x is rounding's, on one side or the other
        start = kn.cycles.poincare(eom, q=[begin * size, 0.02], u=[0.1 * size, 0], section=up, count=2).states[-1]
        cycle = kn.cycles.limit_cycle(eom, q=start[:2], u=start[2:], section=up, atol=1e-13 * min(size, 1.0))
        assert cycle.period == pytest.approx(2.3030386346870, abs=1e-11)
        np.testing.assert_allclose(np.sort(cycle.multipliers.real), [0.19684542, 0.37965799, 0.85212879], atol=1e-7)
        assert abs(cycle.x[1]) == pytest.approx(0.01788284, abs=1e-7)


@pytest.mark.parametrize("size", [1.0, 1e-6, 1e6, pytest.param(1e9, marks=pytest.mark.slow)])
def test_a_start_beside_a_section_is_refused_in_any_units(size):
    """The angle is off by a tenth of what it varies by, however many units the slide moves; the slide, however few."""
    eom, x = slide(size)
    th = next(q for q in eom.coordinates if q.name == "th")
    for quantity, beside in ((th, {"th": 2e-3}), (x, {"x": 2e-3 * size})):
        section = kn.Event("up", quantity, direction=1)
        start = {"x": 0.3 * size, "th": 0.02, quantity.name: 0.0} | beside
        with pytest.raises(kn.SimulationError, match="Expected a start on the section 'up'"):
            kn.limit_cycle(eom, q=start, u=[0.1 * size, 0.1], section=section)


@pytest.mark.parametrize("k", [1, 2, 3, *(pytest.param(k, marks=pytest.mark.slow) for k in (0, 4))])
def test_motions_far_from_a_cycle_are_told(k):
    """Half a cycle later the slide goes the other way: Newton's steps go to turns as fast as you like, and steps are shortened."""
    eom, x = slide(1.0)
    both = kn.Event("both", x)
    start = kn.cycles.poincare(eom, q=[0.3 + 0.02 * k, 0.01 * k], u=[0.1, 0], section=both, count=8 + k % 3).states[-1]
    with pytest.raises(kn.SimulationError, match=r"Expected a cycle|variational equations"):
        kn.limit_cycle(eom, q=start[:2], u=start[2:], section=both, rtol=1e-10, atol=1e-10)


def test_multipliers_by_euler_parameters_are_those_by_angles():
    """A damped body on a ball joint that is driven: perturbations are small angles in one description, coordinates in the other."""

    def multipliers(orientation):
        hinge = kn.ball("b", O, N, orientation=orientation)
        B = hinge.frame
        body = kn.RigidBody(
            "b", frame=B, mass_center=hinge.point.at("G", -0.5 * B.z), mass=1, inertia=kn.inertia(B, 0.1, 0.12, 0.05)
        )
        c, A = kn.parameter("c", 0.3, "N*m*s"), kn.parameter("A", 0.5, "N*m")
        k, W = kn.parameter("k", 0.5, "N*m"), kn.parameter("W", 2.0, "rad/s")
        loads = [
            kn.gravity(-9.81 * N.z),
            kn.Torque(B, A * kn.sin(W * kn.time) * N.x - c * B.angular_velocity(N)),
            kn.Torque(B, k * N.x.dot(B.y) * N.z),
        ]
        eom = kn.derive(kn.System(N, bodies=[body], joints=[hinge], loads=loads))
        rest = dict.fromkeys(eom.coordinates, 0.0) | dict.fromkeys(
            eom.system.euler_parameters and eom.coordinates[:1], 1.0
        )
        settled = kn.simulate(eom, (0, 10 * np.pi), q=rest, u=0, samples=2)
        cycle = kn.limit_cycle(eom, period=2 * kn.pi / W, q=settled.q[-1], u=settled.u[-1])
        return np.sort_complex(cycle.multipliers)

    np.testing.assert_allclose(multipliers("euler parameters"), multipliers("angles"), rtol=0, atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("size", [1e-6, 1e6])
def test_branches_of_cycles_are_the_same_in_other_units(size):
    def followed(size):
        eom, x = slide(size)
        up = kn.Event("up", x, direction=1)
        start = kn.cycles.poincare(eom, q=[0.3 * size, 0.02], u=[0.1 * size, 0], section=up, count=2).states[-1]
        cycle = kn.cycles.limit_cycle(eom, q=start[:2], u=start[2:], section=up, atol=1e-13 * min(size, 1.0))
        branch = cycle.follow("a", to=[2.5, 4.0])
        (change,) = branch.changes
        return [change.value, *(c.period for c in branch.cycles), *branch.multipliers[-1].real]

    np.testing.assert_allclose(followed(size), followed(1.0), rtol=1e-6)
