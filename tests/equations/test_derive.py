# SPDX-License-Identifier: BSD-3-Clause
"""F_r + F*_r = 0 and M u̇ = f are one; derivation is pure, repeatable, thread safe and leaves nothing behind."""

from __future__ import annotations

import gc
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from threading import Barrier

import numpy as np
import pytest

import kane as kn
from kane.expr import node
from kane.gallery import rolling_disk
from kane.gallery.pendulums import system as chain

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
q = kn.coordinates("q1:5")
u = kn.speeds("u1:5")
STATE = {"q": [0.3, -0.6, 0.9, 1.4], "u": [0.7, -0.2, 1.1, 0.4], "t": 0.3}


def array(values):
    return np.array([np.asarray(v, dtype=float) for v in values])


def mechanism(choice="rates"):
    """A cart, a driven turntable on it, and a rod with a spring, a damper, an input torque and a reaction with friction."""
    cart = O.at("cart", q[0] * N.x)
    A = N.rotate("A", q[1] + kn.sin(kn.time), N.z)
    B = A.rotate("B", q[2], A.x)
    arm = cart.at("arm", 0.8 * A.x)
    rod = arm.at("rod", (0.5 + q[3]) * B.y)
    bodies = [
        kn.Particle("cart", cart, kn.parameter("m0", 2.0)),
        kn.RigidBody("table", frame=A, mass_center=arm, mass=1.1, inertia=kn.inertia(A, 0.3, 0.3, 0.5)),
        kn.RigidBody("rod", frame=B, mass_center=rod, mass=0.7, inertia=kn.inertia(B, 0.2, 0.15, 0.3, 0.05, 0, 0.02)),
    ]
    normal = kn.reaction("N_z", at=cart, along=N.z)
    loads = [
        kn.gravity(-9.81 * N.z),
        kn.linear_spring(rod, O, 4.0, 0.3),
        kn.linear_damper(rod, arm, 0.4),
        kn.torque_pair(B, A, kn.input("T") * A.x),
        kn.friction(cart, normal, 0.1, name="friction"),
    ]
    w = B.angular_velocity(N)
    definitions = {
        "rates": [x.dt for x in q],
        "mixed": [q[0].dt + q[1].dt, w.dot(B.y), q[2].dt, rod.velocity(N).dot(B.y)],
    }[choice]
    return kn.System(
        N, bodies=bodies, speeds=dict(zip(u, definitions, strict=True)), loads=loads, reactions=[normal], coordinates=q
    )


@pytest.fixture(scope="module", params=["rates", "mixed", "disk"])
def case(request):
    if request.param == "disk":
        model = rolling_disk.model()
        return kn.derive(model.system), {"q": [0.4, 0.5, 0.1, 1.0, 2.0], "u": [0.3, 0.7, 1.0, 0.2, 0.1]}
    return kn.derive(mechanism(request.param)), STATE | {"inputs": {"T": 0.6}}


def test_equations_hold_at_the_solved_accelerations(case):
    eom, state = case
    residual = [f + g for f, g in zip(eom.Fr, eom.Fr_star, strict=True)]
    assert len(residual) == len(eom.speeds) + len(eom.auxiliary_speeds)
    assert array(eom.evaluate(residual, **state)) == pytest.approx(np.zeros(len(residual)), abs=1e-11)


def test_both_forms_agree_at_any_acceleration_and_any_reaction(case):
    """F_r + F*_r = f − M u̇, auxiliary rows too, as functions of u̇ and R, which are not solved for here."""
    eom, state = case
    rng = np.random.default_rng(4)
    values = {kn.time: state.get("t", 0.0)}
    values |= dict(zip(eom.coordinates, state["q"], strict=True)) | dict(zip(eom.speeds, state["u"], strict=True))
    values |= {kn.input("T"): 0.6} | {r: rng.normal() for r in eom.reactions}
    u_dot = rng.normal(size=len(eom.speeds))
    values |= {s.dt: a for s, a in zip(eom.speeds, u_dot, strict=True)}
    left = array(kn.evaluate([f + g for f, g in zip(eom.Fr, eom.Fr_star, strict=True)], values))
    M = np.vstack([kn.evaluate(eom.mass_matrix, values), kn.evaluate(eom.auxiliary_mass_matrix, values)])
    f = array(kn.evaluate([*eom.forcing, *eom.auxiliary_forcing], values))
    assert left == pytest.approx(f - M @ u_dot, abs=1e-11)


def test_accelerations_solve_the_system(case):
    eom, state = case
    M, f = eom.evaluate(eom.mass_matrix, **state), array(eom.evaluate(list(eom.forcing), **state))
    assert array(eom.evaluate(list(eom.accelerations), **state)) == pytest.approx(np.linalg.solve(M, f), abs=1e-10)
    assert pytest.approx(M.T, abs=0) == M
    assert np.linalg.eigvalsh(M)[0] > 0


def test_contributions_sum_up(case):
    eom, state = case
    for i, s in enumerate(eom.all_speeds):
        from_loads = [eom.Fr_contributions[s, load] for load in eom.loads]
        from_bodies = [eom.Fr_star_contributions[s, b.body] for b in eom.bodies]
        pairs = [eom.pairs[s, r] * r for r in eom.reactions if (s, r) in eom.pairs]
        total, inertia = (
            sum(array(eom.evaluate(from_loads + pairs, **state))),
            sum(array(eom.evaluate(from_bodies, **state))),
        )
        assert float(eom.evaluate(eom.Fr[i], **state)) == pytest.approx(total, abs=1e-12)
        assert float(eom.evaluate(eom.Fr_star[i], **state)) == pytest.approx(inertia, abs=1e-12)


def test_contributions_are_partial_velocities_times_forces():
    eom = kn.derive(mechanism())
    state = STATE | {"inputs": {"T": 0.6}}
    for load in eom.loads:
        for s in eom.all_speeds:
            expected = 0.0
            for point, f in load.forces:
                v = array(eom.evaluate(eom.partial_velocities[point][s].components(N), **state))
                expected += v @ array(eom.evaluate(f.components(N), **state))
            for frame, t in load.torques:
                w = array(eom.evaluate(eom.partial_angular_velocities[frame][s].components(N), **state))
                expected += w @ array(eom.evaluate(t.components(N), **state))
            assert float(eom.evaluate(eom.Fr_contributions[s, load], **state)) == pytest.approx(expected, abs=1e-12)


def test_an_input_as_a_load():
    """T acts between table and rod: it works on the relative turn alone."""
    eom = kn.derive(mechanism())
    (motor,) = [load for load in eom.loads if load.name.startswith("torque between")]
    assert [str(eom.Fr_contributions[s, motor]) for s in u] == ["0", "0", "T", "0"]
    assert eom.inputs == (kn.input("T"),)


def test_equations_do_not_depend_on_the_speeds():
    """q̈ of both choices of speeds, at the same q and q̇."""
    first, second = kn.derive(mechanism("rates")), kn.derive(mechanism("mixed"))
    state = STATE | {"inputs": {"T": 0.6}}
    values = (
        dict(zip(q, state["q"], strict=True)) | {x.dt: v for x, v in zip(q, state["u"], strict=True)} | {kn.time: 0.3}
    )
    other = state | {"u": array(kn.evaluate(list(second.system.speeds.values()), values))}
    wanted = [*(x.dt.dt for x in q), kn.reaction("N_z", at=first.system.bodies[0].point, along=N.z)]
    one = array(first.evaluate([*wanted[:4], first.reactions[0]], **state))
    two = array(second.evaluate([*wanted[:4], second.reactions[0]], **other))
    assert two == pytest.approx(one, rel=1e-10)


def test_loads_in_rates_are_written_in_speeds():
    x = kn.coordinate("x")
    P = O.at("P", x * N.x)
    speed = kn.speed("v")
    eom = kn.derive(
        kn.System(N, bodies=[kn.Particle("p", P, 2)], speeds={speed: 3 * x.dt}, loads=[kn.Force(P, -5 * x.dt * N.x)])
    )
    assert float(eom.evaluate(x.dt.dt, q=[0], u=[3.0])) == pytest.approx(-2.5)
    assert {s.name for s in kn.free_symbols(eom.accelerations)} == {"v"}


def test_a_slip_direction_is_watched():
    eom = kn.derive(mechanism())
    slips = [e for e in eom.events if "onset of sticking" in e.name]
    # a share of the largest slip ends it
    assert [(e.name, e.direction, e.threshold) for e in slips] == [("onset of sticking (friction)", -1, 0.0)]
    assert str(slips[0].quantity) == "sqrt(u1^2)"


# Pure, repeatable, thread safe ----------------------------------------------------------------------------------------


def test_derived_twice_it_is_the_same():
    first, second = kn.derive(rolling_disk.system()), kn.derive(rolling_disk.system())
    assert all(a is b for a, b in zip(first.right_hand_side[:5], second.right_hand_side[:5], strict=True))


@pytest.mark.slow
def test_four_threads_get_identical_objects():
    """One table for all threads: the entries of M, u̇ and M's factors are the same objects."""
    gc.collect()
    node.sweep()
    barrier = Barrier(4)

    def work(_):
        barrier.wait(30)
        eom = kn.derive(chain(8, relative=True))
        return [*(x for row in eom.mass_matrix.rows for x in row), *eom.forcing, *eom.accelerations, *eom.rates]

    switch = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        with ThreadPoolExecutor(4) as pool:
            found = list(pool.map(work, range(4)))
    finally:
        sys.setswitchinterval(switch)
    for other in found[1:]:
        assert all(a is b for a, b in zip(found[0], other, strict=True))


TEXT = """
import kane as kn
from kane.gallery import rolling_disk
eom = kn.derive(rolling_disk.system())
for step in eom.steps:
    print(step)
for e in (*eom.accelerations, *eom.reaction_values):
    print(kn.to_text(e))
    print(kn.to_latex(e))
"""


def text_under(seed):
    environment = {**os.environ, "PYTHONHASHSEED": str(seed)}
    run = subprocess.run([sys.executable, "-c", TEXT], capture_output=True, text=True, check=True, env=environment)
    return run.stdout


@pytest.mark.slow
def test_text_does_not_depend_on_the_hash_seed():
    first, second = text_under(1), text_under(271828)
    assert len(first) > 5000
    assert first == second


def grown(times, links):
    """Nodes in the table before and after as many derivations, swept."""
    kn.derive(chain(links))
    gc.collect()
    node.sweep()
    before = sum(map(len, node.tables()))
    for _ in range(times):
        kn.derive(chain(links))
    gc.collect()
    node.sweep()
    return before, sum(map(len, node.tables()))


@pytest.mark.slow
def test_derivations_leave_nothing_behind():
    before, after = grown(30, 8)
    assert after <= before


@pytest.mark.slow
def test_a_hundred_derivations_of_twenty_links_leave_nothing_behind():
    before, after = grown(100, 20)
    assert after <= before
