# SPDX-License-Identifier: BSD-3-Clause
"""Long expressions in one line of a message: cut, and seen to be."""

from __future__ import annotations


def excerpt(shown: object, most: int = 60) -> str:
    """What `shown` prints as in at most so many letters; "…" stands for what is left out, definitions of intermediates too."""
    text, where, _ = str(shown).partition(", where ")
    if not where and len(text) <= most:
        return text
    return f"{text[: most - 2].rstrip(' +-*/^(')} …"
