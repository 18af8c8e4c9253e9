# SPDX-License-Identifier: BSD-3-Clause
"""A Program in a notebook: signatures, what the arguments and results are, operations."""

from collections.abc import Sequence

from kane.present.notebook.typeset import code, escaped, math, paragraph, table
from kane.program.build import Receipt, receipt
from kane.program.program import Port, Program, Routine
from kane.write.latex import latex_name

_FEW = 12
"""Names of a vector that are listed."""


def routine_html(program: Program, routine: Routine) -> str:
    """Signature, arguments, results and operations of one routine."""
    shape = " × ".join(map(str, routine.shape))
    rows = [*_arguments(program), (code("results"), "", shape, _labels(routine.labels))]
    operations = paragraph(escaped(receipt(program)[routine.name]))
    return paragraph(_signature(program, routine)) + table(_HEAD, rows) + operations


def program_html(program: Program, costs: Receipt) -> str:
    """The arguments that all routines share, and a line for each routine."""
    routines = [
        (_signature(program, routine), _labels(routine.labels), escaped(costs[routine.name]))
        for routine in program.routines
        if routine.results
    ]
    lead = paragraph(f"<b>Compiled</b>: {escaped(program.name)}")
    return lead + table(_HEAD, _arguments(program)) + table(("routine", "results", "operations"), routines)


_HEAD = ("argument", "", "size", "names")


def _arguments(program: Program) -> list[tuple[str, ...]]:
    ports = [port for port in program.ports if port.symbols]
    return [(code(p.name), escaped(p.noun), "" if p.scalar else str(len(p.symbols)), _symbols(p)) for p in ports]


def _signature(program: Program, routine: Routine) -> str:
    return code(f"{routine.name}({program.signature}) → {list(routine.shape)}")


def _symbols(port: Port) -> str:
    few = [latex_name(s.name) for s in port.symbols[:_FEW]]
    return math(r",\, ".join([*few, *([r"\dots"] if len(port.symbols) > _FEW else [])]))


def _labels(labels: Sequence[str]) -> str:
    return code(", ".join(labels[:_FEW])) + (", …" if len(labels) > _FEW else "")
