# SPDX-License-Identifier: BSD-3-Clause
"""`kane bench`: times and operation counts of a model on this machine."""

import time
from collections.abc import Callable
from statistics import median
from timeit import Timer
from typing import Any

import numpy as np
import typer

import kane as kn
from kane.cli import screen
from kane.cli.derive import inputs_at
from kane.cli.models import AsJson, Name, model_of
from kane.cli.screen import user_code
from kane.cli.simulate import NamedStart, start
from kane.progress import working

_ROUNDS, _LEAST, _BATCH = 7, 0.01, 4096


def bench(name: Name, as_json: AsJson = False) -> None:
    """Time the derivation, the compilation and one evaluation of MODEL; count its operations."""
    model = model_of(name)
    with working("Measuring"), user_code(model.path):
        derive_s, eom = _first(lambda: kn.derive(model.system))
        begin = start(model, eom, {})
        values = {p.name: 1.0 for p in eom.parameters if p.default is None} | dict(begin.values["parameters"])
        compile_s, compiled = _first(lambda: eom.compile(parameters=values, cache=False, not_finite="ignore"))
        x, r = _arguments(eom, begin, model.span[0])
        many = np.tile(x, (_BATCH, 1))
        call_s = _each(lambda: compiled.rhs(0.0, x, None, r), 1)
        batch_s = _each(lambda: compiled.rhs(0.0, many, None, r), _BATCH)
    receipt = {n: screen.operations(o) for n, o in compiled.operations.routines}
    times = {"declare": model.declared, "derive": derive_s, "compile": compile_s, "call": call_s, "state": batch_s}
    if as_json:
        screen.as_json({"model": model.name, "title": model.title, "seconds": times, "operations": receipt})
        return
    typer.echo(typer.style(f"{model.name}: {model.title}\n", bold=True))
    rows = [
        ("declare", f"{model.declared * 1e3:.1f} ms", "system()"),
        ("derive", f"{derive_s * 1e3:.1f} ms", "once, nothing known before"),
        ("compile", f"{compile_s * 1e3:.1f} ms", "the right-hand side, without the cache"),
        ("evaluate", f"{call_s * 1e6:.2f} µs", f"one call from Python, median of {_ROUNDS} rounds"),
        ("", f"{batch_s * 1e9:.1f} ns", f"each of {_BATCH} states in one call, median of {_ROUNDS} rounds"),
    ]
    screen.table(rows, indent=0)
    screen.heading("Operations")
    screen.table([(n, str(o)) for n, o in compiled.operations.routines])


def _arguments(eom: kn.Equations, begin: NamedStart, t: float) -> tuple[Any, Any]:
    """The state and the inputs at START, with arbitrary numbers for missing values."""
    given = begin.values
    values = {**given["q"], **given["u"], **given["states"]}
    x = np.array([float(values.get(s.name, 0.1 * k)) for k, s in enumerate(eom.state, 1)])
    forces = inputs_at(given["inputs"], t)
    return x, np.array([float(forces.get(s.name, 0.0)) for s in eom.inputs]) if eom.inputs else None


def _first(run: Callable[[], Any]) -> tuple[float, Any]:
    began = time.perf_counter()
    result = run()
    return time.perf_counter() - began, result


def _each(run: Callable[[], Any], count: int) -> float:
    """Seconds for one of `count` evaluations: the median of rounds, each long enough for the clock."""
    timer, calls = Timer(run), 1
    while (took := timer.timeit(calls)) < _LEAST:
        calls = max(2 * calls, int(calls * _LEAST / max(took, 1e-9)))
    return median(timer.repeat(_ROUNDS, calls)) / calls / count
