# SPDX-License-Identifier: BSD-3-Clause
"""Systems written as Python files: what the file makes when it runs has the same equations, operation by operation."""

from __future__ import annotations

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

import kane as kn
from kane.expr import digest
from kane.gallery import GALLERY, load
from tests.examples import examples
from tests.interop.written import assert_alike, imported
from tests.systems import jointed

QUICK = ("four_bar", "whipple_bicycle", "bricard", "rattleback", "compass_gait", "rolling_disk", "spinning_top")


@pytest.mark.parametrize("name", [pytest.param(n, marks=() if n in QUICK else pytest.mark.slow) for n in GALLERY])
def test_the_gallery(name, tmp_path):
    module = load(name)
    system = module.system()
    told = system.contacts or any(not isinstance(b, kn.RigidBody | kn.Particle) for b in system.bodies)
    if told:
        with pytest.raises(kn.ModelError, match="which only the file that declares it knows"):
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


@pytest.mark.parametrize("kind", CLOSURES)
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
            kn.ModelError, match="constraint 'G tilt1'.*which only the file" if kind != "slider" else "G"
        ):
            kn.exchange.to_python(system(lambda k: 0.6 * a.frame.x + 0.8 * a.frame.y))


@examples(0.2)
@example(5, 5)  # a load along a frame within a joint
@example(89, 5)
@given(st.integers(0, 2**32), st.integers(1, 5))
def test_random_trees(tmp_path_factory, seed, bodies):
    system = jointed.system(seed, bodies)
    text = kn.exchange.to_python(system)
    assert_alike(system, imported(tmp_path_factory.mktemp("tree") / "model.py", text).system(), signs=False)


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
