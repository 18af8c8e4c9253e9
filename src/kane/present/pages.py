# SPDX-License-Identifier: BSD-3-Clause
"""What pages are made of: templates, texts beside them, data for scripts, and scripts that they carry deflated."""

import base64
import hashlib
import json
import zlib
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup


@dataclass(frozen=True, slots=True)
class Carried:
    """A style and scripts as one text in a page, the script that begins them, and what a Content-Security-Policy calls them."""

    text: Markup
    loader: Markup
    hashes: Markup


@cache
def asset(name: str, folder: str = "assets") -> str:
    """Text of a file in present/assets, or another folder of present."""
    return files("kane.present").joinpath(folder, name).read_text(encoding="utf-8")


@cache
def carried(style: str, *scripts: str) -> Carried:
    """What a page carries deflated, to a third of its size; `loader.js` inflates it. No other script may run."""
    loader = asset("loader.js", "templates")
    text = deflated(json.dumps([style, *scripts], ensure_ascii=False).encode())
    return Carried(Markup(text), Markup(loader), Markup(" ".join(map(_hash, (loader, *scripts)))))


def _hash(script: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(script.encode()).digest()).decode('ascii')}'"


def deflated(data: bytes) -> str:
    """Bytes as text: deflated, in base64."""
    return base64.b64encode(zlib.compress(data, 9)).decode("ascii")


def environment(**options: Any) -> Environment:
    """What fills the templates: what they insert is escaped, and what they lack is an error."""
    return Environment(loader=PackageLoader("kane.present"), autoescape=True, undefined=StrictUndefined, **options)


def as_json(data: Any) -> str:
    """Text for a script element of type application/json."""
    return json.dumps(data, separators=(",", ":")).replace("<", "\\u003c")
