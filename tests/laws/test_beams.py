# SPDX-License-Identifier: BSD-3-Clause
"""Laws of systems with flexible beams: momenta and energy, power, reactions, limits, frequencies with masses at the ends."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

import kane as kn
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


def check_kept(system: kn.System, O: kn.Point, rng: np.random.Generator, end: float) -> None:
    eom = kn.derive(system)
    sol = kn.simulate(eom, (0, end), samples=21, rtol=1e-11, atol=1e-12, **started(system, rng))
    momenta = [eom.linear_momentum(), eom.angular_momentum(O)]
    for vector in momenta:
        rows = np.array([sol[x] for x in vector.components(system.inertial)])
        assert np.ptp(rows, axis=1).max() < 1e-9 * np.abs(rows).max()
    assert np.ptp(sol.energy) < 1e-9 * np.abs(sol.energy).max()


@FORMS
def test_free_in_a_plane(form: str, rng: np.random.Generator) -> None:
    system, O = free_flyer(form)
    check_kept(system, O, rng, 2.0)


@pytest.mark.slow
@FORMS
def test_free_in_space(form: str, rng: np.random.Generator) -> None:
    system, O = free_flyer(form, space=True)
    check_kept(system, O, rng, 2.0)


@pytest.mark.slow
def test_free_over_a_hundred_periods(rng: np.random.Generator) -> None:
    system, O = free_flyer("linearized")
    first = frequencies(system)()[0]
    check_kept(system, O, rng, 100 * 2 * np.pi / first)


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


@FORMS
def test_reactions_at_the_root_are_rates_of_momenta(form: str, rng: np.random.Generator) -> None:
    """The force and torque that an auxiliary speed brings into evidence, what Newton and Euler say of the far side, and dp/dt."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    hinge = kn.pin("hinge", O, N, axis=N.z)
    A = hinge.frame
    root = hinge.point.at("root", 0)
    beam = kn.Beam("arm", root, frame=A, axis=A.x, length=2.0, mass_per_length=1.5, EI=20.0, modes=2, form=form)
    bob = kn.Particle("bob", beam.point_at(1), 0.4)
    names = [kn.reaction(f"R{k}", at=root, along=e) for k, e in enumerate((N.x, N.y))]
    gravity = kn.gravity(-9.81 * N.y)
    system = kn.System(N, bodies=[beam, bob], joints=[hinge], reactions=names, loads=[gravity])
    eom = kn.derive(system)
    state = {
        "q": {q: 0.05 * rng.standard_normal() for q in system.coordinates},
        "u": {u: rng.standard_normal() for u in system.speeds},
    }
    found = eom.evaluate(names, **state)
    force = eom.reaction(hinge).force
    assert force is not None
    newton = eom.evaluate(list(force.components(N)), **state)[:2]
    rate = [eom.time_derivative(x) for x in eom.linear_momentum().components(N)[:2]]
    weight = (3.0 + 0.4) * 9.81
    momentum = np.add(eom.evaluate(rate, **state), [0, weight])
    np.testing.assert_allclose(found, momentum, rtol=1e-10)
    np.testing.assert_allclose(newton, momentum, rtol=1e-10)


@pytest.mark.parametrize("ratio", [0.1, 10.0])
def test_tip_mass(ratio: float) -> None:
    """1 + cos β cosh β + μ β (cos β sinh β − sin β cosh β) = 0."""
    beam, system = spinning(modes=kn.mode_shapes("polynomials", 10))
    system = system.replace(bodies=[beam, kn.Particle("tip", beam.point_at(1), ratio)])

    def equation(b: float) -> float:
        return float(1 / np.cosh(b) + np.cos(b) + ratio * b * (np.cos(b) * np.tanh(b) - np.sin(b)))

    expected = [brentq(equation, 0.5 + k * np.pi, 0.5 + (k + 1) * np.pi, xtol=1e-14) ** 2 for k in range(3)]
    np.testing.assert_allclose(frequencies(system)()[:3], expected, rtol=1e-8)


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
