# SPDX-License-Identifier: BSD-3-Clause
"""Derivatives of motions beside differences of motions at 1e-13, closed forms, and each other."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.fitting import sensitivities
from kane.gallery import load

WEIGHTS = ((-2, 1 / 12), (-1, -8 / 12), (1, 8 / 12), (2, -1 / 12))
TIGHT = {"rtol": 1e-13, "atol": 1e-13}


def oscillator():
    """ẍ = F − c ẋ − k x − x³ with F = A cos w t − 0.05 c x."""
    k, c, A, w = (kn.parameter(name, value) for name, value in (("k", 2.0), ("c", 0.1), ("A", 0.7), ("w", 1.3)))
    F, N = kn.input("F"), kn.Frame("N")
    x, u = kn.coordinate("x"), kn.speed("u")
    O = kn.Point("O", fixed_in=N)
    P = O.at("P", x * N.x)
    force = kn.Force(P, (F - c * u - k * x - x**3) * N.x)
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("B", P, 1.0)], speeds={u: x.dt}, loads=[force]))
    return eom, {F: A * kn.cos(w * kn.time) - 0.05 * c * x}, (k, c, A, w, x, u)


def differences(eom, span, by, given, samples, what=None, step=1e-3, rows=slice(None)):
    """∂(states or what)/∂by by differences of fourth order."""
    found = []
    for s in by:
        total = 0.0
        for place, weight in WEIGHTS:
            changed = {kind: dict(given.get(kind, {})) for kind in ("q", "u", "parameters")}
            kind = next(k for k, own in changed.items() if s in own)
            h = step * max(1.0, abs(changed[kind][s]))
            changed[kind][s] += place * h
            motion = kn.simulate(eom, span, samples=samples, **{**given, **changed}, **TIGHT)
            total = total + weight / h * (motion.states if what is None else motion[what])[rows]
        found.append(total)
    return np.stack(found, axis=-1)


def test_by_parameters_of_equations_and_inputs_and_starts():
    """All kinds of b at once, and the total derivative of an expression that holds an input."""
    eom, inputs, by = oscillator()
    k, c, A, w, x, u = by
    given = {"q": {x: 0.4}, "u": {u: 0.0}, "parameters": {k: 2.0, c: 0.1, A: 0.7, w: 1.3}, "inputs": inputs}
    s = sensitivities(eom, (0, 6), by, samples=13, **given)
    wanted = differences(eom, (0, 6), by, given, 13)
    assert s.states.shape == (13, 2, 6)
    np.testing.assert_allclose(s.states, wanted, rtol=0, atol=2e-9 * np.abs(wanted).max())
    F = eom.inputs[0]
    of_power = differences(eom, (0, 6), by, given, 13, F * u + k * x)
    np.testing.assert_allclose(s[F * u + k * x], of_power, rtol=0, atol=2e-9 * np.abs(of_power).max())
    force = s[F]
    t, xs = s.t, s.motion["x"]
    np.testing.assert_allclose(force[:, 2], np.cos(1.3 * t) - 0.05 * 0.1 * s["x"][:, 2], rtol=1e-12)
    np.testing.assert_allclose(force[:, 1], -0.05 * xs - 0.05 * 0.1 * s["x"][:, 1], rtol=1e-12, atol=1e-14)


def test_gains_of_inputs_have_their_values_along_a_motion():
    """A parameter that stands in an input alone has the value that was given, in `sol[…]` and in derivatives."""
    eom, inputs, (_, _, A, _, x, _) = oscillator()
    given = {"q": [0.4], "u": [0.0], "inputs": inputs, "parameters": {A: 0.9}}
    sol = kn.simulate(eom, (0, 1), samples=3, **given)
    np.testing.assert_array_equal(sol[A * x], 0.9 * sol[x])
    s = sensitivities(eom, (0, 1), [A], samples=3, **given)
    np.testing.assert_allclose(s[A * x][:, 0], 0.9 * s[x][:, 0] + s.motion[x], rtol=1e-12)


def test_of_vectors_and_lists():
    eom, inputs, by = oscillator()
    _, _, _, _, x, u = by
    s = sensitivities(eom, (0, 1), [x, u], q=[0.4], u=[0.0], inputs=inputs, samples=3)
    N = eom.system.inertial
    assert s[[x, u]].shape == (3, 2, 2)
    np.testing.assert_array_equal(s[[x, u]], s.states)
    np.testing.assert_array_equal(s[2 * x * N.y][:, 1], 2 * s[x])


def test_of_a_ball_that_bounces():
    """With v = √(2 g y₀), behind the nth bounce y = eⁿ v (t − tₙ) − ½ g (t − tₙ)², tₙ = (v/g)(1 + 2 e (1 − eⁿ⁻¹)/(1 − e))."""
    ball = load("bouncing_ball")
    eom = kn.derive(ball.system())
    m, g, e = eom.parameters
    (y,) = eom.coordinates
    values = {m: 1.0, g: 9.81, e: 0.8}
    s = sensitivities(eom, (0, 2.0), [y, g, e], q={y: 1.0}, u=[0.0], parameters=values, samples=41)
    y0, G, E, t = kn.parameter("y0"), kn.parameter("G"), kn.parameter("E"), kn.time
    v, bounces = kn.sqrt(2 * G * y0), [ev.name for ev, _ in s.motion.events]
    assert len(bounces) >= 2
    for n in (1, 2):
        begin, end = (np.sqrt(2 / 9.81) * (1 + 2 * sum(0.8**i for i in range(1, j))) if j else 0.0 for j in (n, n + 1))
        at = (s.t > begin + 1e-6) & (s.t < end - 1e-6)
        assert at.sum() > 3
        tn = v / G * (1 + 2 * sum(E**i for i in range(1, n)))
        height = E**n * v * (t - tn) - G * (t - tn) ** 2 / 2
        for k, by in enumerate((y0, G, E)):
            numbers = {y0: 1.0, G: 9.81, E: 0.8, t: s.t[at]}
            wanted = kn.evaluate(kn.diff(height, by), numbers)
            np.testing.assert_allclose(s[y][at, k], wanted, rtol=1e-10, atol=1e-10)


@pytest.mark.parametrize("e", [0.0, 0.01, 0.5, 0.98, 0.999999, 1.0])
def test_by_a_coefficient_of_restitution_up_to_its_ends(e):
    """Before the second impact ∂y/∂e = v (t − t₁), v = √(2 g y₀); one that would just bounce has none."""
    eom = kn.derive(load("bouncing_ball").system())
    m, g, restitution = eom.parameters
    (y,) = eom.coordinates
    t1 = np.sqrt(2 / 9.81)
    given = {"q": {y: 1.0}, "u": [0.0], "parameters": {m: 1.0, g: 9.81, restitution: e}, "samples": 2}
    if e == 0:
        with pytest.raises(kn.SimulationError, match="a different law applies nearby"):
            sensitivities(eom, (0, t1 + 0.005), [restitution], **given)
    else:
        s = sensitivities(eom, (0, t1 + 0.005), [restitution], **given)
        assert s[y][-1, 0] == pytest.approx(np.sqrt(2 * 9.81) * 0.005, rel=1e-7)


@pytest.mark.parametrize("far", [0.0, 1e4, 1e8])
def test_a_ball_is_no_nearer_to_its_floor_where_both_are_far_away(far):
    """A floor at y = f: its event is judged by how the ball moves, not by where it is."""
    system, _, (m, F, x, u) = pushed()
    f = kn.parameter("f")
    eom = kn.derive(system.replace(events=[kn.Event("floor", x - f, direction=-1, then={u: -u})]))
    given = {"u": [0.0], "inputs": {F: -9.81 * m}, "parameters": {f: far}}
    s = sensitivities(eom, (0, 1), [x, f], q=[1.0 + far], samples=2, **given)
    v, t1 = np.sqrt(2 * 9.81), np.sqrt(2 / 9.81)
    wanted = v / 2 * (1 - t1) - (v - 9.81 * (1 - t1)) * t1 / 2  # of v τ − g τ²/2, τ = t − t₁
    np.testing.assert_allclose(s[x][-1], [wanted, 1 - wanted], rtol=1e-6)


def test_of_stick_and_slip():
    """A mass on a belt through several changes of mode: by friction, stiffness and start."""
    belt = load("mass_on_belt")
    eom = kn.derive(belt.system())
    own = {p.name: p for p in eom.parameters}
    given = {"parameters": {p: p.default for p in eom.parameters}}
    given |= {
        kind: {s: belt.START[kind][s.name] for s in group}
        for kind, group in (("q", eom.coordinates), ("u", eom.speeds))
    }
    mu = [p for name, p in own.items() if name.startswith("mu")]
    by = [*mu, own["k"], eom.coordinates[0]]
    s = sensitivities(eom, (0, 6.0), by, samples=2, **given)
    assert len(s.motion.mode_history) >= 3
    last = differences(eom, (0, 6.0), by, given, 2, eom.coordinates[0], 1e-4, -1)
    np.testing.assert_allclose(s[eom.coordinates[0]][-1], last, rtol=1e-7, atol=1e-8)


def four_bar():
    bar = load("four_bar")
    eom = kn.derive(bar.system())
    q, u = dict(zip((s.name for s in eom.coordinates), eom.coordinates, strict=True)), eom.speeds
    start = {"q": {q[name]: value for name, value in bar.START["q"].items()}, "u": {u[0]: 5.0}}
    return eom, {**start, "parameters": {p: p.default for p in eom.parameters}}


@pytest.mark.parametrize("names", [("a", "c"), ("q1",), ("u1", "m2")])
def test_of_a_four_bar(names):
    """What the closure makes dependent follows; the independent start values stay."""
    eom, given = four_bar()
    by = [next(s for s in (*eom.state, *eom.parameters) if s.name == name) for name in names]
    s = sensitivities(eom, (0, 1.5), by, samples=6, **given)
    wanted = differences(eom, (0, 1.5), by, given, 6, None, 1e-4)
    np.testing.assert_allclose(s.states, wanted, rtol=0, atol=2e-7 * np.abs(wanted).max())


def test_start_values_that_depend_on_each_other():
    eom, given = four_bar()
    with pytest.raises(kn.SimulationError, match="follow from the others"):
        sensitivities(eom, (0, 1), ["q1", "q2"], **given)


@pytest.mark.parametrize(
    ("by", "error", "said"),
    [
        ([], kn.SimulationError, "some parameters"),
        (["k", "k"], kn.SimulationError, "k twice"),
        (["K"], kn.ValueMissingError, "Expected one of"),
    ],
)
def test_what_is_no_list_of_unknowns(by, error, said):
    eom, inputs, _ = oscillator()
    with pytest.raises(error, match=said):
        sensitivities(eom, (0, 1), by, q=[0.4], u=[0.0], inputs=inputs)


def pushed():
    """m ẍ = F."""
    m, F, N = kn.parameter("m", 1.0), kn.input("F"), kn.Frame("N")
    x, u = kn.coordinate("x"), kn.speed("u")
    O = kn.Point("O", fixed_in=N)
    P = O.at("P", x * N.x)
    system = kn.System(N, bodies=[kn.Particle("B", P, m)], speeds={u: x.dt}, loads=[kn.Force(P, F * N.x)])
    return system, kn.derive(system), (m, F, x, u)


def test_behind_a_breakpoint():
    """A force that jumps in time: F = 2 behind t = 1, else 0. x = ½ 2 (t − 1)² there, and ∂x/∂m = −x/m."""
    _, eom, (m, F, x, u) = pushed()
    law = kn.where(kn.less(kn.time, 1.0), 0.0, 2.0)
    s = sensitivities(eom, (0, 3), [m, x, u], q=[0.0], u=[0.0], inputs={F: law}, samples=7)
    late = np.maximum(s.t - 1, 0)
    np.testing.assert_allclose(s[x], np.column_stack([-(late**2), np.ones(7), s.t]), atol=1e-12)


def test_by_times_at_which_inputs_jump():
    """F = 2 from b on for 1 s: x = (t − b)², then 1 + 2 (t − b − 1). Many motions and both ways have ∂x/∂b, whatever b is."""
    _, eom, (_, F, x, _) = pushed()
    b = kn.parameter("b", 0.0)
    law = kn.where(kn.less(kn.time, b), 0.0, kn.where(kn.less(kn.time, b + 1), 2.0, 0.0))
    given, values = {"q": [0.0], "u": [0.0], "inputs": {F: law}}, np.linspace(0.1, 1.9, 7)
    for value in values:
        own = {"parameters": {b: value}, "samples": 5, **given}
        s = sensitivities(eom, (0, 4), [b], **own)
        wanted = -2 * np.clip(s.t - value, 0, 1)
        np.testing.assert_allclose(s[x][:, 0], wanted, atol=1e-12)
        back = sensitivities(eom, (0, 4), [b], method="adjoint", **own)
        np.testing.assert_allclose(back[x][:, 0], wanted, atol=1e-12)
        np.testing.assert_allclose(
            back.cost(integral=F * (1 + x)).gradient, 0, atol=1e-12
        )  # it moves with b as a whole
    runs = kn.simulate_many(eom, (0, 4), by=[b], parameters={b: values}, samples=[4.0], **given)
    np.testing.assert_allclose(runs["x_by"].values[:, -1, 0], -2.0, rtol=1e-9)
    measured = kn.simulate(eom, (0, 4), parameters={b: 1.1}, samples=9, **given)
    found = kn.fit(eom, {"t": measured.t, "x": measured[x]}, [b], parameters={b: 0.7}, **given)
    assert found.values[b] == pytest.approx(1.1, rel=1e-9)


def test_two_jumps_that_come_together_and_are_moved_apart_are_refused():
    _, eom, (_, F, _, _) = pushed()
    a, b = kn.parameter("a", 1.0), kn.parameter("b", 1.0)
    law = kn.where(kn.less(kn.time, a), 0.0, 1.0) + kn.where(kn.less(kn.time, b), 0.0, 1.0)
    given = {"q": [0.0], "u": [0.0], "inputs": {F: law}}
    with pytest.raises(kn.SimulationError, match="times change differently with parameters"):
        sensitivities(eom, (0, 2), [a, b], parameters={a: 1.0, b: 1.0}, **given)


def test_rates_of_states_that_jump_are_refused():
    system, _, (_, F, x, _) = pushed()
    J = kn.state("J")
    eom = kn.derive(system.replace(states={J: kn.sign(x - 0.3)}))
    given = {"q": [1.0], "u": [0.0], "states": [0.0], "inputs": {F: -x}}
    with pytest.raises(kn.SimulationError, match="rates of states that jump"):
        sensitivities(eom, (0, 2), [x], **given)
    with pytest.raises(kn.SimulationError, match=r"rates of states that jump"):
        kn.simulate_many(eom, (0, 2), by=[x], **given)


def driven(length, *events):
    """Two bodies, the second on the first; x is held by f(x, y, r), which r drives."""
    N, r = kn.Frame("N"), kn.input("r")
    x, y, v, w, k = kn.coordinate("x"), kn.coordinate("y"), kn.speed("v"), kn.speed("w"), kn.parameter("k", 4.0)
    O = kn.Point("O", fixed_in=N)
    P, Q = O.at("P", x * N.x), O.at("Q", x * N.x + y * N.y)
    held = x**2 + y**2 - (r + 1) ** 2 if length else x - r
    eom = kn.derive(
        kn.System(
            N,
            bodies=[kn.Particle("p", P, 1), kn.Particle("q", Q, 1)],
            speeds={v: x.dt, w: y.dt},
            loads=[kn.linear_spring(Q, O, k)],
            holonomic=[kn.configuration_constraint("drive", held)],
            events=[kn.Event("hit", y, threshold=0.2, direction=-1, then={w: -0.5 * w})] if events else (),
        )
    )
    return eom, r, (x, y, w, k)


@pytest.mark.parametrize("length", [False, True])
@pytest.mark.parametrize("event", [False, True])
@pytest.mark.parametrize("method", ["forward", "adjoint"])
def test_starts_on_constraints_that_inputs_drive(length, event, method):
    """The start follows a and om of r = a cos(om t) from its first instant on, and where an event sets a speed."""
    eom, r, (x, y, w, k) = driven(length, *[1] * event)
    a, om = kn.parameter("a", 0.5), kn.parameter("om", 2.0)
    given = {"inputs": {r: a * kn.cos(om * kn.time)}, "parameters": {k: 4.0, a: 0.8, om: 1.3}}
    given |= {"q": {y: 0.3, **({x: kn.guess(1.7)} if length else {})}, "u": {w: -0.7}}
    found = sensitivities(eom, (0, 0.6), [k, a, om], samples=2, method=method, **given)
    wanted = differences(eom, (0, 0.6), (k, a, om), given, 2, rows=[0, -1])
    np.testing.assert_allclose(found.states[[0, -1]], wanted, rtol=0, atol=1e-8)


def test_what_functions_of_events_set_besides_the_state_is_refused_unless_it_is_the_same_number():
    c, F = kn.parameter("c", 0.2), kn.input("F")
    k, N, x, u = kn.parameter("k", 4.0), kn.Frame("N"), kn.coordinate("x"), kn.speed("u")
    P = kn.Point("O", fixed_in=N).at("P", x * N.x)

    def run(then, by):
        load = kn.Force(P, (F - c * u - k * x) * N.x)
        hit = kn.Event("hit", x, direction=-1, then=then)
        eom = kn.derive(kn.System(N, bodies=[kn.Particle("B", P, 1)], speeds={u: x.dt}, loads=[load], events=[hit]))
        given = {"q": {x: 1.0}, "u": {u: 0.0}, "inputs": {F: -0.1 * c * u}, "parameters": {k: 4.0, c: 0.2}}
        return sensitivities(eom, (0, 2), by, samples=2, **given), eom, given

    found, eom, given = run(lambda t, q, u, parameters: {"c": 1.0}, [k, x])
    wanted = differences(eom, (0, 2), (k, x), given, 2, rows=[-1])
    np.testing.assert_allclose(found.states[-1:], wanted, rtol=0, atol=1e-8)
    for then, by in (
        (lambda t, q, u, parameters: {"F": 3.0}, [k]),
        (lambda t, q, u, parameters: {"c": 0.1 * t}, [k]),
        (lambda t, q, u, parameters: {"c": 1.0}, [c]),
    ):
        with pytest.raises(kn.SimulationError, match=r"function of the event 'hit' that sets the state, .* sets [cF]"):
            run(then, by)


def test_samples_beyond_the_end_are_refused():
    eom, inputs, by = oscillator()
    with pytest.raises(kn.SimulationError, match="within"):
        sensitivities(eom, (0, 1), by, q=[0.4], u=[0], inputs=inputs, samples=[0.5, 3.0])
    with pytest.raises(kn.SimulationError, match="to differentiate by, got None"):
        sensitivities(eom, (0, 1), None, q=[0.4], u=[0], inputs=inputs)


@pytest.mark.parametrize("floor", ["contact", "function"])
def test_of_parameters_of_inputs_alone_across_impacts(floor):
    system, _, (_, F, x, u) = pushed()
    b = kn.parameter("b", 0.2)
    falls = kn.Event("floor", x, direction=-1, then=lambda t, q, u, parameters: {"u": -0.5 * next(iter(u.values()))})
    stop = {"contacts": [kn.joints.stop("floor", x, restitution=0.5)]}
    eom = kn.derive(system.replace(**(stop if floor == "contact" else {"events": [falls]})))
    law = kn.where(kn.less(kn.time, b), 0.0, 2.0) - 9.81
    given = {"q": {x: 1.0}, "u": {u: 0.0}, "inputs": {F: law}, "parameters": {b: 0.2}}
    wanted = differences(eom, (0, 0.8), (b,), given, 2, rows=[-1])
    for method in ("forward", "adjoint"):
        s = sensitivities(eom, (0, 0.8), [b], samples=2, method=method, **given)
        np.testing.assert_allclose(s.states[-1:], wanted, rtol=1e-7)


def test_of_a_floor_that_an_input_moves():
    """A floor at r = b sin 3t: the speed after the impact is ṙ − e (u − ṙ), and b moves ṙ."""
    N, r, b = kn.Frame("N"), kn.input("r"), kn.parameter("b", 0.2)
    x, u = kn.coordinate("x"), kn.speed("u")
    O = kn.Point("O", fixed_in=N)
    P = O.at("P", x * N.x)
    floor = kn.contact(kn.joints.point_on_plane("floor", P, O.at("Q", r * N.x), normal=N.x), restitution=0.5)
    eom = kn.derive(
        kn.System(
            N, bodies=[kn.Particle("B", P, 1.0)], speeds={u: x.dt}, loads=[kn.gravity(-9.81 * N.x)], contacts=[floor]
        )
    )
    given = {"q": {x: 1.0}, "u": {u: 0.0}, "inputs": {r: b * kn.sin(3 * kn.time)}, "parameters": {b: 0.2}}
    s = sensitivities(eom, (0, 0.8), [b, x], samples=2, **given)
    wanted = differences(eom, (0, 0.8), (b, x), given, 2, rows=[-1])
    np.testing.assert_allclose(s.states[-1:], wanted, rtol=1e-7)


def test_errors_of_actions_are_told_as_they_are():
    system, _, (_, F, x, _) = pushed()

    def then(t, q, u, parameters):
        if next(iter(u.values())) < -4.4295:  # beside the motion, which comes with −4.42945
            raise kn.ArgumentError("my own trouble: table ends")
        return {"u": -0.5 * next(iter(u.values()))}

    eom = kn.derive(system.replace(events=[kn.Event("floor", x, direction=-1, then=then)]))
    with pytest.raises(kn.ArgumentError, match="table ends"):
        sensitivities(eom, (0, 0.8), [x], samples=2, q=[1.0], u=[0.0], inputs={F: -9.81})


@pytest.mark.parametrize(
    ("angle", "method"), [(-0.4, "forward"), (-0.6, "forward"), (-0.9, "forward"), (-0.6, "adjoint")]
)
def test_dependent_speeds_that_change_between_few_samples(angle, method):
    """A part without a sample is differentiated with the equations by which it was integrated, whose speeds are determined there."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    g = kn.parameter("g", 9.81)
    upper = kn.pin("upper", O, N, axis=N.z)
    lower = kn.pin("lower", upper.point.at("E", 0.7 * upper.frame.x), upper.frame, axis=N.z)
    guide = kn.slider("guide", O.at("G", 0.63 * N.x - 0.14 * N.y), N, axis=N.y)
    tip = lower.point.at("T", 0.5 * lower.frame.x)
    bodies = [kn.Particle(p.name, p, mass) for p, mass in ((lower.point, 1.0), (tip, 0.8), (guide.point, 0.4))]
    joints, rod = [upper, lower, guide], kn.distance(tip, guide.point, 0.8)
    eom = kn.derive(kn.System(N, bodies=bodies, joints=joints, holonomic=[rod], loads=[kn.gravity(-g * N.y)]))
    start = {"q": {"q_upper": angle, "q_lower": 0.0, "q_guide": kn.guess(-0.5)}, "u": {"u_upper": 1.0, "u_lower": -2.0}}
    s = kn.fitting.sensitivities(eom, (0, 1.5), ["g"], samples=2, method=method, **start)
    chosen = [[u.name for u in part.equations.dependent_speeds] for part in s.motion.segments]
    assert len(chosen) > 1
    assert chosen[0] != chosen[1]
    ends = [
        kn.simulate(eom, (0, 1.5), **start, parameters={g: value}, samples=2, rtol=1e-12, atol=1e-12)["q_guide"][-1]
        for value in (9.81 - 1e-4, 9.81 + 1e-4)
    ]
    assert s["q_guide"][-1, 0] == pytest.approx(np.diff(ends)[0] / 2e-4, rel=1e-5)
