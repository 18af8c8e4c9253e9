# SPDX-License-Identifier: BSD-3-Clause
"""Right-hand sides in emitted C++ and Rust beside emitted C: `python -m benchmarks.languages`; needs gcc, g++ and rustc.

Each is called through a pointer that compilers cannot see through, from a loop in its own library, in turn. C is contracted, as its
head says it may be; Rust rounds each operation by itself.
"""

import ctypes
import functools
import subprocess
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import kane as kn
from benchmarks.paired import Pairs
from kane.gallery import pendulums, rolling_disk

PAIRS = 101
SYSTEMS: dict[str, Callable[[], kn.System]] = {
    "sliding disk": rolling_disk.system,
    **{f"{n} rods": functools.partial(pendulums.system, n) for n in (2, 10, 40)},
}
_POINTERS = ", ".join(["double", *["const double *"] * 4, "double *"])
_LOOP = """
{extern}void (*volatile own)({types}) = {rhs};
{extern}void bench(long n, double *x, const double *p, double *out) {{
    double h[{kept} + 1];
    {hoist}(p, h);
    for (long k = 0; k < n; k++) {{ x[0] += 1e-9; own(0.0, x, p, 0, h, out); x[1] += 1e-12 * out[0]; }}
}}
"""
_RUST = """
#[no_mangle]
pub extern "C" fn bench(n: i64, x: &mut [f64; {n}], p: &[f64; {p}], out: &mut [f64; {n}]) {{
    let mut h = [0.0; {kept}];
    hoist(p, &mut h);
    let own = core::hint::black_box(rhs as fn(f64, &[f64; {n}], &[f64; {p}], &[f64; 0], &[f64; {kept}], &mut [f64; {n}]));
    for _ in 0..n {{ x[0] += 1e-9; own(0.0, x, p, &[], &h, out); x[1] += 1e-12 * out[0]; }}
}}
"""
_OPTIONS = ("-O2", "-march=native", "-fno-math-errno", "-ffp-contract=fast", "-shared", "-fPIC")


def loops(compiled: kn.Compiled, folder: Path) -> dict[str, Callable[[int], float]]:
    """Functions of a number of calls that give the time of one, by language."""
    program = compiled.rhs.program
    n, p = (len(program.port(name).symbols) for name in ("x", "p"))
    kept = int(compiled.emit("rust", "rhs").split("h: &mut [f64; ")[1].split("]")[0])
    own = {"types": _POINTERS, "kept": kept, "extern": ""}
    c = compiled.emit("c", "rhs") + _LOOP.format(**own, rhs="model_rhs", hoist="model_hoist")
    own["extern"] = 'extern "C" '
    space = "kane_model::model_"
    cpp = compiled.emit("cpp", "rhs") + _LOOP.format(**own, rhs=f"{space}rhs", hoist=f"{space}hoist").replace(
        'extern "C" void (*', "static void (*"
    )
    rust = compiled.emit("rust", "rhs").replace("#![no_std]", "") + _RUST.format(n=n, p=p, kept=kept)
    texts = {"c": c, "cpp": cpp, "rs": rust}
    commands = {
        "c": ["gcc", "-std=c99", *_OPTIONS],
        "cpp": ["g++", "-std=c++17", *_OPTIONS],
        "rs": ["rustc", "-C", "opt-level=3", "-C", "target-cpu=native", "--crate-type", "cdylib"],
    }
    made: dict[str, Callable[[int], float]] = {}
    for kind, text in texts.items():
        source, library = folder / f"model.{kind}", folder / f"{kind}.so"
        source.write_text(text, encoding="utf-8")
        subprocess.run([*commands[kind], str(source), "-o", str(library)], check=True)
        made[kind] = functools.partial(_timed, ctypes.CDLL(str(library)), n, compiled.parameters())
    return made


def _timed(library: ctypes.CDLL, n: int, parameters: np.ndarray[tuple[int], np.dtype[np.float64]], calls: int) -> float:
    x, out = np.linspace(0.2, 1.0, n), np.zeros(n)
    p = np.ascontiguousarray(parameters)
    given = [v.ctypes.data_as(ctypes.POINTER(ctypes.c_double)) for v in (x, p, out)]
    start = time.perf_counter()
    library.bench(ctypes.c_long(calls), *given)
    return (time.perf_counter() - start) / calls


def main() -> None:
    """One line a system and language."""
    for name, system in SYSTEMS.items():
        compiled = kn.derive(system()).compile()
        with tempfile.TemporaryDirectory() as folder:
            own = loops(compiled, Path(folder))
            calls = max(200, 10**6 // len(compiled.rhs.program.ops))
            rows = [{kind: timed(calls) for kind, timed in own.items()} for _ in range(PAIRS)]
        for kind in ("cpp", "rs"):
            pairs = Pairs(tuple(row["c"] for row in rows), tuple(row[kind] for row in rows))
            c = sorted(pairs.a)[PAIRS // 2]
            print(f"{name}: C {c * 1e9:.0f} ns, {kind} {pairs.ratio:.2f} of it (median of {PAIRS} pairs)")


if __name__ == "__main__":
    main()
