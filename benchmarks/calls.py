# SPDX-License-Identifier: BSD-3-Clause
"""What calls from Python cost, beside peers: `make bench-calls` writes calls.json and calls.md.

Two runs, each a process of its own; within a run all contenders of a table take turns. `--once` prints one run as JSON.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

import kane as kn
from benchmarks import calls_table, native
from benchmarks.calls_table import BY_NAME, FEW, INPUT, JAC, LONG, MANY, OVER, PARTS, ROWS, SINGLE
from benchmarks.machine import processor, versions
from benchmarks.native import Array
from benchmarks.peers import casadi_ad
from benchmarks.rhs_cases import Case, agree, optional, pendulum
from benchmarks.rounds import Loop, in_turn, python_loop, summary
from kane.gallery import pendulum_on_cart

HERE = Path(__file__).parent
ROUNDS, RUNS = 15, 2
RODS = (2, 10)
SYMPY = 2
"""Rods up to which SymPy's functions are made in seconds."""
Contender = tuple[Callable[..., Any], tuple[Any, ...]]


def rows(case: Case, count: int) -> Array:
    """Random states (count × n), of which the first is the case's own."""
    found = np.random.default_rng(3).uniform(-case.reach, case.reach, (count, len(case.x)))
    found[0] = case.x
    return found


def singles(case: Case) -> dict[str, Contender]:
    """One state."""
    code, x, values, n = case.eom.compile(parameters=case.values), case.x, case.values, case.rods
    p = code.parameters(values)
    model = case.model()
    found: dict[str, Contender] = {
        "kane": (code.rhs, (0.0, x, p)),
        f"kane, {BY_NAME}": (code.rhs, (0.0, x, values)),
        "kane, one parameter by name": (code.rhs, (0.0, x, {"g": values["g"]})),
        "CasADi": (model.function, (x, model.p(values))),
    }
    found["CasADi, buffers"] = (casadi_ad.buffered(model, x, values)[0], ())
    if heyoka := optional("heyoka_cfunc"):
        compiled = heyoka.chain(n)
        found["heyoka"] = (
            lambda x, p, out: compiled.function(x, pars=p, outputs=out),
            (x, compiled.p(values), np.empty_like(x)),
        )
    if pinocchio := optional("pinocchio_aba"):
        found["Pinocchio aba"] = pinocchio.call(n, x, values)
    if n <= SYMPY and (pydy := optional("pydy_cython")):
        found["SymPy lambdify, NumPy"] = pydy.call(n, x, values, "lambdify")
    return found


def batches(case: Case, count: int) -> dict[str, Contender]:
    """Rows of states."""
    code, x, values = case.eom.compile(), rows(case, count), case.values
    p, model = code.parameters(values), case.model()
    found: dict[str, Contender] = {
        "kane": (code.rhs, (0.0, x, p)),
        f"kane, {BY_NAME}": (code.rhs, (0.0, x, values)),
        "kane, times by rows": (code.rhs, (np.zeros(count), x, p)),
        "CasADi": (model.function, (ca.DM(x.T), model.p(values))),
    }
    if heyoka := optional("heyoka_cfunc"):
        compiled = heyoka.chain(case.rods)
        columns = np.ascontiguousarray(x.T)
        pars = np.repeat(compiled.p(values)[:, None], count, axis=1)
        out = np.empty_like(columns)
        found["heyoka"] = (lambda x, p, out: compiled.function(x, pars=p, outputs=out), (columns, pars, out))
    return found


def jacobians(case: Case) -> dict[str, Contender]:
    """∂ẋ/∂x at one state; Pinocchio's by its own coordinates."""
    code, x, values = case.eom.compile(), case.x, case.values
    p, model = code.parameters(values), case.model()
    found: dict[str, Contender] = {"kane": (code.jac, (0.0, x, p))}
    x_, p_ = ca.SX.sym("x", len(x)), ca.SX.sym("p", len(p))
    slopes = ca.Function("slopes", [x_, p_], [ca.jacobian(model.function(x_, p_), x_)])
    found["CasADi"] = (slopes, (x, model.p(values)))
    if optional("pinocchio_aba"):
        import pinocchio as pin

        from benchmarks.peers import pinocchio_aba

        _, arguments = pinocchio_aba.call(case.rods, x, values)
        found["Pinocchio computeABADerivatives"] = (pin.computeABADerivatives, arguments)
    return found


def check(case: Case) -> None:
    """All that can be compared gives the same numbers."""
    for name, (f, arguments) in singles(case).items():
        if "buffers" not in name:
            found = np.asarray(f(*arguments), dtype=np.float64).ravel()
            agree(case, name, np.cumsum(found) if "Pinocchio" in name else found)
    for name, (f, arguments) in batches(case, FEW).items():
        found = np.asarray(f(*arguments), dtype=np.float64)
        agree(case, name, found[0] if name.startswith("kane") else found[:, 0])
    both = jacobians(case)
    own, other = (np.asarray(both[name][0](*both[name][1])) for name in ("kane", "CasADi"))
    if not np.abs(own - other).max() < 1e-9 * np.abs(own).max():
        raise ArithmeticError(f"The Jacobians of {case.name} differ by {np.abs(own - other).max():.1e}.")


def with_input() -> dict[str, Contender]:
    """One state of a cart and pendulum, whose force is an array or comes by name."""
    code = kn.derive(pendulum_on_cart.system(force=True)).compile()
    x = np.array([0.1, 0.2, 0.3, 0.4])
    return {
        "kane, an input as an array (cart)": (code.rhs, (0.0, x, None, np.array([2.0]))),
        f"kane, {INPUT} (cart)": (code.rhs, (0.0, x, None, {"F": 2.0})),
    }


def measure(case: Case) -> dict[str, Any]:
    """Microseconds a call by table and contender, and what kane's calls take beside their evaluations."""
    check(case)
    kernel = native.kane_loop(native.kane_kernel(case.eom, case.x, case.values)).loop
    tables = {
        SINGLE: singles(case) | with_input(),
        ROWS: batches(case, FEW),
        LONG: batches(case, MANY),
        JAC: jacobians(case),
    }
    found: dict[str, Any] = {"us": {}, OVER: {}}
    for part in PARTS:
        loops: dict[str, Loop] = {name: python_loop(f, *arguments) for name, (f, arguments) in tables[part].items()}
        times = in_turn(loops | {"native": kernel}, ROUNDS)
        evaluations = {SINGLE: 1, ROWS: FEW, LONG: MANY}.get(part, 0)
        own = times.pop("native")
        found["us"][part] = {name: summary(values, 1e-6) for name, values in times.items()}
        found[OVER][part] = {
            name: summary([a - evaluations * b for a, b in zip(values, own, strict=True)], 1e-6)
            for name, values in times.items()
            if name.startswith("kane") and evaluations
        }
    return found


def once() -> dict[str, Any]:
    """One run."""
    return {case.name: measure(case) for case in map(pendulum, RODS)}


def main() -> None:
    """Measure, print the tables, write them."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--once", action="store_true", help="one run, as JSON")
    if parser.parse_args().once:
        print(json.dumps(once()))
        return
    command = [sys.executable, "-m", "benchmarks.calls", "--once"]
    runs = [
        json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True, cwd=HERE.parent).stdout)
        for _ in range(RUNS)
    ]
    record = {
        "processor": processor(),
        "versions": versions(),
        "rounds": ROUNDS,
        "targets": calls_table.targets(runs),
        "runs": runs,
    }
    text = calls_table.document(record)
    print(text)
    (HERE / "calls.json").write_text(json.dumps(record, indent=1) + "\n")
    (HERE / "calls.md").write_text(text)


if __name__ == "__main__":
    main()
