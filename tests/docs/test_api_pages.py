# SPDX-License-Identifier: BSD-3-Clause
"""The API pages document every public name once, and no other."""

import re

import kane as kn
from tests.docs.snippets import ROOT

_DIRECTIVE = re.compile(r"^\.\. (?:autoclass|autofunction|autoexception|py:data):: (\w+)", re.MULTILINE)


def test_every_public_name_is_documented_once():
    pages = sorted((ROOT / "docs" / "api").glob("*.md"))
    names = [name for page in pages for name in _DIRECTIVE.findall(page.read_text(encoding="utf-8"))]
    assert sorted(names) == sorted(kn.__all__)
