# SPDX-License-Identifier: BSD-3-Clause
"""What only the derivation can see: motions that move no mass, inertias that are not constant in their bodies."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
a, b, c = kn.coordinates("a b c")
L = kn.parameter("L", 1.5)


def derive(*bodies, speeds="rates", **more):
    return kn.derive(kn.System(N, bodies=bodies, speeds=speeds, **more))


class TestMass:
    def test_a_speed_that_moves_nothing(self):
        empty = O.at("P", a * N.x).at("G", 0)
        body = kn.Particle("p", empty, 0)
        with pytest.raises(kn.ModelError, match="zero row of the mass matrix for u_a"):
            derive(body)

    def test_two_coordinates_that_do_the_same(self):
        with pytest.raises(kn.ModelError, match="combination of u_a, u_b that moves none"):
            derive(kn.Particle("p", O.at("P", a * N.x).at("Q", b * N.x), 2))

    @pytest.mark.parametrize("size", [1e-12, 1e-9, 1e-6, 1e6, 1e12])
    def test_models_of_any_size_move_mass(self, size):
        """A block on a rod that turns in space: 1 m from its pivot one of 1 nm has next to no inertia about the rod."""
        turns = [kn.coordinate(name, "rad") for name in "abc"]
        d = kn.coordinate("d", "m")
        B = N.rotate_body("B", turns, "zxz")

        def motion(size):
            edges, place = (3 * size, 2 * size, size), O.at("G", d * (0.6 * B.x + 0.8 * B.z))
            block = kn.RigidBody("block", frame=B, mass_center=place, mass=2, inertia=kn.solids.box(B, 2, *edges))
            q, u = {"a": 0.3, "b": 0.4, "c": 0.5, "d": 0.7 * size}, {"u_a": 1.0, "u_b": 2.0, "u_c": 3.0, "u_d": size}
            return derive(block).evaluate([x.dt for x in (*(q.dt for q in turns), d.dt / size)], q=q, u=u)

        np.testing.assert_allclose(motion(size), motion(1.0), rtol=1e-9)

    def test_a_rod_has_no_inertia_about_its_axis(self):
        B = N.rotate_body("B", (a, b, c), "zxy")
        rod = kn.RigidBody("rod", frame=B, mass_center=O.at("G", 0), mass=2, inertia=kn.rod(B, 2, L, B.x))
        with pytest.raises(kn.ModelError, match="combination of u_a, u_b, u_c that moves none"):
            derive(rod)

    def test_three_angles_in_a_plane(self):
        A = N.rotate("A", a, N.z)
        B = A.rotate("B", b, A.x)
        bob = kn.Particle("bob", O.at("P", L * B.x), 1)  # turning about B.x does not move it
        with pytest.raises(kn.ModelError, match=r"moves? .*mass"):
            derive(bob)

    def test_a_massless_link_in_between_is_fine(self):
        A = N.rotate("A", a, N.z)
        B = A.rotate("B", b, A.z)
        bob = kn.Particle("bob", O.at("E", L * A.x).at("P", L * B.x), 1)
        eom = derive(bob)
        assert np.isfinite(eom.evaluate(list(eom.accelerations), q=[0.3, 0.7], u=[1, 2])).all()

    def test_masses_of_very_different_size_are_fine(self):
        light = kn.Particle("light", O.at("P", a * N.x), 1e-9)
        heavy = kn.Particle("heavy", O.at("Q", b * N.x), 1e9)
        eom = derive(light, heavy, loads=[kn.gravity(N.x)])
        assert np.array(eom.evaluate(list(eom.accelerations), q=[0, 0], u=[0, 0])) == pytest.approx([1, 1])

    @pytest.mark.parametrize("length", [1e-6, 1e-4, 1.0, 1e6])
    def test_a_beam_of_any_length_with_a_body_at_its_tip(self, length):
        beam = kn.Beam("beam", O, frame=N, axis=N.x, length=length, mass_per_length=1, EI=1, modes=3)
        eom = derive(beam, kn.Particle("body", beam.point_at(1), 3 * length), speeds=None)
        assert np.array(eom.evaluate(list(eom.accelerations), q=[0] * 3, u=[0] * 3)) == pytest.approx([0] * 3)


class TestInertia:
    def body(self, frame, dyadic):
        return kn.RigidBody("b", frame=frame, mass_center=O.at("G", 0), mass=1, inertia=dyadic)

    B = N.rotate_body("B", (a, b, c), "zxz")

    def test_along_a_frame_in_which_the_body_turns(self):
        with pytest.raises(kn.ModelError, match="constant in N, in which B turns"):
            derive(self.body(self.B, kn.inertia(N, 1, 2, 3)))

    def test_measure_numbers_that_change(self):
        with pytest.raises(kn.ModelError, match="measure numbers that depend on a"):
            derive(self.body(self.B, kn.inertia(self.B, 1, 2, 3 + a)))

    @pytest.mark.parametrize("large", [1.0, 1e10])
    @pytest.mark.parametrize(
        "more",
        [
            a,
            kn.time,
            kn.input("r"),
            a.dt,
            kn.sin(kn.time) / 2,
            kn.where(kn.less(kn.time, 1000), 0, 1),
            kn.where(kn.less(a, 10), 0, a - 10),
        ],
        ids=str,
    )
    def test_measure_numbers_that_change_are_refused_however_little_and_late(self, more, large):
        """None of them is decided by what it is at a few places."""
        with pytest.raises(
            kn.ModelError, match=r"constant inertia of b, got measure numbers .*rates would be missing in dH/dt"
        ):
            derive(self.body(self.B, kn.inertia(self.B, large, large, 1 + more)))

    def test_along_a_frame_that_is_fixed_in_the_body(self):
        F = self.B.rotate("F", 0.4, self.B.y)
        turn = kn.evaluate(self.B.dcm(F), {})
        rows = turn @ np.diag([1.0, 2.0, 3.0]) @ turn.T
        one, two = (
            derive(self.body(self.B, kn.inertia(F, 1, 2, 3))),
            derive(self.body(self.B, kn.Dyadic.of(self.B, rows))),
        )
        state = {"q": [0.3, 0.9, 0.5], "u": [1, -2, 0.5]}
        assert np.array(one.evaluate(list(one.accelerations), **state)) == pytest.approx(
            np.array(two.evaluate(list(two.accelerations), **state))
        )

    def test_a_body_of_revolution_may_be_written_where_it_spins(self):
        """In the frame that does not spin, in the body's, and as a sum over two frames: one motion."""
        inner = self.B.orientation.base
        assert inner is not self.B
        made = [
            kn.inertia(inner, 1, 1, 2),
            kn.inertia(self.B, 1, 1, 2),
            kn.inertia(self.B, 0.5, 0.5, 1) + kn.inertia(inner, 0.5, 0.5, 1),
        ]
        state = {"q": [0.3, 0.9, 0.5], "u": [1, -2, 0.5]}
        found = [
            np.array(e.evaluate(list(e.accelerations), **state)) for e in (derive(self.body(self.B, d)) for d in made)
        ]
        assert found[1] == pytest.approx(found[0])
        assert found[2] == pytest.approx(found[0])

    def test_a_sphere_may_be_written_anywhere(self):
        eom = derive(self.body(self.B, kn.solid_sphere(N, 1, L)))
        other = derive(self.body(self.B, kn.solid_sphere(self.B, 1, L)))
        state = {"q": [0.3, 0.9, 0.5], "u": [1, -2, 0.5]}
        assert np.array(eom.evaluate(list(eom.accelerations), **state)) == pytest.approx(
            np.array(other.evaluate(list(other.accelerations), **state))
        )

    def test_along_no_single_frame(self):
        with pytest.raises(kn.ModelError, match="measure numbers that depend on"):
            derive(self.body(self.B, kn.inertia(self.B, 1, 2, 3) + kn.inertia(N, 1, 2, 3)))


class TestReactionPlaces:
    def test_prescribed_motion_is_not_freedom(self):
        table = O.at("table", kn.sin(kn.time) * N.y + a * N.x)
        force = kn.reaction("F", at=table, along=N.y)
        assert derive(kn.Particle("p", table, 1), reactions=[force]).reactions == (force,)

    def test_free_only_in_part(self):
        slider = O.at("s", a * (N.x + N.y).normalized())
        across = kn.reaction("F", at=slider, along=(N.x - N.y).normalized())
        assert derive(kn.Particle("p", slider, 1), reactions=[across]).reactions == (across,)
        with pytest.raises(kn.ReactionError, match="moves freely"):
            derive(kn.Particle("p", slider, 1), reactions=[kn.reaction("F", at=slider, along=N.y)])

    def test_a_direction_across_the_motion_only_by_trigonometry(self):
        """s ẋ − c ẏ along a curve whose slope is tan x: zero, but not to the eye of a simplifier."""
        curve = O.at("c", a * N.x - kn.log(kn.cos(a)) * N.y)
        normal = kn.cos(a) * N.y - kn.sin(a) * N.x
        force = kn.reaction("F", at=curve, along=normal)
        eom = derive(kn.Particle("p", curve, 2), reactions=[force], loads=[kn.gravity(-9.81 * N.y)])
        state = {"q": [0.5], "u": [1.2]}
        # curvature: d(tan x)/ds = cos x, speed ẋ/cos x
        expected = 2 * (9.81 * np.cos(0.5) + (1.2 / np.cos(0.5)) ** 2 * np.cos(0.5))
        assert float(eom.evaluate(force, **state)) == pytest.approx(expected)

    def test_torque_reaction_of_a_frame_that_only_tilts(self):
        F = N.rotate("F", 0.3, N.x)
        B = F.rotate("B", a, F.z)
        body = kn.RigidBody("b", frame=B, mass_center=O.at("G", L * B.x), mass=1, inertia=kn.inertia(B, 1, 2, 3))
        torques = [kn.reaction(f"T{k}", frame=F, along=n) for k, n in enumerate((F.x, F.y, F.z))]
        eom = derive(body, reactions=torques)
        assert float(eom.evaluate(torques[2], q=[0.1], u=[2.0])) == pytest.approx(0, abs=1e-12)
