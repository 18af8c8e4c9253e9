# SPDX-License-Identifier: BSD-3-Clause
"""The gallery's page and the pictures of the tutorials are what `docs/make_figures.py` makes now."""

from __future__ import annotations

import re
from importlib.util import module_from_spec, spec_from_file_location

import pytest
from PIL import Image

from kane.gallery import GALLERY
from tests.docs.snippets import ROOT

DOCS = ROOT / "docs"
PAGE = (DOCS / "gallery.md").read_text(encoding="utf-8")
_SHOWN = re.compile(r"_static/(?:sketches|tutorial|motions)/\w+\.(?:svg|webp)")


@pytest.fixture(scope="module")
def figures():
    spec = spec_from_file_location("make_figures", DOCS / "make_figures.py")
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_page_is_what_is_made_now(figures):
    """Titles and sentences are those of the modules; none is left out and none is there twice."""
    assert figures.gallery_page() == PAGE
    assert sorted(re.findall(r"`kane report (\w+)`", PAGE)) == sorted(GALLERY)


def test_each_tutorial_shows_its_sketch_and_leads_to_the_next(figures):
    for name, following in zip(figures.TUTORIALS, (*figures.TUTORIALS[1:], None), strict=True):
        text = (DOCS / "tutorial" / f"{name}.md").read_text(encoding="utf-8")
        assert f"(../_static/sketches/tutorial_{name}.svg)" in text, name
        assert following is None or f"({following}.md)" in text.splitlines()[-1], name


def test_pictures_are_there_and_no_others():
    """A picture that no page shows is left from before, one that is not there would be a hole."""
    shown = {
        found
        for page in DOCS.rglob("*.md")
        if "_build" not in page.parts
        for found in _SHOWN.findall(page.read_text("utf-8"))
    }
    there = {
        f"_static/{folder}/{p.name}"
        for folder in ("sketches", "tutorial", "motions")
        for p in (DOCS / "_static" / folder).iterdir()
    }
    assert shown == there


def test_each_system_moves_in_a_small_picture():
    """A page of all of them is read over a slow line, too."""
    for name in GALLERY:
        place = DOCS / "_static" / "motions" / f"{name}.webp"
        assert place.stat().st_size <= 60_000, name
        with Image.open(place) as moving, Image.open(place.with_stem(f"{name}_still")) as still:
            assert moving.n_frames > 20, name
            assert still.n_frames == 1, name
            assert moving.size == still.size, name


def test_small_pictures_are_drawn(figures, tmp_path, monkeypatch):
    monkeypatch.setattr(figures.moving, "_COUNT", 3)
    figures.moving.card("pendulum", tmp_path)
    with Image.open(tmp_path / "pendulum.webp") as moving, Image.open(tmp_path / "pendulum_still.webp") as still:
        assert moving.n_frames > 1
        assert moving.size == still.size == figures.moving.CARD
