# SPDX-License-Identifier: BSD-3-Clause
"""The runs of the benchmark of beams as Markdown, and which targets hold in every run."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

Run = Mapping[str, Any]

# What is asked, how a run has it, the bound, and whether it is the least.
TARGETS: tuple[tuple[str, Callable[[Run], float], float, bool], ...] = (
    ("times of Exudyn's coarsest mesh, by the fewest modes", lambda run: run["ratios"]["fewest"], 20.0, True),
    ("times of Exudyn's coarsest mesh, by five modes", lambda run: run["ratios"]["all"], 20.0, True),
    ("derivation with five modes, s", lambda run: run["derivation"]["median"], 0.1, False),
)


def targets(runs: Sequence[Run]) -> list[dict[str, Any]]:
    """Each target's figure in each run; it holds when it does in all."""
    found = []
    for what, figure, bound, least in TARGETS:
        figures = [figure(run) for run in runs]
        holds = all(f >= bound if least else f <= bound for f in figures)
        found.append({"target": what, "bound": bound, "least": least, "runs": figures, "holds": holds})
    return found


def _ms(s: Mapping[str, float]) -> str:
    return f"{s['median'] * 1e3:.1f} ({s['min'] * 1e3:.1f} … {s['max'] * 1e3:.1f})"


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    return "\n".join("| " + " | ".join(line) + " |" for line in (head, ["---"] * len(head), *rows)) + "\n"


def _runs(runs: Sequence[Run]) -> str:
    rows = []
    for k, run in enumerate(runs, 1):
        errors = run["errors"]
        for name, what in (
            ("fewest", f"kane, modes: {run['modes']}"),
            ("all", "kane, modes: 5"),
            ("Exudyn", run["setting"]),
        ):
            ratio = f"{run['ratios'][name]:.0f}" if name in run["ratios"] else ""
            rows.append([str(k), what, f"{abs(errors[name]):.2%}", _ms(run[name]), ratio])
    return _table(["run", "", "error of the peak", "ms", "Exudyn's time / this, round by round"], rows)


def _targets(found: Sequence[Mapping[str, Any]]) -> str:
    rows = [
        [
            t["target"],
            f"{'≥' if t['least'] else '≤'} {t['bound']:g}",
            ", ".join(f"{f:.3g}" for f in t["runs"]),
            "yes" if t["holds"] else "**no**",
        ]
        for t in found
    ]
    return _table(["", "bound", "medians of the runs", "holds in both"], rows)


def document(record: Mapping[str, Any]) -> str:
    """The page."""
    runs = record["runs"]
    tools = ", ".join(f"{name} {v}" for name, v in record["versions"].items())
    first = runs[0]
    parts = [
        "# Spin-up of a flexible beam",
        f"{record['processor']}; {tools}. Median (least … greatest) of {record['rounds']} rounds in which all take turns in one "
        "process; each run is a process of its own.",
        "A beam of 10 m (EI = 1.4·10⁴ N m², EA = 2.8·10⁷ N, ρA = 1.2 kg/m) is spun up to 6 rad/s in 15 s and observed for 20 s. "
        f"Its tip lags by {first['reference']:.4f} m at most, by {record['finest']} of Exudyn.",
        "What takes part is the fewest of kane's modes (linearized form) and the coarsest mesh of Exudyn's cable elements with the "
        "fastest of its settings (400 to 2000 steps, spectral radius 0.9 or 0.6, full or modified Newton, the angle in symbols, dense "
        "solver) whose peak is within 1 % of that, and five of kane's modes. Models are ready when the clock starts: equations "
        "derived and compiled, elements assembled. kane's time holds all checks and warnings of `simulate` and the tip's deflection "
        "at 201 times.",
        _runs(runs),
        f"The equations of five modes take {first['operations']} operations, and "
        f"{', '.join(_ms(run['derivation']) for run in runs)} ms to derive, from cold caches.",
        "## Targets",
        _targets(record["targets"]),
    ]
    return "\n\n".join(part.strip() for part in parts) + "\n"
