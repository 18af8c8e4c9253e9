# SPDX-License-Identifier: BSD-3-Clause
"""A Program in a notebook: signatures, what the arguments and results are, operations."""

from collections.abc import Sequence

from kane.present.notebook.pieces import escaped, math, paragraph, table
from kane.program.program import Port, Program, Routine
from kane.program.receipt import Receipt, receipt
from kane.write.latex import latex_name

_FEW = 12
"""Names of a vector that are listed."""


def routine_html(program: Program, routine: Routine) -> str:
    """Signature, arguments, results and operations of one routine."""
    rows = [*_arguments(program), ("<code>results</code>", "", _shape(routine), _labels(routine.labels))]
    operations = paragraph(escaped(receipt(program)[routine.name]))
    return _code(_signature(program, routine)) + table(_HEAD, rows) + operations


def program_html(program: Program, costs: Receipt) -> str:
    """The arguments that all routines share, and a line for each routine."""
    routines = [
        (
            f"<code>{escaped(_signature(program, routine))}</code>",
            _labels(routine.labels),
            escaped(costs[routine.name]),
        )
        for routine in program.routines
        if routine.results
    ]
    lead = paragraph(f"<b>Compiled</b>: {escaped(program.name)}")
    return lead + table(_HEAD, _arguments(program)) + table(("routine", "results", "operations"), routines)


_HEAD = ("argument", "", "size", "names")


def _arguments(program: Program) -> list[tuple[str, ...]]:
    ports = [port for port in program.ports if port.symbols]
    return [(f"<code>{escaped(p.name)}</code>", escaped(p.noun), _size(p), _symbols(p)) for p in ports]


def _signature(program: Program, routine: Routine) -> str:
    return f"{routine.name}({program.signature}) → {list(routine.shape)}"


def _size(port: Port) -> str:
    return "" if port.scalar else str(len(port.symbols))


def _shape(routine: Routine) -> str:
    return " × ".join(map(str, routine.shape))


def _symbols(port: Port) -> str:
    few = [latex_name(s.name) for s in port.symbols[:_FEW]]
    return math(r",\, ".join([*few, *([r"\dots"] if len(port.symbols) > _FEW else [])]))


def _labels(labels: Sequence[str]) -> str:
    return _code_of(", ".join(labels[:_FEW])) + (", …" if len(labels) > _FEW else "")


def _code_of(text: str) -> str:
    return f"<code>{escaped(text)}</code>" if text else ""


def _code(text: str) -> str:
    return paragraph(_code_of(text))
