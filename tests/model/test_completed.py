# SPDX-License-Identifier: BSD-3-Clause
"""Systems by their independent speeds alone: the same motion, and what is still refused."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.errors import SpeedsError
from kane.gallery import chaplygin_sleigh, four_bar, pure_rolling_disk, sphere_on_turntable
from tests.laws.test_methods import numbers, states

CASES = {
    "disk": (pure_rolling_disk, {"u1", "u2", "u3"}),
    "sleigh": (chaplygin_sleigh, {"v", "w"}),
    "four-bar by its coupler": (four_bar, {"u2"}),
    "four-bar by its crank": (four_bar, {"u1"}),
    "sphere, Euler parameters": (sphere_on_turntable, {"w_x", "w_y", "w_z"}),
}


def alone(system, names):
    """The system with some of its speeds."""
    return system.replace(speeds={u: e for u, e in system.speeds.items() if u.name in names}, dependent_speeds=())


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_accelerations_are_those_by_all_speeds(case):
    module, names = CASES[case]
    whole, short = kn.derive(module.system()), kn.derive(alone(module.system(), names))
    assert {u.name for u in short.independent_speeds} == names
    added = [u for u in short.speeds if u.name not in names]
    assert set(added) == set(short.dependent_speeds)
    at = states(whole, 5)
    at |= {u: np.zeros(5) for u in added}
    index = [k for k, u in enumerate(whole.speeds) if u.name in names]
    wanted = numbers([whole.accelerations[k] for k in index], at)
    found = numbers([x for u, x in zip(short.speeds, short.accelerations, strict=True) if u.name in names], at)
    assert found == pytest.approx(wanted, rel=1e-11, abs=1e-11)
    assert numbers(short.rates, at) == pytest.approx(numbers(whole.rates, at), rel=1e-12, abs=1e-12)
    vanishing = numbers([x for u, x in zip(short.speeds, short.accelerations, strict=True) if u.name not in names], at)
    assert vanishing == pytest.approx(0, abs=1e-11)


@pytest.mark.slow
def test_a_motion_needs_no_others_at_the_start():
    eom = kn.derive(alone(pure_rolling_disk.system(), {"u1", "u2", "u3"}))
    sol = kn.simulate(eom, (0, 1), q=[0, 0.2, 0, 0, 0], u={"u1": 0.1, "u2": 1.0, "u3": 5.0})
    assert sol.keeps_energy
    assert sol["w1"] == pytest.approx(0, abs=1e-12)
    assert kn.count_operations((*eom.right_hand_side, *eom.reaction_values)).total <= 52


def test_other_names_are_left_alone():
    """A speed w1 of one's own keeps its name."""
    system = chaplygin_sleigh.system()
    w1 = kn.speed("w1")
    own = {(w1 if u.name == "w" else u): e for u, e in system.speeds.items() if u.name in ("v", "w")}
    (added,) = kn.derive(system.replace(speeds=own, dependent_speeds=())).dependent_speeds
    assert added.name not in ("v", "w1")


@pytest.mark.parametrize(
    "names",
    [
        {"v"},  # two are missing, one constraint
        {"s", "w"},  # s is what the blade holds: it says nothing
    ],
)
def test_what_does_not_determine_the_rates_is_refused(names):
    with pytest.raises(SpeedsError, match="Expected"):
        kn.derive(alone(chaplygin_sleigh.system(), names))


def test_one_speed_forgotten_under_two_constraints_is_refused():
    """Four of the disk's five: neither all speeds nor the independent ones."""
    for left in ({"u1", "u2", "u3", "u4"}, {"u1", "u2", "u3", "u5"}, {"u2", "u3", "u4", "u5"}):
        with pytest.raises(SpeedsError, match="Expected"):
            kn.derive(alone(pure_rolling_disk.system(), left))
