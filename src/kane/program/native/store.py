# SPDX-License-Identifier: BSD-3-Clause
"""The on-disk cache of object code.

An entry is one file: a line of JSON (format, key, size, SHA-256 of the object) and the object's bytes. Code is run only if folder and
file belong to this user, nobody else can write to them, and the digest is right; otherwise a warning is issued, and the code is
compiled again. Entries are written by an atomic rename; when their total size exceeds `LIMIT`, the least recently used are removed.
The limit may be exceeded by what processes write between two scans of the folder.

The environment variable KANE_CACHE names the folder; "off" disables the cache.
"""

import contextlib
import hashlib
import json
import os
import stat
import tempfile
import time
from pathlib import Path

from kane.errors import warn

LIMIT = 256 * 2**20
"""The maximum total size of entries in bytes."""

_FORMAT = "kane object 1"
_SUFFIX = ".kaneobj"
_PART = _SUFFIX + ".part"
_READ = os.O_RDONLY | getattr(os, "O_BINARY", 0) | getattr(os, "O_NONBLOCK", 0)  # do not block on a pipe of that name
_ABANDONED = 3600.0
"""Age in seconds from which a partial file is attributed to a process that died."""
_UNSEEN = 1 / 64
"""The fraction of `LIMIT` that a process writes before it scans the folder again; a scan of thousands of entries takes longer than the
compilation of a small system."""
_ROOM = 1 / 16
"""The fraction of `LIMIT` that removal frees, so that the next entries need no removal."""
_seen: dict[Path, tuple[int, int]] = {}
"""By folder, the total size at this process's last scan, and the bytes that it has written since."""


def key(*parts: str) -> str:
    """SHA-256 of everything on which the object depends."""
    digest = hashlib.sha256()
    for part in parts:
        data = part.encode()
        digest.update(len(data).to_bytes(8) + data)
    return digest.hexdigest()


def folder() -> Path | None:
    """The cache's folder, or None if the cache is disabled."""
    setting = os.environ.get("KANE_CACHE", "")
    if setting.lower() in ("off", "0", "no"):
        return None
    if setting:
        return Path(os.path.expanduser(setting)).absolute()
    from platformdirs import user_cache_path

    try:
        place = user_cache_path("kane", appauthor=False) / "objects"
    except RuntimeError:  # platformdirs did not determine a home folder
        place = Path("~")
    if not place.is_absolute():  # a relative path would be a different folder for each working directory
        warn(f"Expected a home folder of this user for the cache, got none: nothing is cached. {_CURE}")
        return None
    return place


def read(name: str) -> bytes | None:
    """The object of a key, or None if there is none or it is not trusted."""
    place = _trusted(make=False)
    if place is None:
        return None
    path = place / (name + _SUFFIX)
    try:
        with open(os.open(path, _READ), "rb") as file:
            status = os.fstat(file.fileno())  # of the open file, because the path may have been replaced
            ordinary = stat.S_ISREG(status.st_mode)
            head, _, image = file.read().partition(b"\n") if ordinary else (b"", b"", b"")
    except FileNotFoundError:
        return None
    except OSError as error:
        warn(f"Expected to read the cache entry {path}, got {error.strerror or error}. Compiling anew.")
        return None
    if not ordinary:
        warn(f"Expected a file as cache entry, got something else at {path}. Compiling anew and replacing it.")
        return None
    if not _private(status):
        warn(f"Expected a cache entry that {_PRIVATE}, got {path} ({_owner(status)}). Compiling anew and replacing it.")
        return None
    if head != _head(name, image):
        warn(f"Expected an intact cache entry, got a damaged one: {path}. Compiling anew and replacing it.")
        return None
    with contextlib.suppress(OSError):
        os.utime(path)  # marks it as recently used
    return image


def write(name: str, image: bytes) -> None:
    """Stores an object; warns if the folder cannot be written."""
    place = _trusted(make=True)
    if place is None:
        return
    try:
        handle, temporary = tempfile.mkstemp(dir=place, suffix=_PART)
        try:
            with os.fdopen(handle, "wb") as file:
                written = file.write(_head(name, image) + b"\n" + image)
            os.replace(temporary, place / (name + _SUFFIX))
        except BaseException:
            with contextlib.suppress(OSError):
                os.unlink(temporary)
            raise
        _shrink(place, written)
    except OSError as error:
        warn(f"Expected to write to the cache folder {place}, got {error.strerror or error}. {_CURE}")


def size() -> tuple[int, int]:
    """The number of entries and their total size in bytes."""
    place = folder()
    entries = _files(place, _SUFFIX) if place is not None else []
    return len(entries), sum(length for _, length, _ in entries)


def clear() -> tuple[int, int]:
    """Removes all entries; returns their number and total size in bytes."""
    place = folder()
    if place is None:
        return 0, 0
    _sweep(place)
    gone = []
    for _, length, path in _files(place, _SUFFIX):
        try:
            path.unlink(missing_ok=True)
            gone.append(length)
        except OSError as error:
            warn(f"Expected to remove the cache entry {path}, got {error.strerror or error}.")
    return len(gone), sum(gone)


def _head(name: str, image: bytes) -> bytes:
    digest = hashlib.sha256(image).hexdigest()
    return json.dumps({"format": _FORMAT, "key": name, "sha256": digest, "bytes": len(image)}).encode()


def _trusted(make: bool) -> Path | None:
    """The folder, if only this user can write to it; creates it if it is absent and `make` is true."""
    place = folder()
    if place is None:
        return None
    try:
        if make:
            place.mkdir(mode=0o700, parents=True, exist_ok=True)
        status = place.stat()
    except OSError as error:
        if isinstance(error, FileNotFoundError) and not make:
            return None
        warn(f"Expected to use the cache folder {place}, got {error.strerror or error}. {_CURE}")
        return None
    if not stat.S_ISDIR(status.st_mode):
        warn(f"Expected a folder for the cache, got something else at {place}. {_CURE}")
        return None
    if not _private(status):
        warn(f"Expected a cache folder that {_PRIVATE}, got {place} ({_owner(status)}): it is not used. {_CURE}")
        return None
    return place


_CURE = "Set KANE_CACHE to a folder of your own, or to off."
_PRIVATE = "belongs to this user and that nobody else can write to"


def _private(status: os.stat_result) -> bool:
    """Whether it belongs to the effective user of this process, and nobody else can write to it."""
    if not hasattr(os, "geteuid"):  # without user ids, the user's folder is trusted
        return True
    return status.st_uid == os.geteuid() and not status.st_mode & (stat.S_IWGRP | stat.S_IWOTH)


def _owner(status: os.stat_result) -> str:
    return f"owner {status.st_uid}, mode {stat.S_IMODE(status.st_mode):o}"


def _files(place: Path, suffix: str) -> list[tuple[float, int, Path]]:
    """(last use, size in bytes, path) of each file with a suffix."""
    status = []
    with contextlib.suppress(OSError), os.scandir(place) as entries:
        for entry in entries:
            if not entry.name.endswith(suffix):
                continue
            with contextlib.suppress(OSError):  # another process may have removed it
                info = entry.stat(follow_symlinks=False)
                if stat.S_ISREG(info.st_mode):
                    status.append((info.st_mtime, info.st_size, place / entry.name))
    return status


def _shrink(place: Path, written: int) -> None:
    """Keeps the cache within `LIMIT` after a write; most writes need no scan of the folder."""
    total, since = _seen.get(place, (LIMIT, 0))
    since += written
    _seen[place] = total, since
    if total + since <= LIMIT and since <= _UNSEEN * LIMIT:
        return
    _sweep(place)
    entries = sorted(_files(place, _SUFFIX), key=lambda e: e[0])
    total = sum(size for _, size, _ in entries)
    if total > LIMIT:
        for _, size, path in entries:
            if total <= (1 - _ROOM) * LIMIT:
                break
            with contextlib.suppress(OSError):
                path.unlink(missing_ok=True)
                total -= size
    _seen[place] = total, 0


def _sweep(place: Path) -> None:
    """Removes partial files of processes that died while writing."""
    for last, _, path in _files(place, _PART):
        if time.time() - last > _ABANDONED:
            with contextlib.suppress(OSError):
                path.unlink(missing_ok=True)
