# SPDX-License-Identifier: BSD-3-Clause
"""Python's collector while much is made: seldom at work, and afterwards as it was."""

import gc
import threading

import pytest

import kane as kn
from kane import progress
from kane.gallery import pendulums
from kane.progress import SELDOM, collecting_seldom


@pytest.fixture(autouse=True)
def _as_before():
    before = gc.get_threshold()
    yield
    gc.set_threshold(*before)


def test_thresholds_are_higher_within_and_as_they_were_afterwards():
    gc.set_threshold(701, 11, 12)
    with collecting_seldom(), collecting_seldom():
        assert gc.get_threshold()[0] == SELDOM[0]
    assert gc.get_threshold()[:2] == (701, 11)
    with pytest.raises(KeyError), collecting_seldom():
        raise KeyError
    assert gc.get_threshold()[:2] == (701, 11)


@pytest.mark.parametrize("own", [(0, 10, 10), (SELDOM[0] + 1, 5, 5)])
def test_one_that_is_off_or_seldom_at_work_is_left_alone(own):
    gc.set_threshold(*own)
    with collecting_seldom():
        assert gc.get_threshold()[0] == own[0]
    assert gc.get_threshold()[0] == own[0]


def test_what_somebody_sets_meanwhile_stays():
    with collecting_seldom():
        gc.set_threshold(500, 7, 7)
    assert gc.get_threshold()[0] == 500


def test_threads_that_overlap_give_back_what_was_there_first():
    gc.set_threshold(701, 11, 12)
    inside, leave = threading.Event(), threading.Event()

    def work():
        with collecting_seldom():
            inside.set()
            leave.wait()

    other = threading.Thread(target=work)
    with collecting_seldom():
        other.start()
        inside.wait()
    assert gc.get_threshold()[0] == SELDOM[0]
    leave.set()
    other.join()
    assert gc.get_threshold()[0] == 701
    assert not progress._before


@pytest.mark.slow
def test_a_derivation_lets_it_rest():
    system, runs = pendulums.system(40), []
    gc.collect()
    gc.callbacks.append(lambda phase, info: runs.append(phase))
    try:
        eom = kn.derive(system)
    finally:
        gc.callbacks.pop()
    assert len(runs) <= 2  # beginning and end of one, when it is over
    assert eom.operations.total > 2_000
    assert gc.get_threshold() != SELDOM
