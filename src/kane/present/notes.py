# SPDX-License-Identifier: BSD-3-Clause
"""The author's notes in a report: Markdown with formulas between dollar signs, and figures.

HTML in the text is shown as text, and images are accepted as files or figures only, so that a page contains only intended content
and loads nothing. Pictures are in `<img>`, where scripts do not run.
"""

import base64
import io
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from markupsafe import Markup, escape

from kane.errors import ArgumentError, cut

if TYPE_CHECKING:
    from markdown_it import MarkdownIt

_KINDS = {".svg": "image/svg+xml", ".png": "image/png"}
_BEGINS = {".svg": (b"<svg", b"<?xml", b"<!--", b"<!DOCTYPE svg"), ".png": (b"\x89PNG\r\n\x1a\n",)}
_WANTED = 'notes= as a list of Markdown, figures of matplotlib and Paths of .svg or .png files: notes=["# Result", Path("a.svg")]'


@dataclass(frozen=True, slots=True)
class Image:
    """A picture read from a file: its name, ending and bytes."""

    name: str
    ending: str
    data: bytes


def checked(notes: Iterable[Any]) -> tuple[Any, ...]:
    """The notes: Markdown and figures unchanged, an Image for a Path.

    Raises
    ------
    ArgumentError
        if a note is something else, or a file is not a readable picture
    """
    if isinstance(notes, str | Path) or not isinstance(notes, Iterable):
        raise ArgumentError(f"Expected {_WANTED}, got {cut(repr(notes))}.")
    return tuple(map(_checked, notes))


def _checked(note: Any) -> Any:
    if isinstance(note, Path):
        return Image(note.stem, note.suffix.lower(), _read(note))
    if not isinstance(note, str) and not (hasattr(note, "savefig") and hasattr(note, "axes")):
        raise ArgumentError(f"Expected {_WANTED}, got {cut(repr(note))} in it.")
    return note


def written(note: Any) -> Markup:
    """The HTML of a note."""
    if isinstance(note, str):
        return Markup(parser().render(note))
    if isinstance(note, Image):
        return _image(note.data, note.ending, note.name)
    return _image(_drawn(note), ".svg", title_of(note))


def title_of(figure: Any) -> str:
    """The title of a matplotlib figure, or of its first titled axes."""
    titles = (a.get_title() for a in figure.axes)
    return str(figure.get_suptitle() or next(filter(None, titles), "figure"))


def _image(data: bytes, ending: str, told: str) -> Markup:
    source = f"data:{_KINDS[ending]};base64,{base64.b64encode(data).decode('ascii')}"
    return Markup(f'<figure><img alt="{escape(told)}" src="{source}"></figure>\n')


def _read(path: Path) -> bytes:
    """The bytes of a picture; raises ArgumentError unless their beginning agrees with the file's ending."""
    ending = path.suffix.lower()
    if ending not in _KINDS:
        raise ArgumentError(f"Expected a picture that ends in {', '.join(_KINDS)}, got {cut(str(path))!r} in notes=.")
    try:
        data = path.read_bytes()
    except OSError as error:
        raise ArgumentError(
            f"Expected a picture that can be read, got {cut(str(path))!r} in notes=: {error.strerror}."
        ) from None
    if not data.lstrip(b"\xef\xbb\xbf \r\n\t").startswith(_BEGINS[ending]):
        raise ArgumentError(
            f"Expected a picture in {cut(str(path))!r} of notes=, got something else: {cut(repr(data[:12]))}."
        )
    return data


def _drawn(figure: Any) -> bytes:
    """A figure as reproducible SVG."""
    import matplotlib

    out = io.BytesIO()
    with matplotlib.rc_context({"svg.hashsalt": "kane"}):
        figure.savefig(out, format="svg", metadata={"Date": None})
    return out.getvalue()


# Markdown --------------------------------------------------------------------------------------------------------------


@cache
def parser() -> "MarkdownIt":
    """The Markdown parser of notes."""
    from markdown_it import MarkdownIt

    made = MarkdownIt("commonmark", {"html": False}).enable("table").disable("image")
    made.inline.ruler.before("escape", "math", _math)
    made.core.ruler.push("lower", _lower)
    made.add_render_rule("math", lambda _, tokens, k, *__: _formula(tokens[k]))
    return made


def _formula(token: Any) -> str:
    return f'<span class="math{" display" if token.markup == "$$" else ""}">{escape(token.content)}</span>'


def _lower(state: Any) -> None:
    """Lower headings below that of the section."""
    for token in state.tokens:
        if token.type.startswith("heading"):
            token.tag = f"h{min(int(token.tag[1]) + 2, 6)}"


def _math(state: Any, silent: bool) -> bool:
    """Formulas $…$ or $$…$$; prices, as in $5 and $6, and escaped dollar signs are text."""
    for mark in ("$$", "$"):
        if state.src.startswith(mark, state.pos):
            found = next(_ends(state.src, state.pos + len(mark), mark), None)
            if found is None:
                continue
            if not silent:
                token = state.push("math", "span", 0)
                token.content, token.markup = state.src[state.pos + len(mark) : found].strip(), mark
            state.pos = found + len(mark)
            return True
    return False


def _ends(text: str, begin: int, mark: str) -> Iterator[int]:
    """Positions at which a formula that begins there may end."""
    if mark == "$" and text[begin : begin + 1].isspace():
        return
    at = text.find(mark, begin)
    while at > begin:
        before, after = text[at - 1], text[at + len(mark) : at + len(mark) + 1]
        if before != "\\" and (mark == "$$" or not (before.isspace() or after.isdigit())):
            yield at
        at = text.find(mark, at + 1)
