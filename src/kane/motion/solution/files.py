# SPDX-License-Identifier: BSD-3-Clause
"""Files of motions: arrays with a header, one zip file each, with a SHA-256 checksum; nothing in a file is executed.

A file contains the numbers of a motion, the names of its symbols, and a fingerprint of the declared system, by which it is identified:
each expression is evaluated at several values of its symbols, which depend on their names alone. So expressions are compared by their
values, not their form, and may differ by rounding on another machine. Of operations that select, or that are defined for some numbers
only, such as √x, the arguments are compared too.
"""

import hashlib
import json
import zipfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from kane.equations.equations import Equations
from kane.errors import SolutionFileError
from kane.expr.build import add, mul
from kane.expr.evaluation import Walk
from kane.expr.node import ZERO, Expr, as_expr, postorder
from kane.expr.ops import ADD, COS, DIV, MUL, NEG, SIN, SUB
from kane.expr.piecewise import lowered
from kane.expr.symbols import Parameter, Symbol
from kane.model.bodies import parts_of
from kane.model.contacts import slip_parameters
from kane.model.system import System
from kane.motion.inputs.expressions import along
from kane.motion.inputs.functions import constant
from kane.numeric.arrays import Array
from kane.numeric.scale import EQUAL, ROUNDED_CHAIN
from kane.space.frame import Frame, Point
from kane.space.vector import Dyadic, Vector
from kane.whole import exchange, opened

FORMAT, VERSION = "kane solution", 2
_HEADER, _SEAL = "header", "sha256"

Anything = npt.NDArray[Any]


class Contents(NamedTuple):
    """The contents of a file: header and arrays by name."""

    header: dict[str, Any]
    arrays: dict[str, Anything]


class Container(NamedTuple):
    """A file format: functions that write a text and arrays to a path, and read them."""

    write: Callable[[Path, str, Mapping[str, Anything]], None]
    read: Callable[[Path], tuple[str, dict[str, Anything]]]


def write(path: Path, contents: Contents) -> None:
    """Write a file, or replace one that contains a solution.

    Raises
    ------
    SolutionFileError
        if its name has none of the endings of `CONTAINERS`, the folder does not exist, or the path is that of another file
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
        if it does not exist, is truncated or damaged, not a solution, or of another version
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
    except Exception as error:  # each library raises its own exceptions for damaged files
        raise SolutionFileError(
            f"Expected a file with a solution, got one that cannot be read, {path}: it is truncated, damaged or of another "
            f"kind ({type(error).__name__}: {error}). Write it again by sol.save(path)."
        ) from error
    if not known:
        raise SolutionFileError(f"Expected a file with a solution, got {path} with something else in it.")
    if header.get("version") != VERSION:
        raise SolutionFileError(
            f"Expected a file with a solution of version {VERSION}, got version {header.get('version')!r}, written by kane "
            f"{header.get('kane')}: {path}. Read it with that version of kane, or simulate again."
        )
    if header.pop(_SEAL, None) != _seal(header, arrays):
        raise SolutionFileError(
            f"Expected a file with a solution as it was written, got {path}, which was changed or is truncated. Use a backup "
            "copy, or simulate again."
        )
    return Contents(header, arrays)


def _stored(path: Path) -> Contents:
    """Header and arrays of a file, unchecked."""
    with opened(path) as file:
        if not zipfile.is_zipfile(file):
            raise ValueError("it has no table of contents")
    text, arrays = _container(path).read(path)
    header = json.loads(text)
    return Contents(header if isinstance(header, dict) else {}, arrays)


def _holds_solution(path: Path) -> bool:
    """Whether a file can be read as a solution, written by this version or another one."""
    try:
        return bool(_stored(path).header.get("format") == FORMAT)
    except ImportError:
        raise
    except Exception:  # as above
        return False


def _container(path: Path) -> Container:
    result = CONTAINERS.get(path.suffix)
    if result is None:
        raise SolutionFileError(
            f"Expected a file name that ends in {' or '.join(CONTAINERS)}, got {path.name!r}. The ending determines the format."
        )
    return result


def _seal(header: Mapping[str, Any], arrays: Mapping[str, Anything]) -> str:
    """The SHA-256 checksum of the header, and of names, types, shapes and numbers of arrays."""
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
            "Expected the package zarr for files that end in .zarr, got none. Install it, pip install 'kane[table]', or give "
            "a name that ends in .npz."
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


_EVERYWHERE = frozenset((ADD, COS, DIV, MUL, NEG, SIN, SUB))
_DRAWN = 4
"""Number of values of each symbol in a fingerprint."""


class Declared(NamedTuple):
    """A fingerprint: [name, text, number of expressions, number of rows] of each declaration, and the rows (rows × _DRAWN)."""

    things: list[list[Any]]
    numbers: Array


def declared(system: System, more: Iterable[tuple[str, Any]] = ()) -> Declared:
    """The fingerprint of a system's declarations, and of `more` by name."""
    things: list[list[Any]] = []
    roots: list[Expr] = []
    inner: list[slice] = []
    for name, what in (*_things(system), *more):
        told = list(_expressions_of(what))
        exprs = [x for x in told if isinstance(x, Expr)]
        within = [a for n in postorder(lowered(exprs)) if n.op not in _EVERYWHERE for a in n.args]
        things.append(
            [name, " ".join("#" if isinstance(x, Expr) else x for x in told), len(exprs), len(exprs + within)]
        )
        roots += exprs + within
        inner.append(slice(len(roots) - len(within), len(roots)))
    walk = Walk(roots)
    rows = [np.broadcast_to(x, (_DRAWN,)) for x in walk({s: _drawn(s) for s in walk.symbols})]
    numbers = np.array(rows, dtype=float).reshape(len(roots), _DRAWN)
    for rows_within in inner:  # sorted, since rounding may change the order of an expression's nodes
        numbers[rows_within] = np.sort(numbers[rows_within], axis=0)
    return Declared(things, numbers)


def difference(kept: Declared, here: Declared) -> str:
    """The declaration in which two fingerprints differ, with the values of a number, as text; "" if there is none."""
    one, two = _by_name(kept), _by_name(here)
    for name in one | two:
        if name not in two or name not in one:
            return f"{name}, which only {'this system' if name in two else 'that of the file'} has"
        (text, count, a), (other, number, b) = one[name], two[name]
        if (text, count, a.shape) != (other, number, b.shape):
            return name
        for rows in (slice(count), slice(count, None)):
            off = _off(a[rows], b[rows])
            if off.any():
                k = rows.indices(len(a))[0] + int(np.argmax(off.any(axis=1)))
                plain = k < count and not (np.ptp(a[k]) or np.ptp(b[k]))
                return f"{name}: {a[k, 0]:.9g} in the file, {b[k, 0]:.9g} here" if plain else name
    return ""


def _by_name(declared: Declared) -> dict[str, tuple[str, int, Array]]:
    """Text, number of expressions, and rows of each declaration; later declarations of the same name are numbered."""
    result: dict[str, tuple[str, int, Array]] = {}
    times: dict[str, int] = {}
    start = 0
    for name, text, count, rows in declared.things:
        times[name] = times.get(name, 0) + 1
        key = name if times[name] == 1 else f"{name} ({times[name]})"
        result[key] = text, count, declared.numbers[start : start + rows]
        start += rows
    if declared.numbers.shape != (start, _DRAWN):
        raise ValueError(f"declared should be of shape {(start, _DRAWN)}, got {declared.numbers.shape}")
    return result


def _off(a: Array, b: Array) -> Any:
    """Where rows of the same expressions differ by more than rounding; infinite and NaN values must agree."""
    size = np.where(np.isfinite(a), np.abs(a), 0.0)
    limit = EQUAL * size.max(axis=1, keepdims=True, initial=0) + ROUNDED_CHAIN * size.max(initial=0)
    with np.errstate(invalid="ignore"):
        near = (a == b) | (np.abs(a - b) <= limit) | (np.isnan(a) & np.isnan(b))
    return ~near


def _drawn(symbol: Symbol) -> Array:
    """Values of a symbol that depend on its name: half of them positive, the others of either sign."""
    words = [hashlib.sha256(f"{k} {symbol.name}".encode()).digest() for k in range(_DRAWN)]
    sizes = np.array([0.3 + int.from_bytes(w[:6]) / 2**48 for w in words])
    signs = np.array([-1.0 if k >= _DRAWN // 2 and w[6] % 2 else 1.0 for k, w in enumerate(words)])
    return np.asarray(sizes * signs)


def _things(s: System) -> Iterator[tuple[str, Any]]:
    yield from ((f"the parameter {p}", (p.default, p.unit)) for p in s.parameters)
    yield from ((f"the unit of {x}", x.unit) for x in (*s.coordinates, *s.speeds, *s.states, *s.inputs))
    yield from ((f"the speed {u}", definition) for u, definition in s.speeds.items())
    yield from ((f"the rate of {a}", rate) for a, rate in s.states.items())
    yield from ((f"the point {p.name}", (p.parent, p.body, p.offset)) for p in s.points)
    for frame in s.frames:
        o = frame.orientation
        yield f"the frame {frame.name}", o and (o.base.name, o.axis, o.angle, o.direction, o.cosines, o.parameters)
    for part in parts_of(s.bodies):
        yield f"the mass of {part.name}", part.mass
        yield f"the inertia of {part.name}", (part.frame, part.inertia)
        yield f"the mass centre of {part.name}", (part.mass_center, part.momenta)
    yield from (("gravity", g.acceleration) for g in s.gravities)
    yield from ((f"the load {x.name}", x) for x in s.loads)
    yield from ((f"the constraint {c.name}", c) for c in s.constraints)
    yield from ((f"the reaction {r}", r.place) for r in (*s.reactions, *s.auxiliary_speeds))
    yield from ((f"the event {e.name}", e) for e in s.events)


def _expressions_of(what: Any) -> Iterator[Expr | str]:
    """The expressions in a declaration, and everything else as text."""
    if isinstance(what, Expr):
        yield what
    elif isinstance(what, Frame | Point):
        yield what.name
    elif isinstance(what, Vector):
        for frame, triple in sorted(what.parts, key=lambda part: part[0].name):
            yield frame.name
            yield from triple
    elif isinstance(what, Dyadic):
        yield from _expressions_of(_entries(what))
    elif is_dataclass(what):
        for field in fields(what):
            yield from _expressions_of(getattr(what, field.name))
    elif isinstance(what, Mapping):
        for key, value in what.items():
            yield str(key)
            yield from _expressions_of(value)
    elif isinstance(what, tuple | list):
        for x in what:
            yield from _expressions_of(x)
    elif isinstance(what, float | int) and not isinstance(what, bool) and np.isfinite(what):
        yield as_expr(what)
    else:
        yield getattr(what, "__name__", "a function") if callable(what) else repr(what)


def _entries(inertia: Dyadic) -> dict[str, list[Expr]]:
    """The nine entries of a dyadic for each pair of frames."""
    entries: dict[str, list[Expr]] = {}
    for a, b in inertia.dyads:
        for one, left in a.parts:
            for two, right in b.parts:
                total = entries.setdefault(f"{one.name} {two.name}", [ZERO] * 9)
                total[:] = [add(x, mul(left[k // 3], right[k % 3])) for k, x in enumerate(total)]
    return dict(sorted(entries.items()))


_KINDS = ("coordinates", "speeds", "states", "parameters", "inputs")
_STATUS = ("finished", "event", "stopped")
_TYPES = {
    **dict.fromkeys(("kane", "status", "message", "method"), str),
    **dict.fromkeys(("steps", "evaluations"), int),
    **dict.fromkeys(("events", "partitions", "numbers", "phases", "declared", "modes"), list),
}
"""The entries of a header that are checked, and their types."""


def phase_parameters(eom: Equations) -> tuple[Parameter, ...]:
    """The parameters of phases: those of the equations, then those of slip in the modes of contacts."""
    return (*eom.parameters, *slip_parameters(eom.system.contacts))


def contents(motion: Any) -> Contents:
    """The header and arrays of a Solution."""
    from importlib.metadata import version

    eom: Equations = motion.equations
    kept = list(dict.fromkeys([eom, *(s.equations for s in motion.segments), *motion.samples]))
    place = {one: k for k, one in enumerate(kept)}
    known = declared(eom.system)
    header = {
        "kane": version("kane"),
        **names(eom),
        "status": motion.status,
        "message": motion.message,
        "event": None if motion.event is None else motion.event.name,
        "events": [[e.name, None if e.quantity is not ZERO else e.message] for e, _ in motion.events],
        "steps": int(motion.steps),
        "evaluations": int(motion.evaluations),
        "method": motion.method,
        "partitions": [_partition(one) for one in kept],
        "modes": [[int(m) for m in one.system.modes] for one in kept],
        "numbers": [[constant(p.inputs[s]) for s in motion.inputs] for p in motion.phases],
        "phases": [[e.name for e in p.by] for p in motion.phases],
        "declared": known.things,
    }
    columns = [_column(motion, s) for s in motion.inputs]
    arrays = {
        "t": motion.t,
        "states": motion.states,
        "work": motion.work,
        "parameters": np.array([float(motion.parameters[p]) for p in eom.parameters]),
        "inputs": np.array(columns, dtype=float).reshape(len(columns), len(motion.t)),
        "tolerances": np.array([motion.rtol, motion.atol]),
        "event_times": np.array([t for _, t in motion.events], dtype=float),
        "segment_starts": np.array([s.start for s in motion.segments], dtype=float),
        "segments": np.array([place[s.equations] for s in motion.segments], dtype=np.int64),
        "samples": np.array([place[one] for one in motion.samples], dtype=np.int64),
        "phase": motion.phase,
        "phase_parameters": np.array(
            [[float(p.parameters.get(s, 0.0)) for s in phase_parameters(eom)] for p in motion.phases], dtype=float
        ).reshape(len(motion.phases), len(phase_parameters(eom))),
        "declared": known.numbers,
    }
    return Contents(header, arrays)


def check(found: Contents, eom: Equations) -> None:
    """A ValueError for contents that no file of these equations has: a wrong type or shape, NaN, decreasing times."""
    header, arrays = found
    for name, kind in _TYPES.items():
        if type(header[name]) is not kind:
            raise ValueError(f"{name} should be {kind.__name__}, got {type(header[name]).__name__}")
    if header["status"] not in _STATUS:
        raise ValueError(f"the status should be one of {', '.join(_STATUS)}, got {header['status']!r}")
    n, starts, samples = (arrays[name].size for name in ("t", "segment_starts", "samples"))
    own, phases, kept = len(eom.parameters), len(header["phases"]), len(header["partitions"])
    shapes = {
        "t": (max(n, 1),),
        "states": (n, len(eom.state)),
        "work": (n,),
        "parameters": (own,),
        "inputs": (len(eom.inputs), n),
        "tolerances": (2,),
        "event_times": (len(header["events"]),),
        "segment_starts": (starts,),
        "phase_parameters": (phases, len(phase_parameters(eom))),
    }
    for name, shape in shapes.items():
        _check_array(name, arrays[name], shape, "f")
        if not np.isfinite(arrays[name]).all():
            raise ValueError(f"{name} should be finite numbers, got NaN or infinity")
    for name, length, count in (("segments", starts, kept), ("samples", samples and n, kept), ("phase", n, phases)):
        _check_array(name, arrays[name], (length,), "i")
        if np.any((arrays[name] < 0) | (arrays[name] >= count)):
            raise ValueError(f"{name} should be counted from 0 to {count - 1}, got others")
    steps, leaps = np.diff(arrays["t"]), np.diff(arrays["phase"])
    if np.any((leaps < 0) | (steps < 0) | ((steps == 0) & (leaps == 0))):
        raise ValueError("times should increase, and be repeated only where a phase begins, got others")


def _check_array(name: str, array: Any, shape: tuple[int, ...], kind: str) -> None:
    if array.shape != shape or array.dtype.kind != kind:
        raise ValueError(
            f"{name} should be of shape {shape} and kind {kind!r}, got {array.shape} and {array.dtype.kind!r}"
        )


def _column(motion: Any, symbol: Any) -> Array:
    """The values of an input at the samples."""
    result = np.empty(len(motion.t))
    for number, phase in enumerate(motion.phases):
        at = motion.phase == number
        result[at] = along(phase.inputs[symbol], motion.t[at], motion.states[at])
    return result


def names(eom: Equations) -> Mapping[str, Sequence[str]]:
    """The names of symbols of each kind, which are compared first."""
    return {kind: [s.name for s in getattr(eom, kind)] for kind in _KINDS}


def _partition(eom: Equations) -> list[list[int]] | None:
    """Rows, dependent speeds and redundant rows of the partition; None without one."""
    if eom.embedding is None:
        return None
    p = eom.embedding.partition
    return [[int(k) for k in part] for part in (p.rows, p.dependent, p.redundant)]
