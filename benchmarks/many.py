# SPDX-License-Identifier: BSD-3-Clause
"""Many double pendulums on one core and two, a second: `python -m benchmarks.many [COUNT [PAIRS]]`, beside heyoka where it is there.

Rods start at rest at random angles and move for 10 s, at the loosest tolerances that keep the energy to 1e-8 in the median: `drift`
is its change over the largest that there is. Both sides run in turn. Two threads are compared with two processes, too, which share
nothing: each has half of the motions. `python -m benchmarks.many poses`: what a pose costs of a crank's turn and of a trajectory of a
Stewart platform, in whole calls; a trim beside that of two poses, as the first is searched for. `python -m benchmarks.many
lanes`: a right-hand side of eight instances at once, an instance, beside one by itself. `python -m benchmarks.many four-bars
OTHER/src`: ten thousand four-bars beside a loop of `kn.simulate` of another checkout. `python -m benchmarks.many gains [COUNT]`:
motions whose inputs differ by gains, frequencies and values.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from functools import cache, partial
from multiprocessing import get_context
from pathlib import Path
from statistics import median
from time import perf_counter, process_time
from typing import Any

import numpy as np

import kane as kn
from benchmarks.against import MOTIONS, ONE_BY_ONE, SETTINGS, Side, cranks
from benchmarks.native import LANES, Array, kernel_of, lanes_loop
from benchmarks.paired import paired
from benchmarks.rhs_cases import optional
from benchmarks.systems import COUNTED
from kane.gallery import four_bar, pendulum_on_cart, pendulums
from tests.systems import stewart

END, GRAVITY = 10.0, 9.81
TOLERANCE, PEERS = 8e-8, 1e-7  # at 1.2e-7 a Taylor series loses an order, and drifts by 3e-8


def starts(count: int) -> Array:
    """Angles from −π to π, at rest."""
    return np.hstack([np.random.default_rng(0).uniform(-np.pi, np.pi, (count, 2)), np.zeros((count, 2))])


def own(threads: int) -> Callable[[Array], Array]:
    """The motions by `kn.simulate_many`."""
    eom = kn.derive(pendulums.system(2))

    def run(x: Array) -> Array:
        runs = kn.simulate_many(
            eom, (0, END), q=x[:, :2], u=x[:, 2:], samples=2, rtol=TOLERANCE, atol=TOLERANCE, threads=threads
        )
        return np.asarray(runs["end_state"])

    return run


def energy(x: Array) -> Array:
    """K + V of two rods of length 1 and mass 1."""
    q1, q2, u1, u2 = x.T
    kinetic = u1**2 * 2 / 3 + u2**2 / 6 + u1 * u2 * np.cos(q1 - q2) / 2
    return np.asarray(kinetic - GRAVITY * (1.5 * np.cos(q1) + 0.5 * np.cos(q2)))


@cache
def _alone() -> Callable[[Array], Array]:
    return own(1)


def _end(x: Array) -> Array:
    return _alone()(x)


class TwoProcesses:
    """Half of the motions in each of two processes."""

    def __init__(self, x: Array) -> None:
        self.halves = np.array_split(x, 2)
        self.pool = ProcessPoolExecutor(2, get_context("spawn"))

    def __call__(self) -> list[Array]:
        """The ends of both."""
        return list(self.pool.map(_end, self.halves))


def _seconds(call: Callable[[], object], turns: int = 5) -> float:
    """The median of whole calls after the first."""
    call()
    times = []
    for _ in range(turns):
        begin = perf_counter()
        call()
        times.append(perf_counter() - begin)
    return median(times)


def _per_pose(name: str, count: int, call: Callable[[], object]) -> None:
    print(f"{name}: {_seconds(call) / count * 1e3:.3f} ms a pose of {count}")


def crank_turn(count: int) -> None:
    """A full turn of a four-bar's crank, and what is asked of it."""
    linkage, drive = four_bar.system(), kn.input("drive", "N*m")
    crank, (u1, *others) = linkage.bodies[0].parts()[0].frame, linkage.speeds
    assert crank is not None
    loads = [kn.gravity(-GRAVITY * linkage.inertial.y), kn.Torque(crank, drive * crank.z)]
    eom = kn.derive(
        linkage.replace(
            loads=loads, reactions=[], dependent_speeds=others, dependent_coordinates=linkage.coordinates[1:]
        )
    )
    q = {"q1": np.linspace(0, 2 * np.pi, count), "q2": kn.guess(0.9), "q3": kn.guess(-1.4)}
    hung = {"q1": kn.guess(-1.9), "q2": kn.guess(1.0), "q3": kn.guess(-0.6)}
    assemble = partial(kn.assemble, eom, q=q, u={u1: 5.0})
    _of_poses("crank", count, assemble, kn.inverse(eom, [drive]), ({u1.dt: 0.0}, {drive: 0.0}), eom)
    _per_pose("crank, trim", count, lambda: kn.trim(eom, q=hung, inputs={drive: np.linspace(0, 8, count)}))


def platform(count: int) -> None:
    """A closed path of a Stewart platform, its 18 coordinates of the legs sought."""
    eom, s = kn.derive(stewart.system()), np.linspace(0, 2 * np.pi, count)
    path: dict[str, Any] = {
        "x": 0.2 * np.cos(s),
        "y": 0.2 * np.sin(s),
        "z": 1.2 + 0.1 * np.sin(2 * s),
        "a1": 0,
        "a2": 0,
        "a3": 0.3 * np.sin(s),
    }
    legs = {f"{name}{k}": kn.guess(x) for k in stewart.LEGS for name, x in (("al", 0.0), ("be", 0.0), ("s", 1.2))}
    assemble = partial(kn.assemble, eom, q=path | legs, u={f"u_{name}": 0.1 for name in stewart.PLATFORM})
    forces = [f"f{k}" for k in stewart.LEGS]
    given = {u.dt: 0.0 for u in eom.independent_speeds}
    _of_poses("platform", count, assemble, kn.inverse(eom, forces), (given, dict.fromkeys(forces, 0.0)), eom)
    held = partial(kn.trim, eom, inputs=dict.fromkeys(forces, kn.guess(0.0)))
    few, many = ({**{name: x[:k] if np.ndim(x) else x for name, x in path.items()}, **legs} for k in (2, count))
    first, whole = _seconds(lambda: held(q=few), 1), _seconds(lambda: held(q=many), 1)
    print(f"platform, trim: {whole:.2f} s for {count} poses, {first:.2f} s for two")


def _of_poses(
    name: str,
    count: int,
    assemble: Callable[[], Any],
    inverse: kn.analysis.Inverse,
    given: tuple[Any, Any],
    eom: kn.Equations,
) -> None:
    _per_pose(f"{name}, assemble", count, assemble)
    found, (rates, inputs) = assemble(), given
    assert set(found.status.values) == {"found"}
    _per_pose(f"{name}, inverse", count, lambda: inverse(found, given=rates))
    _per_pose(f"{name}, constraint_forces", count, lambda: kn.constraint_forces(eom, found, inputs=inputs))
    _per_pose(f"{name}, linearize", count, lambda: kn.linearize(eom, found, inputs=inputs, steady=False))


def lanes() -> None:
    """The least of twenty turns of each, in ns."""
    systems: dict[str, Callable[[], kn.System]] = {f"{n} rods": partial(pendulums.system, n) for n in (10, 40, 100)}
    systems["7R arm"] = COUNTED["7R arm"]
    for name, system in systems.items():
        rhs = kn.derive(system()).compile().rhs
        x = np.random.default_rng(0).uniform(-0.5, 0.5, (len(rhs.program.port("x").symbols), LANES))
        loops = kernel_of(rhs, x[:, 0]).loop, lanes_loop(rhs, x)
        turns = np.array([[loop(1000) for loop in loops] for _ in range(20)])
        one, eight = turns.min(axis=0) * 1e6
        print(f"{name}: {eight / LANES:.1f} ns an instance of {LANES}, {one:.1f} by itself")


def four_bars(other: Path, count: int = 10_000, pairs: int = 15) -> None:
    """Many four-bars on one thread beside a loop of `kn.simulate` of another checkout, a motion, in turn."""
    eom, side = kn.derive(four_bar.system()), Side(other)
    given: dict[str, Any] = {**four_bar.START, **SETTINGS}

    def run() -> Any:
        return kn.simulate_many(eom, (0, END), parameters={"a": np.array(cranks(count))}, threads=1, **given)

    runs = run()
    assert set(runs.status.values) == {"finished"}
    few = [kn.simulate(eom, (0, END), parameters={"a": a}, **given) for a in cranks(count)[::100]]
    left = max(np.abs(r).max() for sol in few for r in sol.constraint_residuals.values())
    print(f"{count} four-bars: constraints are left {left:.1e} m and rad/s at most, in a hundredth of them")
    result = paired(run, lambda: side.seconds(ONE_BY_ONE), pairs)
    ratios = [b / MOTIONS / (a / count) for a, b in zip(result.a, result.b, strict=True)]
    print(f"{count} four-bars: {median(result.a) / count * 1e3:.3f} ms a motion, {median(ratios):.0f} times a loop")


def gains(count: int = 3000) -> None:
    """Processor time of motions of a driven pendulum on a cart whose inputs differ, in µs a motion on one thread."""
    eom = kn.derive(pendulum_on_cart.system(force=True))
    (x, theta), (_, u2), (force,) = eom.coordinates, eom.speeds, eom.inputs
    kp, kd, w = kn.parameter("kp", 40.0), kn.parameter("kd", 8.0), kn.parameter("w", 2.0)
    rng = np.random.default_rng(0)
    law, some, rates = kp * theta + kd * x + 2 * u2, rng.uniform(20, 60, count), rng.uniform(1, 3, count)
    ways: dict[str, tuple[Any, dict[Any, Array]]] = {
        "one law": (law, {}),
        "gains": (law, {kp: some}),
        "a law with a mass": (law / 40 * eom.parameters[1], {eom.parameters[1]: rates}),
        "frequencies": (kp / 10 * kn.sin(w * kn.time), {w: rates, kp: some}),
        "forces": (some / 30, {}),
    }
    q: dict[str, Any] = {"x": 0.1, "theta": rng.uniform(-0.3, 0.3, count)}
    for name, (what, parameters) in ways.items():
        run = partial(
            kn.simulate_many,
            eom,
            (0, 5),
            q=q,
            u=[0, 0],
            inputs={force: what},
            parameters=parameters,
            samples=21,
            threads=1,
        )
        run()
        begun = process_time()
        run()
        print(f"{name}: {(process_time() - begun) / count * 1e6:.0f} µs a motion of {count}")


def main() -> None:
    """Drifts, then pairs: two threads beside one, beside two processes, and the peer; or poses alone, or right-hand sides in lanes."""
    if sys.argv[1:] == ["lanes"]:
        lanes()
        return
    if sys.argv[1:2] == ["four-bars"]:
        four_bars(Path(sys.argv[2]).resolve())
        return
    if sys.argv[1:2] == ["gains"]:
        gains(*map(int, sys.argv[2:]))
        return
    if sys.argv[1:] == ["poses"]:
        for count in (401, 4001):
            crank_turn(count)
            platform(count)
        return
    count, pairs = (int(a) for a in (*sys.argv[1:], *("10000", "5")[len(sys.argv) - 1 :]))
    x = starts(count)
    one, two = own(1), own(2)
    peer = optional("heyoka_batch")
    sides = {"two threads": two} | ({"heyoka": peer.motions(2, END, PEERS, GRAVITY)} if peer else {})
    for name, run in {"kane": one, **sides}.items():
        drift = np.abs(energy(run(x)) - energy(x)) / (4 * GRAVITY)
        print(f"{name}: drift {np.median(drift):.1e} in the median, {drift.max():.1e} at most")
    for name, run in sides.items():
        print(f"{count} motions:", paired(partial(one, x), partial(run, x), pairs).line("kane", name))
    processes = TwoProcesses(x)
    print(f"{count} motions:", paired(partial(two, x), processes, pairs).line("two threads", "two processes"))
    processes.pool.shutdown()


if __name__ == "__main__":
    main()
