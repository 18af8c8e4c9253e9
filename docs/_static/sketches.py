# SPDX-License-Identifier: BSD-3-Clause
"""The sketches of `docs/howto/sketch.md`: `python docs/_static/sketches.py` draws them anew."""

from pathlib import Path

import kane as kn
from kane.gallery import load

NAMES = ("slider_crank", "rolling_disk", "four_bar", "flyball_governor", "flexible_arm", "spinning_top")


def draw(name: str) -> str:
    """The sketch of a system of the gallery."""
    module = load(name)
    system = module.system()
    shapes = module.shapes(system) if hasattr(module, "shapes") else ()
    return kn.sketch(system, shapes=shapes, title=module.TITLE).svg


if __name__ == "__main__":
    for name in NAMES:
        (Path(__file__).parent / f"sketch_{name}.svg").write_text(draw(name), encoding="utf-8")
