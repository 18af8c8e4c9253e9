# SPDX-License-Identifier: BSD-3-Clause
"""Laws of systems with flexible beams: momenta and energy, power, reactions, limits, frequencies with masses at the ends."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq

import kane as kn
from tests.examples import examples
from tests.systems.beams import frequencies, spinning

FORMS = pytest.mark.parametrize("form", ["linearized", "nonlinear"])
TIP = {"mass": 0.3, "offset": 0.1}


def free_flyer(form: str, *, space: bool = False) -> tuple[kn.System, kn.Point]:
    """A hub that floats, with a beam that stretches and bends (in space twists, too) and carries a body at its tip."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    joint = (kn.free if space else kn.planar)("base", O, N, **({} if space else {"normal": N.z}))
    A, P = joint.frame, joint.point
    hub = kn.RigidBody("hub", frame=A, mass_center=P, mass=2.0, inertia=kn.inertia(A, 0.2, 0.3, 0.4))
    own: dict[str, Any] = {"EI": 40.0, "modes": 2}
    if space:
        own = {"EI": (40.0, 60.0), "modes": (1, 1), "GJ": 30.0, "torsion": 1, "polar": 0.01}
    beam = kn.Beam(
        "boom",
        P.at("R", 0.3 * A.x),
        frame=A,
        axis=A.x,
        length=1.5,
        mass_per_length=0.8,
        EA=4e3,
        stretch=1,
        form=form,
        **own,
    )
    T, F = beam.point_at(1), beam.frame_at(1)
    center = T.at("T*", TIP["offset"] * F.x)
    tip = kn.RigidBody("tip", frame=F, mass_center=center, mass=TIP["mass"], inertia=kn.inertia(F, 0.01, 0.02, 0.03))
    return kn.System(N, bodies=[hub, beam, tip], joints=[joint]), O


def started(system: kn.System, rng: np.random.Generator) -> dict[str, Any]:
    """A state with some deformation and all speeds."""
    q = {
        x: 0.02 * rng.standard_normal() if x.name.endswith("boom") else float(x.name[:2] == "e0")
        for x in system.coordinates
    }
    return {"q": q, "u": {x: 0.4 * rng.standard_normal() for x in system.speeds}}


def check_kept(
    system: kn.System, O: kn.Point, rng: np.random.Generator, end: float, start: dict[str, Any] | None = None
) -> None:
    eom = kn.derive(system)
    sol = kn.simulate(eom, (0, end), samples=21, rtol=1e-12, atol=1e-13, **(start or started(system, rng)))
    assert sol.status == "finished"
    momenta = [eom.linear_momentum(), eom.angular_momentum(O)]
    for vector in momenta:
        rows = np.array([sol[x] for x in vector.components(system.inertial)])
        assert np.ptp(rows, axis=1).max() < 1e-9 * np.abs(rows).max()
    assert np.ptp(sol.energy) < 1e-9 * np.abs(sol.energy).max()


@pytest.mark.slow
@FORMS
def test_free_in_a_plane(form: str, rng: np.random.Generator) -> None:
    system, O = free_flyer(form)
    check_kept(system, O, rng, 2.0)


@pytest.fixture(scope="module")
def hundred_periods() -> float:
    """Of the first frequency of the free flyer in a plane, 15 rad/s."""
    return 100 * 2 * np.pi / float(frequencies(free_flyer("linearized")[0])()[0])


@pytest.mark.slow
@pytest.mark.parametrize("space", [False, True], ids=["plane", "space"])
@FORMS
def test_free_over_a_hundred_periods(form: str, space: bool, hundred_periods: float, rng: np.random.Generator) -> None:
    system, O = free_flyer(form, space=space)
    check_kept(system, O, rng, hundred_periods)


@pytest.mark.slow
@FORMS
def test_free_at_both_ends_and_turning_fast(form: str, rng: np.random.Generator) -> None:
    """A rod in space at 1.3 times its first frequency across its axis, over 100 periods and 130 turns, without and with stretch."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    base = kn.free("base", O, N)
    A = base.frame
    rod = kn.Beam(
        "boom", base.point, frame=A, axis=A.x, along=A.y, length=1.0, mass_per_length=1.0, EI=(1.0, 1.3), modes=(1, 1),
        support="free", polar=1e-3, EA=2e4, stretch=1, form=form,
    )  # fmt: skip
    system = kn.System(N, bodies=[rod], joints=[base])
    start = started(system, rng)
    (spin,) = (u for u in system.speeds if str(u) == "w_z_base")
    start["u"][spin] = 1.3 * 22.3733
    start["q"] = {x: 0.1 * v if x.name.endswith("boom") else v for x, v in start["q"].items()}
    check_kept(system, O, rng, 100 * 2 * np.pi / 22.3733, start)


@pytest.mark.slow
@pytest.mark.parametrize("space", [False, True], ids=["plane", "space"])
def test_the_forms_differ_at_third_order(space: bool, rng: np.random.Generator) -> None:
    """Linearized, the momentum is that of the beam as it is, energy and angular momentum to second order in the deformation."""
    found: dict[str, list[Any]] = {}
    state: dict[str, Any] = {}
    for form in ("linearized", "nonlinear"):
        system, O = free_flyer(form, space=space)
        eom = kn.derive(system)
        state = state or started(system, rng)
        wanted = [
            eom.kinetic_energy,
            *eom.angular_momentum(O).components(system.inertial),
            *eom.linear_momentum().components(system.inertial),
        ]
        found[form] = []
        for size in (1.0, 0.5):
            scaled = {
                k: {s.name: v * (size if s.name.endswith("boom") else 1.0) for s, v in row.items()}
                for k, row in state.items()
            }
            found[form].append(eom.evaluate(wanted, **scaled))
    whole, half = (np.subtract(a, b) for a, b in zip(found["linearized"], found["nonlinear"], strict=True))
    size = np.abs(found["nonlinear"][0])
    assert np.abs(whole[-3:]).max() < 1e-12 * size[-3:].max()
    differs = np.abs(whole[:-3]) > 1e-6 * size[:-3].max()
    assert differs.any()
    np.testing.assert_allclose(whole[:-3][differs] / half[:-3][differs], 8, rtol=0.2)


@pytest.mark.slow
@FORMS
def test_power_of_loads_and_of_the_hub(form: str) -> None:
    """A follower force at the tip, damping, gravity, and a hub whose motion is prescribed: E − ∫P dt is constant."""
    t = kn.time
    beam, system = spinning(
        angle=kn.parameter("alpha", 1.0, "rad/s^2") * t**2 / 2,
        hub=0.2,
        modes=2,
        form=form,
        damping={"ratio": 0.02, "mass": 0.01},
        EI=25.0,
        EA=500.0,
        stretch=1,
    )
    F = beam.frame_at(1)
    push = kn.Force(beam.point_at(1), -0.3 * kn.sin(3 * t) * F.y, name="push")
    system = system.replace(loads=[push, kn.gravity(-9.81 * system.inertial.y)])
    zero = {"q": dict.fromkeys(system.coordinates, 0.0), "u": dict.fromkeys(system.speeds, 0.0)}
    sol = kn.simulate(kn.derive(system), (0, 2), samples=51, rtol=1e-10, atol=1e-12, **zero)
    assert sol.energy_check.relative < 1e-8


@cache
def driven(form: str) -> tuple[kn.Equations, list[tuple[kn.Parameter, float]], kn.Expr]:
    """A hub in space with a beam under loads of every kind; their parameters with sizes, and the power of each by hand, summed."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    base = kn.free("base", O, N)
    A, P = base.frame, base.point
    hub = kn.RigidBody("hub", frame=A, mass_center=P, mass=2.0, inertia=kn.inertia(A, 0.2, 0.3, 0.4))
    mass, stiffness = kn.parameter("alpha", 0.0, "1/s"), kn.parameter("beta", 0.0, "s")
    L, rhoA, EI = 1.5, 0.8, (40.0, 60.0)
    beam = kn.Beam(
        "boom", P.at("R", 0.3 * A.x), frame=A, axis=A.x, along=A.y, length=L, mass_per_length=rhoA, EI=EI, modes=(2, 1),
        form=form, damping={"mass": mass, "stiffness": stiffness},
    )  # fmt: skip
    sized: list[tuple[kn.Parameter, float]] = [(mass, 1.0), (stiffness, 1e-3)]

    def vector(name: str, frame: kn.Frame, unit: str, size: float) -> kn.Vector:
        parts = [kn.parameter(f"{name}_{k}", 0.0, unit) for k in "xyz"]
        sized.extend((p, size) for p in parts)
        return parts[0] * frame.x + parts[1] * frame.y + parts[2] * frame.z

    tip, section, middle = beam.point_at(1), beam.frame_at(1), beam.frame_at(0.6)
    follower, push = vector("F", section, "N", 3.0), vector("G", N, "N", 3.0)
    twist, along = vector("T", middle, "N*m", 2.0), vector("p", N, "N/m", 2.0)
    loads: list[Any] = [
        kn.Force(tip, follower, name="follower"),
        kn.Force(beam.point_at(0.4), push, name="push"),
        kn.Torque(middle, twist, name="twist"),
        beam.distributed(along),
        kn.gravity(vector("g", N, "m/s^2", 10.0)),
    ]
    eom = kn.derive(kn.System(N, bodies=[hub, beam], joints=[base], loads=loads))
    power = follower.dot(tip.velocity(N)) + push.dot(beam.point_at(0.4).velocity(N))
    power += twist.dot(middle.angular_velocity(N))
    power += sum((f.dot(p.velocity(N)) for p, f in loads[3].forces), start=0 * mass)
    beta = {"v": (1.8751040687119611, 4.694091132974175), "w": (1.8751040687119611,)}
    for stem, stiff in zip("vw", EI, strict=True):
        for k, b in enumerate(beta[stem], 1):
            (q,) = (q for q in beam.coordinates if q.name == f"{stem}{k}_boom")
            power -= (mass * rhoA * L + stiffness * stiff * b**4 / L**3) * q.dt**2
    return eom, sized, eom.in_speeds(power)


@pytest.mark.slow
@FORMS
@examples(0.3)
@given(seed=st.integers(0, 10**6), active=st.lists(st.booleans(), min_size=17, max_size=17))
def test_power_of_loads(form: str, seed: int, active: list[bool]) -> None:
    """dE/dt along the motion is the power of what acts, summed by hand: F · v, T · ω, −q̇ᵀ C q̇; some of the loads, at any state."""
    eom, sized, power = driven(form)
    rng = np.random.default_rng(seed)
    state = started(eom.system, rng)
    turn = rng.standard_normal(4)
    state["q"] |= dict(zip(eom.coordinates, turn / np.linalg.norm(turn), strict=False))
    parameters = {p: abs(rng.standard_normal()) * size * on for (p, size), on in zip(sized, active, strict=True)}
    energies = [eom.kinetic_energy, eom.potential_energy]
    rates = [eom.time_derivative(e) for e in energies]
    *found, expected = eom.evaluate([*rates, power], **state, parameters=parameters)
    assert sum(found) == pytest.approx(expected, rel=1e-9, abs=1e-10 * np.abs(found).sum())


@FORMS
def test_reactions_at_the_root_are_rates_of_momenta(form: str, rng: np.random.Generator) -> None:
    """The force that auxiliary speeds bring into evidence, what Newton and Euler say of the far side, and dp/dt; at the tip, too."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    hinge = kn.pin("hinge", O, N, axis=N.z)
    A = hinge.frame
    root = hinge.point.at("root", 0)
    beam = kn.Beam("arm", root, frame=A, axis=A.x, length=2.0, mass_per_length=1.5, EI=20.0, modes=2, form=form)
    held = beam.point_at(1).at("held", 0)
    bob = kn.Particle("bob", held, 0.4)
    names = [
        kn.reaction(f"{s}{k}", at=p, along=e) for s, p in (("R", root), ("S", held)) for k, e in enumerate((N.x, N.y))
    ]
    gravity = kn.gravity(-9.81 * N.y)
    system = kn.System(N, bodies=[beam, bob], joints=[hinge], reactions=names, loads=[gravity])
    eom = kn.derive(system)
    state = {
        "q": {q: 0.05 * rng.standard_normal() for q in system.coordinates},
        "u": {u: rng.standard_normal() for u in system.speeds},
    }
    *found, sx, sy = eom.evaluate(names, **state)
    pull = [0.4 * eom.time_derivative(held.velocity(N).dot(e)) for e in (N.x, N.y)]
    np.testing.assert_allclose([sx, sy], np.add(eom.evaluate(pull, **state), [0, 0.4 * 9.81]), rtol=1e-10)
    force = eom.reaction(hinge).force
    assert force is not None
    newton = eom.evaluate(list(force.components(N)), **state)[:2]
    rate = [eom.time_derivative(x) for x in eom.linear_momentum().components(N)[:2]]
    weight = (3.0 + 0.4) * 9.81
    momentum = np.add(eom.evaluate(rate, **state), [0, weight])
    np.testing.assert_allclose(found, momentum, rtol=1e-10)
    np.testing.assert_allclose(newton, momentum, rtol=1e-10)


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [0.1, 10.0])
def test_tip_mass(ratio: float) -> None:
    """1 + cos β cosh β + μ β (cos β sinh β − sin β cosh β) = 0."""
    beam, system = spinning(modes=kn.mode_shapes("polynomials", 10))
    system = system.replace(bodies=[beam, kn.Particle("tip", beam.point_at(1), ratio)])

    def equation(b: float) -> float:
        return float(1 / np.cosh(b) + np.cos(b) + ratio * b * (np.cos(b) * np.tanh(b) - np.sin(b)))

    expected = [brentq(equation, 0.5 + k * np.pi, 0.5 + (k + 1) * np.pi, xtol=1e-14) ** 2 for k in range(3)]
    np.testing.assert_allclose(frequencies(system)()[:3], expected, rtol=1e-8)


@pytest.mark.slow
@pytest.mark.parametrize("inertia", [0.01, 1.0])
def test_hub_inertia(inertia: float) -> None:
    """A hub that turns freely: w = A (cosh − cos) + B sinh + C sin, EI w''(0) = −J ω² w'(0)."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    hinge = kn.pin("hinge", O, N, axis=N.z)
    A = hinge.frame
    hub = kn.RigidBody(
        "hub", frame=A, mass_center=hinge.point, mass=1.0, inertia=kn.inertia(A, inertia, inertia, inertia)
    )
    beam = kn.Beam(
        "arm",
        hinge.point,
        frame=A,
        axis=A.x,
        length=1.0,
        mass_per_length=1.0,
        EI=1.0,
        modes=kn.mode_shapes("polynomials", 10),
    )
    system = kn.System(N, bodies=[hub, beam], joints=[hinge])

    def equation(b: float) -> float:
        c, s, sh = np.cos(b) / np.cosh(b), np.sin(b) / np.cosh(b), np.tanh(b)
        rows = [[2, inertia * b**3, inertia * b**3], [1 + c, sh, -s], [sh - s, 1, -c]]
        return float(np.linalg.det(rows))

    grid = np.linspace(0.5, 9, 200)
    values = [equation(b) for b in grid]
    roots = [
        brentq(equation, a, b, xtol=1e-14)
        for a, b, x, y in zip(grid, grid[1:], values, values[1:], strict=False)
        if x * y < 0
    ]
    found = frequencies(system)()
    np.testing.assert_allclose(found[found > 0.1][:2], np.square(roots[:2]), rtol=1e-8)


def test_stiff_beams_are_rods() -> None:
    """The first frequency of a pendulum goes to that of a rod as 1/EI."""

    def pendulum(EI: float) -> float:
        N = kn.Frame("N")
        O = kn.Point("O", fixed_in=N)
        hinge = kn.pin("hinge", O, N, axis=N.z)
        A = hinge.frame
        beam = kn.Beam("rod", hinge.point, frame=A, axis=A.x, length=2.0, mass_per_length=1.5, EI=EI, modes=3)
        system = kn.System(N, bodies=[beam], joints=[hinge], loads=[kn.gravity(9.81 * N.x)])
        return float(frequencies(system)()[0])

    rigid = np.sqrt(3 * 9.81 / (2 * 2.0))
    errors = [abs(pendulum(EI) - rigid) for EI in (1e4, 1e5)]
    assert errors[0] < 1e-2 * rigid
    assert errors[0] / errors[1] == pytest.approx(10, rel=0.05)


@pytest.mark.slow
@FORMS
def test_stiff_beams_swing_as_rods(form: str) -> None:
    """A pendulum with a tip mass that swings from 1 rad, its bending damped: the angle after 1 s goes to the rigid one's as 1/EI."""

    def angle(EI: float | None) -> float:
        N = kn.Frame("N")
        O = kn.Point("O", fixed_in=N)
        hinge = kn.pin("hinge", O, N, axis=N.z)
        A = hinge.frame
        L, rhoA = 2.0, 1.5
        body: Any
        if EI is None:
            body = kn.RigidBody(
                "rod",
                frame=A,
                mass_center=hinge.point.at("C", L / 2 * A.x),
                mass=L * rhoA,
                inertia=kn.rod(A, L * rhoA, L, A.x),
            )
            end = hinge.point.at("E", L * A.x)
        else:
            damping = {"ratio": 0.5}
            body = kn.Beam(
                "rod",
                hinge.point,
                frame=A,
                axis=A.x,
                length=L,
                mass_per_length=rhoA,
                EI=EI,
                modes=1,
                form=form,
                damping=damping,
            )
            end = body.point_at(1)
        bodies = [body, kn.Particle("bob", end, 0.5)]
        system = kn.System(N, bodies=bodies, joints=[hinge], loads=[kn.gravity(9.81 * N.x)])
        start = {"q": [1.0, *[0.0] * (EI is not None)], "u": [0.0] * (1 + (EI is not None))}
        sol = kn.simulate(kn.derive(system), (0, 1), samples=3, rtol=1e-11, atol=1e-13, **start)
        return float(sol.q[-1, 0])

    rigid = angle(None)
    errors = [angle(EI) - rigid for EI in (1e4, 1e5)]
    assert abs(errors[0]) < 1e-2
    assert errors[0] / errors[1] == pytest.approx(10, rel=0.1)


@pytest.mark.slow
def test_chain_of_links_converges_to_the_beam() -> None:
    """Rigid links with springs EI/h between them, half a link's spring at the clamp: the frequency goes to the beam's as h²."""

    def chain(n: int) -> float:
        N = kn.Frame("N")
        O = kn.Point("O", fixed_in=N)
        h, A, P = 1.0 / n, N, O
        bodies: list[Any] = []
        joints: list[Any] = []
        loads: list[Any] = []
        for k in range(n):
            J = kn.pin(f"j{k}", P, A, axis=A.z)
            stiffness = n * (2.0 if k == 0 else 1.0)
            loads.append(kn.torsional_spring(J.frame, A, J.coordinates[0], stiffness, A.z))
            A = J.frame
            G = J.point.at(f"G{k}", h / 2 * A.x)
            bodies.append(kn.RigidBody(f"b{k}", frame=A, mass_center=G, mass=h, inertia=kn.rod(A, h, h, axis=A.x)))
            joints.append(J)
            P = J.point.at(f"P{k}", h * A.x)
        return float(frequencies(kn.System(N, bodies=bodies, joints=joints, loads=loads))()[0])

    errors = [abs(chain(n) - 3.516015269) for n in (8, 16)]
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.2)


@pytest.mark.slow
@FORMS
def test_sag_and_twist_in_space(form: str) -> None:
    """At rest, by statics: F L³/3EI in both directions, T L/GJ."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    L, EIv, EIw, GJ = 2.0, 5e3, 8e3, 3e3
    modes = kn.mode_shapes("legendre", 2)
    beam = kn.Beam(
        "bar", O, frame=N, axis=N.x, length=L, mass_per_length=1.0, EI=(EIv, EIw), modes=(modes, modes), GJ=GJ,
        torsion=kn.mode_shapes("legendre rod", 1), polar=0.01, form=form,
    )  # fmt: skip
    T, F = beam.point_at(1), beam.frame_at(1)
    load = kn.Force(T, 0.3 * N.y - 0.2 * N.z), kn.Torque(F, 0.005 * F.x)
    eom = kn.derive(kn.System(N, bodies=[beam], loads=list(load)))
    at = kn.equilibrium(eom, q=dict.fromkeys(eom.coordinates, kn.guess(0.0)))
    position = eom.evaluate(list(T.position(O).components(N)), q=at.q, u=dict.fromkeys(eom.speeds, 0.0))
    np.testing.assert_allclose(position[1:], [0.3 * L**3 / (3 * EIv), -0.2 * L**3 / (3 * EIw)], rtol=1e-5)
    twist = eom.evaluate([beam.coordinates[-1]], q=at.q, u=dict.fromkeys(eom.speeds, 0.0))[0]
    assert twist * float(kn.mode_shapes("legendre rod", 1).at(1)[0]) == pytest.approx(0.005 * L / GJ, rel=1e-5)


@pytest.mark.parametrize("form", ["linearized", pytest.param("nonlinear", marks=pytest.mark.slow)])
def test_loads_along_the_beam(form: str) -> None:
    """A weight per length is gravity, in every equation; one that grows as ξ bends the tip by 11 p L⁴/120EI."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    hinge = kn.pin("hinge", O, N, axis=N.z)
    A = hinge.frame
    beam = kn.Beam(
        "arm",
        hinge.point,
        frame=A,
        axis=A.x,
        length=2.0,
        mass_per_length=1.5,
        EI=2e4,
        modes=kn.mode_shapes("legendre", 4),
        form=form,
    )
    loads = kn.gravity(-9.81 * N.y), beam.distributed(-kn.parameter("p", 1.5 * 9.81, "N/m") * N.y)
    state = {"q": [0.4, 0.02, -0.01, 0.003, 0.001], "u": [0.0] * 5}
    own, other = (kn.derive(kn.System(N, bodies=[beam], joints=[hinge], loads=[x])).Fr for x in loads)
    eom = kn.derive(kn.System(N, bodies=[beam], joints=[hinge]))
    np.testing.assert_allclose(eom.evaluate(list(own), **state), eom.evaluate(list(other), **state), rtol=1e-9)
    p = kn.parameter("p", 3.0, "N/m")
    held = kn.Beam(
        "arm",
        O,
        frame=N,
        axis=N.x,
        length=2.0,
        mass_per_length=1.5,
        EI=2e4,
        modes=kn.mode_shapes("legendre", 4),
        form=form,
    )
    eom = kn.derive(kn.System(N, bodies=[held], loads=[held.distributed(lambda xi: p * xi * N.y)]))
    at = kn.equilibrium(eom, q=dict.fromkeys(eom.coordinates, kn.guess(0.0)))
    tip = eom.evaluate([held.point_at(1).position(O).dot(N.y)], q=at.q, u=dict.fromkeys(eom.speeds, 0.0))[0]
    assert tip == pytest.approx(11 * 3.0 * 2.0**4 / (120 * 2e4), rel=1e-8)
    with pytest.raises(kn.ModelError, match="a load per length on arm as a Vector"):
        held.distributed(3.0)  # type: ignore[arg-type]


@pytest.mark.slow
@pytest.mark.parametrize("field", ["v", "s"])
def test_damping_ratios(field: str) -> None:
    """Each mode at rest has the ratio asked for; Rayleigh's (α/ω + β ω)/2."""
    zeta, alpha, beta = 0.03, 0.2, 1e-3
    for damping, expected in (
        ({"ratio": zeta}, lambda w: zeta + 0 * w),
        ({"mass": alpha, "stiffness": beta}, lambda w: (alpha / w + beta * w) / 2),
    ):
        modes = kn.mode_shapes("legendre", 3)
        more = {"EA": 50.0, "stretch": kn.mode_shapes("legendre rod", 3)} if field == "s" else {}
        _, system = spinning(modes=modes, damping=damping, **more)
        rest = {"q": dict.fromkeys(system.coordinates, 0.0), "u": dict.fromkeys(system.speeds, 0.0)}
        eigenvalues = np.linalg.eigvals(kn.linearize(kn.derive(system), **rest, steady=False).A)
        omega = np.abs(eigenvalues)
        np.testing.assert_allclose(-eigenvalues.real / omega, expected(omega), rtol=1e-8)
