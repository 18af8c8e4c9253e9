# SPDX-License-Identifier: BSD-3-Clause
"""The right-hand sides that are compared: kane's system, the peers' counterparts, a random state and random parameters."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from types import ModuleType
from typing import Any

import numpy as np

import kane as kn
from benchmarks import native
from benchmarks.native import Array, KaneKernel, Kernel
from benchmarks.peers import casadi_ad
from benchmarks.rounds import Loop, python_loop
from kane.gallery import pendulums, rolling_disk, spinning_top


@dataclass(frozen=True)
class Case:
    """A system with coordinates and speeds of up to ±`reach`; `rods` says how many where it is the planar pendulum."""

    name: str
    system: Callable[[], kn.System]
    model: Callable[[], casadi_ad.Model]
    reach: float = 1.0
    rods: int = 0

    @cached_property
    def eom(self) -> kn.Equations:
        """The derived equations."""
        return kn.derive(self.system())

    @cached_property
    def x(self) -> Array:
        """A random state (q, u)."""
        return np.random.default_rng(7).uniform(-self.reach, self.reach, 2 * len(self.eom.speeds))

    @cached_property
    def values(self) -> dict[str, float]:
        """Parameters within a factor 1.5 of their defaults, none equal to another."""
        generator = np.random.default_rng(11)
        return {p.name: float(p.default or 1.0) * generator.uniform(0.7, 1.4) for p in self.eom.parameters}

    @cached_property
    def expected(self) -> Array:
        """ẋ by the reference evaluator."""
        n = len(self.eom.coordinates)
        found = self.eom.evaluate(self.eom.right_hand_side, q=self.x[:n], u=self.x[n:], parameters=self.values)
        return np.array(found, dtype=np.float64)


def pendulum(n: int) -> Case:
    """n uniform rods, absolute angles, every mass and length and g a parameter."""
    return Case(f"pendulum, {n} rods", lambda: pendulums.system(n), lambda: casadi_ad.chain(n), np.pi, n)


CASES = (
    pendulum(2),
    pendulum(10),
    Case("spinning top", spinning_top.system, casadi_ad.top),
    Case("sliding disk", rolling_disk.system, casadi_ad.disk),
)


def optional(name: str) -> ModuleType | None:
    """A peer's module, None where the peer is not installed."""
    try:
        return importlib.import_module(f"benchmarks.peers.{name}")
    except ModuleNotFoundError:
        return None


def error(case: Case, found: Any) -> float:
    """Largest relative difference from the reference evaluator, of ẋ or of u̇ alone."""
    values = np.asarray(found, dtype=np.float64).ravel()
    return float(np.abs(values - case.expected[-len(values) :]).max() / np.abs(case.expected).max())


def checked(case: Case, name: str, kernel: Kernel) -> Loop:
    """The kernel's loop, once its result is that of the reference evaluator."""
    kernel.loop(1)
    agree(case, name, kernel.out)
    return kernel.loop


def agree(case: Case, name: str, found: Any) -> None:
    """Refuse a contender that computes something else."""
    if not error(case, found) < 1e-9:
        raise ArithmeticError(f"{name} differs from kane's evaluation of {case.name} by {error(case, found):.1e}.")


def native_loops(case: Case, kane: KaneKernel | None) -> dict[str, Loop]:
    """Every compiled contender's native loop, checked."""
    kernels: dict[str, Kernel] = {}
    if kane is not None:
        kernels["kane"] = native.kane_loop(kane)
        kernels["kane, parameter tier at every call"] = native.kane_hoisting_loop(kane)
    model = case.model()
    kernels["CasADi C"] = casadi_ad.kernel(model, case.x, case.values)
    kernels["CasADi C, -O1"] = casadi_ad.kernel(model, case.x, case.values, ("-O1",))
    if case.rods:
        recursive = casadi_ad.chain_recursive(case.rods)
        kernels["CasADi C, recursion"] = casadi_ad.kernel(recursive, case.x, case.values)
        if heyoka := optional("heyoka_cfunc"):
            kernels["heyoka, recursion"] = heyoka.kernel(heyoka.chain(case.rods), case.x, case.values)
    return {name: checked(case, name, kernel) for name, kernel in kernels.items()}


def python_loops(case: Case, kane: KaneKernel | None) -> dict[str, Loop]:
    """Every contender called from Python, checked; the planar pendulum only."""
    loops: dict[str, Loop] = {}
    n, x, values = case.rods, case.x, case.values
    if kane is not None:
        agree(case, "kane", kane.rhs(kane.t, kane.x, kane.p))
        loops["kane, native"] = checked(case, "kane", native.kane_loop(kane))
        loops["kane"] = python_loop(kane.rhs, kane.t, kane.x, kane.p)
    model = case.model()
    agree(case, "CasADi", model.function(x, model.p(values)))
    loops["CasADi"] = python_loop(model.function, x, model.p(values))
    buffered, out = casadi_ad.buffered(model, x, values)
    buffered()
    agree(case, "CasADi, buffers", out)
    loops["CasADi, buffers"] = python_loop(buffered)
    if heyoka := optional("heyoka_cfunc"):
        compiled = heyoka.chain(n)
        call = partial(compiled.function, pars=compiled.p(values), outputs=np.empty_like(x))
        agree(case, "heyoka", call(x))
        loops["heyoka"] = python_loop(call, x)
    for name, file in (("Pinocchio aba", "pinocchio_aba"), ("MuJoCo mj_forward", "mujoco_forward")):
        if peer := optional(file):
            agree(case, name, peer.accelerations(n, x, values))
            f, arguments = peer.call(n, x, values)
            loops[name] = python_loop(f, *arguments)
    if pydy := optional("pydy_cython"):
        f, arguments = pydy.call(n, x, values)
        agree(case, "PyDy", f(*arguments))
        loops["PyDy, Cython"] = python_loop(f, *arguments)
    return loops
