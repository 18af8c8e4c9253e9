# SPDX-License-Identifier: BSD-3-Clause
"""Import of models written for Autolev and MotionGenesis."""

from pathlib import Path

from kane import expect
from kane.errors import ModelError
from kane.interop.autolev.build import build
from kane.interop.autolev.grammar import MOST_LETTERS
from kane.interop.autolev.read import read
from kane.interop.imported import Imported


def from_autolev(source: str | Path) -> Imported:
    """Read the model of an Autolev or MotionGenesis text.

    The statements are parsed by a grammar and interpreted in order; no code is run. Command files (`.a`) that a file calls are
    looked up in its folder. Statements that are not part of the model, such as outputs, code and settings, are listed in remarks.

    Parameters
    ----------
    source : path of a file, or the text itself (more than one line)

    Returns
    -------
    Imported
        the system, parameters with the values from Input, start values in `extras["start"]`, and remarks

    Raises
    ------
    ModelError
        if a statement is unknown or contradicts another one (the message names its line), or the text contains no model
    """
    expect.instance(source, (str, Path), "the path of an Autolev file, or its text")
    if isinstance(source, str) and ("\n" in source or len(source) > 1000):
        return build(read(source, None))
    path = Path(source)
    if not path.is_file():
        raise ModelError(
            f"Expected an Autolev file, or a text of several lines, got {str(source)!r}, which is no file."
        )
    if path.stat().st_size > MOST_LETTERS:
        raise ModelError(
            f"Expected a file of at most {MOST_LETTERS} letters, got {path.stat().st_size} in {path.name}."
        )
    return build(read(path.read_text(encoding="utf-8", errors="replace"), path.parent))
