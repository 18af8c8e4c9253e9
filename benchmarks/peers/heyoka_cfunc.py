# SPDX-License-Identifier: BSD-3-Clause
"""The pendulum of rods as a heyoka compiled function, by the recursion; heyoka's object code is linked to time it natively."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import heyoka as hy
import numpy as np

from benchmarks.native import Array, Kernel, address, heyoka_loop, link
from benchmarks.peers.recursion import accelerations


@dataclass(frozen=True)
class Model:
    """A cfunc (q, u) → (q̇, u̇) and the names of its parameters."""

    parameters: tuple[str, ...]
    function: Any

    def p(self, values: Mapping[str, float]) -> Array:
        """The parameters as the function's vector."""
        return np.array([values[name] for name in self.parameters])


def chain(n: int) -> Model:
    """n uniform rods in a plane, u = q̇."""
    q, u = (list(hy.make_vars(*(f"{kind}{i:03}" for i in range(n)))) for kind in "qu")
    m, l = [hy.par[i] for i in range(n)], [hy.par[n + i] for i in range(n)]
    found = accelerations(q, u, m, l, hy.par[2 * n], hy.sin, hy.cos)
    names = [f"m{i}" for i in range(1, n + 1)] + [f"l{i}" for i in range(1, n + 1)] + ["g"]
    return Model(tuple(names), hy.cfunc([*u, *found], [*q, *u]))


def kernel(model: Model, x: Array, values: Mapping[str, float]) -> Kernel:
    """The unbatched function."""
    state = model.function.llvm_states[0]
    # helpers of the vector variants are in the object too, unused; their callees live in heyoka's own libraries
    absent = re.findall(r"^declare .*@(heyoka_\w+)\(", state.ir, re.MULTILINE)
    library = link(state.object_code, [f"-Wl,--defsym,{name}=0" for name in absent])
    return heyoka_loop(address(library, "cfunc"), x, model.p(values))
