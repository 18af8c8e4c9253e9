# SPDX-License-Identifier: BSD-3-Clause
"""The fixed texts of a report in its language, with the rules of gettext: English texts are keys, values are written `%(name)s`.

A catalogue is a TOML file named after the language; missing texts stay English. `tr` and `trn` translate a text in place, `N_` marks
one to be translated later; templates use `_()` and `{% trans %}`. The language is a context variable, set by `spoken`, so that threads
can use different ones: an argument would pass through a hundred functions.
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
"""English is the language of the sources."""


class Catalogue(NullTranslations):
    """The texts of a language by their English; plural forms are not distinguished, and the singular is the key."""

    def __init__(self, language: str) -> None:
        super().__init__()
        self.language = language
        place = files("kane.present.languages").joinpath(f"{language}.toml")
        self.texts: dict[str, str] = tomllib.loads(place.read_text("utf-8"))

    def gettext(self, message: str) -> str:
        """The text in this language."""
        return self.texts.get(message, message)

    def ngettext(self, msgid1: str, msgid2: str, n: int) -> str:
        """The text for a count in this language."""
        return self.texts.get(msgid1) or super().ngettext(msgid1, msgid2, n)


_catalogue = cache(Catalogue)
_spoken: ContextVar[NullTranslations] = ContextVar("spoken", default=NullTranslations())  # noqa: B039 - it holds nothing


def checked(language: str) -> str:
    """The language; raises ArgumentError if there is no catalogue for it."""
    if language not in LANGUAGES:
        known = ", ".join(map(repr, LANGUAGES))
        raise ArgumentError(
            f"Expected language= as one of {known}, got {cut(repr(language))}.{alike(str(language), LANGUAGES)}"
        )
    return language


@contextmanager
def spoken(language: str) -> Iterator[None]:
    """Set the language of texts within the context."""
    token = _spoken.set(NullTranslations() if checked(language) == "en" else _catalogue(language))
    try:
        yield
    finally:
        _spoken.reset(token)


def language() -> str:
    """The current language."""
    return getattr(_spoken.get(), "language", "en")


def tr(text: str, /, **values: Any) -> str:
    """The text in the current language, with its values."""
    said = _spoken.get().gettext(text)
    return said % values if values else said


def plural(one: str, many: str, n: int) -> str:
    """The text for `n` items in the current language, without its values."""
    return _spoken.get().ngettext(one, many, n)


def trn(one: str, many: str, n: int, /, **values: Any) -> str:
    """The text for `n` items in the current language, with its values, including `n`."""
    return plural(one, many, n) % {"n": n, **values}


def N_(text: str) -> str:
    """The English text, marked for a later call of `tr`."""
    return text
