# SPDX-License-Identifier: BSD-3-Clause
"""Bodies in the ground that move with joints elsewhere: rotors whose stators stand still, and counterweights."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane.dynamics import WAYS
from tests.dynamics.test_tree_slopes import check
from tests.examples import examples
from tests.oracles.compare import tolerance
from tests.systems.closed_states import states

COUNTERWEIGHT = "counterweight"


def arm(seed, parents, *, moved=range(100), speeds="rates", held=False, felt=False):
    """Links about axes in turn, each with a rotor in the ground, but the first with a counterweight; ratios of their own.

    `moved` are the links with rotors; the last may be `held` by a rod to the ground, and what the first is borne with may be `felt`.
    """
    rng = np.random.default_rng(seed)
    N, g = kn.Frame("N"), kn.parameter("g", 9.81)
    O = kn.Point("O", fixed_in=N)
    coordinates = kn.coordinates(" ".join(f"q{k}" for k in range(len(parents))))
    frames, ends, bodies, reactions, loads = [], [], [], [], [kn.gravity(-g * N.z)]
    for k, (parent, q) in enumerate(zip(parents, coordinates, strict=True)):
        base, at = (N, O) if parent < 0 else (frames[parent], ends[parent])
        axes = base.x, base.y, base.z
        link = base.rotate(f"A{k}", q, axes[(k + seed) % 3])
        joint = at.at(
            f"J{k}", sum((float(x) * axis for x, axis in zip(rng.uniform(-1, 1, 3), axes, strict=True)), kn.Vector())
        )
        own = link.x, link.y, link.z
        centre = joint.at(
            f"C{k}", sum((float(x) * axis for x, axis in zip(rng.uniform(-1, 1, 3), own, strict=True)), kn.Vector())
        )
        m = kn.parameter(f"m{k}", float(rng.uniform(1, 2)))
        inertia = kn.inertia(link, *map(float, rng.uniform(0.8, 1.2, 3)), *map(float, rng.uniform(-0.1, 0.1, 3)))
        bodies.append(kn.RigidBody(f"link {k}", frame=link, mass_center=centre, mass=m, inertia=inertia))
        if felt and k == 0:
            reactions += [kn.reaction("bearing", frame=link, along=axes[(k + 1 + seed) % 3])]
        frames.append(link)
        ends.append(joint.at(f"E{k}", float(rng.uniform(0.5, 1)) * link.y))
        ratio = float(rng.uniform(-3, 3))
        if k == 0 and k in moved:
            bodies.append(
                kn.Particle(COUNTERWEIGHT, O.at("W", (ratio * q + 0.3) * N.z + 0.2 * N.x), kn.parameter("mW", 0.7))
            )
        elif k in moved:
            rotor, J = N.rotate(f"R{k}", ratio * q, N.x), kn.parameter(f"J{k}", float(rng.uniform(0.1, 0.5)))
            bodies.append(
                kn.RigidBody(f"rotor {k}", frame=rotor, mass_center=O, mass=0.3, inertia=kn.inertia(rotor, J, 0.2, 0.3))
            )
            loads.append(kn.Torque(rotor, (kn.parameter("T", 0.8) - 0.3 * q.dt + kn.sin(q)) * (rotor.x + 0.5 * N.y)))
    edge = [kn.no_slip(ends[-1], along=0.6 * N.x + 0.8 * N.y, name="edge")] if held else []
    return kn.System(N, bodies=bodies, speeds=speeds, loads=loads, nonholonomic=edge, reactions=reactions)


TREES = st.sampled_from([(-1, 0), (-1, 0, 1), (-1, 0, 0, 2), (-1, 0, 1, 1, 3)])


def compared(system, rng, routes=tuple(WAYS)):
    """Of each route what the classical one gives: u̇, reactions, multipliers, M and the kinetic energy."""
    usual, *others = (kn.derive(system, route=route) for route in ("classical", *routes))
    drawn = (
        states(usual, rng, 3, reach=1.0) if usual.system.constraints else rng.uniform(-1, 1, (3, 2, len(usual.speeds)))
    )
    for q, u in drawn:
        at = {"q": q, "u": u}
        condition = np.linalg.cond(np.array(usual.evaluate(usual.mass_matrix, **at)))
        wanted, *found = (
            np.array(e.evaluate([*e.accelerations, *e.reactions, *e.multipliers.values(), e.kinetic_energy], **at))
            for e in (usual, *others)
        )
        for x in found:
            assert np.abs(x - wanted).max() <= tolerance(1e-10, condition) * np.abs(wanted).max()
    return usual, others


@examples(0.1)
@given(st.integers(0, 10**6), TREES, st.booleans(), st.booleans())
def test_accelerations_reactions_and_energy(seed, parents, held, felt):
    routes = ["recursive"] if felt else list(WAYS)
    _, others = compared(arm(seed, parents, held=held, felt=felt), np.random.default_rng(seed), routes)
    assert [e.route for e in others] == routes


@examples(0.05, 3)
@given(st.integers(0, 10**6), TREES)
def test_derivatives_by_every_symbol(seed, parents):
    """Those of masses and inertias that are reflected, too."""
    check(kn.derive(arm(seed, parents)), np.random.default_rng(seed))


@examples(0.05, 3)
@given(st.integers(0, 10**6), TREES)
def test_forces_that_a_motion_takes(seed, parents):
    """Inverse dynamics along the tree leaves nothing at the u̇ of the classical route."""
    system, rng = arm(seed, parents), np.random.default_rng(seed)
    usual = kn.derive(system, route="classical")
    left = kn.derive(system).inverse_dynamics
    q, u = rng.uniform(-1, 1, (2, len(usual.speeds)))
    u_dot = usual.evaluate(usual.accelerations, q=q, u=u)
    values = {p: p.default for p in usual.parameters} | dict(zip(usual.coordinates, q, strict=True))
    values |= dict(zip(usual.speeds, u, strict=True)) | {x.dt: v for x, v in zip(usual.speeds, u_dot, strict=True)}
    force = usual.evaluate(usual.mass_matrix, q=q, u=u) @ np.array(u_dot)
    assert np.array(kn.evaluate(left, values)) == pytest.approx(0, abs=1e-11 * np.abs(force).max())


def test_by_hand():
    """A drum with a rotor that it drives thrice as fast, and a weight on its rope: (J + 9 J_r + m r²) q̈ = −m g r."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    q = kn.coordinate("q")
    drum, rotor = N.rotate("drum", q, N.y), N.rotate("rotor", 3 * q, N.z)
    arm = drum.rotate("arm", kn.coordinate("p"), drum.x)
    bodies = [
        kn.RigidBody("drum", frame=drum, mass_center=O, mass=2, inertia=kn.inertia(drum, 1, 0.5, 1)),
        kn.RigidBody("arm", frame=arm, mass_center=O, mass=1, inertia=kn.inertia(arm, 0.1, 0.2, 0.2)),
        kn.RigidBody("rotor", frame=rotor, mass_center=O, mass=1, inertia=kn.inertia(rotor, 1, 1, 0.01)),
        kn.Particle("weight", O.at("W", 0.3 * q * N.z), 4),
    ]
    for route in WAYS:
        eom = kn.derive(kn.System(N, bodies=bodies, speeds="rates", loads=[kn.gravity(-10 * N.z)]), route=route)
        found = eom.evaluate(eom.accelerations, q=[0.7, 0.2], u=[0, 0])
        assert found == pytest.approx([-4 * 10 * 0.3 / (0.5 + 0.2 + 9 * 0.01 + 4 * 0.09), 0], rel=1e-14)


@pytest.mark.parametrize("route", WAYS)
def test_rotors_cost_little(route):
    """Beside the same arm without them, the torques of five motors included."""
    parents = (-1, 0, 1, 2, 3, 4)
    bare, whole = (kn.derive(arm(1, parents, moved=moved), route=route).operations.total for moved in ((), range(1, 6)))
    assert whole < {"recursive": 1.25, "composite": 1.05}[route] * bare
