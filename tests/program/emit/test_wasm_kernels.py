# SPDX-License-Identifier: BSD-3-Clause
"""Loops along rows are made two turns at once, bit by bit as one by one; loops that read what they write are not."""

import numpy as np
import pytest

from kane.program import INT, For, Writer, in_pairs, specialized
from tests.peer import require
from tests.program.hosted import in_wasm
from tests.program.programs import bits

require("wasmtime")


def along(offset):
    """Row `offset` of w becomes a combination of the rows 0 and 1 by a number that stands in s, and then is written on to r."""
    w = Writer("along")
    rows, s, r = w.array("w"), w.array("s"), w.array("r")
    n, at, code = w.number("n"), w.number("at"), w.variable("code", INT)
    h = s[0] * 3.0
    with w.count(n) as i:
        rows[offset * n + i] = rows[i] + h * (rows[n + i] * 0.1 - w.compute("sqrt", w.compute("abs", rows[i])) / s[1])
        r[at + i] = -rows[n + i]
    return w.finished(code)


@pytest.mark.parametrize(
    ("n", "offset", "paired"), [(6, 2, True), (7, 2, True), (9, 3, True), (5, 2, False), (8, 1, False)]
)
def test_turns_two_by_two(n, offset, paired, rng):
    """Of even and of odd numbers; with few turns, and where a row is read and written, one by one."""
    kernel = specialized(along(offset), {"n": n})
    assert (in_pairs(next(s for s in kernel.body if isinstance(s, For))) is not None) is paired
    given = {"w": rng.normal(size=4 * n), "s": np.array([0.3, 0.7]), "r": np.zeros(n + 3), "at": 2}
    x, before = given["w"].reshape(4, n).copy(), given["w"].copy()
    in_wasm(kernel)(given)
    now = x[0] + (0.3 * 3.0) * (x[1] * 0.1 - np.sqrt(np.abs(x[0])) / 0.7)
    assert bits(given["w"].reshape(4, n)[offset]) == bits(now)
    assert bits(given["r"][2 : 2 + n]) == bits(-(now if offset == 1 else x[1]))
    assert given["r"][n + 2] == given["r"][0] == 0.0
    before[offset * n : (offset + 1) * n] = now
    assert bits(given["w"]) == bits(before)
