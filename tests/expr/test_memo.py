# SPDX-License-Identifier: BSD-3-Clause
"""What is remembered while a derivation lasts: computed once there, anew outside, and let go with it."""

import gc
import threading
import weakref

import pytest

import kane as kn
from kane.expr import remembered, remembering, sweep
from kane.gallery import four_bar

CALLS: list[tuple[object, ...]] = []


@remembered
def _noted(*args):
    CALLS.append(args)
    return (*args, "found")


@pytest.fixture(autouse=True)
def _forgotten():
    CALLS.clear()


def test_within_each_result_is_computed_once_and_outside_anew():
    x = kn.coordinate("x")
    with remembering():
        first = _noted(x, 1)
        with remembering():  # a derivation within another
            assert _noted(x, 1) is first
        assert _noted(x, 1) is first
        assert _noted(x, 2) == (x, 2, "found")
    assert len(CALLS) == 2
    assert _noted(x, 1) == first
    assert _noted(x, 1) is not first


def test_an_error_within_ends_it():
    with pytest.raises(KeyError), remembering():
        raise KeyError
    assert _noted(1) is not _noted(1)


def test_other_threads_remember_for_themselves():
    found = []
    with remembering():
        own = _noted(1)
        thread = threading.Thread(target=lambda: found.append(_noted(1)))
        thread.start()
        thread.join()
    assert found[0] == own
    assert found[0] is not own


@pytest.mark.slow
def test_nothing_is_held_after_a_derivation():
    system = four_bar.system()
    eom, gone = kn.derive(system), weakref.ref(system.frames[-1])
    del eom, system
    gc.collect()
    sweep()  # reactions know their places
    gc.collect()
    assert gone() is None
