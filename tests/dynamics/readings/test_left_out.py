# SPDX-License-Identifier: BSD-3-Clause
"""Rows left out as redundant on one branch of a mechanism hold something on another: that is said, never passed over."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import kane as kn
from kane.dynamics import concerned, configurations, nan_where_more, ranks
from kane.equations import program
from kane.gallery import bricard
from tests.program.emitted import from_c, from_numpy


def quietly(system, **more):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", kn.KaneWarning)
        return kn.derive(system, **more)


@pytest.fixture(scope="module")
def both():
    """Bricard's linkage derived on its moving branch, where one row is redundant, and on one where two are; a state on the first."""
    system = bricard.system(redundant=True)
    eom = quietly(system)
    found = configurations(system, eom.A.entries)
    k = int(np.argmin(ranks(found.matrices(eom.A))))
    other = quietly(system, near={q: found.at(k)[q] for q in system.coordinates})
    state = kn.assemble(eom, q={"q1": 0.3, **{f"q{k}": kn.guess(0.1) for k in range(2, 6)}}, u={"u1": 1.0})
    assert (len(eom.redundant), len(other.redundant)) == (1, 2)
    return eom, other, state


TOLD = r"got 'last \w+ \w', 'last \w+ \w', which were left out as redundant and restrict the motion"


def test_at_a_state(both):
    eom, other, state = both
    with pytest.raises(kn.SingularError, match=rf"{TOLD}.*kn\.derive\(system, near=…\) of this configuration"):
        other.evaluate(other.accelerations, q=state.q, u=state.u)
    cured = quietly(eom.system, near=state.q)
    for x in (eom, cured):
        found = x.evaluate(x.accelerations, q=state.q, u=state.u)
        np.testing.assert_allclose(found, eom.evaluate(eom.accelerations, q=state.q, u=state.u), rtol=1e-9)


def test_of_arrays(both):
    _, other, state = both
    with pytest.warns(kn.KaneWarning, match=rf"{TOLD} at index 0 and 1 more: the values there are NaN"):
        found = other.evaluate(other.accelerations[:2], q={q: [x, x] for q, x in state.q.items()}, u=state.u)
    assert np.isnan(found).all()


def test_what_was_not_solved_for_is_told(both):
    _, other, state = both
    a = other.evaluate(other.A, q=state.q)
    assert np.linalg.matrix_rank(a, 1e-9) == 4


COMPILED = r"got 'last \w+ \w', which was left out as redundant and holds more at this state: .* u1', .*NaN"


def numbers(eom, state):
    return np.array([*(state.q[q] for q in eom.coordinates), *(state.u[u] for u in eom.speeds)])


def test_in_compiled_code(both):
    eom, other, state = both
    x = numbers(eom, state)
    run = kn.compile(other, not_finite="raise")
    with pytest.raises(kn.NotFiniteError, match=COMPILED):
        run.rhs(0.0, x)
    found = kn.compile(other, not_finite="ignore").rhs(0.0, np.array([x] * 5))
    np.testing.assert_allclose(found[:, :5], np.array([x[5:]] * 5))
    assert np.isnan(found[:, 5:]).all()
    assert "'last hinge" in run.emit("c", "rhs")


@pytest.mark.slow
def test_in_emitted_code_and_outputs(both, tmp_path):
    """Where a row holds more every language says NaN, where it follows the numbers are those of `evaluate`."""
    eom, other, state = both
    x = numbers(eom, state)
    for derived, right in ((eom, True), (other, False)):
        made, folder = program(derived.solved, ("rhs",), name="loop"), tmp_path / str(right)
        folder.mkdir()
        run = kn.compile(derived, not_finite="ignore", outputs={"a": derived.accelerations[0], "q": eom.coordinates[0]})
        p = [s.default for s in made.port("p").symbols]
        c, python = from_c(made, folder, True), from_numpy(made, folder)
        wanted = eom.evaluate(eom.accelerations, q=state.q, u=state.u) if right else np.full(5, np.nan)
        every = np.array([x] * 5)
        for found in (
            run.rhs(0.0, x),
            c("rhs", [np.array([0.0, *x, *p])])[0],
            *(python.rhs(0.0, y) for y in (x, every)),
        ):
            np.testing.assert_allclose(found.reshape(-1, 10)[-1, 5:], wanted, rtol=1e-9)
        outputs = run.outputs(0.0, x)
        assert bool(np.isfinite(outputs["a"])) == right
        assert outputs["q"] == x[0]


def test_it_costs_nothing_where_no_row_is_left_out(both):
    _, other, _ = both
    plain = kn.derive(bricard.system())
    assert plain.solved.left_out is None
    assert nan_where_more(plain.solved, plain.accelerations, plain.accelerations) is plain.accelerations
    assert concerned(plain.solved, plain.accelerations) == ()
    assert concerned(other.solved, (*other.accelerations, *other.coordinates)) == tuple(range(5))


@pytest.mark.slow
def test_a_simulation_takes_the_rows_that_hold_more(both):
    eom, other, state = both
    right, same = (kn.simulate(x, (0, 0.3), q=state.q, u=state.u, rtol=1e-10, atol=1e-10) for x in (eom, other))
    np.testing.assert_allclose(same.states[-1], right.states[-1], atol=1e-8)
