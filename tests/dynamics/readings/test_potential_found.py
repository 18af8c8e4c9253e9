# SPDX-License-Identifier: BSD-3-Clause
"""Potential energies found from forces alone, or refused with the reason."""

from __future__ import annotations

import random

import numpy as np
import pytest

import kane as kn
from kane.gallery import load as gallery_module

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
x, y = kn.coordinates("x y")
a, b = kn.coordinates("a b")
u1, u2, u3, u4 = U = kn.speeds("u1:5")
Q = (x, y, a, b)
k, g, l = kn.parameter("k", 7.0), kn.parameter("g", 9.81), kn.parameter("l", 0.4)
A = N.rotate("A", a, N.z)
B = A.rotate("B", b, A.x)
P = O.at("P", x * N.x + y * N.y)
S = P.at("S", l * B.z + 0.2 * B.y)
BODY = kn.RigidBody("body", frame=B, mass_center=P, mass=1.3, inertia=kn.inertia(B, 1.0, 2.0, 2.5))


def random_speeds(rng: random.Random) -> dict[kn.Speed, kn.Expr]:
    """u = (L + small functions of q) q̇ + z, invertible near where it is looked at."""
    mixed = {}
    for i, u in enumerate(U):
        definition = 3 * Q[i].dt + (rng.choice([0, kn.time, x * a]) if rng.random() < 0.3 else 0)
        for q in rng.sample(Q, 2):
            definition += rng.uniform(-0.5, 0.5) * rng.choice([1, kn.cos(a), kn.sin(b - a), kn.cos(y)]) * q.dt
        mixed[u] = definition
    return mixed


def random_potential(rng: random.Random) -> kn.Expr:
    """A sum of products of what energies are made of."""
    total = kn.Rational(0)
    for _ in range(rng.randint(1, 3)):
        p, q = rng.sample(Q, 2)
        total += rng.choice([
            k * p**rng.randint(1, 4) * q**rng.randint(0, 2),
            g * kn.sin(p) * kn.cos(q) ** rng.randint(1, 3),
            k * p**2 * kn.cos(2 * q - p),
            rng.uniform(1, 4) * (p - 0.3) * kn.sin(p + q),
            k * (kn.sqrt(p**2 + l**2 + q**2) - l) ** 2 / 2,
            g * kn.exp(-(p**2)) * q,
            kn.tanh(p) * kn.cos(q),
            k * kn.sqrt(l**2 + 1 - 2 * l * kn.cos(p - q)),
        ])  # fmt: skip
    return total


PULLS = {
    "spring": lambda: kn.linear_spring(S, O, k, 0.3),
    "gravity": lambda: kn.gravity(-g * N.y),
    "central": lambda: kn.Force(P, -P.position(O) * k / (P.position(O).dot(P.position(O)) + 1) ** 2, "central"),
    "constant": lambda: kn.Force(S, 3 * N.x - N.y, "constant"),
    "torsion": lambda: kn.Torque(A, -k * a**3 * N.z, "torsion"),
}


def bare(load: kn.Load | kn.Gravity) -> kn.Load | kn.Gravity:
    """Without the potential that it declares."""
    return kn.Load(load.name, load.forces, load.torques) if isinstance(load, kn.Load) else load


def agrees(eom: kn.Equations, found: kn.Expr, seed: int) -> None:
    """F_r = −Σ ∂V/∂q_s W_sr at random states."""
    rng = np.random.default_rng(seed)
    for _ in range(3):
        state = {"q": rng.uniform(0.2, 1.1, 4), "u": rng.uniform(-1, 1, 4), "t": 0.3}
        slopes = np.array(eom.evaluate(kn.gradient(found, Q), **state))
        forces, w = np.array(eom.evaluate(eom.Fr, **state)), eom.evaluate(eom.W, **state)
        assert forces == pytest.approx(-slopes @ w, rel=1e-9, abs=1e-9 * np.abs(slopes).max())


def conservative(seed: int) -> None:
    rng = random.Random(seed)
    own = [kn.Load.from_potential(random_potential(rng), "V"), bare(PULLS[rng.choice(list(PULLS))]())]
    eom = kn.derive(kn.System(N, bodies=[BODY], speeds=random_speeds(rng), loads=own, coordinates=Q))
    agrees(eom, eom.find_potential().value, seed)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(12))
def test_found_for_random_loads(seed):
    conservative(seed)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(12, 50))
def test_found_for_many_random_loads(seed):
    conservative(seed)


SPOILS = {
    "follower": lambda f: kn.Force(S, f * B.y, "spoil"),
    "whirl": lambda f: kn.Force(P, f * (y * N.x - x * N.y), "spoil"),
    "one way": lambda f: kn.Torque(A, f * x * N.z, "spoil"),
    "damper": lambda f: kn.torsional_damper(A, N, f, N.z, "spoil"),
    "magnet": lambda f: kn.Force(P, f * N.z.cross(P.velocity(N)), "spoil"),
}  # fmt: skip


def refused(seed: int) -> None:
    rng = random.Random(seed)
    kind = rng.choice(list(SPOILS))
    own = [kn.Load.from_potential(random_potential(rng), "V"), SPOILS[kind](10 ** rng.uniform(-4, 4))]
    eom = kn.derive(kn.System(N, bodies=[BODY], speeds=random_speeds(rng), loads=own, coordinates=Q))
    rates = kind in ("damper", "magnet")
    with pytest.raises(kn.PotentialError, match="depend on the rate" if rates else r"∂Q_\w/∂\w = .* but ∂Q_"):
        eom.find_potential()
    agrees(kn.derive(eom.system.replace(loads=own[:1])), eom.find_potential(["V"]).value, seed)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(12))
def test_refused_for_random_loads(seed):
    refused(seed)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(12, 50))
def test_refused_for_many_random_loads(seed):
    refused(seed)


def test_closed_forms_say_so_and_rules_too():
    eom = kn.derive(kn.System(N, bodies=[BODY], speeds="rates", loads=[kn.Load.from_potential(k * x**2 * kn.cos(a))]))
    assert eom.find_potential().how == "closed form"
    assert str(eom.find_potential().value) == "k*x^2*cos(a)"
    rough = kn.Force(P, -kn.exp(-(x**2)) * N.x, "wall")
    eom = kn.derive(kn.System(N, bodies=[BODY], speeds="rates", loads=[rough]))
    found = eom.find_potential()
    assert found.how == "Gauss's rule of 20 points along x"
    assert kn.evaluate(found.value, {x: 0.7}) == pytest.approx(0.6006856690, abs=1e-9)  # √π/2 erf 0.7


def test_a_gradient_in_another_unit_is_judged_alike():
    small = kn.Force(P, 1e-12 * (y * N.x + 1.0001 * x * N.y), "whirl")
    eom = kn.derive(kn.System(N, bodies=[BODY], speeds="rates", loads=[small]))
    with pytest.raises(kn.PotentialError, match="∂Q_x/∂y"):
        eom.find_potential()


def test_loads_are_known_by_name_only_if_they_are_the_systems():
    eom = kn.derive(kn.System(N, bodies=[BODY], speeds="rates", loads=[kn.gravity(-g * N.y)]))
    with pytest.raises(kn.PotentialError, match="Expected some of the loads of the system \\(gravity\\), got 'wind'"):
        eom.find_potential(["wind"])


def test_loads_of_one_name_are_told_apart():
    pulls = kn.Load("pull", ((P, -k * x * N.x),)), kn.Load("pull", ((P, -3 * y * N.y),))
    eom = kn.derive(kn.System(N, bodies=[BODY], speeds="rates", loads=pulls))
    for load, declared, slopes in zip(eom.loads, pulls, ((7.0 * 0.3, 0), (0, 3 * 0.5)), strict=True):
        for given in (load, declared):
            v = eom.find_potential([given]).value
            assert kn.evaluate([kn.diff(v, x), kn.diff(v, y)], {x: 0.3, y: 0.5}) == pytest.approx(slopes)
    with pytest.raises(kn.PotentialError, match=r"got .pull., the name of 2 of them\. Give the load itself"):
        eom.find_potential(["pull"])
    both = kn.Load.from_potential(k * x**2 / 2), kn.Load.from_potential(y**2)
    held = kn.derive(kn.System(N, bodies=[BODY], speeds="rates", loads=both))
    for load, slopes in zip(both, ((7.0 * 0.3, 0), (0, 2 * 0.5)), strict=True):
        v = held.find_potential(load).value
        assert kn.evaluate([kn.diff(v, x), kn.diff(v, y)], {x: 0.3, y: 0.5}) == pytest.approx(slopes)
    energy = next(i.value for i in eom.integrals if i.name == "energy")
    rest = dict.fromkeys((*eom.speeds, a, b), 0.0)
    assert kn.evaluate(energy, {x: 0.3, y: 0.5, **rest}) == pytest.approx(3.5 * 0.3**2 + 1.5 * 0.5**2)


# Under constraints -------------------------------------------------------------------------------------------------------


def skate(load: kn.Load) -> kn.Equations:
    blade = kn.motion_constraint("blade", P.velocity(N).dot(A.y))
    return kn.derive(kn.System(N, bodies=[BODY], speeds="rates", loads=[load], nonholonomic=[blade], coordinates=Q))


def test_forces_that_the_blade_holds_do_not_count():
    """Across the blade a force that depends on the angle has no work: F̃_r = 0, and V is a constant of the others."""
    eom = skate(kn.Load("across", ((P, 5 * x * A.y),), ((A, -3 * a * N.z),)))
    found = eom.find_potential()
    assert kn.evaluate(kn.diff(found.value, a), {a: 0.4}) == pytest.approx(1.2)
    assert {str(s) for s in kn.free_symbols([found.value])} == {"a"}


def test_along_the_blade_a_drive_has_none():
    with pytest.raises(kn.PotentialError, match="along the motions that the constraints allow"):
        skate(kn.Load("drive", ((P, 5 * A.x),))).find_potential()


def test_on_a_circle_every_force_of_the_angle_has_one():
    """x = cos a, y = sin a: a follower force of constant size does 2 per rad."""
    bead = kn.Particle("bead", P, 1.0)
    spin = kn.RigidBody("wheel", frame=A, mass_center=O, mass=1, inertia=kn.inertia(A, 1, 1, 1))
    ring = (kn.configuration_constraint("cx", x - kn.cos(a)), kn.configuration_constraint("cy", y - kn.sin(a)))
    follower = kn.Load("follower", ((P, 2 * A.y),))
    eom = kn.derive(
        kn.System(N, bodies=[bead, spin], speeds="rates", loads=[follower], holonomic=ring, coordinates=(x, y, a))
    )
    found = eom.find_potential().value
    here = {x: np.cos(0.3), y: np.sin(0.3), a: 0.3}
    ways = kn.gradient(found, (x, y, a))
    moved = kn.evaluate(list(ways), here) @ np.array([-np.sin(0.3), np.cos(0.3), 1.0])
    assert moved == pytest.approx(-2.0)


def test_a_parameter_that_is_zero_by_default_counts():
    """What is said holds for all values of parameters, not for their defaults alone."""
    swirl = kn.parameter("swirl", 0.0)
    eom = kn.derive(
        kn.System(N, bodies=[BODY], speeds="rates", loads=[kn.Force(P, swirl * (y * N.x - x * N.y), "swirl")])
    )
    with pytest.raises(kn.PotentialError, match="∂Q_x/∂y"):
        eom.find_potential()
    alike, other = kn.parameter("k1", 2.0), kn.parameter("k2", 2.0)
    eom = kn.derive(
        kn.System(N, bodies=[BODY], speeds="rates", loads=[kn.Force(P, alike * y * N.x + other * x * N.y, "pair")])
    )
    with pytest.raises(kn.PotentialError, match="∂Q_x/∂y"):
        eom.find_potential()


# Euler parameters --------------------------------------------------------------------------------------------------------


def floating(*loads: kn.Load | kn.Gravity) -> kn.Equations:
    """A body by Euler parameters on a spherical joint; `M` is a point of it."""
    e = kn.coordinates("e0:4")
    C = N.rotate_euler_parameters("C", e)
    M = O.at("M", 0.3 * C.x + 0.1 * C.z)
    body = kn.RigidBody("body", frame=C, mass_center=M, mass=2.0, inertia=kn.inertia(C, 1, 2, 2.5))
    w = kn.speeds("w1:4")
    speeds = dict(zip(w, C.angular_velocity(N).components(C), strict=True))
    return kn.derive(kn.System(N, bodies=[body], speeds=speeds, loads=[load(C, M) for load in loads]))


def test_gravity_and_springs_by_euler_parameters():
    T = O.at("T", 0.5 * N.x + 0.2 * N.y)
    for load in (lambda C, M: kn.gravity(-g * N.z), lambda C, M: bare(kn.linear_spring(M, T, k, 0.1))):
        eom = floating(load)
        found = eom.find_potential()
        for seed in range(3):
            rng = np.random.default_rng(seed)
            q = rng.normal(size=4)
            state = {"q": q / np.linalg.norm(q), "u": rng.uniform(-1, 1, 3)}
            power = eom.evaluate(sum(eom.load_powers.values()), **state)
            assert -eom.evaluate(eom.time_derivative(found.value), **state) == pytest.approx(power, rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("axis", ["inertial", "body"])
def test_constant_torques_have_none(axis):
    with pytest.raises(kn.PotentialError, match="along the motions that the constraints allow"):
        floating(lambda C, M: kn.Torque(C, 2.0 * (N.z if axis == "inertial" else C.z), "motor")).find_potential()


@pytest.mark.parametrize(
    "name", ["double_pendulum", "furuta_pendulum", "particle_on_spring", "spinning_top", "rotating_beam"]
)
def test_declared_potentials_are_found_again(name):
    """Gravity, springs and the elasticity of beams of the gallery: ∂V/∂q of what is found and of what is declared."""
    eom = kn.derive(gallery_module(name).system())
    at = {"q": np.linspace(0.3, 0.9, len(eom.coordinates)), "u": np.zeros(len(eom.speeds))}
    for load in eom.system.all_loads():
        if load.potential is not None:
            found = eom.find_potential([load]).value
            pair = [list(kn.gradient(v, eom.coordinates)) for v in (found, load.potential)]
            own, declared = (np.array(x) for x in eom.evaluate(pair, **at))
            assert own == pytest.approx(declared, rel=1e-10, abs=1e-12 * np.abs(declared).max())


def under_a_blade(seed: int) -> None:
    """A random V of all coordinates, and a force across the blade of any size: F̃_r = −Σ ∂V/∂q_s (W_sr + Σ_D W_sD A_n[D, r])."""
    rng = random.Random(seed)
    v = rng.uniform(1, 3) * x**2 * y + k * kn.cos(a - 0.3 * y) + rng.uniform(1, 3) * x * kn.sin(b)
    across = rng.uniform(2, 5) * (x * y + kn.cos(a) + rng.uniform(0, 2) * b)
    blade = kn.motion_constraint("blade", P.velocity(N).dot(A.y))
    loads = [kn.Load.from_potential(v, "V"), kn.Force(P, across * A.y, "wall")]
    eom = kn.derive(
        kn.System(N, bodies=[BODY], speeds=random_speeds(rng), loads=loads, nonholonomic=blade, coordinates=Q)
    )
    found = eom.find_potential().value
    numbers = np.random.default_rng(seed)
    u = dict(zip(eom.independent_speeds, numbers.uniform(-1, 1, 3), strict=True))
    state = {"q": numbers.uniform(0.2, 1.1, 4), "u": u, "t": 0.3}
    slopes = np.array(eom.evaluate(kn.gradient(found, Q), **state))
    forces, w, a_n = eom.evaluate([list(eom.Fr_nh), eom.W, eom.A_n], **state)
    free, given = ([eom.speeds.index(u) for u in own] for own in (eom.independent_speeds, eom.dependent_speeds))
    assert np.array(forces) == pytest.approx(-slopes @ (w[:, free] + w[:, given] @ a_n), rel=1e-8, abs=1e-8)


@pytest.mark.parametrize("seed", range(2))
def test_found_beside_forces_that_constraints_hold(seed):
    under_a_blade(seed)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2, 8))
def test_found_beside_more_forces_that_constraints_hold(seed):
    under_a_blade(seed)
