# SPDX-License-Identifier: BSD-3-Clause
"""Emitted C keeps the rules of MISRA C:2012 that cppcheck's addon knows, but for those of the table in `docs/howto/emitted_c.md`."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

import kane as kn
from kane.gallery import load
from tests.motion.emitted import IN_MODES, MODELS, STRICT, emitted
from tests.program.programs import compiler
from tests.systems.draft_kinds import drafted
from tests.systems.drafts import built

PAGE = Path(__file__).resolve().parents[2] / "docs" / "howto" / "emitted_c.md"
CHECKED = (
    "--enable=warning",
    "--std=c99",
    "--platform=unix64",
    "--quiet",
    "--template={severity}:{id}:{line}",
    "-DFLT_EVAL_METHOD=0",
    "-D__GNUC__=12",
    "-U__clang__",
    "-U_MSC_VER",
    "-U__FAST_MATH__",
    "-U__FINITE_MATH_ONLY__",
    "-U__ASSOCIATIVE_MATH__",
    "-U__RECIPROCAL_MATH__",
    "-U__cplusplus",
)
ADDONS = ("/usr/lib/x86_64-linux-gnu/cppcheck/addons", "/usr/share/cppcheck/addons", "/usr/lib/cppcheck/addons")
SHORT = 5000
"""Lines, more than those of a cart with a controller."""
ALLOCATES = re.compile(r"\b(?:malloc|calloc|realloc|free|alloca|qsort)\b")
LOOP = re.compile(r"for \((?:int64_t|int) (\w+) = [^;]+; [^;]*\b\1 (?:<|<=|>) [^;]+; \1(?:\+\+|--)\) \{")


def deviations(column):
    """The rules of the page's table of deviations that hold for some part: "core" or "main"."""
    lines = [line.split("|") for line in PAGE.read_text(encoding="utf-8").splitlines() if re.match(r"\| \d", line)]
    return {rule.strip() for _, rule, where, *_ in lines if where.strip() in ("all", column)}


def findings(folder, text, *options, main=()):
    """Rules that a text does not keep, deviations apart, and errors that are found in it, with its lines.

    In the lines `main`, from 1, the rules of input and output may be broken. The addon runs by itself, as cppcheck shows but one
    of its findings a line. Its check of rule 8.2 (named parameters) takes a time that grows with the square of a text's length,
    so it is left to short texts, whose functions are printed as those of long ones.
    """
    slow = [] if text.count("\n") < SHORT else ["--suppress-rules", "8.2"]
    source = folder / "emitted.c"
    source.write_text(text, encoding="utf-8")
    checker = Path(compiler("cppcheck"))
    analysed = subprocess.run(
        [checker, *CHECKED, *options, "--dump", source], capture_output=True, text=True, check=True
    )
    (addon,) = [path for place in ADDONS for path in [Path(place) / "misra.py"] if path.is_file()][:1]
    ruled = subprocess.run(
        [sys.executable, addon, "-q", "--no-summary", *slow, f"{source}.dump"],
        capture_output=True,
        text=True,
        check=False,
    )
    lines = ruled.stderr.splitlines()
    told = re.findall(r"^\[.*:(\d+)\] .*\[misra-c2012-([\d.]+)\]$", ruled.stderr, re.MULTILINE)
    assert len(told) == len(lines), ruled.stderr
    core, printing = deviations("core"), deviations("main")
    broken = [(rule, line) for line, rule in told if rule not in core and not (rule in printing and int(line) in main)]
    errors = [tuple(line.split(":")[1:]) for line in analysed.stderr.splitlines() if line.count(":") == 2]
    return [*errors, *broken]


BROKEN = """#include <stdlib.h>
static int f(int n);
static int f(int n)
{
    int *a = malloc(8);
    if (n > 0)
        return f(n - 1);
    goto end;
end:
    free(a);
    return n;
}
int main(void)
{
    f(3);
    return 0;
}
"""


def test_the_addon_finds_what_breaks_rules(tmp_path):
    """Memory from the heap and its leak, recursion, goto, a choice without braces, an unused result."""
    found = {rule for rule, _ in findings(tmp_path, BROKEN)}
    assert {"21.3", "17.2", "15.1", "15.6", "17.7", "memleak"} <= found


@pytest.mark.parametrize("name", ["pendulum_on_cart", "rolling_disk"])
def test_functions_keep_the_rules(tmp_path, name):
    eom = kn.derive(load(name).system())
    for contract in (True, False):
        assert findings(tmp_path, eom.compile(name="model", contract=contract).emit("c")) == []


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(8))
def test_functions_of_random_models_keep_the_rules(tmp_path, seed):
    assert findings(tmp_path, kn.derive(built(drafted(seed))).compile(name="model").emit("c")) == []


@pytest.mark.slow
@pytest.mark.parametrize("name", [*MODELS, *IN_MODES])
def test_programs_keep_the_rules(tmp_path, name):
    """All of them in the core, which does not print; in `main` all but the rules of input and output."""
    _, text = emitted(name)
    parts = re.split(rf"^(#ifndef {name.upper()}_NO_MAIN\n.*?^#endif\n)", text, flags=re.MULTILINE | re.DOTALL)
    assert len(parts) == 5
    assert "stdio" not in "".join(parts[::2])
    last = [text.count("\n", 0, len("".join(parts[: k + 1]))) for k in range(4)]
    main = {*range(last[0] + 1, last[1] + 1), *range(last[2] + 1, last[3] + 1)}
    assert findings(tmp_path, text, f"-U{name.upper()}_NO_MAIN", main=main) == []


@pytest.mark.parametrize("name", [*MODELS, *IN_MODES])
def test_nothing_is_allocated_and_every_loop_has_a_bound(name):
    _, text = emitted(name)
    code = re.sub(r"/\*.*?\*/|\"[^\"\n]*\"", "", text, flags=re.DOTALL)
    assert not ALLOCATES.search(code)
    assert not re.search(r"\b(?:while|do|goto)\b", code)
    counted = [line for line in code.splitlines() if re.search(r"\bfor \(", line)]
    others = [line.strip() for line in counted if not LOOP.search(line)]
    # these go on from where the rows before have ended
    assert all(re.fullmatch(r"for \(; \(?(?:k|noted) <=? .*; (?:k|noted)\+\+\) \{|for \(; \(k < .*", x) for x in others)
    assert len(counted) > 5 * len(others)


@pytest.mark.slow
@pytest.mark.parametrize("name", [*MODELS, *IN_MODES])
def test_the_stack_is_bounded_and_the_core_stands_alone(tmp_path, name):
    """No function takes a stack that depends on numbers; without `main` nothing of input, output or the heap is called."""
    _, text = emitted(name)
    source, made = tmp_path / f"{name}.c", tmp_path / f"{name}.o"
    source.write_text(text, encoding="utf-8")
    options = [*STRICT, "-Wvla", "-fstack-usage", "-O1", f"-D{name.upper()}_NO_MAIN"]
    subprocess.run([compiler(), *options, "-c", source, "-o", made], check=True, cwd=tmp_path)
    used = [line.split()[-1] for line in made.with_suffix(".su").read_text().splitlines()]
    assert used
    assert set(used) <= {"static", "dynamic,bounded"}
    names = subprocess.run([compiler("nm"), "-u", made], capture_output=True, text=True, check=True).stdout.split()
    allowed = {
        "U",
        f"{name}_control",
        "memcpy",
        "memset",
        "nextafter",
        "sin",
        "cos",
        "sincos",
        "sqrt",
        "fmin",
        "fmax",
        "floor",
    }
    assert set(names) <= allowed | {"pow", "exp", "__stack_chk_fail", "_GLOBAL_OFFSET_TABLE_"}


@pytest.mark.slow
def test_gcc_finds_nothing_by_analysis(tmp_path):
    _, text = emitted("cart")
    source = tmp_path / "cart.c"
    source.write_text(text, encoding="utf-8")
    options = [*STRICT, "-fanalyzer", "-O1", "-c", source, "-o", tmp_path / "cart.o"]
    done = subprocess.run([compiler(), *options], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
