# SPDX-License-Identifier: BSD-3-Clause
"""Stores: results of many motions as a directory in Zarr 3 format, written chunk by chunk; an interrupted run can be resumed.

A new store is a template of empty arrays, made under a temporary name and renamed, so that a store is either complete or absent. A
chunk of instances is one file of each array, written once by one writer. Its files are flushed to disk and renamed one by one, and
the statuses of the chunk, which are its record, come last: a chunk without readable statuses counts as not run. A killed process
thus leaves complete chunks, and parts that are written again.

The group ".kane" describes the motions: the system in the form of solution files (`solution/files.py`), and options and initial
values as text or SHA-256.
"""

import hashlib
import json
import os
import shutil
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, fields, is_dataclass
from functools import partial
from importlib.metadata import version
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any

import numpy as np

from kane.equations.instances import package
from kane.errors import SolutionFileError
from kane.expr.node import Expr
from kane.motion.many.chunks import Job
from kane.motion.many.results import REDUCTIONS, Results, coordinates
from kane.motion.many.tiles import cut_into
from kane.motion.solution.files import Declared, declared, difference
from kane.program.native.machine import Settings
from kane.whole import path_of, to_disk

FORMAT, VERSION = "kane runs", 1
_OWN, _HEADER, _RECORD = ".kane", "header", "status"
_WHOLE = 2**20
"""Instances per chunk of arrays that are known from the start."""
_NEW = "Give another path as store=, or remove this one first."


@dataclass(frozen=True, slots=True)
class Store:
    """A store at a path, of `count` instances in chunks of `size`."""

    path: Path
    count: int
    size: int

    def missing(self) -> list[range]:
        """The chunks that have not been run."""
        record = package("zarr").open_group(self.path, mode="r")[_RECORD]
        return [rows for rows in cut_into(range(self.count), self.size) if not _is_there(record, rows)]

    def opened(self, job: Job) -> Any:
        """The Dataset, whose numbers are read lazily."""
        options = {"consolidated": False, "decode_times": False}
        variables, known = _empty(job, 0)
        return package("xarray").open_zarr(self.path, **options)[[*variables, *known]].set_coords(list(known))

    def tidy(self) -> None:
        """Removes temporary files of writers that were killed."""
        for part in self.path.rglob("*.partial"):
            part.unlink(missing_ok=True)


def _is_there(record: Any, rows: range) -> bool:
    try:
        return bool((np.asarray(record[rows.start : rows.stop]) != "").all())
    except Exception:  # each codec raises its own types for an incomplete record
        return False


def write(path: Path, chunk: Results) -> None:
    """Write the results of a chunk, then its record.

    Raises
    ------
    SolutionFileError
        if writing fails
    """
    place, told = slice(chunk.rows.start, chunk.rows.stop), chunk.variables()
    with _writing(path):
        group = package("zarr").open_group(path, mode="r+")
        for name in sorted(told, key=_RECORD.__eq__):  # the record comes last
            array = group[name]
            values = told[name].values
            array[place] = values.astype(object) if values.dtype.kind == "U" else values
            folder = path / name / "c"
            written = folder / str(chunk.rows.start // array.chunks[0])
            for file in [written] if written.is_file() else written.rglob("*"):
                to_disk(file)
            to_disk(written.parent)


@contextmanager
def _writing(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise SolutionFileError(
            f"Expected to write the store {path}, got {error.strerror or error}. Free disk space, or make sure that the folder "
            "exists and is writable, and call again with the same store: complete chunks are kept, and only the others are run."
        ) from error


def begun(given: Any, job: Job, size: int | None) -> Store:
    """The store at a path, made if it does not exist.

    Raises
    ------
    ArgumentError
        if it is not a path
    SolutionFileError
        if it cannot be made, contains something else, or belongs to another system, other settings or other initial values
    """
    path = path_of(given, 'store="runs.zarr"').absolute()
    known = declared(job.family.eom.system, _formulas(job))
    same = _facts(job)
    if path.is_dir() and any(path.iterdir()):
        header = _header(path)
        _check(path, header, known, same)
        if size not in (None, header["chunk"]):
            raise SolutionFileError(
                f"Expected chunks as the store {path} has them, {header['chunk']} instances each, got chunk={size}. Leave it out."
            )
        return Store(path, job.count, header["chunk"])
    _check_free(path)
    size = job.chunk_size() if size is None else size
    header = {"format": FORMAT, "version": VERSION, "kane": version("kane"), "chunk": size, "same": same}
    own = {**header, "things": known.things, "numbers": known.numbers.tolist()}
    _make(path, lambda fresh: _template(fresh, job, size, json.dumps(own)))
    return Store(path, job.count, size)


def _check_free(path: Path) -> None:
    if path.exists() and not path.is_dir():
        raise SolutionFileError(f"Expected the path of a new or an existing store, got the file {path}. {_NEW}")
    if not path.parent.is_dir() or not os.access(path.parent, os.W_OK):
        cure = "Make it first, or choose another one."
        raise SolutionFileError(f"Expected a writable folder, got {path.parent} in {path}. {cure}")


def _make(path: Path, fill: Callable[[Path], None]) -> None:
    fresh = path.with_name(f".kane-{os.urandom(8).hex()}.part")
    try:
        with _writing(path):
            fill(fresh)
            for place in [*fresh.rglob("*"), fresh]:
                to_disk(place)
            fresh.rename(path)
            to_disk(path.parent)
    finally:
        shutil.rmtree(fresh, ignore_errors=True)


def _template(path: Path, job: Job, size: int, header: str) -> None:
    """Writes empty arrays, coordinates and the header."""
    variables, known = _empty(job, job.count)
    for name in (*variables, *known):
        if "/" in name or name.startswith(("__", ".")) or name == "zarr.json":
            raise SolutionFileError(
                f"Expected names of outputs that a store can have, got {name!r}. Choose one without “/”, and without “.” or “__” "
                "in front."
            )
    plain = " ".join(name for name, v in known.items() if name not in v.dims and " " not in name)
    group = package("zarr").create_group(path, attributes=dict(job.facts) | ({"coordinates": plain} if plain else {}))
    for name, v in variables.items():
        _array(group, name, v, tuple(job.count if d == "instance" else n for d, n in v.sizes.items()), size)
    for name, v in known.items():
        values = v.values
        _array(group, name, v, v.shape, _WHOLE)[...] = values.astype(object) if values.dtype.kind == "U" else values
    group.create_group(_OWN, attributes={_HEADER: header})


def _empty(job: Job, count: int) -> tuple[dict[str, Any], dict[str, Any]]:
    """Variables without instances, and coordinates for `count` instances."""
    family = job.family
    variables = Results(family.eom, job.kept, job.t, family.instances, range(0)).variables()
    return variables, coordinates(family.eom, job.t, family.instances, range(count), variables)


_EMPTY = {"U": "", "f": np.nan, "i": 0}


def _array(group: Any, name: str, v: Any, shape: tuple[int, ...], size: int) -> Any:
    chunks = tuple(max(1, min(n, size) if d == "instance" else n) for d, n in zip(v.dims, shape, strict=True))
    return group.create_array(
        name, shape=shape, chunks=chunks, dtype=str if v.dtype.kind == "U" else v.dtype, attributes=dict(v.attrs),
        fill_value=_EMPTY[v.dtype.kind], dimension_names=list(v.dims),
    )  # fmt: skip


def _header(path: Path) -> dict[str, Any]:
    """The header of a store."""
    try:
        header = json.loads(package("zarr").open_group(path, mode="r")[_OWN].attrs[_HEADER])
        known = header["format"] == FORMAT
    except ImportError:
        raise
    except Exception:  # each library below raises its own types for foreign content
        known = False
    if not known:
        raise SolutionFileError(
            f"Expected a store that kn.simulate_many wrote, got {path} with something else in it. {_NEW}"
        )
    if header["version"] != VERSION or header["kane"] != version("kane"):
        raise SolutionFileError(
            f"Expected a store of this version of kane, {version('kane')}, got one of version {header['kane']}: {path}. Its numbers "
            f"may differ. {_NEW}"
        )
    return dict(header)


def _check(path: Path, header: Mapping[str, Any], known: Declared, same: Mapping[str, str]) -> None:
    """Raises SolutionFileError that names the difference between a store and the motions to be run."""
    kept = Declared(header["things"], np.array(header["numbers"], dtype=float).reshape(-1, known.numbers.shape[1]))
    before = header["same"]
    names = [name for name in before | same if before.get(name) != same.get(name)]
    told = [f"{name}: {before.get(name, 'none')} in the store, {same.get(name, 'none')} here" for name in names]
    for reason in (difference(kept, known), *told):
        if reason:
            raise SolutionFileError(
                f"Expected the store of the same motions, got {path}, which differs in {reason}. Pass the arguments that it "
                f"was made with. {_NEW}"
            )


def _formulas(job: Job) -> Iterator[tuple[str, Any]]:
    """Expressions beside those of the system."""
    for one in job.kept:
        yield f"the output {one.name}", one.what
    for s, given in (job.family.instances.common["inputs"] or {}).items():
        yield f"the input {s}", given


def _facts(job: Job) -> dict[str, str]:
    """Everything else that determines the numbers, by name: as text, or as SHA-256 if long."""
    family, many = job.family, job.family.instances
    eom, plan = family.eom, family.plan._asdict()
    plan.pop("samples")
    found = {name: _text(value) for name, value in plan.items()}
    found |= {"samples": _sha(job.t), "settings": repr(family.settings or Settings()), "lanes": repr(family.lanes)}
    found |= {"route": str(eom.route), "dependent speeds": ", ".join(map(str, eom.dependent_speeds))}
    found |= {"check": ", ".join(map(str, family.check)), "count": str(many.count)}
    known = {reduction: name for name, reduction in REDUCTIONS.items()}
    found |= {f"reduce {one.name}": known.get(one.reduce) or _text(one.reduce) for one in job.kept if one.reduce}
    for kind in many.columns:
        for s, given in (many.common[kind] or {}).items():
            found[f"{s} ({kind})"] = _text(given)
    return found | {f"{s} ({kind})": _sha(column) for kind, s, column in many.varied}


def _text(given: Any, depth: int = 4) -> str:
    """A text that is equal for equal values in every process; of functions it covers closures, defaults and globals they read."""
    if given is None or isinstance(given, str | bool | Expr):  # `_formulas` compares expressions
        return "an expression" if isinstance(given, Expr) else str(given)
    if isinstance(given, int | float | np.number):
        return repr(float(given))
    if isinstance(given, np.ndarray):
        return _sha(given) if given.dtype.kind in "if" else repr(given.tolist())
    if isinstance(given, tuple | list):
        return ", ".join(_text(x, depth) for x in given)
    if isinstance(given, Mapping):
        return ", ".join(f"{key}: {_text(x, depth)}" for key, x in given.items())
    if isinstance(given, partial):
        return f"partial({_text([given.func, *given.args, given.keywords], depth)})"
    code, name = getattr(given, "__code__", None), getattr(given, "__qualname__", type(given).__name__)
    if isinstance(given, type) or not depth:
        return str(name)
    if code is None:
        own = [getattr(given, f.name) for f in fields(given)] if is_dataclass(given) else _attributes(given)
        return f"{name}({', '.join(_text(x, depth - 1) for x in own)})"
    held = [*(c.cell_contents for c in given.__closure__ or ()), *(given.__defaults__ or ()), given.__kwdefaults__]
    held += [getattr(given, "__self__", None), *_globals_of(given)]
    text = repr([(c.co_code, c.co_names, _constants(c)) for c in _codes(code)]) + _text(held, depth - 1)
    return f"{name} {hashlib.sha256(text.encode()).hexdigest()[:16]}"


def _codes(code: CodeType) -> list[CodeType]:
    """The code object of a function, and those nested in it."""
    return [code, *(inner for c in code.co_consts if isinstance(c, CodeType) for inner in _codes(c))]


def _constants(code: CodeType) -> list[Any]:
    """The constants that are not code objects; frozensets in the same order in every process."""
    plain = (c for c in code.co_consts if not isinstance(c, CodeType))
    return [sorted(map(repr, c)) if isinstance(c, frozenset) else c for c in plain]


_READ = (str, bool, int, float, np.number, np.ndarray, tuple, list, Mapping, FunctionType, partial)


def _globals_of(function: Any) -> list[Any]:
    """Numbers, texts and functions that a function reads from its module by name."""
    own, names = function.__globals__, {name for c in _codes(function.__code__) for name in c.co_names}
    found = (own[name] for name in sorted(names) if name in own)
    return [x for x in found if isinstance(x, _READ)]


def _attributes(given: Any) -> list[Any]:
    """The attributes of an object."""
    slots = [name for kind in type(given).__mro__ for name in getattr(kind, "__slots__", ())]
    own = [getattr(given, name) for name in slots if hasattr(given, name) and not name.startswith("__")]
    return [*own, *getattr(given, "__dict__", {}).values()] or [repr(given)]


def _sha(numbers: Any) -> str:
    array = np.ascontiguousarray(numbers, dtype=float)
    return f"{array.size} numbers {hashlib.sha256(array.tobytes()).hexdigest()[:32]}"
