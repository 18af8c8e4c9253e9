# SPDX-License-Identifier: BSD-3-Clause
"""What goes wrong, as the command shows it: few lines and an exit code, never a traceback through `kane`."""

from __future__ import annotations

import sysconfig
import traceback
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import typer
from typer.core import TyperGroup

from kane.errors import ArgumentError, KaneError, KaneWarning
from kane.present.wrap import wrapped

LINES = 15
"""At most as many lines of a message are shown."""
_MODEL, _USAGE, _INTERRUPTED = 1, 2, 130


class Misuse(ArgumentError):
    """The command was called with something it cannot use."""


class UserError(Exception):
    """An error of the user's own Python code; its text is the traceback through that code alone."""


class Guarded(TyperGroup):
    """Commands whose errors are shown by `guarded`."""

    def invoke(self, ctx: Any) -> Any:
        """Run the command that was asked for."""
        with guarded():
            return super().invoke(ctx)


@contextmanager
def guarded() -> Iterator[None]:
    """Show the errors and warnings of what runs inside; leave with 1 (the model), 2 (usage) or 130 (Ctrl-C)."""
    with warnings.catch_warnings():
        warnings.simplefilter("always", KaneWarning)
        plain = warnings.showwarning

        def show(message: Any, category: Any, *place: Any, **more: Any) -> None:
            if isinstance(message, KaneWarning):
                typer.echo(shown(f"warning: {message}"), err=True)
            else:
                plain(message, category, *place, **more)

        warnings.showwarning = show
        try:
            yield
        except UserError as error:
            typer.echo(str(error), err=True)
            raise typer.Exit(_MODEL) from None
        except KaneError as error:
            typer.echo(shown(f"error: {message_of(error)}"), err=True)
            raise typer.Exit(_USAGE if isinstance(error, Misuse) else _MODEL) from None
        except KeyboardInterrupt:
            typer.echo("Interrupted.", err=True)
            raise typer.Exit(_INTERRUPTED) from None


def message_of(error: Exception) -> str:
    """The error's message, and in which line of the user's code it arose."""
    return "\n".join([str(error), *getattr(error, "__notes__", ())])


def shown(message: str, most: int = LINES) -> str:
    """The message in lines that fit a terminal, `most` at most; the last line, which says where, is kept."""
    lines = [line for part in message.splitlines() for line in wrapped(part, hang=2)]
    if len(lines) <= most:
        return "\n".join(lines)
    return "\n".join([*lines[: most - 2], f"  … ({len(lines) - most + 1} more lines)", lines[-1]])


@contextmanager
def own_code(path: Path | None) -> Iterator[None]:
    """Run code that may be the user's, of the model file `path`.

    A KaneError gets a note of the line it arose in; any other error becomes a UserError, unless it is none of that code's.

    Raises
    ------
    UserError
        if the user's code raises an error, cannot be parsed, or leaves Python
    """
    if path is None:
        yield
        return
    try:
        yield
    except KaneError as error:
        frames = _theirs(traceback.extract_tb(error.__traceback__), path)
        if frames:
            error.add_note(f"in {short(frames[-1].filename)}, line {frames[-1].lineno}: {frames[-1].line}")
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


def _trimmed(found: traceback.TracebackException, path: Path) -> str:
    """The traceback through the user's frames; of what it was raised from, the part that is theirs."""
    at: traceback.TracebackException | None = found
    while at is not None:
        at.stack = _theirs(at.stack, path)
        for name in ("__cause__", "__context__"):
            before = getattr(at, name)
            if before is not None and not _theirs(before.stack, path):
                setattr(at, name, None)
        at = at.__cause__ or (None if at.__suppress_context__ else at.__context__)
    lines = found.format() if found.stack else found.format_exception_only()
    return "".join(lines).rstrip()
