# SPDX-License-Identifier: BSD-3-Clause
"""Which modes are chosen for the contacts of random bodies, beside a second route that shares nothing with `kane`.

Its W and b are those of redundant coordinates (`tests.oracles`); in the plane every mode is tried, in space directions of slip on grids, or
the cones by a conic solver where contacts are too many. One, none or several answers are so by both; the one has the same modes, and the
same accelerations as the equations of its mode have.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane.contacts import Choice, Count, Mode, choose
from kane.errors import ContactError
from kane.motion import ContactMotion
from tests.contacts.states import State
from tests.examples import examples
from tests.laws.test_contacts import admitted as admitted_in_plane
from tests.oracles import contact_modes, planar_contacts, spatial_contacts
from tests.peer import require
from tests.systems import planar_contacts as plane_systems
from tests.systems import spatial_contacts as space_systems
from tests.systems.spatial_contacts import admitted

Array = Any
NAMES = {Mode.OPEN: "open", Mode.STICK: "stick", Mode.FRESH_SLIP: "begins", Mode.SLIP: "slides"}
UNDETERMINED = "whose forces rigid bodies determine"


class Instant(NamedTuple):
    """A state of a model in which some contacts are closed: what the oracle knows of it."""

    model: Any
    values: Mapping[Any, float]
    t: float
    q: Array
    u: Array
    modes: Sequence[str]
    closed: Sequence[int]
    state: State
    unit: float


def instant(model: Any, values: Any, t: float, q: Array, u: Array, modes: Sequence[str], reduced: Any) -> Instant:
    """The problem of the closed contacts in units of its largest numbers; `reduced` is (W, b, terms, v, μ_k, μ_s)."""
    w, b, terms, v, kinetic, static = reduced
    d = len(b) // len(modes)
    closed = [i for i, mode in enumerate(modes) if mode != "separated"]
    rows = [d * i + j for i in closed for j in range(d)]
    slip = v.reshape(-1, d)[closed, 1:]
    speed = np.linalg.norm(slip, axis=1, keepdims=True)
    sliding = np.where(speed > 1e-9, slip / np.where(speed > 1e-9, speed, 1.0), 0.0)
    unit = terms[rows].max()
    w = w[np.ix_(rows, rows)]
    given_ = [np.array(x)[closed] for x in (static, kinetic)]
    state = State("", d, w / np.diag(w).max(), b[rows] / unit, terms[rows] / unit, *given_, sliding)
    return Instant(model, values, t, q, u, modes, closed, state, unit)


class Chosen(NamedTuple):
    """What the library chooses: how many answers there are (None: not counted), the choice, and the modes of all contacts.

    `modes` are None where the bodies do not determine the forces of those that stick.
    """

    count: int | None
    choice: Choice | None
    modes: Any
    directions: Array


def chosen(at: Instant) -> Chosen:
    """The modes that a motion from this state on begins with."""
    eom = at.model.eom
    state = dict(zip(at.model.coordinates, at.q, strict=True))
    x = np.array([*(state[s] for s in eom.coordinates), *at.u])
    motion = ContactMotion(eom, (at.t, at.t + 1), (at.values, {}), {"atol": 1e-10, "rtol": 1e-10, "settings": None})
    modes, directions = None, np.zeros(0)
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Expected one mode of the contacts", kn.KaneWarning)
        try:
            after, now = motion.begin(at.t, x)
            np.testing.assert_allclose(after, x, rtol=0, atol=1e-9)  # nothing hits
            choice, modes, directions = now.choice, now.modes, now.directions
        except ContactError as none:
            return Chosen(None if "none found" in str(none) else 0, None, None, directions)
        except kn.SimulationError as error:
            if UNDETERMINED not in str(error):
                raise
            touch = motion.touch(at.t, x)
            sliding = np.zeros((len(at.modes), at.state.d - 1))
            sliding[at.closed] = at.state.sliding
            choice = choose(touch.problem(at.closed, sliding, touch.numbers.laws[:, 0]))
    assert choice is not None
    return Chosen({Count.ONE: 1, Count.SEVERAL: 2, Count.UNKNOWN: None}[choice.count], choice, modes, directions)


def in_units(choice: Choice, at: Instant) -> tuple[Array, Array]:
    """Accelerations, and what rounding leaves of them."""
    return choice.accelerations / at.unit, 1e-9 + choice.solution.acceleration_errors / at.unit


def beside_enumeration(at: Instant) -> str:
    """The same number of answers, and of one its modes and accelerations: "one", "none", "several" or "forces" of a continuum."""
    count, choice, *_ = found = chosen(at)
    expected = contact_modes.rounds(at.state, contact_modes.enumerated)
    if choice is not None and not choice.solution.determined:
        assert count in (None, 2)
        return "forces"
    assert count == min(len(expected), 2)
    if choice is None:
        return "none"
    a, errors = in_units(choice, at)
    if count == 2:
        assert len(choice.others) == len(expected) - 1
        assert min(np.abs(other - a).max() for _, other in expected) < 1e-7
        return "several"
    assert tuple(NAMES[mode] for mode in choice.modes) == expected[0][0]
    assert (np.abs(a - expected[0][1]) <= errors).all()
    beside_equations(at, found)
    return "one"


def beside_cones(at: Instant) -> str:
    """Where contacts are too many to count: the answer obeys the laws, and that of the conic solver is the same where there is but one."""
    _, choice, *_ = found = chosen(at)
    if choice is None:
        assert at.state.slides.any()
        return "none"
    a, errors = in_units(choice, at)
    forces = choice.forces * (np.diag(choice_mobility(at)).max() / at.unit)
    kinds = tuple(NAMES[mode] for mode in choice.modes)
    mu = np.where([kind == "begins" for kind in kinds], at.state.kinetic, at.state.static)
    assert contact_modes.violation(at.state, kinds, mu, a, forces, choice.directions) < 1e-8
    if choice.count is Count.ONE and not at.state.slides.any():
        for _, other, _ in contact_modes.rounds(at.state, contact_modes.conic):
            assert (np.abs(other - a) <= 1e-6 + errors).all()
    if choice.solution.determined:
        beside_equations(at, found)
    return "cones"
