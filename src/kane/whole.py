# SPDX-License-Identifier: BSD-3-Clause
"""Files that are written whole: beside their name, to the disk, and then renamed.

At no time does a name stand for a part of a file. What is no ordinary file (a link, a folder, a pipe, a device) is never replaced, and
reading one is never waited for.
"""

import contextlib
import os
import stat
from collections.abc import Callable
from pathlib import Path
from typing import Any, BinaryIO

from kane.errors import ArgumentError, cut

Own = Callable[[Path], bool]

_KINDS = ((stat.S_ISLNK, "link"), (stat.S_ISDIR, "folder"), (stat.S_ISFIFO, "pipe"), (stat.S_ISSOCK, "socket"))
_READ = os.O_RDONLY | getattr(os, "O_BINARY", 0) | getattr(os, "O_NONBLOCK", 0)  # a pipe is not waited for


def path_of(given: Any, call: str) -> Path:
    """A path as users give it; `call` shows how."""
    if not isinstance(given, str | os.PathLike) or not isinstance(text := os.fspath(given), str) or "\0" in text:
        raise ArgumentError(f"Expected the path of a file, a text or a Path, got {cut(repr(given))}. Write {call}.")
    return Path(text)


def refusal(path: Path, own: Own | None = None) -> str:
    """Why no file may be written at a path, as sentences, or "".

    An ordinary file is replaced if it is empty or `own` knows it; without `own`, always.
    """
    if not path.parent.is_dir():
        return f"Expected a folder that exists, got {path.parent} in {path}. Create it first."
    if not os.access(path.parent, os.W_OK):
        return f"Expected a folder with write permission, got {path.parent} in {path}. Choose another one."
    try:
        status = path.lstat()
    except FileNotFoundError:
        return ""
    if not stat.S_ISREG(status.st_mode):
        return f"Expected a file to write, got the {_kind(status)} {path}, which is not replaced. {_ELSE}"
    if not status.st_mode & stat.S_IWUSR:
        return f"Expected a file with write permission, got {path}, which is write-protected. {_ELSE}"
    if own is not None and status.st_size and not own(path):
        return f"Expected a new path, or a file of this kind written by kane, got {path} with other contents. {_ELSE}"
    return ""


_ELSE = "Choose another name, or remove it first."


def exchange(
    path: Path, write: Callable[[Path], Any], own: Own | None = None, error: type[Exception] = ArgumentError
) -> None:
    """Let `write` fill a new file, and give it the name `path`; `error` says why it may not have it.

    A process that dies on the way leaves what was there, and perhaps a file .kane-….part beside it.
    """
    path = path.absolute()
    if reason := refusal(path):
        raise error(reason)
    fresh = path.with_name(f".kane-{os.urandom(8).hex()}.part{path.suffix}")
    fresh.open("xb").close()
    try:
        write(fresh)
        with contextlib.suppress(FileNotFoundError):
            fresh.chmod(stat.S_IMODE(path.stat().st_mode))
        to_disk(fresh)
        if reason := refusal(path, own):
            raise error(reason)
        os.replace(fresh, path)
    except BaseException:
        fresh.unlink(missing_ok=True)
        raise
    to_disk(path.parent)


FIGURES = (b"Software\0kane", b"<dc:title>kane</dc:title>", b"/Creator (kane)")
"""By what figures as PNG, SVG and PDF are known."""


def exchange_marked(path: Path, write: Callable[[Path], Any], *marks: bytes) -> None:
    """`exchange` where a file that bears one of the marks, an empty one, or none may be replaced; missing folders are made."""
    path.parent.mkdir(parents=True, exist_ok=True)
    exchange(path, write, lambda p: any(mark in p.read_bytes() for mark in marks))


def opened(path: Path) -> BinaryIO:
    """An ordinary file to read, links followed; an OSError says what else it is."""
    handle = os.open(path, _READ)
    status = os.fstat(handle)
    if not stat.S_ISREG(status.st_mode):
        os.close(handle)
        raise OSError(f"it is a {_kind(status)}")
    return open(handle, "rb")


def _kind(status: os.stat_result) -> str:
    return next((name for holds, name in _KINDS if holds(status.st_mode)), "device")


def to_disk(path: Path) -> None:
    """What was written of a file, or of the names in a folder, stays if the machine stops."""
    with contextlib.suppress(OSError):  # some systems open no folder, some file systems flush none
        handle = os.open(path, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)
