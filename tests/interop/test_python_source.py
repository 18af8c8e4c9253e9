# SPDX-License-Identifier: BSD-3-Clause
"""Systems written as Python files: what the file makes when it runs has the same equations, operation by operation."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

import kane as kn
from kane.expr import digest
from kane.gallery import GALLERY, load
from tests.examples import examples
from tests.interop.written import assert_alike, imported
from tests.systems import jointed

QUICK = (
    "four_bar",
    "whipple_bicycle",
    "bricard",
    "rattleback",
    "compass_gait",
    "rolling_disk",
    "spinning_top",
    "mass_on_belt",
)


@pytest.mark.parametrize("name", [pytest.param(n, marks=() if n in QUICK else pytest.mark.slow) for n in GALLERY])
def test_the_gallery(name, tmp_path):
    module = load(name)
    system = module.system()
    if any(not isinstance(b, kn.RigidBody | kn.Particle) for b in system.bodies):
        with pytest.raises(kn.ModelError, match="which only its source file can declare"):
            kn.exchange.to_python(system)
        return
    text = kn.exchange.to_python(system, title=module.TITLE)
    written = imported(tmp_path / "model.py", text)
    assert written.TITLE == module.TITLE
    assert max(map(len, text.splitlines())) <= 118
    assert_alike(system, written.system())
    assert kn.exchange.to_python(written.system(), title=module.TITLE) == text


CLOSURES = {
    "weld": {}, "pin": {"axis": 1}, "slider": {"axis": -3}, "cylindrical": {"axis": 2}, "planar": {"normal": 3}, "ball": {},
}  # fmt: skip


@pytest.mark.parametrize(
    "kind", [pytest.param(k, marks=pytest.mark.slow) if k in ("slider", "cylindrical") else k for k in CLOSURES]
)
def test_closures_keep_the_orientation_that_they_mean(kind, tmp_path):
    """Their calls come back with what says which of several orientations is meant; what no call makes is refused."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    a = kn.free("a", O, N)
    b = kn.free("b", O, N)
    ends = a.point.at("A", 0.3 * a.frame.x), b.point.at("B", 0.2 * b.frame.y)
    bodies = [
        kn.RigidBody(j.name, frame=j.frame, mass_center=j.point, mass=1.0, inertia=kn.inertia(j.frame, 1, 2, 2.5))
        for j in (a, b)
    ]

    def system(axis):
        close = getattr(kn, f"close_{kind}")
        given = {key: axis(number) for key, number in CLOSURES[kind].items()}
        closed = close("G", ends[0], a.frame, ends[1], b.frame, **given)
        return kn.System(N, bodies=bodies, joints=[a, b], holonomic=closed)

    plain = system(lambda k: (a.frame.x, a.frame.y, a.frame.z)[abs(k) - 1] * (1 if k > 0 else -1))
    text = kn.exchange.to_python(plain)
    written = imported(tmp_path / "m.py", text).system()
    assert_alike(plain, written)
    assert [c.branch and (c.branch.name, c.branch.what) for c in written.constraints] == [
        c.branch and (c.branch.name, c.branch.what) for c in plain.constraints
    ]
    if any(c.branch for c in plain.constraints):
        assert f'kn.close_{kind}("G", ' in text
    if "axis" in CLOSURES[kind]:
        with pytest.raises(
            kn.ModelError, match="constraint 'G tilt1'.*which only its source" if kind != "slider" else "G"
        ):
            kn.exchange.to_python(system(lambda k: 0.6 * a.frame.x + 0.8 * a.frame.y))


def touching():
    """Two bodies free of each other on a plane that turns, in space; and what is asked for laws."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    bodies = [kn.free(name, O, N) for name in "AB"]
    plane = N.rotate("T", 2 * kn.time, N.z)
    numbers = [kn.parameter(*row) for row in (("R", 0.5), ("r", 0.1), ("mu", 0.2), ("mu_s", 0.3), ("L", 2.0))]
    return N, O, bodies, plane, numbers


PLACES = {
    "point": lambda O, a, b, T, R, r: kn.joints.point_on_plane("touch", O.at("X", a.point.position(O)), O, normal=T.z),
    "corner": lambda O, a, b, T, R, r: kn.joints.corners_on_plane(
        "touch", [a.point.fixed_in(a.frame, "edge", R * a.frame.x + r * a.frame.y)], O, normal=T.z, along=T.y
    )[0],
    "belt": lambda O, a, b, T, R, r: kn.joints.sphere_on_plane(
        "touch", a.frame, a.point, O, radius=R + r, normal=a.parent.z, surface=r * a.parent.x
    ),
    "disk": lambda O, a, b, T, R, r: kn.joints.disk_on_plane(
        "touch", a.frame, a.point, O, axis=a.frame.y, radius=R, normal=T.z
    ),
    "torus": lambda O, a, b, T, R, r: kn.joints.torus_on_plane(
        "touch", a.frame, a.point, O, axis=a.frame.y, radius=R, crown=r, normal=T.z
    ),
    "spheres": lambda O, a, b, T, R, r: kn.joints.sphere_on_sphere(
        "touch", a.frame, a.point, b.frame, b.point, radius=r, other_radius=R
    ),
    "bowl": lambda O, a, b, T, R, r: kn.joints.sphere_on_sphere(
        "touch", a.frame, a.point, b.frame, b.point, radius=r, other_radius=R, inside=True
    ),
    "pipe": lambda O, a, b, T, R, r: kn.joints.sphere_on_cylinder(
        "touch", a.frame, a.point, b.frame, b.point, axis=b.frame.y, radius=r, cylinder_radius=R, inside=True
    ),
}  # fmt: skip
CALLED = {"point": "point_on_plane", "corner": "point_on_plane", "belt": "sphere_on_plane", "disk": "disk_on_plane",
          "spheres": "sphere_on_sphere", "bowl": "sphere_on_sphere"}  # fmt: skip


@pytest.mark.parametrize("place", [pytest.param(p, marks=() if p == "belt" else pytest.mark.slow) for p in PLACES])
def test_contacts_come_back_by_the_calls_that_make_them(place, tmp_path):
    """Others as records; laws with functions of the speed, with what they press, and events on their forces."""
    N, O, (a, b), T, (R, r, mu, mu_s, L) = touching()
    at = PLACES[place](O, a, b, T, R, r)
    law = kn.contact(at, kn.joints.stribeck(mu, mu_s, 0.1), viscous=r, restitution=0.5, law="newton", name="it")
    contacts = [law]
    if place == "belt":
        contacts += [
            kn.joints.rope("rope", [O, a.point, b.point], L - 0.1 * kn.time, restitution=0.1, law="newton"),
            kn.joints.stop("stop", L - a.coordinates[-1]),
            kn.joints.rolling_resistance(law, 0.01),
            kn.joints.drilling_resistance(law, r, static=2 * r, name="d"),
        ]
    parts = [
        kn.RigidBody(j.name, frame=j.frame, mass_center=j.point, mass=1.0, inertia=kn.inertia(j.frame, 1, 2, 2.5))
        for j in (a, b)
    ]
    system = kn.System(N, bodies=parts, joints=[a, b], contacts=contacts)
    text = kn.exchange.to_python(system)
    assert f'kn.joints.{CALLED.get(place, "Contact")}("touch' in "".join(text.split())
    assert_alike(system, imported(tmp_path / "m.py", text).system())


def test_a_rope_round_a_drum_is_refused():
    N, O, (a, _), _, (_, _, mu, _, L) = touching()
    drum = O.at("D", N.x)
    held = kn.joints.capstan("wound", [O, drum, a.point], L, mu, drum=drum, angle=3.0)
    body = kn.RigidBody("a", frame=a.frame, mass_center=a.point, mass=1.0, inertia=kn.inertia(a.frame, 1, 2, 2.5))
    with pytest.raises(kn.ModelError, match=r"got the contact 'wound'.*which only its source file can declare"):
        kn.exchange.to_python(kn.System(N, bodies=[body], joints=[a], contacts=[held]))


@examples(0.1)
@example(5, 5)  # a load along a frame within a joint
@example(89, 5)
@given(st.integers(0, 2**32), st.integers(1, 5))
def test_random_trees(tmp_path_factory, seed, bodies):
    system = jointed.system(seed, bodies)
    text = kn.exchange.to_python(system)
    assert_alike(system, imported(tmp_path_factory.mktemp("tree") / "model.py", text).system(), signs=False)


TABLES = {
    "linear": np.linspace(0.1, 2.9, 40) ** 2, "cubic": [0.0, 0.3, -1.0, 1 / 3], "periodic": [0.0, 0.3, -1.0, 0.0], "steps": [2.0],
}  # fmt: skip


@pytest.mark.parametrize("kind", TABLES)
def test_tables_come_back_by_their_points(kind, tmp_path):
    """In loads, in potentials with their derivatives, in events, and one of the state beside one of the time."""
    y = TABLES[kind]
    x = np.linspace(0.5, 7, len(y))
    N = kn.Frame("N")
    q, u = kn.coordinate("q", "m"), kn.speed("u", "m/s")
    P = kn.Point("O", fixed_in=N).at("P", q * N.x)
    force, plain = kn.table(x, y, kind, name="class", unit="N", of="m"), kn.table(x, y, kind)
    loads = [kn.Force(P, force(2 * q) * plain(kn.time) * N.x)]
    if kind in ("cubic", "periodic"):
        loads.append(kn.loads.Load.from_potential(kn.table(x, y, kind, name="V")(q), "pulled"))
    body, events = kn.Particle("p", P, kn.parameter("m", 2.0, "kg")), [kn.Event("there", plain(q) - 0.1)]
    system = kn.System(N, bodies=[body], speeds={u: q.dt}, loads=loads, events=events)
    text = kn.exchange.to_python(system)
    written = imported(tmp_path / "m.py", text).system()
    assert_alike(system, written)
    assert digest(written.events[0].quantity) == digest(events[0].quantity)
    assert kn.exchange.to_python(written) == text
    assert max(map(len, text.splitlines())) <= 118


def test_names_that_python_does_not_take(tmp_path):
    """Names stay what they were; those of Python's variables are free identifiers."""
    N = kn.Frame("class")
    q, u = kn.coordinate("kn"), kn.speed("lambda")
    m, other = kn.parameter("m'", 2.0), kn.parameter("m*", 3.0)
    P = kn.Point("1", fixed_in=N).at('\u03b8 "quoted"', q * N.x)
    body = kn.Particle("class", P, m + other)
    system = kn.System(N, bodies=[body], speeds={u: q.dt}, loads=[kn.Force(P, -kn.input("def") * N.x, name="a\\b")])
    written = imported(tmp_path / "m.py", kn.exchange.to_python(system, title='it\'s "one"', remarks=["read"])).system()
    assert_alike(system, written)
    assert [p.name for p in written.points] == [p.name for p in system.points]


def test_a_spring_between_points_at_rest_has_a_number_for_potential(tmp_path):
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    P = O.at("P", kn.coordinate("x") * N.x)
    still = kn.loads.linear_spring(O, O.at("Q", 3 * N.y), 2.0, 1.0)
    system = kn.System(N, bodies=[kn.Particle("p", P, 1.5)], speeds="rates", loads=[still])
    written = imported(tmp_path / "m.py", kn.exchange.to_python(system)).system()
    assert_alike(system, written)
    assert kn.derive(written).potential_energy is kn.derive(system).potential_energy


def test_the_start(tmp_path):
    system = load("double_pendulum").system()
    start = {"q": {"q1": 1.0, "q2": 2.0}, "u": {}}
    written = imported(tmp_path / "m.py", kn.exchange.to_python(system, start=start)).START
    assert written == {"q": start["q"]}


LEAVES = [kn.coordinate("x"), kn.parameter("a"), kn.parameter("b"), kn.time, kn.pi, *map(kn.Rational, (1, 2), (3, 5))]
OPERATIONS = (
    lambda a, b, c: a + b, lambda a, b, c: a - b, lambda a, b, c: a * b, lambda a, b, c: a / (b * b + 1), lambda a, b, c: -a,
    lambda a, b, c: a**3, lambda a, b, c: kn.sin(a), lambda a, b, c: kn.sqrt(a * a + 1), lambda a, b, c: kn.max(a, b),
    lambda a, b, c: kn.where(kn.less(a, b), b, c), lambda a, b, c: (a * a + 1) ** kn.Rational(1, 3),
    lambda a, b, c: kn.atan2(a, b * b + 1), lambda a, b, c: a * (b * c), lambda a, b, c: a - (b - c), lambda a, b, c: a / (1 / b),
)  # fmt: skip


@examples(1.0)
@example([(OPERATIONS[2], 0, 0, 0), (OPERATIONS[3], -1, 9, 0)])  # (x x)/(1 + 1/16)
@given(st.lists(st.tuples(st.sampled_from(OPERATIONS), *3 * [st.integers(0, 10**6)]), min_size=1, max_size=25))
def test_random_expressions(tmp_path_factory, made):
    """A force of any operators: the text makes the same node."""
    pool = [*LEAVES, kn.sqrt(2), kn.expr.as_expr(3), kn.expr.as_expr(-0.25)]
    for operation, *places in made:
        try:
            pool.append(operation(*(pool[k % len(pool)] for k in places)))
        except kn.KaneError:  # a division by zero
            continue
    N = kn.Frame("N")
    P = kn.Point("O", fixed_in=N).at("P", LEAVES[0] * N.x)
    force = pool[-1] * N.x + pool[-2] * N.y
    system = kn.System(N, bodies=[kn.Particle("p", P, 1)], speeds="rates", loads=[kn.Force(P, force)])
    text = kn.exchange.to_python(system)
    written = imported(tmp_path_factory.mktemp("force") / "m.py", text).system()
    (_, before), (_, after) = system.loads[0].forces[0], written.loads[0].forces[0]
    wanted, found = (v.components(f) for v, f in ((before, N), (after, written.inertial)))
    assert [digest(e) for e in wanted] == [digest(e) for e in found], text


AWKWARD = {
    "quotes": 'the "long" arm, outside, ',
    "backslashes": "C:\\users\\u, outside, ",
    "new lines": "one\nline, another (here, ",
    "quotes in threes": 'the """ arm',
}


@pytest.mark.parametrize("case", AWKWARD)
def test_texts_of_any_letters_are_kept(case, tmp_path):
    """Descriptions and messages that are broken into lines, and titles: the file runs, and has them as they were."""
    text = AWKWARD[case]
    long = text * 12
    N = kn.Frame("N")
    q, u = kn.coordinate("q", "m", long), kn.speed("u")
    P = kn.Point("O", fixed_in=N).at("P", q * N.x)
    events = [kn.Event("there", q, message=long, direction=np.int64(1))]
    system = kn.System(
        N, bodies=[kn.Particle("b", P, kn.parameter("m", 1.0, "kg", long))], speeds={u: q.dt}, events=events
    )
    written = imported(tmp_path / "model.py", kn.exchange.to_python(system, title=text))
    assert text == written.TITLE
    assert written.__doc__ == f"{text}."
    made = written.system()
    assert_alike(system, made)
    assert {s.description for s in (*made.coordinates, *made.parameters)} == {long}
    assert made.events[0].message == long


def test_start_values_are_numbers_and_guesses(tmp_path):
    N = kn.Frame("N")
    q, u = kn.coordinate("q"), kn.speed("u")
    P = kn.Point("O", fixed_in=N).at("P", q * N.x)
    f = kn.input("f")
    system = kn.System(N, bodies=[kn.Particle("b", P, 1.0)], speeds={u: q.dt}, loads=[kn.Force(P, f * N.x)])
    start = {"q": {q: kn.guess(0.25)}, "u": {"u": np.float64(0.1)}, "inputs": {"f": np.array(2)}}
    written = imported(tmp_path / "model.py", kn.exchange.to_python(system, start=start))
    assert {"q": {"q": kn.guess(0.25)}, "u": {"u": 0.1}, "inputs": {"f": 2.0}} == written.START
    with pytest.raises(kn.KaneError, match="a number as the start value for f, got the function <lambda>"):
        kn.exchange.to_python(system, start={"inputs": {"f": lambda t: 0.0}})
    with pytest.raises(kn.KaneError, match="a finite start value for q, got inf"):
        kn.exchange.to_python(system, start={"q": {"q": float("inf")}})


def test_actions_that_give_inputs_functions_are_refused():
    N = kn.Frame("N")
    q, u, f = kn.coordinate("q"), kn.speed("u"), kn.input("f")
    P = kn.Point("O", fixed_in=N).at("P", q * N.x)
    events = [kn.Event("there", q, then={f: lambda t: 0.0})]
    system = kn.System(
        N, bodies=[kn.Particle("b", P, 1.0)], speeds={u: q.dt}, loads=[kn.Force(P, f * N.x)], events=events
    )
    with pytest.raises(kn.ModelError, match=r"the event 'there'.*which only its source file can declare"):
        kn.exchange.to_python(system)
