# SPDX-License-Identifier: BSD-3-Clause
"""Rows of constraints at numbers, by kinematics alone."""

from __future__ import annotations

import numpy as np

import kane as kn
from kane.kinematics import Kinematics, Sample, constraint_rows, generalized_speeds


def unit_euler_parameters(system, values):
    for s in system.euler_parameters:
        size = np.sqrt(sum(values[e] ** 2 for e in s.coordinates))
        for e in s.coordinates:
            values[e] /= size


def random_values(system, seed):
    rng = np.random.default_rng(seed)
    values = {s: rng.uniform(-1.0, 1.0) for s in (*system.coordinates, *system.speeds)}
    unit_euler_parameters(system, values)
    return values | {kn.time: rng.uniform(0, 1)}


def power_and_rate(system, seed):
    """For each constraint, A u + b from the forces' power, and its rate (a motion constraint: itself) from its expression.

    Then Ȧ u + ḃ and the derivative, at constant speeds, of that expression.
    """
    speeds = generalized_speeds(system)
    kinematics = Kinematics(speeds, {}, Sample(speeds))
    rows = constraint_rows(system.constraints, kinematics, ())
    u = list(system.speeds)
    power = [sum((x * s for x, s in zip(row, u, strict=True)), start=b) for row, b in zip(rows.a, rows.b, strict=True)]
    rates = [
        speeds.in_speeds(kn.time_derivative(c.expr) if c.kind == "configuration" else c.expr, {})
        for c in system.constraints
    ]
    exprs = [*power, *rates, *rows.drift, *map(kinematics.drift, rates)]
    found = np.array(kn.evaluate(exprs, random_values(system, seed)), dtype=float)
    return found.reshape(4, len(rates))


def rank(system, seed):
    speeds = generalized_speeds(system)
    rows = constraint_rows(system.constraints, Kinematics(speeds, {}, Sample(speeds)), ())
    numbers = kn.evaluate([x for row in rows.a for x in row], random_values(system, seed))
    return np.linalg.matrix_rank(np.array(numbers, dtype=float).reshape(len(rows.a), -1), tol=1e-9)
