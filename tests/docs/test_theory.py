# SPDX-License-Identifier: BSD-3-Clause
"""The theory pages tell of every module of the dynamics layer, and of none that is not there."""

import re

from tests.docs.snippets import ROOT

SHOWN_ELSEWHERE = {"__init__", "html"}


def test_each_module_of_the_dynamics_layer_has_its_page():
    text = "".join(page.read_text(encoding="utf-8") for page in (ROOT / "docs" / "theory").glob("*.md"))
    named = set(re.findall(r"`dynamics/(\w+)\.py`", text))
    there = {path.stem for path in (ROOT / "src" / "kane" / "dynamics").glob("*.py")}
    assert named == there - SHOWN_ELSEWHERE
