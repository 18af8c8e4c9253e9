# SPDX-License-Identifier: BSD-3-Clause
"""Trees for the comparison with robotics engines: kane's system, the same links for the peers, one state for all.

The tree of 20 bodies is `BRANCHES` with axes, tilts and inertias drawn with `SEED`, all of them general. How many operations a tree
takes depends on which body hangs on which, so that a count means this one.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

import kane as kn
from benchmarks import native
from benchmarks.native import Array, Kernel
from benchmarks.peers import casadi_ad
from benchmarks.random_trees import BRANCHES, LIMBS, Link, Mass, planar_links, random_links, random_tree
from benchmarks.rhs_cases import optional
from benchmarks.rounds import Loop
from kane.gallery import pendulums

SEED = 1


@dataclass(frozen=True)
class TreeCase:
    """A tree of pins, on the ground or on a base that floats; `absolute` where kane's angles and speeds are not the joints'.

    `rods` says how many rods a planar pendulum of uniform rods has.
    """

    name: str
    system: Callable[[], kn.System]
    links: Callable[[], tuple[Mass | None, Sequence[Link]]]
    gravity: tuple[float, float, float] = (0.0, 0.0, -9.81)
    floating: bool = False
    absolute: bool = False
    rods: int = 0

    @cached_property
    def eom(self) -> kn.Equations:
        """The derived equations."""
        return kn.derive(self.system())

    @cached_property
    def state(self) -> tuple[Array, Array]:
        """Joint angles and rates."""
        rng, n = np.random.default_rng(7), len(self.links()[1])
        return rng.uniform(-1, 1, n), rng.uniform(-1, 1, n)

    @cached_property
    def base(self) -> tuple[Array, Array]:
        """Place and direction cosines (x, y, z, quaternion x, y, z, w), and ω, v along its own axes; empty on the ground."""
        if not self.floating:
            return np.zeros(0), np.zeros(0)
        rng = np.random.default_rng(8)
        e = rng.normal(size=4)
        return np.concatenate((rng.uniform(-1, 1, 3), e / np.linalg.norm(e))), rng.uniform(-1, 1, 6)

    @cached_property
    def x(self) -> Array:
        """kane's state (q, u)."""
        q, v = self.state
        if self.absolute:
            q, v = np.cumsum(q), np.cumsum(v)
        if not self.floating:
            return np.concatenate((q, v))
        place, rates = self.base
        x, y, z, w = place[3:]
        return np.concatenate(((w, x, y, z), place[:3], q, rates, v))

    @cached_property
    def expected(self) -> Array:
        """Accelerations of the joints by the reference evaluator; of a base that floats ω̇, then v̇ before them."""
        n = len(self.eom.coordinates)
        found = np.array(self.eom.evaluate(list(self.eom.accelerations), q=self.x[:n], u=self.x[n:]), dtype=float)
        return np.diff(found, prepend=0.0) if self.absolute else found


def _pendulum(n: int, relative: bool) -> TreeCase:
    return TreeCase(
        f"planar chain, {'relative' if relative else 'absolute'} angles, {n}",
        lambda: pendulums.system(n, relative=relative),
        lambda: (None, planar_links(n)),
        (0.0, -9.81, 0.0),
        absolute=not relative,
        rods=n,
    )


def _random(name: str, parents: Sequence[int], general: bool, floating: bool = False) -> TreeCase:
    return TreeCase(
        f"{name}, every number a parameter" if general else name,
        lambda: random_tree(parents, SEED, floating=floating, general=general),
        lambda: random_links(parents, SEED, floating=floating),
        floating=floating,
    )


CASES = (
    *(_pendulum(n, relative) for relative in (False, True) for n in (10, 40, 100)),
    *(
        _random(name, parents, general, floating)
        for name, parents, floating in (
            ("7R arm, general axes", range(-1, 6), False),
            ("tree of 20 bodies", BRANCHES, False),
            ("four limbs of six joints on a floating base", LIMBS, True),
            ("spatial chain, 100", range(-1, 99), False),
        )
        for general in (False, True)
    ),
)


def _agree(case: TreeCase, name: str, found: Array, tolerance: float = 1e-9) -> None:
    error = float(np.abs(found - case.expected).max() / np.abs(case.expected).max())
    if not error < tolerance:
        raise ArithmeticError(f"{name} differs from kane's evaluation of {case.name} by {error:.1e}.")


def _joint_accelerations(case: TreeCase, rates: Array) -> Array:
    u_dot = rates[len(case.eom.coordinates) :]
    return np.diff(u_dot, prepend=0.0) if case.absolute else u_dot


def kane_loops(case: TreeCase) -> dict[str, Loop]:
    """kane's compiled right-hand side; with the parameter tier at every call, too."""
    kernel = native.kane_kernel(case.eom, case.x, {})
    found = {"kane": native.kane_loop(kernel), "kane, parameter tier at every call": native.kane_hoisting_loop(kernel)}
    return {name: _checked(case, name, k) for name, k in found.items()}


def _checked(case: TreeCase, name: str, kernel: Kernel) -> Loop:
    kernel.loop(1)
    _agree(case, name, _joint_accelerations(case, kernel.out))
    return kernel.loop


def peer_loops(case: TreeCase) -> dict[str, Loop]:
    """The peers', each checked against kane's reference evaluator first."""
    loops: dict[str, Loop] = {}
    (trunk, links), gravity, (q, v) = case.links(), np.array(case.gravity), case.state
    if pinocchio := optional("pinocchio_tree"):
        place, rates = case.base
        tree = pinocchio.tree(links, gravity, trunk)
        at, by = np.concatenate((place, q)), np.concatenate((rates[3:], rates[:3], v))
        for name, local in (("Pinocchio aba", False), ("Pinocchio aba, local", True)):
            loop, out = tree.accelerations(at, by, local=local)
            loop(1)
            _agree(case, name, np.concatenate((out[3:6], out[:3], out[6:])) if case.floating else out)
            loops[name] = loop
    if not case.floating and (mujoco := optional("mujoco_tree")):
        loop, accelerations = mujoco.forward(links, gravity, q, v)
        loop(1)
        # its bodies have 1e-9 kg m² more
        _agree(case, "MuJoCo mj_forward", accelerations(), 1e-4)
        loops["MuJoCo mj_forward"] = loop
    if case.rods and case.absolute:
        values = {p.name: float(p.default or 1.0) for p in case.eom.parameters}
        kernel = casadi_ad.kernel(casadi_ad.chain_recursive(case.rods), case.x, values)
        loops["CasADi C, recursion"] = _checked(case, "CasADi C, recursion", kernel)
        if heyoka := optional("heyoka_cfunc"):
            compiled = heyoka.kernel(heyoka.chain(case.rods), case.x, values)
            loops["heyoka, recursion"] = _checked(case, "heyoka, recursion", compiled)
    return loops
