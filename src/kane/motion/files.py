# SPDX-License-Identifier: BSD-3-Clause
"""Files of arrays with a header: one zip file each, whose seal is the SHA-256 of header and arrays.

The header is text of JSON. Nothing in a file is executed.
"""

import hashlib
import json
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from kane.errors import SolutionFileError
from kane.whole import exchange, opened

FORMAT, VERSION = "kane solution", 2
_HEADER, _SEAL = "header", "sha256"

Anything = npt.NDArray[Any]


class Contents(NamedTuple):
    """What a file holds."""

    header: dict[str, Any]
    arrays: dict[str, Anything]


class Container(NamedTuple):
    """A kind of file: what writes a text and arrays at a path, what reads them."""

    write: Callable[[Path, str, Mapping[str, Anything]], None]
    read: Callable[[Path], tuple[str, dict[str, Anything]]]


def write(path: Path, contents: Contents) -> None:
    """Write a file, or put it in the place of one that holds a solution.

    Raises
    ------
    SolutionFileError
        if its name has another ending than those of `CONTAINERS`, there is no such folder, or something else has that name
    """
    container = _container(path)
    header = {"format": FORMAT, "version": VERSION, **contents.header}
    text = json.dumps({**header, _SEAL: _seal(header, contents.arrays)})
    exchange(path, lambda fresh: container.write(fresh, text, contents.arrays), _holds_solution, SolutionFileError)


def read(path: Path) -> Contents:
    """The contents of a file.

    Raises
    ------
    SolutionFileError
        if there is none, it is cut off or damaged, no file of this kind, or of another version
    """
    _container(path)
    try:
        header, arrays = _stored(path)
        known = header.get("format") == FORMAT
    except FileNotFoundError:
        raise SolutionFileError(
            f"Expected a file with a solution, got none at {path}. Write one by sol.save(path)."
        ) from None
    except (ImportError, SolutionFileError):
        raise
    except Exception as error:  # what damage there is has as many names as there are libraries below
        raise SolutionFileError(
            f"Expected a file with a solution, got one that cannot be read, {path}: it is cut off, damaged or something else "
            f"({type(error).__name__}: {error}). Write it again by sol.save(path)."
        ) from error
    if not known:
        raise SolutionFileError(f"Expected a file with a solution, got {path} with something else in it.")
    if header.get("version") != VERSION:
        raise SolutionFileError(
            f"Expected a file with a solution of version {VERSION}, got version {header.get('version')!r}, written by kane "
            f"{header.get('kane')}: {path}. Read it by that version of kane, or simulate again."
        )
    if header.pop(_SEAL, None) != _seal(header, arrays):
        raise SolutionFileError(
            f"Expected a file with a solution as it was written, got {path}, which was changed or is cut off. "
            "Take a copy of it, or simulate again."
        )
    return Contents(header, arrays)


def _stored(path: Path) -> Contents:
    """Header and arrays as they are in the file."""
    with opened(path) as file:
        if not zipfile.is_zipfile(file):
            raise ValueError("it has no table of contents")
    text, arrays = _container(path).read(path)
    header = json.loads(text)
    return Contents(header if isinstance(header, dict) else {}, arrays)


def _holds_solution(path: Path) -> bool:
    """Whether a file can be read as one that was written here, by this version or another one."""
    try:
        return bool(_stored(path).header.get("format") == FORMAT)
    except ImportError:
        raise
    except Exception:  # as above
        return False


def _container(path: Path) -> Container:
    found = CONTAINERS.get(path.suffix)
    if found is None:
        raise SolutionFileError(
            f"Expected a file name that ends in {' or '.join(CONTAINERS)}, got {path.name!r}. The ending says how it is written."
        )
    return found


def _seal(header: Mapping[str, Any], arrays: Mapping[str, Anything]) -> str:
    """SHA-256 of the header, and of names, types, shapes and numbers of arrays."""
    total = hashlib.sha256(json.dumps(header, sort_keys=True).encode())
    for name in sorted(arrays):
        array = np.ascontiguousarray(arrays[name])
        total.update(f"{name} {array.dtype.str} {array.shape} ".encode())
        total.update(array.tobytes())
    return total.hexdigest()


def _write_npz(path: Path, text: str, arrays: Mapping[str, Anything]) -> None:
    with path.open("wb") as file:
        every: dict[str, Any] = {**arrays, _HEADER: np.frombuffer(text.encode(), dtype=np.uint8)}
        np.savez_compressed(file, **every)


def _read_npz(path: Path) -> tuple[str, dict[str, Anything]]:
    with path.open("rb") as handle, np.load(handle, allow_pickle=False) as file:
        arrays = {name: file[name] for name in file.files}
    return arrays.pop(_HEADER).tobytes().decode(), arrays


def _zarr() -> Any:
    try:
        import zarr.storage
    except ImportError as error:
        raise ImportError(
            "Expected the package zarr for files that end in .zarr, got none. Install it, pip install 'kane[table]', or take a "
            "name that ends in .npz."
        ) from error
    return zarr


def _write_zarr(path: Path, text: str, arrays: Mapping[str, Anything]) -> None:
    zarr = _zarr()
    with zarr.storage.ZipStore(path, mode="w") as store:
        group = zarr.create_group(store, attributes={_HEADER: text})
        for name, array in arrays.items():
            group.create_array(name, data=np.ascontiguousarray(array))


def _read_zarr(path: Path) -> tuple[str, dict[str, Anything]]:
    zarr = _zarr()
    with zarr.storage.ZipStore(path, mode="r") as store:
        group = zarr.open_group(store, mode="r")
        arrays = {name: np.asarray(array[...]) for name, array in group.arrays()}
        return str(group.attrs[_HEADER]), arrays


CONTAINERS: Mapping[str, Container] = {
    ".npz": Container(_write_npz, _read_npz),
    ".zarr": Container(_write_zarr, _read_zarr),
}
