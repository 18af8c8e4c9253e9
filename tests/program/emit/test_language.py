# SPDX-License-Identifier: BSD-3-Clause
"""A new language is a function and a row of the registry: here three-address code, with an interpreter of ten lines."""

import numpy as np
import pytest

import kane as kn
from kane.expr import OPS
from kane.gallery import pendulums, rolling_disk
from kane.program import (
    VECTORS,
    Compute,
    Read,
    SinCos,
    Style,
    function_of,
    hoisting,
    local_names,
    pieces,
    statements,
    targets,
)

SPELLING = {op: f"{{}} := {name} {' '.join(['{}'] * op.arity)}" for name, op in OPS.items() if op.arity}
STYLES = [
    Style(),
    Style(lazy=True),
    Style(whole=50, piece=20),
    Style(lazy=True, whole=50, piece=20, lanes=4),
    Style(lanes=1),
    Style(lazy=True, whole=50, piece=30, lanes=8),
]
SYSTEMS = {"rolling disk": rolling_disk.system, "angles of angles": lambda: pendulums.system(12, relative=True)}


def emitter(style):
    def emit(program, *, version):
        names = local_names(program, str.isidentifier)
        lines = [f"# {program.name} by kane {version}"]
        for function in (hoisting(program), *(function_of(program, r) for r in program.routines)):
            lines.append(f"function {function.name}")
            values = names.of(function, repr)
            for piece in pieces(program, function, style).chunks:
                lines.append("piece")
                lines += [line(s, values) for s in statements(program, function, piece, style)]
        return "\n".join(lines)

    return emit


def line(s, values):
    if isinstance(s, Read):
        return f"{values[s.value]} := load {s.base} {s.offset}"
    if isinstance(s, Compute):
        return SPELLING[s.op].format(values[s.value], *(values[a] for a in s.arguments))
    if isinstance(s, SinCos):
        angles = zip(s.angles, s.values, strict=True)
        return " ; ".join(f"{values[i]} := {op.name} {values[a]}" for a, own in angles for op, i in own.items())
    return f"store {s.base} {s.offset} {values[s.value]}"


def run(text, vectors, scalars):
    """The vectors after all functions; what a piece has loaded or computed is forgotten at its end."""
    for statement in text.replace(" ; ", "\n").splitlines()[1:]:
        words = statement.split()
        if words[0] == "piece":
            known = dict(scalars)
        elif words[0] == "store":
            vectors[words[1]][int(words[2])] = known[words[3]] if words[3] in known else float(words[3])
        elif words[0] != "function":
            name, _, op, *operands = words
            assert name not in known
            if op == "load":
                known[name] = vectors[operands[0]][int(operands[1])]
            else:
                numbers = [known[o] if o in known else np.float64(o) for o in operands]
                known[name] = OPS[op].numpy(*numbers)
    return vectors


@pytest.mark.slow
@pytest.mark.parametrize("style", STYLES)
@pytest.mark.parametrize("model", SYSTEMS)
def test_a_language_of_ones_own(style, model, monkeypatch):
    monkeypatch.setitem(targets.EMITTERS, "three-address", emitter(style))
    eom = kn.derive(SYSTEMS[model]())
    compiled = eom.compile(contract=False)
    text = compiled.emit("three-address", "rhs")
    assert text.startswith("# model by kane ")
    x = np.linspace(0.3, 1.2, len(eom.coordinates) + len(eom.speeds))
    memory = {base: np.full(2000, np.nan) for base in VECTORS}
    found = run(text, {"x": x, "p": compiled.parameters(), **memory}, {"t": 0.0})
    np.testing.assert_allclose(found["<out>"][: len(x)], compiled.rhs(0.0, x), rtol=1e-12)


def test_a_language_that_is_not_there():
    compiled = kn.derive(rolling_disk.system()).compile()
    with pytest.raises(kn.ArgumentError, match=r"Expected one of c, h, numpy, jax, .*javascript, .*wasm, got 'cobol'"):
        compiled.emit("cobol")
