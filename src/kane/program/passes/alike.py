# SPDX-License-Identifier: BSD-3-Clause
"""What values are alike: computed in one way, whatever the signs and the inputs, and read in one way."""

from functools import cached_property

from kane.expr.ops import ADD, MUL, NEG, SUB, Op
from kane.program.program import Code, Operand

_NEAR = 3
"""How far what reads a value is looked at to tell it from another."""


class Alike:
    """The form of each value: what it computes, whatever the signs and the inputs; 0 of inputs, 1 of constants.

    What depends on parameters alone is an input, whose `fine` form says how it is made, where two of them are to be told apart.
    """

    def __init__(self, code: Code) -> None:
        self.code = code
        known: dict[tuple[Op | int, ...], int] = {}
        inputs = len(code.inputs)
        self.form = [0] * inputs + [1] * (code.first - inputs)
        self.fine = list(self.form)
        for k, (op, reads) in enumerate(zip(code.ops, code.args, strict=True)):
            if not code.varies[code.first + k]:
                fine = sorted(self.fine[a] for a in reads)
                same = op is NEG
                self.fine.append(
                    fine[0] if same else known.setdefault((ADD if op is SUB else op, *fine), len(known) + 2)
                )
                self.form.append(0)
                continue
            self.fine.append(0)
            forms = [self.form[a] for a in reads]
            if op is NEG:
                self.form.append(forms[0])
                continue
            if op is ADD or op is SUB or op is MUL:
                forms.sort()
            self.form.append(known.setdefault((ADD if op is SUB else op, *forms), len(known) + 2))

    @cached_property
    def uses(self) -> list[int]:
        """By what each value is read, and that in turn, a few times: not up to where limbs come together, one after the other."""
        code, known = self.code, dict[tuple[int, ...], int]()
        found = self.form
        for _ in range(_NEAR):
            read: list[list[int]] = [[] for _ in found]
            for i in reversed(range(code.first, len(found))):
                op, args = code.ops[i - code.first], code.args[i - code.first]
                if op is NEG:
                    read[args[0]] += read[i]
                else:
                    for a in args:
                        read[a].append(found[i])
            found = [
                known.setdefault((form, *sorted(own)), len(known)) for form, own in zip(self.form, read, strict=True)
            ]
        return found

    def plain(self, i: int) -> Operand:
        """A value without signs before it, and its sign."""
        sign, code = 1, self.code
        while i >= code.first and code.ops[i - code.first] is NEG:
            i, sign = code.args[i - code.first][0], -sign
        return Operand(i, sign)

    def op(self, i: int) -> Op:
        """The operation of an instruction, sums for differences."""
        op = self.code.ops[i - self.code.first]
        return ADD if op is SUB else op

    def reads(self, i: int) -> list[Operand]:
        """What an instruction reads, the sign of a difference with what is taken away."""
        own = [self.plain(a) for a in self.code.args[i - self.code.first]]
        if self.code.ops[i - self.code.first] is SUB:
            own[1] = own[1]._replace(sign=-own[1].sign)
        return own
