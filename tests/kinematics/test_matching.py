# SPDX-License-Identifier: BSD-3-Clause
"""Frames along which velocities are made of the speeds are sought once by these speeds, whatever follows from which."""

from __future__ import annotations

import pytest

import kane as kn
from kane.gallery import rolling_disk, whipple_bicycle
from kane.kinematics.matching import Matching


@pytest.mark.parametrize("system", [rolling_disk.system, whipple_bicycle.system])
def test_motions_by_the_same_speeds_share_what_was_found(system, monkeypatch):
    asked: list[object] = []
    search = Matching._rotation
    monkeypatch.setattr(Matching, "_rotation", lambda self, frame: asked.append(frame) or search(self, frame))
    derived = kn.derive(system()).derived
    usual = derived.kinematics
    again = usual.with_following({}, {})
    for b in derived.system.rigid_bodies:
        usual.frame(b.frame)
    asked.clear()
    for b in derived.system.rigid_bodies:
        one, other = usual.frame(b.frame), again.frame(b.frame)
        assert one is not other
        assert [v.parts for v in one.partials.values()] == [v.parts for v in other.partials.values()]
        assert one.bias.parts == other.bias.parts
    assert not asked
