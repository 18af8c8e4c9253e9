# SPDX-License-Identifier: BSD-3-Clause
"""The runs of the bicycle benchmark as Markdown, and which targets hold in every run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

Run = Mapping[str, Any]

# What is asked, the part of a run it is found in, the bound in seconds.
TARGETS: tuple[tuple[str, str, float], ...] = (
    ("declaration and derivation, kane, s", "derivation", 0.15),
    ("numeric linearization, kane, s", "linearization", 0.01),
)


def targets(runs: Sequence[Run]) -> list[dict[str, Any]]:
    """Each target's median in each run; it holds when it does in all."""
    found = []
    for what, part, bound in TARGETS:
        figures = [run[part]["kane, s"]["median"] for run in runs]
        found.append({"target": what, "bound": bound, "runs": figures, "holds": all(f <= bound for f in figures)})
    return found


def _ms(s: Mapping[str, float]) -> str:
    return f"{s['median'] * 1e3:.1f} ({s['min'] * 1e3:.1f} … {s['max'] * 1e3:.1f})"


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    return "\n".join("| " + " | ".join(line) + " |" for line in (head, ["---"] * len(head), *rows)) + "\n"


def _derivations(runs: Sequence[Run]) -> str:
    rows = [
        [
            str(k),
            _ms(run["derivation"]["kane, s"]),
            _ms(run["derivation"]["SymPy, s"]),
            f"{run['derivation']['ratio']:.0f}",
        ]
        for k, run in enumerate(runs, 1)
    ]
    return _table(["run", "kane, ms", "SymPy, ms", "ratio, pair by pair"], rows)


def _linearizations(runs: Sequence[Run]) -> str:
    parts = [run["linearization"] for run in runs]
    rows = [[str(k), _ms(part["kane, s"]), f"{part['kane ready, s']:.2f}"] for k, part in enumerate(parts, 1)]
    return _table(["run", "kane, ms a point", "first point, derived and compiled, s"], rows)


def _targets(found: Sequence[Mapping[str, Any]]) -> str:
    rows = [
        [t["target"], f"≤ {t['bound']:g}", ", ".join(f"{f:.3g}" for f in t["runs"]), "yes" if t["holds"] else "**no**"]
        for t in found
    ]
    return _table(["", "bound", "medians of the runs", "holds in both"], rows)


def document(record: Mapping[str, Any]) -> str:
    """The whole page."""
    runs = record["runs"]
    named = ", ".join(f"{name} {number}" for name, number in record["versions"].items())
    apart = max(run["difference"] for run in runs)
    peer = record["SymPy linearization"]
    return (
        "# Whipple bicycle\n\n"
        f"{record['processor']}; {named}. Median (least … greatest); each run is a process of its own. SymPy's model has four "
        "coordinates and six speeds, kane's eight and eight: SymPy is spared the wheels' angles and the place on the road. "
        f"The accelerations of the angles at a random state differ by at most {apart:.1e} of the largest, the eigenvalues "
        f"at 5 m/s by {peer['difference']:.1e} 1/s.\n\n"
        f"## Declaration and derivation\n\n{record['pairs']} interleaved pairs, both sides from cold caches.\n\n"
        + _derivations(runs)
        + f"\n## Numeric linearization\n\nkane: a compiled `kn.analysis.linearizer` at {record['points']} forward speeds, with the "
        f"check that the point is a steady motion on the constraints. SymPy: `linearize(A_and_B=True)` with the numbers of state and "
        f"parameters, one point, once, in a process of its own, its derivation left out: {peer['s']:.1f} s.\n\n"
        + _linearizations(runs)
        + "\n## Targets\n\n"
        + _targets(record["targets"])
    )
