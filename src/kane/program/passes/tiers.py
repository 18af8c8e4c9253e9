# SPDX-License-Identifier: BSD-3-Clause
"""The last pass: a draft becomes a Program, its instructions sorted into tiers and ordered."""

from __future__ import annotations

from kane.program.draft import Draft
from kane.program.passes.schedule import schedule
from kane.program.passes.verify import verified
from kane.program.program import Program, Routine


def assembled(draft: Draft) -> Program:
    """The Program: what depends on parameters alone is hoisted, and each routine gets the rest of what it needs."""
    first, args = draft.first, draft.args
    routines = []
    read: set[int] = set()
    for goal in draft.goals:
        body = draft.below(set(goal.results), True)
        read.update(goal.results, *(args[i - first] for i in body))
        order = schedule(body, goal.results, first, args)
        routines.append(Routine(goal.name, goal.shape, goal.labels, goal.results, order))
    hoisted = tuple(draft.below(read, False))
    kept = tuple(i for i in hoisted if i in read)
    parts = (draft.name, draft.subject, draft.ports, draft.constants, draft.ops, args)
    return verified(Program(*parts, hoisted, kept, tuple(routines)))
