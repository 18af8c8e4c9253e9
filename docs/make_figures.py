# SPDX-License-Identifier: BSD-3-Clause
"""The pictures of the tutorials, of the page on plots and of the gallery, and the gallery's page: `make figures` makes them anew.

Plots are those that the listings of the tutorials write; sketches are of what is called `system` in them, and of each system of the
gallery. Run it after a change of these.
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import runpy
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

import kane as kn
from docs import moving
from kane.gallery import GALLERY, load
from tests.docs.snippets import blocks

DOCS = Path(__file__).resolve().parent
STATIC = DOCS / "_static"
TUTORIALS = ("pendulum", "cart", "four_bar", "engine", "disk", "quadcopter", "stick_slip", "chain")
PLOTS = ("phase", "runs", "section", "cycles", "energy")
"""Figures of `howto/plotting.md` that are kept."""
STUDIES = ("basins", "damping", "throws", "identified")
"""Figures of `howto/studies.md`."""
GROUPS = {
    "": "Pendulums, tops and linkages",
    "rolling": "Rolling and skating",
    "flexible": "Flexible beams",
    "contacts": "Contacts: impacts, stick and slip",
    "walking": "Walking: legs that land",
}
"""Headings of the gallery's folders."""

_HEAD = """<!-- made by docs/make_figures.py -->

# Gallery

Systems that come with `kane`, with their sources: models to read, to run and to begin with.

```console
$ kane report NAME            # every step of the derivation, the motion and its checks, as one HTML page
$ kane simulate NAME          # the motion in figures
$ kane animate NAME           # the motion as a page to turn and step through
```

In Python, `kane.gallery.load("NAME").system()` is the system, and the module's file is a model to copy.
"""


def gallery_page() -> str:
    """The gallery's page: title, sketch, one sentence and command of every system."""
    parts = [_HEAD]
    for folder, heading in GROUPS.items():
        parts.append(f"\n## {heading}\n")
        parts += [_card(name) for name, path in GALLERY.items() if _folder(path) == folder]
    return "".join(parts)


def _folder(path: str) -> str:
    return path.removeprefix("kane.gallery.").rpartition(".")[0]


def _card(name: str) -> str:
    module = load(name)
    assert module.__doc__ is not None
    title = module.TITLE[0].upper() + module.TITLE[1:]
    sentence = module.__doc__.strip().splitlines()[0]
    return (
        f"\n````{{figure}} _static/sketches/{name}.svg\n:alt: Sketch of the system {name}\n:figclass: gallery\n:loading: lazy\n\n"
        f"**{title}.** {sentence} `kane report {name}`\n\n{_motion(name, title)}````\n"
    )


def _motion(name: str, title: str) -> str:
    """The moving picture, which a reader who asks for less motion sees at rest."""
    moves, width, height = f"_static/motions/{name}.webp", *moving.CARD
    return (
        f'```{{raw}} html\n<picture><source srcset="{moves}" media="(prefers-reduced-motion: no-preference)">'
        f'<img src="_static/motions/{name}_still.webp" alt="Motion: {title}" width="{width}" height="{height}" loading="lazy">'
        "</picture>\n```\n"
    )


def tutorials() -> Iterator[tuple[str, Any]]:
    """Name and system of each tutorial, whose listings run in a folder of their own; what they draw goes to `_static/tutorial`."""
    for name in TUTORIALS:
        pictures, found = _run(DOCS / "tutorial" / f"{name}.md")
        for made, svg in pictures.items():
            (STATIC / "tutorial" / made).write_text(svg, encoding="utf-8")
        yield f"tutorial_{name}", found["system"]


def plotting() -> None:
    """The pictures of the pages on plots and on studies."""
    for page, kind, names in (("plotting", "plot", PLOTS), ("studies", "study", STUDIES)):
        pictures, _ = _run(DOCS / "howto" / f"{page}.md")
        for name in names:
            (STATIC / f"{kind}_{name}.svg").write_text(pictures[f"{name}.svg"], encoding="utf-8")


def _run(page: Path) -> tuple[dict[str, str], dict[str, Any]]:
    """The SVGs that a page's listings write, and what they define."""
    with tempfile.TemporaryDirectory() as folder:
        script = Path(folder) / "page.py"
        script.write_text("".join(block.code for block in blocks(page.read_text(encoding="utf-8"))), encoding="utf-8")
        here = Path.cwd()
        os.chdir(folder)
        try:
            with contextlib.redirect_stdout(io.StringIO()):
                found = runpy.run_path(str(script))
        finally:
            os.chdir(here)
        return {made.name: _settled(made.read_text("utf-8")) for made in Path(folder).glob("*.svg")}, found


def _settled(svg: str) -> str:
    """Without date, and with the names that matplotlib draws at random numbered, so that a picture changes only with what it shows."""
    svg = re.sub(r"<dc:date>.*?</dc:date>", "", svg)
    for i, name in enumerate(dict.fromkeys(re.findall(r'id="([a-z][0-9a-f]{10})"', svg))):
        svg = svg.replace(name, f"k{i}")
    return svg


def partial_velocity(path: Path) -> None:
    """The bob of a pendulum with what acts on it, and its partial velocity."""
    angle, length = 0.6, 1.0
    across, along = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    bob = -length * along
    page = Figure(figsize=(4.2, 3.9), layout="constrained")
    ax = page.subplots()
    ax.plot([0, bob[0]], [0, bob[1]], color="0.4", lw=2)
    ax.plot([0, 0], [0, -0.8], color="0.7", ls="--", lw=1)
    ax.plot(*bob, "o", ms=12, color="#33475b")
    ax.plot(0, 0, "o", ms=6, mfc="white", mec="0.2")
    for vector, color, text, shift in (
        (0.55 * across, "#0d7333", r"partial velocity $\mathbf{v}_1 = L\,\hat{\mathbf{b}}_x$", (-0.28, 0.07)),
        (0.55 * along, "#b23c06", r"pull $S\,\hat{\mathbf{b}}_y$", (0.05, -0.05)),
        (np.array([0, -0.45]), "#b23c06", r"weight $-m g\,\hat{\mathbf{n}}_y$", (0.04, 0.02)),
    ):
        end = bob + vector
        ax.annotate("", end, bob, arrowprops={"arrowstyle": "-|>", "color": color, "lw": 2, "shrinkA": 0, "shrinkB": 0})
        ax.text(*(end + shift), text, color=color, fontsize=10)
    turn = np.linspace(0, angle, 30)
    ax.plot(0.45 * np.sin(turn), -0.45 * np.cos(turn), color="#0b57b0", lw=1.2)
    ax.text(0.13, -0.56, "$q$", color="#0b57b0", fontsize=12)
    ax.text(-0.12, 0.02, "$O$", fontsize=11)
    ax.set_xlim(-0.2, 1.45)
    ax.set_ylim(-1.45, 0.15)
    ax.set_aspect("equal")
    ax.axis("off")
    page.savefig(path, metadata={"Date": None})


def partial_velocities(path: Path) -> None:
    """Two bobs one below the other, and the partial velocities of both for each speed."""
    page = Figure(figsize=(6.4, 3.4), layout="constrained")
    angles = np.array([0.5, 0.95])
    across = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    along = np.stack([np.sin(angles), -np.cos(angles)], axis=1)
    P, Q = along[0], along[0] + along[1]
    for k, ax in enumerate(page.subplots(1, 2), 1):
        ax.plot(*np.stack([np.zeros(2), P, Q]).T, color="0.4", lw=2)
        ax.plot(0, 0, "o", ms=6, mfc="white", mec="0.2")
        for point, name in ((P, "P"), (Q, "Q")):
            ax.plot(*point, "o", ms=10, color="#33475b")
            moves = k == 1 or name == "Q"
            unit = r"\hat{\mathbf{b}}_x" if k == 1 else r"\hat{\mathbf{c}}_x"
            value = rf"L\,{unit}" if moves else "0"
            end = point + (0.6 * across[k - 1] if moves else 0)
            if moves:
                arrow = {"arrowstyle": "-|>", "color": "#0d7333", "lw": 2, "shrinkA": 0, "shrinkB": 0}
                ax.annotate("", end, point, arrowprops=arrow)
            shift = (0.05, 0.02) if moves else (0.13, -0.02)
            ax.text(*(end + shift), rf"$\mathbf{{v}}^{name}_{k} = {value}$", color="#0d7333", fontsize=10)
            ax.text(*(point - np.array([0.2, 0.06])), f"${name}$", fontsize=11)
        ax.set_title(f"for $u_{k}$", fontsize=11)
        ax.set_xlim(-0.2, 2.6)
        ax.set_ylim(-1.65, 0.1)
        ax.set_aspect("equal")
        ax.axis("off")
    page.savefig(path, metadata={"Date": None})


def _shapes(name: str, system: kn.System) -> tuple[Any, ...]:
    """The shapes that a system of the gallery declares beside it."""
    made = getattr(load(name), "shapes", None) if name in GALLERY else None
    return () if made is None else tuple(made(system))


def main() -> None:
    """Make all of it."""
    mpl.rcParams.update({"svg.hashsalt": "kane", "svg.fonttype": "path"})
    for folder in ("tutorial", "sketches", "motions"):
        (STATIC / folder).mkdir(exist_ok=True)
    plotting()
    partial_velocity(STATIC / "tutorial" / "partial_velocity.svg")
    partial_velocities(STATIC / "tutorial" / "partial_velocities.svg")
    moving.front(STATIC / "disk.webp")
    for name, system in [*tutorials(), *((name, load(name).system()) for name in GALLERY)]:
        kn.sketch(system, STATIC / "sketches" / f"{name}.svg", shapes=_shapes(name, system))
    for name in GALLERY:
        moving.card(name, STATIC / "motions")
    (DOCS / "gallery.md").write_text(gallery_page(), encoding="utf-8")


if __name__ == "__main__":
    main()
