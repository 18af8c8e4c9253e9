# SPDX-License-Identifier: BSD-3-Clause
"""The report: self-contained, seven chapters, formulas that stand for something, figures as computed."""

from __future__ import annotations

import base64
import hashlib
import json
import re
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kane as kn
from kane import Check
from kane.dynamics import shown_speeds
from kane.gallery import double_pendulum, four_bar, pure_rolling_disk
from kane.gallery.contacts import bouncing_ball
from kane.gallery.pendulums import system as chain
from kane.present import Tex, chapters_of, declared_tables, motion_checks
from kane.write import latex_name
from tests.present.disk import derived, moved
from tests.present.page import Page
from tests.systems.dumbbell import ONE as DUMBBELL

CHECKS = (Check("first <of> two", 1.234e-15, 1e-10, "a & b"), Check("second", 3e-2, 1e-6))


@pytest.fixture(scope="module")
def text(tmp_path_factory: pytest.TempPathFactory) -> str:
    target = tmp_path_factory.mktemp("report") / "new" / "disk.html"
    made = kn.report(
        derived()[1], target, solution=moved(), title="A <disk>", sources=("Somebody & others",), checks=CHECKS
    )
    assert made == target
    return made.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def page(text: str) -> Page:
    return Page(text)


@pytest.mark.slow
def test_loads_nothing(page: Page, text: str) -> None:
    assert page.loads == []
    assert not {"link", "img", "iframe", "object", "embed"} & set(page.tags)
    assert "default-src 'none'" in text


def test_is_light(text: str) -> None:
    assert len(text.encode()) <= 500_000


def test_only_the_scripts_that_it_carries_run(text: str) -> None:
    """The policy names each by its hash, that of the loader too, and no others."""
    policy = re.search(r"script-src ([^;]*);", text)
    found = re.search(r'<script type="text/plain">(.*?)</script>\n<script>(.*?)</script>', text, re.DOTALL)
    assert policy is not None
    assert found is not None
    packed, loader = found.groups()
    _, *scripts = json.loads(zlib.decompress(base64.b64decode(packed)))
    hashes = [base64.b64encode(hashlib.sha256(s.encode()).digest()).decode() for s in (loader, *scripts)]
    assert policy[1].split() == [*(f"'sha256-{h}'" for h in hashes), "'wasm-unsafe-eval'"]
    assert text.count("<script>") == 1


def test_references_are_within_the_page(page: Page) -> None:
    assert len(page.identifiers) == len(set(page.identifiers))
    missing = {r[1:] for r in page.references} - set(page.identifiers)
    assert missing == set()


def test_a_chapter_for_each_step(page: Page) -> None:
    assert [s for s in page.sections if s.startswith("step-")] == [f"step-{i}" for i in range(1, 8)]
    assert page.sections[:2] == ["sketch", "system"]
    assert page.sections[9:] == ["why", "operations", "checks", "motion", "sources"]


def test_formulas_are_whole(page: Page) -> None:
    for section in page.sections[:9]:
        assert page.math[section], section
        for formula in page.math[section]:
            assert formula.strip()
            assert formula.count("{") == formula.count("}"), formula
            assert formula.count(r"\left") == formula.count(r"\right"), formula
            assert not re.search(r"=\s*$", formula), formula


def test_every_equation_of_motion_is_there(page: Page) -> None:
    _, eom = derived()
    shown = "\n".join(page.math["step-7"])
    for i in range(1, 6):
        assert rf"f_{{u_{{{i}}}}} = " in shown
        assert rf"\dot{{u}}_{{{i}}} = " in shown
    assert "N_{z} = " in shown
    for step in (5, 6):
        assert sum(" = " in f and f.startswith("F") for f in page.math[f"step-{step}"]) >= len(eom.all_speeds)


def test_short_formulas_take_the_names_of_long_ones(page: Page) -> None:
    """F_4 of the sliding disk has 35 operations written out; the velocities in it have names beside it."""
    (shown,) = [f for f in page.math["step-5"] if f.startswith("F_{u_{4}} = ")]
    assert "Z_{" in shown
    assert "sqrt" not in shown


def test_formulas_are_read_by_two_angles() -> None:
    """f of a double pendulum in absolute angles as in textbooks."""
    shown = {f.name: f.text for f in chapters_of(kn.derive(double_pendulum.system()))[6].formulas}
    assert shown["f[u2]"] == "-m2*l2*(g*sin(q2) - l1*u1^2*sin(q1 - q2))/2"


def test_intermediates_are_defined_before_use(page: Page) -> None:
    for step in (5, 6):
        known: set[str] = set()
        for formula in page.math[f"step-{step}"]:
            left, equals, right = formula.partition(" = ")
            if equals:
                assert set(re.findall(r"Z_\{\d+\}", right)) <= known, formula
                known.add(left)


def test_velocities_print_as_the_article_has_them(page: Page) -> None:
    assert (
        r"{}^{N}\boldsymbol{\omega}^{C} = u_{1}\,\hat{b}_{x} + u_{2}\,\hat{b}_{y} + u_{3}\,\hat{b}_{z}"
        in page.math["step-4"]
    )


def test_checks_and_operations_show_their_figures(page: Page) -> None:
    _, eom = derived()
    assert ["first <of> two", "1.2e-15", "1e-10", "passed"] in page.rows
    assert ["second", "3.0e-02", "1e-06", "failed"] in page.rows
    o = eom.operations
    assert ["total", str(o.parameter), str(o.state), str(o.total)] in page.rows
    assert ["÷", "1", "8", str(dict(o.by_operation)["div"])] in page.rows
    at = page.rows.index(["result", "on its own", "added to those above"])
    assert sum(int(row[2]) for row in page.rows[at + 1 : at + 6]) == o.total
    assert page.rows[at + 6] == ["total", "", str(o.total)]


def test_parameters_show_default_and_value_used(page: Page) -> None:
    assert [r"\mu_{k}", "0.25", "0.1", "1", "coefficient of sliding friction"] in page.rows
    assert ["g", "9.81", "", "m/s²", "acceleration of free fall"] in page.rows


def test_reactions_show_their_extremes(page: Page) -> None:
    sol = moved()
    (force,) = sol.equations.reactions
    values = sol[force]
    wanted = [f"{x:.5g}" for k in (values.argmin(), values.argmax()) for x in (values[k], sol.t[k])]
    assert [latex_name(force.name), *wanted, "N"] in page.rows


def test_plots_follow_the_theme(page: Page, text: str) -> None:
    assert page.tags.count("svg") == 2 + 2 + text.count('<div class="plot" ')
    assert "currentColor" in text
    assert "var(--series-1)" in text
    assert not re.search(r"#0[12]0[23]0[0-9a-f]", text)


def test_the_sketch_stands_first_at_two_widths(page: Page, text: str) -> None:
    """Every coordinate is labelled in both, and one of them is shown at a time."""
    drawings = re.findall(r'<svg[^>]*class="kane-sketch" width="(\d+)".*?</svg>', text, re.DOTALL)
    assert drawings == ["640", "330"]
    for q in ("q1", "q2", "q3", "q4", "q5"):
        assert text.count(f'data-s="{q}"') == 2
    assert text.index('id="sketch"') < text.index('id="system"')
    assert ".sketch .narrow { display: none; }" in text


def test_text_is_escaped(text: str) -> None:
    assert "A &lt;disk&gt;" in text
    assert "first &lt;of&gt; two" in text
    assert "Somebody &amp; others" in text


@pytest.mark.slow
def test_is_the_same_each_time(tmp_path: Path) -> None:
    _, eom = derived()
    pages = [kn.report(eom, tmp_path / f"{i}.html", solution=moved()).read_bytes() for i in range(2)]
    assert pages[0] == pages[1]


def test_without_a_motion(tmp_path: Path) -> None:
    eom = kn.derive(chain(3))
    page = Page(kn.report(eom, str(tmp_path / "chain.html")).read_text(encoding="utf-8"))
    assert page.loads == []
    assert page.sections == ["sketch", "system", *(f"step-{i}" for i in range(1, 8)), "why", "operations"]


@pytest.mark.slow
def test_many_speeds_are_listed(tmp_path: Path) -> None:
    page = Page(kn.report(kn.derive(chain(11)), tmp_path / "chain.html").read_text(encoding="utf-8"))
    assert any(f.startswith("M_{u_{1}") for f in page.math["step-7"])


def test_a_motion_of_other_equations_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="Expected a solution of the equations reported"):
        kn.report(kn.derive(chain(1)), tmp_path / "x.html", solution=moved())
    assert not (tmp_path / "x.html").exists()


def test_terms_stand_with_load_place_and_partial_velocity(page: Page) -> None:
    labels = ("load", "on", "force or torque", "partial velocity", "term")
    cells = (
        "gravity",
        "C^{*}",
        r"-m g\,\hat{n}_{z}",
        r"{}^{N}\mathbf{v}^{C^{*}}_{u_{1}} = R\,\hat{b}_{z}",
        r"-m g R \sin q_{2}",
    )
    assert [" ".join(pair) for pair in zip(labels, cells, strict=True)] in page.rows
    entry = (r"entry M_{u_{1}\,u_{1}}", "body disk", "m R^{2}", r"\frac{m R^{2}}{4}")
    (found,) = [row for row in page.rows if row[:2] == list(entry[:2])]
    assert all(cell.endswith(end) for cell, end in zip(found[2:], entry[2:], strict=True))


@pytest.mark.slow
def test_dependent_speeds_and_auxiliary_ones_are_laid_out() -> None:
    eom = kn.derive(four_bar.system())
    step = chapters_of(eom)[3]
    every, own = step.tables
    assert [str(row[0]) for row in every.rows] == [str(Tex(latex_name(str(s)))) for s in shown_speeds(eom.derived)]
    assert [str(row[0]) for row in own.rows] == [str(Tex(latex_name(str(s)))) for s in eom.independent_speeds]
    mass, *_ = chapters_of(eom)[6].block.displays
    assert mass.latex.startswith(r"\tilde M \dot{u}_I = \tilde f")
    by_all = chapters_of(eom)[6].by_all_speeds
    assert [d.latex.startswith(r"M \dot{u} = f + A^{T} \lambda") for d in by_all.displays] == [True]
    assert not {f.name for f in by_all.formulas} & {f.name for f in chapters_of(eom)[6].block.formulas}
    shown = {f.name: f.text for f in step.formulas}
    assert [u.name for u in eom.dependent_speeds] == [name for name in shown if name.startswith("u")] == ["u1", "u3"]
    at = {"q": {"q1": 0.7, "q2": -0.3, "q3": 1.9}, "u": {"u2": 2.0}}
    items = dict(eom.steps[3].items)
    u1, u3 = eom.evaluate([items["u1"], items["u3"]], **at)
    residual = np.array(eom.evaluate(eom.A, **at)) @ [u1, 2.0, u3] + eom.evaluate(list(eom.b), **at)
    np.testing.assert_allclose(residual, 0.0, atol=1e-14)


def test_loads_without_a_share_are_named(text: str) -> None:
    assert "1 load contributes nothing: friction." in text
    assert "1 load contributes nothing: gravity." in text


def test_noncontributing_loads_are_named(tmp_path: Path) -> None:
    N = kn.Frame("N")
    x, u, m = kn.coordinate("x"), kn.speed("u"), kn.parameter("m", 1.0)
    P = kn.Point("O", fixed_in=N).at("P", x * N.x)
    loads = [kn.gravity(-9.81 * N.y), kn.Force(P, m * N.z, "side push"), kn.Force(P, m * N.x, "push")]
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("bead", P, m)], speeds={u: x.dt}, loads=loads))
    text = kn.report(eom, tmp_path / "bead.html").read_text(encoding="utf-8")
    assert "gravity, side push enter no generalized active force: noncontributing." in text


def test_a_motion_is_checked_without_being_asked(page: Page, text: str) -> None:
    names = [row[0] for row in page.rows if row[-1] in ("passed", "failed")]
    assert names[:2] == ["first <of> two", "second"]
    assert names[2:] == [c.name for c in motion_checks(moved())]
    assert "6 of 7 checks passed" in text


def test_provenance_is_left_out_where_there_are_too_many_speeds() -> None:
    assert [c.provenance for c in chapters_of(kn.derive(chain(11)))] == [None] * 7


def test_a_motion_through_another_choice_of_speeds_is_checked() -> None:
    """The equations of each sample are thinned with the samples."""
    eom = kn.derive(pure_rolling_disk.system())
    sol = kn.simulate(eom, (0, 5), **pure_rolling_disk.START)
    assert len(sol) > 101
    found = motion_checks(sol)
    assert all(c.passed for c in found), [str(c) for c in found]
    assert any("BᵀMB" in c.name for c in found)


def test_constraints_are_held_by_reactions_with_a_direction_and_a_formula() -> None:
    """Their auxiliary speeds move nothing, and have no row; their multipliers stand in step 7."""
    eom = kn.derive(pure_rolling_disk.system())
    rows = {str(s) for s in shown_speeds(eom.derived)}
    hidden = {str(s) for s in eom.all_speeds} - rows
    assert len(hidden) == 2
    for number, prefix in ((5, "F_"), (6, "F*_")):
        names = {name for name, _ in eom.steps[number - 1].items}
        assert {f"{prefix}{s}" for s in rows} | {f"~{prefix}{u.name}" for u in eom.independent_speeds} == names
    items = dict(eom.steps[6].items)
    state = {"q": {"q1": 0.3, "q2": 0.4, "q3": 0, "q4": 0, "q5": 0}, "u": {"u1": 0.5, "u2": -1.0, "u3": 6.0}}
    at = kn.assemble(eom, q=state["q"], u=state["u"])
    values = zip(eom.reactions, eom.evaluate(list(eom.reaction_values), q=at.q, u=at.u), strict=True)
    expected = {r.name: v for r, v in values}
    for name in ("F_x", "F_y"):
        assert eom.evaluate(items[name], q=at.q, u=at.u) == pytest.approx(expected[name], rel=1e-12)
    (table,) = [t for t in declared_tables(eom) if t.title.startswith("Reactions")]
    assert [str(row[2]) for row in table.rows] == [str(Tex(rf"\hat{{n}}_{{{a}}}")) for a in "zxy"]


def test_primes_in_names_are_no_dots(tmp_path) -> None:
    """x' and w' are names; dots stand for derivatives alone, in formulas, tables, notebooks and plots."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, w = kn.coordinate("x'"), kn.speed("w'")
    P = O.at("P'", x * N.x)
    push, hold = kn.Force(P, -w * N.x), kn.reaction("R'", at=P, along=N.y)
    bodies = [kn.Particle("A", P, 1.0)]
    eom = kn.derive(kn.System(N, bodies=bodies, speeds={w: 2 * x.dt}, loads=[push], reactions=[hold]))
    sol = kn.simulate(eom, (0, 1), q=[0], u=[1])
    page = Page(kn.report(eom, tmp_path / "r.html", solution=sol, why=False).read_text(encoding="utf-8"))
    formulas = [f for some in page.math.values() for f in some]
    shown: list[Any] = [eom.accelerations, eom.rates]
    formulas += [e._repr_html_() for e in (eom, eom.system)] + [e._repr_latex_() for e in shown]
    bare = [f for f in formulas if re.search(r"dot\{[xwR]\}(?!\^\{\\prime\})", f)]
    assert bare == []
    assert r"{\dot{w}^{\prime}}" in " ".join(formulas)
    assert r"x^{\prime}" in kn.plot(sol, x).axes[0].get_ylabel()


def test_a_report_lists_each_part(tmp_path):
    page = kn.report(DUMBBELL, tmp_path / "dumbbell.html").read_text()
    assert page.count("<td>dumb-bell</td>") >= 2
    for shown in (repr(DUMBBELL), DUMBBELL._repr_html_(), DUMBBELL.system._repr_html_()):
        assert "dumb-bell" in shown


def test_auxiliary_equations_are_spoken_of_where_there_are_reactions() -> None:
    with_reaction, without = derived()[1], kn.derive(pure_rolling_disk.system())
    for eom in (with_reaction, without):
        said = [chapters_of(eom)[6].text, eom.steps[6].text]
        assert all(("auxiliary equations give" in text) == bool(eom.reactions) for text in said)
        assert all(text.endswith(".") for text in said)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", ['a"b', "a&b", "a`b", "a'b", "a<b>", "a\\b", "a$b", "100%", "{a}", "a#b", "a^b", "a~b", "side w"]
)
def test_any_name_makes_a_page_that_is_whole(name: str, tmp_path: Path) -> None:
    """Of bodies, frames, points and loads; what stands in formulas is LaTeX in balance."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    q = kn.coordinate("q" if " " in name else name)
    A = N.rotate(name, q, N.z)
    P = O.at(name, A.x)
    body = kn.RigidBody(name, frame=A, mass_center=P, mass=1, inertia=kn.solid_sphere(A, 1, 1))
    system = kn.System(N, bodies=[body], speeds={kn.speed("u"): q.dt}, loads=[kn.Force(P, A.y, name=name)])
    eom = kn.derive(system)
    sol = kn.simulate(eom, (0, 1), q=[0.1], u=[0], samples=5)
    page = Page(kn.report(eom, tmp_path / "x.html", title=name, solution=sol).read_text(encoding="utf-8"))
    kn.plot(sol, q, path=tmp_path / "x.svg")
    assert len(page.identifiers) == len(set(page.identifiers))
    assert {r[1:] for r in page.references} <= set(page.identifiers)
    assert page.loads == []


def test_a_motion_with_contacts_lists_what_happens_on_the_way(tmp_path):
    """Time, event, what contacts do from then on, and energy: a rebound takes 1 − e² of the kinetic energy."""
    eom = kn.derive(bouncing_ball.system())
    sol = kn.simulate(eom, (0, 2), **bouncing_ball.START)
    text = kn.report(eom, tmp_path / "ball.html", solution=sol).read_text()
    rows = re.findall(r"<tr>(.*?)</tr>", text[text.index("Events during the motion") :].split("</table>")[0], re.S)
    cells = [re.findall(r"<td[^>]*>(.*?)</td>", row, re.S) for row in rows]
    told = [[re.sub(r"<[^>]+>", "", cell).strip() for cell in row] for row in cells if row]
    assert [row[0] for row in told] == [f"{t:.9g}" for t in sol.t[sol.begins]]
    for row, jump in zip(told, sol.jumps, strict=True):
        assert row[1] == jump.events[0].name
        assert float(row[3]) == pytest.approx(jump.energy, rel=1e-3)


def test_what_is_no_list_is_refused(tmp_path: Path) -> None:
    """A text is no list of sources: each letter would be one."""
    eom = kn.derive(chain(1))
    shape = kn.figures.shape("sphere", eom.system.bodies[0], radius=1)
    given: dict[str, Any] = {"sources": "Kane 1985", "checks": ["a"], "shapes": shape, "title": 3}
    for name, value in given.items():
        with pytest.raises(kn.KaneError, match=f"Expected {name}= as "):
            kn.report(eom, tmp_path / "a.md", **{name: value})
    assert not (tmp_path / "a.md").exists()


def test_a_motion_of_one_instant_has_a_report(tmp_path: Path) -> None:
    sol = moved().at(0.25)
    assert len(sol) == 1
    assert "t = 0.25" in kn.report(derived()[1], tmp_path / "a.md", solution=sol).read_text()
