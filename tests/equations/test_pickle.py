# SPDX-License-Identifier: BSD-3-Clause
"""Copies and pickles of what models are made of: a copy is the thing itself, a pickle means the same in another process."""

from __future__ import annotations

import copy
import pickle
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

import kane as kn
from kane.equations import repartition
from kane.gallery import GALLERY, load

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
q1, q2 = kn.coordinates("q1 q2")
u1, u2 = kn.speeds("u1 u2")
m, L, g, T = kn.parameter("m", 1.2), kn.parameter("L", 0.5), kn.parameter("g", 9.81), kn.input("T")
A = N.rotate("A", q1, N.z)
B = A.rotate_body("B", (q2, 0.1, 0.2), "xyz")
P = O.at("P", L * A.x)
Q = P.fixed_in(B, "Q", L * B.x)
PULL = kn.reaction("R", at=P, along=A.x)
JOINT = kn.pin("hinge", P, A, axis=A.x, coordinates=[q2], speeds=[u2])
ROD = kn.RigidBody("rod", frame=B, mass_center=P.at("G", L * B.x), mass=m, inertia=kn.rod(B, m, L, axis=B.x))
SYSTEM = kn.System(
    N,
    bodies=[kn.Particle("bob", P, m), ROD],
    speeds={u1: q1.dt, u2: q2.dt},
    loads=[kn.gravity(-g * N.y), kn.Torque(A, T * N.z), kn.linear_spring(P, O, stiffness=20, free_length=0.1)],
    reactions=[PULL],
    events=[kn.Event("turned", q1, threshold=2.0, terminal=False)],
    joints=[JOINT],
)
EOM = kn.derive(SYSTEM)
SOL = kn.simulate(EOM, (0, 0.4), q=[0.2, 0.3], u=[1, 2], inputs={T: lambda t: np.sin(7 * t)}, samples=9)
ROWS = kn.coincident(P, O, along=(N.x, N.y))
THINGS = [
    N, B, O, Q, P.velocity(N), ROD.inertia, *SYSTEM.bodies, *SYSTEM.all_loads(), *SYSTEM.gravities, *SYSTEM.events, *ROWS, JOINT,
    SYSTEM, EOM, EOM.mass_matrix,
]  # fmt: skip


def again(x):
    return pickle.loads(pickle.dumps(x))


@pytest.mark.parametrize("thing", THINGS, ids=lambda x: type(x).__name__)
def test_a_copy_is_the_thing_itself(thing):
    if isinstance(thing, kn.Matrix):
        assert copy.deepcopy(thing).entries == thing.entries
        return
    assert copy.copy(thing) is thing
    assert copy.deepcopy(thing) is thing
    assert copy.deepcopy({"a": [thing]})["a"][0] is thing


@pytest.mark.parametrize("thing", [*THINGS, SOL], ids=lambda x: type(x).__name__)
def test_a_pickle_reads_as_it_was(thing):
    assert repr(again(thing)) == repr(thing)


def test_what_was_one_stays_one():
    frame, point, vector, twice = again((B, Q, P.velocity(N), B))
    assert frame is twice
    assert point.body is frame
    assert vector.dt(frame.root()).components(frame.root())[0] is P.velocity(N).dt(N).components(N)[0]
    assert frame.angular_velocity(frame.root()).dot(frame.x) is B.angular_velocity(N).dot(B.x)
    assert point.acceleration(frame.root()).components(frame) == Q.acceleration(N).components(B)


def test_equations_and_motions_mean_the_same():
    eom, sol = again((EOM, SOL))
    assert sol.equations is eom
    assert eom.mass_matrix.entries == EOM.mass_matrix.entries
    state = {"q": [0.4, 1.0], "u": [1.0, 2.0], "inputs": {"T": 0.3}}
    assert eom.evaluate(list(eom.accelerations), **state) == EOM.evaluate(list(EOM.accelerations), **state)
    for name in ("q1", "u2", "u2'", "R", "T", "m"):
        assert np.array_equal(sol[name], SOL[name])
    assert np.array_equal(sol[eom.system["P"].position(eom.system["O"])], SOL[P.position(O)])
    assert sol.energy_check == SOL.energy_check
    with pytest.raises(
        kn.SimulationError,
        match=r"among the samples for the input T of a motion that was saved or pickled, got t = 0.0123",
    ):
        sol.inputs[T](0.0123)
    with pytest.raises(kn.SpaceError, match="no common root"):  # another frame now, which is said
        sol[P.position(O)]
    deep = copy.deepcopy(SOL)
    deep.states[:] = 0
    assert SOL.states.any()
    assert deep.equations is EOM


def test_long_lines_of_frames_and_points():
    angles = kn.coordinates("a0:600")
    frame, point = N, O
    for k, a in enumerate(angles):
        frame = frame.rotate(f"F{k}", a, (frame.x, frame.y)[k % 2])
        point = point.at(f"P{k}", frame.x)
    for thing in (frame, point):
        other = again(thing)
        while other.parent is not None:
            assert other.name == thing.name
            other, thing = other.parent, thing.parent
        assert thing in (N, O)


def test_dependent_speeds_that_were_changed_stay():
    eom = kn.derive(load("four_bar").system())
    eom = repartition(eom, replace(eom.embedding.partition, dependent=(0, 1)))
    assert eom.dependent_speeds == eom.speeds[:2]
    other = again(eom)
    assert other.dependent_speeds == eom.dependent_speeds
    assert other.right_hand_side == eom.right_hand_side


@pytest.mark.slow
def test_in_another_process():
    code = (
        "import pickle, sys; eom, sol = pickle.load(sys.stdin.buffer); "
        "print(*eom.evaluate(list(eom.accelerations), q=[0.4, 1.0], u=[1.0, 2.0], inputs={'T': 0.3}), *sol['R'])"
    )
    ran = subprocess.run([sys.executable, "-c", code], input=pickle.dumps((EOM, SOL)), capture_output=True, check=True)
    told = [float(x) for x in ran.stdout.split()]
    here = EOM.evaluate(list(EOM.accelerations), q=[0.4, 1.0], u=[1.0, 2.0], inputs={"T": 0.3})
    assert told == pytest.approx([*map(float, here), *SOL["R"]], rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("name", GALLERY)
def test_every_system_of_the_gallery(name):
    system = load(name).system()
    other = again(system)
    assert [s.name for s in other.coordinates] == [s.name for s in system.coordinates]
    one, two = kn.derive(system), kn.derive(other)
    assert one.mass_matrix.entries == two.mass_matrix.entries
    if not system.reactions:
        assert one.right_hand_side == two.right_hand_side
