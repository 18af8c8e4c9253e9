# SPDX-License-Identifier: BSD-3-Clause
"""A Solution in a notebook: how it ended, whether energy was kept, the first and last state."""

from kane.motion.solution.solution import Solution
from kane.present.notebook.typeset import either, escaped, listed, math, paragraph, table
from kane.units.rules import unit_text
from kane.write.latex import latex_name


def solution_html(solution: Solution) -> str:
    """Summary, energy check, events, first and last state."""
    return "".join(either(make, solution) for make in (_summary, _energy, _events, _states))


def _summary(solution: Solution) -> str:
    bodies = listed([b.name for b in solution.equations.system.bodies])
    span = f"t = {solution.t[0]:g} … {solution.t[-1]:g} s" if len(solution) else "no samples"
    counts = f"{len(solution)} samples, {solution.steps} steps, {solution.evaluations} evaluations"
    ended = f"{escaped(solution.status)}: {escaped(solution.message)}"
    return paragraph(f"<b>Solution</b>: {bodies}; {span}") + paragraph(f"{counts}; {ended}")


def _energy(solution: Solution) -> str:
    words = str(solution.energy_check)
    return paragraph(escaped(f"{words[:1].upper()}{words[1:]}."))


def _events(solution: Solution) -> str:
    rows = [(escaped(event.name), f"{t:.6g} s", escaped(event.message)) for event, t in solution.events]
    return table(("event", "at", "message"), rows)


def _states(solution: Solution) -> str:
    if not len(solution):
        return ""
    eom = solution.equations
    rows = [
        (math(latex_name(s.name)), f"{a:.6g}", f"{b:.6g}", escaped(unit_text(s.unit)), escaped(s.description))
        for s, a, b in zip(eom.state, solution.states[0], solution.states[-1], strict=True)
    ]
    return table(("", f"t = {solution.t[0]:g} s", f"t = {solution.t[-1]:.6g} s", "unit", "meaning"), rows)
