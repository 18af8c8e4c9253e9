# SPDX-License-Identifier: BSD-3-Clause
"""The same numbers from the text of every language: the shared agreement of all emitters of the registry.

Each operation is checked at the arguments that the emitted code itself had, against NumPy's: to the last bit where IEEE 754 fixes it.
"""

import importlib.util
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane.gallery import pendulums, rolling_disk
from kane.program import Routine, targets, values
from tests.examples import examples
from tests.program.languages import LANGUAGES, emit
from tests.program.programs import (
    EDGES,
    HOSTILE_NAMES,
    NASTY,
    assert_each_operation_right,
    every_operation,
    grid,
    programs,
    small,
)

HERE = [name for name in LANGUAGES if name not in ("c", "numpy")]  # these two have tests of their own
TORCH = importlib.util.find_spec("torch") is not None  # some 3 GB: `make test-torch` brings it
RUN = [name for name in HERE if name != "torch" or TORCH]
MARKED = [pytest.param(name, marks=pytest.mark.slow) if name == "eigen" else name for name in RUN]
QUICK = [name for name in RUN if name not in ("eigen", "rust", "cpp", "sympy", "torch")]
READ = ("julia", "modelica")  # their statements are read and run as JavaScript
NO_NAN = ("casadi", "modelica")  # their min and max pass no NaN on; Modelica has none
NORMAL = ("jax",)  # XLA takes subnormal numbers for zero


def rows_for(target, rows):
    """Those of the rows that a language can be held to."""
    keep = np.ones(len(rows), bool)
    if target in NO_NAN:
        keep &= ~np.isnan(rows).any(axis=1)
    if target in NORMAL:
        keep &= ~((np.abs(rows) < 1e-300) & (rows != 0)).any(axis=1) & (np.abs(rows) < 1e100).all(axis=1)
        keep &= (np.abs(rows) > 1e-100).all(axis=1) | (rows == 0).any(axis=1)
    return rows[keep]


def test_every_target_is_held():
    """A row of the registry without one here is not tested."""
    assert set(targets.EMITTERS) == {*LANGUAGES, "h", "cargo", "sfunction"}  # test_simulink.py


@pytest.mark.parametrize("target", MARKED)
def test_each_operation_at_special_numbers(target, tmp_path):
    program, rows = every_operation(), rows_for(target, grid())
    assert len(rows) >= 100
    rows = rows[:: 29 if target == "sympy" else 1]
    found = LANGUAGES[target](program, tmp_path, rows)["all"]
    if target in ("jax", "torch", "casadi"):  # functions of their own, and zeros of another sign
        relative(program, found, rows, 1e-12)
    else:
        assert_each_operation_right(program, found.T)


def relative(program, found, rows, least):
    """Each operation of inputs alone, to `least` of its value."""
    for i in range(program.first, found.shape[1]):
        with np.errstate(all="ignore"):
            expected = np.asarray(program.op(i).numpy(*(rows[:, a] for a in program.arguments(i))), dtype=float)
        np.testing.assert_allclose(found[:, i], expected, rtol=least, err_msg=program.op(i).name)


PLAIN = st.one_of(st.sampled_from([0.0, 1.0, -1.0, 0.5]), st.floats(-4, 4).map(lambda v: round(v, 3)))


@st.composite
def cases(draw):
    program = draw(programs(most=25))
    rows = draw(
        st.lists(st.lists(PLAIN, min_size=len(program.inputs), max_size=len(program.inputs)), min_size=3, max_size=3)
    )
    return program, np.array(rows)


@pytest.mark.parametrize("target", QUICK)
@examples(0.1)
@given(cases())
def test_random_programs(tmp_path_factory, target, case):
    agree(tmp_path_factory, target, *case)


@pytest.mark.slow
@pytest.mark.parametrize("target", [name for name in RUN if name not in QUICK])
@examples(0.05)
@given(cases())
def test_random_programs_where_building_takes_long(tmp_path_factory, target, case):
    agree(tmp_path_factory, target, *case)


def agree(factory, target, program, rows):
    """Each operation at the code's own arguments; parts of what "all" gives in "some"."""
    found = LANGUAGES[target](program, factory.mktemp(target), rows)
    every = found["all"]
    np.testing.assert_array_equal(every[:, : len(program.inputs)], rows)
    np.testing.assert_array_equal(found["some"], every[:, list(program.routine("some").results)])
    assert found["none"].shape == (len(rows), 0)
    for i in range(program.first, every.shape[1]):
        if target == "casadi" and len(program.arguments(i)) > len(set(program.arguments(i))):
            continue  # x/x and x − x are 1 and 0 there by form, at 0 and at infinity too
        arguments = [np.ascontiguousarray(every[:, a]) for a in program.arguments(i)]
        with np.errstate(all="ignore"):
            expected = np.asarray(program.op(i).numpy(*arguments), dtype=float)
        keep = np.ones(len(rows), bool)
        if target == "casadi":  # which simplifies by form: where NumPy has no number it may have one
            keep &= np.isfinite(expected) & np.isfinite(np.stack(arguments)).all(axis=0)
        for a in arguments:
            keep &= np.isfinite(a) if target in (*NO_NAN, *NORMAL) else ~np.isnan(a)
            if target in NORMAL:
                keep &= (np.abs(a) > 1e-300) | (a == 0)
        if target in NORMAL:
            keep &= (np.abs(expected) > 1e-300) | (expected == 0) | np.isnan(expected)
        np.testing.assert_allclose(
            every[keep, i], expected[keep], rtol=1e-12, err_msg=f"{program.op(i).name} of {arguments}"
        )


@pytest.mark.parametrize("target", QUICK)
def test_programs_in_which_something_is_missing(target, tmp_path):
    for k, what in enumerate(EDGES):
        edge(target, what, tmp_path / str(k))


@pytest.mark.slow
@pytest.mark.parametrize("target", [name for name in RUN if name not in QUICK])
def test_programs_in_which_something_is_missing_where_building_takes_long(target, tmp_path):
    for k, what in enumerate(EDGES):
        edge(target, what, tmp_path / str(k))


def edge(target, what, folder):
    if target in ("casadi", "sympy") and what == "constants alone":
        return  # -1/0 is +inf to CasADi and zoo to SymPy; derived equations have no operation of constants alone
    folder.mkdir()
    program = EDGES[what]()
    rows = np.array([[0.25 + k for k in range(len(program.inputs))]] * 2)
    found = LANGUAGES[target](program, folder, rows)["f"]
    known = values(program, program.routine("f").body, rows[0])
    expected = np.array([float(known[i]) for i in program.routine("f").results])
    if target in NORMAL:
        keep = (np.abs(expected) > 1e-300) | (expected == 0)
        found, expected = found[:, keep], expected[keep]
    np.testing.assert_allclose(found, np.broadcast_to(expected, found.shape), rtol=1e-15, err_msg=what)


WORDS = [
    "lambda",
    "end",
    "function",
    "fn",
    "let",
    "match",
    "self",
    "Self",
    "impl",
    "type",
    "use",
    "mod",
    "where",
    "while",
    "abs",
    "sqrt",
    "sin",
    "der",
    "algorithm",
    "model",
    "equation",
    "connect",
    "parameter",
    "Real",
    "const",
    "var",
    "new",
    "class",
    "yield",
    "jnp",
    "jax",
    "torch",
    "ca",
    "sp",
    "np",
    "out",
    "h",
    "kane_sqrt",
    "kane_where",
    "i",
    "j",
    "pi",
    "eps",
    "NaN",
    "Inf",
    "NAN",
    "INFINITY",
    "T",
    "defaults",
    "names",
    "m",
    "steps",
    "SYMBOLS",
    "DEFAULTS",
    "SIZES",
    "leading",
    "f64",
    "math",
    "template",
    "namespace",
    "std",
    "Motion",
]


@pytest.mark.parametrize("target", [name for name in RUN if name not in ("eigen", *READ)])
def test_names_that_a_language_keeps_for_itself(target, tmp_path):
    """Inputs, the program and a routine that are called as what the language has are renamed, and it is said."""
    program = hostile_program()
    row = np.linspace(0.3, 1.9, len(program.inputs))
    found = LANGUAGES[target](program, tmp_path, row[None])
    expected = row[1] * row[2] + row[3:].sum()
    np.testing.assert_allclose(found["f"][0], [expected, row[3]], rtol=1e-14)
    assert found["end"][0] == row[1]
    text = emit(target, program)
    if target not in ("cpp", "rust", "matlab", "javascript"):  # to these lambda is a name as others
        assert re.search(r"lambda, .*its name here is|lambda; its name here is", text)


def hostile_program():
    x = [kn.coordinate(name) for name in dict.fromkeys([*HOSTILE_NAMES, *WORDS])]
    steps = [("mul", (1, 2))]
    for k in range(2, len(x)):
        steps.append(("add", (len(x) + k - 1, k + 1)))
    goals = [
        Routine("f", (2,), ("*/ %{ ''' #=", '"""'), (len(x) + len(steps), 3)),
        Routine("end", (1,), ("y",), (1,)),
    ]
    return small(steps, x=x, p=(), goals=goals, name="end")


KEYWORDS = {
    "julia": "abstract baremodule begin break catch const continue do else elseif end export finally for function global if "
    "import in isa let local macro module mutable quote return struct try using where while true false",
    "modelica": "algorithm and annotation block class connect constant der discrete each else elseif elsewhen end equation "
    "extends external final flow for function if import in initial inner input loop model not operator or outer output "
    "package parameter partial protected public record redeclare replaceable return stream then true false type when while within",
}


@pytest.mark.parametrize("target", READ)
def test_names_that_a_language_keeps_for_itself_are_none_of_the_assigned(target):
    text = emit(target, hostile_program())
    assigned = set(re.findall(r"^    (\w+) :?= ", text, re.MULTILINE))
    assert len(assigned) > 90
    assert assigned.isdisjoint(KEYWORDS[target].split())


@pytest.mark.parametrize("target", LANGUAGES)
def test_names_are_told_apart_by_their_first_letters(target):
    """MATLAB cuts words off behind 63 letters, C need not look further: two parameters were one there."""
    p = tuple(kn.parameter(f"{'a' * 70}{k}") for k in range(2))
    text = emit(target, small((("mul", (2, 3)),), (4,), x=(kn.coordinate("x"),), p=p))
    code = re.sub(r"(?s:/\*.*?\*/)|(//|#|%).*|\"[^\"]*\"|'[^']*'", "", text)
    assert max(map(len, re.findall(r"\w+", code))) <= 63


@pytest.mark.parametrize("target", QUICK)
@examples(0.05)
@given(st.lists(NASTY, min_size=4, max_size=4))
def test_text_stays_in_its_literal_or_comment(tmp_path_factory, target, texts):
    label, description, unit, name = texts
    symbol = kn.coordinate("".join(name.split()) or "q", description=description)
    program = small(
        (("sin", (1,)),),
        (4,),
        x=(symbol,),
        p=(kn.parameter("m", 1.0, description=unit), kn.parameter("k", 2.0)),
        labels=(label,),
    )
    row = np.array([0.0, 0.5, 1.0, 2.0])
    found = LANGUAGES[target](program, tmp_path_factory.mktemp(target), row[None])
    assert found["f"][0, 0] == pytest.approx(np.sin(0.5), rel=1e-15)


@pytest.fixture(scope="module")
def disk():
    eom = kn.derive(rolling_disk.system())
    return eom, eom.compile(contract=False)


@pytest.mark.parametrize("target", MARKED)
def test_equations_of_motion(target, disk, tmp_path):
    """All routines of the sliding disk, against its machine code."""
    eom, compiled = disk
    n = len(eom.coordinates) + len(eom.speeds)
    rows = np.array([[0.1, *np.linspace(0.2 + k, 1 - k, n), *compiled.parameters()] for k in (0.0, 0.3)])
    found = LANGUAGES[target](compiled.program, tmp_path, rows)
    for routine in compiled.program.routines:
        for row, value in zip(rows, found[routine.name], strict=True):
            expected = getattr(compiled, routine.name)(row[0], row[1 : n + 1], row[n + 1 :])
            np.testing.assert_allclose(value, expected.reshape(-1), rtol=1e-12, atol=1e-13)


@pytest.mark.slow
@pytest.mark.parametrize("target", [name for name in RUN if name != "sympy"])
def test_equations_in_pieces_and_of_many_operations(target, tmp_path):
    """Thirty rods: long enough that C++ and Rust cut them."""
    eom = kn.derive(pendulums.system(30))
    compiled = eom.compile(contract=False)
    x = np.linspace(0.2, 1.2, 60)
    row = np.array([0.0, *x, *compiled.parameters()])
    program = compiled._program(("rhs",))
    found = LANGUAGES[target](program, tmp_path, row[None])["rhs"][0]
    np.testing.assert_allclose(found, compiled.rhs(0.0, x), rtol=1e-9)


def test_sympy_has_no_more_operations_than_our_code(tmp_path):
    """Counted by SymPy, changes of sign being free as in our counts: at most 1.2 times ours, whatever the size."""
    import sympy

    from tests.program.emitted import module

    for k, system in enumerate((rolling_disk.system(), pendulums.system(6))):
        compiled = kn.derive(system).compile()
        loaded = module(compiled.emit("sympy", "rhs"), tmp_path / f"m{k}.py")
        steps, out = loaded.rhs()
        shown = sum((sympy.count_ops(e, visual=True) for e in [*(e for _, e in steps), *out]), sympy.Integer(0))
        names = {s: 0 if s.name in ("NEG", "ABS", "GT", "PIECEWISE") else 1 for s in shown.free_symbols}
        assert 0 < shown.subs(names) <= 1.2 * compiled.operations["rhs"].total


@pytest.mark.parametrize(
    "target", [name for name in targets.EMITTERS if name not in ("h", "cargo", "numpy", "c", "sfunction")]
)
def test_the_first_lines_say_how_to_call(target, disk):
    first = disk[1].emit(target).splitlines()[:6]
    assert any("Call:" in line for line in first)
    assert any("rhs(" in line for line in first), first
