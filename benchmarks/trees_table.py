# SPDX-License-Identifier: BSD-3-Clause
"""The runs of the benchmark of trees as Markdown, and which targets hold in every run."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from benchmarks.rhs_table import spread, table

Run = Mapping[str, Any]

_ABSOLUTE, _RELATIVE = "planar chain, absolute angles", "planar chain, relative angles"
_LIMBS = "four limbs of six joints on a floating base"


def _over(case: str, *peers: str) -> Callable[[Run], float]:
    """The faster peer's time over kane's."""
    return lambda run: min(float(run["native"][case]["over kane"][peer]["median"]) for peer in peers)


def _microseconds(case: str) -> Callable[[Run], float]:
    return lambda run: float(run["native"][case]["ns"]["kane"]["median"]) / 1e3


def _derivatives(case: str, ratio: str) -> Callable[[Run], float]:
    return lambda run: float(run["derivatives"][case]["ratios"][ratio]["median"])


def _cold(name: str, n: int) -> Callable[[Run], float]:
    return lambda run: sum(float(run["growth"][name]["rows"][str(n)][key]) for key in ("derive", "compile"))


def _power(name: str, key: str) -> Callable[[Run], float]:
    return lambda run: float(run["growth"][name]["powers"][key])


_PINOCCHIO = ("Pinocchio aba", "Pinocchio aba, local")
_SPATIAL = "spatial chain"
_CHAIN = f"{_SPATIAL}, 100"
_GENERAL = ", every number a parameter"

# What is asked, the figure of a run, the bound, and whether that is the least one.
TARGETS: tuple[tuple[str, Callable[[Run], float], float, bool], ...] = (
    *(
        (
            f"{_ABSOLUTE}, {n}: CasADi's recursion in C / kane",
            _over(f"{_ABSOLUTE}, {n}", "CasADi C, recursion"),
            1 / b,
            True,
        )
        for n, b in ((10, 0.6), (40, 0.75), (100, 0.6))
    ),
    *(
        (f"{_RELATIVE}, {n}: Pinocchio / kane", _over(f"{_RELATIVE}, {n}", *_PINOCCHIO), 10.0, True)
        for n in (10, 40, 100)
    ),
    *(
        (f"{_RELATIVE}, {n}: MuJoCo / kane", _over(f"{_RELATIVE}, {n}", "MuJoCo mj_forward"), 6.0, True)
        for n in (10, 40, 100)
    ),
    *(
        (f"{case}{given}: Pinocchio / kane", _over(f"{case}{given}", *_PINOCCHIO), bound, True)
        for case, bound in (("7R arm, general axes", 5.5), ("tree of 20 bodies", 10.0), (_LIMBS, 3.3), (_LIMBS, 8.0))
        for given in ("", _GENERAL)
    ),
    *(
        (f"{case}: derivatives / right-hand side", _derivatives(case, "jac / rhs"), 4.0, False)
        for case in ("7R arm", "7R arm, general axes")
    ),
    *(
        (f"{case}: Pinocchio's derivatives / kane's", _derivatives(case, "Pinocchio derivatives / jac"), 1.0, True)
        for case in ("7R arm", "7R arm, general axes", "tree of 20 bodies", _LIMBS)
    ),
    *((f"{_CHAIN}{given}: µs", _microseconds(f"{_CHAIN}{given}"), 10.0, False) for given in ("", _GENERAL)),
    *(
        (f"{_ABSOLUTE}, {n}: derived and compiled, s", _cold(_ABSOLUTE, n), b, False)
        for n, b in ((10, 0.1), (40, 0.3), (100, 0.8))
    ),
    (f"{_CHAIN}: derived and compiled, s", _cold(_SPATIAL, 100), 3.0, False),
    *(
        (f"{name}, 50 to 400: power of n of {key}", _power(name, key), 1.15, False)
        for name in (_ABSOLUTE, _SPATIAL)
        for key in ("derive", "compile", "evaluation")
    ),
)


def targets(runs: Sequence[Run]) -> list[dict[str, Any]]:
    """Each target's figure in each run; it holds when it does in all."""
    found = []
    for what, figure, bound, least in TARGETS:
        figures = [figure(run) for run in runs]
        holds = all(f >= bound if least else f <= bound for f in figures)
        found.append({"target": what, "bound": bound, "least": least, "runs": figures, "holds": holds})
    return found


def _native(runs: Sequence[Run]) -> str:
    names = list(dict.fromkeys(name for case in runs[0]["native"].values() for name in case["ns"]))
    rows = []
    for case, first in runs[0]["native"].items():
        operations = f"{first['operations']['state']} + {first['operations']['parameter']}"
        for k, run in enumerate(runs):
            figures = (spread(run["native"][case]["ns"].get(name), 0) for name in names)
            rows.append([f"{case} ({operations}, {first['route']})" if k == 0 else "", str(k + 1), *figures])
    return table(["", "run", *names], rows)


def _ratios(runs: Sequence[Run]) -> str:
    names = list(dict.fromkeys(name for case in runs[0]["native"].values() for name in case["over kane"]))
    rows = []
    for case in runs[0]["native"]:
        for k, run in enumerate(runs):
            figures = (spread(run["native"][case]["over kane"].get(name), 2) for name in names)
            rows.append([case if k == 0 else "", str(k + 1), *figures])
    return table(["peer's time / kane's", "run", *names], rows)


def _slopes(runs: Sequence[Run]) -> str:
    first = next(iter(runs[0]["derivatives"].values()))
    rows = []
    for case, own in runs[0]["derivatives"].items():
        operations = f"{own['operations']['jac']} for {own['operations']['rhs']}"
        for k, run in enumerate(runs):
            found = run["derivatives"][case]
            times = (spread(found["ns"].get(name), 0) for name in first["ns"])
            ratios = (spread(found["ratios"].get(name), 2) for name in first["ratios"])
            rows.append([f"{case} ({operations})" if k == 0 else "", str(k + 1), *times, *ratios])
    return table(["", "run", *first["ns"], *first["ratios"]], rows)


def _growth(runs: Sequence[Run]) -> str:
    parts = []
    for name, first in runs[0]["growth"].items():
        rows = []
        for n, row in first["rows"].items():
            cells = [n, f"{row['operations']:.0f}"]
            for run in runs:
                own = run["growth"][name]["rows"][n]
                cells += [f"{own['derive']:.3f}", f"{own['compile']:.3f}", f"{own['evaluation'] * 1e6:.2f}"]
            rows.append(cells)
        cells = ["power of n", f"{first['powers']['operations']:.2f}"]
        for run in runs:
            cells += [f"{run['growth'][name]['powers'][key]:.2f}" for key in ("derive", "compile", "evaluation")]
        rows.append(cells)
        head = ["n", "operations"]
        for k in range(len(runs)):
            head += [f"derive, s ({k + 1})", f"compile, s ({k + 1})", f"evaluation, µs ({k + 1})"]
        parts.append(f"### {name}\n\n{table(head, rows)}")
    return "\n\n".join(parts)


def _targets(found: Sequence[Mapping[str, Any]]) -> str:
    rows = [
        [
            t["target"],
            f"{'≥' if t['least'] else '≤'} {t['bound']:.3g}",
            ", ".join(f"{f:.3g}" for f in t["runs"]),
            "yes" if t["holds"] else "**no**",
        ]
        for t in found
    ]
    return table(["", "bound", "medians of the runs", "holds in both"], rows)


def document(record: Mapping[str, Any]) -> str:
    """The whole page."""
    runs = record["runs"]
    named = ", ".join(f"{name} {number}" for name, number in record["versions"].items())
    return (
        "# Trees\n\n"
        f"{record['processor']}; {record['compiler']}; {named}. Median (least … greatest) of {record['rounds']} rounds "
        "in which all contenders of a case take turns in one process; each run is a process of its own. All native: kane's "
        "machine code, Pinocchio's C++ (`aba` about the world's origin and in the bodies' frames), MuJoCo's C "
        "(`mj_forward`, contacts and constraints off), CasADi's generated C and heyoka's compiled function of a recursion "
        "written for planar chains. Masses and g are inputs at run time in kane, CasADi and heyoka, of planar chains the "
        "lengths too, and every number where the case says so; Pinocchio and MuJoCo read theirs from their models. Every "
        "result is compared with kane's reference evaluator first, to 1e-9; MuJoCo's to 1e-4, for its bodies have 1e-9 "
        "kg m² more. A dash means that a peer does not take part.\n\n"
        "## Nanoseconds a call (kane's operations with the state + of parameters, and the route)\n\n"
        + _native(runs)
        + "\n\n"
        + _ratios(runs)
        + "\n\n## Derivatives by coordinates and speeds\n\nAll of ∂(q̇, u̇)/∂(q, u) beside Pinocchio's "
        "`computeABADerivatives`; nanoseconds a call, and ratios round by round. Derivatives agree to 1e-9 of the largest. "
        "In brackets the operations with the state, of derivatives and of the right-hand side; the first arm has aligned axes.\n\n"
        + _slopes(runs)
        + "\n\n## Growth with the number of bodies\n\nCold: a fresh process each, the cache off, seconds of processor "
        "time, medians of up to three; runs 1 and 2.\n\n"
        + _growth(runs)
        + "\n\n## Targets\n\n"
        + _targets(record["targets"])
        + "\n"
    )
