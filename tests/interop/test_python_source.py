# SPDX-License-Identifier: BSD-3-Clause
"""Systems written as Python files: what the file makes when it runs has the same equations, operation by operation."""

from __future__ import annotations

import importlib.util

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane.expr import digest
from kane.gallery import GALLERY, load
from tests.examples import examples
from tests.systems import jointed

QUICK = ("four_bar", "whipple_bicycle", "bricard", "rattleback", "compass_gait", "rolling_disk", "spinning_top")


def imported(path, text):
    """The module that a file with this text is."""
    path.write_text(text, "utf-8")
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def assert_alike(system, other):
    """Both have the same symbols and names, the same operations, and accelerations equal to rounding."""
    for what in ("coordinates", "speeds", "parameters", "inputs", "reactions", "states", "dependent_speeds"):
        assert [s.declaration()[:4] for s in getattr(system, what)] == [
            s.declaration()[:4] for s in getattr(other, what)
        ]
    for what in ("bodies", "joints", "loads", "constraints", "events", "gravities"):
        assert [x.name for x in getattr(system, what)] == [x.name for x in getattr(other, what)]
    a, b = kn.derive(system), kn.derive(other)
    assert a.compile().operations == b.compile().operations
    if [digest(e) for e in a.accelerations] == [digest(e) for e in b.accelerations]:
        return
    rng = np.random.default_rng(1)
    named = {"q": a.coordinates, "u": a.independent_speeds, "inputs": a.system.inputs}
    values = {kind: {s.name: rng.uniform(0.2, 0.8, 5) for s in symbols} for kind, symbols in named.items()}
    before, after = (np.array(e.evaluate([s.name + "'" for s in e.speeds], **values)) for e in (a, b))
    np.testing.assert_allclose(after, before, rtol=0, atol=1e-11 * np.abs(before).max())


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


@examples(0.4)
@given(st.integers(0, 2**32), st.integers(1, 5))
def test_random_trees(tmp_path_factory, seed, bodies):
    system = jointed.system(seed, bodies)
    text = kn.exchange.to_python(system)
    assert_alike(system, imported(tmp_path_factory.mktemp("tree") / "model.py", text).system())


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
