# SPDX-License-Identifier: BSD-3-Clause
"""Other tools that tests compare with: `pinocchio = require("pinocchio")`."""

import importlib
import os
from types import ModuleType

import pytest


def require(name: str) -> ModuleType:
    """Import a peer. Where it is absent the test is skipped, but fails under CI or KANE_FULL."""
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as missing:
        # a peer that is there but broken (its own dependency is missing) is an error everywhere
        if missing.name != name.partition(".")[0] or not may_be_absent():
            raise
        pytest.skip(f"the peer {name} is not installed", allow_module_level=True)


def may_be_absent() -> bool:
    """Whether tests are skipped for want of a package: not under CI or KANE_FULL."""
    return not (os.environ.get("CI") or os.environ.get("KANE_FULL"))
