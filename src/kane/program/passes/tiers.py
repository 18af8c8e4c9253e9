# SPDX-License-Identifier: BSD-3-Clause
"""The last pass: code becomes a Program, its instructions sorted into tiers and ordered."""

from dataclasses import replace

from kane.program.passes.schedule import schedule
from kane.program.passes.verify import verified
from kane.program.program import Code, Program


def assembled(code: Code) -> Program:
    """The Program: what depends on parameters alone is hoisted, and each routine gets the rest of what it needs."""
    first, args = code.first, code.args
    routines = []
    read: set[int] = set()
    for routine in code.routines:
        body = code.below(set(routine.results), True)
        read.update(routine.results, *(args[i - first] for i in body))
        routines.append(replace(routine, body=schedule(body, routine.results, first, args)))
    hoisted = tuple(code.below(read, False))
    kept = tuple(i for i in hoisted if i in read)
    parts = (code.name, code.subject, code.ports, code.constants, code.ops, args)
    return verified(Program(*parts, tuple(routines), hoisted, kept))
