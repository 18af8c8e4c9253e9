# SPDX-License-Identifier: BSD-3-Clause
"""The fixed texts of a report in its language, by the rules of gettext: the English text is the key, values stand as `%(name)s`.

A catalogue is a TOML file named after the language; what it lacks stays English. `tr` and `trn` mark texts that are taken where they
stand, `N_` those that are taken later; in templates `_()` and `{% trans %}` do. The language holds within `spoken`, for what is called
there alone: it is no argument of the hundred functions that make a report, and two threads may write in two languages.
"""

import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache
from gettext import NullTranslations
from importlib.resources import files
from typing import Any

from kane.errors import ArgumentError, alike, cut

LANGUAGES = ("en", "ko")
"""English is that of the sources."""


class Catalogue(NullTranslations):
    """The texts of a language by their English; a count chooses no form of its own, the key is the text of one."""

    def __init__(self, language: str) -> None:
        super().__init__()
        self.language = language
        place = files("kane.present.languages").joinpath(f"{language}.toml")
        self.texts: dict[str, str] = tomllib.loads(place.read_text("utf-8"))

    def gettext(self, message: str) -> str:
        """The text in this language."""
        return self.texts.get(message, message)

    def ngettext(self, msgid1: str, msgid2: str, n: int) -> str:
        """The text of a count in this language."""
        return self.texts.get(msgid1) or super().ngettext(msgid1, msgid2, n)


_catalogue = cache(Catalogue)
_spoken: ContextVar[NullTranslations] = ContextVar("spoken", default=NullTranslations())  # noqa: B039 - it holds nothing


def checked(language: str) -> str:
    """The language, if there is a catalogue of it."""
    if language not in LANGUAGES:
        known = ", ".join(map(repr, LANGUAGES))
        raise ArgumentError(
            f"Expected language= as one of {known}, got {cut(repr(language))}.{alike(str(language), LANGUAGES)}"
        )
    return language


@contextmanager
def spoken(language: str) -> Iterator[None]:
    """What is written within is in this language."""
    token = _spoken.set(NullTranslations() if checked(language) == "en" else _catalogue(language))
    try:
        yield
    finally:
        _spoken.reset(token)


def language() -> str:
    """The language that holds here."""
    return getattr(_spoken.get(), "language", "en")


def tr(text: str, /, **values: Any) -> str:
    """The text in the language that holds, with its values."""
    said = _spoken.get().gettext(text)
    return said % values if values else said


def plural(one: str, many: str, n: int) -> str:
    """The text of `n` things in the language that holds, without its values."""
    return _spoken.get().ngettext(one, many, n)


def trn(one: str, many: str, n: int, /, **values: Any) -> str:
    """The text of `n` things in the language that holds, with its values, of which `n` is one."""
    return plural(one, many, n) % {"n": n, **values}


def N_(text: str) -> str:
    """The English text, which `tr` is given later."""
    return text
