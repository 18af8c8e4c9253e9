# SPDX-License-Identifier: BSD-3-Clause
"""From a text to a sheet: statements are parsed, then executed in order: commands, assignments, masses, inertias, values."""

import re
from collections.abc import Iterator, Sequence
from importlib import import_module
from itertools import takewhile
from pathlib import Path
from typing import Any

from kane.errors import KaneError, ModelError, alike
from kane.expr.differentiation import time_derivative
from kane.expr.node import ZERO, Expr, as_expr
from kane.expr.symbols import Coordinate, Input, Parameter, Speed, Symbol, rate
from kane.interop.autolev.commands import COMMANDS
from kane.interop.autolev.declarations import DECLARED, FORMING, Outlook, Statement, declare, outlook, words_of
from kane.interop.autolev.evaluate import CallArguments, FileReading, over, plus, quantity, times
from kane.interop.autolev.functions import FUNCTIONS
from kane.interop.autolev.genesis import MEMBERS, defined, tensor
from kane.interop.autolev.grammar import Line, bare, lines_of, parser, tokens
from kane.interop.autolev.sheet import FileTurn, Sheet, splits
from kane.interop.autolev.units import base_units
from kane.interop.autolev.values import Dyad, FileMatrix, Unread, Value, Vec
from kane.interop.imported import Remarks


class Statements:
    """Executes statements on a sheet."""

    def __init__(self, reading: FileReading, seen: Outlook) -> None:
        self.r, self.sheet, self.seen = reading, reading.sheet, seen

    def do(self, s: Statement) -> None:
        """Executes one statement."""
        tree, line = s.tree, s.line
        if tree.data == "declaration":
            declare(self.r, self.seen, s, self.assign)
        elif tree.data == "args":
            getattr(self, f"_{s.keyword}")(CallArguments(tree.children, line), line)
        elif tree.children[1] is None:
            self._command(tree.children[0], line)
        else:
            self._assignment(tree, line)

    # Commands --------------------------------------------------------------------------------------------------------

    def _command(self, tree: Any, line: Line) -> None:
        node = bare(tree)
        if node.data == "function":
            name = str(node.children[0]).lower()
            args = CallArguments(node.children[1].children, line)
            if name in COMMANDS:
                COMMANDS[name](self.r, args, line)
                return
            if name in ("setgeneralizedspeed", "setgeneralizedspeeds"):
                return
            if name == "setdt":
                for a in (a for a in args if a.data == "named"):
                    self.assign(str(a.children[0].children[0]), self.r.value(a.children[2], line), "=", line)
                return
            if name not in FUNCTIONS:
                known = (*COMMANDS, *FUNCTIONS)
                raise line.refuse(
                    "a command of Autolev", f"{node.children[0]} at column {line.column}", alike(name, known).strip()
                )
            self.sheet.remarks.say("ignored", f"{node.children[0]}(…): it only formats results", line.where)
        elif node.data == "member":
            self.r.value(node, line)
        else:
            self.sheet.remarks.say("ignored", "an expression that is only displayed", line.where)
            self.r.value(tree, line)

    # Mass, Inertia, Input --------------------------------------------------------------------------------------------

    def _mass(self, args: Sequence[Any], line: Line) -> None:
        for a in args:
            if a.data not in ("named", "chained"):
                raise line.refuse("Mass body = expression", "no “=”")
            name = _only(a.children[0], line).lower()
            if name not in self.sheet.bodies and name not in self.sheet.particles:
                known = [self.sheet.say(x) for x in (*self.sheet.bodies, *self.sheet.particles)]
                raise line.refuse("a body or particle that has a mass", name, alike(name, known).strip())
            if a.data == "chained":  # Mass A = mA = 10: a constant with its value
                mass: Expr = defined(self.r, str(a.children[2]), a.children[4], a.children[5], line)
            else:
                self._constants_of(a.children[2])
                mass = self.r.scalar(a.children[2], line)
            self.sheet.masses[name] = mass

    def _constants_of(self, tree: Any) -> None:
        """Declares new names in Mass and Inertia as constants."""
        for token in tokens(tree):
            name = str(token)
            low = name.lower()
            if name[-1] not in "'>" and low not in (*self.sheet.symbols, *self.sheet.values, "pi", "t", *FUNCTIONS):
                self.sheet.parameter(name)

    def _inertia(self, args: Sequence[Any], line: Line) -> None:
        node, rest = bare(args[0].children[0]), args[1:]
        name = str(node.children[0]).lower()
        inner = CallArguments(node.children[1].children, line) if node.data == "function" else None
        frame = _only(inner[0].children[0], line).lower() if inner is not None else ""
        body, point = name, self.sheet.bodies.get(name, "")
        if name not in self.sheet.bodies:
            pairs = [(a, b) for a, b in splits(name) if a in self.sheet.bodies and b in self.sheet.points]
            if not pairs:
                raise line.refuse("a body that has inertia", name, alike(name, self.sheet.bodies).strip())
            body, point = pairs[0]
        if len(rest) not in (3, 6):
            raise line.refuse("three or six measures of inertia", len(rest))
        values = [self._measure(a, line) for a in rest]
        self.sheet.inertias[body] = (tensor(frame or body, values), point, line)

    def _measure(self, a: Any, line: Line) -> Expr:
        """A moment or product of inertia, which may be defined in the statement: IA = 5."""
        if a.data == "named":
            return defined(self.r, _only(a.children[0], line), a.children[2], a.children[3], line)
        self._constants_of(a.children[0])
        return self.r.scalar(a.children[0], line)

    def _input(self, args: Sequence[Any], line: Line) -> None:
        for a in args:
            if a.data != "named":
                raise line.refuse("Input name = number", "no “=”")
            name = _only(a.children[0], line).lower()
            value = quantity(self.r, a.children[2], a.children[3], line)
            base = name.rstrip("'")
            if base in self.sheet.symbols or base in self.sheet.values:
                if isinstance(value, Expr):
                    self.sheet.inputs[name] = value
            else:
                self.sheet.remarks.say("ignored", f"{name}: a setting of the integrator", line.where)

    # Assignments -----------------------------------------------------------------------------------------------------

    def _assignment(self, tree: Any, line: Line) -> None:
        target, op, right, unit = tree.children
        if FORMING & words_of([right]):
            self.sheet.formed = True
        node = bare(target)
        value = quantity(self.r, right, unit, line)
        if node.data == "element":
            self._set_element(node, value, str(op), line)
        elif node.data == "name":
            self.assign(str(node.children[0]), value, str(op), line)
        elif node.data == "term" and len(node.children) == 3 and node.children[1] == "/":
            first, second = _only(node.children[0], line).lower(), _only(node.children[2], line).lower()
            self._load_pair(first, second, value, line)
        else:
            raise line.refuse("a name before “=”", "an expression")

    def _load_pair(self, first: str, second: str, value: Value, line: Line) -> None:
        """Force_P/Q> = F>: F on Q, −F on P, as Force(P/Q, F>)."""
        kind, _, one = first.partition("_")
        known, loads = (
            (self.sheet.points, self.sheet.forces) if kind == "force" else (self.sheet.frames, self.sheet.torques)
        )
        other = second.rstrip(">")
        if kind not in ("force", "torque") or one not in known or other not in known or not isinstance(value, Vec):
            raise line.refuse("Force_P/Q> or Torque_A/B> with a vector", f"{first}/{second}")
        self.sheet.act(loads, other, one, value, line)

    def _set_element(self, node: Any, value: Value, op: str, line: Line) -> None:
        name = str(node.children[0]).lower()
        at = [self.r.number(x.children[0], line) for x in node.children[1].children]
        if not at or len(at) > 2 or not all(0 < k <= 300 for k in at):
            raise line.refuse("one or two indices from 1 to 300", at)
        old = self.sheet.values.get(name)
        if isinstance(old, Unread) or isinstance(value, Unread):
            self.sheet.values[name] = old if isinstance(old, Unread) else value
            return
        rows = [list(row) for row in old.rows] if isinstance(old, FileMatrix) else []
        i, j = (*at, 1)[:2]
        if len(at) == 1 and len(rows) == 1 and len(rows[0]) >= i > 1:
            i, j = 1, i
        rows += [[] for _ in range(i - len(rows))]
        width = max(j, *(len(row) for row in rows))
        for row in rows:
            row += [ZERO] * (width - len(row))
        rows[i - 1][j - 1] = self._changed(rows[i - 1][j - 1], value, op, line)
        self.sheet.values[name] = FileMatrix(tuple(tuple(row) for row in rows))

    def _changed(self, old: Value, value: Value, op: str, line: Line) -> Value:
        if op == "+=":
            return plus(old, value, line)
        if op == "-=":
            return plus(old, times(as_expr(-1), value, line), line)
        if op == "*=":
            return times(old, value, line)
        return over(old, value, line) if op == "/=" else value

    def assign(self, given: str, value: Value, op: str, line: Line) -> None:
        """Executes name = value."""
        name = given.lower()
        self.sheet.shown.setdefault(name, given)
        if op in ("+=", "-=", "*=", "/=") and not name.startswith(("force_", "torque_")):
            value = self._changed(self.r.named(given, line, 1), value, op, line)
        if isinstance(value, Unread):
            symbol = self.sheet.symbols.get(name.rstrip("'"))
            if symbol is not None and not self.sheet.formed:
                self.sheet.outputs[symbol] = (value.why, line)
                self.sheet.values[name] = value
            self.sheet.values.setdefault(name, value)
        elif name.endswith(">>"):
            self._dyadic(name, value, line)
        elif name.endswith(">"):
            self._vector(name[:-1], value, op, line)
        elif name.endswith("'"):
            self._derivative(name, value, line)
        elif isinstance(value, FileMatrix):
            self._matrix(name, value, line)
        else:
            self._scalar(name, value, line)

    def _dyadic(self, name: str, value: Value, line: Line) -> None:
        if isinstance(value, Dyad) and name.startswith("i_"):
            for a, b in splits(name[2:-2]):
                if a in self.sheet.bodies and b in self.sheet.points:
                    self.sheet.inertias[a] = (value, b, line)
                    return
        self.sheet.values[name] = value

    def _vector(self, name: str, value: Value, op: str, line: Line) -> None:
        s = self.sheet
        vector = value if isinstance(value, Vec) else Vec() if value is ZERO else None
        if vector is None:
            raise line.refuse(f"a vector for {name}>", "another value", "Multiply it by a unit vector, as N1>.")
        head, _, rest = name.partition("_")
        pair = s.pair(head, rest)
        if pair is not None:
            s.place(head, *pair, vector, line)
        elif head in ("force", "torque") and rest:
            self._load(head, rest, vector, op, line)
        else:
            s.values[f"{name}>"] = vector

    def _load(self, kind: str, on: str, vector: Vec, op: str, line: Line) -> None:
        s = self.sheet
        known, loads = (s.points, s.forces) if kind == "force" else (s.frames, s.torques)
        if on not in known:
            what = "point" if kind == "force" else "frame"
            raise line.refuse(f"{kind.capitalize()}_ with the name of a {what}", on, alike(on, known).strip())
        if op != "+=":
            loads[:] = [x for x in loads if x[0] != on]
        loads.append((on, vector, line))

    def _derivative(self, name: str, value: Value, line: Line) -> None:
        base, primes = name.rstrip("'"), len(name) - len(name.rstrip("'"))
        symbol = self.sheet.symbols.get(base)
        if symbol is None or not isinstance(value, Expr):
            got = "no such variable" if symbol is None else "another value"
            raise line.refuse(f"a variable {base} declared with {primes} prime(s), and a scalar", got)
        if primes == 1 and isinstance(symbol, Coordinate):
            self.sheet.kinematic[rate(symbol)] = self.sheet.by_speeds(value)
        elif isinstance(symbol, Input):
            held: Expr = symbol
            for _ in range(primes):
                held = rate(held) if isinstance(held, Symbol) else time_derivative(held)
            self.sheet.late[held] = value
        elif not self.sheet.formed and isinstance(symbol, Speed):
            cure = "Declare a prescribed motion as Specified."
            raise line.refuse(f"no equation for {name} before those of motion are formed", "one", cure)

    def _matrix(self, name: str, value: FileMatrix, line: Line) -> None:
        for a, b in splits(name):
            if a in self.sheet.frames and b in self.sheet.frames and len(value.rows) == 3 == len(value.rows[0]):
                rows = tuple(tuple(x for x in row if isinstance(x, Expr)) for row in value.rows)
                self.sheet.orient(FileTurn(a, b, rows))
                return
        self.sheet.values[name] = value

    def _scalar(self, name: str, value: Value, line: Line) -> None:
        symbol = self.sheet.symbols.get(name)
        if isinstance(value, Expr) and isinstance(symbol, Input | Parameter) and symbol is not value:
            self.sheet.late[symbol] = value
            if name in self.sheet.given:  # its derivatives may be assigned too
                return
        self.sheet.values[name] = value


def _only(tree: Any, line: Line) -> str:
    """The name of which an expression consists."""
    names = list(tokens(tree))
    if len(names) != 1:
        raise line.refuse("a name", "an expression")
    return str(names[0])


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
    # lines after the first that ends the program, such as Quit, are ignored and may be invalid
    heard = takewhile(lambda line: line.text.lower() not in _ENDS, lines_of(text))
    lines = [x for line in heard for x in _unfolded(line, folder, _MACROS)]
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
