# SPDX-License-Identifier: BSD-3-Clause
"""A mode that begins pulled, or held by more friction than there is, is refused; the system itself takes the right one.

Motions that begin late, where times are far apart from each other, are those that begin at t = 0.
"""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import kane as kn
from kane.gallery import skidding_disk
from tests.examples import examples
from tests.laws.test_contacts import admitted, drawn_modes, frictionless
from tests.motion.test_contact_runner import by_python
from tests.oracles.planar_contacts import Plane, Plate, Support, Touch, solved
from tests.peer import require
from tests.systems.planar_contacts import model, planes, system

STATIC, WEIGHT = 0.35, 9.81


@pytest.fixture(scope="module")
def block() -> tuple[kn.Equations, kn.Equations]:
    """A block on a floor, pulled by F_x along it and by F_y upward: the whole, and its mode that sticks."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, y = kn.coordinates("x y", "m")
    P = O.at("P", x * N.x + y * N.y)
    pull = kn.parameter("F_x", 0.0, "N") * N.x + kn.parameter("F_y", 0.0, "N") * N.y
    floor = kn.contact(kn.joints.point_on_plane("floor", P, O, normal=N.y), 0.3, static=STATIC)
    whole = kn.System(
        N,
        bodies=[kn.Particle("block", P, 1.0)],
        speeds="rates",
        loads=[kn.gravity(-WEIGHT * N.y), kn.Force(P, pull)],
        contacts=[floor],
    )
    return kn.derive(whole), kn.derive(whole.in_modes({"floor": "stick"}))


@pytest.mark.parametrize(
    ("along", "upward", "mode"),
    [
        (0.99, 0.0, "stick"),
        (1 + 1e-6, 0.0, "slip"),
        (-1.5, 0.0, "slip"),
        (0.99, 0.5, "stick"),
        (1.01, -0.5, "slip"),
        (0.0, 1 + 1e-6, "separated"),
        (0.1, 3.0, "separated"),
        (1.0, 0.0, "stick"),
        (1 - 1e-12, 0.0, "stick"),
    ],
)
@pytest.mark.filterwarnings("ignore:Expected a start beside the threshold:kane.KaneWarning")
def test_a_block_that_cannot_stick(block: Any, along: float, upward: float, mode: str) -> None:
    """`along` is F_x as a share of the most friction, `upward` F_y as one of the weight."""
    whole, sticks = block
    up = upward * WEIGHT
    most = STATIC * abs(WEIGHT - up)
    given_: Any = {"q": [0, 0], "u": [0, 0], "parameters": {"F_x": along * most, "F_y": up}}
    assert kn.simulate(whole, (0, 1e-3), **given_).mode_history[0][1] == {"floor": mode}
    if mode == "stick":
        assert np.ptp(kn.simulate(sticks, (0, 1), **given_).q) == 0
        return
    told = (
        "with a normal force ≥ 0, got N = " if mode == "separated" else r"with sufficient friction, got \|F\| > μ_s N"
    )
    for run in (kn.simulate, kn.simulate, by_python):  # the second time by the kernel that is there
        with pytest.raises(kn.SimulationError, match=f"Expected a contact 'floor' {told}"):
            run(sticks, (0, 1), **given_)


@pytest.mark.filterwarnings("ignore:Expected a start beside the threshold:kane.KaneWarning")
def test_many_blocks_some_of_which_cannot_stick(block: Any) -> None:
    """Each is judged for itself: the force along the floor is 0.99 or 1.01 of the most friction, by turns."""
    require("xarray")
    along = np.tile([0.99, 1.01], 20) * STATIC * WEIGHT
    found = kn.simulate_many(
        block[1], (0, 1), q=[0, 0], u=[0, 0], parameters={"F_x": along, "F_y": np.zeros(len(along))}
    )
    assert found.status.values.tolist() == ["finished", "failed"] * 20


@examples(0.2)
@given(planes(), st.data())
def test_random_modes_that_cannot_be(plane: Any, data: st.DataObject) -> None:
    """A mode goes on just where the forces that Newton and Euler's equations of redundant coordinates give are in their cones."""
    modes = drawn_modes(plane, data)
    rng = np.random.default_rng(data.draw(st.integers(0, 2**32)))
    oracle = frictionless(plane, modes)
    state = admitted(plane, oracle, rng, 0.0)
    assume(state is not None and not any(m in ("straight", "slip") for m in modes))
    assert state is not None
    q, u = state
    eom = kn.derive(system(plane).in_modes({f"c{i}": m for i, m in enumerate(modes)}))
    _, normal, tangential = solved(plane, q, u, oracle, [1.0] * len(modes), 0.0)
    margins, size = [], max(1.0, *np.abs(normal), *np.abs(tangential))
    for i, mode in enumerate(modes):
        if mode == "separated":
            continue
        margins.append(normal[i])
        if mode == "stick" and plane.touches[i].static:
            group = [i] + [j for j in range(i + 1, len(modes)) if set(modes[i + 1 : j + 1]) == {"held"}]
            most = sum(plane.touches[j].static * normal[j] for j in group)
            margins.append(most - abs(sum(tangential[j] for j in group)))
    assume(margins and min(np.abs(margins)) > 1e-6 * size)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", kn.KaneWarning)
        if min(margins) > 0:
            assert kn.simulate(eom, (0, 1e-9), q=q, u=u).t[-1] > 0
        else:
            with pytest.raises(kn.SimulationError, match=r"with a normal force ≥ 0|with sufficient friction"):
                kn.simulate(eom, (0, 1e-9), q=q, u=u)


@pytest.mark.parametrize("late", [1e5, 1e7])
@pytest.mark.parametrize("simulate", [kn.simulate, by_python])
def test_a_slip_in_space_ends_late(simulate: Any, late: float) -> None:
    """Times are 1e-11 s and 2e-9 s apart: the disk's slip ends straight from the speed that it loses in some of these."""
    eom, options = kn.derive(skidding_disk.system()), {"rtol": 1e-13, "atol": 1e-13}
    early = simulate(eom, (0, 3), **skidding_disk.START, **options)
    sol = simulate(eom, (late, late + 3), **skidding_disk.START, **options)
    assert sol.status == "finished", sol.message
    assert [e.name for e, _ in sol.events] == ["ground slows", "ground sticks"]
    np.testing.assert_allclose(sol.states[-1], early.states[-1], rtol=0, atol=40 * np.spacing(late) + 1e-9)


@pytest.mark.parametrize(  # at 1e7 the last rebounds by Stronge's law are within the rounding of sin ω t
    ("law", "late"), [(law, late) for law in ("stronge", "moreau") for late in (1e5, 1e6, 1e7)[: 2 + (law == "moreau")]]
)
def test_a_plate_falls_on_a_shaken_floor_late(law: str, late: float) -> None:
    """Its rebounds end, and by Moreau's law both corners hit at once and it does not turn, though sin ω t is known to ω t ε alone."""
    corners = [Touch(0, (x, -0.3), kinetic=0.3, static=0.3, restitution=0.5) for x in (0.4, -0.4)]
    plane = Plane(0.0, (Plate(2.0, 0.3),), tuple(corners), Support((0.0, 1.0), (0.05, 5.0), 0.3))
    own, late = model(plane, law), round(5 * late / (2 * np.pi)) * 2 * np.pi / 5
    given = {"q": [0, 0.8, 0], "u": [0.5, 0.1, 0], "parameters": own.values(plane)}
    for tolerance in (1e-9, 1e-12):
        options = {"rtol": tolerance, "atol": tolerance}
        early = kn.simulate(own.eom, (0, 3), **given, **options)
        sol = kn.simulate(own.eom, (late, late + 3), **given, **options)
        assert sol.status == "finished", sol.message
        assert len(sol.events) < 1.5 * len(early.events)
        np.testing.assert_allclose(sol.states[-1], early.states[-1], rtol=0, atol=1e-12 * late + 1e-7)
        assert law != "moreau" or np.abs(sol[own.coordinates[2]]).max() < 1e-20
