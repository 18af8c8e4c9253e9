# SPDX-License-Identifier: BSD-3-Clause
"""The functions of Autolev that occur in expressions, in a table by name."""

from collections.abc import Callable, Sequence
from typing import Any

from kane import expect
from kane.errors import alike
from kane.expr import operators as ops
from kane.expr.differentiation import affine, diff
from kane.expr.evaluation import free_symbols
from kane.expr.matrix import solve_linear
from kane.expr.node import ONE, ZERO, Expr, as_expr, constant_value, pi
from kane.expr.symbols import Symbol
from kane.expr.visit import substituted
from kane.interop.autolev.evaluate import Call, FileReading, plus, quantity
from kane.interop.autolev.grammar import Line, bare
from kane.interop.autolev.sheet import Sheet
from kane.interop.autolev.values import Dyad, FileMatrix, Rows, Unread, Value, Vec, along, transposed

_PLAIN: dict[str, Callable[..., Expr]] = {
    "tanh": ops.tanh, "sinh": ops.sinh, "cosh": ops.cosh, "acos": ops.acos, "asin": ops.asin, "atan": ops.atan,
    "exp": ops.exp, "log": ops.log, "ln": ops.log, "sqrt": ops.sqrt, "abs": ops.abs, "sign": ops.sign,
    "sqr": lambda x: x * x, "log10": lambda x: ops.log(x) / ops.log(as_expr(10)),
}  # fmt: skip
_OF_TWO: dict[str, Callable[..., Expr]] = {"atan2": ops.atan2, "max": ops.max, "min": ops.min}
_TURNING: dict[str, Callable[[Expr], Expr]] = {"sin": ops.sin, "cos": ops.cos, "tan": ops.tan}
_DEGREE = pi / 180
_PLAIN |= {f"{name}degrees": lambda x, f=f: f(x * _DEGREE) for name, f in _TURNING.items()}
_PLAIN |= {f"{name}degrees": lambda x, f=_PLAIN[name]: f(x) / _DEGREE for name in ("asin", "acos", "atan")}
_SAME = (
    "expand factor explicit arrange factorlinear factorquadratic rhs fulldot simplify "
    "collect combine decompose zee simplifysqrt"
)
_OUTPUTS = (
    "fr frstar ke pe momentum angmom taylor coef getcoefficient include exclude polynomial roots eig diagmat partials "
    "nicheck round int ceil floor factorial inertia laplace evaluateatinput linearize rows cols fstar evaluatetonumber "
    "evaluatenumber evaluateinput getstateequations constraintforces getlinearunits conserved power work kane lagrange "
    "jacobian"
)


def expression(tree: Any) -> Any:
    """The expression of an argument."""
    return tree.children[0]


def _plain(function: Callable[..., Expr], count: int = 1, *, turns: bool = False) -> Call:
    """A function of `count` scalars, or of each element of a matrix; functions of an angle take constants in degrees."""

    def call(r: FileReading, args: Sequence[Any], line: Line) -> Value:
        if len(args) != count:
            raise line.refuse(f"{count} argument{'s' * (count > 1)}", len(args) or "none")
        values = [r.value(expression(a), line) for a in args]
        unread = next((x for x in values if isinstance(x, Unread)), None)
        if unread is not None:
            return unread
        if count == 1 and isinstance(values[0], FileMatrix) and not (turns and len(values[0].flat()) == 1):
            return values[0].map(lambda x: function(_radians(r, x, line) if turns else x))
        numbers = [r.scalar(expression(a), line) for a in args]
        return function(*(_radians(r, x, line) if turns else x for x in numbers))

    return call


def _radians(r: FileReading, angle: Any, line: Line) -> Any:
    if not r.sheet.degrees or r.sheet.genesis or constant_value(angle) in (None, 0):
        return angle
    r.sheet.remarks.say("inferred", f"{constant_value(angle)} is an angle in degrees (Degrees on)", line.where)
    return angle * _DEGREE


def _same(r: FileReading, args: Sequence[Any], line: Line) -> Value:
    return quantity(r, args[0].children[0], None, line)


def output(name: str) -> Call:
    """A call whose result is an output, not part of the model."""
    return lambda r, args, line: Unread(f"what {name}(…) gives")


def _dot(r: FileReading, args: Sequence[Any], line: Line) -> Value:
    a, b = (r.value(expression(x), line) for x in _two(args, line))
    if isinstance(a, FileMatrix) or isinstance(b, FileMatrix):
        table, other = (a, b) if isinstance(a, FileMatrix) else (b, a)
        assert isinstance(table, FileMatrix)
        return table.map(lambda x: _dotted(r, x, other, line))
    return _dotted(r, a, b, line)


def _dotted(r: FileReading, a: Value, b: Value, line: Line) -> Value:
    for x in (a, b):
        if isinstance(x, Unread):
            return x
    if isinstance(a, Dyad) and isinstance(b, Vec):
        return r.sheet.apply(a, b)
    if isinstance(b, Dyad) and isinstance(a, Vec):
        return r.sheet.apply(Dyad(tuple((y, x) for x, y in b.terms), b.unit), a)
    if isinstance(a, Vec) and isinstance(b, Vec):
        return r.sheet.dot(a, b)
    raise line.refuse("two vectors, or a dyadic and a vector, in Dot", "others")


def _cross(r: FileReading, args: Sequence[Any], line: Line) -> Value:
    a, b = _two(args, line)
    for x in (a, b):
        value = r.value(expression(x), line)
        if isinstance(value, Unread):
            return value
    return r.sheet.cross(r.vector(expression(a), line), r.vector(expression(b), line))


def _two(args: Sequence[Any], line: Line) -> tuple[Any, Any]:
    if len(args) > 2:
        raise line.refuse("2 arguments", len(args))
    return args[0], args[1]


def frame_of(r: FileReading, tree: Any, line: Line) -> str:
    """The frame or body that an argument names."""
    name = word(tree, line)
    if name not in r.sheet.frames:
        raise line.refuse("the name of a frame or body", name, alike(name, r.sheet.frames.values()).strip())
    return name


def point_of(r: FileReading, tree: Any, line: Line) -> str:
    """The point or particle that an argument names."""
    name = word(tree, line)
    if name not in r.sheet.points:
        raise line.refuse("the name of a point", name, alike(name, r.sheet.points.values()).strip())
    return name


def word(tree: Any, line: Line) -> str:
    """The name of which an argument consists."""
    tree = bare(tree)
    if tree.data != "name":
        raise line.refuse("a name", "an expression")
    return str(tree.children[0]).lower()


def pair_of(tree: Any, line: Line) -> tuple[str, str]:
    """Two names separated by “/”, or one name and ""."""
    tree = bare(tree)
    if tree.data == "term" and len(tree.children) == 3 and tree.children[1] == "/":
        return word(tree.children[0], line), word(tree.children[2], line)
    return word(tree, line), ""


def _dt(r: FileReading, args: Sequence[Any], line: Line) -> Value:
    return derived(r, r.value(expression(args[0]), line), args[1:], line)


def derived(r: FileReading, value: Value, args: Sequence[Any], line: Line) -> Value:
    """The time derivative, for a vector in a frame."""
    if isinstance(value, Unread):
        return value
    if isinstance(value, Expr):
        return r.sheet.rate(value)
    if isinstance(value, FileMatrix):
        return value.map(lambda x: derived(r, x, args, line))
    if isinstance(value, Vec) and args:
        return r.sheet.dt(value, frame_of(r, args[0], line))
    raise line.refuse("Dt(vector>, frame)", "no frame")


def _express(r: FileReading, args: Sequence[Any], line: Line) -> Value:
    value = r.value(expression(args[0]), line)
    return r.sheet.express(value, frame_of(r, args[1], line)) if isinstance(value, Vec) else value


def _angle(r: FileReading, args: Sequence[Any], line: Line) -> Value:
    return ops.acos(r.sheet.dot(r.vector(expression(args[0]), line), r.vector(expression(args[1]), line)))


def _unitvec(r: FileReading, args: Sequence[Any], line: Line) -> Value:
    v = r.vector(expression(args[0]), line)
    return v.times(ONE / r.sheet.magnitude(v))


def _vector(r: FileReading, args: Sequence[Any], line: Line) -> Value:
    frame = frame_of(r, args[0], line)
    values = [r.value(expression(a), line) for a in args[1:]]
    if len(values) == 1 and isinstance(values[0], FileMatrix):
        values = list(values[0].flat())
    if len(values) != 3 or not all(isinstance(x, Expr) for x in values):
        raise line.refuse("three scalars in Vector(frame, x, y, z)", len(values))
    return along(frame, (x for x in values if isinstance(x, Expr)))


def _matrix(r: FileReading, args: Sequence[Any], line: Line) -> Value:
    frame, value = frame_of(r, args[0], line), r.value(expression(args[1]), line)
    if isinstance(value, Vec):
        return FileMatrix(tuple((x,) for x in r.sheet.components(value, frame)))
    return value if isinstance(value, Unread) else Unread("the matrix of a dyadic")


def _table(r: FileReading, tree: Any, line: Line) -> FileMatrix | Unread:
    value = r.value(expression(tree), line)
    if not isinstance(value, FileMatrix | Unread):
        raise line.refuse("a matrix", "another value")
    return value


def _transpose(r: FileReading, args: Sequence[Any], line: Line) -> Value:
    table = _table(r, args[0], line)
    return table if isinstance(table, Unread) else FileMatrix(tuple(zip(*table.rows, strict=True)))


def _inv(r: FileReading, args: Sequence[Any], line: Line) -> Value:
    table = _table(r, args[0], line)
    if isinstance(table, Unread):
        return table
    rows, n = scalars(table, line), len(table.rows)
    if n > 12 or any(len(row) != n for row in rows):
        raise line.refuse("a square matrix of at most 12 rows to invert", f"{n} rows")
    columns = [solve_linear(rows, [ONE if i == j else ZERO for i in range(n)]) for j in range(n)]
    return FileMatrix(transposed(tuple(columns)))


def _trace(r: FileReading, args: Sequence[Any], line: Line) -> Value:
    table = _table(r, args[0], line)
    if isinstance(table, Unread):
        return table
    value: Value = ZERO
    for k, row in enumerate(table.rows):
        value = plus(value, row[k], line) if k < len(row) else value
    return value


def _element(r: FileReading, args: Sequence[Any], line: Line) -> Value:
    table = _table(r, args[0], line)
    if isinstance(table, Unread):
        return table
    i, j = r.number(expression(args[1]), line), r.number(expression(args[2]), line)
    if not (0 < i <= len(table.rows) and 0 < j <= len(table.rows[0])):
        raise line.refuse("an element that the matrix has", f"[{i}, {j}]")
    return table.rows[i - 1][j - 1]


def scalars(table: FileMatrix, line: Line) -> Rows:
    """The elements of a matrix of scalars."""
    if not all(isinstance(x, Expr) for x in table.flat()):
        raise line.refuse("a matrix of scalars", "one of other values")
    return tuple(tuple(x for x in row if isinstance(x, Expr)) for row in table.rows)


def _d(r: FileReading, args: Sequence[Any], line: Line) -> Value:
    value, by = r.value(expression(args[0]), line), r.value(expression(args[1]), line)
    if len(args) == 2 and isinstance(value, Expr) and isinstance(by, Symbol):
        return diff(value, by)
    return Unread("what D(…) gives")


def _evaluate(r: FileReading, args: Sequence[Any], line: Line) -> Value:
    value = r.value(expression(args[0]), line)
    changes: dict[Expr, Expr] = {}
    for a in args[1:]:
        if a.data == "named":
            changes[r.scalar(a.children[0], line)] = r.scalar(a.children[2], line)
    if isinstance(value, Expr):
        return substituted(value, changes)
    return value if isinstance(value, Unread) else Unread("what Evaluate(…) gives")


def solve(sheet: Sheet, equations: Sequence[Expr], unknown: Sequence[Expr], line: Line) -> tuple[Expr, ...]:
    """The solution of linear equations, given as expressions that vanish."""
    if len(equations) != len(unknown):
        raise line.refuse(f"as many equations as unknowns, {len(unknown)}", len(equations))
    rows, right = [], []
    for e in equations:
        held = set(free_symbols([e]))
        if not any(u in held for u in unknown):
            raise line.refuse("equations that hold an unknown", "one that holds none")
        coefficients, rest = affine(e, unknown)
        rows.append([coefficients.get(u, ZERO) for u in unknown])
        right.append(-rest)
    return solve_linear(rows, right)


FUNCTIONS: dict[str, Call] = {
    **{name: _plain(f) for name, f in _PLAIN.items()},
    **{name: _plain(f, turns=True) for name, f in _TURNING.items()},
    **{name: _plain(f, 2) for name, f in _OF_TWO.items()},
    **dict.fromkeys(_SAME.split(), _same),
    **{name: output(name) for name in _OUTPUTS.split()},
    "dot": _dot, "cross": _cross, "dt": _dt, "express": _express,
    **dict.fromkeys(("mag", "getmagnitude"), lambda r, args, line: r.sheet.magnitude(r.vector(expression(args[0]), line))),
    "getanglebetweenunitvectors": _angle,
    "unitvec": _unitvec, "getunitvector": _unitvec, "vector": _vector, "matrix": _matrix, "getmatrix": _matrix,
    "transpose": _transpose, "gettranspose": _transpose, "inv": _inv, "trace": _trace, "element": _element, "d": _d,
    "evaluate": _evaluate, "replace": _evaluate,
    "dtdt": lambda r, args, line: derived(r, derived(r, r.value(expression(args[0]), line), args[1:], line), args[1:], line),
    "mass": lambda r, args, line: mass(r.sheet, [word(a, line) for a in args]),
    "cm": lambda r, args, line: center(r.sheet, point_of(r, args[0], line), [word(a, line) for a in args[1:]]),
    "det": output("det"), "solve": output("solve"),
}  # fmt: skip
"""The implementation of each function."""


def mass(sheet: Sheet, names: Sequence[str]) -> Expr:
    """The total mass of the named bodies and particles, or of all if none is named."""
    expect.none([sheet.say(x) for x in names if x not in sheet.masses], "bodies and particles that have a mass")
    return sum((sheet.masses[name] for name in names or sheet.masses), start=ZERO)


def center(sheet: Sheet, origin: str, names: Sequence[str]) -> Vec:
    """The position of the mass centre of the named bodies and particles, or of all if none is named."""
    whole, listed = mass(sheet, names), names or sheet.masses
    moments = (sheet.position(origin, sheet.bodies.get(n, n)).times(sheet.masses[n]) for n in listed)
    return sum(moments, start=Vec()).times(ONE / whole)
