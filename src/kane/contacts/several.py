# SPDX-License-Identifier: BSD-3-Clause
"""Impacts of several contacts at one instant, sequential or simultaneous.

SEQUENTIAL: one contact at a time by Routh's method, the fastest approach first, ties by index, until none approaches. SIMULTANEOUS:
all that approach at once, v_n⁺ ≥ −e v_n⁻, with friction impulses that oppose the slip after the impact (Moreau 1988): Newton's law.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any, NamedTuple

import numpy as np

from kane.contacts.choice import ModeChoice, choose
from kane.contacts.problem import ContactProblem, contact_problem, numbers
from kane.contacts.routh import ContactImpact, Law, check_laws, routh, warn_of_gain
from kane.errors import ArgumentError
from kane.expect import is_number, that
from kane.numeric.arrays import Array, Entries
from kane.numeric.scale import ROUNDED, ROUNDED_CHAIN

_MOST = 100
"""Largest number of impacts of a sequence, over k²; then the remaining approach ends without restitution."""

_NOTHING = math.sqrt(np.finfo(float).tiny)
"""Velocities below this, whose squares underflow, are set to zero: projections may leave such values at sticking contacts."""


class Rule(Enum):
    """The order of impacts."""

    SEQUENTIAL = "one after the other, the fastest first"
    SIMULTANEOUS = "all at once"


class Hit(NamedTuple):
    """An impact of a sequence, with the index of its contact."""

    contact: int
    impact: ContactImpact


@dataclass(frozen=True, slots=True, eq=False)
class Impacts:
    """The result of impacts of k contacts.

    Attributes
    ----------
    velocity : v⁺ (dk)
    impulse : p (dk), the sum of all
    energy : change of the kinetic energy
    hits : the impacts of a sequence, in order
    at_once : the choice of modes of contacts that close together: if SIMULTANEOUS, in the first impact; if a sequence reaches the
        largest number of impacts, in the last one, without restitution; else None
    rule, law : the rule and the law of restitution; `law` is Newton's if SIMULTANEOUS
    """

    velocity: Array
    impulse: Array
    energy: float
    hits: tuple[Hit, ...]
    at_once: ModeChoice | None
    rule: Rule
    law: Law


def impacts(
    mobility: Any,
    velocity: Any,
    friction: Any,
    restitution: Any,
    *,
    law: Law | None = None,
    rule: Rule = Rule.SEQUENTIAL,
    terms: Any = None,
    names: Sequence[str] = (),
) -> Impacts:
    """The velocities of k contacts after impacts of those that approach; contacts at rest take part if impacts make them approach.

    Parameters
    ----------
    mobility : W = J M⁻¹ Jᵀ (dk × dk), each contact's normal first
    velocity : v⁻ = J u (dk)
    friction : μ of each contact (k)
    restitution : e of each contact (k), or one for all
    law : the law of restitution; Stronge's unless given, Newton's if SIMULTANEOUS
    rule : the order of impacts
    terms : sums of the magnitudes of the terms of v (dk); the largest |v| unless given
    names : names of the contacts, for messages

    Raises
    ------
    ArgumentError
        as `impact` and `contact_problem`, and if SIMULTANEOUS with a law other than Newton's
    ContactError
        if no impulses satisfy the laws of friction where contacts close together

    Warns
    -----
    KaneWarning
        if energy is gained, as by Newton's law with friction
    """
    v = numbers(velocity, "velocities with the rows of all contacts", 1)
    v[np.abs(v) < _NOTHING] = 0.0
    size = np.full(len(v), np.abs(v).max(initial=0)) if terms is None else terms
    problem = contact_problem(mobility, v, friction, terms=size, names=names)
    given = np.full(problem.count, restitution) if is_number(restitution) else restitution
    e = numbers(given, "coefficients of restitution, one per contact", 1, (problem.count,))
    that(isinstance(rule, Rule), "a rule: Rule.SEQUENTIAL or SIMULTANEOUS", rule, error=ArgumentError)
    together = rule is Rule.SIMULTANEOUS
    that(
        not together or law in (None, Law.NEWTON),
        "Law.NEWTON where impacts are simultaneous",
        law,
        "Take Rule.SEQUENTIAL for the other laws.",
        error=ArgumentError,
    )
    law = law or (Law.NEWTON if together else Law.STRONGE)
    for mu, share in zip(problem.static, e, strict=True):
        check_laws(float(mu), float(share), law)
    result = _together(problem, e) if together else _sequence(problem, e, law)
    warn_of_gain(result.energy, float(np.abs(result.impulse) @ problem.terms), law)
    return result


def _together(problem: ContactProblem, e: Array) -> Impacts:
    """Simultaneous impacts of contacts that approach or are at rest; repeated while the impulses make other contacts approach."""
    d, k, w = problem.dimension, problem.count, problem.mobility
    v, p, terms, first = problem.bias, np.zeros(d * k), problem.terms, None
    for _ in range(_MOST * k * k):
        normal, rounding = v[::d], ROUNDED * terms[::d]
        if first is not None and not (normal < -rounding).any():
            break
        parts = np.flatnonzero(normal <= rounding) if (normal <= rounding).any() else np.arange(k)
        choice = _thrown(problem, v, terms, e, parts)
        first = first or choice
        rows = (d * parts[:, None] + np.arange(d)).ravel()
        p[rows] += choice.forces
        v, terms = v + w[:, rows] @ choice.forces, terms + np.abs(w[:, rows]) @ np.abs(choice.forces)
    else:
        choice = _thrown(problem, v, terms, np.zeros(k), np.arange(k))
        v, p = v + w @ choice.forces, p + choice.forces
    return Impacts(v, p, float(p @ (problem.bias + v)) / 2, (), first, Rule.SIMULTANEOUS, Law.NEWTON)


def _thrown(problem: ContactProblem, v: Array, terms: Array, e: Array, parts: Entries) -> ModeChoice:
    """The simultaneous impulses, as forces, of the contacts `parts`, with v_n⁺ ≥ −e v_n⁻."""
    d = problem.dimension
    rows = (d * parts[:, None] + np.arange(d)).ravel()
    asked = v[rows].copy()
    asked[::d] += e[parts] * np.minimum(asked[::d], 0.0)
    size, names = terms[rows] + np.abs(asked), [problem.name(int(i)) for i in parts]
    w = problem.mobility[np.ix_(rows, rows)]
    return choose(contact_problem(w, asked, problem.static[parts], terms=size, names=names))


def _sequence(problem: ContactProblem, e: Array, law: Law) -> Impacts:
    """Sequential impacts."""
    d, k, w = problem.dimension, problem.count, problem.mobility
    v, p, terms, hits, at_once = problem.bias, np.zeros(d * k), problem.terms, list[Hit](), None
    for _ in range(_MOST * k * k):
        closing = np.where(v[::d] < -ROUNDED * terms[::d], -v[::d], 0.0)
        fastest = closing.max()
        if fastest <= 0:
            break
        i = int(np.flatnonzero(closing >= (1 - ROUNDED_CHAIN) * fastest)[0])
        rows = slice(d * i, d * i + d)
        hit = routh(w[rows, rows], v[rows], float(problem.static[i]), float(e[i]), law)
        v, terms = v + w[:, rows] @ hit.impulse, terms + np.abs(w[:, rows]) @ np.abs(hit.impulse)
        v[rows] = hit.velocity
        p[rows] += hit.impulse
        hits.append(Hit(i, hit))
    else:
        at_once = choose(contact_problem(w, v, problem.static, terms=terms, names=problem.names))
        v, p = at_once.accelerations, p + at_once.forces
    energy = float(p @ (problem.bias + v)) / 2
    return Impacts(v, p, energy, tuple(hits), at_once, Rule.SEQUENTIAL, law)
