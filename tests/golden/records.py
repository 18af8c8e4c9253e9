# SPDX-License-Identifier: BSD-3-Clause
"""What is made of each system: counts, digests of emitted text, accelerations, the end of a motion, what is said of it.

The systems are those of the gallery, those of which operations are counted, and random ones of the kinds that slips of the pen are
tried on, each sound and with a slip.
"""

from __future__ import annotations

import hashlib
import warnings
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from typing import Any

import numpy as np

import kane as kn
from benchmarks.systems import COUNTED
from kane.gallery import GALLERY, load
from tests.golden.compare import COUNTS, TEXTS, Record
from tests.systems.draft_kinds import drafted
from tests.systems.drafts import built, verdict
from tests.systems.slips import slipped

RANDOM = 1000
"""Random systems."""

SPAN = (0.0, 0.05)


def made(random: int, jobs: int) -> dict[str, Record]:
    """The records of all systems, by name; each is made alike in whatever process."""
    names = list(systems(random))
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        return dict(zip(names, pool.map(record_of, names, chunksize=8), strict=True))


def systems(random: int) -> Iterator[str]:
    """Their names."""
    yield from (f"gallery: {name}" for name in GALLERY)
    yield from (f"counted: {name}" for name in COUNTED)
    yield from (f"random {seed}" for seed in range(random))


def record_of(name: str) -> Record:
    """The record of a system by its name."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        kind, _, which = name.partition(" ")
        record = _KINDS[kind](which)
    if caught:
        record["warned"] = sorted({f"{w.category.__name__}: {w.message}" for w in caught})
    return record


def emitted(eom: kn.Equations) -> Record:
    """Operations by tier, and digests of the text in C and NumPy, whatever the version of kane in it."""
    compiled = eom.compile()
    record: Record = {tier: getattr(eom.operations, tier) for tier in COUNTS}
    for target in TEXTS:
        record[target] = hashlib.sha256(
            compiled.emit(target).replace(f"kane {kn.__version__}", "kane").encode()
        ).hexdigest()[:16]
    return record


def moved(eom: kn.Equations, start: Mapping[str, Any]) -> Record:
    """Accelerations at the start, and the state at the end of a motion."""
    sol = kn.simulate(eom, SPAN, samples=2, rtol=1e-11, atol=1e-11, **start)
    ends = [*eom.coordinates, *eom.speeds]
    return {
        "accelerations": [float(v[0]) for v in sol[[u.dt for u in eom.speeds]]],
        "end": [float(v[-1]) for v in sol[ends]],
        "status": sol.status,
    }


def _of_gallery(name: str) -> Record:
    module = load(name)
    eom = kn.derive(module.system())
    start = getattr(module, "START", None) or _somewhere(eom)
    return emitted(eom) | moved(eom, start)


def _somewhere(eom: kn.Equations) -> dict[str, Any]:
    """Values that differ, away from where angles are singular, for a system without constraints and without a start of its own."""
    rng = np.random.default_rng(17)
    q: dict[Any, float] = {c: float(rng.uniform(0.3, 1.2)) for c in eom.coordinates}
    for euler in eom.system.euler_parameters:
        q |= dict(zip(euler.coordinates, (0.8, 0.0, 0.6, 0.0), strict=True))
    return {"q": q, "u": {u: 0.1 * float(rng.standard_normal()) for u in eom.speeds}}


def _of_draft(number: str) -> Record:
    seed = int(number)
    draft = drafted(seed)
    eom = kn.derive(built(draft))
    start: dict[str, Any] = {
        "q": draft.q,
        "u": draft.u or None,
        "parameters": draft.values,
        "inputs": draft.forces or None,
    }
    slip, wrong = slipped(draft, np.random.default_rng([seed, 1]))
    said, where, kind = verdict(wrong)
    return emitted(eom) | moved(eom, start) | {"slip": slip, "said": said, "where": where, "kind": kind}


_KINDS: dict[str, Callable[[str], Record]] = {
    "gallery:": _of_gallery,
    "counted:": lambda name: emitted(kn.derive(COUNTED[name]())),
    "random": _of_draft,
}
"""How the record of a system is made, by the first word of its name."""
