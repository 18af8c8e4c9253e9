# SPDX-License-Identifier: BSD-3-Clause
"""The API pages document every public name once, and no other."""

import re

import kane as kn
from tests.docs.snippets import ROOT
from tests.test_api import FAMILIES

_PART = re.compile(r"^\.\. (currentmodule|autoclass|autofunction|autoexception|py:data):: ([\w.]+)", re.MULTILINE)


def documented() -> list[tuple[str, str]]:
    """Module and name of what the pages document."""
    found, module = [], ""
    for page in sorted((ROOT / "docs" / "api").glob("*.md")):
        for directive, name in _PART.findall(page.read_text(encoding="utf-8")):
            if directive == "currentmodule":
                module = name
            else:
                found.append((module, name))
    return found


def test_every_public_name_is_documented_once():
    """A name of a family stands with its family."""
    families = {name: f"kane.{family}" for family in FAMILIES for name in getattr(kn, family).__all__}
    public = {**{name: "kane" for name in kn.__all__ if name not in FAMILIES}, **families}
    assert sorted(documented()) == sorted((module, name) for name, module in public.items())
