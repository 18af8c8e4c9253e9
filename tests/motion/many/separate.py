# SPDX-License-Identifier: BSD-3-Clause
"""The instances of many motions that are simulated separately, since no kernel runs them."""

from typing import Any

import pytest

import kane as kn


def simulated_separately(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """The start values of such instances, as they come."""
    asked = list[Any]()

    def simulate(*args: Any, **options: Any) -> kn.Solution:
        asked.append((options["q"], options["u"]))
        return kn.simulate(*args, **options)

    monkeypatch.setattr("kane.motion.many.tiles.simulate", simulate)
    return asked
