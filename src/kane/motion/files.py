# SPDX-License-Identifier: BSD-3-Clause
"""Files of arrays with a header: written beside their place and then renamed, so that a name never stands for a part of a file.

The header is text of JSON and says, among other things, the SHA-256 of all arrays: what is cut off, or was changed, is not read.
Nothing in a file is executed.
"""

import hashlib
import json
import os
import shutil
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path
from tempfile import mkdtemp
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from kane.errors import SolutionFileError

FORMAT, VERSION = "kane solution", 1
_HEADER = "header"

Anything = npt.NDArray[Any]


class Contents(NamedTuple):
    """What a file holds."""

    header: dict[str, Any]
    arrays: dict[str, Anything]


class Container(NamedTuple):
    """A kind of file: what writes a text and arrays at a path, what reads them."""

    write: Callable[[Path, str, Mapping[str, Anything]], None]
    read: Callable[[Path], tuple[str, dict[str, Anything]]]


def write(path: Any, contents: Contents) -> None:
    """Write a file, or put it in the place of one.

    Raises
    ------
    SolutionFileError
        if its name has another ending than those of `CONTAINERS`, or there is no such folder
    """
    target = Path(path).absolute()
    container = _container(target)
    if not target.parent.is_dir():
        raise SolutionFileError(f"Expected a folder that there is, got {target.parent} in {target}. Make it first.")
    header = {"format": FORMAT, "version": VERSION, "sha256": _sum(contents.arrays), **contents.header}
    beside = Path(mkdtemp(prefix=f".{target.name}.", dir=target.parent))
    try:
        fresh = beside / target.name
        container.write(fresh, json.dumps(header), contents.arrays)
        _flush(fresh)
        if target.is_dir():
            os.replace(target, beside / "old")  # a folder takes the place of none that holds something
        os.replace(fresh, target)
        _flush(target.parent)
    finally:
        shutil.rmtree(beside, ignore_errors=True)


def read(path: Any) -> Contents:
    """The contents of a file.

    Raises
    ------
    SolutionFileError
        if there is none, it is cut off or damaged, no file of this kind, or of another version
    """
    place = Path(path)
    container = _container(place)
    if not place.exists():
        raise SolutionFileError(f"Expected a file with a solution, got none at {place}. Write one by sol.save(path).")
    try:
        text, arrays = container.read(place)
        header = json.loads(text)
        own = isinstance(header, dict) and header.get("format") == FORMAT
    except (ImportError, SolutionFileError):
        raise
    except Exception as error:  # what damage there is has as many names as there are libraries below
        raise SolutionFileError(
            f"Expected a file with a solution, got one that cannot be read, {place}: it is cut off, damaged or something else "
            f"({type(error).__name__}: {error}). Write it again by sol.save(path)."
        ) from error
    if not own:
        raise SolutionFileError(f"Expected a file with a solution, got {place} with something else in it.")
    if header.get("version") != VERSION:
        raise SolutionFileError(
            f"Expected a file with a solution of version {VERSION}, got version {header.get('version')!r}, written by kane "
            f"{header.get('kane')}: {place}. Read it by that version of kane, or simulate again."
        )
    if header.get("sha256") != _sum(arrays):
        raise SolutionFileError(
            f"Expected a file with a solution whose arrays are as they were written, got {place}, which was changed or is cut off. "
            "Take a copy of it, or simulate again."
        )
    return Contents(header, arrays)


def _container(path: Path) -> Container:
    found = CONTAINERS.get(path.suffix)
    if found is None:
        raise SolutionFileError(
            f"Expected a file name that ends in {' or '.join(CONTAINERS)}, got {path.name!r}. The ending says how it is written."
        )
    return found


def _sum(arrays: Mapping[str, Anything]) -> str:
    """SHA-256 of names, types, shapes and numbers."""
    total = hashlib.sha256()
    for name in sorted(arrays):
        array = np.ascontiguousarray(arrays[name])
        total.update(f"{name} {array.dtype.str} {array.shape} ".encode())
        total.update(array.tobytes())
    return total.hexdigest()


def _flush(path: Path) -> None:
    """To the disk, so that a name is not there before what it stands for."""
    for file in [path, *path.rglob("*")] if path.is_dir() and path.suffix in CONTAINERS else [path]:
        try:
            handle = os.open(file, os.O_RDONLY)
        except OSError:  # a folder, on systems that open none
            continue
        try:
            os.fsync(handle)
        except OSError:
            pass
        finally:
            os.close(handle)


def _write_npz(path: Path, text: str, arrays: Mapping[str, Anything]) -> None:
    with path.open("wb") as file:
        own: dict[str, Any] = {**arrays, _HEADER: np.frombuffer(text.encode(), dtype=np.uint8)}
        np.savez_compressed(file, **own)


def _read_npz(path: Path) -> tuple[str, dict[str, Anything]]:
    if not zipfile.is_zipfile(path):
        raise ValueError("it has no table of contents")
    with path.open("rb") as handle, np.load(handle, allow_pickle=False) as file:
        arrays = {name: file[name] for name in file.files}
    return arrays.pop(_HEADER).tobytes().decode(), arrays


def _zarr() -> Any:
    try:
        import zarr
    except ImportError as error:
        raise ImportError(
            "Expected the package zarr for files that end in .zarr, got none. Install it, pip install 'kane[table]', or take a "
            "name that ends in .npz."
        ) from error
    return zarr


def _write_zarr(path: Path, text: str, arrays: Mapping[str, Anything]) -> None:
    group = _zarr().open_group(str(path), mode="w", attributes={_HEADER: text})
    for name, array in arrays.items():
        group.create_array(name, data=np.ascontiguousarray(array))


def _read_zarr(path: Path) -> tuple[str, dict[str, Anything]]:
    group = _zarr().open_group(str(path), mode="r")
    arrays = {name: np.asarray(array[...]) for name, array in group.arrays()}
    return str(group.attrs[_HEADER]), arrays


CONTAINERS: Mapping[str, Container] = {
    ".npz": Container(_write_npz, _read_npz),
    ".zarr": Container(_write_zarr, _read_zarr),
}
