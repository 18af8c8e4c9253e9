# SPDX-License-Identifier: BSD-3-Clause
"""MJCF through MuJoCo's reader, in a separate process with bounds on memory and time.

Before that `xml_text` checks the text: all files that it and its includes name must be in one folder.
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Any

from kane import expect
from kane.errors import ModelError, cut
from kane.interop.robots.xml_text import Element, given, parsed

MEMORY = 4 * 2**30
"""Maximum address space of the reading process in bytes."""
INCLUDES = 100
REFUSED = ("plugin", "flexcomp", "flex", "deformable")
"""Elements that are not rigid bodies, or that run code."""
_CHILD = """
import sys
try:
    import resource
    resource.setrlimit(resource.RLIMIT_AS, ({memory}, {memory}))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
except (ImportError, ValueError, OSError):
    pass
import mujoco
try:
    model = mujoco.MjModel.from_xml_path(sys.argv[1])
    mujoco.mj_saveModel(model, sys.argv[2], None)
except Exception as error:
    sys.stderr.write("\\n" + str(error)[:2000])
    sys.exit(3)
"""


def mujoco() -> Any:
    """The mujoco package."""
    lacking = ModelError("Expected the package mujoco to read MJCF. Install it: pip install 'kane[models]'.")
    return expect.package("mujoco", lacking)


def read(source: Any, folder: Any, timeout: float) -> tuple[Any, Element]:
    """MuJoCo's compiled model, and the text as elements.

    Raises
    ------
    ModelError
        if a named file is outside the folder, or MuJoCo cannot read the text within the bounds on time and memory
    """
    package = mujoco()
    expect.that(expect.is_number(timeout) and timeout > 0, "timeout= as seconds above zero", timeout)
    text, name, path = given(source, "MJCF")
    root = parsed(text, name)
    if root.tag not in ("mujoco", "mujocoinclude"):
        raise root.wrong("<mujoco> as the root of an MJCF", f"<{cut(root.tag)}>")
    within = _folder(path, folder)
    _check(root, path, within)
    with tempfile.TemporaryDirectory(prefix="kane-mjcf-") as own:
        if path is None:
            path = Path(own) / "model.xml"
            path.write_bytes(text if isinstance(text, bytes) else text.encode())
        binary = Path(own) / "model.mjb"
        _run(path, binary, min(timeout, _WEEK), name)
        return package.MjModel.from_binary_path(str(binary)), root


_UNSEEN = {"MUJOCO_GL": "disable"}
"""No library for windows, whose import takes as long as that of MuJoCo."""
_WEEK = 604800.0
"""Maximum timeout in seconds; operating systems do not accept much longer ones."""


def _run(path: Path, binary: Path, timeout: float, name: str) -> None:
    """Runs the process that reads the text and writes MuJoCo's binary model."""
    command = [sys.executable, "-I", "-c", _CHILD.format(memory=MEMORY), str(path.absolute()), str(binary)]
    try:
        done = subprocess.run(
            command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, timeout=timeout, check=False,
            cwd=binary.parent, env={k: v for k, v in os.environ.items() if not k.startswith("MUJOCO")} | _UNSEEN,
        )  # fmt: skip
    except subprocess.TimeoutExpired as late:
        cure = "Give a longer timeout=, or a smaller model."
        raise expect.refusal(ModelError, f"MuJoCo to read {name} in {timeout:g} s", "more", cure) from late
    if done.returncode or not binary.is_file():
        lines = [x.strip() for x in done.stderr.decode(errors="replace").splitlines() if x.strip()]
        came = cut("; ".join(lines[-4:]) or f"exit status {done.returncode}", 300)
        raise ModelError(f"Expected an MJCF that MuJoCo reads, got: {came} ({name})")


def _folder(path: Path | None, folder: Any) -> Path | None:
    if folder is None:
        return None if path is None else path.resolve().parent
    expect.instance(folder, (str, Path), "folder= the path of a folder")
    result = Path(folder).resolve()
    expect.that(result.is_dir(), "folder= the path of a folder", str(folder))
    return result


def _check(root: Element, path: Path | None, within: Path | None) -> None:
    """Raises if a named file, also in includes, is outside the folder, or an element runs code."""
    waiting, seen = [root], set[Path]() if path is None else {path.resolve()}
    elements: list[Element] = []
    while waiting:
        for e in waiting.pop().walk():
            if e.tag in REFUSED:
                raise e.wrong("rigid bodies alone, and no plugins", f"<{e.tag}>", "Leave it out.")
            elements.append(e)
            if e.tag != "include":
                continue
            (found,) = _files(e, "file", [""], path, within)
            if found in seen or len(seen) > INCLUDES:
                came = f"{found.name!r} again" if found in seen else f"more than {INCLUDES}"
                raise e.wrong("files that are included once", came)
            seen.add(found)
            text, name, _ = given(found, "MJCF")
            waiting.append(parsed(text, name))
    folders = ["", *(v for e in elements if e.tag == "compiler" for k, v in e.attributes.items() if k.endswith("dir"))]
    for e in elements:
        for key in [k for k in e.attributes if k.startswith("file") and e.tag != "include"]:
            _files(e, key, folders, path, within)


def _files(e: Element, key: str, folders: list[str], path: Path | None, within: Path | None) -> list[Path]:
    """The files that an attribute may name, in any of these folders."""
    name = e.text(key)
    if path is None or within is None:
        raise e.wrong("no files in an MJCF that is given as text", cut(repr(name)), "Give the path of a file.")
    result = []
    for folder in folders:
        for p in (folder, name):
            if PurePosixPath(p).is_absolute() or PureWindowsPath(p).drive or "\0" in p:
                raise e.wrong(f"files below {within.name!r}", cut(repr(p)), "Name it relative to the model.")
        file = (path.resolve().parent / folder / name).resolve()
        if within not in file.parents:
            cure = "Say by folder= below which folder files may be opened."
            raise e.wrong(f"files below {within.name!r}", cut(repr(str(PurePosixPath(folder, name)))), cure)
        result.append(file)
    return result
