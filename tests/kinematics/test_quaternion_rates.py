# SPDX-License-Identifier: BSD-3-Clause
"""Speeds along perpendicular axes: the rates of Euler parameters without a divisor, by either frame's components."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.gallery import sphere_on_turntable
from kane.kinematics import generalized_speeds, turned


def top(axes, order=(0, 1, 2), extra=0):
    """A body about a fixed point; the speeds are components of ω, along N, B, or A that is turned from N by a fixed angle."""
    N = kn.Frame("N")
    B = N.rotate_euler_parameters("B", kn.coordinates("e0:4"))
    frames = {"N": N, "B": B, "A": N.rotate("A", 0.4, N.y), "C": B.rotate("C", 0.7, B.x)}
    O = kn.Point("O", fixed_in=N)
    body = kn.RigidBody("top", frame=B, mass_center=O, mass=1.0, inertia=kn.inertia(B, 1.0, 2.0, 2.5))
    w, f = B.angular_velocity(N), frames[axes]
    measures = [w.dot(x) for x in (f.x, f.y, f.z)]
    speeds = dict(zip(kn.speeds("u1:4"), (measures[k] + extra for k in order), strict=True))
    return kn.System(N, bodies=[body], speeds=speeds)


@pytest.mark.parametrize("axes", ["N", "A", "B", "C"])
@pytest.mark.parametrize("order", [(0, 1, 2), (2, 0, 1)])
@pytest.mark.parametrize("extra", [0, 0.3])
def test_rates_give_back_the_speeds(axes, order, extra, rng):
    """Y q̇ + z = u at random unit Euler parameters, and e·ė = 0."""
    eom = kn.derive(top(axes, order, extra))
    e = rng.normal(size=4)
    e, u = e / np.linalg.norm(e), rng.normal(size=3)
    rates = np.array(eom.evaluate(list(eom.rates), q=e, u=u), dtype=float)
    y = np.array(eom.evaluate(eom.Y, q=e, u=u), dtype=float)
    z = np.array(eom.evaluate(list(eom.z), q=e, u=u), dtype=float)
    assert y @ rates + z == pytest.approx([*u, 0.0], abs=1e-12)
    assert e @ rates == pytest.approx(0, abs=1e-13)


@pytest.mark.parametrize("axes", ["N", "A", "C"])
def test_nothing_is_divided_by(axes):
    assert generalized_speeds(top(axes)).pivots == ()


def test_along_the_base_they_are_as_short_as_along_the_frame():
    here, there = (kn.derive(top(axes)).solved for axes in ("N", "B"))
    assert kn.count_operations(here.rates).total <= kn.count_operations(there.rates).total + 1
    assert str(here.rates[0]) == "-(e1*u1 + e2*u2 + e3*u3)/2"


def test_other_speeds_are_left_alone():
    """A stretched measure, and one that another row holds too."""
    N = kn.Frame("N")
    B = N.rotate_euler_parameters("B", kn.coordinates("e0:4"))
    O = kn.Point("O", fixed_in=N)
    body = kn.RigidBody("top", frame=B, mass_center=O, mass=1.0, inertia=kn.inertia(B, 1.0, 2.0, 2.5))
    w = B.angular_velocity(N)
    u = kn.speeds("u1:4")
    system = kn.System(N, bodies=[body], speeds=dict(zip(u, (2 * w.dot(N.x), w.dot(N.y), w.dot(N.z)), strict=True)))
    speeds = generalized_speeds(system)
    assert turned(system.euler_parameters[0], speeds.rows) is None
    assert speeds.along == {}
    assert turned(system.euler_parameters[0], speeds.rows[:2]) is None


def test_a_sphere_on_a_turntable_reads_as_in_books():
    """Its centre runs in circles at 2/7 of the table's rate (Weltner 1979, Am. J. Phys. 47, 984-986)."""
    eom = kn.derive(sphere_on_turntable.system())
    told = {u.name: str(x) for u, x in zip(eom.speeds, eom.accelerations, strict=True)}
    assert told == {
        "u_x": "-2*Omega*u_y/7",
        "u_y": "2*Omega*u_x/7",
        "w_x": "5*Omega*u_x/(7*R)",
        "w_y": "5*Omega*u_y/(7*R)",
        "w_z": "0",
    }
    assert eom.operations.total <= 50


@pytest.mark.parametrize("orientation", ["euler parameters", "angles"])
def test_velocities_along_a_body_give_the_rates_without_a_divisor(orientation):
    N = kn.Frame("N")
    joint = kn.free("base", kn.Point("O", fixed_in=N), N, orientation=orientation)
    body = kn.RigidBody(
        "b", frame=joint.frame, mass_center=joint.point, mass=1.0, inertia=kn.inertia(joint.frame, 1, 2, 3)
    )
    eom = kn.derive(kn.System(N, bodies=[body], joints=[joint]))
    lengths = eom.rates[-3:]
    names = {s.name for s in kn.free_symbols(eom.kinematical.pivots)}
    assert not names & {"x_base", "y_base", "z_base"}
    assert all(node.op.name != "div" for node in kn.expr.postorder(lengths))
    rng = np.random.default_rng(3)
    values = {s: rng.uniform(-1, 1) for s in (*eom.coordinates, *eom.speeds)}
    turning = [q for q in eom.coordinates if q.name.startswith("e")]
    size = np.sqrt(sum(values[e] ** 2 for e in turning)) if turning else 1.0
    values |= {e: values[e] / size for e in turning}
    v = sum(
        (u * e for u, e in zip(eom.speeds[3:], (joint.frame.x, joint.frame.y, joint.frame.z), strict=True)),
        start=kn.Vector(),
    )
    wanted = np.array(kn.evaluate(list(v.components(N)), values), dtype=float)
    assert np.array(kn.evaluate(list(lengths), values), dtype=float) == pytest.approx(wanted, rel=1e-12)
