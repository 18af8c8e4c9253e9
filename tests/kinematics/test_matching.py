# SPDX-License-Identifier: BSD-3-Clause
"""Frames along which velocities are made of the speeds are sought once by these speeds, whatever follows from which."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane import free_symbols
from kane.expr import ZERO
from kane.gallery import rolling_disk, whipple_bicycle
from kane.kinematics import Following, Matching
from kane.numeric import draw


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


def test_speeds_that_vanish_are_in_no_motion():
    system = whipple_bicycle.system()
    derived = kn.derive(system).derived
    gone = frozenset(derived.speeds[3:6])
    following = {u: Following({}, ZERO, ZERO) for u in gone}
    without = derived.kinematics.with_following(following, {}, gone)
    held = derived.kinematics.with_following(following, {})
    shown = [
        [x for v in (m.total, m.bias, *m.partials.values()) for x in v.scalars()]
        for m in (k.frame(b.frame) for k in (without, held) for b in system.rigid_bodies)
    ]
    half = len(shown) // 2
    assert gone.isdisjoint(free_symbols(x for xs in shown[:half] for x in xs))
    assert not gone.isdisjoint(free_symbols(x for xs in shown[half:] for x in xs))
    for b in system.rigid_bodies:
        pairs = [m.frame(b.frame).bias.components(b.frame) for m in (held, without)]
        at = {s: draw(1, s) for s in free_symbols(x for xs in pairs for x in xs)} | dict.fromkeys(gone, 0.0)
        wanted, found = (np.array(kn.evaluate(list(xs), at)) for xs in pairs)
        assert found == pytest.approx(wanted, rel=1e-11, abs=1e-12)
