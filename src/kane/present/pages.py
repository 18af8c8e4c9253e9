# SPDX-License-Identifier: BSD-3-Clause
"""What pages are made of: templates, texts beside them, and data for scripts."""

import json
from functools import cache
from importlib.resources import files
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined


@cache
def asset(name: str, folder: str = "assets") -> str:
    """Text of a file in present/assets, or another folder of present."""
    return files("kane.present").joinpath(folder, name).read_text(encoding="utf-8")


def environment(**options: Any) -> Environment:
    """What fills the templates: what they insert is escaped, and what they lack is an error."""
    return Environment(loader=PackageLoader("kane.present"), autoescape=True, undefined=StrictUndefined, **options)


def as_json(data: Any) -> str:
    """Text for a script element of type application/json."""
    return json.dumps(data, separators=(",", ":")).replace("<", "\\u003c")
