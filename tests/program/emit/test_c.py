# SPDX-License-Identifier: BSD-3-Clause
import ctypes
import itertools
import os
import re
import sys
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane import coordinates, parameter
from kane.equations import program
from kane.expr import compile_reference
from kane.gallery import rolling_disk
from kane.program import Program, Task, build_program, emit_c, emit_header, is_free_in_c
from kane.program import values as reference_values
from tests.examples import examples
from tests.expr import expressions
from tests.program.emitted import OPTIMIZED, STRICT, call, library, run
from tests.program.programs import (
    EDGES,
    EXACT,
    HOSTILE_NAMES,
    NASTY,
    SPECIAL,
    assert_each_operation_right,
    bits,
    compiler,
    every_operation,
    exact_results,
    grid,
    points,
    ports,
    programs,
    small,
)


@pytest.fixture(scope="session")
def build(tmp_path_factory):
    """A function from text of C to its library; each gets a place of its own."""
    folder, numbers = tmp_path_factory.mktemp("emit_c"), itertools.count()

    return lambda text, *options: library(text, folder / f"m{next(numbers)}.c", *options)


# ----------------------------------------------------------------------------------------- the same numbers as NumPy


@pytest.mark.slow
@examples(0.4)
@given(st.data())
def test_each_operation_gives_what_numpy_gives(build, data):
    program = data.draw(programs())
    library = build(emit_c(program, contract=False, longest=data.draw(st.sampled_from((3, 7, 2000)))))
    found = []
    for values in data.draw(points(program, 8)):
        every = call(library, program, "all", values)
        assert bits(every[: len(program.inputs)]) == bits(values)
        assert bits(every[len(program.inputs) : program.first]) == bits(program.constants)
        assert bits(call(library, program, "some", values)) == bits(every[list(program.routine("some").results)])
        assert call(library, program, "none", values).size == 0
        found.append(every)
    assert_each_operation_right(program, np.transpose(found))


def test_each_operation_at_all_pairs_of_special_numbers(build):
    program = every_operation()
    library = build(emit_c(program, contract=False))
    assert_each_operation_right(program, np.transpose([call(library, program, "all", at) for at in grid()]))


@examples(0.4)
@given(expressions.programs(tuple(n for n in EXACT if n not in ("less", "neg"))), st.sampled_from(("c99", "gnu11")))
def test_results_without_contraction_are_those_of_the_reference_evaluator_bit_by_bit(build, example, standard):
    roots = exact_results(example)
    leaves = [*expressions.LEAVES[:3], expressions.M]
    program = build_program(
        "drawn", ports(leaves[:3], (expressions.M,)), [Task("f", roots, (len(roots),), [""] * len(roots))]
    )
    library = build(emit_c(program, contract=False), f"-std={standard}", "-O3", "-march=native")
    reference = compile_reference(roots, leaves)
    for values in (example.values, tuple(-v for v in example.values), (0.0, 1e200, -0.0, 1.0)):
        x = [np.float64(v) for v in values]
        assert bits(call(library, program, "f", [0, *x])) == bits(reference(x))


def test_without_contraction_a_product_is_rounded_before_the_sum(build):
    program = small([("mul", (1, 1)), ("sub", (5, 2))], (6,))
    x = 1 + 2.0**-30  # its square needs 61 bits
    library = build(emit_c(program, contract=False), "-std=gnu11", "-O3", "-march=native")
    assert call(library, program, "f", [0, x, x * x, 0, 0])[0] == 0
    loose = build(emit_c(program), "-std=gnu11", "-O3", "-march=native")
    assert call(loose, program, "f", [0, x, x * x, 0, 0])[0] in (0, 2.0**-60)


@pytest.mark.parametrize("flag", ["-ffast-math", "-Ofast", "-ffinite-math-only"])
def test_fast_math_is_refused(build, flag):
    with pytest.raises(AssertionError, match="Compile without -ffast-math"):
        build(emit_c(small((), (1,))), "-std=c99", flag)


@pytest.mark.skipif(sys.platform != "linux" or os.uname().machine != "x86_64", reason="x87 is an x86 matter")
def test_excess_precision_is_refused_where_bits_are_promised(build):
    if "clang" in run([compiler(), "--version"]):
        pytest.skip("clang computes doubles in SSE2 always")
    build(emit_c(small((), (1,))), "-std=c99", "-mfpmath=387")
    with pytest.raises(AssertionError, match="excess precision"):
        build(emit_c(small((), (1,)), contract=False), "-std=c99", "-mfpmath=387")


# ------------------------------------------------------------------------------------------------- missing and unusual


@pytest.mark.parametrize(
    "options",
    [
        ("-std=c99", "-O0"),
        pytest.param(("-std=gnu11", "-O3", "-Wshadow"), marks=pytest.mark.slow),
        pytest.param(("-std=c++17", "-xc++"), marks=pytest.mark.slow),
    ],
)
def test_programs_in_which_something_is_missing_compile_without_a_warning(build, options):
    if "-xc++" in options:
        compiler("c++")
    for what, make in EDGES.items():
        program = make()
        library = build(emit_c(program, contract=False), *options)
        values = [0.25 + k for k in range(len(program.inputs))]
        first = program.first
        known = dict(enumerate([*values, *program.constants]))
        for i in range(first, first + len(program.ops)):
            with np.errstate(all="ignore"):
                known[i] = float(program.op(i).numpy(*(np.float64(known[a]) for a in program.arguments(i))))
        expected = [known[i] for i in program.routine("f").results]
        np.testing.assert_allclose(call(library, program, "f", values), expected, rtol=1e-15, err_msg=what)


def test_constants_and_defaults_are_exact(build):
    p = [parameter(f"p_{k}", v) for k, v in enumerate(SPECIAL)]
    program = small(
        (), range(2 + len(p), 2 + 2 * len(p)), p=(*p, parameter("free")), constants=SPECIAL, x=(), name="exact"
    )
    library = build(emit_c(program))
    table = rows(library, "exact_parameters", len(p) + 1)
    assert bits(call(library, program, "f", np.zeros(len(program.inputs)))) == bits(SPECIAL)
    assert bits([row[3] for row in table]) == bits([*(float(q.default) for q in p), np.nan])


# ------------------------------------------------------------------------------------------------------ names and text


class Quantity(ctypes.Structure):
    _fields_ = (
        ("name", ctypes.c_char_p),
        ("unit", ctypes.c_char_p),
        ("description", ctypes.c_char_p),
        ("value", ctypes.c_double),
    )


def rows(library: ctypes.CDLL, table: str, count: int) -> list[tuple[Any, ...]]:
    """The rows of a table; what follows the last one must be the end's mark."""
    found = (Quantity * (count + 1)).in_dll(library, table)
    assert found[count].name is None
    return [(q.name, q.unit, q.description, q.value) for q in found[:count]]


def utf8(text: str) -> bytes:
    """As C reads a string: up to the first null character."""
    return text.encode("utf-8", "replace").partition(b"\0")[0]


@examples(0.4)
@given(st.lists(NASTY, min_size=4, max_size=4), NASTY, st.booleans())
def test_no_text_leaves_its_literal_or_comment(build, texts, name, split):
    name = re.sub(r"\s", "", name) or "q"
    x = (kn.coordinate(name, *texts[:2]), kn.coordinate("q_2", *texts[2:]))
    program = small([("add", (1, 2))], (3, 1), x=x, p=(), name=texts[0] + "m", labels=texts[1:3])
    text = emit_c(program, version=texts[3], longest=1 if split else 2000)
    library = build(text)
    prefix = re.search(r"void (\w+)_hoist", text)[1]
    assert list(call(library, program, "f", [0, 1.5, 2.0], prefix)) == [3.5, 1.5]
    expected = [(*map(utf8, (s.name, s.unit, s.description)),) for s in x]
    assert [row[:3] for row in rows(library, f"{prefix}_state", 2)] == expected
    labels = (ctypes.c_char_p * 3).in_dll(library, f"{prefix}_f_labels")
    assert list(labels) == [*map(utf8, texts[1:3]), None]


@pytest.mark.slow
@pytest.mark.parametrize("longest", [9, 2000])
@pytest.mark.parametrize("options", [OPTIMIZED, ("-std=gnu11", "-Wshadow"), ("-std=c++17", "-xc++")])
def test_names_that_c_cannot_have_or_needs_itself(build, options, longest):
    if "-xc++" in options:
        compiler("c++")
    x = [kn.coordinate(name) for name in HOSTILE_NAMES]
    steps = [("add", (1, 2)), *(("add", (len(x) + i, i + 2)) for i in range(1, len(x) - 1)), ("sin", (1,))]
    program = small(steps, (2 * len(x) - 1, 2 * len(x)), x=x, p=())
    library = build(emit_c(program, longest=longest), *options)
    values = 2.0 ** np.arange(len(x))
    found = call(library, program, "f", [0, *values])
    np.testing.assert_allclose(found, [values.sum(), np.sin(1)], rtol=1e-15)


ROUTINES = "hoist state state labels f f_labels pi E sincos f_part 8_t rhs RHS *"


@pytest.mark.slow
@pytest.mark.parametrize("name", ["m", "int", "FLT", "kane", "while", "2 links", "", "*", "part_1", "fp", "a\nb"])
def test_any_name_of_a_system_and_of_its_routines(build, name):
    routines = ROUTINES.split()
    wanted = [Task(r, [coordinates("q")[0] + k], (1,), ("",)) for k, r in enumerate(routines)]
    program = build_program(name, ports(coordinates("q")), wanted)
    text = emit_c(program, longest=1)
    library = build(text)
    names = re.findall(r"^void (\w+)\(double t, .*;$", text, re.MULTILINE)
    assert len(set(names)) == len(routines)
    for k, full in enumerate(names):
        out, x = (ctypes.c_double * 1)(), (ctypes.c_double * 1)(0.5)
        getattr(library, full)(ctypes.c_double(0), x, None, None, None, out)
        assert out[0] == k + 0.5


def test_headers_of_mathematics_leave_the_names_that_we_use():
    """Every macro without arguments that the emitted file sees and every function of <math.h> is known."""
    headers = "".join(f"#include <{name}.h>\n" for name in ("math", "float", "stdint", "string"))
    common = [compiler(), "-std=gnu11", "-D_GNU_SOURCE", "-E", "-xc", "-"]
    macros = set(re.findall(r"^#define (\w+) ", run([*common, "-dM"], input=headers), re.MULTILINE))
    functions = set(re.findall(r"\b(\w+) \(", run(common, input="#include <math.h>\n")))
    theirs = {n for n in macros | functions if not n.startswith("_")}
    assert len(theirs) > 100
    assert not sorted(n for n in theirs if is_free_in_c(n))


def test_the_text_reads_well():
    q, m = kn.coordinate("θ", "rad", "angle"), kn.parameter("m", 2.0, "kg", "mass")
    program = small(
        [("sin", (1,)), ("cos", (1,)), ("mul", (3, 2)), ("neg", (5,))], (6, 4), x=(q,), p=(m,), labels=("N", "c")
    )
    text = emit_c(program, version="1.2")
    assert text == emit_c(program, version="1.2")
    assert "kane 1.2" in text
    assert " * x[0]    θ, rad: angle\n" in text
    assert text.endswith("""\
/* f: 2; 3 operations. */
void small_f(double t, const double *x, const double *p, const double *r, const double *h, double *out)
{
    (void)t;
    (void)r;
    (void)h;
    const double theta = x[0];
    const double m = p[0];
    double z1;
    double z4;
    kane_sincos(theta, &z1, &z4);
    const double z2 = z1 * m;
    const double z3 = -z2;
    out[0] = z3; /* N */
    out[1] = z4; /* c */
}
""")


def test_one_call_serves_sine_and_cosine_of_an_angle():
    program = small([("sin", (1,)), ("sin", (2,)), ("cos", (1,)), ("cos", (5,))], (5, 6, 7, 8))
    body = emit_c(program).partition("void small_f")[2].rpartition("void small_f")[2]
    assert re.findall(r"kane_\w+\(\w+", body) == ["kane_sincos(q1", "kane_sin(q2", "kane_cos(z1"]
    assert "sincos" not in emit_c(small([("tan", (1,))], (5,)))


# ----------------------------------------------------------------------------------------------- long, whole, in C++


def test_no_function_of_a_long_program_is_long():
    steps = [("add", (1, 2)), *(("mul" if k % 3 else "sub", (4 + k, max(1, 5 + k - 40))) for k in range(1, 30_000))]
    text = emit_c(small(steps, (30_004, 6_000)))
    bodies = [f.count("\n") for f in re.split(r"^}\n", text, flags=re.MULTILINE)]
    assert max(bodies) < 2_200
    assert text.count(" = z") + text.count(" = q") < 1.1 * len(steps)


@pytest.fixture(scope="module")
def disk() -> Program:
    return program(kn.derive(rolling_disk.system()).solved, name="rolling disk")


MAIN = """
#include <stdio.h>
#include "rolling_disk.h"
int main(void)
{
    double x[ROLLING_DISK_STATES], p[ROLLING_DISK_PARAMETERS], h[ROLLING_DISK_HOISTED], out[ROLLING_DISK_RHS_SIZE];
    for (int i = 0; i < ROLLING_DISK_STATES; i++) x[i] = 0.3 + 0.1 * i;
    for (int i = 0; rolling_disk_parameters[i].name; i++) p[i] = rolling_disk_parameters[i].value;
    rolling_disk_hoist(p, h);
    rolling_disk_rhs(0.0, x, p, 0, h, out);
    for (int i = 0; i < ROLLING_DISK_RHS_SIZE; i++) printf("%s %.17g\\n", rolling_disk_rhs_labels[i], out[i]);
    return 0;
}
"""


def check_disk(disk: Program, printed: str) -> None:
    routine = disk.routine("rhs")
    at = [0.0, *(0.3 + 0.1 * i for i in range(10)), *(s.default for s in disk.port("p").symbols)]
    expected = reference_values(disk, routine.body, at)
    labels, numbers = zip(*(line.split() for line in printed.splitlines()), strict=True)
    assert labels == routine.labels
    np.testing.assert_allclose([float(n) for n in numbers], [expected[i] for i in routine.results], rtol=1e-11)


@pytest.mark.slow
@pytest.mark.parametrize("longest", [20, 2000])
def test_the_disk_in_a_program_of_its_own_does_nothing_undefined(disk, tmp_path, longest):
    (tmp_path / "rolling_disk.c").write_text(emit_c(disk, longest=longest), encoding="utf-8")
    (tmp_path / "rolling_disk.h").write_text(emit_header(disk), encoding="utf-8")
    (tmp_path / "main.c").write_text(MAIN, encoding="utf-8")
    sanitize = ["-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
    sources = [tmp_path / "main.c", tmp_path / "rolling_disk.c"]
    run([compiler(), *OPTIMIZED, *STRICT, *sanitize, *sources, "-o", tmp_path / "disk", "-lm"])
    check_disk(disk, run([tmp_path / "disk"], env={**os.environ, "ASAN_OPTIONS": "detect_leaks=0"}))


def test_the_header_serves_c_plus_plus(disk, tmp_path):
    (tmp_path / "rolling_disk.c").write_text(emit_c(disk), encoding="utf-8")
    (tmp_path / "rolling_disk.h").write_text(emit_header(disk), encoding="utf-8")
    (tmp_path / "main.cc").write_text(f'#include "rolling_disk.h"\n{MAIN}', encoding="utf-8")
    run([compiler(), *OPTIMIZED, *STRICT, "-c", tmp_path / "rolling_disk.c", "-o", tmp_path / "disk.o"])
    command = [compiler("c++"), "-std=c++11", *STRICT, tmp_path / "main.cc", tmp_path / "disk.o"]
    run([*command, "-o", tmp_path / "disk", "-lm"])
    check_disk(disk, run([tmp_path / "disk"]))
