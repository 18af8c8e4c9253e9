# SPDX-License-Identifier: BSD-3-Clause
"""`kane convert`: a model of another tool as a Python file that declares it to kane."""

import sys
from collections.abc import Mapping
from contextlib import redirect_stdout
from inspect import isfunction
from pathlib import Path
from typing import Annotated, Any

import typer

import kane as kn
from kane.cli import screen
from kane.cli.models import KINDS, SPAN, Force, Out, imported, model_of, names_like
from kane.cli.screen import Misuse, short, user_code
from kane.equations.state import Guess
from kane.errors import cut
from kane.gallery import GALLERY
from kane.interop.imported import Imported
from kane.progress import working

READERS: Mapping[str, str] = {
    ".urdf": "from_urdf",
    ".xml": "from_mjcf",
    ".mjcf": "from_mjcf",
    ".al": "from_autolev",
    ".in": "from_autolev",
}
"""The reader of a file, by its ending."""
ROBOTS = ("from_urdf", "from_mjcf")


def convert(
    source: Annotated[
        str,
        typer.Argument(
            metavar="FILE[:NAME]",
            help="A file of URDF, MJCF or Autolev; or FILE.py:NAME, a KanesMethod or System of SymPy, or a function that returns one.",
            autocompletion=names_like,
            show_default=False,
        ),
    ],
    out: Out = None,
    stops: Annotated[bool, typer.Option("--stops", help="URDF and MJCF: import joint limits as stops.")] = False,
    friction: Annotated[bool, typer.Option("--friction", help="URDF and MJCF: import dry friction in joints.")] = False,
    force: Force = False,
) -> None:
    """Write a model of URDF, MJCF, Autolev or SymPy as a Python file that declares it to kane."""
    path = _path(source)
    options = {name: True for name, wanted in (("stops", stops), ("friction", friction)) if wanted}
    if options and (path is None or not path.is_file() or _reader(path) not in ROBOTS):
        raise Misuse(f"Expected a file of URDF or MJCF with --{' --'.join(options)}, got {source}.")
    place = screen.target(out, path, force) if out else None
    with working("Reading"):
        text, remarks = _written(source, path, options)
    for line in remarks:
        screen.say(line, err=True)
    if place is None:
        typer.echo(text, nl=False)
        return
    screen.write(place, text, force)
    screen.say(f"Next: kane check {place}", err=True)


def _path(source: str) -> Path | None:
    """The file to read; None for a system of the gallery."""
    if source in GALLERY:
        return None
    path = Path(source)
    return path if path.is_file() else Path(source.rpartition(":")[0] or source)


def _written(source: str, path: Path | None, options: Mapping[str, bool]) -> tuple[str, list[str]]:
    """The text of the file, and remarks on what was inferred, changed or left out."""
    if path is None or (path.suffix == ".py" and path == Path(source)):
        model = model_of(source)
        span = None if model.span == SPAN else model.span
        return kn.exchange.to_python(model.system, title=model.title, start=model.start, span=span), []
    if not path.is_file():
        raise Misuse(
            f"Expected a file that ends in {', '.join((*READERS, '.py'))}, got {source}, which does not exist."
        )
    if path.suffix == ".py":
        return _of_python(path, source.rpartition(":")[2])
    return _of(getattr(kn.exchange, _reader(path))(path, **options), path.stem)


def _reader(path: Path) -> str:
    ending = path.suffix.lower()
    if ending not in READERS:
        raise Misuse(f"Expected a file that ends in {', '.join((*READERS, '.py'))}, got {path}.")
    if ending == ".xml" and b"<robot" in path.read_bytes()[:4096]:
        return "from_urdf"
    return READERS[ending]


def _of_python(path: Path, name: str) -> tuple[str, list[str]]:
    """An object in a Python file: a kane System, or an argument of `kn.from_sympy_mechanics`."""
    with user_code(path), redirect_stdout(sys.stderr):
        module = imported(path)
        found: Any = getattr(module, name, None)
        if found is None:
            own = ", ".join(k for k in vars(module) if not k.startswith("_")) or "nothing"
            raise Misuse(f"Expected a name defined in {short(path)} ({cut(own, 200)}), got {name}.")
        found = found() if isfunction(found) else found
    if isinstance(found, kn.System):
        return kn.exchange.to_python(found, title=name.replace("_", " ")), []
    return _of(kn.exchange.from_sympy_mechanics(found), path.stem)


def _of(model: Imported, title: str) -> tuple[str, list[str]]:
    """The text of an imported model, with its remarks at the head of the file."""
    remarks = [str(r) for r in model.remarks if r.kind not in ("read", "checked")]
    start = _start_of(model)
    text = kn.exchange.to_python(model.system, title=title.replace("_", " "), start=start, remarks=remarks)
    return text, remarks


def _start_of(model: Imported) -> dict[str, dict[str, Any]]:
    """Start values from the source or its reader, by name; none if constraints cannot be satisfied near them."""
    told = model.extras.get("start")
    groups = {kind: getattr(told, kind, None) or {} for kind in KINDS}
    if any(isinstance(v, Guess) for values in groups.values() for v in values.values()):
        try:
            found = kn.assemble(model.eom, told)
        except kn.KaneError:
            return {}
        groups |= {"q": found.q, "u": found.u}
    return {kind: {getattr(s, "name", s): float(v) for s, v in values.items()} for kind, values in groups.items()}
