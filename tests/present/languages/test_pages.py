# SPDX-License-Identifier: BSD-3-Clause
"""Reports in Korean beside those in English: the same numbers and formulas in the same order, and no English but what was given."""

import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest

import kane as kn
from kane.cli import model_of
from kane.gallery import GALLERY

SIX = ("pendulum", "rolling_disk", "four_bar", "skidding_disk", "whipple_bicycle", "flexible_arm")
"""Their reports have, together, every part."""
SAME = {"kane", "LaTeX"}
"""Words that are the same in Korean."""
FORMULAS = {"dE", "dK", "dV", "dt", "MB", "ms", "sin", "cos", "exp", "tanh", "if", "otherwise", "where"}
"""What formulas in the text of checks are made of, a unit of the page's own, and words within formulas of choices."""


class Shown(HTMLParser):
    """The texts of a page that are read, and the LaTeX of its formulas, in order."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.texts: list[str] = []
        self.formulas: list[str] = []
        self._open: list[str] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        told = dict(attrs)
        if tag not in ("meta", "input", "br", "link", "img", "use", "path"):
            self._open.append("math" if "math" in (told.get("class") or "").split() else tag)
        self.texts += [value for name in ("aria-label", "title") if (value := told.get(name))]

    def handle_endtag(self, tag: str) -> None:
        if self._open:
            self._open.pop()

    def handle_data(self, data: str) -> None:
        if not {"script", "style"} & set(self._open):
            (self.formulas if self._open and self._open[-1] == "math" else self.texts).append(data)

    @property
    def numbers(self) -> list[str]:
        return re.findall(r"\d+(?:\.\d+)?(?:e[-+]\d+)?", " ".join(self.texts))

    @property
    def plain_formulas(self) -> list[str]:
        """Formulas without the words in them."""
        return [re.sub(r"\\text\{[^}]*\}", "", f) for f in self.formulas]

    @property
    def words(self) -> set[str]:
        inside = [t for f in self.formulas for t in re.findall(r"\\text\{([^}]*)\}", f)]
        return set(re.findall(r"[A-Za-z]{2,}", " ".join([*self.texts, *inside])))


def given(eom: kn.Equations, title: str) -> set[str]:
    """The words of names, descriptions, messages and units that a report takes as they are."""
    system = eom.system
    named: tuple[Any, ...] = (
        *system.bodies,
        *eom.loads,
        *system.joints,
        *system.constraints,
        *system.events,
        *system.frames,
        *system.points,
    )
    symbols = (*eom.parameters, *eom.state, *eom.inputs, *eom.reactions, *eom.all_speeds)
    told = [title, *(x.name for x in named), *(f"{s.name} {s.description} {s.unit}" for s in symbols)]
    told += [e.message for e in system.events] + [c.name for c in system.contacts]
    return set(re.findall(r"[A-Za-z]{2,}", " ".join(filter(None, told))))


@pytest.mark.parametrize("name", [pytest.param(n, marks=() if n in SIX[:2] else pytest.mark.slow) for n in SIX])
def test_a_korean_report_says_what_the_english_one_says(name: str, tmp_path: Path) -> None:
    model = model_of(name)
    eom = kn.derive(model.system)
    sol = kn.simulate(eom, (0.0, 0.2), samples=21, **model.start)
    english, korean = _both(eom, tmp_path, solution=sol, shapes=model.shapes)
    assert korean.numbers == english.numbers
    assert korean.plain_formulas == english.plain_formulas
    shown = sol.samples[0] if eom.system.contacts else eom
    known = (
        given(shown, model.title)
        | SAME
        | FORMULAS
        | _words(sol.message if sol.status != "finished" else "")
        | _refused(shown)
    )
    assert korean.words - known == set()
    assert len(english.words - known) > 100


OFTEN = (
    "spherical_pendulum", "spinning_top", "gimbal_gyroscope", "slider_crank", "knife_edge", "pure_rolling_disk", "car_with_trailer",
    "muscle_arm", "rotating_beam", "bouncing_ball", "mass_on_belt", "clutch",
)  # fmt: skip
"""One of each kind; the others take their time, and are asked for with all pages."""


@pytest.mark.parametrize(
    "name",
    [pytest.param(n, marks=pytest.mark.slow if n in OFTEN else pytest.mark.page) for n in GALLERY if n not in SIX],
)
def test_a_korean_derivation_of_the_gallery(name: str, tmp_path: Path) -> None:
    model = model_of(name)
    eom = kn.derive(model.system)
    english, korean = _both(eom, tmp_path, shapes=model.shapes, why=False)
    assert korean.numbers == english.numbers
    assert korean.plain_formulas == english.plain_formulas
    known = given(eom, model.title) | SAME | FORMULAS
    assert korean.words - known == set()


def _both(eom: kn.Equations, folder: Path, **told: object) -> tuple[Shown, Shown]:
    paths = [kn.report(eom, folder / f"{name}.html", title="A", language=name, **told) for name in ("en", "ko")]  # type: ignore[arg-type]
    assert '<html lang="ko"' in paths[1].read_text(encoding="utf-8")
    english, korean = (Shown(p.read_text(encoding="utf-8")) for p in paths)
    return english, korean


def _words(text: str) -> set[str]:
    return set(re.findall(r"[A-Za-z]{2,}", text))


def _refused(eom: kn.Equations) -> set[str]:
    """The words of the error, if Lagrange's equations do not take the system."""
    try:
        eom.by("lagrange first kind")
    except kn.ModelError as error:
        return _words(str(error))
    return set()
