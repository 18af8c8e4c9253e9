# SPDX-License-Identifier: BSD-3-Clause
"""All of ∂u̇/∂(q, u) against Pinocchio's computeABADerivatives, both in native loops: `python -m benchmarks.jacobian [name]`.

The derivatives are compared first. kane gives all of ∂(q̇, u̇)/∂(q, u); masses, and lengths where they are declared, are arguments.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from benchmarks.native import kernel_of
from benchmarks.random_trees import Link, Mass
from benchmarks.rhs_cases import optional
from benchmarks.rounds import Loop, in_turn, summary
from benchmarks.systems import arm
from benchmarks.tree_cases import CASES, TreeCase

_ROUNDS, _SECONDS, _TOLERANCE = 31, 2e-3, 1e-9
_WANTED = ("7R arm, general axes", "tree of 20 bodies", "four limbs of six joints on a floating base")


def arm_links(axes: str) -> tuple[None, list[Link]]:
    """The numbers of `arm`, on the ground."""
    unit = dict(zip("xyz", np.eye(3), strict=True))
    along = np.array([0.0, 0.0, 1.0])
    body = Mass(1.0, 0.25 * along, 0.1 * np.eye(3))
    return None, [Link(k - 1, np.eye(3), 0.5 * along * (k > 0), unit[axis], body) for k, axis in enumerate(axes)]


def cases() -> list[TreeCase]:
    """Those that are compared."""
    aligned = TreeCase("7R arm", lambda: arm("zyzyzyz"), lambda: arm_links("zyzyzyz"))
    return [aligned, *(case for case in CASES if case.name in _WANTED)]


def depth_first(links: Sequence[Link]) -> list[int]:
    """An order in which those that hang on one stand right after it, as Pinocchio's derivatives take them to."""
    order: list[int] = []
    waiting = [k for k, link in reversed(list(enumerate(links))) if link.parent < 0]
    while waiting:
        k = waiting.pop()
        order.append(k)
        waiting += [i for i, link in reversed(list(enumerate(links))) if link.parent == k]
    return order


def compared_loops(case: TreeCase) -> tuple[dict[str, Loop], float]:
    """The loops of a case, and the largest difference over the largest derivative."""
    eom, (trunk, links), (q, v) = case.eom, case.links(), case.state
    n, count = len(links), len(case.eom.coordinates)
    code = eom.compile()
    found = {"kane rhs": kernel_of(code.rhs, case.x), "kane jac": kernel_of(code.jac, case.x)}
    loops: dict[str, Loop] = {name: kernel.loop for name, kernel in found.items()}
    off = np.nan
    if pinocchio := optional("pinocchio_tree"):
        order = depth_first(links)
        place = {-1: -1, **{k: i for i, k in enumerate(order)}}
        sorted_links = [replace(links[k], parent=place[links[k].parent]) for k in order]
        tree = pinocchio.tree(sorted_links, np.array(case.gravity), trunk)
        at, rates = case.base
        state = np.concatenate((at, q[order])), np.concatenate((rates[3:], rates[:3], v[order]))
        loops["Pinocchio aba"], _ = tree.accelerations(*state, local=False)
        loops["Pinocchio derivatives"], theirs = tree.derivatives(*state)
        loops["Pinocchio derivatives"](1)
        found["kane jac"].loop(1)
        j = found["kane jac"].out.reshape(code.jac.shape)
        own = np.array([j[-n:, count - n : count], j[-n:, -n:]])[:, order][:, :, order]
        off = float(np.abs(own - theirs[:, -n:, -n:]).max() / np.abs(theirs).max())
    return loops, off


def measured(case: TreeCase, rounds: int) -> dict[str, Any]:
    """Nanoseconds a call of all contenders, and two ratios, round by round.

    Raises
    ------
    ArithmeticError
        if derivatives differ by more than 1e-9 of the largest
    """
    loops, off = compared_loops(case)
    if off > _TOLERANCE:
        raise ArithmeticError(f"Pinocchio's derivatives differ from kane's of {case.name} by {off:.1e}.")
    times = in_turn(loops, rounds)
    own = times["kane jac"]
    ratios = {"jac / rhs": (own, times["kane rhs"])}
    if "Pinocchio derivatives" in times:
        ratios["Pinocchio derivatives / jac"] = times["Pinocchio derivatives"], own
    operations = {"rhs": case.eom.operations.state, "jac": case.eom.jacobian().operations.state}
    return {
        "operations": operations,
        "ns": {name: summary(values, 1e-9) for name, values in times.items()},
        "ratios": {name: summary([a / b for a, b in zip(x, y, strict=True)]) for name, (x, y) in ratios.items()},
    }


def compare(case: TreeCase) -> dict[str, float]:
    """Nanoseconds of a call, the least of several rounds, and the largest difference over the largest derivative."""
    loops, off = compared_loops(case)
    return {**{name: _least(loop) for name, loop in loops.items()}, "off": off}


def _least(loop: Loop) -> float:
    calls = max(1, round(_SECONDS / max(loop(10) / 10, 1e-9)))
    return float(min(loop(calls) for _ in range(_ROUNDS)) / calls * 1e9)


def main() -> None:
    """Print the figures of every case, or of those whose name holds an argument."""
    for case in cases():
        if sys.argv[1:] and not any(a in case.name for a in sys.argv[1:]):
            continue
        found = compare(case)
        print(case.name)
        print("   ", "  ".join(f"{name} {x:.3g}" for name, x in found.items()))
        shares = [f"jac / rhs {found['kane jac'] / found['kane rhs']:.2f}"]
        if "Pinocchio derivatives" in found:
            shares.append(f"Pinocchio derivatives / jac {found['Pinocchio derivatives'] / found['kane jac']:.2f}")
        print("   ", "  ".join(shares))


if __name__ == "__main__":
    main()
