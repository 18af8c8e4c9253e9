# SPDX-License-Identifier: BSD-3-Clause
"""Mass centres and inertias about any point against sums over point masses."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn

m, L, k = kn.parameter("m", 2.0, "kg"), kn.parameter("L", 1.5, "m"), kn.parameter("k", 0.7, "kg")


@pytest.fixture
def arm():
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    q = kn.coordinate("q", "rad")
    B = N.rotate("B", q, N.z)
    C = O.at("C", L / 2 * B.x)
    rod = kn.RigidBody("rod", frame=B, mass_center=C, mass=m, inertia=kn.rod(B, m, L, B.x))
    tip = kn.Particle("tip", O.at("T", L * B.x), k)
    return N, O, B, rod, tip


def test_of_a_pendulum(arm):
    _, O, B, rod, tip = arm
    assert str(kn.mass_center([rod, rod], O)) == "L/2 B.x"
    assert str(kn.inertia_about(rod, O)) == "(m*L^2/3 B.y)(B.y) + (m*L^2/3 B.z)(B.z)"
    assert str(kn.moment_of_inertia([rod, tip], O, B.z)) == "L^2*(k + m/3)"
    assert kn.unit_of(kn.moment_of_inertia([rod, tip], O, B.z)) == "kg*m^2"
    assert str(kn.radius_of_gyration(tip, O, B.z)) == "sqrt(L^2)"
    assert kn.evaluate(kn.radius_of_gyration(rod, O, B.z), {}) == pytest.approx(1.5 / np.sqrt(3), rel=1e-15)


@pytest.fixture
def cloud(rng):
    """Twenty particles, half of them in a frame that is turned."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    A = N.rotate("A", kn.Rational(2, 5), N.y)
    c, s = np.cos(0.4), np.sin(0.4)
    turn = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    own, masses = rng.normal(size=(20, 3)), rng.uniform(0.5, 2, 20)
    frames = [N, A] * 10
    bodies = [
        kn.Particle(f"P{i}", O.at(f"Q{i}", float(r[0]) * f.x + float(r[1]) * f.y + float(r[2]) * f.z), float(w))
        for i, (r, w, f) in enumerate(zip(own, masses, frames, strict=True))
    ]
    points = np.array([r if f is N else turn @ r for r, f in zip(own, frames, strict=True)])
    return N, O, bodies, points, masses


def sums(points, masses):
    return sum(w * ((r @ r) * np.eye(3) - np.outer(r, r)) for r, w in zip(points, masses, strict=True))


def test_of_many_particles(cloud):
    N, O, bodies, points, masses = cloud
    center = masses @ points / masses.sum()
    np.testing.assert_allclose(kn.evaluate(kn.mass_center(bodies, O).components(N), {}), center, rtol=1e-13)
    Q = O.at("Q", 0.3 * N.x - 0.2 * N.y + N.z)
    about = sums(points - [0.3, -0.2, 1], masses)
    np.testing.assert_allclose(kn.evaluate(kn.inertia_matrix(bodies, Q, N), {}), about, rtol=1e-13)
    n, e = (2 * N.x - N.y + 2 * N.z) / 3, N.y
    unit, y = np.array([2, -1, 2]) / 3, np.array([0, 1, 0])
    vector = kn.evaluate(kn.inertia_vector(bodies, Q, n).components(N), {})
    np.testing.assert_allclose(vector, about @ unit, rtol=1e-12)
    assert kn.evaluate(kn.moment_of_inertia(bodies, Q, n), {}) == pytest.approx(unit @ about @ unit, rel=1e-13)
    assert kn.evaluate(kn.product_of_inertia(bodies, Q, n, e), {}) == pytest.approx(unit @ about @ y, rel=1e-12)


def test_parallel_axes_there_and_back(cloud):
    N, O, bodies, _points, masses = cloud
    r = kn.mass_center(bodies, O)
    total = float(masses.sum())
    center = O.at("S", r)
    central = kn.central_inertia(kn.inertia_about(bodies, O), total, r)
    np.testing.assert_allclose(
        kn.evaluate(central.components(N), {}), kn.evaluate(kn.inertia_matrix(bodies, center, N), {}), rtol=1e-11, atol=1e-12
    )  # fmt: skip
    back = kn.parallel_axis(central, total, r)
    np.testing.assert_allclose(
        kn.evaluate(back.components(N), {}), kn.evaluate(kn.inertia_matrix(bodies, O, N), {}), rtol=1e-11, atol=1e-12
    )  # fmt: skip


def test_composites_are_sums(cloud):
    N, O, bodies, points, masses = cloud
    whole = kn.composite("whole", bodies, N)
    center = masses @ points / masses.sum()
    assert kn.evaluate(whole.mass, {}) == pytest.approx(masses.sum(), rel=1e-14)
    np.testing.assert_allclose(kn.evaluate(whole.mass_center.position(O).components(N), {}), center, rtol=1e-13)
    found = kn.evaluate(whole.inertia.components(N), {})
    np.testing.assert_allclose(found, sums(points - center, masses), rtol=1e-12, atol=1e-13)


def test_holes_are_cut_out(arm):
    """A disk with a round hole is a disk less a disk (areas R² and r²)."""
    _N, O, B, *_ = arm
    disk = kn.RigidBody("disk", frame=B, mass_center=O.at("D", 0), mass=4, inertia=kn.thin_disk(B, 4, 2, B.z))
    hole = kn.RigidBody("hole", frame=B, mass_center=O.at("H", B.x), mass=1, inertia=kn.thin_disk(B, 1, 1, B.z))
    left = kn.composite("left", disk, B, without=hole)
    assert str(left.mass_center.position(O)) == "-1/3 B.x"
    r = np.array([-1 / 3, 0, 0])
    about_O = 4 * 4 * np.diag([0.25, 0.25, 0.5]) - np.diag([0.25, 0.25, 0.5]) - np.diag([0, 1, 1])
    expected = about_O - 3 * (r @ r * np.eye(3) - np.outer(r, r))
    np.testing.assert_allclose(kn.evaluate(left.inertia.components(B), {}), expected, rtol=1e-14)


def test_a_composite_moves_as_its_bodies_do(arm):
    """The same equations of motion from the pendulum as one body and as two."""
    N, _, B, rod, tip = arm
    g = kn.gravity(-9.81 * N.y)
    made = [
        kn.derive(kn.System(N, bodies=b, speeds="rates", loads=[g]))
        for b in ([rod, tip], [kn.composite("c", [rod, tip], B)])
    ]
    one, other = (e.evaluate(e.accelerations, q=[0.4], u=[0.2]) for e in made)
    np.testing.assert_allclose(one, other, rtol=1e-13)


def test_inertia_about_another_point_of_the_body(arm):
    N, O, B, rod, _ = arm
    same = kn.RigidBody(
        "rod", frame=B, mass_center=rod.mass_center, mass=m, inertia=(kn.inertia(B, 0, m * L**2 / 3, m * L**2 / 3), O)
    )
    np.testing.assert_allclose(
        kn.evaluate(same.inertia.components(B), {}), kn.evaluate(rod.inertia.components(B), {}), atol=1e-16
    )
    loose = O.at("Z", L * N.x)
    with pytest.raises(kn.ModelError, match="depends on q"):
        kn.RigidBody("rod", frame=B, mass_center=rod.mass_center, mass=m, inertia=(rod.inertia, loose))
    with pytest.raises(kn.ModelError, match=r"inertia=\(dyadic, point\)"):
        kn.RigidBody("rod", frame=B, mass_center=rod.mass_center, mass=m, inertia=(O, rod.inertia))
    with pytest.raises(kn.ModelError, match="m r², not smaller"):
        kn.RigidBody("rod", frame=B, mass_center=rod.mass_center, mass=m, inertia=(rod.inertia, O))


def test_errors_say_what_to_do(arm):
    N, O, B, rod, tip = arm
    with pytest.raises(kn.ModelError, match=r"kn.Particle\(name, point, mass\)"):
        kn.mass_center(O, O)
    with pytest.raises(kn.ModelError, match="Expected the Point"):
        kn.mass_center(rod, N)
    with pytest.raises(kn.ModelError, match="bodies with mass"):
        kn.mass_center([], O)
    with pytest.raises(kn.ModelError, match="unit vector"):
        kn.moment_of_inertia(rod, O, 2 * B.z)
    with pytest.raises(kn.ModelError, match=r"fixed in N, .* depend on q"):
        kn.composite("c", [rod, tip], N)
    system = kn.System(N, bodies=[rod, tip], speeds="rates")
    assert str(kn.mass_center(system, O)) == str(kn.mass_center([rod, tip], O))


@pytest.mark.parametrize("form", ["nonlinear", "linearized"])
def test_of_a_flexible_beam(form):
    """½ ω·I·ω of the deformed shape is the kinetic energy of a turn without deformation, also where points share momentum."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    B = N.rotate("B", kn.coordinate("q"), N.z)
    beam = kn.Beam("arm", O, frame=B, axis=B.x, length=2.0, mass_per_length=3.0, EI=5.0, modes=2, form=form)
    eom = kn.derive(kn.System(N, bodies=[beam], speeds="rates"))
    q = {x: 0.1 * (k + 1) for k, x in enumerate(eom.coordinates)}
    turning = {u: 1.5 if str(d) == "q'" else 0.0 for u, d in eom.system.speeds.items()}
    moment, energy = kn.moment_of_inertia(beam, O, N.z), eom.kinetic_energy
    found = [float(x) for x in eom.evaluate([moment, energy], q=q, u=turning)]
    assert found[0] * 1.5**2 / 2 == pytest.approx(found[1], rel=1e-6 if form == "linearized" else 1e-12)
    assert found[0] > 0
    center = kn.mass_center(beam, O) - eom.mass_center(O)
    np.testing.assert_allclose(
        [float(x) for x in eom.evaluate(list(center.components(N)), q=q, u=turning)], 0, atol=1e-14
    )
    with pytest.raises(kn.ModelError, match=r"deforms|depend on"):
        kn.composite("c", [beam], B)


def test_a_composite_of_nothing():
    with pytest.raises(kn.ModelError, match="Expected bodies with mass, got none"):
        kn.composite("c", [], kn.Frame("N"))
