# SPDX-License-Identifier: BSD-3-Clause
"""Which modes are chosen for the contacts of random bodies, beside a second route that shares nothing with `kane`.

Its W and b are those of redundant coordinates (`tests.oracles`); in the plane every mode is tried, in space directions of slip on
grids, or the cones by a conic solver where contacts are too many. One, none or several answers are so by both; the one has the same
modes, and the same accelerations as the equations of its mode have.
"""

from __future__ import annotations

import itertools
import warnings
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import kane as kn
from kane.contacts import ContactStatus, ModeChoice, SolutionCount, choose
from kane.errors import ContactError
from kane.motion import ContactMotion
from tests.contacts.states import State
from tests.examples import examples
from tests.laws.test_contacts import admitted as admitted_in_plane
from tests.oracles import contact_modes, planar_contacts, spatial_contacts
from tests.oracles.planar_contacts import Plane
from tests.oracles.spatial_contacts import Scene
from tests.peer import require
from tests.systems import planar_contacts as plane_systems
from tests.systems import spatial_contacts as space_systems
from tests.systems.spatial_contacts import admitted

Array = Any
NAMES = {
    ContactStatus.OPEN: "open",
    ContactStatus.STICK: "stick",
    ContactStatus.FRESH_SLIP: "begins",
    ContactStatus.SLIP: "slides",
}
UNDETERMINED = "with uniquely determined forces between rigid bodies"


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
    mobility: float
    solve: Any


def instant(
    model: Any, values: Any, t: float, q: Array, u: Array, modes: Sequence[str], reduced: Any, laws: Any, solve: Any
) -> Instant:
    """The problem of the closed contacts in units of its largest numbers; `reduced` is (W, b, terms, v), `laws` (μ_k, μ_s)."""
    w, b, terms, v = reduced
    kinetic, static = laws
    d = len(b) // len(modes)
    closed = [i for i, mode in enumerate(modes) if mode != "separated"]
    rows = [d * i + j for i in closed for j in range(d)]
    slip = v.reshape(-1, d)[closed, 1:]
    speed = np.linalg.norm(slip, axis=1, keepdims=True)
    sliding = np.where(speed > 1e-9, slip / np.where(speed > 1e-9, speed, 1.0), 0.0)
    unit = terms[rows].max()
    w = w[np.ix_(rows, rows)]
    most = np.diag(w).max()
    mu_s, mu_k = (np.array(x)[closed] for x in (static, kinetic))
    state = State("", d, w / most, b[rows] / unit, terms[rows] / unit, mu_s, mu_k, sliding)
    return Instant(model, values, t, q, u, modes, closed, state, unit, most, solve)


class Chosen(NamedTuple):
    """What the library chooses: how many answers there are (None: not counted), the choice, and the modes of all contacts.

    `modes` are None where the bodies do not determine the forces of those that stick.
    """

    answers: int | None
    choice: ModeChoice | None
    modes: Any
    directions: Array
    constants: Mapping[Any, float] = MappingProxyType({})
    equations: kn.Equations | None = None


def chosen(at: Instant) -> Chosen:
    """The modes that a motion from this state on begins with."""
    eom = at.model.eom
    state = dict(zip(at.model.coordinates, at.q, strict=True))
    x = np.array([*(state[s] for s in eom.coordinates), *at.u])
    motion = ContactMotion(eom, (at.t, at.t + 1), (at.values, {}), {"atol": 1e-10, "rtol": 1e-10, "settings": None})
    modes, directions, constants, equations = None, np.zeros(0), dict[Any, float](), None
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Expected one mode of the contacts", kn.KaneWarning)
        try:
            after, now = motion.begin(at.t, x)
            np.testing.assert_allclose(after, x, rtol=0, atol=1e-9)  # nothing hits
            choice, modes, directions = now.choice, now.modes, now.directions
            constants = motion.constants(now, at.t, after)
            equations = motion.mode(modes, constants, after)
        except ContactError as none:
            return Chosen(None if "none found" in str(none) else 0, None, None, directions)
        except kn.SimulationError as error:
            if UNDETERMINED not in str(error):
                raise
            modes, touch = None, motion.touch(at.t, x)
            sliding = np.zeros((len(at.modes), at.state.d - 1))
            sliding[at.closed] = at.state.sliding
            choice = choose(touch.problem(at.closed, sliding, touch.numbers.laws[:, 0]))
    assert choice is not None
    return Chosen(
        {SolutionCount.ONE: 1, SolutionCount.SEVERAL: 2, SolutionCount.UNKNOWN: None}[choice.count],
        choice,
        modes,
        directions,
        constants,
        equations,
    )


def in_units(choice: ModeChoice, at: Instant) -> tuple[Array, Array]:
    """Accelerations, and what rounding leaves of them."""
    return choice.accelerations / at.unit, 1e-9 + choice.solution.acceleration_errors / at.unit


def beside_enumeration(at: Instant) -> str:
    """The same number of answers, and of one its modes and accelerations: "one", "none", "several", or "a continuum"."""
    count, choice, *_ = found = chosen(at)
    expected = contact_modes.rounds(at.state, contact_modes.enumerated)
    if choice is not None and not choice.solution.determined:
        assert count in (None, 2)
        return "a continuum"
    assert count == min(len(expected), 2)
    if choice is None:
        return "none"
    a, errors = in_units(choice, at)
    if count == 2:
        assert len(choice.others) == len(expected) - 1
        for other in choice.others:
            assert min(np.abs(x - other.accelerations / at.unit).max() for _, x in expected) < 1e-7
        return "several"
    assert tuple(NAMES[mode] for mode in choice.modes) == expected[0][0]
    assert (np.abs(a - expected[0][1]) <= errors).all()
    beside_conic(at, choice)
    return beside_equations(at, found, *expected[0])


def beside_conic(at: Instant, choice: ModeChoice) -> None:
    """The one answer is the conic solver's, where nothing slips yet and cones are no lines."""
    if choice.count is SolutionCount.ONE and not at.state.slides.any() and at.state.kinetic.min() > 0.01:
        a, errors = in_units(choice, at)
        for _, other, *_ in contact_modes.rounds(at.state, contact_modes.conic):
            assert (np.abs(other - a) <= 1e-5 + errors).all()


def beside_cones(at: Instant) -> str:
    """Where contacts are too many to count: the answer obeys the laws, and the conic solver's is the same where there is but one."""
    _, choice, *_ = found = chosen(at)
    if choice is None:
        assert at.state.slides.any()
        return "none"
    a, _ = in_units(choice, at)
    forces = choice.forces * at.mobility / at.unit
    kinds = tuple(NAMES[mode] for mode in choice.modes)
    mu = np.where([kind == "begins" for kind in kinds], at.state.kinetic, at.state.static)
    assert contact_modes.violation(at.state, kinds, mu, a, forces, choice.directions) < 1e-8
    beside_conic(at, choice)
    return beside_equations(at, found, kinds, a) if choice.solution.determined else "a continuum"


def by_oracle(at: Instant, kinds: Sequence[str], a: Array) -> Array:
    """u̇ in the modes of the closed contacts, whose accelerations are a."""
    words, d = ["separated"] * len(at.modes), at.state.d
    along = np.zeros((len(at.modes), d - 1))
    for k, (i, kind) in enumerate(zip(at.closed, kinds, strict=True)):
        words[i] = {"open": "separated", "stick": "stick"}.get(kind, "straight")
        slip = a[d * k + 1 : d * k + d]
        along[i] = at.state.sliding[k] if kind == "slides" else slip / max(float(np.linalg.norm(slip)), 1e-12)
    return at.solve(words, along)


def beside_equations(at: Instant, found: Chosen, kinds: Sequence[str], a: Array) -> str:
    """The accelerations of the equations of the modes are the oracle's: "one"; "held" where forces are not determined."""
    if found.modes is None:
        return "held"
    wanted, first, eom = by_oracle(at, kinds, a), at.model.eom, found.equations
    assert eom is not None
    state = dict(zip(at.model.coordinates, at.q, strict=True)) | dict(zip(eom.speeds, at.u, strict=True))
    numbers = state | {kn.time: at.t} | dict(at.values)
    for c, way in zip(first.system.contacts, found.directions, strict=True):
        numbers |= dict(zip(c.direction, way, strict=False))
    numbers |= found.constants
    values = np.array(kn.evaluate(list(eom.solved.accelerations), numbers), dtype=float)
    if not np.isfinite(values).all():  # where other speeds are dependent
        here = {*eom.coordinates, *eom.parameters}
        eom = kn.derive(eom.system, near={s: x for s, x in numbers.items() if s in here})
        values = np.array(kn.evaluate(list(eom.solved.accelerations), numbers), dtype=float)
    np.testing.assert_allclose(values, wanted, rtol=0, atol=1e-7 * max(1.0, np.abs(wanted).max()))
    return "one"


PER_EXAMPLE = 6
KINDS = ("separated", "stick", "stick", "straight", "straight")


def drawn_kinds(count: int, rng: np.random.Generator) -> list[str]:
    """What contacts do by their speeds, one at least closed; half the time none slips."""
    kinds = [str(rng.choice(KINDS)) for _ in range(count)]
    if rng.random() < 0.5:
        kinds = ["stick" if k == "straight" else k for k in kinds]
    kinds[int(rng.integers(count))] = str(rng.choice(["stick", "straight"]))
    return kinds


def planar_states(plane: Plane, rng: np.random.Generator) -> Iterator[Instant]:
    """Random states of a plane."""
    if rng.random() < 0.3:  # where several modes, or none, may agree with the laws
        rough = [replace(x, kinetic=4 * x.kinetic, static=4 * x.static) for x in plane.touches]
        plane = replace(plane, touches=tuple(rough))
    model, t = plane_systems.model(plane), float(rng.uniform(0, 3))
    for _ in range(PER_EXAMPLE):
        kinds = drawn_kinds(len(plane.touches), rng)
        state = admitted_in_plane(plane, kinds, rng, t, redundant=True)
        if state is None:
            continue
        q, u = state
        w, b, terms, v = planar_contacts.reduced(plane, q, u, t)
        z, dz = planar_contacts.poses(plane, q)
        gaps = [planar_contacts.rows(plane, touch, z, dz @ u, t).gap for touch in plane.touches]
        for i, touch in enumerate(plane.touches):
            if touch.stops:
                v[2 * i + 1] = 0.0
        if clear(kinds, gaps, w, v, 2):
            laws = [x.kinetic for x in plane.touches], [x.static for x in plane.touches]
            yield instant(
                model, model.values(plane), t, q, u, kinds, (w, b, terms, v), laws,
                partial(solved_in_plane, plane, q, u, t),
            )  # fmt: skip


def solved_in_plane(plane: Plane, q: Array, u: Array, t: float, words: Sequence[str], along: Array) -> Array:
    stops = [w if not x.stops or w == "separated" else "straight" for w, x in zip(words, plane.touches, strict=True)]
    return planar_contacts.solved(plane, q, u, stops, along[:, 0], t)[0]


def spatial_states(scene: Scene, rng: np.random.Generator) -> Iterator[Instant]:
    """Random states of a scene."""
    model = space_systems.model(scene)
    for _ in range(PER_EXAMPLE // 2):
        kinds = drawn_kinds(len(scene.touches), rng)
        state = admitted(scene, kinds, rng, redundant=True)
        if state is None:
            continue
        q, u = state
        reduced = spatial_contacts.reduced(scene, q, u)
        gaps = spatial_contacts.rows(scene, spatial_contacts.posed(scene, q), np.zeros(6 * len(scene.solids))).gaps
        if clear(kinds, gaps, reduced[0], reduced[3], 3):
            laws = [x.kinetic for x in scene.touches], [x.static for x in scene.touches]
            yield instant(
                model, model.values(scene), 0.0, q, u, kinds, reduced, laws, partial(solved_in_space, scene, q, u)
            )


def solved_in_space(scene: Scene, q: Array, u: Array, words: Sequence[str], along: Array) -> Array:
    return spatial_contacts.solved(scene, q, u, words, along).accelerations


def clear(kinds: Sequence[str], gaps: Any, w: Array, v: Array, d: int) -> bool:
    """Whether what is open is open, slips are some or none, and no gap is at its extremum: its root is known to √ε only."""
    slips = np.linalg.norm(v.reshape(-1, d)[:, 1:], axis=1)
    mobility = np.diag(w).reshape(-1, d)
    if (mobility[:, 0] < 1e-9 * mobility.max(axis=1)).any():
        return False
    opened = all(g > 1e-3 for g, kind in zip(gaps, kinds, strict=True) if kind == "separated")
    return opened and all(s < 1e-11 or s > 1e-3 for s in slips)


@pytest.mark.grows
def test_the_modes_of_plane_bodies() -> None:
    """1,000 states and more by the full profile."""
    require("clarabel")
    told: Counter[str] = Counter()

    @examples(1.5)
    @given(plane_systems.alike(), st.integers(0, 2**32))
    def beside(drawn: tuple[Plane, str], seed: int) -> None:
        told.update(beside_enumeration(at) for at in planar_states(drawn[0], np.random.default_rng(seed)))

    beside()
    assert told["one"] >= 5 * settings().max_examples


@pytest.mark.slow
@examples(0.1)
@given(plane_systems.alike(), st.integers(0, 2**32))
def test_motions_begin_in_the_modes_that_are_chosen(drawn: tuple[Plane, str], seed: int) -> None:
    for at in itertools.islice(planar_states(drawn[0], np.random.default_rng(seed)), 1):
        expected = contact_modes.rounds(at.state, contact_modes.enumerated)
        if len(expected) != 1 or chosen(at).modes is None:
            continue
        kinds, a = expected[0]
        q = dict(zip(at.model.coordinates, at.q, strict=True))
        sol = kn.simulate(at.model.eom, (at.t, at.t + 1e-6), q=q, u=at.u, parameters=at.values, samples=2)
        words = dict.fromkeys(sol.modes, "separated")
        for i, kind in zip(at.closed, kinds, strict=True):
            words[f"c{i}"] = {"open": "separated", "stick": "stick"}.get(kind, "slip")
        rubs = {c.name for c in at.model.eom.system.contacts if c.slips}
        assert [sol.modes[name][0] for name in rubs] == [words[name] for name in rubs]
        wanted = by_oracle(at, kinds, a)
        u = sol.rates()[0][len(q) :]
        np.testing.assert_allclose(u, wanted, rtol=0, atol=1e-7 * max(1.0, np.abs(wanted).max()))


@pytest.mark.slow
@pytest.mark.grows
def test_the_modes_of_bodies_in_space() -> None:
    require("clarabel")
    told: Counter[str] = Counter()

    @examples(1.0)
    @given(space_systems.scenes((*space_systems.BUILDS, *space_systems.STANDING)), st.integers(0, 2**32))
    def beside(scene: Scene, seed: int) -> None:
        for at in spatial_states(scene, np.random.default_rng(seed)):
            second = beside_enumeration if np.sum(~at.state.slides) <= 2 else beside_cones
            told[second(at)] += 1

    beside()
    assert told.total() >= 2 * settings().max_examples
