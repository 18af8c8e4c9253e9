# SPDX-License-Identifier: BSD-3-Clause
"""From a text to a sheet: statements are parsed, then executed in order."""

import re
from collections.abc import Iterable, Iterator
from importlib import import_module
from itertools import takewhile
from pathlib import Path

from kane.errors import KaneError, ModelError, alike
from kane.interop.autolev.commands import COMMANDS
from kane.interop.autolev.declarations import DECLARED, Statement, outlook, words_of
from kane.interop.autolev.evaluate import FileReading
from kane.interop.autolev.functions import FUNCTIONS
from kane.interop.autolev.genesis import MEMBERS
from kane.interop.autolev.grammar import Line, lines_of, parser
from kane.interop.autolev.sheet import Sheet
from kane.interop.autolev.statements import Statements
from kane.interop.autolev.units import base_units
from kane.interop.imported import Remarks

_SETTINGS = """
    autoz autorhs autoepsilon autoexpress autoassign overwrite beepsound pause digits factoring complex units output outputplot
    encode code save ode animate animake plot title zee format nicheck run checkifnumbers echo help load clear clearinput
    clearoutput outputencode encodeoutput plotoutput getunitsystem setautozee setautoz setdigits setdefaultparenthesis
    setautoexpress setimaginarynumber setautodifferentiate setautoepsilon setautofactor setautooverwrite setautorhs
    setautosimplify setautotaylor setautotaylorseries setautolinearize setbasissubscripts setbasissubscript setbeepsound
    setbeepsoundonerror setcmsymbol setcomplex setdefaults setlinespacing setlinestepping setpauseonwarning setscreendisplay
    setworkingdirectory setscratchdirectory setdirectory setworkingfolder setfolder setnozee setnozeesymbol resetnozee
"""
_SET = frozenset(_SETTINGS.split())
_ENDS = {"quit", "exit", "stop", "quitexit", "exitquit"}
_ARGUED = {"mass", "inertia", "input"}
_GENESIS = re.compile(r"(?im)^\s*(newtonianframe|rigidbody|rigidframe)\s|\.(set|rotate|translate)\w*\s*\(")
_ODE = re.compile(r"(?i)ode\s*\(.*[^\s(].*\)")
_MACROS = 4


def read(text: str, folder: Path | None) -> Sheet:
    """The sheet of a text; command files (.a) and files that it runs are looked up in `folder`."""
    sheet = Sheet(Remarks(), genesis=bool(_GENESIS.search(text)))
    reading = FileReading(sheet, FUNCTIONS, MEMBERS)
    lines = [x for line in _to_the_end(lines_of(text)) for x in _unfolded(line, folder, _MACROS)]
    statements = [s for line in lines if (s := _parsed(line, sheet)) is not None]
    if not statements:
        raise ModelError("Expected a model of Autolev or MotionGenesis, got a text without a statement.")
    statements_of = Statements(reading, outlook(statements))
    for s in statements:
        try:
            statements_of.do(s)
        except KaneError as error:
            if sheet.formed and _is_output(s, sheet):
                sheet.remarks.say("ignored", f"an output, as {_first(error)}", s.line.where)
                continue
            if s.line.where in str(error):
                raise
            raise ModelError(f"{error} This was found in {s.line.where}, “{s.line.text}”.") from error
    return sheet


def _to_the_end(lines: Iterable[Line]) -> Iterator[Line]:
    """The lines before the first that ends the program, such as Quit; the rest is ignored and may be invalid."""
    return takewhile(lambda line: line.text.lower() not in _ENDS, lines)


def _first(error: KaneError) -> str:
    text = str(error)
    return text[0].lower() + text[1:].rstrip(".")


def _is_output(s: Statement, sheet: Sheet) -> bool:
    """Whether a statement after the formation of the equations assigns a quantity that is not part of the model."""
    if s.tree.data != "statement" or s.tree.children[1] is None:
        return False
    names = words_of([s.tree.children[0]])
    base = {n.rstrip("'>") for n in names}
    return not (base & sheet.symbols.keys()) and not any(
        n.startswith(("force_", "torque_", "dependent")) for n in names
    )


def _unfolded(line: Line, folder: Path | None, deep: int) -> Iterator[Line]:
    """A line, or the lines of the file that it runs or calls as a command, with arguments substituted for #1#, #2#, …."""
    file, arguments = _called(line, folder) if folder is not None and folder.is_dir() else (None, ())
    if file is None:
        yield line
        return
    if not deep:
        raise line.refuse(f"files that call others at most {_MACROS} deep", file.name)
    body = file.read_text(encoding="utf-8", errors="replace")
    for k, argument in enumerate(arguments, 1):
        body = body.replace(f"#{k}#", argument.strip())
    for inner in lines_of(body):
        yield from _unfolded(Line(inner.text, line.number, line.column), folder, deep - 1)


def _called(line: Line, folder: Path) -> tuple[Path | None, tuple[str, ...]]:
    """The file in this folder that a line runs or calls, and its arguments."""
    run = re.fullmatch(r"(?i)run\s+(?:.*[/\\])?([^/\\]+)", line.text)
    if run is not None:
        return next((p for p in folder.iterdir() if p.name.lower() == run[1].lower() and p.is_file()), None), ()
    match = re.fullmatch(r"([A-Za-z]\w*)\s*\((.*)\)", line.text)
    name = match[1].lower() if match else ""
    if match is None or name in COMMANDS or name in FUNCTIONS or name in _SET:
        return None, ()
    file = next((p for p in folder.glob("*.[aA]") if p.stem.lower() == name), None)
    return file, tuple(match[2].split(","))


def _parsed(line: Line, sheet: Sheet) -> Statement | None:
    """A parsed statement; None for one that ends the program or sets something other than the model."""
    lark = import_module("lark")
    head = re.match(r"([A-Za-z_]+)('{0,3})(\s+(?![:+*/=^-]=?\s|=)|\s*$|(?=\())", line.text)
    word, rest = (head[1].lower(), line.text[head.end() :]) if head else ("", line.text)
    spaced = bool(head) and line.text[head.end() : head.end() + 1] != "(" if head else False
    if (
        not _ODE.match(line.text)
        and word in _SET | {"unitsystem", "setunitsystem", "degrees"}
        and not rest.lstrip().startswith(("=", ":="))
    ):
        _setting(word, rest, line, sheet)
        return None
    start, text, offset = "statement", line.text, 0
    solving = _ODE.match(text)
    if solving:
        text = solving[0]  # without the file name
    if spaced and word in DECLARED:
        start, text, offset = "declaration", rest, len(line.text) - len(rest)
    elif spaced and word in _ARGUED:
        start, text, offset = "args", rest, len(line.text) - len(rest)
    try:
        tree = parser().parse(text, start=start)
    except lark.exceptions.UnexpectedInput as error:
        column = offset + (error.column if isinstance(error.column, int) and error.column > 0 else len(text) + 1)
        known = (*DECLARED, *COMMANDS, *_ARGUED, *_SET)
        cure = alike(word, known).strip() if spaced and word and word not in known else ""
        raise line.refuse(
            "a statement of Autolev or MotionGenesis", f"a fault at column {line.column + column - 1}", cure
        ) from None
    return Statement(word, tree, line)


def _setting(word: str, rest: str, line: Line, sheet: Sheet) -> None:
    if word == "degrees":
        sheet.degrees = "off" not in rest.lower()
    elif word in ("unitsystem", "setunitsystem"):
        sheet.units = base_units(re.findall(r"[A-Za-z]+", rest), line)
    elif word == "run":
        raise line.refuse(
            "a file that is beside this one", "Run, which reads another file", "Put that file in its place."
        )
    else:
        sheet.remarks.say("ignored", f"{word}: no part of the model", line.where)
