# SPDX-License-Identifier: BSD-3-Clause
"""The models that MODEL can name: systems of the gallery, or Python files with `system()`; `kane new`; options of several commands."""

import difflib
import inspect
import math
import sys
import time
from collections.abc import Callable, Mapping
from contextlib import redirect_stdout
from dataclasses import dataclass
from importlib.machinery import SourceFileLoader
from importlib.resources import files
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import CodeType, ModuleType
from typing import Annotated, Any

import typer

import kane as kn
from kane import expect
from kane.cli import screen
from kane.cli.screen import Misuse, short, user_code
from kane.errors import ModelError, alike, cut
from kane.gallery import GALLERY, load
from kane.present.scene.shapes import BodyShape

KINDS = ("q", "u", "parameters", "inputs", "states")
"""The keys of START."""

SPAN = (0.0, 5.0)
"""The default span of a motion."""

OF_OTHERS = frozenset((".urdf", ".xml", ".mjcf", ".al", ".a", ".txt"))
"""Endings of models of other tools."""


@dataclass(frozen=True, slots=True, eq=False)
class NamedModel:
    """A system with the data of its module; `start` contains values by name for each of `KINDS`."""

    name: str
    title: str
    sources: tuple[str, ...]
    path: Path | None
    system: kn.System
    start: Mapping[str, Mapping[str, Any]]
    span: tuple[float, float]
    declared: float
    shapes: tuple[BodyShape, ...] = ()


def model_of(text: str) -> NamedModel:
    """The model for the argument MODEL.

    Raises Misuse if it is neither in the gallery nor a file; ModelError if the file has no `system()` that returns a System; UserError
    if the file's own code fails.
    """
    if text in GALLERY:
        module = load(text)
        return _model(text, module, None, STARTS.get(text, {}))
    path, function = Path(text), "system"
    head, sign, tail = text.rpartition(":")
    if sign and tail.isidentifier() and not path.is_file():
        path, function = Path(head), tail
    if head in GALLERY:
        raise Misuse(
            f"Expected :NAME after a Python file, got {text}. {head} is a system of the gallery: write it alone."
        )
    if not path.is_file():
        raise Misuse(_unknown(str(path), path))
    if path.suffix.lower() in OF_OTHERS:
        cure = f"`kane convert {path} -o model.py` makes one of it."
        raise Misuse(f"Expected a system of the gallery or a Python file as MODEL, got {path}. {cure}")
    with user_code(path), redirect_stdout(sys.stderr):  # output of the file must not mix with results
        return _model(path.stem, imported(path), path, {}, function)


def names_like(start: str) -> list[str]:
    """Completions of MODEL: systems of the gallery, Python files, folders."""
    head = Path(start)
    folder = head if start.endswith("/") else head.parent
    files = [p for p in folder.glob("*") if p.suffix == ".py" or p.is_dir()] if folder.is_dir() else []
    names = [*GALLERY, *sorted(f"{p}/" if p.is_dir() else str(p) for p in files if not p.name.startswith((".", "__")))]
    return [name for name in names if name.startswith(start)]


def _unknown(text: str, path: Path) -> str:
    if path.is_dir():
        return f"Expected a system of the gallery or a Python file as MODEL, got the folder {text}."
    if path.suffix == ".py" or len(path.parts) > 1:
        near = [str(p) for p in path.parent.glob("*.py")] if path.parent.is_dir() else []
        return f"Expected a Python file as MODEL, got {text}, which does not exist.{alike(text, near)} `kane new {text}` writes one."
    own = [f"{text}.py"] if Path(f"{text}.py").is_file() else []
    cure = f" Did you mean {own[0]}?" if own else alike(text, GALLERY)
    return (
        f"Expected a system of the gallery or a Python file as MODEL, got {text!r}.{cure} `kane gallery` lists the systems; "
        "`kane new model.py` writes a file."
    )


class _Loader(SourceFileLoader):
    """A loader that always compiles the file, and writes no __pycache__ beside it."""

    def get_code(self, fullname: str) -> CodeType:
        """The compiled code of the file."""
        try:
            code: CodeType = self.source_to_code(self.get_data(self.path), self.path)
        except OSError as error:
            raise Misuse(f"Expected a file that can be read as MODEL, got {self.path}: {error.strerror}.") from error
        except ValueError as error:  # null bytes, in some releases of Python
            raise SyntaxError(str(error), (self.path, 1, None, None)) from error
        return code


def imported(path: Path) -> ModuleType:
    """A Python file imported as a module."""
    name = f"kane_model_{path.stem}"  # a name that nothing else imports
    spec = spec_from_file_location(name, path, loader=_Loader(name, str(path.resolve())))
    if spec is None or spec.loader is None:
        raise Misuse(f"Expected a Python file as MODEL, got {path}.")
    module = module_from_spec(spec)
    sys.modules[name] = module  # dataclasses and pickle look there
    folder = str(path.resolve().parent)
    if folder not in sys.path:
        sys.path.insert(0, folder)  # as `python FILE` does: the file's neighbours can be imported, later ones too
    spec.loader.exec_module(module)
    return module


def _model(
    name: str, module: ModuleType, path: Path | None, start: Mapping[str, Any], function: str = "system"
) -> NamedModel:
    where = short(path) if path else name
    maker = _maker(module, where, function)
    began = time.perf_counter()
    system = maker()
    declared = time.perf_counter() - began
    if not isinstance(system, kn.System):
        cure = "end it with `return kn.System(…)`" if system is None else "return the System itself"
        raise ModelError(f"Expected {function}() in {where} to return a kn.System, got {_kind(system)}: {cure}.")
    with user_code(path, "START"):
        begin = _start(getattr(module, "START", start), where)
    with user_code(path, "SPAN"):
        span = _span(getattr(module, "SPAN", SPAN), where)
    with user_code(path, "shapes"):
        drawn = getattr(module, "shapes", None)
        shapes = tuple(drawn(system)) if callable(drawn) else ()
    title, sources = getattr(module, "TITLE", name.replace("_", " ")), getattr(module, "SOURCES", ())
    quoted = expect.instances(sources, str, f"SOURCES in {where} to be a list of texts", 'Write SOURCES = ["…"].')
    return NamedModel(name, str(title), quoted, path, system, begin, span, declared, shapes)


def _kind(value: object) -> str:
    return "None" if value is None else f"{type(value).__name__} ({cut(repr(value))})"


def _maker(module: ModuleType, where: str, name: str) -> Callable[[], Any]:
    maker: Any = getattr(module, name, None)
    if maker is None:
        own = [n for n, f in vars(module).items() if inspect.isfunction(f) and f.__module__ == module.__name__]
        has = f"only {', '.join(f'{n}()' for n in own)}" if own else "no function"
        near = difflib.get_close_matches(name, own, n=1)
        cure = f"Rename {near[0]} to {name}, or define" if near else "Define"
        raise ModelError(
            f"Expected a function {name}() in {where}, got {has}. {cure} one that returns a kn.System; `kane new example.py` writes "
            "an example."
        )
    if not callable(maker):
        raise ModelError(
            f"Expected {name} in {where} to be a function, got {_kind(maker)}: write `def {name}(): … return kn.System(…)`."
        )
    try:
        inspect.signature(maker).bind()
    except TypeError as error:
        raise ModelError(
            f"Expected {name}() in {where} to need no arguments, got one with {error}: give it a default."
        ) from error
    return maker  # type: ignore[no-any-return]


def _start(told: Any, where: str) -> dict[str, dict[str, Any]]:
    if not isinstance(told, Mapping):
        raise ModelError(f"Expected START in {where} to be a dict with q and u, got {cut(repr(told))}.")
    for kind, values in told.items():
        if kind not in KINDS:
            raise ModelError(f"Expected START in {where} to have keys among {', '.join(KINDS)}, got {kind!r}.")
        expected = f"START[{kind!r}] in {where} to be a dict {{name: value}}"
        cure = "Give each value by name; the order is irrelevant."
        expect.that(isinstance(values, Mapping), expected, values, cure)
    return {kind: {getattr(k, "name", k): v for k, v in values.items()} for kind, values in told.items()}


def _span(told: Any, where: str) -> tuple[float, float]:
    try:
        first, last = (float(t) for t in told)
    except (TypeError, ValueError) as error:
        raise ModelError(f"Expected SPAN in {where} to be two times (t0, t1) in s, got {cut(repr(told))}.") from error
    ordered = math.isfinite(first) and math.isfinite(last) and last > first
    expect.that(ordered, f"SPAN in {where} to end after it begins", told, "Swap its times, or end later.")
    return first, last


STARTS: dict[str, Mapping[str, Mapping[str, float]]] = {
    "particle_on_spring": {"q": {"x": 0.6, "y": 0.2, "z": -0.9}, "u": {"u_x": 0.0, "u_y": 1.0, "u_z": 0.0}},
    "pendulum": {"q": {"theta": 1.0}, "u": {"u_theta": 0.0}},
    "double_pendulum": {"q": {"q1": 1.0, "q2": 2.0}, "u": {"u1": 0.0, "u2": 0.0}},
    "pendulums": {"q": {"q1": 0.5, "q2": 1.0, "q3": 1.5}, "u": {"u1": 0.0, "u2": 0.0, "u3": 0.0}},
    "pendulum_on_cart": {"q": {"x": 0.0, "theta": 1.0}, "u": {"u_x": 0.0, "u_theta": 0.0}},
    "spherical_pendulum": {"q": {"phi": 0.0, "theta": 1.0}, "u": {"u_phi": 2.0, "u_theta": 0.0}},
    "spinning_top": {"q": {"psi": 0.0, "theta": 0.5, "phi": 0.0}, "u": {"u_psi": 0.0, "u_theta": 0.0, "u_phi": 150.0}},
    "free_body": {
        "q": {"e0": 1.0, "e1": 0.0, "e2": 0.0, "e3": 0.0, "x": 0.0, "y": 0.0, "z": 0.0},
        "u": {"w1_e0": 0.01, "w2_e0": 5.0, "w3_e0": 0.02, "u_x": 0.1, "u_y": 0.0, "u_z": 0.0},
    },
    "gimbal_gyroscope": {"q": {"q1": 0.0, "q2": 0.3, "q3": 0.0}, "u": {"u1": 0.0, "u2": 0.0, "u3": 200.0}},
    "rolling_disk": {
        "q": {"q1": 0.0, "q2": 0.1, "q3": 0.0, "q4": 0.0, "q5": 0.0},
        "u": {"u1": 0.0, "u2": 2.0, "u3": 25.0, "u4": 2.0, "u5": 0.0},
    },
}
"""START of each system of the gallery by name, with default speeds."""


Name = Annotated[
    str,
    typer.Argument(
        metavar="MODEL",
        help="A system of the gallery, or a Python file with system(); FILE:NAME for another function of it.",
        autocompletion=names_like,
        show_default=False,
    ),
]
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON.")]
Out = Annotated[Path | None, typer.Option("--out", "-o", help="File to write.", show_default=False)]
Force = Annotated[bool, typer.Option("--force", help="Overwrite an existing file.")]
End = Annotated[float | None, typer.Option("--t1", help="End of the motion, s.", show_default="SPAN, or 5")]
Q = Annotated[list[str] | None, typer.Option("--q", metavar="NAME=VALUE", help="Start value of a coordinate.")]
U = Annotated[list[str] | None, typer.Option("--u", metavar="NAME=VALUE", help="Start value of a speed.")]
Parameters = Annotated[
    list[str] | None,
    typer.Option("--parameter", metavar="NAME=VALUE", help="Value of a parameter instead of its default."),
]
States = Annotated[
    list[str] | None, typer.Option("--state", metavar="NAME=VALUE", help="Start value of a further state.")
]
Inputs = Annotated[list[str] | None, typer.Option("--input", metavar="NAME=VALUE", help="Constant value of an input.")]


def new(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="Python file to write.", show_default=False)],
    force: Force = False,
) -> None:
    """Write a commented model file: a double pendulum on a cart held by a spring."""
    if file.suffix != ".py":
        raise Misuse(
            f"Expected a name that ends in .py, got {file}: `kane new {file.parent / (file.stem or 'model')}.py`."
        )
    _, _, text = (files("kane.cli") / "example.py").read_text(encoding="utf-8").partition("\n")  # without the licence
    screen.write(screen.target(file, None, force), text, force)
    typer.echo(f"Next: kane check {file}", err=True)
