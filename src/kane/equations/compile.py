# SPDX-License-Identifier: BSD-3-Clause
"""`compile`: machine code of equations of motion."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from kane.equations.compiled import Compiled
from kane.equations.equations import Equations
from kane.errors import ArgumentError
from kane.program.native.compiled_routine import NotFinite


def compile(
    eom: Equations,
    *,
    name: str = "model",
    outputs: Mapping[str, Any] | None = None,
    parameters: Mapping[Any, float] | None = None,
    contract: bool = True,
    cpu: str = "host",
    features: str = "",
    cache: bool = True,
    not_finite: NotFinite = "warn",
) -> Compiled:
    """Machine code of the equations, through LLVM; no compiler is needed on the machine.

    Parameters
    ----------
    eom : Equations
    name : what the emitted functions are called after
    outputs : expressions, vectors, matrices by name, for `Compiled.outputs`
    parameters : values by symbol or name that replace defaults where a call gives no p
    contract : let a·b + c round once (FMA) and divisions by one divisor share its reciprocal; False rounds each operation of the
        expressions by itself, so that those of + − × ÷ √ are NumPy's bit by bit
    cpu : "host", or "generic" for what every processor of this kind has
    features : what to add to "generic", as LLVM calls it: "+avx2,+fma"
    cache : keep the code in the user's cache folder, so that a second run compiles nothing (see `KANE_CACHE`)
    not_finite : "warn", "raise" or "ignore" where a result is infinite or NaN

    Raises
    ------
    ValueMissingError
        if `parameters` names something else
    ProgramError
        if the code could not run on this processor
    """
    if not isinstance(eom, Equations):
        raise ArgumentError(
            f"Expected Equations, got {type(eom).__name__}: derive them first, kn.derive(system).compile()."
        )
    return eom.compile(
        name=name,
        outputs=outputs,
        parameters=parameters,
        contract=contract,
        cpu=cpu,
        features=features,
        cache=cache,
        not_finite=not_finite,
    )
