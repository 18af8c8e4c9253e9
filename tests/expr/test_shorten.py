# SPDX-License-Identifier: BSD-3-Clause
"""The shortest of a few ways to write what is read."""

import kane as kn
from kane.expr.node import ZERO
from kane.expr.shorten import shortened

A, B = kn.parameters("a b")
U, V = kn.speeds("u v")


def test_each_takes_its_shortest_way():
    square = (U + V) ** 2
    written, other = shortened([square, A * U + (B * U - A * U)])
    assert written is square
    assert str(other) == "b*u"


def test_ways_are_compared():
    (found,) = shortened([A * V + U], [A * U / B + U])
    assert found is A * V + U
    assert shortened([A * V - A * U], [A * U - A * U]) == (ZERO,)


def test_what_is_shared_is_not_torn_apart():
    shared = (U + V) * (A + B)
    together = [shared * A, shared * B]
    assert kn.count_operations(shortened(together)).total <= kn.count_operations(together).total


def test_long_expressions_are_left():
    e = ZERO
    for k in range(200):
        e = e + kn.parameter(f"p{k}") * U - kn.parameter(f"p{k}") * V
    assert shortened([e]) == (e,)
