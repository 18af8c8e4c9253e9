# SPDX-License-Identifier: BSD-3-Clause
"""What notebooks show of systems, equations, motions and compiled code: formulas that MathJax and KaTeX take, escaped text."""

from __future__ import annotations

import re
import subprocess
import sys
from dataclasses import dataclass, replace
from functools import cache
from html.parser import HTMLParser
from typing import Any

import numpy as np
import pytest

import kane as kn
from kane.errors import Attributes
from kane.gallery import pendulum
from kane.gallery.pendulums import system as chain
from tests.present.disk import derived, moved

HOSTILE = r"<script>alert(1)</script>&$x$\(y\)"
WORDS = "displaystyle begin end text frac sqrt left right sin cos tan dot hat prime mathrm dots lt mu theta"
COMMANDS = {f"\\{word}" for word in WORDS.split()}


class Shown(HTMLParser):
    """Parsed HTML: the text between any two tags, and the rows of tables."""

    def __init__(self, text: str | None) -> None:
        super().__init__()
        assert text is not None
        self.tags: list[str] = []
        self.pieces: list[str] = []
        self.rows: list[list[str]] = []
        self._open: list[str] = []
        self.feed(re.sub(r"<svg.*?</svg>", "", text, flags=re.DOTALL))  # sketches have tests of their own
        self.close()
        assert not self._open

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        assert all(name == "style" for name, _ in attrs)
        self.tags.append(tag)
        if tag != "br":
            self._open.append(tag)
        if tag == "tr":
            self.rows.append([])
        if tag in ("td", "th"):
            self.rows[-1].append("")
        self.pieces.append("")

    def handle_endtag(self, tag: str) -> None:
        assert self._open.pop() == tag
        self.pieces.append("")

    def handle_data(self, data: str) -> None:
        if "code" not in self._open:  # where MathJax does not look
            self.pieces[-1] += data
        if {"td", "th"} & set(self._open):
            self.rows[-1][-1] += data

    @property
    def formulas(self) -> list[str]:
        """What lies between dollar signs of one text; a delimiter that is text stands alone."""
        found: list[str] = []
        for piece in self.pieces:
            bare = re.sub(r"\\[^a-zA-Z]", lambda m: "\0" * len(m[0]), piece)
            if piece in ("$", "\\"):
                continue
            at = [m.start() for m in re.finditer(r"\$", bare)]
            assert len(at) % 2 == 0, piece
            spans = list(zip(at[::2], at[1::2], strict=True))
            for i, j in reversed(spans):
                found.append(piece[i + 1 : j])
                piece = piece[:i] + piece[j + 1 :]
            assert "\\" not in piece, piece
        return found

    def row(self, start: str) -> list[str]:
        return next(row for row in self.rows if row[0] == start)


@cache
def hostile() -> tuple[kn.System, kn.Equations]:
    """A particle on a spring, all of whose names and descriptions are hostile."""
    frame = kn.Frame(HOSTILE)
    origin = kn.Point(HOSTILE, fixed_in=frame)
    q = kn.coordinate("q$<script>", "m", HOSTILE)
    u = kn.speed("u\\end", "m/s", HOSTILE)
    m = kn.parameter("m<i>", 1.0, "kg", HOSTILE)
    k = kn.parameter("k}{", 2.0, "N/m", HOSTILE)
    pull = kn.input("F%#", "N", HOSTILE)
    point = origin.at("P<", q * frame.x)
    event = kn.Event(HOSTILE, q, 0.5, message=HOSTILE)
    system = kn.System(
        frame,
        bodies=[kn.Particle(HOSTILE, point, m)],
        speeds={u: q.dt},
        loads=[
            kn.linear_spring(point, origin, k, name=HOSTILE),
            kn.Force(point, pull * frame.x, name=HOSTILE),
            kn.gravity(-9.81 * frame.y, name=HOSTILE),
        ],
        events=[event],
    )
    return system, kn.derive(system)


@cache
def hostile_motion() -> kn.Solution:
    _, eom = hostile()
    return kn.simulate(eom, (0.0, 2.0), q=[0.1], u=[1.0], inputs={eom.inputs[0]: lambda t: 0.0}, samples=5)


@cache
def shown() -> dict[str, Shown]:
    model, eom = derived()
    compiled = eom.compile()
    mean, odd = hostile()
    things: dict[str, Any] = {
        "system": model.system,
        "equations": eom,
        "solution": moved(),
        "compiled": compiled,
        "handle": compiled.rhs,
        "pendulum": kn.derive(pendulum.system()),
        "chain": kn.derive(chain(12)),
        "hostile system": mean,
        "hostile equations": odd,
        "hostile solution": hostile_motion(),
        "hostile compiled": odd.compile(name="a"),
        "hostile handle": odd.compile(name="a").mass_matrix,
    }
    return {name: Shown(thing._repr_html_()) for name, thing in things.items()}


EVERY = ["system", "equations", "solution", "compiled", "handle", "pendulum", "chain"] + [
    f"hostile {kind}" for kind in ("system", "equations", "solution", "compiled", "handle")
]


@pytest.mark.slow
@pytest.mark.parametrize("name", EVERY)
def test_formulas_are_whole_and_plain(name: str) -> None:
    page = shown()[name]
    assert page.formulas
    for formula in page.formulas:
        bare = re.sub(r"\\[^a-zA-Z]", "", formula)
        assert bare.count("{") == bare.count("}"), formula
        assert bare.count(r"\left") == bare.count(r"\right"), formula
        assert bare.count(r"\begin") == bare.count(r"\end"), formula
        assert not set("<>$#%~") & set(bare), formula
        if not name.startswith("hostile"):
            assert set(re.findall(r"\\[a-zA-Z]+", formula)) <= COMMANDS, formula


@pytest.mark.parametrize("name", EVERY)
def test_nothing_is_markup_but_the_markup(name: str) -> None:
    page = shown()[name]
    assert set(page.tags) <= {"p", "b", "div", "table", "tr", "th", "td", "code", "details", "summary", "br", "span"}


def test_hostile_text_is_shown_as_text() -> None:
    page = shown()["hostile system"]
    assert not {"x", "y"} & {f for name in EVERY if name.startswith("hostile") for f in shown()[name].formulas}
    assert page.row(HOSTILE)[0] == HOSTILE
    assert page.row(r"$\mathrm{q\$\lt script\gt }$")[1:] == ["m", HOSTILE]
    assert shown()["hostile solution"].row(HOSTILE)[2] == HOSTILE


def test_the_disk_as_declared() -> None:
    page = shown()["system"]
    assert page.row("disk") == [
        "disk",
        "$m$",
        "$C^{*}$",
        "$C$",
        r"$\frac{m R^{2}}{4}\,\hat{c}_{x} \hat{c}_{x} + \frac{m R^{2}}{4}\,\hat{c}_{y} \hat{c}_{y} + "
        r"\frac{m R^{2}}{2}\,\hat{c}_{z} \hat{c}_{z}$",
    ]
    assert page.row("$q_{2}$") == ["$q_{2}$", "rad", "lean"]
    assert page.row("$u_{3}$") == ["$u_{3}$", r"$\dot{q}_{1} \sin q_{2} + \dot{q}_{3}$", "rad/s"]
    assert page.row("gravity") == ["gravity", r"$-g\,\hat{n}_{z}$ on every body"]
    assert page.row("friction")[1].startswith(r"force on $\hat{C}$: $-\frac{\mu_{k} N_{z}")
    assert page.row("$N_{z}$") == ["$N_{z}$", "$P$", r"$\hat{n}_{z}$", "N"]
    assert page.row("$g$") == ["$g$", "9.81", "m/s²", "acceleration of free fall"]


def test_the_disks_angular_velocity() -> None:
    model, eom = derived()
    assert eom.angular_velocities[model.C]._repr_latex_() == (
        r"$\displaystyle u_{1}\,\hat{b}_{x} + u_{2}\,\hat{b}_{y} + u_{3}\,\hat{b}_{z}$"
    )


def test_the_pendulum_in_full() -> None:
    page = shown()["pendulum"]
    assert (
        r"\displaystyle \begin{aligned} & M = \begin{bmatrix} m l^{2} + I \end{bmatrix} \\ & f = \begin{bmatrix} "
        r"-m g l \sin \theta - c u_{\theta} \end{bmatrix} \end{aligned}"
    ) in page.formulas
    assert r"\displaystyle \dot{\theta} = u_{\theta}" in page.formulas
    assert "5 parameters" in [row[0] for row in page.rows]


def test_the_disks_equations() -> None:
    page = shown()["equations"]
    (motion,) = [f for f in page.formulas if "M = " in f]
    mass, _, rest = motion.partition(r"\\ & f = ")
    assert r"\frac{5 m R^{2}}{4} & 0 & 0 & m R \cos q_{2} \sin q_{1} & -m R \cos q_{1} \cos q_{2}" in mass
    assert "Z_" not in mass
    assert r"\text{where} \\ & Z_{1} = " in rest
    used = re.findall(r"Z_\{\d+\}", rest)
    assert set(used) == set(re.findall(r"& (Z_\{\d+\}) = ", rest))
    (rates,) = [f for f in page.formulas if r"\dot{q}_{1} = " in f]
    assert r"\dot{q}_{3} = u_{3} - u_{2} \tan q_{2}" in rates
    assert str(derived()[1].operations) in " ".join(page.pieces)
    assert [row[1] for row in page.rows if row[0].isdigit()] == [s.title for s in derived()[1].steps]


def test_m_and_f_share_intermediates_where_both_are_long() -> None:
    page = Shown(kn.derive(chain(5))._repr_html_())
    (motion,) = [f for f in page.formulas if "M = " in f]
    mass, forcing, where = re.split(r" \\\\ & (?=f = |\\text\{where\})", motion)
    rows = mass.split(r"\\[3pt]")
    assert [row.removeprefix(r"\displaystyle \begin{aligned} & ").count(" & ") for row in rows] == [4] * 5
    assert not re.search(r"\bg\b", mass)
    assert [row.count("&") for row in forcing.split(r"\\[3pt]")] == [0] * 5
    assert re.search(r"\bg\b", forcing)
    named = re.findall(r"& (Z_\{\d+\}) = ", where)
    assert named == [f"Z_{{{i}}}" for i in range(1, len(named) + 1)]
    assert set(re.findall(r"Z_\{\d+\}", mass + forcing)) <= set(named)


def test_where_each_step_is_read() -> None:
    for row in shown()["equations"].rows:
        if row[0].isdigit():
            for name in row[3].split(", "):
                assert hasattr(derived()[1], name.removesuffix("[1]"))


def test_a_large_system_is_described() -> None:
    page = shown()["chain"]
    text = " ".join(page.pieces)
    assert re.search(r"M is a 12 × 12 matrix with 144 entries .* take \d+ operations, too long to typeset\.", text)
    assert "bmatrix" not in text
    assert str(kn.derive(chain(12)).operations) in text


@pytest.mark.slow
def test_a_very_large_system_is_short_and_quick() -> None:
    text = kn.derive(chain(30))._repr_html_()
    assert text is not None
    assert len(text) < 5000
    assert "… and 10 more" in text


def test_the_motion() -> None:
    solution, page = moved(), shown()["solution"]
    text = " ".join(page.pieces)
    assert f"{solution.status}: {solution.message}" in text
    assert str(solution.energy_check)[1:] in text
    eom = solution.equations
    for k, s in enumerate((*eom.coordinates, *eom.speeds)):
        first, last = solution.states[[0, -1], k]
        assert page.row(f"${s.name[0]}_{{{s.name[1]}}}$")[1:3] == [f"{first:.6g}", f"{last:.6g}"]


def test_compiled_code() -> None:
    eom = derived()[1]
    for name in ("compiled", "handle"):
        page = shown()[name]
        assert page.row("x")[1:3] == ["state", "10"]
        assert page.row("p")[3] == r"$R,\, m,\, \mu_{k},\, g$"
    compiled = eom.compile()
    page = shown()["compiled"]
    assert page.row("rhs(t, x[10], p[4]) → [10]")[2] == str(compiled.operations["rhs"])
    assert page.row("reactions(t, x[10], p[4]) → [1]")[1] == "N_z"
    assert shown()["handle"].row("results")[3].startswith("q1', q2', q3'")


def test_a_compiled_model_is_shown_without_compiling_more() -> None:
    compiled = derived()[1].compile()
    assert compiled._repr_html_()
    assert "mass_matrix" not in vars(compiled)


def test_odd_things_are_shown_all_the_same() -> None:
    solution = moved()
    page = Shown(replace(solution, states=np.full_like(solution.states, np.nan))._repr_html_())
    assert page.row("$q_{1}$")[1:3] == ["nan", "nan"]
    assert "Energy minus work constant to nan J" in " ".join(page.pieces)
    empty = replace(solution, t=solution.t[:0], states=solution.states[:0], work=solution.work[:0])
    assert "no samples" in " ".join(Shown(empty._repr_html_()).pieces)
    lacking = replace(derived()[1])
    vars(lacking)["rates"] = ()
    assert "Not shown: ValueError" in " ".join(Shown(lacking._repr_html_()).pieces)
    kinds: tuple[Any, ...] = (kn.System, kn.Equations, kn.Solution, kn.Compiled, kn.Handle)
    for kind in kinds:
        text = object.__new__(kind)._repr_html_()
        assert text is None or "Not shown: MissingAttributeError" in text


def test_a_system_without_inertia_is_shown() -> None:
    """Its equations are singular, so it cannot be derived; it can be looked at."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    q = kn.coordinate("q")
    system = kn.System(N, bodies=[kn.Particle("P", O.at("P", q * N.x), 0)], speeds="rates")
    assert Shown(system._repr_html_()).row("P")[:2] == ["P", "$0$"]


def test_what_is_printed_is_as_before() -> None:
    model, eom = derived()
    assert repr(model.system) == "System(disk; 5 coordinates, 5 speeds)"
    assert repr(eom.compile().rhs).startswith("<rhs(t, x[10], p[4]) -> [10]: q1'")
    assert repr(kn.Matrix([[1]])) == "Matrix([[1]])"


@pytest.mark.slow
def test_nothing_heavy_is_imported() -> None:
    code = (
        "import sys, kane as kn; from kane.gallery import rolling_disk\n"
        "m = rolling_disk.model(); e = kn.derive(m.system)\n"
        "for x in (m.system, e): assert x._repr_html_()\n"
        "assert e.mass_matrix._repr_latex_() and m.slip._repr_latex_()\n"
        "print(*sys.modules)"
    )
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert {"sympy", "matplotlib", "jinja2", "scipy.integrate", "llvmlite", "IPython"} & set(loaded) == set()


def test_motions_are_tables():
    frame = kn.Frame("F$<")
    q, u = kn.coordinates("q1 q2"), kn.speeds("u1 u2")
    held = [q[0].dt - kn.parameter("a<i>") * q[1].dt]
    shown = Shown(kn.motions(frame, {u[0]: q[0].dt, u[1]: 2 * q[1].dt}, nonholonomic=held)._repr_html_())
    assert [row[0] for row in shown.rows if not row[0].startswith("$")] == ["speed", "rate", "dependent speed"]
    assert len(shown.formulas) == 10


def test_sets_of_forces_and_wrenches_are_tables():
    frame = kn.Frame("F$<")
    at = kn.Point("O<&", fixed_in=frame)
    both = kn.force_system(
        [kn.Force(at, kn.parameter("a<i>") * frame.x), kn.Torque(frame, kn.parameter("b$") * frame.x)]
    )
    shown = Shown(both._repr_html_())
    assert [row[0] for row in shown.rows] == ["at", "O<&", ""]
    assert len(shown.formulas) == 2
    shown = Shown(both.wrench(at)._repr_html_())
    assert len(shown.rows) == 2
    assert len(shown.formulas) == 4


def test_principal_moments_are_a_table_of_formulas():
    frame = kn.Frame("F$<")
    shown = Shown(
        kn.principal(
            kn.inertia(frame, kn.parameter("a<i>"), kn.parameter("b$"), 3, Ixy=kn.parameter("c"))
        )._repr_html_()
    )
    assert shown.rows[0] == ["principal moment", "axis"]
    assert len(shown.rows) == 4
    assert len(shown.formulas) == 6


def test_a_system_begins_with_its_sketch() -> None:
    shown = pendulum.system()._repr_html_()
    assert shown is not None
    assert shown.count('class="kane-sketch"') == 1
    assert shown.index("<svg") < shown.index("<table")
    assert 'data-s="theta"' in shown


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (1234567, "1234567"),
        (np.int64(12345678), "12345678"),
        (np.True_, "yes"),
        (np.array(2.5), "2.5"),
        (1.5e7, "1.5e+07"),
    ],
)
def test_numbers_within_records(value: Any, shown: str) -> None:
    """Counts keep all their digits, and NumPy's values are shown as Python's."""

    @dataclass(frozen=True)
    class Counted(Attributes):
        evaluations: Any

    assert Shown(Counted(value)._repr_html_()).rows == [["evaluations", shown]]
