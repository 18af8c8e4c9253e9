# SPDX-License-Identifier: BSD-3-Clause
"""A system as a Python file that declares it: symbols, frames and points, bodies, constraints, loads, then `kn.System(…)`.

Executing the file gives the same equations, with the same operations; names, units, defaults and descriptions are kept. Points and
frames are written in the order of the tree, joints as calls of the functions that made them.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from kane import expect
from kane.equations.state import Guess
from kane.errors import ModelError, cut
from kane.expr.node import Expr
from kane.expr.symbols import Input, Parameter, Reaction, StateVariable, Symbol
from kane.interop.python_source.contacts import Group, Made, OfSpeed, groups, law_call, new_points, place_call
from kane.interop.python_source.expressions import (
    INDENT,
    Expressions,
    ObjectNames,
    call,
    folded,
    listed,
    literal,
    same,
    shared_among,
    wrapped,
)
from kane.interop.python_source.makers import friction_call, joint_call, pair_of, solid_call
from kane.model.bodies import Particle, RigidBody
from kane.model.constraints import Constraint, Cut
from kane.model.contacts import ContactLaw
from kane.model.declarations import Event
from kane.model.joints.contact import Contact
from kane.model.joints.joint import Joint
from kane.model.loads import Load
from kane.model.system import System
from kane.numeric.sampling import finite_number
from kane.space.frame import Frame, Point
from kane.space.vector import Dyadic, Vector


def to_python(
    system: System,
    *,
    title: str = "",
    start: Mapping[str, Mapping[str, Any]] | None = None,
    span: tuple[float, float] | None = None,
    remarks: Iterable[str] = (),
) -> str:
    """Return the text of a Python file with `system()`, which returns the system, and `START`, start values of motions.

    Parameters
    ----------
    system : the system
    title : a one-line description
    start : numbers and guesses by name under "q", "u", "parameters", …, as in `kane simulate`
    span : start and end time of motions, which become `SPAN`
    remarks : lines of a comment at the head of the file, such as the remarks of an import

    Raises
    ------
    ModelError
        if the system contains objects that cannot be written: beams, Python functions as actions, ropes around drums
    SimulationError
        if a start value is not a finite number
    """
    expect.instance(system, System, "a System to write as Python")
    first = _Writer(system, ())
    lines = _Writer(system, shared_among(first.lines_and_asked()[1])).lines_and_asked()[0]
    head = [_docstring(f"{(title or 'A system').rstrip('.')}."), ""]
    head += [f"# {line}" for remark in remarks for line in wrapped(remark)] + ([""] if remarks else [])
    head += ["import kane as kn"]
    values = [f"{kind}={{{_values(told)}}}" for kind, told in (start or {}).items() if told]
    globals_ = [*([f"TITLE = {literal(title)}"] if title else []), *([call("START = dict", values)] if values else [])]
    times = () if span is None else expect.pair(span, "span= two times")
    globals_ += [f"SPAN = {tuple(finite_number('time', 'span', t) for t in times)}"] if times else []
    head += ["", *globals_] if globals_ else []
    body = [f"{INDENT}{line}" if line else "" for line in "\n".join(map(folded, lines)).split("\n")]
    return "\n".join([*head, "", "", "def system() -> kn.System:", f'{INDENT}"""The system."""', *body, ""])


def _docstring(text: str) -> str:
    plain = text.isprintable() and "\\" not in text and '"""' not in text
    return f'"""{text}"""' if plain else literal(text)


def _values(told: Mapping[Any, Any]) -> str:
    """The entries of a dict of start values by name."""
    named = {str(getattr(s, "name", s)): x for s, x in told.items()}
    return ", ".join(f"{literal(name)}: {_value(name, x)}" for name, x in named.items())


def _value(name: str, x: Any) -> str:
    return f"kn.guess({x.value!r})" if isinstance(x, Guess) else repr(finite_number("start value", name, x))


class _Writer:
    """Writes the body of `system()`; objects are written on first use."""

    def __init__(self, system: System, shared: Iterable[Expr]) -> None:
        self.system = system
        self.names = ObjectNames()
        self.lines: list[str] = []
        self.text = Expressions(self.names, self._assign, shared, self._make_owner)
        self._made = {id(x): j for j in system.joints for x in (j.point, *_turned_by(j))}
        places = (c.place for c in system.contacts if c.place is not None)
        self._touching = {id(p): place for place in places for p, _ in new_points(place)}

    def lines_and_asked(self) -> tuple[list[str], list[Expr]]:
        """The lines, and the expressions in them."""
        _refuse(self.system)
        kinds = (self._symbols, self._places, self._constraints, self._bodies, self._contacts, self._loads, self._whole)
        for write in kinds:
            write()
        return self.lines, self.text.asked

    def _assign(self, name: str, text: str) -> None:
        self.lines.append(f"{name} = {text}")

    def _paragraph(self) -> None:
        if self.lines and self.lines[-1]:
            self.lines.append("")

    # Symbols --------------------------------------------------------------------------------------------------------

    def _symbols(self) -> None:
        system = self.system
        named = {s for j in system.joints if self._by_name(j) for s in j.named}
        kinds: tuple[tuple[str, Iterable[Symbol]], ...] = (
            ("coordinate", system.coordinates),
            ("speed", system.speeds),
            ("parameter", system.parameters),
            ("input", (s for s in system.inputs if isinstance(s, Input))),
            ("state", system.states),
        )
        self._assign(
            self.names.give(system.inertial, system.inertial.name, "frame"),
            call("kn.Frame", [literal(system.inertial.name)]),
        )
        for kind, symbols in kinds:
            for s in symbols:
                if s not in named:
                    self._declare(s, kind)

    def _declare(self, s: Symbol, kind: str) -> None:
        default = [] if s.default is None else [repr(float(s.default))]
        said = [literal(s.unit), literal(s.description)] if s.description else [literal(s.unit)] if s.unit else []
        if isinstance(s, Parameter | StateVariable) and not default and said:
            said[0] = f"unit={said[0]}"
            said[1:] = [f"description={x}" for x in said[1:]]
        self._assign(self.names.give(s, s.name, kind), call(f"kn.{kind}", [literal(s.name), *default, *said]))

    def _by_name(self, j: Joint) -> bool:
        """Whether a joint makes its coordinates and speeds itself."""
        return bool(j.coordinates) and j.named >= {*j.coordinates, *j.speeds}

    # Frames, points, joints -----------------------------------------------------------------------------------------

    def _places(self) -> None:
        self._paragraph()
        for frame in self.system.frames:
            self.frame(frame)
        for point in self.system.points:
            self.point(point)

    def frame(self, frame: Frame) -> str:
        """The name of a frame, which is written first if necessary."""
        line = [frame]
        while line[-1] not in self.names and line[-1].parent is not None:
            line.append(line[-1].parent)
        for f in reversed(line):
            if f not in self.names:
                self._make_frame(f)
        return self.names[frame]

    def _make_frame(self, f: Frame) -> None:
        if id(f) in self._made:
            self._make_joint(self._made[id(f)])
            return
        text = self._birth(f)
        self._assign(self.names.give(f, f.name, "frame"), text)
        self._know_quasi(f)

    def _birth(self, f: Frame) -> str:
        o, parent = f.orientation, f.parent
        if o is None or parent is None:
            raise ModelError(f"Expected one inertial frame, got the root {f.name} beside it.")
        base = self.names[parent]
        if o.parameters:
            return call(f"{base}.rotate_euler_parameters", [literal(f.name), _tuple(map(self.text, o.parameters))])
        if o.angle is not None and o.axis is not None:
            before = parent.orientation
            merged = before is not None and before.base is o.base and before.axis == o.axis and o.base is not parent
            angle = o.angle - before.angle if merged and before is not None and before.angle is not None else o.angle
            return call(f"{base}.rotate", [literal(f.name), self.text(angle), f"{base}.{'xyz'[o.axis]}"])
        if o.angle is not None and o.direction is not None:
            axis = self.text.vector(Vector(((parent, o.direction),)))
            return call(f"{base}.rotate", [literal(f.name), self.text(o.angle), axis])
        assert o.cosines is not None
        rows = [f"({', '.join(self.text(x) for x in row)})" for row in o.cosines]
        return call(f"{base}.rotate_matrix", [literal(f.name), f"({', '.join(rows)})"])

    def _know_quasi(self, f: Frame) -> None:
        o = f.orientation
        if o is None or not o.quasi or f.parent is None:
            return
        of = f"{self.names[f]}.angular_velocity({self.names[f.parent]})"
        for s, axis in zip(o.quasi, "xyz", strict=True):
            self.text.quasi[s] = f"{of}.dot({self.names[f]}.{axis})"

    def _make_owner(self, s: Symbol) -> None:
        """Writes the joint that makes a symbol; objects that rotate with a joint, such as a rotor, may precede it."""
        owner = next((j for j in self.system.joints if s in j.named and j not in self.names), None)
        if owner is not None:
            self._make_joint(owner)

    def _make_joint(self, j: Joint) -> None:
        at, parent = self.point(j.at), self.frame(j.parent)
        name = self.names.give(j, j.name, "joint")
        function, arguments = joint_call(j, self.text, self._by_name(j), self.names)
        child = [] if j.frame.name == j.name else [f"child={literal(j.frame.name)}"]
        self._assign(name, call(f"kn.{function}", [literal(j.name), at, parent, *arguments, *child]))
        for k, turned in enumerate(_turned_by(j)):
            self.names.alias(turned, f"{name}.frame{k * '.parent'}")
        self.names.alias(j.point, f"{name}.point")
        if self._by_name(j):
            for symbols, what in ((j.coordinates, "coordinates"), (tuple(j.speeds), "speeds")):
                given = [self.names.give(s, s.name, what[:-1]) for s in symbols]
                self.lines.append(f"{_tuple(given) if len(given) == 1 else ', '.join(given)} = {name}.{what}")
        self._know_quasi(j.frame)

    def point(self, point: Point) -> str:
        """The name of a point, which is written first if necessary."""
        line, others = [point], {*self._made, *self._touching}
        while line[-1] not in self.names and line[-1].parent is not None and id(line[-1]) not in others:
            line.append(line[-1].parent)
        for p in reversed(line):
            if p not in self.names:
                self._make_point(p)
        return self.names[point]

    def _make_point(self, p: Point) -> None:
        if id(p) in self._made:
            self._make_joint(self._made[id(p)])
            return
        if id(p) in self._touching:
            self._place(self._touching[id(p)])
            return
        if p.parent is None:
            text = call("kn.Point", [literal(p.name), f"fixed_in={self.frame(p.frame)}"])
        else:
            offset = self.vector(p.offset) if p.offset.parts else ""
            body = [] if p.body is None else [self.frame(p.body)]
            function = f"{self.names[p.parent]}.{'at' if p.body is None else 'fixed_in'}"
            text = call(function, [*body, literal(p.name), *([offset] if offset else [] if body else ["0"])])
        self._assign(self.names.give(p, p.name, "point"), text)

    def vector(self, v: Vector) -> str:
        """A vector, whose frames are written first if necessary."""
        for f, _ in v.parts:
            assert isinstance(f, Frame)
            self.frame(f)
        return self.text.vector(v)

    # Constraints and reactions --------------------------------------------------------------------------------------

    def _constraints(self) -> None:
        self._paragraph()
        self.kinds: dict[str, list[str]] = {"configuration": [], "motion": []}
        for group in groups(self.system.constraints):
            name = self.names.give(group, group.name, "constraint")
            self._assign(name, self._group(group))
            single = group.single
            for k, c in enumerate(group.constraints):
                self.names.alias(c, name if single else f"{name}[{k}]")
            self.kinds[group.constraints[0].kind].append(name if single else f"*{name}")
        for s in (*self.system.reactions, *self.system.auxiliary_speeds):
            self._cut(s)

    def _group(self, group: Group) -> str:
        places = [self._argument(p) for p in group.places]
        arguments = [self.text(x) if isinstance(x, Expr) else self._directions(x) for x in group.arguments]
        keywords = [f"{key}={self._directions(vectors)}" for key, vectors in group.keywords.items()]
        if group.function == "Constraint":
            return self._record(group.constraints[0])
        return call(f"kn.{group.function}", [*group.first, *places, *arguments, *keywords, *group.named])

    def _directions(self, vectors: Sequence[Vector]) -> str:
        return self.vector(vectors[0]) if len(vectors) == 1 else _tuple(map(self.vector, vectors))

    def _record(self, c: Constraint) -> str:
        if c.branch is not None:
            raise _unwritten("constraint", c)
        own = [f"own={self.text(c.own)}"] if c.own.op.name != "const" else []
        unit = [f"unit={literal(c.unit)}"] if c.unit else []
        normal = [f"normal={self.vector(c.normal)}"] if c.normal is not None else []
        return call(
            "kn.Constraint",
            [literal(c.name), literal(c.kind), self.text(c.expr), *self._acting(c), *unit, *own, *normal],
        )

    def _acting(self, x: Load | Constraint) -> list[str]:
        forces = [f"({self.point(p)}, {self.vector(v)})" for p, v in x.forces]
        torques = [f"({self.frame(f)}, {self.vector(v)})" for f, v in x.torques]
        return [f"{key}={listed(items, '()')}" for key, items in (("forces", forces), ("torques", torques)) if items]

    def _cut(self, s: Symbol) -> None:
        function = "reaction" if isinstance(s, Reaction) else "auxiliary_speed"
        place, unit = s.place, []
        where: list[str] = []
        if isinstance(place, Cut):
            point = isinstance(place.at, Point)
            at = self._argument(place.at)
            where = [f"{'at' if point else 'frame'}={at}", f"along={self.vector(place.along)}"]
            unit = [] if s.unit in ("N" if point else "N*m", "m/s", "rad/s") else [f"unit={literal(s.unit)}"]
        elif isinstance(place, Constraint):
            where = [f"constraint={self.names[place]}"]
        elif s.unit:
            unit = [f"unit={literal(s.unit)}"]
        self._assign(self.names.give(s, s.name, "reaction"), call(f"kn.{function}", [literal(s.name), *where, *unit]))

    # Contacts -------------------------------------------------------------------------------------------------------

    def _contacts(self) -> None:
        self._paragraph()
        for c in self.system.contacts:
            if c.gap is None and c.normal_force is not None and c.normal_force not in self.names:
                self._cut(c.normal_force)
            made = law_call(c, self.system.joints)
            if made is None:
                raise _unwritten("contact", c)
            text = self._call(made, "kn" if made.function == "contact" else "kn.joints")
            name = self.names.give(c, c.name, "contact")
            self._assign(name, text)
            if c.normal_force is not None and c.normal_force not in self.names:
                self.names.alias(c.normal_force, f"{name}.normal_force")
            for k, force in enumerate(c.friction_forces):
                self.names.alias(force, f"{name}.friction_forces[{k}]")

    def _place(self, place: Contact) -> str:
        """The name of a contact, which is written first with its points if necessary."""
        if place not in self.names:
            text = self._call(place_call(place), "kn.joints")
            name = self.names.give(place, place.name, "place")
            self._assign(name, text)
            for point, own in new_points(place):
                self.names.alias(point, f"{name}.{own}")
        return self.names[place]

    def _call(self, made: Made, family: str) -> str:
        named = [f"{key}={self._argument(x)}" for key, x in made.named.items()]
        return call(f"{family}.{made.function}", [*map(self._argument, made.given), *named])

    def _argument(self, x: Any) -> str:
        return next((write(self, x) for kind, write in _ARGUMENTS if isinstance(x, kind)), literal(x))

    def _of_speed(self, x: OfSpeed) -> str:
        """The text of a coefficient function, without names of subexpressions, which would be assigned outside of it."""
        v = self.names.give(x.speed, "v", "slip")
        return f"lambda {v}: {Expressions(self.names, self._assign, (), self._make_owner)(x.size)}"

    # Bodies and loads -----------------------------------------------------------------------------------------------

    def _bodies(self) -> None:
        self._paragraph()
        for body in self.system.bodies:
            if isinstance(body, Particle):
                text = call("kn.Particle", [literal(body.name), self.point(body.point), self.text(body.mass)])
            elif isinstance(body, RigidBody):
                arguments = [f"frame={self.frame(body.frame)}", f"mass_center={self.point(body.mass_center)}"]
                arguments += [f"mass={self.text(body.mass)}", f"inertia={self._inertia(body)}"]
                text = call("kn.RigidBody", [literal(body.name), *arguments])
            self._assign(self.names.give(body, body.name, "body"), text)

    def _inertia(self, body: RigidBody) -> str:
        dyadic, frame = body.inertia, body.frame
        if solid := self._solid(dyadic, body.mass):
            return solid
        homes = {f for a, b in dyadic.dyads for v in (a, b) for f, _ in v.parts}
        home = next(iter(homes)) if len(homes) == 1 else frame
        assert isinstance(home, Frame)
        m = dyadic.components(home)
        products = [m[0, 1], m[1, 2], m[2, 0]]
        while products and products[-1].op.name == "const" and not float(products[-1]):
            products.pop()
        entries = [m[0, 0], m[1, 1], m[2, 2], *products]
        return f"kn.inertia({self.frame(home)}, {', '.join(self.text(x) for x in entries)})"

    def _solid(self, dyadic: Dyadic, mass: Expr) -> str:
        """The call of the function of `kn.solids` that makes an inertia, "" if none does."""
        made_by = solid_call(dyadic, mass)
        if made_by is None:
            return ""
        function, frame, values = made_by
        written = [self.vector(x) if isinstance(x, Vector) else self.text(x) for x in values.values()]
        return f"kn.solids.{function}({', '.join([self.frame(frame), *written])})"

    def _loads(self) -> None:
        self._paragraph()
        for load in self.system.gravities:
            named = [] if load.name == "gravity" else [f"name={literal(load.name)}"]
            text = call("kn.gravity", [self.vector(load.acceleration), *named])
            self._assign(self.names.give(load, load.name, "load"), text)
        for item in self.system.loads:
            self._assign(self.names.give(item, item.name, "load"), self._load(item))

    def _load(self, load: Load) -> str:
        if (rubs := friction_call(load)) is not None:
            against = [] if rubs.against is None else [f"against={self.point(rubs.against)}"]
            threshold = [] if rubs.threshold is None else [f"threshold={rubs.threshold!r}"]
            arguments = [self.point(rubs.point), self.names[rubs.normal], self.names[rubs.mu], *against, *threshold]
            return call("kn.friction", [*arguments, f"name={literal(load.name)}"])
        if load.potential is None and len(load.forces) + len(load.torques) == 1:
            acting: list[tuple[Point | Frame, Vector]] = [*load.forces, *load.torques]
            ((place, v),) = acting
            kind = "Force" if isinstance(place, Point) else "Torque"
            at = self._argument(place)
            named = [] if load.name == f"{kind.lower()} on {place.name}" else [f"name={literal(load.name)}"]
            return call(f"kn.{kind}", [at, self.vector(v), *named])
        if (pair := pair_of(load)) is not None:
            function, (on, v), (other, _) = pair
            places = [self._argument(x) for x in (on, other)]
            return call(f"kn.loads.{function}", [*places, self.vector(v), f"name={literal(load.name)}"])
        potential = [] if load.potential is None else [f"potential={self.text(load.potential)}"]
        return call("kn.loads.Load", [literal(load.name), *self._acting(load), *potential])

    # The system -----------------------------------------------------------------------------------------------------

    def _whole(self) -> None:
        system, names = self.system, self.names
        told = {u: e for j in system.joints for u, e in j.speeds.items()}
        own = same(told, system.speeds) and same(told.values(), system.speeds.values())
        speeds = [] if own else [f"{names[u]}: {self.text(e)}" for u, e in system.speeds.items()]
        states = [f"{names[s]}: {self.text(e)}" for s, e in system.states.items()]
        events = [self._event(e) for e in system.events]
        self._paragraph()
        rows: list[tuple[str, Sequence[str], str]] = [
            ("bodies", [names[b] for b in system.bodies], "[]"),
            ("joints", [names[j] for j in system.joints], "[]"),
            ("speeds", speeds, "{}"),
            ("loads", [names[x] for x in (*system.gravities, *system.loads)], "[]"),
            ("holonomic", self.kinds["configuration"], "[]"),
            ("nonholonomic", self.kinds["motion"], "[]"),
            ("reactions", [names[s] for s in system.reactions], "[]"),
            ("contacts", [names[c] for c in system.contacts], "[]"),
            ("auxiliary_speeds", [names[s] for s in system.auxiliary_speeds], "[]"),
            ("states", states, "{}"),
            ("events", events, "[]"),
            ("coordinates", [names[q] for q in system.coordinates] if len(system.coordinates) > 1 else [], "[]"),
            ("dependent_coordinates", [names[q] for q in system.dependent_coordinates], "[]"),
            ("dependent_speeds", [names[u] for u in system.dependent_speeds], "[]"),
        ]
        arguments = [f"{key}={listed(items, brackets)}" for key, items, brackets in rows if items or key == "bodies"]
        self.lines.append("return " + call("kn.System", [names[system.inertial], *arguments]))

    def _event(self, e: Event) -> str:
        keywords = {"threshold": e.threshold, "direction": int(e.direction), "message": e.message}
        said = [f"{k}={literal(v)}" for k, v in keywords.items() if v]
        if isinstance(e.then, Mapping):
            said.append(f"then={listed([f'{self.names[s]}: {self.text(x)}' for s, x in e.then.items()], '{}')}")
        if e.terminal != (e.then is None):
            said.append(f"terminal={e.terminal}")
        return call("kn.Event", [literal(e.name), self.text(e.quantity), *said])


_ARGUMENTS: tuple[tuple[Any, Callable[[_Writer, Any], str]], ...] = (
    (OfSpeed, _Writer._of_speed),
    (Expr, lambda own, x: own.text(x)),
    (Vector, _Writer.vector),
    (Point, _Writer.point),
    (Frame, _Writer.frame),
    (Contact, _Writer._place),
    (Constraint, _Writer._record),
    (Joint | ContactLaw, lambda own, x: own.names[x]),
    (tuple, lambda own, x: listed([own._argument(item) for item in x], "()")),
)
"""The text of call arguments, by type; others are literals."""


def _tuple(items: Iterable[str]) -> str:
    kept = list(items)
    return f"({', '.join(kept)}{',' if len(kept) == 1 else ''})"


def _refuse(system: System) -> None:
    """Raises ModelError for parts of a system that cannot be written."""
    checks: tuple[tuple[str, Iterable[Any], Callable[[Any], bool]], ...] = (
        ("body", system.bodies, lambda x: not isinstance(x, Particle | RigidBody)),
        ("load", system.loads, lambda x: x.slip is not None and friction_call(x) is None),
        ("event", system.events, lambda x: x.then is not None and not _is_of_expressions(x.then)),
    )
    for what, items, refused in checks:
        for item in items:
            if refused(item):
                raise _unwritten(what, item)


def _is_of_expressions(action: Any) -> bool:
    return isinstance(action, Mapping) and all(isinstance(x, Expr) for x in action.values())


def _unwritten(what: str, item: Any) -> ModelError:
    return ModelError(
        "Expected a system of rigid bodies and particles, joints, loads and constraints to write as Python, got the "
        f"{what} {item.name!r} ({cut(repr(item), 60)}), which only its source file can declare. Keep that file."
    )


def _turned_by(j: Joint) -> list[Frame]:
    """The frame of a joint and those between it and the parent."""
    frames, frame = [j.frame], j.frame.parent
    while frame is not None and frame is not j.parent:
        frames.append(frame)
        frame = frame.parent
    return frames
