# SPDX-License-Identifier: BSD-3-Clause
"""Parts of HTML pages: templates, texts of assets, data for scripts, and deflated scripts."""

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
    """Style and scripts of a page as one deflated text, the script that loads it, and their hashes for the Content-Security-Policy."""

    text: Markup
    loader: Markup
    hashes: Markup


@dataclass(frozen=True, slots=True)
class Document:
    """The text of a file, and functions that write the files beside it, by name."""

    text: str
    beside: Mapping[str, Callable[[Path], object]] = field(default_factory=dict)


@cache
def asset(name: str, folder: str = "assets") -> str:
    """The text of a file in present/assets, or in another folder of present."""
    return files("kane.present").joinpath(folder, name).read_text(encoding="utf-8")


@cache
def carried(style: str, *scripts: str) -> CarriedText:
    """Style and scripts deflated to a third of their size; `loader.js` inflates them. The policy allows no other script."""
    loader = asset("loader.js", "templates")
    text = deflated(json.dumps([style, *scripts], ensure_ascii=False).encode())
    return CarriedText(Markup(text), Markup(loader), Markup(" ".join(map(_hash, (loader, *scripts)))))


def _hash(script: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(script.encode()).digest()).decode('ascii')}'"


def deflated(data: bytes) -> str:
    """Bytes deflated and encoded in base64."""
    return base64.b64encode(zlib.compress(data, 9)).decode("ascii")


def environment(**options: Any) -> Environment:
    """The environment of the templates, which escapes values for HTML and raises an error for missing ones."""
    told: dict[str, Any] = {"autoescape": True, "undefined": StrictUndefined, **options}
    made: Any = Environment(loader=PackageLoader("kane.present"), extensions=["jinja2.ext.i18n"], **told)
    made.install_gettext_callables(tr, plural, newstyle=True)
    made.globals["language"] = language
    return cast(Environment, made)


def as_json(data: Any) -> str:
    """Data as text for a script element of type application/json."""
    return json.dumps(data, separators=(",", ":")).replace("<", "\\u003c")


def figure_text(x: float) -> str:
    """The figure of a check: three digits near one, otherwise in scientific notation."""
    return f"{x:.3g}" if 0.1 <= x < 1e4 else f"{x:.1e}"


def segments(text: str) -> list[tuple[bool, str]]:
    r"""Pieces of a sentence, with LaTeX between dollar signs marked; `\$` is a dollar sign."""
    pieces = enumerate(re.split(r"(?<!\\)\$", text))
    return [(i % 2 == 1, piece if i % 2 else piece.replace(r"\$", "$")) for i, piece in pieces if piece]


def plain(text: str) -> str:
    """Text without LaTeX, escaped as a sentence for `segments`."""
    return text.replace("$", r"\$")
