# SPDX-License-Identifier: BSD-3-Clause
"""What each rule is worth, in operations: `python -m benchmarks.ablation [number of random systems] [part of a rule's name …]`.

Left out one at a time are the entries of the tables of

    routes     what the search for the shortest formulation tries (`dynamics/formulation`): operations of q̇, u̇ and the reactions
    passes     what rewrites programs (`rewrite`, `program/passes`): operations of the compiled right-hand side

A row says of how many systems an entry changes the operations, how many there are more in all, and where most: in the gallery, among
the systems that are counted, among random ones of `tests/systems`. An entry that buys nothing has zeros in all three. Of a system
whose count falls another choice would have been shorter: candidates are priced before they are finished.
"""

import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context
from typing import Any

import kane as kn
from benchmarks.systems import COUNTED
from kane.dynamics.formulation.candidates import TRIED, Tried
from kane.dynamics.formulation.table import FINISHES, shortest, without_constraint_forces
from kane.dynamics.solved import Solved
from kane.equations.compiled import program
from kane.gallery import GALLERY, load
from kane.program.from_expressions import receipt
from kane.program.passes.optimize import RULES
from kane.program.program import Program
from tests.systems.draft_kinds import drafted
from tests.systems.drafts import built

RANDOM = 100
"""Random systems, unless told."""
JOBS = 2
LONGEST = 2_000
"""Operations of the largest systems that are tried: without a rule others would take minutes."""

Counted = Callable[[kn.Equations], int]


def _without(table: Sequence[Any], entry: Any) -> tuple[Any, ...]:
    return tuple(x for x in table if x is not entry)


def _name(entry: Any) -> str:
    """A function's or class's name, or the fields of a choice."""
    return entry if isinstance(entry, str) else getattr(entry, "__name__", None) or ", ".join(entry)


def _without_entries(tables: Any) -> Iterator[tuple[str, Any]]:
    """A record of tables without one entry, for each of the entries, with its name."""
    for field, table in tables._asdict().items():
        if isinstance(table, bool):
            yield field, tables._replace(**{field: False})
            continue
        for entry in table:
            yield f"{field}: {_name(entry)}", tables._replace(**{field: _without(table, entry)})


def _routed(eom: kn.Equations, search: Callable[..., Solved]) -> int:
    partition = None if eom.embedding is None else eom.embedding.partition
    return search(eom.derived, partition).price


def _compiled(eom: kn.Equations, **options: Any) -> int:
    return operations(program(eom.solved, ("rhs",), **options))


def operations(of: Program) -> int:
    """Operations of a program's right-hand side."""
    return receipt(of)["rhs"].total


def _search(tried: Tried = TRIED, finishes: Sequence[Any] = FINISHES) -> Callable[..., Solved]:
    return without_constraint_forces(partial(shortest, tried=tried, finishes=finishes))


def searches() -> dict[str, Callable[..., Solved]]:
    """The search for the shortest formulation under "", and without each entry of its tables by its name."""
    found = {"": _search(), "held forces": shortest}
    found |= {name: _search(tried) for name, tried in _without_entries(TRIED)}
    return found | {f"finishes: {_name(f)}": _search(finishes=_without(FINISHES, f)) for f in FINISHES}


def options() -> dict[str, dict[str, Any]]:
    """What programs are made with, all of it under "", and without each pass and each of its rules by their names."""
    found: dict[str, dict[str, Any]] = {"": {}, "reciprocals": {"reciprocals": False}, "optimize": {"optimize": False}}
    return found | {name: {"rules": rules} for name, rules in _without_entries(RULES)}


def routes() -> dict[str, Counted]:
    """Operations of the equations by each of the searches."""
    return {name: partial(_routed, search=search) for name, search in searches().items()}


def passes() -> dict[str, Counted]:
    """Operations of the compiled right-hand side by each of the options."""
    return {name: partial(_compiled, **given) for name, given in options().items()}


TABLES = {"routes": routes, "passes": passes}


def systems(random: int) -> Iterator[tuple[str, str]]:
    """Kinds of systems with their names."""
    yield from (("gallery", name) for name in GALLERY)
    yield from (("counted", name) for name in COUNTED)
    yield from (("random", str(seed)) for seed in range(random))


MAKE: dict[str, Callable[[str], kn.System]] = {
    "gallery": lambda name: load(name).system(),
    "counted": lambda name: COUNTED[name](),
    "random": lambda seed: built(drafted(int(seed))),
}


def costs(parts: Sequence[str], system: tuple[str, str]) -> dict[str, int]:
    """The operations that each entry saves of a system."""
    kind, name = system
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        eom = kn.derive(MAKE[kind](name))
        if eom.operations.total > LONGEST:
            return {}
        found: dict[str, int] = {}
        for title, table in TABLES.items():
            own = table()
            chosen = {rule: count for rule, count in own.items() if rule and _asked(f"{title}: {rule}", parts)}
            least = own[""](eom) if chosen else 0
            found |= {f"{title}: {rule}": count(eom) - least for rule, count in chosen.items()}
        return found


def _asked(rule: str, parts: Sequence[str]) -> bool:
    return not parts or any(part in rule for part in parts)


def rows(found: dict[tuple[str, str], dict[str, int]]) -> Iterator[str]:
    """A line a rule."""
    tried = {kind: sum(bool(c) for (k, _), c in found.items() if k == kind) for kind in MAKE}
    yield "  ".join(f"{kind}: {count} systems" for kind, count in tried.items())
    for rule in next(c for c in found.values() if c):
        line = f"{rule:44}"
        for kind in MAKE:
            changed = {name: c[rule] for (k, name), c in found.items() if k == kind and c.get(rule)}
            most = max(changed, key=lambda name: changed[name], default="")
            line += f" {len(changed):4} {sum(changed.values()):+6}"
            line += f" ({changed[most]:+} {most[:24]})" if most else ""
            line += " |" if kind != "random" else ""
        yield line


def main() -> None:
    """Print the rows."""
    random = next((int(x) for x in sys.argv[1:] if x.isdecimal()), RANDOM)
    parts = [x for x in sys.argv[1:] if not x.isdecimal()]
    names = list(systems(random))
    with ProcessPoolExecutor(JOBS, mp_context=get_context("spawn")) as pool:
        found = dict(zip(names, pool.map(partial(costs, parts), names, chunksize=2), strict=True))
    print("\n".join(rows(found)))


if __name__ == "__main__":
    main()
