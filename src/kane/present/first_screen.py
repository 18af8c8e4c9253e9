# SPDX-License-Identifier: BSD-3-Clause
"""The first screen of a report: the motion, its causes and its results on one time line, interactive if a kernel can run in the page.

Causes: each u̇ expanded into products with their current values, if that is short, u̇_r = Σ_s M⁻¹_rs (F_s + F*_s at u̇ = 0), with M⁻¹
in closed form for speeds that M couples at most in pairs; not with constraints or contacts. Otherwise, in each row of F_r + F*_r = 0,
the current contribution of every load and body. Results: coordinates, speeds, reactions and energy. If WebAssembly can run the motion,
sliders change parameters and start, and the page runs the same kernel as `kn.simulate`.
"""

import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from markupsafe import Markup

from kane.equations.compiled import output_bundle, program
from kane.equations.equations import Equations
from kane.errors import KaneError, KaneWarning
from kane.expr.build import div, mul, neg, sub, sum_of
from kane.expr.evaluation import free_symbols
from kane.expr.forms.collect import expanded, factored
from kane.expr.node import ONE, ZERO, Expr
from kane.expr.symbols import Input, Parameter, Symbol, rate
from kane.expr.visit import substitute
from kane.model.contact_modes import in_mode
from kane.motion.inputs.functions import constant
from kane.motion.programs.contacts_wasm import contacts_module
from kane.motion.programs.program_modes import modes_of
from kane.motion.programs.simulator_wasm import emit_simulator_wasm
from kane.motion.solution.solution import Solution
from kane.numeric.arrays import Array
from kane.present.animation import MODE_COLOURS, Animation, animation_of
from kane.present.languages.catalogue import N_, tr
from kane.present.overview import meaning
from kane.present.pages import as_json, deflated
from kane.present.scene.gather import scene
from kane.present.scene.records import Scene
from kane.program.emit.wasm import emit_wasm, emit_wasms
from kane.program.program import Program
from kane.units.rules import unit_text
from kane.write.latex import symbol_latex, to_latex

METHOD = "dop853"
"""The stepper of interactive motions."""
SAMPLES = 601
"""Number of instants of an interactive motion."""
_ROWS, _TERMS, _LINES = 5, 8, 6
"""Largest numbers of expanded rows, terms of a row, and lines of a plot; the largest along the motion are shown."""
_SPEEDS, _LETTERS = 4, 90
"""Largest numbers of equations that are expanded, and of letters of a term in LaTeX."""
_NOTHING = 1e-11
"""Fraction of the energy below which a contribution is not shown."""
_SLIDERS = 6
"""Largest number of sliders of parameters, and of the start."""
_MODES = 9
"""Number of modes of contacts up to which a page contains all modes; beyond it, only those of the motion."""
_LONGEST = 4000
"""Number of operations of an evaluation beyond which a page is not interactive."""


@dataclass(frozen=True, slots=True, eq=False)
class ShownQuantity:
    """A number along the motion: `group` is where it is shown, `label` its LaTeX or the name of a load or body.

    For a term of u̇, `source` is the load or body from which it comes.
    """

    group: str
    label: str
    unit: str
    expr: Expr
    kind: str = "line"
    source: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Slider:
    """A parameter or start value that the reader can change."""

    kind: str
    name: str
    label: str
    unit: str
    value: float
    low: float
    high: float
    meaning: str


@dataclass(frozen=True, slots=True, eq=False)
class TermRow:
    """A row of F_r + F*_r = 0 or of u̇: its label, and its terms with their indices."""

    label: str
    terms: tuple[tuple[int, ShownQuantity], ...]


@dataclass(frozen=True, slots=True, eq=False)
class FirstScreen:
    """The values of the template: the viewer, rows, collapsed rows, plots as (title, unit, lines), sliders, and data for the script.

    `multiplied` is true if the rows are those of u̇.
    """

    view: Markup
    multiplied: bool
    rows: tuple[TermRow, ...]
    folded: tuple[TermRow, ...]
    plots: tuple[tuple[str, str, tuple[tuple[int, ShownQuantity], ...]], ...]
    sliders: tuple[Slider, ...]
    data: Markup
    still: str


@dataclass(frozen=True, slots=True, eq=False)
class Cause:
    """A term of u̇: the load or body from which it comes, its kind, "active" or "inertia", and its LaTeX."""

    source: str
    kind: str
    term: Expr
    latex: str


def screen_of(solution: Solution, drawn: Scene | None = None) -> FirstScreen:
    """The first screen of a motion, with the scene of its system if it is already available."""
    eom = solution.equations
    animation = animation_of([solution], scene(eom) if drawn is None else drawn, (), autoplay=False)
    found = multiplied_out(eom)
    rows = list(terms(eom)) if found is None else list(_multiplied(found))
    shown = _shown([*rows, *_lines(eom)], animation.courses[0].motion, found is not None)
    values = [q for q, _ in shown]
    row = np.stack([v for _, v in shown], axis=-1) if shown else np.zeros((len(animation.courses[0].times), 0))
    live, sliders, still = _live(solution, animation, values)
    data = {"lines": len(values), "live": live, "samples": SAMPLES, "end": float(solution.t[-1])}
    numbered = list(enumerate(values))
    shown_rows, folded = _rows(animation.courses[0].motion, shown, found is not None)
    plots = tuple(_plots(numbered))
    part, packed = animation.part(extra=row, words=(live or {}).get("colours", ())), Markup(as_json(data))
    return FirstScreen(part, found is not None, shown_rows, folded, plots, sliders, packed, still)


# Displayed quantities --------------------------------------------------------------------------------------------------


def terms(eom: Equations) -> Iterator[ShownQuantity]:
    """For each equation the contributions of loads and bodies: F̃_r = F_r + Σ_D A_n,Dr F_D, and likewise for inertia."""
    dependent = [eom.contributions(u) for u in eom.dependent_speeds]
    for j, u in enumerate(eom.independent_speeds):
        own = eom.contributions(u)
        shares = [eom.A_n[k, j] for k in range(len(dependent))]
        every: list[Expr] = []
        for kind in ("active", "inertia"):
            by_source: dict[str, list[Expr]] = {}
            for share, found in ((ONE, own), *zip(shares, dependent, strict=True)):
                for c in getattr(found, kind):
                    by_source.setdefault(c.source.name, []).append(share * c.term)
            every += [x for parts in by_source.values() for x in parts]
            for name, parts in by_source.items():
                yield ShownQuantity(f"why {u.name}", name, "", sum_of(parts), kind)
        if eom.system.contacts:  # contact forces depend on the mode; they balance the other terms
            yield ShownQuantity(f"why {u.name}", tr("contacts"), "", -sum_of(every), "active")


def _multiplied(found: Mapping[Symbol, Sequence[Cause]]) -> Iterator[ShownQuantity]:
    for u, own in found.items():
        for c in own:
            source = tr("inertia of %(body)s", body=c.source) if c.kind == "inertia" else c.source
            yield ShownQuantity(f"why {u.name}", c.latex, "", c.term, c.kind, source)


def _lines(eom: Equations) -> Iterator[ShownQuantity]:
    of = ((N_("coordinates"), eom.coordinates), (N_("speeds"), eom.speeds), (N_("reactions"), eom.reactions))
    for group, symbols in of:
        for s in symbols:
            yield ShownQuantity(group, symbol_latex(s), eom.unit(s), s)
    yield ShownQuantity(N_("energy"), "K", "J", eom.kinetic_energy)
    if eom.potential_energy is not ZERO:
        yield ShownQuantity("energy", "V", "J", eom.potential_energy)


def _shown(wanted: Sequence[ShownQuantity], dense: Solution, multiplied: bool) -> list[tuple[ShownQuantity, Array]]:
    """The significant quantities, with their values along a motion; those that vanish throughout are omitted."""
    times = dense.t
    with warnings.catch_warnings():  # rows that are singular somewhere are left out below
        warnings.filterwarnings("ignore", "Expected dependent speeds", KaneWarning)
        values = dense[[q.expr for q in wanted]]
    found = [np.broadcast_to(np.asarray(v, dtype=float), times.shape) for v in values]
    sizes = [float(np.nanmax(np.abs(v), initial=0.0)) for v in found]
    by_group: dict[str, list[int]] = {}
    for k, q in enumerate(wanted):
        by_group.setdefault(f"{q.group} {q.unit}", []).append(k)
    kept: set[int] = set()
    idle = _idle(dense, float(times[-1] - times[0]), multiplied)
    for group, numbers in by_group.items():
        rows = wanted[numbers[0]].group.startswith("why")
        if rows and not all(np.isfinite(found[k]).all() for k in numbers):
            continue
        most = _TERMS if rows else _LINES
        scale = max(sizes[k] for k in numbers)
        if scale <= idle.get(group.strip(), 0.0):
            continue
        large = sorted((k for k in numbers if sizes[k] > 1e-12 * scale), key=lambda k: -sizes[k])
        kept |= set(large[:most])
    return [(wanted[k], found[k]) for k in sorted(kept)]


def _idle(dense: Solution, span: float, multiplied: bool) -> dict[str, float]:
    """The least significant size of terms of a row: their work beside the kinetic energy, or for u̇ the change of u."""
    eom = dense.equations
    energy = float(np.nanmax(np.abs(dense[eom.kinetic_energy]), initial=0.0))
    result = {}
    for u in eom.independent_speeds:
        fastest = float(np.nanmax(np.abs(dense[u]), initial=0.0))
        above, below = (fastest, span) if multiplied else (energy, fastest * span)
        result[f"why {u.name}"] = _NOTHING * above / below if below > 0 else 0.0
    return result


def _rows(
    dense: Solution, shown: Sequence[tuple[ShownQuantity, Array]], multiplied: bool
) -> tuple[tuple[TermRow, ...], tuple[TermRow, ...]]:
    """The rows whose terms do most work along the motion, and the others; work is comparable for rows of forces and of torques."""
    rows: list[TermRow] = []
    work: list[float] = []
    for u in dense.equations.independent_speeds:
        own = [(k, q, v) for k, (q, v) in enumerate(shown) if q.group == f"why {u.name}"]
        if own:
            speed = np.abs(np.broadcast_to(np.asarray(dense[u], dtype=float), dense.t.shape))
            label = symbol_latex(rate(u)) + " =" if multiplied else symbol_latex(u)
            rows.append(TermRow(label, tuple((k, q) for k, q, _ in own)))
            work.append(max(float(np.nanmax(np.abs(v) * speed, initial=0.0)) for _, _, v in own))
    most = set(sorted(range(len(rows)), key=lambda k: -work[k])[:_ROWS])
    return tuple(r for k, r in enumerate(rows) if k in most), tuple(r for k, r in enumerate(rows) if k not in most)


def _plots(
    numbered: Sequence[tuple[int, ShownQuantity]],
) -> Iterator[tuple[str, str, tuple[tuple[int, ShownQuantity], ...]]]:
    groups: dict[tuple[str, str], list[tuple[int, ShownQuantity]]] = {}
    for k, q in numbered:
        if q.kind == "line":
            groups.setdefault((q.group, q.unit), []).append((k, q))
    for (group, unit), lines in groups.items():
        yield tr(group), _unit(unit), tuple(lines)


# Code that runs in the page ---------------------------------------------------------------------------------------------


def _live(
    solution: Solution, animation: Animation, values: Sequence[ShownQuantity]
) -> tuple[dict[str, Any] | None, tuple[Slider, ...], str]:
    """The modules and their data; or the reason why the page shows only the given motion."""
    eom = solution.equations
    inputs = {s: constant(solution.inputs[s]) for s in eom.inputs if s in solution.inputs}
    if any(v is None for v in inputs.values()):
        return None, (), tr("Its inputs change with time.")
    if float(solution.t[0]) != 0.0:
        return None, (), tr("It does not begin at t = 0.")
    if eom.operations.total > _LONGEST:
        return None, (), tr("Its equations are long.")
    exprs = [*animation.scene.row, *(q.expr for q in values)]
    try:
        run, read, more = _modules(solution, exprs)
    except KaneError as error:
        return None, (), str(error)
    start = dict(zip([s.name for s in eom.state], map(float, solution.states[0]), strict=False))
    given = {s.name: float(v) for s, v in solution.parameters.items() if isinstance(s, Parameter)}
    sliders = tuple(_sliders(eom, given, start))
    live = {
        "run": deflated(run),
        "read": deflated(read),
        "state": start,
        "parameters": given,
        "inputs": {s.name: float(v) for s, v in inputs.items() if isinstance(s, Input) and v is not None},
        "count": len(exprs),
        "tolerances": [solution.rtol, solution.atol or 1e-9],
        **more,
    }
    return live, sliders, ""


def _modules(solution: Solution, exprs: Sequence[Expr]) -> tuple[bytes, bytes, dict[str, Any]]:
    """The module that runs the motion, that which evaluates expressions along it, and the colours of modes of contacts."""
    eom, compiled = solution.equations, solution.equations.compile()
    if not eom.system.modes_change:
        return emit_simulator_wasm(compiled, METHOD, samples=SAMPLES), emit_wasm(_reader(eom, exprs)), {}
    own = tuple(dict.fromkeys(one.system.modes for one in solution.samples))
    modes = modes_of(compiled, METHOD, own, _MODES)
    run = contacts_module(compiled, modes, METHOD, SAMPLES)
    readers = [_reader(one.equations, in_mode(eom.system.contacts, one.modes, exprs)) for one in modes]
    words = {m.word(c) for one in modes for m, c in zip(one.modes, eom.system.contacts, strict=True)}
    return (
        run,
        emit_wasms(readers),
        {"colours": {word: colour for word, colour in MODE_COLOURS.items() if word in words}},
    )


def _reader(eom: Equations, exprs: Sequence[Expr]) -> Program:
    """The program that evaluates expressions."""
    bundle = output_bundle(eom.solved, {f"{k}": e for k, e in enumerate(exprs)})
    return program(eom.solved, (), bundle, reciprocals=False)


def _sliders(eom: Equations, given: Mapping[str, float], start: Mapping[str, float]) -> Iterator[Slider]:
    """Sliders of those parameters and start values whose change does not violate constraints."""
    rows = [c.expr for c in eom.system.constraints]
    held = set(free_symbols(rows))
    free = [p for p in eom.parameters if p not in held and p.name in given]
    for p in free[:_SLIDERS]:
        v = given[p.name]
        low, high = (0.25 * v, 2.5 * v) if v else (-1.0, 1.0)
        yield _slider("parameters", p, v, min(low, high), max(low, high))
    if rows:
        return
    euler = {e for s in eom.system.euler_parameters for e in s.coordinates}
    moving: list[Symbol] = [*(q for q in eom.coordinates if q not in euler), *eom.speeds]
    for s in moving[:_SLIDERS]:
        v = start[s.name]
        reach = max(abs(v), 1.0) if s.unit != "rad" else 1.5
        yield _slider("state", s, v, v - reach, v + reach)


def _slider(kind: str, s: Symbol, value: float, low: float, high: float) -> Slider:
    return Slider(kind, s.name, symbol_latex(s), _unit(s.unit), value, low, high, meaning(s))


def _unit(unit: str) -> str:
    return unit_text(unit) if unit not in ("", "1") else ""


def multiplied_out(eom: Equations) -> Mapping[Symbol, Sequence[Cause]] | None:
    """The terms of each u̇; None if they are too many or too long."""
    if eom.embedding or eom.system.contacts or len(eom.speeds) > _SPEEDS:
        return None
    inverse = _inverse(eom)
    forces = None if inverse is None else [_forces(eom, u) for u in eom.speeds]
    if inverse is None or forces is None:
        return None
    result: dict[Symbol, Sequence[Cause]] = {}
    for r, u in enumerate(eom.speeds):
        shares = [(inverse[r, s], own) for s, own in enumerate(forces) if (r, s) in inverse]
        terms = list(_terms(shares))
        if None in terms or len(terms) > _TERMS:
            return None
        result[u] = [t for t in terms if t is not None]
    return result


def _forces(eom: Equations, u: Symbol) -> Mapping[tuple[str, str], Expr]:
    """Contributions of loads and bodies to the equation of u, except M u̇."""
    still = {rate(s): ZERO for s in eom.speeds}
    own = eom.contributions(u)
    found: dict[tuple[str, str], list[Expr]] = {}
    for kind, parts in (("active", own.active), ("inertia", own.inertia)):
        for c in parts:
            found.setdefault((c.source.name, kind), []).append(substitute(c.term, still))
    return {which: sum_of(parts) for which, parts in found.items()}


def _terms(shares: Sequence[tuple[Expr, Mapping[tuple[str, str], Expr]]]) -> Iterator[Cause | None]:
    """The products that each load and body adds to u̇; None in place of long ones."""
    for which in dict.fromkeys(which for _, own in shares for which in own):
        products = expanded(sum_of([mul(m, own[which]) for m, own in shares if which in own]))
        for product in [None] if products is None else products:
            term = ZERO if product is None else factored([product])
            latex = to_latex(term)
            yield Cause(*which, term, latex) if product is not None and len(latex) <= _LETTERS else None


def _inverse(eom: Equations) -> Mapping[tuple[int, int], Expr] | None:
    """The nonzero entries of M⁻¹; None if M couples more than two speeds."""
    m, n = eom.mass_matrix, len(eom.speeds)
    result: dict[tuple[int, int], Expr] = {}
    for i in range(n):
        others = [j for j in range(n) if j != i and m[i, j] is not ZERO]
        if len(others) > 1:
            return None
        if not others:
            result[i, i] = div(ONE, m[i, i])
            continue
        (j,) = others
        squares = sub(mul(m[i, i], m[j, j]), mul(m[i, j], m[i, j]))
        short = expanded(squares)
        squares = squares if short is None else factored(short)
        result[i, i], result[i, j] = div(m[j, j], squares), neg(div(m[i, j], squares))
    return result
