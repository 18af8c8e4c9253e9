# SPDX-License-Identifier: BSD-3-Clause
"""Every public class has a form in a notebook, and every result of three systems one that is well formed."""

from __future__ import annotations

import inspect
import pickle
import re
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import cache
from typing import Any

import pytest
from lxml import etree

import kane as kn
from kane.gallery import load

WITHOUT = {
    "ContactMode": "an IntEnum: it prints as its name",
}
"""Public classes without a form in notebooks, and why."""
FAMILIES = (
    *("analysis", "attitude", "beams", "cycles", "exchange", "expr"),
    *("figures", "fitting", "integrators", "joints", "loads", "solids"),
)


def every_class() -> dict[str, type]:
    families = (kn, *(getattr(kn, name) for name in FAMILIES))
    found = {n: getattr(family, n) for family in families for n in dir(family) if not n.startswith("_")}
    own = {n: c for n, c in found.items() if inspect.isclass(c) and c.__module__.startswith("kane.")}
    return {n: c for n, c in own.items() if not issubclass(c, BaseException)}


def test_every_public_class_has_a_form() -> None:
    bare = {n for n, c in every_class().items() if not (hasattr(c, "_repr_html_") or hasattr(c, "_repr_latex_"))}
    assert bare == set(WITHOUT)


def balanced(latex: str) -> None:
    bare = re.sub(r"\\[\\{}$%#&_]", "", latex)
    depth = 0
    for sign in bare:
        depth += (sign == "{") - (sign == "}")
        assert depth >= 0, latex
    assert depth == 0, latex
    assert bare.count(r"\left") == bare.count(r"\right"), latex
    assert bare.count(r"\begin") == bare.count(r"\end"), latex


def well_formed(name: str, html: str) -> None:
    page = re.sub(r"&(?!amp;|lt;|gt;|quot;|#)\w+;", "", html)
    page = re.sub(r"<(br|img|hr|meta|link)([^>]*[^/])?>", r"<\1\2/>", page)
    root = etree.fromstring(f"<div>{page}</div>")
    text = " ".join(root.itertext())
    assert "Not shown:" not in text, f"{name}: {text}"
    for formula in re.findall(r"\$([^$]+)\$", text):
        balanced(formula)


@cache
def rolling() -> dict[str, Any]:
    """A system with a reaction and friction, and what it is made of."""
    eom = kn.derive(load("rolling_disk").system())
    system = eom.system
    frame, point, body = system.frames[-1], system.points[-1], system.bodies[0]
    first, second = system.points[:2]
    held = kn.distance(first, second, 1)
    assert isinstance(body, kn.RigidBody)
    return {
        **{"eom": eom, "system": system, "frame": frame, "root": system.inertial, "point": point, "body": body},
        **{"load": system.loads[0], "gravity": system.gravities[0], "constraint": held, "inertia": body.inertia},
        **{"reaction": eom.reactions[0], "operations": eom.operations, "settings": kn.Settings()},
        **{"guess": kn.guess(0.1), "signal": kn.signal([0, 1, 2], [0, 1, 0]), "step": kn.integrators.Dop853()},
        **{
            "rotation": kn.attitude.Rotation.from_axis_angle([0, 0, 1], 0.3),
            "event": kn.Event("e", system.coordinates[0]),
        },
    }


@cache
def swinging() -> dict[str, Any]:
    """A system with motions, linearized, solved for rest, by other methods."""
    eom = kn.derive(load("double_pendulum").system())
    rest = kn.equilibrium(eom, q=[kn.guess(0.1), kn.guess(0.0)])
    linear = kn.linearize(eom, rest)
    sol = kn.simulate(eom, (0, 0.2), q=[0.1, 0.2], u=[0.0, 0.0], samples=9)
    return {
        **{"eom": eom, "system": eom.system, "equilibrium": rest, "linear": linear, "mode": linear.modes[0]},
        **{"second order": linear.second_order(), "normal modes": kn.analysis.normal_modes(linear), "solution": sol},
        **{
            "symbolic": kn.analysis.linearize_symbolic(eom, dict.fromkeys(eom.state, 0)),
            "lagrange": eom.by("lagrange"),
        },
        **{"methods": kn.analysis.compare_methods(eom, ["kane", "lagrange"]), "jacobian": eom.jacobian()},
        **{"compiled": eom.compile(), "sketch": kn.figures.sketch(eom.system), "scene": kn.figures.scene(eom.system)},
        **{"regressor": kn.fitting.regressor(eom), "forces": eom.inertia_forces[eom.system.bodies[0]]},
    }


@cache
def closed() -> dict[str, Any]:
    """A system with constraints and joints."""
    eom = kn.derive(load("slider_crank").system())
    found = kn.assemble(eom, q=[kn.guess(0.3)] * len(eom.coordinates))
    return {"eom": eom, "system": eom.system, "assembled": found, "state": found.state, "motions": eom.system}


def attributes(thing: Any) -> Iterator[tuple[str, Any]]:
    """What is read off a thing and is of a type of this library; of sliding friction there is no equilibrium."""
    for name in dir(thing):
        with suppress(kn.ModelError):
            value = None if name.startswith("_") else getattr(thing, name)
            kind = type(value)
            if kind.__module__.startswith("kane.") and kind.__name__ not in INNER:
                yield name, value


INNER = {"Derived", "Solved", "Speeds", "Kinematics", "ConstraintRows", "Blocks", "Embedding", "Program"}
"""Records that derivation hands on; what is in them is read off the equations."""


@pytest.mark.parametrize("made", [rolling, swinging, closed])
def test_every_result_is_well_formed(made: Callable[[], dict[str, Any]]) -> None:
    things = made()
    eom = things["eom"]
    every = [*things.items(), *(x for thing in (eom, eom.system, things.get("solution")) for x in attributes(thing))]
    assert {"accelerations", "Fr", "rates", "velocities", "coordinates", "bodies", "loads"} <= {
        name for name, _ in every
    }
    for name, thing in every:
        html, latex = (getattr(thing, form, lambda: None)() for form in ("_repr_html_", "_repr_latex_"))
        assert html or latex, f"{name}, a {type(thing).__name__}, has no form"
        if html:
            well_formed(name, html)
        if latex:
            balanced(latex)


def test_equations_begin_with_accelerations() -> None:
    html = swinging()["eom"]._repr_html_()
    assert html.index(r"\dot{u}_{1} = ") < html.index("M = ")


def test_tuples_of_expressions_print_as_equations() -> None:
    force = swinging()["eom"].Fr
    assert str(force).splitlines()[1] == f"F_u2 = {force[1]}"
    assert repr(pickle.loads(pickle.dumps(force))) == repr(force)
    latex = force._repr_latex_()
    assert latex is not None
    assert rf"F_{{u_{{2}}}} = {kn.to_latex(force[1])}" in latex
