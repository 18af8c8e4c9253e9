# SPDX-License-Identifier: BSD-3-Clause
"""What other methods would have to solve: counts by hand, operations of the formulations, accelerations that agree."""

from __future__ import annotations

import re

import pytest

import kane as kn
from kane.gallery import double_pendulum, four_bar, free_body, pure_rolling_disk, rolling_disk
from kane.present import why_kane
from tests.present.page import Page


@pytest.mark.parametrize(
    ("module", "kane", "lagrange", "newton"),
    [
        (four_bar, (1, 0), (3, 2), (18, 17)),  # three rods: one freedom of 18
        (pure_rolling_disk, (3, 0), (5, 2), (6, 3)),  # contact: a normal force and two of friction
        (double_pendulum, (2, 0), (2, 0), (12, 10)),
    ],
)
def test_what_is_solved_for(module, kane, lagrange, newton) -> None:
    eom = kn.derive(module.system())
    chapter = why_kane(eom)
    accelerations, forces, equations = ([int(row[k]) for row in chapter.table.rows] for k in (1, 2, 3))
    assert list(zip(accelerations, forces, strict=True)) == [kane, lagrange, newton]
    assert equations == [sum(kane), sum(lagrange), sum(newton)]
    by_lagrange = eom.by("lagrange first kind")
    assert (len(by_lagrange.unknowns), str(by_lagrange.operations.total)) == (sum(lagrange), chapter.table.rows[1][4])
    assert chapter.table.rows[0][4] == str(eom.by("kane").operations.total)
    off, left = (float(re.findall(r"[0-9.]+e-[0-9]+", sentence)[-1]) for sentence in chapter.found)
    assert off < 1e-9
    assert left < 1e-9
    assert all(float(x) > 0.5 for x in re.findall(r"up to ([0-9.]+) N", chapter.found[1]))


def test_what_constrains_nothing_and_what_lagrange_does_not_take() -> None:
    free = why_kane(kn.derive(free_body.system()))
    assert free.table.rows[2][2] == "0"
    assert len(free.found) == 1
    (sentence,) = why_kane(kn.derive(rolling_disk.system())).found
    assert sentence.startswith(
        "Lagrange's equations do not apply to this system: Expected loads that contain no reaction"
    )


def test_the_chapter_may_be_left_out(tmp_path) -> None:
    eom = kn.derive(double_pendulum.system())
    pages = [kn.report(eom, tmp_path / "r.html", why=why).read_text(encoding="utf-8") for why in (False, None)]
    assert ["why" in Page(text).sections for text in pages] == [False, True]
