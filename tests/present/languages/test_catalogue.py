# SPDX-License-Identifier: BSD-3-Clause
"""The catalogue of each language: nothing missing, nothing idle, values and formulas as in English; what refuses a language."""

import re
import tomllib
from pathlib import Path

import pytest

import kane as kn
from kane.cli import model_of
from kane.gallery import load
from kane.present import LANGUAGES, meaning, spoken, tr
from tests.present.languages.marked import PRESENT, in_python, in_templates

VALUE = re.compile(r"%\(\w+\)s|\$[^$]*\$")
OTHERS = [name for name in LANGUAGES if name != "en"]


@pytest.fixture(scope="module")
def texts() -> set[str]:
    """All that is marked, and what the seven steps are called."""
    steps = kn.derive(model_of("pendulum").system).steps
    return {*in_python(), *in_templates(), *(s.title for s in steps), *(s.text for s in steps[:2])}


@pytest.mark.parametrize("language", OTHERS)
def test_a_catalogue_has_every_text_with_its_values(language: str, texts: set[str]) -> None:
    own = tomllib.loads((PRESENT / "languages" / f"{language}.toml").read_text(encoding="utf-8"))
    assert texts - own.keys() == set()
    assert own.keys() - texts == set()
    assert {t: own[t] for t in own if VALUE.findall(t) != VALUE.findall(own[t]) and t != "%(n)s %(what)s"} == {
        t: own[t] for t in own if "%(what)s" in t and t != "%(n)s %(what)s"
    }
    assert [t for t in own if "%" in VALUE.sub("", t + own[t])] == []
    assert [t for t in own if not own[t].strip()] == []


def test_no_text_of_a_page_is_left_unmarked() -> None:
    """What stands in a template is code, or taken from the catalogue."""
    for path in PRESENT.rglob("templates/*.html"):
        text = re.sub(
            r"\{#.*?#\}|\{% trans.*?endtrans %\}|\{[{%].*?[%}]\}|<style>.*?</style>",
            "",
            path.read_text("utf-8"),
            flags=re.DOTALL,
        )
        shown = [re.sub(r"<[^>]*>", " ", text), *re.findall(r'(?:aria-label|title|alt)="([^"]*)"', text)]
        assert re.findall(r"[A-Za-z]{2,}", " ".join(shown)) == [], path.name


def test_a_language_holds_within_its_block_alone() -> None:
    with spoken("ko"):
        assert tr("Checks") == "검사"
        with spoken("en"):
            assert tr("Checks") == "Checks"
        assert tr("inertia of %(body)s", body="A") == "A의 관성"
    assert tr("Checks") == "Checks"


def test_what_is_no_language_or_not_in_latex_is_refused(tmp_path: Path) -> None:
    eom = kn.derive(model_of("pendulum").system)
    with pytest.raises(kn.ArgumentError, match="Expected language= as one of 'en', 'ko', got 'kr'"):
        kn.report(eom, tmp_path / "a.html", language="kr")
    with pytest.raises(kn.ArgumentError, match='Expected language="en" for LaTeX'):
        kn.report(eom, tmp_path / "a.tex", language="ko")
    assert list(tmp_path.iterdir()) == []


def test_what_parameters_of_contacts_mean() -> None:
    """Their descriptions are the program's, those of others the user's."""
    law = load("mass_on_belt").system().contacts[0]
    with spoken("ko"):
        assert meaning(law.direction[0]) == "미끄럼의 방향: belt"
        assert all(not meaning(s).isascii() for s in (law.slowest, law.slack))
        assert meaning(kn.parameter("m", 1.0, "kg", "mass")) == "mass"
    assert meaning(law.direction[0]) == law.direction[0].description
