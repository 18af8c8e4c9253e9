# SPDX-License-Identifier: BSD-3-Clause
"""Friction as it is declared: what it pulls, what it ends, and that what was not declared is not guessed."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
x, y = kn.coordinates("x y")
P = O.at("P", x * N.x)
G = 9.81


def block(load, normal=None, lift=0.0):
    """A block of 2 kg on the ground, lifted by a pull that grows with time."""
    reactions = [] if normal is None else [normal]
    loads = [kn.gravity(-G * N.y), kn.Force(P, lift * kn.time * N.y, name="lift"), load]
    return kn.derive(kn.System(N, bodies=[kn.Particle("p", P, 2)], speeds="rates", loads=loads, reactions=reactions))


def pressed():
    return kn.reaction("R", at=P, along=N.y)


class TestFriction:
    def test_it_is_the_force_that_one_writes(self):
        normal = pressed()
        declared = block(kn.friction(P, normal, 0.3), normal)
        written = block(kn.Force(P, -0.3 * normal * P.velocity(N).normalized()), normal)
        assert [str(e) for e in declared.accelerations] == [str(e) for e in written.accelerations]
        names = [e.name for e in declared.events]
        assert names == ["onset of sticking (friction on P)", "contact lost (R = 0)"]
        assert [e.name for e in written.events] == ["contact lost (R = 0)"]

    @pytest.mark.slow
    @pytest.mark.parametrize("threshold", [1e-4, 1e-2, 1e2])
    def test_the_threshold_is_its_own(self, threshold):
        normal = pressed()
        eom = block(kn.friction(P, normal, 0.3, threshold=threshold), normal)
        sol = kn.simulate(eom, (0, 1e4), q=[0], u=[3 * threshold], samples=3)
        assert sol.event is not None
        assert sol.t[-1] == pytest.approx(2 * threshold / (0.3 * G), rel=1e-6)

    @pytest.mark.slow
    def test_without_one_a_slide_ends_at_a_share_of_its_largest_slip_in_any_units(self):
        """A block and a pin, from 1e-6 to 1e6: t = u/(μ g) less what a ten-thousandth takes."""
        normal = pressed()
        eom = block(kn.friction(P, normal, 0.3), normal)
        pin = kn.pin("pin", O, N, axis=N.z)
        rod = kn.RigidBody(
            "rod", frame=pin.frame, mass_center=O.at("G", 0), mass=1.0, inertia=kn.inertia(pin.frame, 1, 1, 1)
        )
        turned = kn.derive(kn.System(N, bodies=[rod], joints=[pin], loads=[kn.dry_friction(pin, 0.3 * G)]))
        for speed in (1e-6, 1.0, 1e6):
            for system, name in (
                (eom, "onset of sticking (friction on P)"),
                (turned, "onset of sticking (dry friction in pin)"),
            ):
                sol = kn.simulate(system, (0, 1e7), q=[0], u=[speed], samples=3, atol=1e-9 * speed)
                assert sol.event is not None
                assert sol.event.name == name
                assert "fell below a ten-thousandth of its largest" in sol.message
                assert sol.t[-1] == pytest.approx((1 - 1e-4) * speed / (0.3 * G), rel=1e-6)
        with pytest.raises(kn.SimulationError, match="Expected a start before the event 'onset of sticking"):
            kn.simulate(eom, (0, 1), q=[0], u=[0])

    @pytest.mark.parametrize(
        "of_speed",
        [kn.sign, lambda v: kn.tanh(v / 1e-3), lambda v: v / kn.sqrt(v**2 + 1e-6)],
        ids=["sign", "tanh", "root"],
    )
    def test_a_ground_that_pulls_is_seen_however_it_is_written(self, of_speed):
        """R = 2 g − 5 t vanishes at t = 0.4 g: before, the block slides on with the ground pulling it down."""
        normal = pressed()
        load = kn.Force(P, -0.1 * normal * of_speed(x.dt) * N.x)
        sol = kn.simulate(block(load, normal, 5.0), (0, 10), q=[0], u=[20], samples=3)
        assert sol.event is not None
        assert sol.event.name == "contact lost (R = 0)"
        assert sol.t[-1] == pytest.approx(0.4 * G, abs=1e-6)

    def test_smooth_friction_starts_at_rest_and_creeps(self):
        """Pulled by less than μ N it creeps at a speed of the order of ε, pulled by more it slides."""
        normal = pressed()
        eps, mu, weight = 1e-3, 0.3, 2 * G
        for pull in (0.5, 2.0):
            load = kn.friction(P, normal, mu, smooth=eps)
            eom = kn.derive(
                block(load, normal).system.replace(
                    loads=[kn.gravity(-G * N.y), kn.Force(P, pull * mu * weight * N.x), load]
                )
            )
            sol = kn.simulate(eom, (0, 1), q=[0], u=[0], method="Radau", samples=3)
            assert sol.status == "finished"
            end = eps * pull / np.sqrt(1 - pull**2) if pull < 1 else (pull - 1) * mu * G
            assert sol["u_x"][-1] == pytest.approx(end, rel=0.01)

    def test_against_another_body(self):
        """A block slides on a free plank: both together keep their momentum, and end with one velocity."""
        plank = O.at("plank", y * N.x)
        top = plank.at("top", x * N.x)
        normal = kn.reaction("R", at=top, along=N.y)
        load = kn.friction(top, normal, 0.3, against=plank)
        bodies = [kn.Particle("block", top, 2), kn.Particle("plank", plank, 3)]
        eom = kn.derive(
            kn.System(N, bodies=bodies, speeds="rates", loads=[kn.gravity(-G * N.y), load], reactions=[normal])
        )
        sol = kn.simulate(eom, (0, 5), q={x: 0, y: 0}, rates={x: 2, y: 0}, samples=3)
        assert sol.status == "event"
        assert sol["u_y"][-1] == pytest.approx(2 * 2 / 5, abs=1e-4)

    @pytest.mark.parametrize(
        ("given", "message"),
        [
            ((O, 3, 0.3), "Expected the normal force as a reaction, got 3"),
            ((N, pressed(), 0.3), "Expected friction at a Point"),
            ((P, kn.reaction("bare"), 0.3), "Expected along=unit vector"),
            ((P, pressed(), -0.3), "a coefficient of friction at P at or above zero, got -0.3"),
        ],
    )
    def test_errors(self, given, message):
        with pytest.raises(kn.ModelError, match=message):
            kn.friction(*given)
        with pytest.raises(kn.ModelError, match="the particle that it slides on as a Point, got 5"):
            kn.friction(P, pressed(), 0.3, against=5)
        with pytest.raises(kn.ModelError, match="Expected threshold > 0"):
            kn.friction(P, pressed(), 0.3, threshold=0)


class TestWhatIsNoFriction:
    def test_drag_from_rest_is_not_told_of_rolling(self):
        """Drag c v² along v, from rest: it falls towards the speed at which the drag carries the weight."""
        v = P.velocity(N)
        written = -0.5 * v.magnitude() * v
        eom = block(kn.Force(P, written + 4 * N.x))
        assert eom.events == ()
        sol = kn.simulate(eom, (0, 3), q=[0], u=[0], samples=3)
        assert sol["u_x"][-1] == pytest.approx(np.sqrt(8) * np.tanh(3 / np.sqrt(2)), abs=1e-6)

    @pytest.mark.slow
    def test_a_direction_that_rest_has_not_is_said_to_be_none(self):
        eom = block(kn.Force(P, -0.5 * P.velocity(N).normalized()))
        assert eom.events == ()
        with pytest.raises(kn.SimulationError, match=r"Expected finite rates at the start, got none for u_x'"):
            kn.simulate(eom, (0, 1), q=[0], u=[0])
        for method in ("auto", "gauss16", "dop853", "tsitpap8", "vern9", "tsit5", "radau9"):
            sol = kn.simulate(eom, (0, 20), q=[0], u=[0.5], samples=3, method=method)
            assert sol.status == "stopped"
            assert "switches back and forth" in sol.message


@pytest.mark.parametrize("kind", ["block", "tip", "wheel", "wheel on wheel"])
def test_the_end_of_a_slip_at_a_point_is_named_for_what_sets_in(kind):
    """Rolling where another particle of a body is in contact at every instant, else sticking."""
    B = N.rotate("B", y, N.z)
    at = {
        "block": P,
        "tip": P.fixed_in(B, "tip", 0.2 * B.y - 0.3 * B.x),
        "wheel": P.fixed_in(B, "rim", -0.3 * N.y),
        "wheel on wheel": P,
    }[kind]
    against = P.fixed_in(B, "roll", 0.1 * N.y) if kind == "wheel on wheel" else None
    normal = pressed()
    load = kn.friction(at, normal, 0.3, against=against, name="rub")
    body = kn.RigidBody("b", frame=B, mass_center=P, mass=2, inertia=kn.inertia(B, 1, 1, 1))
    loads = [kn.gravity(-G * N.y), load]
    eom = kn.derive(kn.System(N, bodies=[body], speeds="rates", loads=loads, reactions=[normal]))
    onset = "rolling" if "wheel" in kind else "sticking"
    (event,) = (e for e in eom.events if "onset" in e.name)
    assert event.name == f"onset of {onset} (rub)"
    assert f"fell below a ten-thousandth of its largest: {onset} sets in" in event.message


def test_a_clutch_sticks():
    """Two disks of 1 and 2 kg m² pressed together: at rest relative to each other after (Ω₁ − Ω₂)/(M (1/J₁ + 1/J₂))."""
    first = kn.pin("shaft", O, N, axis=N.z)
    clutch = kn.pin("clutch", O, first.frame, axis=N.z)
    disks = [
        kn.RigidBody(j.name, frame=j.frame, mass_center=O, mass=1, inertia=kn.inertia(j.frame, 1, 1, k))
        for k, j in enumerate((first, clutch), 1)
    ]
    load = kn.dry_friction(clutch, 0.6, threshold=1e-6)
    eom = kn.derive(kn.System(N, bodies=disks, joints=[first, clutch], loads=[load]))
    sol = kn.simulate(eom, (0, 20), q=[0, 0], u=[3, 4.5], samples=3)
    assert sol.event is not None
    assert sol.event.name == "onset of sticking (dry friction in clutch)"
    assert sol.t[-1] == pytest.approx(4.5 / 0.9, rel=1e-6)
    assert "sticking sets in" in sol.message


class TestDryFriction:
    @pytest.mark.parametrize("kind", ["pin", "slider"])
    def test_a_joint_that_comes_to_rest(self, kind):
        """Against a constant torque or force of 0.6 the rate falls steadily."""
        make = {"pin": kn.pin, "slider": kn.slider}[kind]
        joint = make("J", O, N, axis=N.z)
        body = kn.RigidBody(
            "b", frame=joint.frame, mass_center=joint.point, mass=2, inertia=kn.inertia(joint.frame, 1, 1, 2)
        )
        load = kn.dry_friction(joint, 0.6)
        eom = kn.derive(kn.System(N, bodies=[body], joints=[joint], loads=[load]))
        sol = kn.simulate(eom, (0, 10), q=[0], u=[1.5], samples=3)
        assert sol.event is not None
        assert sol.event.name == "onset of sticking (dry friction in J)"
        assert sol.t[-1] == pytest.approx(1.5 * (1 - 1e-4) / 0.3, rel=1e-6)
        smooth = kn.derive(
            kn.System(N, bodies=[body], joints=[joint], loads=[kn.dry_friction(joint, 0.6, smooth=1e-3)])
        )
        assert smooth.events == ()
        rest = kn.simulate(smooth, (0, 10), q=[0], u=[1.5], method="Radau", samples=3)
        assert rest.status == "finished"
        assert abs(rest.u[-1, 0]) < 1e-3

    def test_errors(self):
        ball = kn.ball("B", O, N)
        with pytest.raises(kn.ModelError, match="Expected dry friction in a pin or slider joint, got a ball joint"):
            kn.dry_friction(ball, 1)
        with pytest.raises(kn.ModelError, match="Expected dry friction in a pin or slider joint, got 3"):
            kn.dry_friction(3, 1)
        with pytest.raises(kn.ModelError, match="a size of dry friction in 'slide' at or above zero, got size = -2"):
            kn.dry_friction(kn.slider("slide", O, N, axis=N.x), kn.parameter("size", -2.0))
