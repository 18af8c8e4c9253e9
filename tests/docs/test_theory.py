# SPDX-License-Identifier: BSD-3-Clause
"""The theory pages tell of every module of the dynamics layer, and of none that is not there."""

import re

from tests.docs.snippets import ROOT

DYNAMICS = ROOT / "src" / "kane" / "dynamics"
TOOLS = {"lazy"}


def test_each_module_of_the_dynamics_layer_has_its_page():
    text = "".join(page.read_text(encoding="utf-8") for page in (ROOT / "docs" / "theory").glob("*.md"))
    named = set(re.findall(r"`dynamics/([\w/]+)\.py`", text))
    there = {path.relative_to(DYNAMICS).with_suffix("").as_posix() for path in DYNAMICS.rglob("*.py")}
    assert named == {name for name in there if not name.endswith("__init__")} - TOOLS
