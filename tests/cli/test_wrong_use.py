# SPDX-License-Identifier: BSD-3-Clause
"""What a new user does wrong: one style of answer, lines whole at any width, a cure in each; and what `kane` and `--help` say."""

from __future__ import annotations

import pytest

from tests.cli.command import kane, line

FILES = {
    "syntax.py": "def system(:\n    pass\n",
    "none.py": "x = 1\n",
    "key.py": "from kane.gallery.pendulum import system\nSTART = {'q': {'tetha': 1}}\n",
    "kind.py": "from kane.gallery.pendulum import system\nSTART = {'qq': {'theta': 1}}\n",
    "sources.py": "from kane.gallery.pendulum import system\nSOURCES = 'a book'\n",
    "there.csv": "",
}
WRONG = {
    "simulat pendulum": (2, "Did you mean simulate"),
    "simulate pendulm": (2, "Did you mean pendulum"),
    "simulate pendulum:other": (2, "pendulum is a system of the gallery"),
    "simulate pendulum --t2 3": (2, "Did you mean --t1"),
    "simulate pendulum --t1 soon": (2, "See `"),
    "simulate pendulum --q thta=1": (2, "Did you mean theta?"),
    "emit pendulum --target rst": (2, "Did you mean rust?"),
    "emit pendulum": (2, "c, h, numpy"),
    "check": (2, "`kane gallery` lists systems"),
    "cache inf": (2, "Did you mean info?"),
    "check missing.py": (2, "`kane new missing.py` writes one"),
    "check none.py": (1, "Define one that returns a kn.System"),
    "check key.py": (1, "Did you mean theta?"),
    "check kind.py": (1, "q, u, parameters"),
    "check sources.py": (1, "SOURCES in sources.py to be a list of texts, got 'a book'"),
    "simulate pendulum --csv there.csv": (2, "--force"),
    "simulate pendulum --csv there.csv/run.csv": (2, "there.csv"),
    "new model.txt": (2, "`kane new model.py`"),
    "new .": (2, "`kane new model.py`"),
    "simulate pendulum --t1 inf": (2, "got --t1 inf"),
    "emit pendulum --target fmu --out unit.zip": (2, "ends in .fmu, got unit.zip"),
}
"""The exit code, and words of the answer."""


@pytest.mark.parametrize("width", ["60", "100"])
def test_wrong_use_is_answered_with_a_cure(width, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", width)
    for name, text in FILES.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    for words, (code, cure) in WRONG.items():
        said = kane(*words.split(), code=code).stderr
        assert said.startswith("error: Expected "), words
        assert cure in line(said), (words, said)
        assert all(len(x) <= int(width) for x in said.splitlines()), said
        assert "\x1b" not in said
    assert "SyntaxError" in kane("check", "syntax.py", code=1).stderr


def test_alone_it_says_what_to_do_first():
    said = kane().stdout
    assert said.index("kane gallery") < said.index("kane new model.py") < said.index("kane --help")


@pytest.mark.parametrize("words", ["", "simulate", "emit", "sweep", "cache"])
def test_help_is_whole_and_has_examples(words, monkeypatch):
    monkeypatch.setenv("COLUMNS", "60")
    said = kane(*words.split(), "--help").stdout
    assert f"Examples\n  kane {words}".rstrip() in said
    assert all(len(x) <= 60 for x in said.splitlines())
    if not words:
        commands = (
            "gallery",
            "new",
            "convert",
            "demo",
            "check",
            "derive",
            "emit",
            "bench",
            "simulate",
            "sweep",
            "cache",
        )
        assert all(f"\n  {name} " in said for name in commands)
