# SPDX-License-Identifier: BSD-3-Clause
"""Our sine and cosine, compiled from both texts, against 60 digits."""

from __future__ import annotations

import ctypes
import math
import subprocess
from fractions import Fraction
from itertools import count

import llvmlite.binding as llvm
import mpmath  # type: ignore[import-untyped]
import numpy as np
import pytest

from kane.program import C_SINCOS, CONSTANTS, LIMIT, llvm_sincos
from tests.program.programs import compiler

WIDTHS = (1, 2, 4, 8)
SCALE = 400
with mpmath.workprec(SCALE + 60):
    HALF_PI = int(mpmath.ldexp(mpmath.pi, SCALE - 1))  # π/2 · 2^SCALE
LAST = round(LIMIT / (math.pi / 2))
BOUND = 0.85  # ulp; 0.79 was found among 240 000 angles, 1.02 without the tail in the cosine
CLOSEST = (29, 58285, 145897)  # a double is very near to these multiples of π/2

LOOP = """
declare double @sin(double)
declare double @cos(double)
{sincos}
define void @batch(ptr %x, ptr %s, ptr %c, i64 %n) {{
entry:
  br label %loop
loop:
  %i = phi i64 [ 0, %entry ], [ %next, %loop ]
  %xi = getelementptr double, ptr %x, i64 %i
  %si = getelementptr double, ptr %s, i64 %i
  %ci = getelementptr double, ptr %c, i64 %i
  %angle = load {v}, ptr %xi, align 8
  %both = call {{{v}, {v}}} @kane.sincos.{width}({v} %angle)
  %sine = extractvalue {{{v}, {v}}} %both, 0
  %cosine = extractvalue {{{v}, {v}}} %both, 1
  store {v} %sine, ptr %si, align 8
  store {v} %cosine, ptr %ci, align 8
  %next = add i64 %i, {width}
  %more = icmp slt i64 %next, %n
  br i1 %more, label %loop, label %done
done:
  ret void
}}
"""

C_LOOP = f"""
#include <math.h>
#include <stdint.h>
#include <string.h>
{C_SINCOS}
void batch(const double *x, double *s, double *c, int64_t n);
void batch(const double *x, double *s, double *c, int64_t n)
{{
    for (int64_t i = 0; i < n; i++)
        kane_sincos(x[i], s + i, c + i);
}}
"""

C_MAIN = """
int main(void)
{
    const double x[] = {0.0, -0.0, 1.0, -1e-310, 1e5, -262144.0, 262144.1, 1e300, HUGE_VAL, -HUGE_VAL, NAN};
    double s[sizeof x / sizeof *x], c[sizeof x / sizeof *x];
    batch(x, s, c, sizeof x / sizeof *x);
    for (double u = -3e5; u < 3e5; u += 1.7) {
        batch(&u, s, c, 1);
        if (!(fabs(s[0] * s[0] + c[0] * c[0] - 1.0) < 1e-15))
            return 1;
    }
    return 0;
}
"""


class Compiled:
    """A function `batch(x, s, c, n)`, called with arrays; it keeps alive what holds the code."""

    def __init__(self, function, *held, width=1):
        self.function, self.held, self.width = function, held, width

    def __call__(self, x):
        x = np.ascontiguousarray(x)
        padded = np.resize(x, -(-x.size // self.width) * self.width)
        s, c = np.empty_like(padded), np.empty_like(padded)
        self.function(padded.ctypes.data, s.ctypes.data, c.ctypes.data, padded.size)
        return s[: x.size], c[: x.size]


SIGNATURE = (None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int64)
names = (f"sincos{k}" for k in count())


def compile_llvm(width, contract):
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    kind = "double" if width == 1 else f"<{width} x double>"
    module = llvm.parse_assembly(LOOP.format(sincos=llvm_sincos(width, contract), v=kind, width=width))
    module.verify()
    machine = llvm.Target.from_default_triple().create_target_machine(
        opt=2, cpu=llvm.get_host_cpu_name(), features=llvm.get_host_cpu_features().flatten()
    )
    passes = llvm.create_pass_builder(machine, llvm.create_pipeline_tuning_options(speed_level=2))
    passes.getModulePassManager().run(module, passes)
    lljit = llvm.create_lljit_compiler()
    image = llvm.JITLibraryBuilder().add_object_img(machine.emit_object(module)).add_current_process()
    tracker = image.export_symbol("batch").link(lljit, next(names))
    return Compiled(ctypes.CFUNCTYPE(*SIGNATURE)(tracker["batch"]), lljit, tracker, width=width)


def cc(directory, text, *flags):
    """Compile C text without a warning."""
    source, target = directory / "sincos.c", directory / "sincos.out"
    source.write_text(text)
    strict = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wshadow", "-Werror"]
    subprocess.run([compiler(), *strict, *flags, "-o", target, source, "-lm"], check=True)
    return target


def compile_c(directory, *flags):
    library = ctypes.CDLL(cc(directory, C_LOOP, "-fPIC", "-shared", *flags))
    return Compiled(ctypes.CFUNCTYPE(*SIGNATURE)(("batch", library)), library)


C_FLAGS = {
    "c": ("-O2", "-ffp-contract=off"),
    "c-default": ("-O2",),
    "c-fma": ("-O3", "-march=native", "-ffp-contract=fast"),
}
VARIANTS = [*(f"llvm-{w}{f}" for w in WIDTHS for f in ("", "-fma")), *C_FLAGS]


@pytest.fixture(scope="module")
def variants(tmp_path_factory):
    made = {}

    def get(name):
        if name not in made:
            kind, *rest = name.split("-")
            made[name] = (
                compile_c(tmp_path_factory.mktemp("c"), *C_FLAGS[name])
                if kind == "c"
                else compile_llvm(int(rest[0]), "fma" in rest)
            )
        return made[name]

    return get


def multiple(n, part=2):
    """The double nearest to n π/part."""
    return 2 * n * HALF_PI / (part << SCALE)


def angles(rng, size):
    """Angles of all magnitudes, and next to multiples of π/4, where results are tiny or sine and cosine change places."""
    near = [multiple(n) for n in (*range(1, 40), *CLOSEST, *range(LAST - 40, LAST))]
    near += [multiple(int(n)) for n in rng.integers(40, LAST - 40, size)]
    between = [multiple(int(n), 4) for n in 2 * rng.integers(0, LAST - 1, size) + 1]
    turns = np.array(near + between)
    x = np.concatenate(
        [
            turns,
            np.nextafter(turns, 0),
            np.nextafter(turns, np.inf),
            rng.uniform(0, math.pi / 4, size),
            rng.uniform(0, 10, size),
            rng.uniform(0, LIMIT, size),
            np.exp2(rng.uniform(-1074, 18, size)),
            [0.0, 5e-324, 2.0**-1022, np.nextafter(LIMIT, 0), LIMIT],
        ]
    )
    return x * rng.choice([-1.0, 1.0], x.size)


class Reference:
    """Sine and cosine of x as sums of two doubles, from 60 digits."""

    def __init__(self, x):
        self.x = x
        with mpmath.workdps(60):
            exact = [mpmath.cos_sin(mpmath.mpf(float(v))) for v in x]
            self.high = np.array([[float(v) for v in pair] for pair in exact]).T[::-1]
            self.low = np.array([[float(v - float(v)) for v in pair] for pair in exact]).T[::-1]

    def ulps(self, computed):
        """The largest error in units in the last place of the result."""
        error = np.abs((np.array(computed) - self.high) - self.low) / np.spacing(np.abs(self.high))
        assert np.isfinite(error).all()
        return error.max()


@pytest.fixture(scope="module")
def reference():
    return Reference(angles(np.random.default_rng(1), 150))


@pytest.mark.slow
@pytest.mark.parametrize("name", VARIANTS)
def test_accuracy(variants, reference, name):
    assert reference.ulps(variants(name)(reference.x)) < BOUND


@pytest.mark.slow
def test_accuracy_at_many(variants):
    reference = Reference(angles(np.random.default_rng(2), 10_000))
    for name in VARIANTS:
        assert reference.ulps(variants(name)(reference.x)) < BOUND


@pytest.mark.parametrize("name", VARIANTS)
def test_zeros_and_tiny(variants, name):
    x = np.array([0.0, -0.0, 5e-324, -5e-324, 2.0**-1022, -3e-310, 1e-160, -1e-9])
    s, c = variants(name)(x)
    np.testing.assert_array_equal(s, x)
    np.testing.assert_array_equal(np.signbit(s), np.signbit(x))
    np.testing.assert_array_equal(c, 1.0)


@pytest.mark.parametrize("name", VARIANTS)
def test_beyond_the_limit(variants, reference, name):
    """There the library's values; the lanes beside keep the values that they have alone."""
    alone = reference.x[::3]
    mixed = alone.copy()
    mixed[::3] = np.resize([np.nextafter(LIMIT, np.inf), -3e5, 1e9, 1e22, -1.7e308], mixed[::3].size)
    mixed[[1, 40, 77]] = np.inf, -np.inf, np.nan
    near = np.abs(mixed) <= LIMIT
    far = ~near & np.isfinite(mixed)
    for found, single, library in zip(variants(name)(mixed), variants(name)(alone), (math.sin, math.cos), strict=True):
        np.testing.assert_array_equal(found[far], [library(v) for v in mixed[far]])
        np.testing.assert_array_equal(found[near], single[near])
        assert np.isnan(found[~near & ~far]).all()


@pytest.mark.parametrize("name", [f"llvm-{w}" for w in WIDTHS[1:]] + ["c"])
def test_same_bits(variants, reference, name):
    """Without FMA all widths and both texts give the same bits."""
    np.testing.assert_array_equal(variants(name)(reference.x), variants("llvm-1")(reference.x))


def test_parts_of_half_pi():
    """n P1 and n P2 are doubles; what three parts leave of n π/2 is below 2⁻⁵⁹ of the distance to the nearest double."""
    p1, p2, p3 = (int(Fraction(CONSTANTS[k]) * (1 << SCALE)) for k in ("P1", "P2", "P3"))
    for p in (p1, p2):
        assert LAST.bit_length() + p.bit_length() - (p & -p).bit_length() + 1 <= 53
    rest = abs(HALF_PI - p1 - p2 - p3)
    rounding = p3 >> 52  # of n P3 and of what is added, relative to n
    worst = 0
    for n in range(1, LAST + 1):
        whole = n * HALF_PI
        unit = 1 << (whole.bit_length() - 53)
        distance = abs((whole + unit // 2) % unit - unit // 2)
        worst = max(worst, n * (rest + rounding) / distance)
    assert worst < 2**-59


def test_sanitizers(tmp_path):
    """No undefined behaviour in C."""
    program = cc(tmp_path, C_LOOP + C_MAIN, "-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
    assert subprocess.run([program], check=True, capture_output=True).stderr == b""
