# SPDX-License-Identifier: BSD-3-Clause
"""What the commands write: lines, tables, JSON, files; and what goes wrong, in few lines and an exit code, never as a traceback."""

import ast
import errno
import json
import linecache
import math
import os
import re
import shutil
import sys
import sysconfig
import textwrap
import traceback
import warnings
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import contextmanager, suppress
from enum import EnumType
from functools import partial
from pathlib import Path
from typing import Any

import typer

from kane.errors import ArgumentError, KaneError, KaneWarning, alike
from kane.expr.evaluation import Operations
from kane.present.formula_list import WIDTH
from kane.whole import exchange, refusal

LINES = 15
"""At most as many lines of a message are shown."""
UNBROKEN: dict[str, Any] = {"break_long_words": False, "break_on_hyphens": False}
"""How lines are wrapped: at spaces alone."""
_MODEL, _USAGE, _INTERRUPTED = 1, 2, 130


class Misuse(ArgumentError):
    """The command was called with something it cannot use."""


class UserError(Exception):
    """An error of the user's own Python code; its text is the traceback through that code alone."""


_UsageError: type[Any] = typer.BadParameter.__mro__[1]


def coloured() -> bool | None:
    """False where the environment asks for none (https://no-color.org); else a terminal decides."""
    return False if os.environ.get("NO_COLOR") else None


def complain(kind: str, message: str) -> None:
    """An error or warning on stderr: a headline, and what belongs to it below."""
    text = shown(f"{kind}: {message}")
    head = typer.style(f"{kind}:", bold=True, fg="red" if kind == "error" else "yellow")
    typer.echo(head + text.removeprefix(f"{kind}:"), err=True, color=coloured())


@contextmanager
def guarded() -> Iterator[None]:
    """Show the errors and warnings of what runs inside; leave with 1 (the model), 2 (usage) or 130 (Ctrl-C)."""
    with warnings.catch_warnings():
        warnings.simplefilter("always", KaneWarning)
        plain = warnings.showwarning

        def show(message: Any, category: Any, *place: Any, **more: Any) -> None:
            if isinstance(message, KaneWarning):
                complain("warning", str(message))
            else:
                plain(message, category, *place, **more)

        warnings.showwarning = show
        try:
            yield
        except _UsageError as error:
            if type(error).__name__ == "NoArgsIsHelpError":
                typer.echo(error.ctx.get_help(), err=True, color=coloured())
                raise typer.Exit(_USAGE) from None
            complain("error", _misused(error))
            raise typer.Exit(_USAGE) from None
        except UserError as error:
            typer.echo(str(error), err=True)
            raise typer.Exit(_MODEL) from None
        except KaneError as error:
            complain("error", message_of(error))
            raise typer.Exit(_USAGE if isinstance(error, Misuse) else _MODEL) from None
        except OSError as error:
            if error.errno in (None, errno.EPIPE):  # who reads has gone: the command line knows what to do
                raise
            place = f" to {error.filename}" if error.filename else ""
            complain("error", f"Expected to write{place}, got {error.strerror}.")
            _leave_stdout()
            raise typer.Exit(_MODEL) from None
        except KeyboardInterrupt:
            typer.echo("Interrupted.", err=True)
            raise typer.Exit(_INTERRUPTED) from None


def _misused(error: Any) -> str:
    """What is wrong with the arguments of the command, and where they are explained."""
    path = error.ctx.command_path if error.ctx else "kane"
    return f"{_error_message(error, path)}\nSee `{path} --help`."


def _error_message(error: Any, path: str) -> str:
    command, param = getattr(error.ctx, "command", None), getattr(error, "param", None)
    strange = re.match(r"No such command '(.*?)'", str(error.message))
    if strange:
        known = list(getattr(command, "commands", ()))
        has = f" It has {', '.join(known)}."
        return f"Expected a command of `{path}`, got {strange[1]!r}.{alike(strange[1], known) or has}"
    if type(error).__name__ == "NoSuchOption":
        known = [name for p in getattr(command, "params", ()) for name in p.opts if name.startswith("--")]
        return (
            f"Expected an option of `{path}`, got {error.option_name!r}.{alike(error.option_name, [*known, '--help'])}"
        )
    known = choices(param)
    among = f" as one of {', '.join(known)}" if known else ""
    if type(error).__name__ == "MissingParameter" and param is not None:
        cure = " `kane gallery` lists systems; `kane new model.py` writes a file." if called(param) == "MODEL" else ""
        return f"Expected {called(param)}{among}, got none.{cure}"
    wrong = re.search(r"'([^']*)' is not one of", str(error.message))
    if known and wrong:
        return f"Expected {called(param)}{among}, got {wrong[1]!r}.{alike(wrong[1], known)}"
    told = str(error.message) if param is not None else error.format_message()
    if param is not None:
        return f"Expected a value that {called(param)} can have, got another. {told}{'.' * (told[-1:] not in '.?')}"
    return f"Expected arguments that `{path}` takes, got others: {told}{'.' * (told[-1:] not in '.?')}"


def called(param: Any) -> str:
    """How an argument or option is written."""
    return str(param.opts[0] if param.param_type_name == "option" else param.metavar or param.name.upper())


def choices(param: Any) -> list[str]:
    """The values that an option may have, where they are a list."""
    kind = _annotation(param)
    members: Any = kind if isinstance(kind, EnumType) else getattr(getattr(param, "type", None), "choices", ())
    return [str(getattr(member, "value", member)) for member in members]


def kind_of(param: Any) -> str:
    """The name of the type that an option takes."""
    kind = _annotation(param)
    return "bool" if getattr(param, "is_flag", False) else str(getattr(kind, "__name__", getattr(kind, "name", "")))


def _annotation(param: Any) -> Any:
    """The type of an argument or option: releases of typer keep it in different places."""
    return getattr(getattr(param, "type_descriptor", None), "annotation", getattr(param, "type", None))


def _leave_stdout() -> None:
    """What could not be written is not tried again at exit."""
    with suppress(OSError, ValueError):
        sys.stdout.flush()
        return
    with suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def message_of(error: Exception) -> str:
    """The error's message, and in which line of the user's code it arose."""
    return "\n".join([str(error), *getattr(error, "__notes__", ())])


def columns(most: int = WIDTH) -> int:
    """How wide the terminal is, at most; `most` where there is none."""
    return min(most, shutil.get_terminal_size((most, 0)).columns)


def shown(message: str, most: int = LINES) -> str:
    """The message in lines that fit a terminal, `most` at most; the last line, which says where, is kept."""
    lines = [line for part in message.splitlines() for line in prose(part)]
    if len(lines) <= most:
        return "\n".join(lines)
    return "\n".join([*lines[: most - 2], f"  … ({len(lines) - most + 1} more lines)", lines[-1]])


def prose(text: str) -> list[str]:
    """Lines that fit the terminal, broken at spaces; the first keeps its indent."""
    indent = text[: len(text) - len(text.lstrip())]
    return textwrap.wrap(
        text.strip(), columns(), initial_indent=indent, subsequent_indent=f"{indent}  ", **UNBROKEN
    ) or [""]  # fmt: skip


@contextmanager
def user_code(path: Path | None, about: str = "") -> Iterator[None]:
    """Run code that may be the user's, of the model file `path`.

    A KaneError gets a note of the line it arose in, or, where that is none of the user's, of the line that calls or sets `about`; any
    other error becomes a UserError, one of syntax and an exit too, unless it is none of that code's.
    """
    if path is None:
        yield
        return
    try:
        yield
    except KaneError as error:
        frames = _theirs(traceback.extract_tb(error.__traceback__), path)
        if frames:
            error.add_note(_location(frames[-1].filename, frames[-1].lineno, frames[-1].line))
        elif isinstance(error, Misuse) or hasattr(error, "__notes__"):
            pass  # the command's options are wrong, or a line is named already
        elif about and (place := _line_of(about, path)) is not None:
            error.add_note(_location(path, *place))
        raise
    except SystemExit as error:
        text = (
            f"error: Expected {short(path)} to declare a model and come to its end, got a call of sys.exit() in it. Put what is "
            "not declaration under `if __name__ == '__main__':`."
        )
        raise UserError(shown(text)) from error
    except Exception as error:
        if isinstance(error, SyntaxError) or _theirs(traceback.extract_tb(error.__traceback__), path):
            raise UserError(_trimmed(traceback.TracebackException.from_exception(error), path)) from error
        raise


def warning_location(warning: warnings.WarningMessage, path: Path | None) -> str:
    """Where in the user's code a warning arose; empty where it did elsewhere."""
    if path is None or not _is_theirs(warning.filename, path):
        return ""
    return _location(warning.filename, warning.lineno, linecache.getline(warning.filename, warning.lineno))


def _location(file: str | Path, line: int | None, text: str | None) -> str:
    where = f"in {short(file)}, line {line}: "
    room = max(columns() - len(where) - 4, 20)
    code = (text or "").strip()
    return where + (code if len(code) <= room else f"{code[: room - 1]}…")


def _line_of(name: str, path: Path) -> tuple[int, str] | None:
    """Number and text of the last line of the file that calls or sets `name`."""
    try:
        text = path.read_text(encoding="utf-8")
        lines = [
            n.lineno for n in ast.walk(ast.parse(text)) if isinstance(n, ast.Call | ast.Assign) and _names(n, name)
        ]
    except (OSError, ValueError, SyntaxError):
        return None
    return (max(lines), text.splitlines()[max(lines) - 1]) if lines else None


def _names(node: ast.Call | ast.Assign, name: str) -> bool:
    parts = [node.func] if isinstance(node, ast.Call) else node.targets
    return any(name in (getattr(p, "attr", ""), getattr(p, "id", "")) for p in parts)


def short(path: str | Path) -> str:
    """The path as seen from the working folder, where it lies in it."""
    here, whole = Path.cwd(), Path(path).resolve()
    return str(whole.relative_to(here) if whole.is_relative_to(here) else whole)


def _theirs(frames: traceback.StackSummary, path: Path) -> traceback.StackSummary:
    """The frames of the user's code: neither in kane, nor in Python, nor in an installed package."""
    return traceback.StackSummary.from_list([f for f in frames if _is_theirs(f.filename, path)])


def _is_theirs(name: str, path: Path) -> bool:
    if name.startswith("<"):
        return False
    file = Path(name).resolve()
    return file == path.resolve() or not any(file.is_relative_to(folder) for folder in _FOREIGN)


_FOREIGN = (
    Path(__file__).resolve().parents[1],
    *(Path(p).resolve() for n in ("stdlib", "platstdlib", "purelib", "platlib") if (p := sysconfig.get_path(n))),
)


def _trimmed(report: traceback.TracebackException, path: Path) -> str:
    """The traceback through the user's frames; of what it was raised from, the part that is theirs."""
    at: traceback.TracebackException | None = report
    while at is not None:
        at.stack = _theirs(at.stack, path)
        for name in ("__cause__", "__context__"):
            before = getattr(at, name)
            if before is not None and not _theirs(before.stack, path):
                setattr(at, name, None)
        at = at.__cause__ or (None if at.__suppress_context__ else at.__context__)
    lines = report.format() if report.stack else report.format_exception_only()
    return "".join(lines).rstrip()


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
    for line in rows_of(rows, indent):
        typer.echo(line)


def rows_of(rows: Sequence[Sequence[str]], indent: int = 2) -> list[str]:
    """The lines of a table."""
    filled = [c for c in zip(*rows, strict=True) if any(c)]
    widths = [max(map(len, c)) for c in filled]
    wide = columns(_WIDEST)
    hang = min(indent + sum(w + 2 for w in widths[:-1]), wide // 2)
    lines: list[str] = []
    for row in zip(*filled, strict=True):
        cells = (f"{cell:{width}}" for cell, width in zip(row, widths, strict=True))
        line = " " * indent + "  ".join(cells).rstrip()
        fits = len(line) <= wide
        lines += [line] if fits else textwrap.wrap(line, wide, subsequent_indent=" " * hang, **UNBROKEN)
    return lines


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


def ending(path: Path | None, endings: Collection[str], option: str = "--out") -> None:
    """Misuse where a file to write ends in something else."""
    if path is not None and path.suffix.lower() not in endings:
        raise Misuse(f"Expected {option} FILE that ends in {', '.join(endings)}, got {path}.")


def put(path: Path, content: str | Callable[[Path], object], force: bool) -> None:
    """Write a text, or let `content` write; over a file that came in the meantime only by `force`."""
    write = content if callable(content) else partial(Path.write_text, data=content, encoding="utf-8")
    exchange(path, write, None if force else lambda _: False, Misuse)


def write(path: Path, content: str | Callable[[Path], object], force: bool) -> None:
    """Write, and say where."""
    put(path, content, force)
    typer.echo(f"Written: {path}", err=True)
