# SPDX-License-Identifier: BSD-3-Clause
"""Trees of pins in Pinocchio's C++, compiled against the headers of its wheel; Eigen's are those of cmeel-eigen."""

from __future__ import annotations

import ctypes
import hashlib
import subprocess
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import pinocchio as pin

from benchmarks.native import Array
from benchmarks.random_trees import Link, Mass, along_z

SOURCE = Path(__file__).with_suffix(".cpp")
_BUILD = Path(__file__).parents[2] / "build" / "benchmarks"
CXX, FLAGS = "g++", ("-std=c++17", "-O3", "-DNDEBUG", "-w")
_LIMITS = (
    "-DBOOST_MPL_LIMIT_LIST_SIZE=30",
    "-DBOOST_MPL_LIMIT_VECTOR_SIZE=30",
    "-DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS",
    "-DBOOST_FUSION_INVOKE_MAX_ARITY=10",
    "-DFUSION_MAX_VECTOR_SIZE=10",
)


@cache
def library() -> ctypes.CDLL:
    """The driver; Pinocchio's templates are instantiated in it, which takes a minute or two, once."""
    prefix = Path(pin.__file__).parents[4]
    include, lib = prefix / "include", prefix / "lib"
    out = (
        _BUILD / f"pinocchio_tree-{hashlib.sha256(SOURCE.read_bytes() + pin.__version__.encode()).hexdigest()[:16]}.so"
    )
    headers = (f"-I{include}", f"-I{include / 'eigen3'}")
    linked = (f"-L{lib}", f"-Wl,-rpath,{lib}", "-lpinocchio_default", "-lboost_serialization", "-lboost_filesystem")
    if not out.exists():
        _BUILD.mkdir(parents=True, exist_ok=True)
        command = [CXX, *FLAGS, *_LIMITS, *headers, "-shared", "-fPIC", str(SOURCE), "-o", str(out), *linked]
        subprocess.run(command, check=True)
    found = ctypes.CDLL(str(out))
    found.tree_new.restype = ctypes.c_void_p
    found.tree_aba.restype = found.tree_derivatives.restype = ctypes.c_double
    return found


def _doubles(a: Array) -> ctypes.c_void_p:
    return ctypes.c_void_p(a.ctypes.data)


@dataclass(frozen=True)
class PinocchioTree:
    """A tree with z of each joint frame along its axis."""

    handle: int
    freedoms: int

    def accelerations(self, q: Array, v: Array, *, local: bool) -> tuple[Callable[[int], float], Array]:
        """Seconds of n calls of `aba`, and v̇ after them; about the world's origin or in the bodies' frames."""
        out = np.empty(self.freedoms)
        f = library().tree_aba
        arguments = (ctypes.c_void_p(self.handle), _doubles(q), _doubles(v), _doubles(out), ctypes.c_long(local))
        return lambda n, _alive=(q, v, out): float(f(ctypes.c_long(n), *arguments)), out

    def derivatives(self, q: Array, v: Array) -> tuple[Callable[[int], float], Array]:
        """Seconds of n calls of `computeABADerivatives`, and ∂v̇/∂q, ∂v̇/∂v after them."""
        out = np.empty((2, self.freedoms, self.freedoms))
        f = library().tree_derivatives
        arguments = (ctypes.c_void_p(self.handle), _doubles(q), _doubles(v), _doubles(out))
        return lambda n, _alive=(q, v, out): float(f(ctypes.c_long(n), *arguments)), out


def tree(links: Sequence[Link], gravity: Array, trunk: Mass | None = None) -> PinocchioTree:
    """The tree of links, on the ground or on a base that floats."""
    own = along_z(links)
    parents = np.array([link.parent for link in own], dtype=np.int64)
    turns, places = (np.array([getattr(link, name) for link in own]) for name in ("seat", "at"))
    masses, centers, inertias = (
        np.array([getattr(link.body, name) for link in own]) for name in ("mass", "center", "inertia")
    )
    base = np.zeros(13) if trunk is None else np.concatenate(([trunk.mass], trunk.center, trunk.inertia.ravel()))
    arrays = [np.ascontiguousarray(a) for a in (parents, turns, places, masses, centers, inertias, gravity, base)]
    pointers = [ctypes.c_void_p(a.ctypes.data) for a in arrays]
    handle = library().tree_new(ctypes.c_long(len(links)), ctypes.c_long(trunk is not None), *pointers)
    return PinocchioTree(handle, len(links) + 6 * (trunk is not None))
