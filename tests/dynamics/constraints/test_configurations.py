# SPDX-License-Identifier: BSD-3-Clause
"""Several configurations decide: rank and dependent speeds do not hang on one of them, nor on units."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import kane as kn
from kane.dynamics import chosen, configurations, derived, qualities
from kane.gallery import bricard, four_bar, n_four_bar, whipple_bicycle
from tests.systems.four_bar import BAR

CLOSED = {f"q{k}": 0.0 for k in range(1, 6)}


def quietly(system, **more):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", kn.KaneWarning)
        return kn.derive(system, **more)


def in_multipliers(eom, **state):
    """u̇ of [M −Aᵀ; A 0] [u̇; λ] = [f; −(Ȧ u + ḃ)]: rows that depend on each other do no harm."""
    M, A = (np.asarray(eom.evaluate(x, **state), dtype=float).reshape(x.shape) for x in (eom.mass_matrix, eom.A))
    right = np.array(eom.evaluate([*eom.forcing, *eom.constraints.drift], **state), dtype=float)
    n, m = len(M), len(A)
    right[n:] *= -1
    return np.linalg.lstsq(np.block([[M, -A.T], [A, np.zeros((m, m))]]), right, rcond=1e-11)[0][:n]


@pytest.mark.parametrize("near", [None, CLOSED])
def test_bricard_whole_has_the_rank_of_its_motion(near):
    """Among the assemblies of the six hinges are some of lower rank: a second constraint was left out there."""
    eom = quietly(bricard.system(redundant=True), near=near)
    assert len(eom.redundant) == 1
    assert len(eom.independent_speeds) == 1
    found = kn.assemble(eom, q={"q1": 0.3, **{f"q{k}": kn.guess(0.1) for k in range(2, 6)}}, u={"u1": 1.0})
    state = {"q": found.q, "u": found.u}
    np.testing.assert_allclose(eom.evaluate(eom.accelerations, **state), in_multipliers(eom, **state), rtol=1e-9)


@pytest.mark.parametrize(("which", "near"), [(four_bar, None), (bricard, CLOSED)])
def test_every_configuration_is_closed_and_gives_the_dependent_speeds(which, near):
    """Bricard's linkage has branches for which no one choice will do."""
    system = which.system()
    eom = kn.derive(system, near=near)
    found = eom.derived.compared
    f = configurations(system, [c.expr for c in system.holonomic])
    closed = [np.abs(kn.evaluate([c.expr for c in system.holonomic], f.at(k))).max() for k in range(f.count)]
    assert max(closed) < 1e-10
    assert found.at.count > 2
    assert qualities(found.a, eom.embedding.partition).min() > 1e-3


@pytest.mark.parametrize("windows", [1, 2, 5])
def test_all_speeds_but_that_of_the_first_crank_depend(windows):
    """Parallelograms have change points and branches that cross: that one configuration is such a point refuses nothing."""
    system = n_four_bar.system(windows)
    first, *others = system.speeds
    eom = kn.derive(system.replace(dependent_speeds=others))
    assert eom.independent_speeds == (first,)
    assert not eom.redundant


def test_a_front_wheel_that_is_steered_drives_straight():
    """w = v tan(delta)/L: v would follow from w where the wheel stands across, but not straight ahead."""
    N = kn.Frame("N")
    x, y, theta, delta = kn.coordinates("x y theta delta")
    v, w, s, side = kn.speeds("v w s side")
    B = N.rotate("B", theta, N.z)
    S = B.rotate("S", delta, B.z)
    R = kn.Point("O", fixed_in=N).at("R", x * N.x + y * N.y)
    F = R.at("F", 1.0 * B.x)
    frames = {"car": (B, R.at("C", 0.5 * B.x), 10.0, 2.0), "fork": (S, F, 1.0, 0.1)}
    bodies = [
        kn.RigidBody(name, frame=f, mass_center=c, mass=m, inertia=kn.inertia(f, i, i, i))
        for name, (f, c, m, i) in frames.items()
    ]
    push = kn.input("push")
    held = [*kn.no_slip(R, along=B.y, name="rear"), *kn.no_slip(F, along=S.y, name="front")]
    velocity = R.velocity(N)
    speeds = {v: velocity.dot(B.x), w: theta.dt, s: delta.dt, side: velocity.dot(B.y)}
    system = kn.System(N, bodies=bodies, speeds=speeds, nonholonomic=held, loads=[kn.Force(R, push * B.x)])
    eom = quietly(system)
    assert set(eom.dependent_speeds) == {w, side}
    assert eom.evaluate(v.dt, q=0, u={v: 2.0, s: 0.0}, inputs={push: 1.0}) == pytest.approx(1 / 11)


def test_near_says_which_branch():
    """Elbow up and elbow down: all configurations compared lie on the branch of the one that is given."""
    q1, q2, q3 = BAR.q
    system = BAR.system()
    eom = kn.derive(system, near={q1: 1.2, "q2": 0.4, q3: -1.5})
    at = eom.derived.compared.at
    assert at.at(0)[q2] == pytest.approx(0.439637, abs=0.1)
    values = np.array([at.values[q] for q in BAR.q])
    assert np.abs(values - [[1.2], [0.4], [-1.5]]).max() < 1.2
    flipped = kn.derive(system, near={q1: 1.2, q2: -1.5, q3: 0.4}).derived.compared.at
    assert flipped.at(0)[q2] < flipped.at(0)[q3]
    assert at.at(0)[q2] > at.at(0)[q3]


def test_near_that_is_none():
    system = BAR.system()
    with pytest.raises(kn.ValueMissingError, match=r"t in near= of the system .*got one for 'q9'"):
        kn.derive(system, near={"q9": 1.0})
    with pytest.raises(kn.SimulationError, match="a finite value in near= for q1, got nan"):
        kn.derive(system, near={"q1": np.nan})
    with pytest.raises(kn.ModelError, match="Expected near= at which the constraints nearly hold, got d = 9, "):
        kn.derive(four_bar.system(), near={"d": 9.0})


def linkage(unit: float, seed: int) -> kn.System:
    """A four-bar and a slider in lengths of 1/unit m: the same mechanism whatever the unit, one row of it twice."""
    rng = np.random.default_rng(seed)
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    q = kn.coordinates("q1:4")
    s = kn.coordinate("s")
    bodies, at = [], O
    for k, length in enumerate(rng.uniform(0.8, 1.2, 3) * [0.4, 1.0, 0.8] * unit):
        frame = N.rotate(f"B{k}", q[k], N.z)
        center, at = at.at(f"c{k}", length / 2 * frame.x), at.at(f"e{k}", length * frame.x)
        inertia = kn.inertia(frame, *(unit**2 * x for x in (0.01, 0.1, 0.1)))
        bodies.append(kn.RigidBody(f"b{k}", frame=frame, mass_center=center, mass=1, inertia=inertia))
    slider = O.at("S", s * N.x)
    bodies.append(kn.Particle("slider", slider, 1))
    G = O.at("G", 1.1 * unit * N.x)
    pin = kn.coincident(at, G, along=(N.x, N.y), name="pin")
    rod = kn.distance(bodies[0].mass_center, slider, 0.9 * unit, name="rod")
    turn = kn.configuration_constraint("again", 1e3 * (pin[0].expr + pin[1].expr))
    return kn.System(N, bodies=bodies, speeds="rates", holonomic=[*pin, rod, turn])


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_units_of_length_do_not_matter(seed):
    """In m, mm and Mm the same is closed, redundant and dependent."""
    verdicts = []
    for unit in (1.0, 1e3, 1e-6):
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            eom = kn.derive(linkage(unit, seed))
        verdicts.append(([str(w.message) for w in told], len(eom.redundant), len(eom.dependent_speeds)))
        assert not eom.derived.compared.at.missed
    assert verdicts[0][1:] == (1, 3)
    assert verdicts[1:] == verdicts[:1] * 2


def quality_upright(system, **angles):
    """How well the dependent speeds follow where all coordinates but those given are zero."""
    eom = kn.derive(system)
    q = {s.name: angles.get(s.name, 0.0) for s in eom.coordinates}
    a = np.array(eom.evaluate(eom.A, q=q, u=[0.0] * len(eom.speeds)), dtype=float)
    return qualities(a[None], eom.embedding.partition)[0]


@pytest.mark.parametrize("speeds", ["rates", "spins"])
def test_dependent_speeds_follow_upright_and_straight(speeds):
    """The bicycle's lean rate follows wherever random configurations lie, but not there."""
    assert quality_upright(whipple_bicycle.system(speeds)) > 0.1
    assert quality_upright(whipple_bicycle.system(speeds), psi=np.pi / 2) > 0.1


@pytest.mark.slow
def test_forty_windows_are_closed_from_upright():
    """So many loops are closed from no random start; as they stand they are."""
    found = derived(n_four_bar.system(40)).compared
    assert not found.at.missed
    assert found.at.special[0]
    assert found.at.count > 2


def test_exchanges_that_no_greedy_choice_finds():
    """Three matrices: speeds 0 or 1, each poor at one of them, 2 good at all but never the largest."""
    a = np.array([[[1, 0, 0.4]], [[0, 1, 0.4]], [[1, 1, 0.4]]], dtype=float)
    found = chosen(a, np.array([True, True, False]), (), np.zeros((1, 3), dtype=bool))
    assert found.dependent == (2,)
