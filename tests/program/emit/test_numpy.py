# SPDX-License-Identifier: BSD-3-Clause
import itertools
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane import input, parameter
from kane.expr import compile_reference
from kane.program import Routine, Task, build_program, emit_numpy
from tests.expr import expressions
from tests.program.emitted import module
from tests.program.programs import (
    EDGES,
    EXACT,
    HOSTILE_NAMES,
    NASTY,
    SPECIAL,
    assert_each_operation_right,
    bits,
    by_port,
    every_operation,
    exact_results,
    grid,
    points,
    ports,
    programs,
    small,
)


@pytest.fixture(scope="session")
def load(tmp_path_factory):
    """A function from a module's text to the module."""
    folder, numbers = tmp_path_factory.mktemp("emit_numpy"), itertools.count()

    return lambda text: module(text, folder / f"emitted{next(numbers)}.py")


def arguments(program, values):
    given = by_port(program, values)
    return [given["t"][..., 0], given["x"], given["p"], given["r"]]


# ------------------------------------------------------------------------------------------ the same numbers as NumPy


@given(st.data())
def test_each_operation_is_the_one_of_the_reference(load, data):
    program = data.draw(programs())
    module = load(emit_numpy(program))
    values = data.draw(points(program, 6))
    given = arguments(program, values)
    every = module.all(*given)
    assert bits(every[:, : len(program.inputs)]) == bits(values)
    assert bits(every[:, len(program.inputs) : program.first]) == bits([program.constants] * len(values))
    assert bits(module.some(*given)) == bits(every[:, list(program.routine("some").results)])
    assert module.some(*given).shape == (6, *program.routine("some").shape)
    assert module.none(*given).shape == (6, 0)
    assert_each_operation_right(program, every.T)


def test_each_operation_at_all_pairs_of_special_numbers(load):
    program = every_operation()
    every = load(emit_numpy(program)).all(*arguments(program, grid()))
    assert_each_operation_right(program, every.T)


@given(expressions.programs(tuple(n for n in EXACT if n not in ("less", "neg"))))
def test_results_are_those_of_the_reference_evaluator_bit_by_bit(load, example):
    roots = exact_results(example)
    leaves = [*expressions.LEAVES[:3], expressions.M]
    program = build_program(
        "drawn", ports(leaves[:3], (expressions.M,)), [Task("f", roots, (len(roots),), [""] * len(roots))]
    )
    module = load(emit_numpy(program))
    values = np.array([example.values, tuple(-v for v in example.values), (0.0, 1e200, -0.0, 1.0)])
    expected = np.broadcast_arrays(values[:, 0], *compile_reference(roots, leaves)(list(values.T)))[1:]
    assert bits(module.f(0, values[:, :3], values[:, 3:])) == bits(np.transpose(expected))
    one = compile_reference(roots, leaves)([np.float64(v) for v in values[0]])
    assert bits(module.f(0, values[0, :3], values[0, 3:])) == bits(one)


# -------------------------------------------------------------------------------------------------- shapes, arguments


def test_leading_axes_of_all_arguments_are_broadcast(load):
    steps = [("mul", (0, 1)), ("add", (4, 2)), ("sub", (5, 3))]
    x, p, r = [kn.coordinate("q")], [parameter("m", 0.25)], [input("F")]
    goals = [
        Routine("a", (1, 2), ("", ""), (6, 6)),
        Routine("b", (), ("",), (6,)),
        Routine("c", (2,), ("", ""), (1, 2)),
    ]
    module = load(emit_numpy(small(steps, x=x, p=p, r=r, goals=goals)))
    generator = np.random.default_rng(1)
    t, x, p, r = (generator.normal(size=s) for s in ((5,), (3, 1, 1), (1, 5, 1), (2, 1, 1, 1)))
    expected = t * x[..., 0] + p[..., 0] - r[..., 0]
    assert expected.shape == (2, 3, 5)
    np.testing.assert_array_equal(module.a(t, x, p, r), np.stack([expected, expected], -1)[..., None, :])
    np.testing.assert_array_equal(module.b(t, x, p, r), expected)
    assert module.c(t, x, p, r).shape == (2, 3, 5, 2)
    assert module.b(2, [3], r=[4]) == 2 * 3 + 0.25 - 4


def test_parameters_have_defaults_where_all_of_them_do(load):
    full = load(emit_numpy(small([("add", (1, 4))], (5,), p=(parameter("m", 2.0), parameter("k", 3.0)))))
    assert full.f(0, [1, 0]) == 4
    free = load(emit_numpy(small([("add", (1, 4))], (5,))))
    assert free.PARAMETERS == {"m": (2.5, "", ""), "k": (2.5, "", "")}
    part = load(emit_numpy(small([("add", (1, 4))], (5,), p=(parameter("m", 2.0), parameter("k")))))
    assert part.PARAMETERS["k"][0] is None
    with pytest.raises(TypeError, match="'p'"):
        part.f(0, [1, 0])
    assert part.f(0, [1, 0], [0, 7]) == 8


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (([1, 2, 3],), r"Expected 2 values on the last axis of x \(q1, q2\), got \(3,\)"),
        ((1.0,), r"Expected 2 values on the last axis of x \(q1, q2\), got \(\)"),
        (([1, 2], [1]), r"Expected 2 values on the last axis of p \(m, k\), got \(1,\)"),
        (([1, 2], [1, 2], [3]), r"Expected 0 values on the last axis of r"),
    ],
)
def test_a_vector_of_another_length_is_refused(load, given, message):
    module = load(emit_numpy(small((), (1,))))
    with pytest.raises(ValueError, match=message):
        module.f(0, *given)


@pytest.mark.parametrize("what", EDGES)
def test_programs_in_which_something_is_missing(load, what):
    program = EDGES[what]()
    module = load(emit_numpy(program))
    values = np.array([[0.25 + k for k in range(len(program.inputs))]] * 2)
    known = dict(enumerate([*values[0], *program.constants]))
    for i in range(program.first, program.first + len(program.ops)):
        with np.errstate(all="ignore"):
            known[i] = float(program.op(i).numpy(*(np.float64(known[a]) for a in program.arguments(i))))
    routine = program.routine("f")
    expected = np.reshape([known[i] for i in routine.results], routine.shape)
    assert bits(module.f(*arguments(program, values[0]))) == bits(expected)
    assert module.f(*arguments(program, values)).shape == (2, *routine.shape)
    assert bits(module.f(*arguments(program, values))[1]) == bits(expected)


def test_constants_are_exact(load):
    program = small((), range(5, 5 + len(SPECIAL)), constants=SPECIAL)
    assert bits(load(emit_numpy(program)).f(0, [0, 0])) == bits(SPECIAL)


# ------------------------------------------------------------------------------------------------------ names and text


def squeezed(text):
    """Without white space: from Python 3.13 on the compiler takes some out of docstrings."""
    return "".join(text.split())


@given(st.lists(NASTY, min_size=6, max_size=6), NASTY)
def test_no_text_leaves_its_literal_or_comment(load, texts, name):
    name = re.sub(r"\s", "", name) or "q"
    x = (kn.coordinate(name, *texts[:2]), kn.coordinate("q_2", *texts[2:4]))
    program = small([("add", (1, 2))], (3, 1), x=x, p=(), name=texts[0], labels=texts[1:3])
    module = load(emit_numpy(program, version=texts[4]))
    assert list(module.f(0, [1.5, 2.0])) == [3.5, 1.5]
    assert {s.name: (s.unit, s.description) for s in x} == module.STATE
    assert squeezed(module.__doc__).startswith(squeezed(f"{texts[0]}: equations of motion."))
    assert squeezed(texts[1]) in squeezed(module.f.__doc__)
    assert {n for n in vars(module) if not n.startswith("__")} == {
        *("np", "PARAMETERS", "STATE", "INPUTS", "DEFAULTS", "_vector", "hoist", "f")
    }


def test_names_that_python_cannot_have_or_needs_itself(load):
    x = [kn.coordinate(name) for name in HOSTILE_NAMES]
    steps = [("add", (1, 2)), *(("add", (len(x) + i, i + 2)) for i in range(1, len(x) - 1))]
    program = small(steps, (2 * len(x) - 1,), x=x, p=())
    values = 2.0 ** np.arange(len(x))
    assert load(emit_numpy(program)).f(0, values) == values.sum()


def test_any_name_of_a_routine(load):
    names = ("hoist", "np", "None", "f", "f", "STATE", "2", "", "_vector", "match", "float")
    goals = [Routine(name, (1,), ("",), (k % 3,)) for k, name in enumerate(names)]
    module = load(emit_numpy(small(goals=goals)))
    found = re.findall(r"^    (\w+)\(t, x, p, r\)", module.__doc__, re.MULTILINE)
    assert len(set(found)) == len(names)
    for k, name in enumerate(found):
        assert getattr(module, name)(0.0, [1.0, 2.0]) == k % 3


def test_the_text_reads_well():
    q, m = kn.coordinate("θ", "rad", "angle"), kn.parameter("m", 2.0, "kg", "mass")
    steps = [("sin", (1,)), ("mul", (3, 2)), ("less", (4, 0)), ("where", (5, 1, 4)), ("mul", (2, 2)), ("pow", (1, 7))]
    program = small(steps, (6, 8), x=(q,), p=(m,), labels=("N", "c"))
    text = emit_numpy(program, version="1.2")
    assert text == emit_numpy(program, version="1.2")
    assert "kane 1.2" in text
    assert "STATE = {\n    'θ': ('rad', 'angle'),\n}\n" in text
    assert text.endswith('''\

def f(t, x, p=DEFAULTS, r=()):
    """2: N, c."""
    h = hoist(p)
    t = np.asarray(t, dtype=np.float64)
    x = _vector(x, STATE, "x")
    p = _vector(p, PARAMETERS, "p")
    r = _vector(r, INPUTS, "r")
    shape = np.broadcast_shapes(t.shape, x.shape[:-1], p.shape[:-1], r.shape[:-1])
    out = np.empty((*shape, 2))
    with np.errstate(all="ignore"):
        theta = x[..., 0]
        m = p[..., 0]
        h0 = h[..., 0]
        z1 = np.sin(theta)
        z2 = z1 * m
        z3 = np.where(z2 < t, 1.0, 0.0)
        z4 = np.where(z3 != 0.0, theta, z2)
        z5 = np.power(theta, h0)
        out[..., 0] = z4  # N
        out[..., 1] = z5  # c
    return out.reshape(shape + (2,))
''')
