# SPDX-License-Identifier: BSD-3-Clause
"""The same mechanisms in other units: lengths, masses and times a million times as large or as small decide alike."""

from __future__ import annotations

import warnings
from functools import cache

import numpy as np
import pytest

import kane as kn
from kane.gallery import GALLERY, load
from kane.units import parse

BIG, SMALL = 1e6, 1e-6
SCALES = [(BIG, 1, 1), (SMALL, 1, 1), (1, SMALL, BIG), (BIG, BIG, SMALL)]
"""How many of its units metre, kilogram and second become."""
HELD = [name for name in GALLERY if load(name).system().constraints]


def decided(name, monkeypatch, scale=(1, 1, 1), **options):
    """Dependent speeds, the number of redundant constraints, the route, and how much was said."""
    plain, (metre, kilogram, second) = kn.parameter, scale

    def parameter(symbol, default=None, unit="", *more):
        e = [float(x) for x in parse(unit).exponents] if unit else [0.0] * 3
        size = kilogram ** e[0] * metre ** e[1] * second ** e[2]
        return plain(symbol, None if default is None else default * size, unit, *more)

    with monkeypatch.context() as patched, warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        patched.setattr(kn, "parameter", parameter)
        eom = kn.derive(load(name).system(**options))
    return {u.name for u in eom.dependent_speeds}, len(eom.redundant), eom.solved.route, len(said)


@pytest.mark.slow
@pytest.mark.parametrize("name", HELD)
def test_dependent_speeds_and_rank_do_not_depend_on_units(name, monkeypatch):
    expected = decided(name, monkeypatch)
    for scale in SCALES:
        assert decided(name, monkeypatch, scale) == expected, scale


@pytest.mark.slow
def test_how_many_constraints_are_redundant_does_not_depend_on_units(monkeypatch):
    """Which one of them is left out may, and with it the dependent speeds and the route that is shortest for them."""
    (speeds, *counted, route, said) = decided("bricard", monkeypatch, redundant=True)
    for scale in SCALES:
        (found, *recounted, other, heard) = decided("bricard", monkeypatch, scale, redundant=True)
        assert (len(found), recounted, heard) == (len(speeds), counted, said), scale
        assert other == route or found != speeds, scale


# Motions and operating points with the same parameters in other units -----------------------------------------------------


def factor(unit, scale, per_second=0):
    """How many of the scaled units one of `unit`, over so many seconds, is."""
    e = [float(x) for x in parse(unit).exponents] if unit else [0.0] * 3
    metre, kilogram, second = scale
    return kilogram ** e[0] * metre ** e[1] * second ** (e[2] - per_second)


class InUnits:
    """A system of the gallery, and values of it in other units."""

    def __init__(self, name):
        self.module = load(name)
        self.eom = kn.derive(self.module.system())
        eom = self.eom
        self.units = {x.name: (x.unit, 0) for x in (*eom.coordinates, *eom.inputs, *eom.parameters)}
        for i, u in enumerate(eom.speeds):
            if u.unit:
                self.units[u.name] = (u.unit, 0)
            elif u.name.startswith("w"):  # of Euler parameters
                self.units[u.name] = ("rad", 1)
            else:
                own = [q for q in eom.coordinates if u.name == f"u_{q.name}"]
                self.units[u.name] = ((own or [eom.coordinates[i]])[0].unit, 1)

    def factors(self, symbols, scale):
        return np.array([factor(self.units[s.name][0], scale, self.units[s.name][1]) for s in symbols])

    def scaled(self, values, scale):
        """Numbers and guesses by name."""

        def one(name, value):
            unit, per_second = self.units[name]
            f = factor(unit, scale, per_second)
            return kn.guess(value.value * f) if hasattr(value, "value") else value * f

        return {name: one(name, v) for name, v in values.items()}

    def parameters(self, scale, **changed):
        return self.scaled({p.name: changed.get(p.name, p.default) for p in self.eom.parameters}, scale)

    def start(self):
        """Where the module starts, assembled; else some state."""
        eom, given = self.eom, getattr(self.module, "START", None)
        if given:
            found = kn.assemble(eom, q=given["q"], u=given["u"], inputs=given.get("inputs"))
            return {x.name: v for x, v in found.q.items()}, {x.name: v for x, v in found.u.items()}
        q = {x.name: 0.2 + 0.4 * k / len(eom.coordinates) for k, x in enumerate(eom.coordinates)}
        for s in eom.system.euler_parameters:
            length = np.sqrt(sum(q[e.name] ** 2 for e in s.coordinates))
            q |= {e.name: q[e.name] / length for e in s.coordinates}
        return q, {u.name: 0.5 - k / len(eom.speeds) for k, u in enumerate(eom.speeds)}


@pytest.fixture(scope="module")
def in_units():
    return cache(InUnits)


def moved(system, scale, start):
    """Status, how many events and warnings, the states in metres, kilograms and seconds, and E over its unit."""
    eom, (q, u), second = system.eom, start, scale[2]
    every = (*eom.coordinates, *eom.speeds)
    factors = system.factors(every, scale)
    inputs = {r.name: 0.0 for r in eom.inputs if "'" not in r.name} | getattr(system.module, "START", {}).get(
        "inputs", {}
    )
    span = 0.02 if system.module.__name__.endswith("andrews_squeezer") else 0.3
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        sol = kn.simulate(
            eom, (0, span * second), q=system.scaled(q, scale), u=system.scaled(u, scale), samples=5,
            parameters=system.parameters(scale), inputs=system.scaled(inputs, scale),
            atol=(1e-12 if "flexible" in system.module.__name__ else 1e-9) * min(1.0, *factors),  # deflections are small
        )  # fmt: skip
    # which speeds are dependent is chosen anew where they must be, at the end of a step, once or, of choices that are as good there,
    # twice: steps are others in units of which some need a smaller atol
    named = ["dependent speeds" if e.name.startswith("dependent speeds") else e.name for e, _ in sol.events]
    events = [name for k, name in enumerate(named) if k == 0 or (name, named[k - 1]) != ("dependent speeds",) * 2]
    return (sol.status, events, len(said), sol.keeps_energy), np.hstack([sol.q, sol.u]) / factors


GIGA = (1e-9, 1, 1), (1e9, 1, 1), (1, 1, 1e-9)
"""Lengths in millions of kilometres and in nanometres, times in thirty years."""


@pytest.mark.slow
@pytest.mark.parametrize("name", ["whipple_bicycle", "slider_crank", "pure_rolling_disk", "flexible_four_bar"])
def test_what_is_assembled_is_the_same_in_any_units(name, in_units):
    """Which speeds are determined is no matter of the sizes of metres beside radians; least changes neither."""
    system, given = in_units(name), load(name).START
    guessed = {u.name: kn.guess(given["u"].get(u.name, 0.0)) for u in system.eom.speeds}
    inputs = given.get("inputs")
    for u in (given["u"], guessed):
        expected = kn.assemble(system.eom, q=given["q"], u=u, inputs=inputs)
        for scale in (*SCALES, *GIGA):
            found = kn.assemble(
                system.eom, q=system.scaled(given["q"], scale), u=system.scaled(u, scale),
                parameters=system.parameters(scale), inputs=inputs and system.scaled(inputs, scale),
            )  # fmt: skip
            for one, other in ((found.q, expected.q), (found.u, expected.u)):
                factors = system.factors(one, scale)
                values = np.array(list(other.values()))
                np.testing.assert_allclose(
                    np.array(list(one.values())) / factors,
                    values,
                    rtol=1e-7,
                    atol=1e-9 * max(1.0, np.abs(values).max()),
                )


def test_tolerances_of_large_numbers_overflow_nothing(in_units):
    system = in_units("pure_rolling_disk")
    start = system.start()
    verdict, expected = moved(system, (1, 1, 1), start)
    found, states = moved(system, GIGA[1], start)
    assert found == verdict
    np.testing.assert_allclose(states, expected, atol=1e-7 * np.abs(expected).max())


def test_a_tolerance_far_too_wide_stops_a_motion_with_a_reason(in_units):
    """Millimetres with atol = 1 m: steps lead to deflections whose foreshortening was nothing before, and are moved back."""
    system, scale = in_units("flexible_four_bar"), GIGA[0]
    q, u = system.start()
    sol = kn.simulate(
        system.eom,
        (0, 0.3),
        q=system.scaled(q, scale),
        u=system.scaled(u, scale),
        parameters=system.parameters(scale),
        samples=3,
    )
    assert np.isfinite(sol.states).all()
    assert sol.status == "finished" or sol.message


def slow_but(quick, names):
    """The names, those that are not quick marked so."""
    return [n if n in quick else pytest.param(n, marks=pytest.mark.slow) for n in names]


OTHERWISE = {"slider_crank_with_clearance", "ball_on_turntable", "skidding_bicycle"}
"""Ever faster impacts are as many as absolute tolerances tell; dependent speeds change where units of a ball, a bicycle mix."""


@pytest.mark.parametrize(
    "name", slow_but(["slider_crank", "rolling_disk"], [n for n in GALLERY if n.split(".")[-1] not in OTHERWISE])
)
def test_motions_are_the_same_in_any_units(name, in_units):
    system = in_units(name)
    start = system.start()
    verdict, expected = moved(system, (1, 1, 1), start)
    size = np.abs(expected).max(axis=0)
    for scale in SCALES:
        found, states = moved(system, scale, start)
        assert found == verdict, scale
        assert (np.abs(states - expected) <= 1e-6 * size + 1e-8 * size.max()).all(), scale


@pytest.mark.parametrize("name", slow_but(["slider_crank", "four_bar"], HELD))
def test_assembly_is_the_same_in_any_units(name, in_units):
    system = in_units(name)
    eom, given = system.eom, system.module.START
    inputs = system.module.START.get("inputs", {})

    def assembled(scale):
        found = kn.assemble(
            eom, q=system.scaled(given["q"], scale), u=system.scaled(given["u"], scale),
            inputs=system.scaled(inputs, scale), parameters=system.parameters(scale),
        )  # fmt: skip
        every = {**found.q, **found.u}
        return np.array(list(every.values())) / system.factors(every, scale), found.branch.split(";")[0]

    expected, branch = assembled((1, 1, 1))
    for scale in SCALES:
        found, own = assembled(scale)
        np.testing.assert_allclose(found, expected, rtol=1e-8, atol=1e-9 * np.abs(expected).max(), err_msg=str(scale))
        assert own == branch


REST = {
    "pendulum": {"theta": kn.guess(0.3)},
    "double_pendulum": {"q1": kn.guess(0.3), "q2": kn.guess(-0.2)},
    "pendulums": {"q1": kn.guess(0.3), "q2": kn.guess(-0.2), "q3": kn.guess(0.1)},
    "pendulum_on_cart": {"x": 0.0, "theta": kn.guess(0.3)},
    "furuta_pendulum": {"q1": 0.0, "q2": kn.guess(3.0)},
    "four_bar": {"q1": kn.guess(-1.5), "q2": kn.guess(0.8), "q3": kn.guess(-0.8)},
    "whipple_bicycle": {"phi": 0.0, "delta": 0.0, "theta": kn.guess(0.1)},
}
"""Guesses of states of rest."""
TURNS = {
    "spinning_top": ({"psi": 0.0, "theta": 0.5, "phi": 0.0}, {"u_psi": kn.guess(1.0), "u_theta": 0.0, "u_phi": 100.0}),
    "flyball_governor": (
        {"psi": 0.0, "alpha1": kn.guess(0.5), "alpha2": kn.guess(0.5), "s": kn.guess(0.5)},
        {"u_psi": 2 * np.pi, "u_alpha1": 0.0, "u_alpha2": 0.0, "u_s": 0.0},
    ),
    "pure_rolling_disk": ({"q1": 0.0, "q2": 0.4, "q3": 0.0, "q4": 0.0, "q5": 0.0}, {"u2": kn.guess(1.0), "u3": -9.0}),
    "car_with_trailer": ({"x": 0.0, "y": 0.0, "theta": 0.0, "beta": kn.guess(0.1)}, {"u_v": 5.0}),
}
"""Guesses of steady motions."""


@pytest.mark.parametrize("name", slow_but(["pendulum_on_cart", "car_with_trailer"], [*REST, *TURNS]))
def test_rest_and_eigenvalues_are_the_same_in_any_units(name, in_units):
    system = in_units(name)
    eom = system.eom
    q, u = TURNS[name] if name in TURNS else (REST[name], dict.fromkeys((s.name for s in eom.speeds), 0.0))
    q = {x.name: 0.0 for x in eom.coordinates} | q
    inputs = {r.name: 0.0 for r in eom.inputs} | (
        {"delta": 0.2, "F": kn.guess(0.0)} if name == "car_with_trailer" else {}
    )

    def found(scale):
        point = kn.trim(
            eom, q=system.scaled(q, scale), u=system.scaled(u, scale), inputs=system.scaled(inputs, scale),
            parameters=system.parameters(scale),
        )  # fmt: skip
        linear = kn.linearize(eom, **point.arguments)
        every = (*eom.coordinates, *eom.speeds)
        place = np.array([point[s] for s in every]) / system.factors(every, scale)
        return place, linear.eigenvalues * scale[2], (linear.states, linear.cyclic)

    place, roots, names = found((1, 1, 1))
    for scale in SCALES:
        other, own, labels = found(scale)
        assert labels == names
        np.testing.assert_allclose(other, place, rtol=1e-9, atol=1e-9, err_msg=str(scale))
        distance = np.abs(own[:, None] - roots)
        assert distance.min(axis=0).max() < 1e-6 * np.abs(roots).max()
        assert distance.min(axis=1).max() < 1e-6 * np.abs(roots).max()


UNTOLD = [n for n in GALLERY if n.split(".")[-1] != "flap_lag_blade"]
"""The blade, bent as far as its stiffness tells, has a negative kinetic energy or, found first, a singular matrix."""


@pytest.mark.parametrize("name", slow_but(["flexible_arm", "flexible_slider_crank", "snakeboard"], UNTOLD))
def test_an_equilibrium_without_values_is_the_same_in_any_units(name, in_units):
    """At rest without loads no term has a size, so that nothing but the masses compares metres to radians."""
    system = in_units(name)
    eom = system.eom

    def found(scale):
        values = {"parameters": system.parameters(scale), "inputs": dict.fromkeys(eom.inputs, 0.0)}
        try:
            point = kn.equilibrium(eom, **values)
        except kn.KaneError as error:
            return str(error)[:60], 0.0
        return "", np.array(list(point.q.values())) / system.factors(point.q, scale)

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        told, place = found((1, 1, 1))
        for scale in (*SCALES, (1e3, 1e3, 1e3)):
            other, own = found(scale)
            assert other == told, scale
            np.testing.assert_allclose(own, place, rtol=1e-6, atol=1e-8 * np.abs(place).max(initial=1e-3))


@pytest.mark.parametrize(
    "name", slow_but(["slider_crank", "four_bar", "pure_rolling_disk"], [n for n in HELD if "flexible" not in n])
)
def test_derivatives_of_motions_are_the_same_in_any_units(name, in_units):
    """Which initial values stay as they are when a parameter changes is no matter of units either."""
    system = in_units(name)
    eom, (q, u), by = system.eom, system.start(), list(system.eom.parameters)[:2]
    inputs = {r.name: 0.0 for r in eom.inputs} | getattr(system.module, "START", {}).get("inputs", {})

    def found(scale):
        factors = system.factors((*eom.coordinates, *eom.speeds), scale)
        sizes = system.factors(by, scale) * [abs(p.default or 1.0) for p in by]
        s = kn.fitting.sensitivities(
            eom, (0, 0.02 * scale[2]), by, q=system.scaled(q, scale), u=system.scaled(u, scale), samples=2,
            parameters=system.parameters(scale), inputs=system.scaled(inputs, scale), atol=1e-11 * min(1.0, *factors),
        )  # fmt: skip
        return s.states[:, : len(factors)] / factors[:, None] * sizes

    expected = found((1, 1, 1))
    for scale in (*SCALES, (1, 1, SMALL)):
        rows = np.abs(expected).max(axis=(0, 2), keepdims=True)[0]
        assert (np.abs(found(scale) - expected) <= 1e-6 * np.abs(expected) + 1e-7 * rows + 1e-9 * rows.max()).all(), (
            scale
        )


@pytest.mark.parametrize("scale", [(1, 1, 1), *SCALES])
def test_which_coordinates_depend_on_others_is_the_same_in_any_units(scale, in_units):
    """Gyroscopic terms alone keep the satellite from normal modes, not a mixture of its panels' deflections with its angles."""
    system = in_units("flexible_satellite")
    q, u = system.start()
    at = {"q": system.scaled(q, scale), "u": system.scaled(u, scale), "parameters": system.parameters(scale)}
    linear = kn.linearize(system.eom, **at, inputs=dict.fromkeys(system.eom.inputs, 0.0), steady=False)
    with pytest.raises(kn.SimulationError, match="without damping and gyroscopic terms"):
        kn.analysis.normal_modes(linear)


LAST = {"thrown_disk": 3.0, "rocking_block": 3.0, "skidding_bicycle": 1.7}
"""Until when contacts change their modes."""


@pytest.mark.parametrize("name", slow_but({"thrown_disk", "rocking_block"}, LAST))
def test_contacts_have_the_same_modes_in_any_units(name, in_units):
    system = in_units(name)
    eom, start = system.eom, system.module.START
    told = []
    for scale in ((1, 1, 1), (1e3, 1, 1), (1e-3, 1, 1), (SMALL, 1, 1), (BIG, BIG, 1)):
        factors = system.factors((*eom.coordinates, *eom.speeds), scale)
        sol = kn.simulate(
            eom, (0, LAST[name]), q=system.scaled(start["q"], scale), u=system.scaled(start["u"], scale),
            parameters=system.parameters(scale), inputs=system.scaled(start.get("inputs", {}), scale),
            atol=1e-9 * min(1.0, *factors),
        )  # fmt: skip
        told.append((sol.status, [(round(t, 5), *m.values()) for t, m in sol.mode_history]))
    assert len(told[0][1]) > 1
    assert told[1:] == told[:1] * 4
