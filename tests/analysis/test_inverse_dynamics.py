# SPDX-License-Identifier: BSD-3-Clause
"""Inverse dynamics undoes forward dynamics, whatever is unknown; counts and singular choices are named."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane.gallery import bricard
from tests.examples import examples
from tests.systems import steady as systems

MADE: dict = {}


def equations(name):
    if name not in MADE:
        MADE[name] = getattr(systems, name)()
    return MADE[name]


def forward(eom, seed):
    """A random state on the constraints, random inputs, and u̇ and R there."""
    rng = np.random.default_rng(seed)
    start = {"four_bar": {"q1": 1.2, "q2": kn.guess(-0.2), "q3": kn.guess(-1.5)}}
    q = start.get(next(n for n, e in MADE.items() if e is eom)) or dict(
        zip(eom.coordinates, rng.uniform(0.2, 1.2, len(eom.coordinates)), strict=True)
    )
    for group in eom.system.euler_parameters:
        size = np.sqrt(sum(q[e] ** 2 for e in group.coordinates))
        q |= {e: q[e] / size for e in group.coordinates}
    free = dict(zip(eom.independent_speeds, rng.normal(size=len(eom.independent_speeds)), strict=True))
    if eom.b:
        at = kn.assemble(eom, q=q, u=free)
        q, free = at.q, at.u
    inputs = {s: float(v) for s, v in zip(eom.inputs, rng.normal(size=len(eom.inputs)), strict=True)}
    roots = [*eom.accelerations, *eom.reactions]
    values = eom.evaluate(roots, q=q, u=free, inputs=inputs)
    names = [*(f"{u.name}'" for u in eom.speeds), *(r.name for r in eom.reactions)]
    whole = dict(zip(names, map(float, values), strict=True)) | {s.name: v for s, v in inputs.items()}
    return {"q": q, "u": free}, whole


UNKNOWNS = {
    "four_bar": (["tau"], ["tau", "u1'", "u2'", "G_x", "G_y"], ["u1'", "u2'", "u3'", "G_x", "G_y"]),
    "double_pendulum": (["s1", "s2"], ["u1'", "s2"], ["u2'", "s1"], ["u1'", "u2'"], ["u1'", "s1"]),
    "cart": (["F", "u1'", "R_y"], ["F", "u1'"], ["u1'", "u2'", "R_y"], ["u2'", "F"]),
    "sleigh": (["F", "w'"], ["v'", "w'", "s'"]),
    "rolling_disk": (["u1'", "u2'", "u3'"],),
    "free_body": (["T", "w2'", "w3'", "v1'", "v2'", "v3'"],),
}
CASES = [(name, k) for name, sets in UNKNOWNS.items() for k in range(len(sets))]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "k"), CASES)
@examples(0.2)
@given(seed=st.integers(0, 2**31))
def test_inverse_undoes_forward(name, k, seed):
    eom = equations(name)
    unknowns = list(UNKNOWNS[name][k])
    state, whole = forward(eom, seed)
    inverse = kn.inverse(eom, unknowns)
    found = inverse(**state, given={s.name: whole[s.name] for s in inverse.known})
    scale = max(1.0, *(abs(v) for v in whole.values()))
    assert {s.name for s in found} >= set(unknowns)
    for s, value in found.items():
        assert value == pytest.approx(whole[s.name], abs=1e-10 * scale), s


@pytest.mark.slow
def test_computed_torque_along_a_motion():
    """The torque that drove a motion is found from the motion; arrays go through at once."""
    eom = equations("four_bar")
    start = kn.assemble(eom, q={"q1": 1.2, "q2": kn.guess(-0.2), "q3": kn.guess(-1.5)}, u={"u1": 4.0})
    sol = kn.simulate(eom, (0, 0.5), q=start.q, u=start.u, inputs={"tau": lambda t: 0.4 * np.sin(9 * t)}, samples=51)
    found = kn.inverse(eom, ["tau"]).along(sol)
    (tau,) = eom.inputs
    np.testing.assert_allclose(found[tau], 0.4 * np.sin(9 * sol.t), atol=1e-9)
    for r in eom.reactions:
        np.testing.assert_allclose(found[r], sol[r], atol=1e-8)


def test_the_torque_that_holds_a_wanted_acceleration():
    """Computed torque of two rods in a wanted motion q(t): the simulated motion is the wanted one."""
    eom = equations("double_pendulum")
    t = np.linspace(0, 1, 201)
    q = np.array([0.5 * np.sin(2 * t), 1.0 - 0.3 * np.cos(3 * t)])
    rates = np.array([np.cos(2 * t), 0.9 * np.sin(3 * t)])
    second = np.array([-2 * np.sin(2 * t), 2.7 * np.cos(3 * t)])
    u = np.array([rates[0], rates.sum(axis=0)])
    found = kn.inverse(eom, ["s1", "s2"])(
        q=list(q), u=list(u), given={"u1'": second[0], "u2'": second.sum(axis=0)}, t=t
    )
    from scipy.interpolate import CubicSpline

    drives = {s: CubicSpline(t, v) for s, v in found.items()}
    sol = kn.simulate(eom, (0, 1), q=q[:, 0], u=u[:, 0], inputs=drives, samples=t)
    np.testing.assert_allclose(sol.q.T, q, atol=1e-6)


# Messages -----------------------------------------------------------------------------------------------------------------


def test_counts():
    eom = equations("double_pendulum")
    with pytest.raises(
        kn.SimulationError,
        match=r"one for each of 2 speeds and 0 reactions, got 1 \(s1\): too few",
    ):
        kn.inverse(eom, ["s1"])
    with pytest.raises(kn.SimulationError, match=r"got 3 \(s1, s2, u1'\): too many\. Give values of the others"):
        kn.inverse(eom, ["s1", "s2", "u1'"])
    with pytest.raises(kn.ValueMissingError, match=r"Expected one of u1', u2', s1, s2, got 'q1'"):
        kn.inverse(eom, ["q1", "s1"])
    with pytest.raises(kn.SimulationError, match="different unknowns, got s1 twice"):
        kn.inverse(eom, ["s1", "s1"])
    with pytest.raises(kn.ValueMissingError, match="got none for u2'"):
        kn.inverse(eom, ["s1", "s2"])(q=[0, 0], u=[0, 0], given={"u1'": 0})


def two_motors():
    """Two motors on one joint, and a brake whose force is the square of its input."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    q1, q2 = kn.coordinates("q1:3")
    a, b, p = kn.input("a"), kn.input("b"), kn.input("p")
    A = N.rotate("A", q1, N.z)
    B = N.rotate("B", q2, N.z)
    bodies = [
        kn.RigidBody(n, frame=f, mass_center=O, mass=1.0, inertia=kn.inertia(f, 1, 1, 1))
        for n, f in (("x", A), ("y", B))
    ]
    loads = [kn.Torque(A, (a + 2 * b) * N.z), kn.Torque(B, p**2 * N.z)]
    return kn.derive(kn.System(N, bodies=bodies, speeds="rates", loads=loads))


def test_what_cannot_be_solved():
    eom = two_motors()
    with pytest.raises(
        kn.SingularError,
        match=r"a combination that they leave undetermined: (\+1 a -0\.5 b|-1 a \+0\.5 b) can be added",
    ):
        kn.inverse(eom, ["a", "b"])(q=[0, 0], u=[0, 0], given={"u1'": 0, "u2'": 0, "p": 0})
    with pytest.raises(kn.NotAffineError, match=r"unknown inputs that enter the loads linearly, got one that does not"):
        kn.inverse(eom, ["a", "p"])


def test_an_input_that_multiplies_a_reaction():
    """Sliding friction with an unknown coefficient."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, mu = kn.coordinate("x"), kn.input("mu")
    P = O.at("P", x * N.x)
    normal = kn.reaction("n", at=P, along=N.y)
    loads = [kn.gravity(-9.81 * N.y), kn.Force(P, -mu * normal * N.x)]
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("p", P, 2.0)], speeds="rates", loads=loads, reactions=[normal]))
    with pytest.raises(kn.NotAffineError, match=r"got mu, which multiplies a reaction"):
        kn.inverse(eom, ["mu", "n"])
    found = kn.inverse(eom, ["u_x'", "n"])(q=[0], u=[1.0], given={"mu": 0.3})
    assert {s.name: float(v) for s, v in found.items()} == pytest.approx({"u_x'": -0.3 * 9.81, "n": 2 * 9.81})


def test_a_state_off_the_constraints():
    eom = equations("four_bar")
    with pytest.raises(kn.SimulationError, match=r"state on the constraints, got coordinates that miss pin 1 by 1\.1"):
        kn.inverse(eom, ["tau"])(q=[0, 0, 0], u=[0, 0, 0], given={u.name + "'": 0 for u in eom.independent_speeds})


def test_a_state_that_is_not_whole():
    """Where constraints give the rest, it is said what completes it."""
    eom = equations("four_bar")
    need, given = kn.inverse(eom, ["tau"]), {u.name + "'": 0 for u in eom.independent_speeds}
    with pytest.raises(
        kn.ValueMissingError, match=r"got none for q2, .*kn\.assemble\(eom, q=…, u=…\) completes a state"
    ):
        need(q={"q1": 0.5}, u={}, given=given)
    with pytest.raises(kn.ValueMissingError, match=r"got none for u2'\. Give them"):
        need(q=[0, 0, 0], u=[0, 0, 0])


@pytest.mark.filterwarnings("ignore::kane.KaneWarning")
def test_which_constraints_follow_from_the_others_may_change_with_the_state():
    """Three of rank two, along a(θ), a(2θ), a(3θ + 1), hold a bead still beside a crank: τ = J θ̈ at every θ.

    At 2θ + 1 = π the first and the third are parallel, at θ = 0 and π the first and the second.
    """
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, y, th = kn.coordinates("x y th")
    A = N.rotate("A", th, N.z)
    tau = kn.input("tau")
    at = enumerate((th, 2 * th, 3 * th + 1))
    still = [kn.motion_constraint(f"d{k}", x.dt * kn.cos(a) + y.dt * kn.sin(a)) for k, a in at]
    crank = kn.RigidBody("crank", frame=A, mass_center=O.at("G", 0), mass=1, inertia=kn.inertia(A, 1, 1, 3))
    bead = kn.Particle("bead", O.at("P", x * N.x + y * N.y), 2.0)
    loads = [kn.Torque(A, tau * N.z), kn.Force(bead.point, 5 * N.x)]
    eom = kn.derive(kn.System(N, bodies=[crank, bead], speeds="rates", nonholonomic=still, loads=loads))
    angles = np.array([0.0, 0.4, (np.pi - 1) / 2, (np.pi - 1) / 2 + 1e-7, 1.5, np.pi])
    found = kn.inverse(eom, [tau])(q=[0, 0, angles], u=[0, 0, 0.7], given={"u_th'": 2.0})
    np.testing.assert_allclose(found[tau], 6.0, rtol=1e-9)


def test_arrays_that_do_not_fit_and_no_numbers_are_refused():
    eom = equations("double_pendulum")
    torques = kn.inverse(eom, [u.dt for u in eom.speeds])
    known = dict.fromkeys(torques.known, 0.0)
    with pytest.raises(kn.SimulationError, match=r"broadcast to one shape, got \(3,\) for .*, \(2,\) for "):
        torques(q=[np.zeros(3), np.zeros(2)], u=[0, 0], given=known)
    for wrong in ("x", kn.guess(0.1)):
        with pytest.raises(kn.SimulationError, match="numbers for "):
            torques(q=[wrong, 0.2], u=[0, 0], given=known)
    some = next(p for p in eom.parameters if p.default is not None)
    none = torques(q=[0.1, 0.2], u=[0, 0], given=known, parameters={some: np.zeros(0)})
    assert all(x.shape == (0,) for x in none.values())


def test_parameters_that_events_change_are_those_of_the_motion():
    """A spring that softens where it is slack: no force but the spring's moves the mass, before and after."""
    N = kn.Frame("N")
    x, k, drive = kn.coordinate("x"), kn.parameter("k", 4.0), kn.input("drive")
    P = kn.Point("O", fixed_in=N).at("P", x * N.x)
    softens = kn.Event("softens", x, direction=-1, then={k: 1.0})
    loads = [kn.Force(P, (drive - k * x) * N.x)]
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("p", P, 1.0)], speeds="rates", loads=loads, events=[softens]))
    motion = kn.simulate(eom, (0, 3), q={x: 1.0}, u=0, inputs={drive: 0.0}, samples=13)
    assert set(motion[k]) == {1.0, 4.0}
    assert np.abs(kn.inverse(eom, [drive]).along(motion)[drive]).max() < 1e-12


def test_euler_parameters_must_be_of_unit_length():
    N = kn.Frame("N")
    ball = kn.ball("b", kn.Point("O", fixed_in=N), N)
    body = kn.RigidBody(
        "r", frame=ball.frame, mass_center=ball.point, mass=1.0, inertia=kn.inertia(ball.frame, 1, 2, 3)
    )
    eom = kn.derive(kn.System(N, bodies=[body], joints=[ball]))
    spin = kn.inverse(eom, [u.dt for u in eom.speeds])
    for first in (2.0, np.array([1.0, 2.0])):
        with pytest.raises(kn.SimulationError, match=r"e0² \+ e1² \+ e2² \+ e3² = 1, got length 2\. Divide"):
            spin(q=[first, 0, 0, 0], u=[1, 2, 3])
    found = spin(q=[1, 0, 0, 0], u=[1, 2, 3])
    assert list(found.values()) == pytest.approx([(2 - 3) * 6 / 1, (3 - 1) * 3 / 2, (1 - 2) * 2 / 3])


@pytest.mark.parametrize("metre", [1.0, 1e3, 1e-3, 1e-6])
def test_a_loop_has_an_inverse_in_any_units(metre):
    """Whether the unknowns are determined is asked of accelerations and multipliers in units of one size."""
    eom = kn.derive(bricard.system())
    length = {"m": 1, "m/s^2": 1}
    inverse = kn.inverse(eom, [u.dt for u in eom.independent_speeds])
    parameters = {p: p.default * metre ** length.get(p.unit, 0) for p in eom.parameters}
    at = kn.assemble(eom, q=bricard.START["q"], u=bricard.START["u"], parameters=parameters)
    found = list(inverse(at).values())
    plain = kn.assemble(eom, q=bricard.START["q"], u=bricard.START["u"])
    np.testing.assert_allclose(found, [eom.evaluate(s, plain) for s in inverse.unknowns], rtol=1e-9)
