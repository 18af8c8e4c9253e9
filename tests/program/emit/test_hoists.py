# SPDX-License-Identifier: BSD-3-Clause
"""Programs of one library whose parameters take more than one function each."""

from __future__ import annotations

import re

import pytest

import kane as kn
from kane.program import Port, Task, build_program, emit_llvm

(q,), p = kn.coordinates("q,"), kn.parameters("p1:61")
PORTS = (Port("q", (q,)), Port("p", p, "parameter"))


@pytest.mark.slow
def test_long_hoists_of_several_programs_have_names_of_their_own() -> None:
    """The pieces of the first are not called as the whole of the second."""
    programs = [
        build_program("", PORTS, [Task(name, [q * kn.sin(x * y + k) for x in p for y in p], (3600,), ("",) * 3600)])
        for k, name in enumerate(("one", "two"))
    ]
    names = re.findall(r"^define [^@]*@([\w.]+)\(", emit_llvm(programs), re.MULTILINE)
    assert any(re.fullmatch(r"one\.hoist\.\d+", name) for name in names)
    assert len(set(names)) == len(names)
