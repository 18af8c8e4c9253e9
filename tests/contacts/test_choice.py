# SPDX-License-Identifier: BSD-3-Clause
"""Which contacts open, stick and slip: beside a second route, in closed form, in any units; where there is no answer, or several."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kane.contacts import (
    Block,
    ContactStatus,
    SolutionCount,
    choose,
    contact_problem,
    enumerated,
    iterated,
    jamming,
    least_forces,
    projected,
)
from kane.errors import ArgumentError, ContactError
from tests.contacts.states import dense, scene
from tests.examples import examples
from tests.oracles import contact_modes
from tests.peer import require

NAMES = {
    ContactStatus.OPEN: "open",
    ContactStatus.STICK: "stick",
    ContactStatus.FRESH_SLIP: "begins",
    ContactStatus.SLIP: "slides",
}
SEEDS = st.integers(0, 2**32 - 1)


def problem(state, mass=1.0, length=1.0):
    """The numbers of a state, in other units of mass and length."""
    return contact_problem(
        state.W / mass,
        state.b * length,
        state.static,
        kinetic=state.kinetic,
        sliding=state.sliding,
        terms=state.terms * length,
    )


def chosen(state, **units):
    """A choice, None where there is none; how many answers: 0, 1 or 2 for several, None where they are not counted."""
    try:
        choice = choose(problem(state, **units))
    except ContactError as none:
        return None, None if "none found" in str(none) else 0
    return choice, {SolutionCount.ONE: 1, SolutionCount.SEVERAL: 2, SolutionCount.UNKNOWN: None}[choice.count]


def labels(solution):
    return tuple(NAMES[mode] for mode in solution.modes)


def near(a, b, least=1e-9):
    """Whether the accelerations of two answers are equal within the bounds of their errors."""
    return bool(
        (np.abs(a.accelerations - b.accelerations) <= least + a.acceleration_errors + b.acceleration_errors).all()
    )


def beside_enumeration(state):
    """One, none or several by both, and the same modes and accelerations of the one."""
    choice, count = chosen(state)
    expected = contact_modes.rounds(state, contact_modes.enumerated)
    if choice is not None and not choice.solution.determined:
        assert count in (None, 2)
        return
    assert count == min(len(expected), 2)
    if count == 1:
        assert labels(choice) == expected[0][0]
        assert (np.abs(choice.accelerations - expected[0][1]) <= 1e-9 + choice.solution.acceleration_errors).all()
    elif count == 2:
        for other in choice.others:
            assert min((np.abs(a - other.accelerations) - other.acceleration_errors).max() for _, a in expected) < 1e-7
        assert len(choice.others) == len(expected) - 1


def lawful(state, solution, mu, enough):
    """Whether forces and accelerations obey the laws of the modes."""
    solution_labels, a, forces, directions = solution
    assert contact_modes.violation(state, solution_labels, mu, a, forces, directions) < enough


def choice_is_lawful(state, choice, mass=1.0, length=1.0):
    kinds, a, forces = labels(choice), choice.accelerations / length, choice.forces / (mass * length)
    lawful(state, (kinds, a, forces, choice.directions), friction_of(state, kinds), 1e-8)


def friction_of(state, kinds):
    """μ of the last round."""
    return np.where([kind == "begins" for kind in kinds], state.kinetic, state.static)


def beside_cones(state):
    """Where contacts are too many to count, the answer obeys the laws; that of the conic solver is the same or obeys them too.

    There always is one where no contact slips yet, as b = J v: λᵀ W λ is no less than zero (Acary et al. 2011, ZAMM 91, 155). Where
    one slips there may be none, and none is in any mode.
    """
    choice, _ = chosen(state)
    if choice is None:
        assert state.slides.any()
        assert not contact_modes.rounds(state, contact_modes.enumerated)
        return
    choice_is_lawful(state, choice)
    if state.slides.any():
        return
    for kinds, a, forces in contact_modes.rounds(state, contact_modes.conic):
        if choice.solution.determined and np.abs(a - choice.accelerations).max() > 1e-5:
            slip = a.reshape(len(kinds), -1)[:, 1:]
            directions = slip / np.maximum(np.linalg.norm(slip, axis=1, keepdims=True), 1e-12)
            lawful(state, (kinds, a, forces, directions), friction_of(state, kinds), 1e-5)


@pytest.mark.parametrize("drawn", [scene, dense])
@pytest.mark.parametrize("d", [2, 3])
@examples(0.42)
@given(seed=SEEDS)
def test_beside_a_second_route(d, drawn, seed):
    """1,000 states by the full profile, as many again of whole models in `tests.laws.test_chosen_modes`."""
    require("clarabel")
    rng = np.random.default_rng(seed)
    for _ in range(4 if d == 2 else 2):
        state = drawn(rng, d)
        (beside_enumeration if d == 2 or np.sum(~state.slides) <= 2 else beside_cones)(state)


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "skipped"), [(460, 1), (1022, 0)])
def test_four_dense_contacts_without_an_answer(seed, skipped):
    """Three may stick, and one slides: no angles of slip, no mode agrees with the laws; of the first it jams by itself."""
    require("clarabel")
    rng = np.random.default_rng(seed)
    for _ in range(skipped):
        dense(rng, 3)
    state = dense(rng, 3)
    assert chosen(state) == (None, None)
    beside_cones(state)


def surely_has(state):
    """Whether Lemke's method ends with an answer: its matrix is copositive (Cottle, Pang & Stone 1992, sec. 4.4), as b = J v."""
    if not state.slides.any():
        return True
    d, unit, left, right = state.d, np.eye(len(state.b)), [], []
    for i, slides in enumerate(state.slides):
        rows = unit[d * i : d * i + d]
        left += [rows[0]] if slides else list(rows)
        right += [rows[0] - state.kinetic[i] * state.sliding[i] @ rows[1:]] if slides else list(rows)
    form = np.array(left) @ state.W @ np.array(right).T
    return np.linalg.eigvalsh(form + form.T)[0] > 1e-9


@pytest.mark.parametrize("d", [2, 3])
@given(seed=SEEDS)
def test_iteration_finds_one_of_those_enumerated(d, seed):
    rng = np.random.default_rng(seed)
    state = (scene if rng.random() < 0.7 else dense)(rng, d)
    if d == 3 and len(state.static) > 2:
        return
    one = problem(state).with_friction(state.static)
    every, found = enumerated(one), iterated(one)
    if surely_has(state):
        assert found is not None
    if found is not None and found.determined:
        assert any(near(found, s) for s in every.solutions)


@pytest.mark.parametrize("d", [2, 3])
@given(seed=SEEDS, share=st.floats(0, 1))
def test_as_many_are_chosen_from_as_there_are(d, seed, share):
    """Also where a bound on friction says that there is one, and nothing is enumerated."""
    rng = np.random.default_rng(seed)
    state = (scene if rng.random() < 0.7 else dense)(rng, d)
    if d == 3 and np.sum(~state.slides) > 2:
        return
    one = contact_problem(state.W, state.b, share * state.static, sliding=state.sliding, terms=state.terms)
    every = enumerated(one).solutions
    if not every:
        with pytest.raises(ContactError):
            choose(one)
        return
    choice = choose(one)
    assert len(choice.others) == len(every) - 1
    if choice.solution.determined:
        assert any(near(choice.solution, s) and s.modes == choice.modes for s in every)
        assert (
            choice.count is (SolutionCount.ONE if len(every) == 1 else SolutionCount.SEVERAL)
            or not enumerated(one).complete
        )


@pytest.mark.parametrize(("mu", "count"), [(0.2, SolutionCount.ONE), (1.2, SolutionCount.UNKNOWN)])
def test_three_feet_that_slip_have_one_answer_where_friction_is_small(mu, count):
    """Feet in a plane press each other along it alone."""
    angles = 2 * np.pi * np.arange(3) / 3
    points = np.stack([np.cos(angles), np.sin(angles), -0.3 * np.ones(3)], axis=1)
    rows = [np.concatenate([t, np.cross(p, t)]) for p in points for t in np.eye(3)[[2, 0, 1]]]
    jacobian, force = np.array(rows), np.array([6.0, 3.0, -9.81, 0.0, 0.0, 1.0])
    choice = choose(contact_problem(jacobian @ jacobian.T, jacobian @ force, [mu] * 3))
    assert choice.count is count
    assert choice.solution.determined
    assert choice.modes == ((ContactStatus.FRESH_SLIP,) * 3 if mu < 1 else (ContactStatus.STICK,) * 3)


@given(seed=SEEDS, d=st.sampled_from([2, 3]), mass=st.integers(-6, 6), length=st.integers(-6, 6))
def test_units_change_nothing(seed, d, mass, length):
    rng = np.random.default_rng(seed)
    state = (scene if rng.random() < 0.7 else dense)(rng, d)
    (one, count), units = chosen(state), {"mass": 10.0**mass, "length": 10.0**length}
    other, again = chosen(state, **units)
    assert (again, other is None) == (count, one is None)
    if one is None:
        return
    if count is None:  # one of several, or of a continuum: rounding may lead to another
        choice_is_lawful(state, one)
        choice_is_lawful(state, other, **units)
        return
    assert labels(other) == labels(one)
    errors = one.solution.acceleration_errors + other.solution.acceleration_errors / units["length"]
    assert (np.abs(other.accelerations / units["length"] - one.accelerations) <= 1e-9 + errors).all()


def rod(theta):
    """W of a uniform rod's tip, of unit mass and half length, at an angle to the floor."""
    c, s = np.cos(theta), np.sin(theta)
    return np.array([[1 + 3 * c * c, -3 * c * s], [-3 * c * s, 1 + 3 * s * s]])


def sliding_rod(theta, mu, normal):
    return contact_problem(rod(theta), [normal, 0.3], [mu], sliding=[[-1.0]])


def halved(holds, low, high):
    """Where something begins to hold."""
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (low, middle) if holds(middle) else (middle, high)
    return high


@pytest.mark.parametrize(("mu", "first", "last"), [(1.4, 55.58581080789, 69.95186698409), (2.0, None, None)])
def test_painleve_rod(mu, first, last):
    """Sliding forward it jams where 1 + 3 cos θ (cos θ − μ sin θ) < 0."""
    # with t = tan θ that is t² − 3 μ t + 4 < 0
    roots = [np.degrees(np.arctan((3 * mu + sign * np.sqrt(9 * mu * mu - 16)) / 2)) for sign in (-1, 1)]
    middle = np.radians(sum(roots) / 2)

    def jams(theta):
        return bool(jamming(sliding_rod(theta, mu, -1.0)))

    found = np.degrees([halved(jams, 0.1, middle), -halved(lambda t: jams(-t), -1.5, -middle)])
    np.testing.assert_allclose(found, roots, rtol=0, atol=1e-9)
    if first is not None:
        np.testing.assert_allclose(found, [first, last], rtol=0, atol=1e-9)
    assert choose(sliding_rod(np.radians(roots[0] - 1e-9), mu, -1.0)).modes == (ContactStatus.SLIP,)
    with pytest.raises(ContactError, match=r"contact 0 slides .* Painlevé"):
        choose(sliding_rod(np.radians(roots[0] + 1e-6), mu, -1.0))
    both = choose(sliding_rod(middle, mu, 1.0))
    assert (both.count, both.jams) == (SolutionCount.SEVERAL, (0,))
    assert (both.modes, [s.modes for s in both.others]) == ((ContactStatus.OPEN,), [(ContactStatus.SLIP,)])
    assert choose(sliding_rod(middle, mu, 1.0), before=(ContactStatus.SLIP,)).modes == (
        ContactStatus.OPEN,
    )  # its slip diverges


def test_least_friction_that_jams_a_rod():
    def jams(theta):
        return halved(lambda mu: bool(jamming(sliding_rod(theta, mu, -1.0))), 0.1, 5.0)

    theta = np.arctan(2.0)
    assert jams(theta) == pytest.approx(4 / 3, abs=1e-12)
    assert min(jams(theta - 1e-3), jams(theta + 1e-3)) > 4 / 3 + 1e-7


@pytest.mark.parametrize("d", [2, 3])
@pytest.mark.parametrize("slope", [0.1, 0.3, 0.7])
def test_a_block_on_an_incline(d, slope):
    """It sticks up to tan α = μ, that included, and slides down with g (sin α − μ cos α) beyond."""
    g, mass, azimuth = 9.81, 2.0, 0.4
    down = np.array([1.0]) if d == 2 else np.array([np.cos(azimuth), np.sin(azimuth)])
    b = np.array([-g * np.cos(slope), *(g * np.sin(slope) * down)])
    for share, mode in ((1.01, ContactStatus.STICK), (1.0, ContactStatus.STICK), (0.5, ContactStatus.FRESH_SLIP)):
        mu = share * np.tan(slope)
        choice = choose(contact_problem(np.eye(d) / mass, b, [mu]))
        assert (choice.modes, choice.count) == ((mode,), SolutionCount.ONE)
        slides = g * (np.sin(slope) - mu * np.cos(slope)) if mode is ContactStatus.FRESH_SLIP else 0.0
        np.testing.assert_allclose(choice.accelerations, [0, *(slides * down)], atol=1e-13)
        assert choice.forces[0] == pytest.approx(mass * g * np.cos(slope))


def test_rest_and_slip_have_coefficients_of_their_own():
    """Between μ_k and μ_s a block that rests goes on to, and one that slides goes on to."""
    g = 9.81
    b, w = [-g, 0.5 * g], np.eye(2)
    assert choose(contact_problem(w, b, [0.6], kinetic=[0.4])).modes == (ContactStatus.STICK,)
    slides = choose(contact_problem(w, b, [0.6], kinetic=[0.4], sliding=[[2.0]]))
    assert slides.modes == (ContactStatus.SLIP,)
    begins = choose(contact_problem(w, b, [0.49], kinetic=[0.4]))
    assert begins.modes == (ContactStatus.FRESH_SLIP,)
    for choice in (slides, begins):
        np.testing.assert_allclose(choice.accelerations, [0, 0.1 * g], atol=1e-14)


def box(load):
    """W, b of a cube of unit mass on its four corners, with a horizontal load at its foot (2)."""
    normal, inverse = np.array([0.0, 0, 1]), np.diag([1, 1, 1, 6, 6, 6.0])
    rows = []
    for x, y in ((-1, -1), (-1, 1), (1, -1), (1, 1)):
        r = np.array([x, y, -1]) / 2
        rows += [np.concatenate([t, np.cross(r, t)]) for t in (normal, [1.0, 0, 0], [0, 1.0, 0])]
    jacobian, force = np.array(rows), np.array([*load, -9.81])
    return jacobian @ inverse @ jacobian.T, jacobian @ inverse @ [*force, *np.cross([0, 0, -0.5], force)]


@pytest.mark.parametrize("mu", [0.0, 0.3])
def test_a_pull_is_in_no_cone(mu):
    """The nearest forces of a cone to N < 0 are none where μ = 0, too: three posts under a plate, loaded beyond the edge of two."""
    cones = [Block(3 * i, 3, mu) for i in range(3)]
    pull = np.tile([-1.0, 0.0, 0.0], 3)
    np.testing.assert_array_equal(projected(cones, pull)[0], np.zeros(9))
    posts = [Block(i, 1, mu) for i in range(3)]
    rows = np.linalg.qr(np.array([[1.0, 1.0, 1.0], [-1.0, 0.0, 1.0]]).T)[0].T
    found = least_forces(posts, rows, np.array([-0.5, 1.0, 2.0]), np.zeros(3))
    assert found.forces is None or found.forces.min() >= 0
    beyond = np.array([-1.5, 1.0, 2.5])  # its moment is more than the sum can have
    assert least_forces(posts, rows, beyond, beyond).forces is None


def test_redundant_contacts_share_the_least_forces():
    w, b = box([0.0, 0.0])
    choice = choose(contact_problem(w, b, [0.5] * 4))
    assert choice.modes == (ContactStatus.STICK,) * 4
    assert choice.solution.rank < choice.solution.unknowns
    assert choice.solution.determined
    assert (choice.solution.rank, choice.solution.unknowns) == (6, 12)
    np.testing.assert_allclose(choice.forces, [9.81 / 4, 0, 0] * 4, atol=1e-12)


@pytest.mark.parametrize(("d", "k"), [(2, 1), (2, 5), (3, 1), (3, 2), (3, 4)])
def test_without_loads_nothing_happens(d, k):
    """Closed before open, stick before slip; no forces."""
    choice = choose(contact_problem(np.eye(d * k), np.zeros(d * k), [0.5] * k))
    assert choice.modes == (ContactStatus.STICK,) * k
    assert not choice.forces.any()
    assert not choice.accelerations.any()


@pytest.mark.parametrize("d", [2, 3])
def test_many_contacts_apart(d, rng):
    """Of bodies that do not touch each other each contact does what it does alone."""
    alone = []
    for _ in range(6):
        state = dense(rng, d)
        while len(state.static) > 1 or chosen(state)[1] != 1:
            state = dense(rng, d)
        alone.append(state)
    w = np.zeros((6 * d, 6 * d))
    for i, state in enumerate(alone):
        w[d * i : d * i + d, d * i : d * i + d] = state.W
    joined = [np.concatenate([getattr(s, name) for s in alone]) for name in ("b", "static", "kinetic", "sliding")]
    together = choose(contact_problem(w, *joined[:2], kinetic=joined[2], sliding=joined[3]))
    assert together.count is SolutionCount.UNKNOWN
    each = [chosen(state)[0] for state in alone]
    assert together.modes == sum((choice.modes for choice in each), ())
    np.testing.assert_allclose(together.forces, np.concatenate([choice.forces for choice in each]), atol=1e-9)


def test_a_ball_in_a_corner_where_any_direction_of_slip_is_aligned():
    """Two of three contacts slide; in one mode d⊥·a_t is zero whatever d is, and no force there is near its right sign."""
    rng = np.random.default_rng(357)
    scene(rng, 3)
    state = scene(rng, 3)
    assert (state.name, state.slides.sum()) == ("corner", 2)
    beside_enumeration(state)
    assert chosen(state)[1] == 1


@pytest.mark.parametrize("mu", [(0.0, 0.0), (1e-12, 1e-12), (1e-6, 1e-6), (0.4, 1e-7), (0.0, 0.4)])
def test_contacts_that_hardly_rub_begin_to_slip_along_their_accelerations(mu):
    """A block on an edge: no friction turns them."""
    rows = [np.concatenate([t, np.cross([0, y, -1], t)]) for y in (-1.0, 1.0) for t in np.eye(3)[[2, 0, 1]]]
    jacobian, force = np.array(rows), np.array([8.0, 1.0, -9.81, 0.0, 0.0, 0.3])
    every = enumerated(contact_problem(jacobian @ jacobian.T, jacobian @ force, mu))
    assert every.complete
    assert [s.modes for s in every.solutions] == [(ContactStatus.FRESH_SLIP,) * 2]
    (one,) = every.solutions
    a = one.accelerations.reshape(2, 3)
    np.testing.assert_allclose(a[:, 1:] / np.linalg.norm(a[:, 1:], axis=1, keepdims=True), one.directions, atol=1e-9)


def test_too_many_to_enumerate():
    one = contact_problem(*box([0.0, 0.0]), [0.5] * 4)
    with pytest.raises(ArgumentError, match=r"fewer contacts to enumerate their modes, got 4\. Use `choose`"):
        enumerated(one)


def test_a_box_that_is_pushed_slides():
    load, mu = np.array([3.0, 4.0]), 0.3
    w, b = box(load)
    choice = choose(contact_problem(w, b, [mu] * 4))
    assert choice.modes == (ContactStatus.FRESH_SLIP,) * 4
    slip = load * (1 - mu * 9.81 / 5)
    np.testing.assert_allclose(choice.accelerations.reshape(4, 3), [[0, *slip]] * 4, atol=1e-12)
    np.testing.assert_allclose(choice.directions, [load / 5] * 4, atol=1e-12)


@pytest.mark.parametrize("turns", [0.0, 0.3, 3.0])
def test_corners_that_slip_in_directions_of_their_own_have_one_answer(turns):
    """Their normal forces are not determined, and accelerations depend on them where directions differ."""
    w, b = box([0.0, 0.0])
    x, y = np.array([(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)]).T
    slips = np.column_stack([1 - turns * y, turns * x])
    sliding = slips / np.linalg.norm(slips, axis=1, keepdims=True)
    choice = choose(contact_problem(w, b, [0.3] * 4, sliding=sliding))
    assert choice.modes == (ContactStatus.SLIP,) * 4
    assert choice.solution.determined == (turns == 0.0)
    assert choice.count is (SolutionCount.UNKNOWN if turns else SolutionCount.ONE)
    assert not choice.others
    np.testing.assert_allclose(choice.forces[::3].sum(), 9.81, rtol=1e-12)


def test_a_box_between_walls_falls_or_jams():
    """Both are consistent; without forces is the first choice, to go on with what was is another."""
    normals, points = ([1.0, 0], [-1.0, 0]), ([-1.0, 0], [1.0, 0])
    rows = []
    for n, r in zip(normals, points, strict=True):
        t = [0.0, 1.0]
        rows += [[*n, r[0] * n[1] - r[1] * n[0]], [*t, r[0] * t[1] - r[1] * t[0]]]
    jacobian = np.array(rows)
    given = jacobian @ jacobian.T, jacobian @ [0, -9.81, 0], [0.5, 0.5]
    falls = choose(contact_problem(*given))
    assert falls.count is SolutionCount.SEVERAL
    np.testing.assert_allclose(falls.accelerations[1::2], -9.81)
    assert not falls.forces.any()
    assert not falls.solution.determined
    jams = choose(contact_problem(*given), before=(ContactStatus.STICK, ContactStatus.STICK))
    assert jams.modes == (ContactStatus.STICK, ContactStatus.STICK)
    np.testing.assert_allclose(jams.accelerations, 0, atol=1e-12)
    np.testing.assert_allclose(jams.forces[1::2], 9.81 / 2)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"friction": [-0.1]}, r"coefficients of friction μ_s ≥ 0"),
        ({"kinetic": [0.7]}, r"μ_k ≤ μ_s"),
        ({"bias": [1.0]}, r"2 or 3 of 1, got 1 of b.*normal, then tangents"),
        ({"bias": [np.nan, 1.0]}, r"finite"),
        ({"mobility": [[1.0, 0.5], [0.1, 1.0]]}, r"a symmetric mobility W"),
        ({"mobility": [[0.0, 0.0], [0.0, 1.0]]}, r"W_nn > 0.*Leave the contact out"),
        ({"mobility": np.eye(3)}, r"2 × 2 numbers, got an array of the shape \(3, 3\)"),
        ({"sliding": [[1.0, 0.0]]}, r"directions of slip, 1 × 1 numbers"),
        ({"terms": [0.1, 1.0]}, r"terms of b that are no smaller than b"),
        ({"friction": "much"}, r"coefficients of friction, one per contact, got 'much'"),
    ],
)
def test_what_is_no_problem(given, message):
    right = {"mobility": np.eye(2), "bias": [-1.0, 0.2], "friction": [0.5]}
    with pytest.raises(ArgumentError, match=message):
        contact_problem(**{**right, **given})


@pytest.mark.parametrize("k", [1, 2, 3])
@pytest.mark.parametrize("d", [2, 3])
def test_rows_that_rounding_alone_couples(k, d):
    """Bodies of their own, pressed and not pushed: all stick, whatever rounding leaves between their rows."""
    rng = np.random.default_rng(10 * k + d)
    for _ in range(60):
        w = np.diag((rng.uniform(1, 4, (k, d)) / 10 ** rng.uniform(-2, 2, (k, 1))).ravel())
        noise = 1e-14 * rng.normal(size=w.shape) * (rng.random(w.shape) < 0.5)
        w = w + (noise + noise.T) * np.sqrt(np.multiply.outer(np.diag(w), np.diag(w)))
        b = np.zeros(d * k)
        b[::d] = -9.81 * rng.uniform(0.1, 1, k)
        choice = choose(contact_problem(w, b, rng.uniform(0.01, 1, k)))
        assert choice.modes == (ContactStatus.STICK,) * k
        assert choice.count is SolutionCount.ONE


def test_contacts_are_told_by_name():
    c, s = np.cos(np.radians(60)), np.sin(np.radians(60))
    rod = [[1 + 3 * c * c, -3 * c * s], [-3 * c * s, 1 + 3 * s * s]]
    given = {"sliding": [[-1.0]], "kinetic": [2.0]}
    for names, told in (((), "contact 0 slides"), (("tip",), "tip slides")):
        with pytest.raises(ContactError, match=f"got none: {told} and its friction increases the normal force"):
            choose(contact_problem(rod, [-9.81, 0.0], [2.0], names=names, **given))


def test_modes_before_of_other_contacts():
    with pytest.raises(ArgumentError, match="before= as the earlier modes of all 1 contacts"):
        choose(contact_problem(np.eye(2), [-1.0, 0.2], [0.5]), before=(ContactStatus.OPEN, ContactStatus.OPEN))
