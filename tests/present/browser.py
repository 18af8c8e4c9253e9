# SPDX-License-Identifier: BSD-3-Clause
"""Chromium for tests of pages: found on the machine, never downloaded."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from tests.peer import require

NAMES = ("chromium", "chromium-browser", "google-chrome")
FLAGS = (
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)


def executable() -> str:
    """Path of the browser. Where there is none the test is skipped, but fails under CI or KANE_FULL."""
    found = next(filter(None, map(shutil.which, NAMES)), None)
    if found is not None:
        return found
    message = f"Expected one of {', '.join(NAMES)} on the path, got none: install Debian's package chromium."
    if os.environ.get("CI") or os.environ.get("KANE_FULL"):
        pytest.fail(message)
    pytest.skip(message)


def visit(page: Any, path: Path) -> None:
    """Open a page that kane wrote, and wait for the scripts that it carries."""
    page.goto(path.as_uri())
    begun(page)


def begun(page: Any) -> None:
    """Wait for the scripts that a page carries."""
    page.locator("html:not(.loading)").wait_for(state="attached")


@contextmanager
def chromium(*more: str) -> Iterator[Any]:
    """A headless browser with a profile of its own; `more` are further flags."""
    path = executable()
    playwright = require("playwright.sync_api")
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(
            executable_path=path, args=[*(f for f in FLAGS if not more or f != "--disable-gpu"), *more]
        )
        yield browser
        browser.close()
