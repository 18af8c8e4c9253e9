# SPDX-License-Identifier: BSD-3-Clause
"""The recursive route gives the accelerations of the classical one, wherever it expresses the tree."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from benchmarks.random_trees import LIMBS, random_tree
from benchmarks.systems import COUNTED, wrist_arm
from kane.dynamics import WAYS, Derived, by_recursion, carrying, classical, derived
from kane.expr import price
from kane.gallery import pendulums, rolling_disk, spinning_top
from kane.kinematics import Unsuited
from tests.examples import examples
from tests.kinematics.test_tree import wrist
from tests.oracles import kane_tree
from tests.oracles.compare import tolerance
from tests.oracles.tree import trees
from tests.systems import jointed

SEEDS = (1, 2, 3)
TREES = [name for name in COUNTED if "general axes" in name or "planar" in name or name == "7R arm"]


def state(expressions, seed):
    """A value for every symbol, sets of Euler parameters of length 1."""
    rng = np.random.default_rng(seed)
    symbols = sorted(kn.free_symbols(expressions), key=lambda s: s.name)
    values = {s: float(s.default) if getattr(s, "default", None) else rng.uniform(-1.2, 1.2) for s in symbols}
    sets = {}
    for s in symbols:
        if s.name[:1] == "e" and s.name[1:2].isdigit():
            sets.setdefault(s.name[2:], []).append(s)
    for group in sets.values():
        length = np.sqrt(sum(values[e] ** 2 for e in group))
        values |= {e: values[e] / length for e in group}
    return values


def by_all_routes(system):
    """What is derived, and solved by each of the recursions; by none where none expresses the system."""
    parts = derived(system)
    try:
        carried = carrying(parts)
        return parts, [by_recursion(parts, carried, route) for route in WAYS]
    except Unsuited:
        return parts, []


def difference(system):
    """The largest difference of u̇ by all routes over the largest u̇, over what rounding allows; None where there is one route."""
    parts, found = by_all_routes(system)
    return max((_difference(parts, f) for f in found), default=None)


def _difference(parts, found):
    usual = classical(parts, None)
    roots = [*found.accelerations, *usual.accelerations]
    n, worst = len(usual.accelerations), 0.0
    for seed in SEEDS:
        values = state([*roots, *parts.mass_matrix.entries], seed)
        numbers = np.array(kn.evaluate(roots, values), dtype=float)
        condition = np.linalg.cond(np.array(kn.evaluate(parts.mass_matrix, values), dtype=float))
        off, largest = np.abs(numbers[:n] - numbers[n:]).max(), np.abs(numbers[n:]).max()
        if off > 0:  # without loads at rest all are zero
            worst = max(worst, off / (largest * tolerance(1e-9, condition)) if largest > 0 else np.inf)
    return worst


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(12))
def test_trees_of_joints(seed):
    off = difference(jointed.system(seed, 1 + seed % 5, jointed.PLAIN))
    assert off is not None
    assert off <= 1


def test_a_seat_turned_by_a_parameter_about_the_axis_of_a_pin():
    """Fixed to a body that turns about the same axis, it carries a body, and a pin about that axis again."""
    N, g = kn.Frame("N"), kn.parameter("g", 9.81)
    at, frame, bodies = kn.Point("O", fixed_in=N), N, []
    for i in range(1, 7):
        turn = kn.parameter(f"a{i}", 0.1 * i) if i % 2 == 0 else kn.coordinate(f"q{i}")
        frame = frame.rotate(f"B{i}", turn, frame.z)
        center = at.at(f"C{i}", 0.3 * frame.x + 0.2 * frame.z)
        bodies.append(
            kn.RigidBody(
                f"b{i}", frame=frame, mass_center=center, mass=1.0 * i, inertia=kn.inertia(frame, 1, 2, 2, 0.3)
            )
        )
        at = at.at(f"P{i}", frame.y * 0.7)
        frame = frame if i < 4 else frame.rotate(f"D{i}", 0.3, frame.x)
    assert difference(kn.System(N, bodies=bodies, speeds="rates", loads=[kn.gravity(-g * N.y)])) <= 1


@pytest.mark.slow
@pytest.mark.parametrize("seed", [5171, 5341, 5351])
def test_seats_turned_by_parameters(seed):
    assert difference(jointed.system(seed, 1 + seed % 9)) <= 1


@examples(0.3)
@given(st.integers(0, 10**6), st.integers(1, 5))
def test_trees_of_any_joints(seed, bodies):
    off = difference(jointed.system(seed, bodies))
    assert off is None or off <= 1


@examples(0.1)
@given(st.integers(0, 10**6), st.integers(2, 5))
def test_trees_of_joints_that_meet(seed, bodies):
    """Several begin at one point."""
    off = difference(jointed.system(seed, bodies, meeting=0.7))
    assert off is None or off <= 1


@examples(0.2)
@given(st.integers(0, 10**6), st.integers(1, 5))
def test_trees_of_any_joints_by_any_speeds(seed, bodies):
    """Constant combinations of joint speeds, ones that change with the configuration, and with time."""
    off = difference(jointed.by_mixed_speeds(jointed.system(seed, bodies), seed))
    assert off is None or off <= 1


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(8))
def test_no_joint_and_no_choice_of_speeds_is_left(seed):
    assert difference(jointed.by_mixed_speeds(jointed.system(seed, 2 + seed % 4), seed)) <= 1


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 0, 1)])
@pytest.mark.parametrize(("twist", "offset"), [(1.0, 0), (0.0, 0), (1.0, 0.3), (kn.pi / 2, 0)])
def test_axes_that_meet(order, twist, offset):
    assert difference(wrist(order, twist, offset)) <= 1


def test_an_arm_with_a_wrist_takes_fewer_operations_than_one_without():
    """Shoulder, elbow and wrist whose axes meet: by recursion, shorter than with offsets between all of them."""
    own, other = (kn.derive(wrist_arm(lengths)) for lengths in ((0.3, 0, 0.4, 0, 0.4, 0, 0.1), (0.3,) * 7))
    assert own.route == other.route == "composite"
    assert own.operations.state <= 970 < other.operations.state
    usual = kn.derive(wrist_arm(), route="classical")
    values = state([*own.accelerations, *usual.accelerations], 1)
    a, b = (np.array(kn.evaluate(list(e.accelerations), values)) for e in (own, usual))
    np.testing.assert_allclose(a, b, rtol=1e-9, atol=1e-9 * np.abs(b).max())


@pytest.mark.parametrize("axis", ["z", "tilted"])
def test_screws(axis):
    """What turns slides by the same speed: on a slider, carrying a screw and a ball."""
    N, g = kn.Frame("N"), kn.parameter("g", 9.81)
    at, frame, joints = kn.Point("O", fixed_in=N), N, []
    makers = (kn.slider, kn.screw, kn.screw, kn.ball)
    for i, make in enumerate(makers):
        along = frame.z if axis == "z" else 0.6 * frame.x + 0.8 * frame.z
        at = at.at(f"P{i}", kn.parameter(f"l{i}", 0.7) * frame.x)
        more = {"pitch": kn.parameter(f"p{i}", 0.3)} if make is kn.screw else {}
        joints.append(make(f"j{i}", at, frame, **(more | ({} if make is kn.ball else {"axis": along}))))
        at, frame = joints[-1].point, joints[-1].frame
    bodies = [
        kn.RigidBody(
            f"b {j.name}", frame=j.frame, mass_center=j.point.at(f"C{j.name}", 0.1 * j.frame.y + 0.2 * j.frame.x),
            mass=kn.parameter(f"m{j.name}", 1.5), inertia=kn.inertia(j.frame, 1, 2, 2.5, 0.1),
        )
        for j in joints
    ]  # fmt: skip
    assert difference(kn.System(N, bodies=bodies, joints=joints, loads=[kn.gravity(-g * N.y)])) <= 1


@pytest.mark.slow
@examples(0.3)
@given(trees(4))
def test_trees_of_turns_and_slides(tree):
    off = difference(kane_tree.derive(tree).eom.system)
    assert off is None or off <= 1


@pytest.mark.parametrize("name", [n if "free" not in n else pytest.param(n, marks=pytest.mark.slow) for n in TREES])
def test_what_is_counted(name):
    assert difference(COUNTED[name]()) <= 1


@pytest.mark.slow
@pytest.mark.parametrize("speeds", ["rates", "mixed", "tips", "scrambled"])
@pytest.mark.parametrize("relative", [False, True])
@pytest.mark.parametrize("cart", [False, True])
def test_speeds_of_chains_in_any_way(speeds, relative, cart):
    assert difference(pendulums.system(5, relative=relative, cart=cart, speeds=speeds)) <= 1


def test_a_route_can_be_asked_for_and_is_kept():
    system = pendulums.system(6)
    eom, usual = kn.derive(system), kn.derive(system, route="classical")
    assert (eom.route, usual.route) == ("recursive", "classical")
    assert eom.routes["recursive"] == eom.operations.total < usual.operations.total
    assert kn.derive(pendulums.system(2), route="recursive").route == "recursive"
    again = pickle.loads(pickle.dumps(usual))
    assert again.route == "classical"
    assert np.array_equal(*(e.evaluate(e.accelerations, q=[0.1] * 6, u=[1.0] * 6) for e in (again, usual)))
    with pytest.raises(kn.ModelError, match="one of classical, recursive, composite, got"):
        kn.derive(system, route="articulated")


def test_what_no_recursion_expresses_is_said():
    for route, system, why in (
        ("composite", rolling_disk.system(), "loads that contain reactions"),
        ("recursive", spinning_top.system(speeds="node"), "speeds whose W has poles"),
        ("composite", spinning_top.system(speeds="node"), "speeds whose W has poles"),
    ):
        with pytest.raises(kn.ModelError, match=f"route='{route}', got .*{why}.*route='classical'"):
            kn.derive(system, route=route)
        assert kn.derive(system).route not in WAYS


def test_the_mass_matrix_is_assembled_when_it_is_read(monkeypatch):
    monkeypatch.setattr(Derived, "blocks", property(lambda d: pytest.fail("M is assembled")))
    eom = kn.derive(pendulums.system(12))
    sol = kn.simulate(eom, (0, 0.1), q=[0.1] * 12, u=[0.0] * 12)
    assert sol.status == "finished"
    monkeypatch.undo()
    assert eom.mass_matrix.shape == (12, 12)


def test_what_moves_no_mass_is_an_error_of_any_route():
    """The last of a chain has neither mass nor inertia."""
    N, g = kn.Frame("N"), kn.parameter("g", 9.81)
    at, frame, bodies = kn.Point("O", fixed_in=N), N, []
    for i in range(1, 8):
        q = kn.coordinate(f"q{i}")
        frame = frame.rotate(f"B{i}", q, frame.y if i % 2 else frame.z)
        mass = 0 if i == 7 else 1.0
        bodies.append(
            kn.RigidBody(
                f"b{i}",
                frame=frame,
                mass_center=at.at(f"C{i}", 0.5 * frame.x),
                mass=kn.parameter(f"m{i}", 1.0) * mass,
                inertia=kn.inertia(frame, 0, 0, 0),
            )
        )
        at = at.at(f"P{i}", frame.x * 1.0)
    with pytest.raises(kn.ModelError, match="move some mass"):
        kn.derive(kn.System(N, bodies=bodies, speeds="rates", loads=[kn.gravity(-g * N.z)]))


@pytest.mark.parametrize("make", [lambda: pendulums.system(60), lambda: random_tree(range(-1, 19), 1)])
def test_operations_grow_as_the_tree(make):
    """From one half of a chain to the whole they double, but for the ends."""
    whole = kn.derive(make()).operations.total
    bodies = len(make().bodies)
    half = kn.derive(pendulums.system(30) if bodies == 60 else random_tree(range(-1, 9), 1)).operations.total
    assert 1.9 < whole / half < 2.2


@pytest.mark.slow
def test_reactions_follow_from_the_recursion():
    N, g = kn.Frame("N"), kn.parameter("g", 9.81, "m/s^2")
    at, frame, bodies = kn.Point("O", fixed_in=N).at("A", 0), N, []
    cut = kn.reaction("R", at=at, along=N.y)
    for i in range(1, 7):
        frame = frame.rotate(f"B{i}", kn.coordinate(f"q{i}"), frame.z)
        m = kn.parameter(f"m{i}", 1.0, "kg")
        bodies.append(kn.Particle(f"p{i}", at.at(f"P{i}", frame.x * kn.parameter(f"l{i}", 1.0, "m")), m))
        at = bodies[-1].point
    system = kn.System(N, bodies=bodies, speeds="rates", loads=[kn.gravity(-g * N.y)], reactions=[cut])
    eoms = [kn.derive(system, route="recursive"), kn.derive(system, route="classical")]
    state = {"q": [0.3, -0.4, 0.5, 0.2, 0.9, -1.0], "u": [1.0, 2.0, -1.0, 0.5, 0.1, -2.0]}
    values = [np.array(e.evaluate([*e.accelerations, cut], **state)) for e in eoms]
    assert values[0] == pytest.approx(values[1], rel=1e-9)


def test_a_body_that_slides_along_itself_and_carries_pins_about_the_axis_it_turns_about():
    N, g = kn.Frame("N"), kn.parameter("g", 9.81)
    x, y, *q = kn.coordinates("x y q1:6")
    frame, at = N.rotate("B0", q[0], N.z), kn.Point("O", fixed_in=N).at("A", x * N.x + y * N.y)
    v = at.velocity(N)
    definitions = [q[0].dt, v.dot(frame.x), v.dot(frame.y), *(a.dt for a in q[1:])]
    bodies = []
    for i, angle in enumerate((*q[1:], None)):
        solid = {"mass": kn.parameter(f"m{i}", 1.0), "inertia": kn.inertia(frame, 1, 2, 3)}
        bodies.append(kn.RigidBody(f"b{i}", frame=frame, mass_center=at.at(f"C{i}", frame.y * 0.2), **solid))
        if angle is not None:
            at = at.at(f"P{i}", frame.x * 0.4 + frame.z * 0.1)
            frame = frame.rotate(f"B{i + 1}", angle, frame.z)
    speeds = dict(zip(kn.speeds("u1:8"), definitions, strict=True))
    assert difference(kn.System(N, bodies=bodies, speeds=speeds, loads=[kn.gravity(-g * N.y)])) <= 1


def test_the_shorter_recursion_is_taken():
    assert kn.derive(random_tree(range(-1, 6), 1)).route == "composite"
    assert kn.derive(pendulums.system(10)).route == "recursive"


def test_links_without_length_or_mass_are_as_good_as_others():
    """A link's share of the next one's mass is a quotient by its length that has no divisor."""
    N, g = kn.Frame("N"), kn.parameter("g", 9.81)
    at, bodies = kn.Point("O", fixed_in=N), []
    for i in range(1, 8):
        frame = N.rotate(f"B{i}", kn.coordinate(f"q{i}"), N.z)
        m, length, inertia = (kn.parameter(f"{name}{i}", 1.0) for name in "mlI")
        center = at.at(f"C{i}", length / 2 * frame.x)
        bodies.append(
            kn.RigidBody(f"b{i}", frame=frame, mass_center=center, mass=m, inertia=kn.inertia(frame, 0, 0, inertia))
        )
        at = at.at(f"P{i}", length * frame.x)
    system = kn.System(N, bodies=bodies, speeds="rates", loads=[kn.gravity(-g * N.y)])
    state = {"q": np.linspace(-1, 2, 7), "u": np.linspace(2, -1, 7), "parameters": {"l3": 0.0, "m5": 0.0, "m3": 0.0}}
    found, wanted = (
        np.array(e.evaluate(e.accelerations, **state))
        for e in (kn.derive(system, route="recursive"), kn.derive(system, route="classical"))
    )
    assert np.abs(found - wanted).max() <= 1e-12 * np.abs(wanted).max()


@pytest.mark.parametrize(("rods", "relative", "most"), [(10, False, 500), (40, False, 2100), (10, True, 550)])
def test_planar_chains_are_as_short_as_by_hand(rods, relative, most):
    """Each rod is two masses at its ends and a moment of inertia: M of the pins has two entries to add for it."""
    assert kn.derive(pendulums.system(rods, relative=relative)).operations.state <= most


@pytest.mark.slow
@pytest.mark.parametrize(
    ("parents", "floating", "general", "state", "most"),
    [
        (LIMBS, True, False, 9_950, 10_465),
        (LIMBS, True, True, 9_950, 12_300),
        (range(-1, 6), False, False, 1_860, 2_025),
        (range(-1, 6), False, True, 1_860, 2_540),
    ],
)
def test_general_axes_by_numbers_and_by_parameters(parents, floating, general, state, most):
    """Four limbs on a base that floats, J and M of each turned with one 2 cos q; an arm."""
    found = kn.derive(random_tree(parents, 1, floating=floating, general=general)).operations
    assert found.state <= state
    assert found.total <= most


@pytest.mark.slow
@pytest.mark.parametrize("route", WAYS)
def test_rates_of_euler_parameters_by_half_of_omega(route):
    """Three halves a set, in the place of four, where u̇ does not hold the rates itself."""
    floating = random_tree((-1, 0, 0, 1), 3, floating=True)
    for system, least in ((floating, 1), (jointed.system(4, 3, ("free", "ball")), 0)):
        own, usual = kn.derive(system, route=route), kn.derive(system, route="classical")
        roots = [*own.solved.rates, *usual.solved.rates]
        values = state([*roots, *own.accelerations], 2)
        a, b = np.array(kn.evaluate(roots, values), dtype=float).reshape(2, -1)
        np.testing.assert_allclose(a, b, rtol=1e-12, atol=1e-13)
        assert price(usual.solved.rates) - price(own.solved.rates) == least


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_joints_oriented_by_angles_turn_by_their_angular_velocity(seed):
    """Where bodies are not tilted by numbers; elsewhere the classical route is left."""
    off = difference(jointed.system(seed, 3, ("turning ball", "turning free", "pin")))
    assert off is None or off <= 1


@pytest.mark.slow
def test_u_dot_is_right_at_gimbal_lock_of_a_free_body_and_below_a_universal_joint():
    """Speeds are ω and v along the body; at q2 = π/2 its angles' rates are infinite."""
    N, g = kn.Frame("N"), kn.parameter("g", 9.81)
    joints = [kn.free("base", kn.Point("O", fixed_in=N), N, orientation="angles")]
    at, frame = joints[0].point, joints[0].frame
    for i in range(1, 4):
        cross = kn.universal(f"cross{i}", at.at(f"P{i}", 0.3 * frame.x), frame, axes=(frame.x, frame.y))
        joints += [
            cross,
            kn.ball(f"ball{i}", cross.point.at(f"Q{i}", 0.2 * cross.frame.z), cross.frame, orientation="angles"),
        ]
        at, frame = joints[-1].point, joints[-1].frame
    bodies = [
        kn.RigidBody(
            j.name,
            frame=j.frame,
            mass_center=j.point.at(f"C{j.name}", 0.1 * j.frame.y + 0.05 * j.frame.x),
            mass=kn.parameter(f"m_{j.name}", 1.0),
            inertia=kn.inertia(j.frame, 0.1, 0.2, 0.15, 0.01),
        )
        for j in joints
    ]
    system = kn.System(N, bodies=bodies, joints=joints, loads=[kn.gravity(-g * N.z)])
    eom, usual = kn.derive(system), kn.derive(system, route="classical")
    assert eom.route in WAYS
    rng = np.random.default_rng(1)
    q, u = {x: rng.uniform(-1, 1) for x in system.coordinates}, rng.normal(size=len(eom.speeds))
    locked = [x for x in system.coordinates if x.name.startswith("q2_b")]

    def at_lock(e, off=0.0):
        return np.array(e.evaluate(e.accelerations, q=q | dict.fromkeys(locked, np.pi / 2 + off), u=u))

    here, beside, wanted = at_lock(eom), at_lock(eom, 1e-3), at_lock(usual, 1e-3)
    size = np.abs(wanted).max()
    assert np.abs(beside - wanted).max() <= 1e-9 * size
    assert np.abs(here - (at_lock(eom, 1e-4) + at_lock(eom, -1e-4)) / 2).max() <= 1e-6 * size
