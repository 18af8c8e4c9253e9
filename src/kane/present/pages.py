# SPDX-License-Identifier: BSD-3-Clause
"""What pages are made of: templates, texts beside them, data for scripts, and scripts that they carry deflated."""

import base64
import hashlib
import json
import re
import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any, cast

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from kane.present.languages.catalogue import language, plural, tr


@dataclass(frozen=True, slots=True)
class CarriedText:
    """A style and scripts as one text in a page, the script that begins them, and what a Content-Security-Policy calls them."""

    text: Markup
    loader: Markup
    hashes: Markup


@dataclass(frozen=True, slots=True)
class Document:
    """The text of a file, and what writes each file that lies beside it, by its name."""

    text: str
    beside: Mapping[str, Callable[[Path], object]] = field(default_factory=dict)


@cache
def asset(name: str, folder: str = "assets") -> str:
    """Text of a file in present/assets, or another folder of present."""
    return files("kane.present").joinpath(folder, name).read_text(encoding="utf-8")


@cache
def carried(style: str, *scripts: str) -> CarriedText:
    """What a page carries deflated, to a third of its size; `loader.js` inflates it. No other script may run."""
    loader = asset("loader.js", "templates")
    text = deflated(json.dumps([style, *scripts], ensure_ascii=False).encode())
    return CarriedText(Markup(text), Markup(loader), Markup(" ".join(map(_hash, (loader, *scripts)))))


def _hash(script: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(script.encode()).digest()).decode('ascii')}'"


def deflated(data: bytes) -> str:
    """Bytes as text: deflated, in base64."""
    return base64.b64encode(zlib.compress(data, 9)).decode("ascii")


def environment(**options: Any) -> Environment:
    """What fills the templates: what they insert is escaped for HTML, and what they lack is an error."""
    told: dict[str, Any] = {"autoescape": True, "undefined": StrictUndefined, **options}
    made: Any = Environment(loader=PackageLoader("kane.present"), extensions=["jinja2.ext.i18n"], **told)
    made.install_gettext_callables(tr, plural, newstyle=True)
    made.globals["language"] = language
    return cast(Environment, made)


def as_json(data: Any) -> str:
    """Text for a script element of type application/json."""
    return json.dumps(data, separators=(",", ":")).replace("<", "\\u003c")


def figure_text(x: float) -> str:
    """A figure of a check: three digits near one, else a power of ten."""
    return f"{x:.3g}" if 0.1 <= x < 1e4 else f"{x:.1e}"


def segments(text: str) -> list[tuple[bool, str]]:
    r"""Pieces of a sentence, LaTeX between dollar signs marked; `\$` is a dollar."""
    pieces = enumerate(re.split(r"(?<!\\)\$", text))
    return [(i % 2 == 1, piece if i % 2 else piece.replace(r"\$", "$")) for i, piece in pieces if piece]


def plain(text: str) -> str:
    """A text without LaTeX as a sentence for `segments`."""
    return text.replace("$", r"\$")
