# SPDX-License-Identifier: BSD-3-Clause
"""What is no kernel is refused, with what is wrong."""

from dataclasses import replace

import pytest

from kane.errors import ProgramError
from kane.program import FLOAT, INT, ArrayOf, Compute, If, Immediate, Put, SinCos, Value, Write, Writer, verified_kernel


def writer():
    w = Writer("k")
    return w, w.array("x"), w.variable("back", INT)


def kernel():
    w, x, back = writer()
    with w.when(x[0] < x[1]):
        x[0] = x[0] + 1.0
    return w.finished(back)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda k: replace(k, result=replace(k.result, type=FLOAT)), "one of its cells, an integer, as result"),
        (lambda k: replace(k, arguments=(*k.arguments, *k.arguments)), "names that differ .* got x more than once"),
        (lambda k: replace(k, arguments=(ArrayOf("z"),)), "arrays of its own .* got x"),
        (lambda k: replace(k, cells=(replace(k.result, name="c"),)), "one of its cells"),
        (lambda k: replace(k, body=(*k.body, *k.body)), "values that are defined once"),
        (lambda k: replace(k, body=(*k.body, Write(Value(5, FLOAT), *k.body[0][1:]))), "defined where they are used"),
        (lambda k: replace(k, body=(*k.body, Write(Value(99, FLOAT), *k.body[0][1:]))), "defined where they are used"),
        (lambda k: replace(k, body=(Put(k.result, Immediate(FLOAT, 1.0)),)), "Expected int .* got float in Put"),
        (lambda k: replace(k, body=(If(Immediate(INT, 1), (), ()),)), "Expected bool .* got int in If"),
        (
            lambda k: replace(k, body=(Compute(Value(9, FLOAT), "cosh", (Immediate(FLOAT, 1.0),)),)),
            "one of the operations",
        ),
        (lambda k: replace(k, body=(SinCos((1,), ({},)),)), "Expected statements of kernels .* got SinCos"),
        (lambda k: replace(k, body=(Write(1, "x", Immediate(INT, 0)),)), "defined where they are used .* got value 1"),
        (
            lambda k: replace(k, body=(Compute(Value(9, INT), "neg", (Immediate(FLOAT, 1.0),)),)),
            "Expected float .* got int",
        ),
    ],
)
def test_what_is_wrong_is_named(change, told):
    """A value of an inner block is not known behind it, nor one of a number that nothing defines."""
    with pytest.raises(ProgramError, match=told):
        verified_kernel(change(kernel()))


def test_operands_must_fit():
    _, x, _ = writer()
    with pytest.raises(ProgramError, match=r"Expected 2 operands that 'add' takes, got float, float×4: convert them"):
        x[0] + x.lanes(0, 4)


def test_a_routine_takes_what_it_says():
    w, x, back = writer()
    call = w.callee("f", "float", "array")
    call(1.0, x.at(0))
    verified_kernel(w.finished(back))
    call(x.at(0), x.at(0))
    with pytest.raises(ProgramError, match=r"a routine of its own, f\(float, array\) .* got array, array"):
        w.finished(back)
