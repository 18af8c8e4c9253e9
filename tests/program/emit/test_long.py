# SPDX-License-Identifier: BSD-3-Clause
"""Long functions of machine code: pointers near what is read and written, sines in packs."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from benchmarks.random_trees import random_tree
from kane.expr import COS, SIN
from kane.gallery import pendulums
from kane.program import REACH, Read, SinCos, Style, Write, function_of, gathered, pieces, pointed, statements

SYSTEMS = {
    "angles of angles": lambda: pendulums.system(60, relative=True),
    "spatial chain": lambda: random_tree(range(-1, 11), 3),
    "spatial chain of parameters": lambda: random_tree(range(-1, 7), 4, general=True),
    "floating": lambda: random_tree((-1, 0, 0, 2, 3, -1, 5, 6, 7, 8), 5, floating=True),
}


@pytest.fixture(scope="module", params=SYSTEMS)
def eom(request):
    return kn.derive(SYSTEMS[request.param]())


@pytest.mark.slow
def test_machine_code_agrees_with_the_reference(eom, rng):
    """In pieces, with contraction and without; the reference knows no order, no pieces and no vectors."""
    n = len(eom.coordinates)
    x = rng.uniform(-1, 1, n + len(eom.speeds))
    x[: len(eom.coordinates) - len(eom.speeds)] += 2.0  # of a quaternion, if there is one
    expected = np.array(eom.evaluate(list(eom.accelerations), q=x[:n], u=x[n:]), dtype=float)
    for contract in (True, False):
        rhs = eom.compile(contract=contract).rhs
        assert len(rhs.program.routine("rhs").body) > 600
        np.testing.assert_allclose(rhs(0.0, x)[n:], expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())


@pytest.mark.slow
@pytest.mark.parametrize("lanes", [2, 4, 8])
def test_gathered_is_an_order_of_the_same(eom, lanes):
    """Every instruction stands behind what it reads, and no more packs are needed than angles fill."""
    program = eom.compile().rhs.program
    block = program.routine("rhs").body
    found = gathered(program, block, lanes)
    assert sorted(found) == sorted(block)
    place = {i: k for k, i in enumerate(found)}
    assert all(place[a] < place[i] for i in block for a in program.arguments(i) if a in place)


@pytest.mark.slow
def test_sines_stand_side_by_side():
    """Eight angles q + constant of a chain are one statement, wherever the depth-first order has them."""
    program = kn.derive(random_tree(range(-1, 15), 3)).compile().rhs.program
    style = Style(lazy=True, lanes=8, whole=0)
    function = function_of(program, program.routine("rhs"))
    found = [
        len(s.angles)
        for piece in pieces(program, function, style).chunks
        for s in statements(program, function, piece, style)
        if isinstance(s, SinCos)
    ]
    angles = {program.arguments(i)[0] for i in function.block if program.op(i) in (SIN, COS)}
    assert sum(found) == len(angles)
    assert max(found) == 8
    assert len(found) < len(angles) / 3


places = st.lists(st.tuples(st.sampled_from(["x", "<w>"]), st.integers(0, 400), st.booleans()), max_size=120)


@given(places)
def test_every_place_has_one_pointer(drawn):
    """Pointer and offset give the place; most are within reach, all if they fit under as many pointers as there are."""
    body = [(Write if late else Read)(k, base, place) for k, (base, place, late) in enumerate(drawn)]
    near = pointed(body)
    assert set(near) == {s.base for s in body}
    assert sum(len(own.places) for own in near.values()) <= 8
    for s in body:
        k, offset = near[s.base].nearest(s.offset)
        assert near[s.base].places[k] + offset == s.offset
        assert abs(offset) == min(abs(s.offset - p) for p in near[s.base].places)
    if all(s.offset < 2 * REACH for s in body):
        assert all(-REACH <= near[s.base].nearest(s.offset)[1] < REACH for s in body)
