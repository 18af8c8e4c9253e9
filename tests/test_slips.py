# SPDX-License-Identifier: BSD-3-Clause
"""Random models with one slip of the pen each: refused or warned of, and without the slip sound.

A slip that a machine can see is one after which the model contradicts itself: a unit, a name, a start, a contact, a constraint.
Others, such as the sign of a force, leave another sound model; they are counted apart.
"""

from __future__ import annotations

import re

import numpy as np
import pytest

import kane as kn
from kane.analysis import doubtful_loads
from tests.systems.draft_kinds import KINDS, drafted
from tests.systems.drafts import Draft, built, verdict
from tests.systems.slips import SEEN, slipped
from tests.systems.slips_unseen import UNSEEN, sign_of_a_force, sign_of_a_value

BLOCK = 100
LEAST = 0.99
"""Share of the slips that must be told."""

few = pytest.mark.parametrize("seed", range(24))
many = pytest.mark.parametrize("block", range(1000 // BLOCK))


def seeds(block: int) -> range:
    return range(1000 + block * BLOCK, 1000 + (block + 1) * BLOCK)


def told(seed: int) -> str:
    """What is wrong with what is said of the slip with this seed; "" where all is well."""
    sound = drafted(seed)
    name, wrong = slipped(sound, np.random.default_rng([seed, 1]))
    found = verdict(wrong)
    where = f"{seed}, {sound.kind}, {name}"
    if not found.said:
        return f"{where}: not seen"
    return "" if "xpected" in found.said and "got" in found.said else f"{where}: {found.said}"


@pytest.mark.slow
@few
def test_a_slip_is_told(seed):
    assert told(seed) == ""


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(len(KINDS)))
def test_a_sound_model_passes_without_a_word(seed):
    assert verdict(drafted(seed)).said == ""


@pytest.mark.slow
@many
def test_slips_are_told(block):
    missed = [said for seed in seeds(block) if (said := told(seed))]
    assert len(missed) <= round((1 - LEAST) * BLOCK), missed


@pytest.mark.slow
@many
def test_sound_models_pass_without_a_word(block):
    alarms = [(seed, said) for seed in seeds(block)[::4] if (said := verdict(drafted(seed)).said)]
    assert alarms == []


def test_every_slip_has_an_occasion():
    """Each slip of the tables can be made in some kind of model."""
    drafts = [drafted(seed) for seed in range(10 * len(KINDS))]
    for name, slip in {**SEEN, **UNSEEN}.items():
        assert any(slip(d, np.random.default_rng(1)) is not None for d in drafts), name


@pytest.mark.slow
def test_what_cannot_be_seen_is_another_sound_model():
    """Signs and values of one unit: neither refused nor warned of, but by chance."""
    said = []
    for seed in range(2000, 2036):
        sound = drafted(seed)
        if any(slip(sound, np.random.default_rng(seed)) for slip in UNSEEN.values()):
            said.append(verdict(slipped(sound, np.random.default_rng([seed, 2]), UNSEEN)[1]).said)
    assert sum(not x for x in said) >= 0.9 * len(said)


def doubted(d: Draft) -> set[str]:
    """The loads that `kane check` would hint at."""
    eom = kn.derive(built(d))
    start = kn.assemble(eom, q=d.q, u=d.u or None, parameters=d.values)
    numbers: dict = {kn.time: 0.0}
    numbers |= {p: d.values.get(p.name, p.default) for p in eom.parameters}
    numbers |= {s: d.forces[s.name] for s in eom.inputs}
    numbers |= start.q
    numbers |= start.u
    return {doubt.load.name for doubt in doubtful_loads(eom, numbers)}


@pytest.mark.parametrize(
    "seeds", [range(6), pytest.param(range(2000, 2072), marks=pytest.mark.slow)], ids=["few", "many"]
)
def test_hints_at_springs_that_push_and_dampers_that_feed(seeds):
    """Every stiffness and damping below zero, every spring and drag of the wrong sign; no motor, and nothing of what is sound."""
    for seed in seeds:
        sound = drafted(seed)
        assert doubted(sound) == set(), seed
        for slip in (sign_of_a_value, sign_of_a_force):
            wrong = slip(sound, np.random.default_rng(seed))
            if wrong is None:
                continue
            changed = {
                n
                for n, text in wrong.loads.items()
                if sound.loads[n] != text or any(re.search(rf"\b{v}\b", text) for v in wrong.values)
            }
            passive = changed - {"pull", "push", "motor", *(f"motor {i}" for i in range(4))}
            assert bool(doubted(wrong) & passive) == bool(passive), (seed, changed)
