# SPDX-License-Identifier: BSD-3-Clause
"""From expressions to Programs: numbering, folding, tiers, order, chunks, reciprocals."""

import dataclasses
import itertools
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane.errors import ProgramError
from kane.expr import DIV, MUL, OPS
from kane.gallery.pendulums import system as chain
from kane.program import Port, Program, Task, build_program, explain, live_ranges, receipt, split, values, verified
from tests.program.programs import ports

a, b = kn.parameters("a b")
q, s = kn.coordinates("q s")
w = kn.input("w")
PORTS = ports((q, s), (a, b), (w,))


def built(*roots, reciprocals=False):
    labels = [f"f{k}" for k in range(len(roots))]
    wanted = [Task("f", [kn.pi * 0 + r for r in roots], (len(roots),), labels)]
    return build_program("test", PORTS, wanted, reciprocals)


def results(program, numbers=(0.3, 0.7, -1.1, 2.0, 3.0, 0.5)):
    found = values(program, program.routines[0].body, numbers)
    return [float(found[i]) for i in program.routines[0].results]


class TestBuild:
    def test_values_are_those_of_the_expressions(self):
        e = [q * kn.sin(s) + a / b, (q * kn.sin(s)) ** 2, kn.sqrt(a) * w + kn.time, a, q]
        expected = kn.evaluate(e, {kn.time: 0.3, q: 0.7, s: -1.1, a: 2.0, b: 3.0, w: 0.5})
        assert results(built(*e)) == [float(v) for v in expected]

    def test_common_subexpressions_are_computed_once(self):
        program = built(kn.sin(q) * s, kn.sin(q) + s)
        assert [op.name for op in program.ops].count("sin") == 1

    def test_constants_alone_are_folded(self):
        program = built(q * kn.sqrt(kn.pi * 2))
        assert [op.name for op in program.ops] == ["mul"]
        assert program.constants == (np.sqrt(np.pi * 2),)

    def test_constants_that_are_not_finite_stay_instructions(self):
        program = built(q + kn.log(kn.exp(1000 * kn.pi)))
        assert "exp" in [op.name for op in program.ops]
        assert results(program) == [np.inf]

    def test_tiers(self):
        program = built(kn.sin(a) * q + a * b, kn.sin(a) * b)
        names = [program.op(i).name for i in program.hoisted]
        assert sorted(names) == ["mul", "mul", "sin"]
        assert [program.op(i).name for i in program.routines[0].body] == ["mul", "add"]
        assert set(program.kept) <= set(program.hoisted)

    def test_two_routines_share_what_is_hoisted(self):
        wanted = [Task("f", [q * kn.sin(a)], (1,), ["f"]), Task("g", [s * kn.sin(a)], (1,), ["g"])]
        program = build_program("test", PORTS, wanted)
        assert len(program.hoisted) == len(program.kept) == 1
        assert [len(r.body) for r in program.routines] == [1, 1]

    def test_symbol_that_no_port_gives_is_named(self):
        with pytest.raises(kn.ValueMissingError, match=r"inputs \(t: t; x: q, s; p: a, b; r: w\), got c \(Parameter\)"):
            built(q * kn.parameter("c"))

    def test_results_that_are_inputs_and_constants(self):
        assert results(built(q, a, 3 + q * 0, kn.time)) == [0.7, 2.0, 3.0, 0.3]

    @pytest.mark.slow
    def test_text_is_the_same_under_any_hash_seed(self):
        code = (
            "import hashlib, kane as kn\nfrom kane.gallery.pendulums import system as chain\n"
            "from kane.equations import program\nfrom kane.program import emit_llvm\n"
            "p = program(kn.derive(chain(4)).solved)\n"
            "print(hashlib.sha256(emit_llvm([p]).encode()).hexdigest())"
        )
        found = {
            subprocess.run(
                [sys.executable, "-c", code], env={"PYTHONHASHSEED": seed}, capture_output=True, text=True, check=True
            ).stdout
            for seed in ("0", "1")
        }
        assert len(found) == 1


class TestVerify:
    """Each way in which a pass could break a program is found."""

    program = built(kn.sin(q) * s + a * b, q / s)

    @pytest.mark.parametrize(
        ("change", "message"),
        [
            (lambda p: {"args": p.args[:-1]}, "operations and"),
            (lambda p: {"args": ((p.first,), *p.args[1:])}, "value 6 = "),
            (
                lambda p: (
                    {"ops": (OPS["add"], *p.ops[1:])} if p.ops[0].arity == 1 else {"ops": (OPS["sin"], *p.ops[1:])}
                ),
                "value 6 = ",
            ),
            (lambda p: {"ops": (OPS["symbol"], *p.ops[1:])}, "value 6 = symbol"),
            (
                lambda p: {"constants": (np.nan,), "args": tuple(tuple(i + (i >= p.first) for i in r) for r in p.args)},
                "not finite",
            ),
            (lambda p: {"hoisted": ()}, "kept value"),
            (lambda p: {"hoisted": p.routines[0].body[:1], "kept": ()}, "before its arguments"),
            (lambda p: {"ports": (*p.ports[:3], Port("r", (w, w)))}, "two symbols of one name in the port r"),
        ],
    )
    def test_tables(self, change, message):
        with pytest.raises(ProgramError, match=f"after the pass 'test', got .*{message}"):
            verified(dataclasses.replace(self.program, **change(self.program)), "test")

    @pytest.mark.parametrize(
        ("change", "message"),
        [
            (lambda r: {"body": r.body[::-1]}, "before its arguments"),
            (lambda r: {"body": r.body[:-1]}, "not computed"),
            (lambda r: {"body": (*r.body, r.body[0])}, "twice"),
            (lambda r: {"results": r.results[:1], "labels": ("f",), "shape": (1,)}, "not used"),
            (lambda r: {"shape": (3,)}, "2 results and 2 labels"),
        ],
    )
    def test_routines(self, change, message):
        routine = self.program.routines[0]
        broken = dataclasses.replace(self.program, routines=(dataclasses.replace(routine, **change(routine)),))
        with pytest.raises(ProgramError, match=message):
            verified(broken, "test")

    def test_sound_program_passes(self):
        assert verified(self.program, "test") is self.program


def pendulum(n: int) -> Program:
    from kane.equations import program

    return program(kn.derive(chain(n)).solved, ("rhs",))


class TestOrder:
    @pytest.mark.parametrize("n", [2, 5, 10])
    def test_live_ranges_are_no_longer_than_in_the_order_of_building(self, n):
        program = pendulum(n)
        routine = program.routines[0]
        built_order = sorted(routine.body)
        assert live_ranges(program, routine.body) <= live_ranges(program, built_order)

    def test_live_ranges_by_hand(self):
        # f = (q+s)·(q−s): values 0, 1 at places 0, 1, both read at place 2
        program = built((q + s) * (q - s))
        assert live_ranges(program, program.routines[0].body) == 2 + 1


class TestSplit:
    @given(st.integers(1, 60), st.integers(2, 6))
    def test_chunks_pass_values_through_slots(self, chunk, n):
        program = pendulum(n)
        body = program.routines[0].body
        parts = split(program, body, 0, chunk)
        assert tuple(itertools.chain(*(c.instructions for c in parts.chunks))) == body
        assert max(len(c.instructions) for c in parts.chunks) <= chunk
        inputs = np.linspace(0.2, 0.9, len(program.inputs))
        expected = values(program, body, inputs)
        given_ = {*range(program.first), *program.kept}
        slots = {}  # which value a slot holds
        for c in parts.chunks:
            here = {v for v, slot in c.loads.items() if slots[slot] == v}
            assert here == set(c.loads)  # nobody has overwritten what is read
            known = given_ | here
            for i in c.instructions:
                assert known.issuperset(program.arguments(i))
                known.add(i)
            slots.update((slot, v) for v, slot in c.stores.items())
        assert set(slots) == set(range(parts.slots))
        assert all(i in expected for i in body)

    def test_short_blocks_stay_whole(self):
        program = pendulum(10)
        parts = split(program, program.routines[0].body)
        assert len(parts.chunks) == 1
        assert parts.slots == 0

    def test_empty_block(self):
        assert [c.instructions for c in split(pendulum(2), ()).chunks] == [()]

    def test_slots_are_used_again(self):
        program = pendulum(8)
        parts = split(program, program.routines[0].body, 0, 10)
        assert parts.slots < sum(len(c.stores) for c in parts.chunks)


class TestReciprocal:
    def test_one_division_for_each_divisor(self):
        program = built(a / (q + s), b / (q + s), w / (q + s), reciprocals=True)
        assert [op for op in program.ops if op is DIV] == [DIV]

    def test_lone_divisions_stay(self):
        assert [op for op in built(a / q, b / s, reciprocals=True).ops if op is DIV] == [DIV, DIV]

    def test_divisions_by_parameters_are_hoisted(self):
        program = built(q / a, reciprocals=True)
        assert [program.op(i) for i in program.hoisted] == [DIV]
        assert [program.op(i) for i in program.routines[0].body] == [MUL]

    def test_a_reciprocal_that_is_there_already_serves(self):
        program = built(1 / (q + s), a / (q + s), b / (q + s), reciprocals=True)
        assert [op for op in program.ops if op is DIV] == [DIV]
        assert np.allclose(results(program), [1 / -0.4, 2 / -0.4, 3 / -0.4], rtol=1e-14)

    def test_division_by_zero_gives_what_it_gave(self):
        roots = [a / (q - s), b / (q - s), 0 * w + kn.time / (q - s)]
        numbers = (0.0, 0.5, 0.5, 2.0, -3.0, 1.0)
        plain, fast = (np.array(results(built(*roots, reciprocals=r), numbers)) for r in (False, True))
        assert np.array_equal(plain, fast, equal_nan=True)

    def test_pendulum(self):
        n = 10
        program = pendulum(n)
        divisions = [i for i in program.routines[0].body if program.op(i) is DIV]
        assert len(divisions) == n - 1  # one a pivot; the first depends on parameters alone


class TestReceipt:
    def test_counts_are_those_of_the_expressions(self):
        eom = kn.derive(chain(3))
        from kane.equations import program

        found = receipt(program(eom.solved, ("rhs",), reciprocals=False, optimize=False))["rhs"]
        expected = eom.operations
        assert (found.state, found.parameter, found.by_operation) == (
            expected.state,
            expected.parameter,
            expected.by_operation,
        )

    def test_each_routine_counts_what_it_runs(self):
        wanted = [Task("f", [kn.sin(a) * q], (1,), ["f"]), Task("g", [a * b + s], (1,), ["g"])]
        found = receipt(build_program("test", PORTS, wanted))
        assert [(o.parameter, o.state) for _, o in found.routines] == [(1, 1), (1, 1)]
        assert "g: 2 operations: 1 with the state, 1 of parameters" in str(found)


class TestExplain:
    def test_names_the_division(self):
        program = built(q * 2, kn.sin(s) + b / (q - kn.time))
        text = explain(program, program.routines[0], (0.5, 0.5, 1.0, 2.0, 3.0, 0.0))
        assert text == "b/(q - t) = inf where b = 3, q - t = 0; it makes f1 not finite"

    def test_names_the_root_of_a_negative_number(self):
        program = built(kn.sqrt(q) * s)
        assert explain(program, program.routines[0], (0.0, -2.0, 1.0, 1.0, 1.0, 0.0)) == (
            "sqrt(q) = nan where q = -2; it makes f0 not finite"
        )

    def test_names_the_argument(self):
        program = built(q * s + a)
        assert (
            explain(program, program.routines[0], (0.0, np.nan, 1.0, 1.0, 1.0, 0.0))
            == "q = nan; it makes f0 not finite"
        )

    def test_says_nothing_where_all_is_finite(self):
        program = built(q / s)
        assert explain(program, program.routines[0], (0.0, 1.0, 1.0, 1.0, 1.0, 0.0)) == ""

    def test_follows_the_branch_that_was_chosen(self):
        program = built(kn.where(kn.less(q, 0), 1 / q, kn.log(s)), kn.where(kn.less(0, q), kn.log(s), kn.sqrt(q)))
        routine = program.routines[0]
        assert explain(program, routine, (0.0, 0.0, -1.0, 1.0, 1.0, 0.0)).startswith("log(s) = nan where s = -1;")
        assert explain(program, routine, (0.0, -2.0, 1.0, 1.0, 1.0, 0.0)).startswith("sqrt(q) = nan where q = -2;")

    def test_what_is_not_chosen_does_not_count(self):
        program = built(kn.where(kn.less(q, 1), q, 1 / s))
        assert explain(program, program.routines[0], (0.0, 0.5, 0.0, 1.0, 1.0, 0.0)) == ""
