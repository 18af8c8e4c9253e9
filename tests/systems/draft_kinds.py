# SPDX-License-Identifier: BSD-3-Clause
"""Random sound drafts, kind by kind."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tests.systems.draft_constrained import loop, sled, wheel
from tests.systems.draft_trees import free_body, jointed, tree
from tests.systems.drafts import Draft

KINDS: dict[str, Callable[[np.random.Generator], Draft]] = {
    "tree": tree,
    "free body": free_body,
    "wheel": wheel,
    "loop": loop,
    "sled": sled,
    "jointed": jointed,
}


def drafted(seed: int) -> Draft:
    """A random sound draft."""
    rng = np.random.default_rng(seed)
    return KINDS[list(KINDS)[seed % len(KINDS)]](rng)
