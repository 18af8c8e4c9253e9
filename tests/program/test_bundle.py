# SPDX-License-Identifier: BSD-3-Clause
"""Bundles: groups of expressions with shapes, and the records that their routines return."""

from dataclasses import dataclass

import numpy as np
import pytest

import kane as kn
from kane import Settings
from kane.errors import ProgramError
from kane.program import Bundle, BundleRoutine, CompiledRoutine, Port, build_program, shaped

A, K = kn.coordinates("a b c"), kn.parameters("k l", 2.0)
PORTS = (Port("a", A), Port("k", K, "parameter"))
a, b, c = A
k, l = K


@dataclass(frozen=True)
class Record:
    number: np.ndarray
    vector: np.ndarray
    matrix: np.ndarray
    nothing: np.ndarray


GROUPS = {
    "number": a * k,
    "vector": (a, b + l),
    "matrix": kn.Matrix([[a, 1, c], [k, b * c, 0]]),
    "nothing": kn.Matrix([], (0, 3)),
}
BUNDLE = Bundle("sums", PORTS, Record, GROUPS)


def check(found, a, b, c, k, l):
    assert np.array_equal(found.number, a * k)
    assert np.array_equal(found.vector, np.stack([a, b + l], -1))
    zero, one = np.zeros_like(a * k), np.ones_like(a * k)
    rows = [np.stack(np.broadcast_arrays(*row), -1) for row in ((a, one, c), (k + zero, b * c, zero))]
    assert np.array_equal(found.matrix, np.stack(rows, -2))
    assert found.nothing.shape == (*np.shape(a), 0, 3)


@pytest.fixture(scope="module")
def routine():
    program = build_program("sums", PORTS, [BUNDLE.task])
    return BundleRoutine(BUNDLE, CompiledRoutine(program, "sums", Settings(cache=False)))


def test_one_state(routine):
    found = routine(np.array([1.5, 2.0, 3.0]), np.array([4.0, 5.0]))
    assert isinstance(found, Record)
    assert found.number.shape == ()
    check(found, *np.array([1.5, 2.0, 3.0, 4.0, 5.0]))


def test_many_states(routine):
    x = np.random.default_rng(4).normal(size=(4, 2, 3))
    check(routine(x, None), *np.moveaxis(x, -1, 0), 2.0, 2.0)


def test_the_reference_evaluator_gives_the_same():
    check(BUNDLE.reference((*A, *K))([1.5, 2.0, 3.0, 4.0, 5.0]), *np.array([1.5, 2.0, 3.0, 4.0, 5.0]))


def test_labels_and_results_as_one_vector(routine):
    assert routine.flat.labels[:4] == ("number", "vector[0]", "vector[1]", "matrix[0]")
    assert routine.flat.shape == (9,)
    own = Bundle("two", PORTS, dict, {"x": (a, b)}, labels=("first", "second"))
    assert own.task.labels == ["first", "second"]


def test_groups_are_the_fields_of_the_record_in_their_order():
    with pytest.raises(ProgramError, match="Expected the groups number, vector, matrix, nothing, got vector, number"):
        Bundle("sums", PORTS, Record, {"vector": (a,), "number": a})


def test_shapes():
    assert shaped(a).shape == shaped(2).shape == ()
    assert shaped([]).shape == (0,)
    assert shaped(kn.Matrix.identity(2)).shape == (2, 2)
    assert shaped(shaped((a, 1))).roots == (a, *shaped(1).roots)
    with pytest.raises(TypeError):
        shaped("a")
