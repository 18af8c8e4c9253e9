# SPDX-License-Identifier: BSD-3-Clause
"""The runs of the benchmark of calls as Markdown, and which targets hold in every run."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from benchmarks.rhs_table import spread, table

Run = Mapping[str, Any]
FEW, MANY = 8, 10_000
"""Rows of a batch."""
SINGLE, BY_NAME, INPUT = "one state", "all parameters by name", "an input by name"
ROWS, LONG, JAC = f"{FEW} rows", f"{MANY:,} rows", "Jacobian"
PARTS = (SINGLE, ROWS, LONG, JAC)
OVER = "over its evaluations"


def _over(part: str, kind: str = "kane") -> Callable[[Run, str], float]:
    return lambda run, case: float(run[case][OVER][part][kind]["median"])


# What is asked, the figure of a run and a case, the bound in µs.
TARGETS: tuple[tuple[str, Callable[[Run, str], float], float], ...] = (
    ("a call over its evaluation, µs", _over(SINGLE), 1.2),
    ("a call with all parameters by name over its evaluation, µs", _over(SINGLE, f"kane, {BY_NAME}"), 3.0),
    (f"a batch of {FEW} rows over its evaluations, µs", _over(ROWS), 10.0),
)


def targets(runs: Sequence[Run]) -> list[dict[str, Any]]:
    """Each target's figure in each run and case; it holds when it does in all."""
    found = []
    for what, figure, bound in TARGETS:
        for case in runs[0]:
            figures = [figure(run, case) for run in runs]
            holds = all(f <= bound for f in figures)
            found.append({"target": f"{case}: {what}", "bound": bound, "runs": figures, "holds": holds})
    return found


def _part(runs: Sequence[Run], part: str) -> str:
    cases = list(runs[0])
    names = list(dict.fromkeys(name for case in cases for name in runs[0][case]["us"][part]))
    rows = [
        [name if k == 0 else "", str(k + 1), *(spread(run[case]["us"][part].get(name), 2) for case in cases)]
        for name in names
        for k, run in enumerate(runs)
    ]
    return table(["", "run", *cases], rows)


def _targets(found: Sequence[Mapping[str, Any]]) -> str:
    rows = [
        [t["target"], f"≤ {t['bound']:g}", ", ".join(f"{f:.3g}" for f in t["runs"]), "yes" if t["holds"] else "**no**"]
        for t in found
    ]
    return table(["", "bound", "medians of the runs", "holds in all"], rows)


def document(record: Mapping[str, Any]) -> str:
    """The whole page."""
    named = ", ".join(f"{name} {number}" for name, number in record["versions"].items())
    parts = "\n\n".join(f"## {part[0].upper()}{part[1:]}, µs a call\n\n{_part(record['runs'], part)}" for part in PARTS)
    return (
        "# Calls from Python\n\n"
        f"{record['processor']}; {named}. Median (least … greatest) of {record['rounds']} rounds in which all contenders "
        "of a table take turns in one process, in processor time; each run is a process of its own. Masses, lengths and g are "
        "inputs at run time on every side; every result is compared with kane's reference evaluator to 1e-9 first. kane looks for "
        "NaN and infinity in arguments and results and returns a new array; CasADi's buffers, heyoka's `outputs=` and Pinocchio's "
        "data are written to in place. CasADi takes rows as columns of a matrix. Pinocchio's Jacobian is "
        "`computeABADerivatives` in relative angles.\n\n"
        f"{parts}\n\n## Targets\n\n{_targets(record['targets'])}\n"
    )
