# SPDX-License-Identifier: BSD-3-Clause
"""Output of the commands: lines, tables, JSON, files; and errors, as a few lines and an exit code, never as a traceback."""

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
"""Largest number of lines of a message."""
UNBROKEN: dict[str, Any] = {"break_long_words": False, "break_on_hyphens": False}
"""Options of line wrapping: at spaces only."""
_MODEL, _USAGE, _INTERRUPTED = 1, 2, 130


class Misuse(ArgumentError):
    """The command was called with unusable arguments."""


class UserError(Exception):
    """An error in the user's Python code; its text is the traceback through that code only."""


_UsageError: type[Any] = typer.BadParameter.__mro__[1]


def coloured() -> bool | None:
    """False if the environment disables colours (https://no-color.org); otherwise the terminal decides."""
    return False if os.environ.get("NO_COLOR") else None


def complain(kind: str, message: str) -> None:
    """Print an error or warning on stderr: a headline, and details below."""
    text = shown(f"{kind}: {message}")
    head = typer.style(f"{kind}:", bold=True, fg="red" if kind == "error" else "yellow")
    typer.echo(head + text.removeprefix(f"{kind}:"), err=True, color=coloured())


@contextmanager
def guarded() -> Iterator[None]:
    """Show errors and warnings of the code in the context; exit with 1 (model), 2 (usage) or 130 (Ctrl-C)."""
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
            path = error.ctx.command_path if error.ctx else "kane"
            complain("error", f"{_error_message(error, path)}\nSee `{path} --help`.")
            raise typer.Exit(_USAGE) from None
        except UserError as error:
            typer.echo(str(error), err=True)
            raise typer.Exit(_MODEL) from None
        except KaneError as error:
            complain("error", message_of(error))
            raise typer.Exit(_USAGE if isinstance(error, Misuse) else _MODEL) from None
        except OSError as error:
            if error.errno in (None, errno.EPIPE):  # the reader of a pipe has exited, which typer handles
                raise
            place = f" to {error.filename}" if error.filename else ""
            complain("error", f"Expected to write{place}, got {error.strerror}.")
            _leave_stdout()
            raise typer.Exit(_MODEL) from None
        except KeyboardInterrupt:
            typer.echo("Interrupted.", err=True)
            raise typer.Exit(_INTERRUPTED) from None


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
        return f"Expected a valid value of {called(param)}, got an invalid one. {told}{'.' * (told[-1:] not in '.?')}"
    return f"Expected arguments of `{path}`, got invalid ones: {told}{'.' * (told[-1:] not in '.?')}"


def called(param: Any) -> str:
    """The name of an argument or option as written by the user."""
    return str(param.opts[0] if param.param_type_name == "option" else param.metavar or param.name.upper())


def choices(param: Any) -> list[str]:
    """The values that an option may have, if they are a list."""
    kind = _annotation(param)
    members: Any = kind if isinstance(kind, EnumType) else getattr(getattr(param, "type", None), "choices", ())
    return [str(getattr(member, "value", member)) for member in members]


def kind_of(param: Any) -> str:
    """The name of the type of an option."""
    kind = _annotation(param)
    return "bool" if getattr(param, "is_flag", False) else str(getattr(kind, "__name__", getattr(kind, "name", "")))


def _annotation(param: Any) -> Any:
    """The type of an argument or option, whose location depends on the release of typer."""
    return getattr(getattr(param, "type_descriptor", None), "annotation", getattr(param, "type", None))


def _leave_stdout() -> None:
    """Flush stdout; if that fails, redirect it to the null device, so that the interpreter does not try again at exit."""
    with suppress(OSError, ValueError):
        sys.stdout.flush()
        return
    with suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def message_of(error: Exception) -> str:
    """The message of an error, with its notes on the line of the user's code."""
    return "\n".join([str(error), *getattr(error, "__notes__", ())])


def columns(most: int = WIDTH) -> int:
    """The width of the terminal, at most `most`, which is the default without a terminal."""
    return min(most, shutil.get_terminal_size((most, 0)).columns)


def shown(message: str, most: int = LINES) -> str:
    """The message in lines that fit a terminal, at most `most`, including the last one, which gives the location."""
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
    """Run code of the user's, in the model file `path`.

    A KaneError gets a note with the line where it arose or, outside the user's code, the line that calls or sets `about`; any other
    error in that code, including syntax errors and exits, becomes a UserError.
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
            pass  # wrong options of the command, or a line already noted
        elif about and (place := _line_of(about, path)) is not None:
            error.add_note(_location(path, *place))
        raise
    except SystemExit as error:
        text = (
            f"error: Expected {short(path)} to declare a model and run to its end, got a call of sys.exit(). Put everything "
            "except declarations under `if __name__ == '__main__':`."
        )
        raise UserError(shown(text)) from error
    except Exception as error:
        if isinstance(error, SyntaxError) or _theirs(traceback.extract_tb(error.__traceback__), path):
            raise UserError(_trimmed(traceback.TracebackException.from_exception(error), path)) from error
        raise


def warning_location(warning: warnings.WarningMessage, path: Path | None) -> str:
    """The line of the user's code where a warning arose; "" for other code."""
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
    """The path relative to the working folder, if it is inside it."""
    here, whole = Path.cwd(), Path(path).resolve()
    return str(whole.relative_to(here) if whole.is_relative_to(here) else whole)


def _theirs(frames: traceback.StackSummary, path: Path) -> traceback.StackSummary:
    """The frames of the user's code: outside of kane, Python and installed packages."""
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
    """The traceback through the user's frames, also for the errors from which it was raised."""
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
"""Width of output that is not a terminal, whose lines are read by programs."""


def say(text: str, **style: Any) -> None:
    """Print sentences in lines that fit the terminal."""
    typer.secho(shown(text), **style)


def heading(text: str) -> None:
    """Print a title above a table."""
    typer.echo(f"\n{typer.style(text, bold=True)}")


def table(rows: Sequence[Sequence[str]], indent: int = 2) -> None:
    """Print rows in aligned columns, without empty columns; rows wider than the terminal continue on the next line."""
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
    """Print a value as JSON, with null for numbers that are not finite."""
    typer.echo(json.dumps(_plain(value), indent=2, ensure_ascii=False, allow_nan=False))


def operations(count: Operations) -> dict[str, Any]:
    """An operation count as data for JSON."""
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
    """A path to write to, with folders made; raises Misuse for the model's file, an existing file without `force`, or a folder."""
    if source is not None and path.resolve() == source.resolve():
        raise Misuse(f"Expected an output file other than the model's own, got {path}.")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise Misuse(f"Expected a file that can be written, got {path}: {error.strerror or error}.") from error
    if reason := refusal(path):
        raise Misuse(reason)
    if path.is_file() and not force:
        raise Misuse(f"Expected a new file, got {path}, which already exists. Choose another name, or add --force.")
    return path


def ending(path: Path | None, endings: Collection[str], option: str = "--out") -> None:
    """Raise Misuse if a file to write has another ending."""
    if path is not None and path.suffix.lower() not in endings:
        raise Misuse(f"Expected {option} FILE that ends in {', '.join(endings)}, got {path}.")


def put(path: Path, content: str | Callable[[Path], object], force: bool) -> None:
    """Write a text, or let `content` write; a file created in the meantime is replaced only with `force`."""
    write = content if callable(content) else partial(Path.write_text, data=content, encoding="utf-8")
    exchange(path, write, None if force else lambda _: False, Misuse)


def write(path: Path, content: str | Callable[[Path], object], force: bool) -> None:
    """Write, and print the path."""
    put(path, content, force)
    typer.echo(f"Written: {path}", err=True)
