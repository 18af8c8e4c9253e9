# SPDX-License-Identifier: BSD-3-Clause
"""Limbs side by side compute what they compute one by one."""

import dataclasses
import re
from unittest.mock import patch

import numpy as np
import pytest
from hypothesis import event, given
from hypothesis import strategies as st

import kane as kn
from benchmarks.random_trees import random_tree
from kane import Handle, Settings
from kane.equations import program
from kane.errors import ProgramError
from kane.expr import OPS, compile_reference, intern_node
from kane.gallery import whipple_bicycle
from kane.program import Task, build_program, emit_llvm, limbs, verified
from tests.examples import examples
from tests.program.programs import ports

OWN, MOST = 3, 6
STATES, PARAMETERS = kn.coordinates(f"x1:{OWN * MOST + 1}"), kn.parameters(f"k1:{2 * MOST + 1}", 1.0)
PORTS = ports(STATES, PARAMETERS)
SYMBOLS = (kn.time, *STATES, *PARAMETERS)
OPERATIONS = ("add", "add", "sub", "mul", "mul", "div", "neg", "sqrt")


def node(name, *args):
    return intern_node(OPS[name], *args)


@st.composite
def legs(draw):
    """Two to six limbs by one recipe of random operations: arguments change places, differences their signs, from limb to limb."""
    count = draw(st.integers(2, MOST))
    steps = draw(
        st.lists(st.tuples(st.sampled_from(OPERATIONS), *[st.integers(0, 10**6)] * 2), min_size=3, max_size=25)
    )
    whims = draw(st.randoms(use_true_random=False))
    made = []
    for k in range(count):
        pool = [
            *STATES[OWN * k : OWN * (k + 1)],
            *PARAMETERS[2 * k : 2 * k + 2],
            kn.time,
            kn.expr.constant(1.5 + k),
        ]
        for name, i, j in steps:
            own = [pool[i % len(pool)], pool[j % len(pool)]][: OPS[name].arity]
            value = node(name, *own)
            if name in ("add", "mul") and whims.random() < 0.5:
                value = node(name, *own[::-1])
            if name == "sub" and whims.random() < 0.5:
                value = node("neg", node("sub", *own[::-1]))
            pool.append(value)
        made.append(pool[-1])
    total = made[0]
    for value in made[1:]:
        total = node("add", total, value)
    # what limbs share, and what each makes of it
    return [total, *(node("mul", value, total) for value in made), *made]


def compiled(roots, contract):
    with patch.object(limbs, "LEAST", 1), patch.object(limbs, "_SHARE", 0.0):
        task = Task("f", roots, (len(roots),), [f"y{i}" for i in range(len(roots))])
        program = build_program("random", PORTS, [task], optimize=True)
    return program, Handle(program, "f", Settings(contract=contract), None, "ignore")


@examples(0.3)
@given(legs(), st.lists(st.floats(-3, 3).map(lambda v: round(v, 3)), min_size=len(SYMBOLS), max_size=len(SYMBOLS)))
def test_any_limbs(roots, values):
    program, handle = compiled(roots, contract=False)
    row = np.array(values)
    found = handle(row[0], row[1 : 1 + len(STATES)].copy(), row[1 + len(STATES) :].copy())
    expected = np.array([float(v) for v in compile_reference(roots, list(SYMBOLS))(values)])
    event(f"{len(program.routine('f').packs) > 0} packs")
    finite = np.isfinite(expected)
    assert np.array_equal(found[finite], expected[finite])


@pytest.mark.parametrize("count", range(2, MOST + 1))
def test_limbs_of_turns(count):
    """Sums, differences and products of sines, in another order and with other signs from limb to limb."""
    made = []
    for k in range(count):
        x, y, z = STATES[OWN * k : OWN * (k + 1)]
        p, q = node("mul", node("sin", node("neg", x) if k % 2 else x), y), node("cos", node("add", z, x))
        d = node("neg", node("sub", q, p)) if k % 3 else node("sub", p, q)
        made.append(node("div", d, node("add", node("mul", y, y), kn.expr.constant(1.5 + k))))
    total = sum(made[1:], start=made[0])
    program, handle = compiled([total, *(node("mul", total, v) for v in made), *made], contract=False)
    packs = program.routine("f").packs
    assert {len(p.values) for p in packs} == {count}
    assert {"sin", "cos", "div"} <= {p.op.name for p in packs}
    values = np.random.default_rng(count).uniform(0.3, 1.2, len(SYMBOLS))
    roots = [total, *(node("mul", total, v) for v in made), *made]
    expected = np.array([float(v) for v in compile_reference(roots, list(SYMBOLS))(list(values))])
    found = handle(values[0], values[1 : 1 + len(STATES)].copy(), values[1 + len(STATES) :].copy())
    assert np.abs(found - expected).max() <= 1e-14 * np.abs(expected).max()


@pytest.mark.slow
@pytest.mark.parametrize(("count", "joints"), [(2, 3), (3, 2), (4, 2), (6, 2)])
@pytest.mark.parametrize("floating", [True, False])
def test_walking_machines(count, joints, floating):
    parents = [-1 if k % joints == 0 else k - 1 for k in range(count * joints)]
    system = random_tree(parents, 3, floating=floating)
    eom = kn.derive(system)
    n = len(eom.coordinates)
    x = np.random.default_rng(5).uniform(0.2, 0.8, n + len(eom.speeds))
    if floating:
        x[:4] /= np.linalg.norm(x[:4])
    fast = eom.compile()
    packs = fast.rhs.program.routine("rhs").packs
    assert not packs or {len(p.values) for p in packs} == {count}
    assert packs or not floating
    values = {str(p): 0.5 + 0.1 * k for k, p in enumerate(eom.parameters)}
    expected = np.array(eom.evaluate(eom.right_hand_side, q=x[:n], u=x[n:], parameters=values), dtype=float)
    found = fast.rhs(0.0, x, values)
    assert np.abs(found - expected).max() <= 1e-12 * np.abs(expected).max()
    rows = fast.rhs(0.0, np.array([x, x]), values)
    assert np.array_equal(rows, [found, found])


def test_systems_without_limbs_have_no_packs():
    assert not kn.derive(whipple_bicycle.system()).compile().rhs.program.routine("rhs").packs


def test_without_optimization_there_are_none():
    eom = kn.derive(random_tree([-1, 0, 1, -1, 3, 4], 3, floating=True))
    assert not eom.compile(optimize=False).rhs.program.routine("rhs").packs


def test_packs_are_verified():
    program = kn.derive(random_tree([-1, 0, 1, -1, 3, 4], 3, floating=True)).compile().rhs.program
    routine = program.routine("rhs")
    first = routine.packs[0]
    for packs in (
        (first._replace(values=first.values[::-1]), *routine.packs[1:]),
        (first, *routine.packs),
        (first._replace(op=OPS["sqrt"]),),
    ):
        broken = dataclasses.replace(
            program,
            routines=tuple(dataclasses.replace(r, packs=packs) if r is routine else r for r in program.routines),
        )
        with pytest.raises(ProgramError, match="pack"):
            verified(broken, "test")


def gathered(parents, **more):
    """Doubles put into vectors one by one, for each vector operation; and the share of instructions that are in lanes."""
    eom = kn.derive(random_tree(parents, 1, **more))
    own = program(eom.solved, ("rhs",))
    text = emit_llvm([own], lanes=4)
    body = text[text.index("define void @rhs(") :]
    body = body[: body.index("\n}")]
    operations = [line for line in body.splitlines() if re.search(r"= f(mul|add|sub|div) .*<4 x double>", line)]
    routine = own.routine("rhs")
    return body.count("insertelement") / len(operations), sum(len(p.values) for p in routine.packs) / len(routine.body)


@pytest.mark.slow
@pytest.mark.parametrize("general", [False, True])
def test_what_limbs_read_is_side_by_side(general):
    """Parameters are put in the order of the lanes once; arguments that are alike keep their parts from limb to limb."""
    inserted, laid = gathered([-1, 0, -1, 2, -1, 4, -1, 6], floating=True, general=general)
    assert inserted < 0.4
    assert laid > 0.79


def test_products_of_what_is_alike_stay_with_their_limb():
    """Sums of products of what is alike, in another order from limb to limb: only what the factors are made of tells them apart."""
    made, count = [], 4
    for k in range(count):
        x, y, z = STATES[OWN * k : OWN * (k + 1)]
        a, b = node("sin", x), node("sin", y)
        p, q = node("mul", node("add", a, z), node("cos", x)), node("mul", node("add", b, z), node("cos", y))
        made += [node("add", p, q) if k % 2 else node("add", q, p), a if k % 3 else node("neg", a), b]
    program, _ = compiled(made, contract=False)
    packs = {v: (n, lane) for n, pack in enumerate(program.routine("f").packs) for lane, v in enumerate(pack.values)}
    for pack in program.routine("f").packs:
        for operand in pack.operands:
            homes = [packs[o.value] for o in operand if o.value in packs]
            assert len({n for n, _ in homes}) <= 1
            assert [lane for _, lane in homes] in ([], [0, 1, 2, 3])
