# SPDX-License-Identifier: BSD-3-Clause
"""Programs over other ports than those of equations of motion: any number, any name, scalars and vectors of both tiers."""

import pickle
import re

import numpy as np
import pytest

import kane as kn
from kane import Settings
from kane.errors import ArgumentError, ProgramError, ValueMissingError
from kane.expr import ADD, COS, SIN
from kane.program import Code, CompiledRoutine, Port, Routine, Task, assembled, build_program, receipt, values
from tests.program.emitted import from_c, from_numpy
from tests.program.programs import by_port

A, B = kn.coordinates("a1 a2"), kn.speeds("b1 b2 b3")
K, L = kn.parameters("k1 k2", 1.5), kn.parameters("l1 l2 l3", -0.5)
S, G = kn.input("s"), kn.parameter("g", 9.81)

TWO_BY_TWO = (Port("left", A), Port("right", B), Port("stiffness", K, "parameter"), Port("length", L, "parameter"))
SCALARS = (
    Port("g", (G,), "parameter", scalar=True),
    Port("a", A),
    Port("s", (S,), scalar=True),
    Port("k", (*K, *L), "parameter"),
    Port("b", B),
)
RESERVED = (
    Port("h", A),
    Port("out", B),
    Port("int", K, "parameter"),
    Port("w1", L, "parameter"),
    Port("run", (S,)),
    Port("x", (G,)),
)
STATES_ALONE = (Port("one", (*A, *B)), Port("two", (*K, *L)), Port("lambda", (S,), scalar=True), Port("g", (G,)))
PARAMETERS_ALONE = (Port("all", (*A, *B, *K, *L, S, G), "parameter"),)
PORTS = {
    "two state vectors, two hoisted vectors, no time": TWO_BY_TWO,
    "scalars of both tiers between vectors": SCALARS,
    "names that emitted code uses itself": RESERVED,
    "nothing hoisted": STATES_ALONE,
    "all hoisted": PARAMETERS_ALONE,
}


def program_of(ports):
    known = {s for port in ports for s in port.symbols}
    (a1, a2), (b1, b2, b3), (k1, k2), (l1, l2, l3) = A, B, K, L
    roots = [
        kn.sin(a1) * kn.cos(l1 * k2) + b1 * kn.sin(b2),
        kn.sqrt(k1 * k1 + 1) * (a2 + kn.sin(a2 + b3)),
        kn.exp(l2 / 3) + kn.cos(a1) / (l3 - 7),
        b2 / (k1 + k2) + b3 / (k1 + k2),
    ]
    roots += [S * a1 + b2 * G] if S in known else [k2 * l3]
    wanted = [
        Task("first", roots, (len(roots),), [f"y{k}" for k in range(len(roots))]),
        Task("second", [roots[1], l1 * l2, a1 + 0, kn.pi * b2], (2, 2), ["m", "n", "o", "p"]),
    ]
    return build_program("open", ports, wanted)


def expected(program, name, rows):
    routine = program.routine(name)
    found = [values(program, routine.body, row) for row in rows]
    return np.array([[float(v[i]) for i in routine.results] for v in found]).reshape(len(rows), *routine.shape)


def arguments(program, rows):
    found = by_port(program, rows)
    return [found[port.name][..., 0] if port.scalar else found[port.name] for port in program.ports]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["first", "second"])
@pytest.mark.parametrize("which", PORTS)
def test_every_emitter_gives_the_reference(which, name, tmp_path):
    program = program_of(PORTS[which])
    rows = np.random.default_rng(5).uniform(-2, 2, (6, len(program.inputs)))
    right = expected(program, name, rows)
    native = CompiledRoutine(program, name, Settings(contract=False, cache=False))
    given = arguments(program, rows)
    np.testing.assert_allclose(native(*given), right, rtol=1e-13, atol=1e-14)
    one_by_one = [native(*(g[k].copy() if np.ndim(g[k]) else float(g[k]) for g in given)) for k in range(len(rows))]
    assert np.array_equal(native(*given), one_by_one)
    module = from_numpy(program, tmp_path)
    np.testing.assert_array_equal(getattr(module, name)(*given), right)
    emitted = from_c(program, tmp_path, contract=False)
    np.testing.assert_allclose(emitted(name, rows), right.reshape(len(rows), -1), rtol=1e-13, atol=1e-14)


@pytest.mark.parametrize("which", PORTS)
def test_what_depends_on_hoisted_ports_alone_is_computed_once(which):
    program = program_of(PORTS[which])
    varies = [not port.hoisted for port in program.ports for _ in port.symbols] + [False] * len(program.constants)
    for reads in program.args:
        varies.append(any(varies[i] for i in reads))
    assert not any(varies[i] for i in program.hoisted)
    assert all(varies[i] for routine in program.routines for i in routine.body)
    cost = receipt(program)["first"]
    assert (cost.parameter == 0) == (which == "nothing hoisted")
    assert (cost.state == 0) == (which == "all hoisted")


def test_a_change_of_any_hoisted_port_hoists_again():
    program = program_of(SCALARS)
    native = CompiledRoutine(program, "first", Settings(cache=False))
    row = np.linspace(0.3, 1.4, len(program.inputs))
    for changed in range(len(row)):
        row[changed] += 0.25
        given = arguments(program, row)
        found = native(*(g if np.ndim(g) else float(g) for g in given))
        np.testing.assert_allclose(found, expected(program, "first", [row])[0], rtol=1e-13)


class TestCalls:
    program = program_of(SCALARS)
    routine = CompiledRoutine(program, "first", Settings(cache=False))
    a, b = np.array([0.1, 0.2]), np.array([0.3, 0.4, 0.5])

    def test_by_name_with_defaults_of_what_is_hoisted(self):
        full = self.routine(9.81, self.a, 2.0, np.array([1.5, 1.5, -0.5, -0.5, -0.5]), self.b)
        assert np.array_equal(self.routine(a=self.a, b=self.b, s=2.0), full)
        assert np.array_equal(self.routine(None, self.a, s=2, b=list(self.b)), full)
        assert np.array_equal(self.routine(None, {"a1": 0.1, "a2": 0.2}, 2.0, {"k1": 1.5}, self.b), full)

    def test_leading_axes_broadcast(self):
        found = self.routine(np.array([[9.81], [1.6]]), self.a, np.arange(3.0), b=self.b)
        assert found.shape == (2, 3, 5)
        assert np.array_equal(found[1, 2], self.routine(1.6, self.a, 2.0, None, self.b))

    def test_signature(self):
        assert repr(self.routine) == "<first(g, a[2], s, k[5], b[3]) -> [5]: y0, y1, y2, y3, y4>"

    def test_what_is_wrong_is_named(self):
        with pytest.raises(ArgumentError, match=re.escape("Expected b of shape (…, 3), got shape (2,)")):
            self.routine(None, self.a, 2.0, None, self.a)
        with pytest.raises(ArgumentError, match="the arguments g, a, s, k, b, each once, got c"):
            self.routine(None, self.a, c=2.0)
        with pytest.raises(ArgumentError, match="the arguments g, a, s, k, b, each once, got g"):
            self.routine(9.81, g=2.0)
        with pytest.raises(ArgumentError, match="Expected real numbers as b, got NoneType"):
            self.routine(None, self.a, 2.0)
        with pytest.raises(ArgumentError, match="Expected finite b, got b2 = nan"):
            self.routine(None, self.a, 2.0, None, np.array([0, np.nan, 0]))
        with pytest.raises(ValueMissingError, match="one of the a, got none for a2: pass them as a"):
            self.routine(None, {"a1": 1.0}, 2.0, None, self.b)

    def test_pickled(self):
        again = pickle.loads(pickle.dumps(self.routine))
        assert np.array_equal(again(None, self.a, 2.0, None, self.b), self.routine(None, self.a, 2.0, None, self.b))

    def test_explain_takes_the_ports_in_order(self):
        assert self.routine.explain(None, self.a, 2.0, None, self.b) == ""
        with pytest.raises(ArgumentError, match="Expected one state to explain"):
            self.routine.explain(None, np.stack([self.a, self.a]), 2.0, None, self.b)


@pytest.mark.parametrize(
    ("ports", "message"),
    [
        ((Port("x", A), Port("x", B)), "two ports of one name"),
        ((Port("2x", A),), "'2x' is no identifier"),
        ((Port("größe", A),), "'größe' is no identifier"),
        ((Port("t", A, scalar=True),), "2 symbols in the port t, which is a number"),
    ],
)
def test_ports_that_cannot_be(ports, message):
    with pytest.raises(ProgramError, match=message):
        build_program("wrong", ports, [])


GOALS = (Routine("all", (5,), tuple("abcde"), (1, 2, 3, 4, 5)),)


def test_sines_that_stand_twice(tmp_path):
    """A Program may compute one sine twice, though expressions never do."""
    (a1, _), subject = A, "a sine"
    draft = Code(
        "model", subject, (Port("a", (a1,)),), (), (SIN, COS, SIN, SIN, ADD), ((0,), (0,), (0,), (1,), (1, 3)), GOALS
    )
    program = assembled(draft)
    rows = np.array([[0.3], [0.9], [-2.0]])
    wanted = np.array([[np.sin(x), np.cos(x), np.sin(x), np.sin(np.sin(x)), 2 * np.sin(x)] for (x,) in rows])
    for results in (
        from_c(program, tmp_path, False)("all", rows),
        CompiledRoutine(program, "all", Settings(contract=False, cache=False))(rows),
    ):
        np.testing.assert_allclose(results, wanted, rtol=1e-15)
