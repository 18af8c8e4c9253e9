# SPDX-License-Identifier: BSD-3-Clause
"""XML from untrusted sources, parsed in bounded time and memory to elements with line numbers.

Entities are refused, no other file is opened, and size, depth and number of elements are limited before elements are built.
"""

import math
import stat
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from xml.sax import SAXException
from xml.sax.handler import ContentHandler

import numpy as np

from kane import expect
from kane.errors import ModelError, cut, none_of
from kane.numeric.arrays import Array

BYTES = 32 * 2**20
DEPTH = 300
ELEMENTS = 200_000
LARGEST = 1e60
"""The largest number accepted for a length, a mass, …; products of larger ones could overflow."""
WORD = 4096
"""The maximum length of an attribute that is read, usually a name or a few numbers; others may be longer."""


@dataclass(slots=True, eq=False)
class Element:
    """An element, its line in the text and its source."""

    tag: str
    attributes: Mapping[str, str]
    line: int
    source: str
    children: list["Element"] = field(default_factory=list)

    @property
    def where(self) -> str:
        """The file and line."""
        return f"{self.source}, line {self.line}"

    def all(self, tag: str) -> list["Element"]:
        """The children with a tag."""
        return [c for c in self.children if c.tag == tag]

    def one(self, tag: str) -> "Element | None":
        """The child with a tag, or None; raises if there are several."""
        found = self.all(tag)
        if len(found) > 1:
            raise self.wrong(f"one <{tag}> in <{self.tag}>", f"another one in line {found[1].line}")
        return found[0] if found else None

    def walk(self) -> Iterator["Element"]:
        """The element and all its descendants."""
        stack = [self]
        while stack:
            yield (here := stack.pop())
            stack += reversed(here.children)

    def wrong(self, expected: str, got: str, cure: str = "") -> ModelError:
        """An error about this element."""
        return expect.refusal(ModelError, expected, f"{got} ({self.where})", cure)

    def text(self, name: str) -> str:
        """A required attribute."""
        value = self.attributes.get(name)
        if not value or len(value) > WORD:
            raise self.wrong(f"an attribute {name}= of <{self.tag}>", cut(repr(value)) if value else "none")
        return value

    def number(self, name: str, default: float | None = None, *, infinite: bool = False) -> float:
        """An attribute that is a number, at most `LARGEST` unless `infinite`."""
        return float(self.numbers(name, 1, None if default is None else (default,), infinite=infinite)[0])

    def numbers(self, name: str, count: int, default: Any = None, *, infinite: bool = False) -> Array:
        """An attribute that is `count` numbers."""
        if name not in self.attributes and default is not None:
            return np.array(default, dtype=float)
        words = self.text(name).split()
        values = [number_of(w) for w in words[: count + 1]]
        right = (v is not None and (infinite or abs(v) <= LARGEST) and not math.isnan(v) for v in values)
        if len(values) != count or not all(right):
            what = "a number" if count == 1 else f"{count} numbers"
            raise self.wrong(f"{what} as {name}= of <{self.tag}>", cut(repr(self.attributes[name])))
        return np.array(values, dtype=float)

    def refuse_others(self, *known: str) -> None:
        """Raises if a child has another tag."""
        for child in self.children:
            if child.tag not in known:
                raise ModelError(
                    f"Expected in <{self.tag}> one of {none_of(sorted(known), child.tag)} It stands in {child.where}."
                )


def number_of(word: str) -> float | None:
    """A number in XML syntax, without Python's underscores and digits of other scripts; else None."""
    if not word.isascii() or "_" in word:
        return None
    try:
        return float(word)
    except ValueError:
        return None


class _ElementBuilder(ContentHandler):
    """Builds the elements from the parser's events, within the limits."""

    def __init__(self, source: str) -> None:
        super().__init__()
        self.source = source
        self.open: list[Element] = []
        self.root: Element | None = None
        self.count = 0
        self.place: Any = None

    def startElement(self, name: str, attrs: Any) -> None:
        """Opens an element."""
        here = Element(name, dict(attrs.items()), self.place.getLineNumber(), self.source)
        self.count += 1
        if len(self.open) >= DEPTH or self.count > ELEMENTS:
            raise here.wrong(f"at most {DEPTH} levels and {ELEMENTS} elements", "more")
        if self.open:
            self.open[-1].children.append(here)
        else:
            self.root = here
        self.open.append(here)

    def endElement(self, name: str) -> None:
        """Closes the innermost element."""
        self.open.pop()


def given(source: Any, kind: str) -> tuple[str | bytes, str, Path | None]:
    """The text, its name and its file: `source` itself if it begins like XML, else the content of the file that it names."""
    expected = f"the path of a {kind} file, or its text"
    expect.instance(source, (str, bytes, Path), expected)
    if isinstance(source, bytes) or (isinstance(source, str) and source.lstrip("\ufeff \t\r\n").startswith("<")):
        _limited(len(source), kind)
        return source, kind, None
    try:
        path = Path(source)
        info = path.stat()
    except (OSError, ValueError) as error:
        raise expect.refusal(ModelError, expected, cut(repr(str(source)), 120), "There is no such file.") from error
    expect.that(stat.S_ISREG(info.st_mode), expected, came=f"{cut(repr(str(path)), 120)}, which is no file")
    _limited(info.st_size, kind)
    return path.read_bytes(), path.name, path


def _limited(size: int, kind: str) -> None:
    expect.that(size <= BYTES, f"a {kind} text of at most {BYTES} bytes", came=f"one of {size}")


def parsed(text: str | bytes, source: str) -> Element:
    """The root element of the text.

    Raises
    ------
    ModelError
        if it is not well formed, contains entities, or exceeds the limits
    """
    lacking = ModelError("Expected the package defusedxml to read XML. Install it: pip install 'kane[models]'.")
    reader, common = (expect.package(f"defusedxml.{part}", lacking) for part in ("expatreader", "common"))
    builder = _ElementBuilder(source)
    parser = reader.DefusedExpatParser(forbid_entities=True, forbid_external=True)  # without namespaces: many lack them
    parser.setContentHandler(builder)
    builder.place = parser
    try:
        parser.feed(text)
        parser.close()
    except SAXException as error:
        raise ModelError(f"Expected well-formed XML, got {cut(error, 120)} ({source}).") from error
    except common.DefusedXmlException as error:
        cure = "Replace them by the text that they stand for."
        raise expect.refusal(ModelError, "XML without entities", f"{cut(error, 120)} ({source})", cure) from error
    except (LookupError, UnicodeError, ValueError) as error:
        if isinstance(error, ModelError):
            raise
        raise ModelError(f"Expected XML in an encoding that it declares, got {cut(error, 120)} ({source}).") from error
    if builder.root is None:
        raise ModelError(f"Expected an XML element, got none ({source}).")
    return builder.root
