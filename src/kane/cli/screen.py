# SPDX-License-Identifier: BSD-3-Clause
"""What the commands write: lines, tables, JSON, files."""

import json
import math
import textwrap
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import typer

from kane.cli.faults import UNBROKEN, Misuse, columns, shown
from kane.expr.count import Operations
from kane.whole import exchange, refusal

_WIDEST = 10_000
"""Columns of a table that no terminal shows: its lines are read by programs."""


def say(text: str, **style: Any) -> None:
    """A sentence or two, in lines that fit the terminal."""
    typer.secho(shown(text), **style)


def heading(text: str) -> None:
    """A title above a table."""
    typer.echo(f"\n{typer.style(text, bold=True)}")


def table(rows: Sequence[Sequence[str]], indent: int = 2) -> None:
    """Rows in aligned columns; an empty column is left out, and a row that is wider than the terminal goes on in the next line."""
    filled = [c for c in zip(*rows, strict=True) if any(c)]
    widths = [max(map(len, c)) for c in filled]
    wide = columns(_WIDEST)
    hang = min(indent + sum(w + 2 for w in widths[:-1]), wide // 2)
    for row in zip(*filled, strict=True):
        cells = (f"{cell:{width}}" for cell, width in zip(row, widths, strict=True))
        line = " " * indent + "  ".join(cells).rstrip()
        typer.echo(
            line
            if len(line) <= wide
            else "\n".join(textwrap.wrap(line, wide, subsequent_indent=" " * hang, **UNBROKEN))
        )


def as_json(value: Any) -> None:
    """A value as JSON, what is not finite as null."""
    typer.echo(json.dumps(_plain(value), indent=2, ensure_ascii=False, allow_nan=False))


def operations(count: Operations) -> dict[str, Any]:
    """An operation count, ready for JSON."""
    tiers = {"total": count.total, "state": count.state, "parameter": count.parameter}
    return {**tiers, "by_operation": dict(count.by_operation)}


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    if isinstance(value, bool | str | int) or value is None:
        return value
    number = float(value)
    return number if math.isfinite(number) else None


def target(path: Path, source: Path | None, force: bool = False) -> Path:
    """Where a result may be written: Misuse over the model, over a file unless `force`, or where no file can be; folders are made."""
    if source is not None and path.resolve() == source.resolve():
        raise Misuse(f"Expected another file to write than the model's own, got {path}.")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise Misuse(f"Expected a file that can be written, got {path}: {error.strerror or error}.") from error
    if reason := refusal(path):
        raise Misuse(reason)
    if path.is_file() and not force:
        raise Misuse(f"Expected a new file, got {path}, which is there already. Choose another name, or add --force.")
    return path


def put(path: Path, content: str | Callable[[Path], object], force: bool) -> None:
    """Write a text, or let `content` write; over a file that came in the meantime only by `force`."""
    write = content if callable(content) else partial(Path.write_text, data=content, encoding="utf-8")
    exchange(path, write, None if force else lambda _: False, Misuse)


def write(path: Path, content: str | Callable[[Path], object], force: bool) -> None:
    """Write, and say where."""
    put(path, content, force)
    typer.echo(f"Written: {path}", err=True)
