# SPDX-License-Identifier: BSD-3-Clause
"""The runs of the right-hand-side benchmark as Markdown, and which targets hold in every run."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

Run = Mapping[str, Any]
DASH = "–"

_HOISTING = "kane, parameter tier at every call"


def _ratio(case: str, name: str) -> Callable[[Run], float]:
    return lambda run: float(run["native"][case]["ratio to CasADi C"][name]["median"])


# What is asked, the figure of a run, the bound.
TARGETS: tuple[tuple[str, Callable[[Run], float], float], ...] = (
    ("10 rods, native: kane / CasADi C", _ratio("pendulum, 10 rods", "kane"), 1.0),
    ("10 rods, native: kane / CasADi C, goal", _ratio("pendulum, 10 rods", "kane"), 0.7),
    ("10 rods, native, parameter tier at every call: kane / CasADi C", _ratio("pendulum, 10 rods", _HOISTING), 1.0),
    ("2 rods, native: kane / CasADi C", _ratio("pendulum, 2 rods", "kane"), 1.0),
    ("2 rods, native: kane / CasADi C, goal", _ratio("pendulum, 2 rods", "kane"), 0.7),
    ("2 rods, native, parameter tier at every call: kane / CasADi C", _ratio("pendulum, 2 rods", _HOISTING), 1.0),
    (
        "10 rods: a Python call over the native time, µs",
        lambda run: float(run["python"]["pendulum, 10 rods"]["us over native"]["median"]),
        1.2,
    ),
    (
        "10 rods: cold compile, s",
        lambda run: float(run["compile"]["rods"]["10"]["seconds"]["median"]),
        0.15,
    ),
    ("20, 40, 80 rods: compile time as a power of operations", lambda run: float(run["compile"]["exponent"]), 1.15),
)


def targets(runs: Sequence[Run]) -> list[dict[str, Any]]:
    """Each target's figure in each run; it holds when it does in all. None where kane was left out."""
    if any("compile" not in run for run in runs):
        return []
    found = []
    for what, figure, bound in TARGETS:
        figures = [figure(run) for run in runs]
        found.append({"target": what, "bound": bound, "runs": figures, "holds": all(f <= bound for f in figures)})
    return found


def spread(s: Mapping[str, float] | None, digits: int = 1) -> str:
    """Median and range; a dash where there are none."""
    if s is None:
        return DASH
    return f"{s['median']:.{digits}f} ({s['min']:.{digits}f} … {s['max']:.{digits}f})"


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A Markdown table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def _contenders(run: Run, part: str, unit: str) -> list[str]:
    """Names in order of first appearance."""
    return list(dict.fromkeys(name for case in run[part].values() for name in case[unit]))


def _by_run(runs: Sequence[Run], part: str, unit: str, digits: int) -> str:
    cases = list(runs[0][part])
    rows = [
        [name if k == 0 else "", str(k + 1), *(spread(run[part][case][unit].get(name), digits) for case in cases)]
        for name in _contenders(runs[0], part, unit)
        for k, run in enumerate(runs)
    ]
    return table(["", "run", *cases], rows)


def _ratios(runs: Sequence[Run]) -> str:
    name = "ratio to CasADi C"
    return "\n\nkane's time as a fraction of CasADi's C, round by round:\n\n" + _by_run(runs, "native", name, 2)


def _overheads(runs: Sequence[Run]) -> str:
    rows = [[case, *(spread(run["python"][case]["us over native"], 2) for run in runs)] for case in runs[0]["python"]]
    head = ["kane's call over its native time, µs", *(f"run {k + 1}" for k in range(len(runs)))]
    return "\n\n" + table(head, rows)


def _compiles(runs: Sequence[Run]) -> str:
    rows = [
        [n, str(entry["operations"]), *(spread(run["compile"]["rods"][n]["seconds"], 3) for run in runs)]
        for n, entry in runs[0]["compile"]["rods"].items()
    ]
    rows.append(["exponent, 20 to 80", "", *(f"{run['compile']['exponent']:.2f}" for run in runs)])
    head = ["rods", "operations", *(f"run {k + 1}" for k in range(len(runs)))]
    return "kane, cold, a fresh process each, the cache off, s:\n\n" + table(head, rows) + "\n\n"


def _peer_compiles(runs: Sequence[Run]) -> str:
    text = ", ".join(f"{n} rods {seconds:.2f} s" for n, seconds in runs[0]["peer compile"].items())
    return f"CasADi, from nothing to compiled C: {text}.\n"


def _targets(found: Sequence[Mapping[str, Any]]) -> str:
    rows = [
        [t["target"], f"≤ {t['bound']:g}", ", ".join(f"{f:.3g}" for f in t["runs"]), "yes" if t["holds"] else "**no**"]
        for t in found
    ]
    return "\n## Targets\n\n" + table(["", "bound", "medians of the runs", "holds in both"], rows) + "\n"


def document(record: Mapping[str, Any]) -> str:
    """The whole page."""
    runs = record["runs"]
    kane = bool(record["targets"])
    named = ", ".join(f"{name} {number}" for name, number in record["versions"].items())
    operations = ", ".join(
        f"{name} {case['operations']['state']} + {case['operations']['parameter']}"
        for name, case in runs[0]["native"].items()
    )
    return (
        "# Right-hand sides\n\n"
        f"{record['processor']}; {record['compiler']}, `{record['flags']}`; {named}. Median (least … greatest) of "
        f"{record['rounds']} rounds in which all contenders of a column take turns in one process; each run is a process of its "
        "own. Masses, lengths and g are inputs at run time on every side, and every result is the whole state derivative "
        "(q̇, u̇), compared with kane's reference evaluator to 1e-9 first; Pinocchio and MuJoCo give relative accelerations "
        "alone. CasADi C is Kane's method by hand and differentiation with a symbolic LDLᵀ; the recursions are another "
        "formulation. By default kane's parameter tier runs once for a set of parameters.\n\n"
        f"kane's operations, with the state + of parameters: {operations}.\n\n"
        "## Native, ns a call\n\n"
        + _by_run(runs, "native", "ns", 1)
        + (_ratios(runs) if kane else "")
        + "\n\n## From Python, µs a call\n\n"
        + _by_run(runs, "python", "us", 2)
        + (_overheads(runs) if kane else "")
        + "\n\n## Compile times\n\n"
        + (_compiles(runs) if kane else "")
        + _peer_compiles(runs)
        + (_targets(record["targets"]) if kane else "")
    )
