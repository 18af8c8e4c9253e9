# SPDX-License-Identifier: BSD-3-Clause
"""Names as text, hulls, and the placement of labels."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kane.present import Label, hull, placed, point_name, product, series, spans, unit_vector, width_of


def plain(runs: Any) -> str:
    """The text alone."""
    return "".join(r.text for r in runs)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("q1", "q|1"), ("mu_k", "μ|k"), ("u1'", "u\u0307|1"), ("x''", "x\u0308"), ("theta_R", "θ|R"), ("v1_beam", "v|1,beam"),
        ("Ixx", "I|xx"), ("q", "q"), ("T_phi_b", "T|φ,b"), ("lambda", "λ"),
    ],
)  # fmt: skip
def test_names_are_typeset(name: str, text: str) -> None:
    assert "|".join(r.text for r in spans(name)) == text
    assert [r.shift for r in spans(name)] == ["", "sub"][: text.count("|") + 1]


def test_places_vectors_and_products() -> None:
    assert plain(point_name("C*")) == "C*"
    assert [r.shift for r in point_name("B1*")] == ["", "sub", "sup"]
    assert plain(point_name("C^")) == "C\u0302"
    assert plain(point_name("crank pin")) == "crank pin"
    assert [r.text for r in unit_vector("B1", "x")] == ["b\u0302", "1x"]
    assert plain(product("c*x'")) == "c x\u0307"
    assert plain(series(("e0", "e1"))) == "e0, e1"


@given(st.lists(st.tuples(st.integers(-9, 9), st.integers(-9, 9)), min_size=3, max_size=30, unique=True))
def test_the_hull_holds_all_points(points: list[tuple[int, int]]) -> None:
    cloud = np.array(points, dtype=float)
    if np.linalg.matrix_rank(cloud - cloud[0]) < 2:
        return
    border = hull(cloud)
    ahead = np.roll(border, -1, axis=0) - border
    for p in cloud:
        off = p - border
        assert (ahead[:, 0] * off[:, 1] - ahead[:, 1] * off[:, 0] >= -1e-9).all()
    assert {tuple(b) for b in border} <= {tuple(p) for p in cloud}


@given(st.integers(2, 14), st.randoms(use_true_random=False))
def test_labels_that_are_needed_are_all_there_and_apart(count: int, random: Any) -> None:
    """Crowded anchors, lines everywhere: all needed ones are placed, none upon another, none beyond the edges."""
    labels = [
        Label(
            spans(f"q{k}"), (random.uniform(150, 250), random.uniform(120, 180)), (random.uniform(-1, 1), random.uniform(-1, 1)),
            16.0, "coordinate", (f"q{k}",), k % 2 == 0,
        )
        for k in range(count)
    ]  # fmt: skip
    lines = np.array([[random.uniform(0, 400), random.uniform(0, 300)] for _ in range(200)])
    found = placed(labels, lines, np.ones(len(lines)), 400.0, 300.0)
    assert {b.symbols for b in labels if b.needed} <= {b.symbols for b in found}
    for a, b in combinations(found, 2):
        (p, q, r, s), (t, u, v, w) = a.box, b.box
        assert p >= v or t >= r or q >= w or u >= s
    for b in found:
        assert b.box[0] >= 0
        assert b.box[1] >= 0
        assert b.box[2] <= 400
        assert b.box[3] <= 300


def test_a_label_goes_where_it_is_wanted() -> None:
    free = np.zeros((0, 2))
    (right,) = placed(
        [Label(spans("q1"), (100.0, 100.0), (1.0, 0.0), 16.0, "coordinate", ("q1",), True)],
        free,
        np.zeros(0),
        200.0,
        200.0,
    )
    assert right.x > 100
    assert abs(right.y - 100) < 1
    wall = np.array([[x, y] for x in np.arange(102, 140, 2.0) for y in np.arange(90, 110, 2.0)])
    (moved,) = placed([right], wall, np.ones(len(wall)), 200.0, 200.0)
    left, top, r, bottom = moved.box
    assert not ((wall[:, 0] > left) & (wall[:, 0] < r) & (wall[:, 1] > top) & (wall[:, 1] < bottom)).any()


def test_width_grows_with_letters() -> None:
    assert width_of(spans("q1"), 16) < width_of(spans("q12"), 16) < width_of(spans("q12_beam"), 16)
