# SPDX-License-Identifier: BSD-3-Clause
"""The shortest of a few ways to write what is read."""

import kane as kn
from kane.expr import ZERO, shortened, with_short_quotients

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


def test_short_quotients_are_written_shorter_where_all_get_shorter():
    m, inertia = kn.parameters("m I")
    u = A * inertia * U / (B * B * (m + inertia / (B * B)))
    v = A * inertia * V / (B * B * (m + inertia / (B * B)))
    found = with_short_quotients([u, -v, v / B, U], [A * U])
    assert [str(x) for x in found[:2]] == ["a*I*u/(m*b^2 + I)", "-a*I*v/(m*b^2 + I)"]
    assert found[2] is -found[1] / B
    assert found[3] is U


def test_what_all_share_is_kept():
    shared = U / (A * (B + U / A))
    others = [shared * shared, kn.sin(shared), A * (B + U / A)]
    assert with_short_quotients([shared], others) == (shared,)
    together = kn.count_operations(with_short_quotients([shared, *others], [])).total
    assert together <= kn.count_operations([shared, *others]).total
