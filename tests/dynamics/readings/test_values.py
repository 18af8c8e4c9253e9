# SPDX-License-Identifier: BSD-3-Clause
"""Numbers of expressions at a state: asked for once, again, and forgotten."""

import gc
import weakref

import numpy as np
import pytest

import kane as kn
from benchmarks.systems import arm


@pytest.fixture(scope="module")
def robot():
    return kn.derive(arm("zyz"))


def by_forces(eom, q, u):
    """u̇ from M u̇ = f in numbers."""
    at = {**dict(zip(eom.coordinates, q, strict=True)), **dict(zip(eom.speeds, u, strict=True))}
    return np.linalg.solve(kn.evaluate(eom.mass_matrix, at), kn.evaluate(list(eom.forcing), at))


def test_accelerations_asked_for_again_with_other_numbers(robot, rng):
    for _ in range(4):
        q, u = rng.normal(size=(2, 3))
        assert robot.evaluate(robot.accelerations, q=q, u=u) == pytest.approx(by_forces(robot, q, u), rel=1e-9)


def test_parameters_and_kinds_of_numbers_may_change_between_calls(robot, rng):
    q, u = rng.normal(size=(2, 3))
    one = robot.evaluate(robot.accelerations, q=q, u=u)
    heavy = robot.evaluate(robot.accelerations, q=q, u=u, parameters={"m3": 2.0})
    many = robot.evaluate(
        robot.accelerations, q=[[x, x] for x in q], u=[[x, x] for x in u], parameters={"m3": [1.0, 2.0]}
    )
    assert np.array(many) == pytest.approx(np.stack([one, heavy], axis=1), rel=1e-12)
    assert robot.evaluate(robot.accelerations, q=q.tolist(), u=u.tolist()) == one


def test_one_expression_is_the_same_as_all(robot, rng):
    q, u = rng.normal(size=(2, 3))
    assert robot.evaluate(robot.accelerations[1], q=q, u=u) == robot.evaluate(robot.accelerations, q=q, u=u)[1]


def test_arrays_that_do_not_fit_are_named(robot):
    with pytest.raises(kn.ArgumentError, match=r"shapes broadcast, got \(2,\) for q2, \(3,\) for u2\. Give each"):
        robot.evaluate(robot.accelerations, q=[0.3, [0.1, 0.2], 0.4], u=[0.1, [0.1, 0.2, 0.3], 0.3])


@pytest.mark.parametrize("given", [np.complex128(1j), np.array([1j]), np.ma.array([1.0, 2.0], mask=[0, 1]), None])
def test_what_is_no_real_number_is_named(robot, given):
    with pytest.raises(kn.ExpressionError, match="Expected a real number or an array of them as a value"):
        robot.evaluate(robot.accelerations, q=[0.1, given, 0.4], u=[0.1, 0.2, 0.3])
    if np.size(given) == 1:
        with pytest.raises(kn.SimulationError, match="Expected a number as the start value for q2"):
            kn.simulate(robot, (0, 1), q=[0.1, given, 0.4], u=0)


def test_a_missing_value_is_named_at_every_call(robot):
    for _ in range(2):
        with pytest.raises(kn.ValueMissingError, match="got none for q"):
            robot.evaluate(robot.accelerations, u=[0.3, 0.4, 0.5])


@pytest.mark.slow
def test_what_was_evaluated_goes_with_the_equations():
    eom = kn.derive(arm("zy"))
    eom.evaluate(eom.accelerations, q=[0.1, 0.2], u=[0.3, 0.4])
    (reading,) = eom.solved.readings.values()
    gone = weakref.ref(reading.walk), weakref.ref(eom)
    del reading, eom
    gc.collect()
    assert [r() for r in gone] == [None, None]


def test_no_more_than_some_are_kept():
    eom = kn.derive(arm("zy"))
    for k in range(100):
        assert eom.evaluate(eom.speeds[0] * k, u=[2.0, 1.0]) == 2 * k
    assert len(eom.solved.readings.values()) < 100
