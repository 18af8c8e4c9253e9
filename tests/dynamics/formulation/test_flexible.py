# SPDX-License-Identifier: BSD-3-Clause
"""Flexible beams by recursion: u̇ and reactions of the classical route, in a number of operations that grows as the tree."""

from collections.abc import Callable

import numpy as np
import pytest

import kane as kn
from kane import evaluate, free_symbols
from kane.dynamics import WAYS
from kane.gallery import (
    flap_lag_blade,
    flexible_arm,
    flexible_four_bar,
    flexible_pendulum,
    flexible_slider_crank,
    flexible_spacecraft,
    rotating_beam,
)
from tests.systems import flexible
from tests.systems.closed_states import states


def pinned_rod(form: str) -> kn.System:
    """What is fixed in the section at the root of a rod turns by its slope there, about the place where the rod's frame does."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    hinge = kn.pin("hinge", O, N, axis=N.z)
    A = hinge.frame
    rod = kn.Beam(
        "rod",
        hinge.point,
        frame=A,
        axis=A.x,
        length=1.0,
        mass_per_length=0.5,
        EI=2.0,
        modes=2,
        support="pinned",
        form=form,
    )
    E = rod.frame_at(0)
    bob = kn.RigidBody(
        "bob", frame=E, mass_center=rod.point_at(0).at("C", -0.2 * E.x), mass=0.3, inertia=kn.inertia(E, 0.1, 0.1, 0.1)
    )
    return kn.System(N, bodies=[rod, bob], joints=[hinge], loads=[kn.gravity(-9.81 * N.y)])


SYSTEMS: dict[str, Callable[[], kn.System]] = {
    "two-link arm": flexible_arm.system,
    "two-link arm, nonlinear": lambda: flexible_arm.system(form="nonlinear", modes=1),
    "pendulum": flexible_pendulum.system,
    "spacecraft": flexible_spacecraft.system,
    "blade on hinges": flap_lag_blade.system,
    "spin-up": lambda: rotating_beam.system(spin_up=True, stretch=1),
    "spin-up, nonlinear": lambda: rotating_beam.system(spin_up=True, modes=2, form="nonlinear"),
    "reactions in an arm": lambda: flexible.flexible_arm(2, modes=1, reactions=True),
    "reactions in an arm, nonlinear": lambda: flexible.flexible_arm(2, modes=1, reactions=True, form="nonlinear"),
    "three booms": lambda: flexible.booms(3),
    "two booms, nonlinear": lambda: flexible.booms(2, form="nonlinear"),
    "booms on the ground": lambda: flexible.booms(2, fixed=True),
    "in space": flexible.spatial,
}


def accelerations(eom: kn.Equations) -> np.ndarray:
    """u̇ and the reactions at a state near the straight one."""
    rng = np.random.default_rng(1)
    wanted = [*eom.solved.accelerations, *eom.solved.reactions]
    symbols = sorted(free_symbols(wanted), key=lambda s: s.name)
    values = {s: s.default if getattr(s, "default", None) is not None else 0.2 * rng.uniform(-1, 1) for s in symbols}
    return np.array(evaluate(wanted, values), dtype=float)


def apart(first: kn.Equations, *others: kn.Equations) -> float:
    """The largest difference of others from the first one, over the largest value."""
    values = accelerations(first)
    return max(float(np.abs(accelerations(x) - values).max()) for x in others) / float(np.abs(values).max())


def routes_apart(system: kn.System) -> float:
    """The same of the classical route and the recursions."""
    return apart(*(kn.derive(system, route=route) for route in ("classical", *WAYS)))


@pytest.mark.slow
@pytest.mark.parametrize("name", SYSTEMS)
def test_both_recursions_agree_with_the_classical_route(name: str) -> None:
    assert routes_apart(SYSTEMS[name]()) < 1e-10


@pytest.mark.parametrize("form", ["linearized", "nonlinear"])
def test_angles_that_a_joint_and_a_section_share(form: str) -> None:
    system = pinned_rod(form)
    assert routes_apart(system) < 1e-10
    assert set(kn.derive(system).routes) == {"classical", *WAYS}


@pytest.mark.slow
def test_beams_on_beams_in_space() -> None:
    assert routes_apart(flexible.spatial(2)) < 1e-10
    assert routes_apart(flexible.spatial(1, form="nonlinear")) < 1e-10


@pytest.mark.slow
def test_ten_flexible_links() -> None:
    """Each more takes as many operations as the one before, a twentieth of the classical route's in all."""
    system = flexible.flexible_arm(10)
    eom, classical = kn.derive(system), kn.derive(system, route="classical")
    assert eom.route == "recursive"
    assert apart(classical, eom) < 1e-10
    few, more, most = (kn.derive(flexible.flexible_arm(n), route="recursive").operations.total for n in (4, 5, 6))
    assert most - more == more - few
    assert 20 * eom.operations.total < classical.operations.total


def test_the_shortest_is_taken() -> None:
    eom = kn.derive(flexible_arm.system())
    assert set(eom.solved.routes) == {"classical", *WAYS}
    assert eom.route == "recursive"
    assert 2 * eom.operations.total < kn.derive(flexible_arm.system(), route="classical").operations.total


def test_speeds_that_are_no_rates_of_single_coordinates() -> None:
    """The angular velocity of the second link as a speed: the rates of the first one's deformation are in it."""
    system = flexible.flexible_arm(2, modes=1)
    first, beam = system.joints[0].coordinates[0], system.bodies[0]
    assert isinstance(beam, kn.Beam)
    frame = system.joints[1].frame
    u1, u2 = kn.speed("w_1", "rad/s"), kn.speed("w_2", "rad/s")
    turning = frame.angular_velocity(system.inertial).dot(system.inertial.z)
    other = system.replace(speeds={u1: first.dt, u2: turning, **beam.speeds})
    assert routes_apart(other) < 1e-10


LOOPS: dict[str, Callable[[], kn.System]] = {
    "four-bar": flexible_four_bar.system,
    "four-bar, nonlinear": lambda: flexible_four_bar.system(form="nonlinear"),
    "slider-crank": flexible_slider_crank.system,
    "slider-crank, nonlinear": lambda: flexible_slider_crank.system(form="nonlinear"),
    "slider-crank, one mode": lambda: flexible_slider_crank.system(modes=1),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", LOOPS)
def test_loops_with_beams(name: str) -> None:
    """Their accelerations and multipliers on the constraints, by both recursions."""
    system = LOOPS[name]()
    usual, *others = (kn.derive(system, route=route) for route in ("classical", *WAYS))
    for q, u in states(usual, np.random.default_rng(2), 2, reach=0.2):
        wanted, *found = (
            np.array(e.evaluate([*e.accelerations, *e.multipliers.values()], q=q, u=u)) for e in (usual, *others)
        )
        assert max(np.abs(x - wanted).max() for x in found) < 1e-10 * np.abs(wanted).max()
    assert kn.derive(system).operations.total <= min(e.operations.total for e in (usual, *others))
