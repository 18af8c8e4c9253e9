# SPDX-License-Identifier: BSD-3-Clause
"""The width of lines is that where there is no terminal, whatever runs the tests."""

import pytest


@pytest.fixture(autouse=True)
def _no_terminal(monkeypatch):
    monkeypatch.setenv("COLUMNS", "110")
