# SPDX-License-Identifier: BSD-3-Clause
"""How cost grows with the number of bodies, drawn: `python -m benchmarks.growth_plot` makes docs/_static/growth.svg of trees.json."""

from __future__ import annotations

import json
from pathlib import Path

import matplotlib as mpl

mpl.use("svg")
import matplotlib.pyplot as plt

HERE = Path(__file__).parent
OUT = HERE.parent / "docs" / "_static" / "growth.svg"
PANELS = (("derive", "derivation, s"), ("compile", "compilation, s"), ("evaluation", "evaluation, µs"))


def main() -> None:
    """Draw the medians of both runs."""
    runs = json.loads((HERE / "trees.json").read_text())["runs"]
    mpl.rcParams.update({"svg.hashsalt": "kane", "svg.fonttype": "path"})
    figure, axes = plt.subplots(1, 3, figsize=(10, 3.4), layout="constrained")
    for ax, (key, label) in zip(axes, PANELS, strict=True):
        for k, name in enumerate(runs[0]["growth"]):
            for run in runs:
                rows = run["growth"][name]["rows"]
                n = [int(x) for x in rows]
                scale = 1e6 if key == "evaluation" else 1.0
                values = [rows[x][key] * scale for x in rows]
                ax.loglog(n, values, "o-", color=f"C{k}", alpha=0.7, label=name if run is runs[0] else None)
        n0, n1 = 10, 400
        low = min(line.get_ydata()[0] for line in ax.lines)
        ax.loglog([n0, n1], [low / 2, low / 2 * n1 / n0], "--", color="0.6", label="∝ n")
        ax.set_xlabel("bodies")
        ax.set_title(label, fontsize=10)
        ax.grid(visible=True, which="both", alpha=0.25)
    axes[0].legend(fontsize=8)
    figure.savefig(OUT, metadata={"Date": None})


if __name__ == "__main__":
    main()
