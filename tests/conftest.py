# SPDX-License-Identifier: BSD-3-Clause
"""Hypothesis profiles (`--hypothesis-profile=quick|full`), which tests run, and a cache of the tests' own."""

import gc
import hashlib
import importlib.util
import os
import shutil
import zlib
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, settings

from tests.peer import may_be_absent

# `quick` draws the same examples each time: a failure of `make test` is a failure for everyone.
settings.register_profile(
    "quick",
    max_examples=10,
    deadline=None,
    derandomize=True,
    print_blob=True,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.register_profile(
    "full",
    max_examples=200,
    deadline=None,
    derandomize=bool(os.environ.get("CI")),  # by hand other examples each time, in CI a result that can be repeated
    print_blob=True,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("quick")  # where no profile is named

collect_ignore = (
    [] if importlib.util.find_spec("torch") else ["interop/test_native_torch.py"]
)  # some 3 GB: `make test-torch`


def pytest_configure(config: pytest.Config) -> None:
    """Compiled code goes to a folder of the tests' own, which workers share and the next sessions find; `make clean` removes it.

    Keys of entries tell of text, processor and versions; the folder's name of the files that make code of text, so that a change to
    these is tried on everything anew.
    """
    if "PYTEST_XDIST_WORKER" not in os.environ:
        root, digest = Path(config.rootpath), hashlib.sha256()
        for file in sorted((root / "src" / "kane" / "program" / "native").glob("*.py")):
            digest.update(file.read_bytes())
        folder = root / ".pytest_cache" / "code" / digest.hexdigest()[:16]
        os.environ["KANE_CACHE"] = str(folder)
        for other in set(folder.parent.glob("*")) - {folder}:
            shutil.rmtree(other, ignore_errors=True)


def pytest_collection() -> None:
    """No garbage is looked for while tests are collected: all that they are made of stays."""
    gc.disable()


def pytest_collection_finish() -> None:
    """What stays is not looked through again, either, and what tests make, which is much, is looked through seldom."""
    gc.freeze()
    gc.set_threshold(10_000, 20, 50)  # below those of a derivation, which are tested
    gc.enable()


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Which tests run, by KANE_FULL; the others are deselected, never skipped.

    Without it those that are neither `slow` nor a `page` (`make test`). "1": all (`make test-full`). "rest": what `make test` has not
    run in the same way: slow ones, those of random examples, and those that grow with the profile. "pages": the listings of pages.
    """
    wanted = {
        "": lambda i: not (i.get_closest_marker("slow") or i.get_closest_marker("page")),
        "1": lambda i: True,
        "rest": lambda i: any(map(i.get_closest_marker, ("slow", "grows"))) or _draws(i),
        "pages": lambda i: bool(i.get_closest_marker("page")),
    }[os.environ.get("KANE_FULL", "")]
    kept, left_out = list[pytest.Item](), list[pytest.Item]()
    for item in items:
        (kept if wanted(item) else left_out).append(item)
    if left_out:
        config.hook.pytest_deselected(items=left_out)
    items[:] = _dealt(kept, getattr(config, "workerinput", {"workercount": 1})["workercount"])


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call() -> Iterator[None]:
    """A test that wants a package of an extra, which kane says is not there, is skipped as one that requires it as a peer."""
    try:
        return (yield)
    except ImportError as absent:
        if not (
            isinstance(absent.__cause__, ModuleNotFoundError)
            and "pip install 'kane[" in str(absent)
            and may_be_absent()
        ):
            raise
        pytest.skip(f"the package {absent.__cause__.name} is not installed")


LONGEST = (
    "tests/interop/robots/test_hostile.py::test_mutated_",  # of stated duration, so each on a worker of its own
    "tests/laws/test_chosen_modes.py::test_the_modes_of_",
    "tests/interop/test_python_source.py::test_random_trees",
    "tests/analysis/test_inertial_regressor.py::test_inverse_dynamics_",
    "tests/motion/fitting/test_fit.py::test_a_four_bar_within_",
    "tests/motion/fitting/test_fit.py::test_a_chaotic_motion_",
    "tests/laws/test_random_axes.py::test_many_",
    "tests/motion/fitting/test_fit.py::test_stick_and_slip_within_",
    "tests/laws/test_contacts.py::test_what_no_motion_may_do",
    "tests/motion/test_c_rules.py::test_programs_keep_",
    "tests/present/test_every_page.py::",
    "tests/motion/many/test_cluster.py::test_a_killed_",
    "tests/motion/fitting/test_fit.py::test_a_tree_within_",
    "tests/analysis/test_trimming.py::test_a_cantilever_",
)
"""Tests that take longest when all of them run, the longest first, by how their names begin."""


def _dealt(items: list[pytest.Item], workers: int) -> list[pytest.Item]:
    """The longest tests are dealt out, one to each worker in turn, and come first; then those of laws, and other slow ones.

    xdist's `worksteal` gives each worker one stretch of the list, all of one length, and who has ended takes the end of another's. So
    what is left at the end are short ones, and no worker waits for another's long one.
    """
    rank = {i: next((k for k, name in enumerate(LONGEST) if i.nodeid.startswith(name)), len(LONGEST)) for i in items}
    longest = sorted((i for i in items if rank[i] < len(LONGEST)), key=rank.__getitem__)
    slow, short = list[pytest.Item](), list[pytest.Item]()
    for item in sorted(items, key=lambda i: not i.nodeid.startswith("tests/laws/")):
        if rank[item] == len(LONGEST):
            (slow if _is_long(item) else short).append(item)
    found = list[pytest.Item]()
    for k in range(workers):
        own = [*longest[k::workers], *_stretch(slow, k, workers)]
        length = (len(items) - len(found)) // (workers - k)
        left = len(short) if k == workers - 1 else max(0, length - len(own))
        found += [*own, *short[:left]]
        del short[:left]
    return found


def _stretch(items: list[pytest.Item], k: int, workers: int) -> list[pytest.Item]:
    """The kth of as many stretches of equal length as there are workers: neighbours, which share fixtures, stay together."""
    return items[k * len(items) // workers : (k + 1) * len(items) // workers]


def _is_long(item: pytest.Item) -> bool:
    """Whether a test is slow, or draws many examples."""
    return bool(item.get_closest_marker("slow") or (os.environ.get("KANE_FULL") and _draws(item)))


def _draws(item: pytest.Item) -> bool:
    """Whether Hypothesis draws the test's examples."""
    return bool(getattr(getattr(item, "obj", None), "is_hypothesis_test", False))


@pytest.fixture
def rng(request: pytest.FixtureRequest) -> np.random.Generator:
    """A generator of the test's own: what it draws depends on the test's name, not on which tests ran before."""
    return np.random.default_rng(zlib.crc32(request.node.name.encode()))
