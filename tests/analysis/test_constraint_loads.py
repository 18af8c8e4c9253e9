# SPDX-License-Identifier: BSD-3-Clause
"""Forces of constraints in two ways."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.gallery import load


@pytest.mark.slow
@pytest.mark.parametrize("evident", [True, False])
@pytest.mark.parametrize("name", ["four_bar", "chaplygin_sleigh", "pure_rolling_disk", "knife_edge"])
def test_both_ways_agree(name, evident):
    """With the reactions that the system brings into evidence, and without."""
    system = load(name).system()
    eom = kn.derive(system if evident else system.replace(reactions=()))
    rng = np.random.default_rng(4)
    q = dict(zip(eom.coordinates, rng.uniform(0.3, 0.8, len(eom.coordinates)), strict=True))
    if eom.system.holonomic:
        q = kn.assemble(eom, q={eom.coordinates[0]: 0.7}).q
    u = dict(zip(eom.independent_speeds, rng.uniform(-1, 1, len(eom.independent_speeds)), strict=True))
    found = kn.constraint_forces(eom, q=q, u=u)
    ways = [np.array(list(way.values())) for way in (found.by_multipliers, found.by_auxiliary_speeds)]
    assert ways[0] == pytest.approx(ways[1], rel=1e-10, abs=1e-11 * np.abs(ways[0]).max())
    assert "by multipliers" in repr(found)


def test_scalars_have_no_places():
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, y = kn.coordinates("x y")
    bead = kn.Particle("bead", O.at("B", x * N.x + y * N.y), 1.0)
    eom = kn.derive(kn.System(N, bodies=[bead], speeds="rates", holonomic=x - y**2, coordinates=(x, y)))
    with pytest.raises(kn.SimulationError, match="say where their forces act"):
        kn.constraint_forces(eom, q=[0.25, 0.5], u={})


@pytest.mark.parametrize("mu", [0.1, 0.3, 0.9])
@pytest.mark.parametrize("across", [1, 0])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_particle_that_slips_along_a_wall(sign, across, mu):
    """Both ways along both axes: v_n' = −e v_n, and friction takes μ (1 + e) |v_n| of the slip, all of it at most."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, y = kn.coordinates("x y")
    P = O.at("P", x * N.x + y * N.y)
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("p", P, 2.0)], speeds="rates"))
    normal, before = (N.y, [sign, -1.0]) if across else (N.x, [-1.0, sign])
    blow = kn.impact(eom, P, normal, restitution=0.5, friction=mu, q=[0, 0], u=before)
    left = max(1.0 - 1.5 * mu, 0.0)
    wanted = [sign * left, 0.5] if across else [0.5, sign * left]
    assert list(blow.u.values()) == pytest.approx(wanted, abs=1e-14)
    assert blow.slips is (left > 0)


def test_impacts_of_what_has_no_mass_and_at_many_states_are_refused():
    N = kn.Frame("N")
    m, y = kn.parameter("m", 1.0), kn.coordinate("y")
    P = kn.Point("O", fixed_in=N).at("P", y * N.y)
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("p", P, m)], speeds="rates"))
    with pytest.raises(kn.SingularError, match="speeds that all move some mass, got none moved by "):
        kn.impact(eom, P, N.y, restitution=0.5, q=[0], u=[-1.0], parameters={m: 0.0})
    with pytest.raises(kn.ArgumentError, match="one state, got arrays"):
        kn.impact(eom, P, N.y, restitution=0.5, q=[0], u=[np.array([-1.0, -2.0])])


def test_an_impact_is_the_same_whichever_way_its_body_heads():
    """A slender body slips in a direction beside which few others do; speeds along its own axes do not know of the heading."""
    N = kn.Frame("N")
    heading, tilt, roll, x, y, z = kn.coordinates("heading tilt roll x y z")
    B = N.rotate_body("B", (heading, tilt, roll), "zxy")
    center = kn.Point("O", fixed_in=N).at("B*", x * N.x + y * N.y + z * N.z)
    body = kn.RigidBody("b", frame=B, mass_center=center, mass=1, inertia=kn.inertia(B, 1, 0.001, 1))
    speeds = {
        kn.speed(f"{name}{axis}"): motion.dot(getattr(B, axis))
        for name, motion in (("v", center.velocity(N)), ("w", B.angular_velocity(N)))
        for axis in "xyz"
    }
    eom = kn.derive(kn.System(N, bodies=[body], speeds=speeds))
    end = center.fixed_in(B, "end", -0.5 * B.x + 0.2 * B.y + 0.4 * B.z)
    before = [0.3, 0.8, -0.2, 0, 0, 0]
    blows = [
        kn.impact(eom, end, N.z, restitution=0.5, friction=0.5, q=[angle, -0.4, 0.6, 0, 0, 0], u=before)
        for angle in np.linspace(-3, 3, 13)
    ]
    assert all(blow.slips for blow in blows)
    after = np.array([list(blow.u.values()) for blow in blows])
    np.testing.assert_allclose(after, np.tile(after[0], (13, 1)), rtol=1e-10)
