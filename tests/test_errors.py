# SPDX-License-Identifier: BSD-3-Clause
"""What messages show of long things ends in "…"."""

import inspect
import math
import pickle
import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane.errors import cut
from kane.gallery import load
from tests.systems.things import N, O, things

EOM = {name: kn.derive(load(name).system()) for name in ("pendulum", "pure_rolling_disk", "four_bar")}


@given(st.text(alphabet="ab +-*/(^", max_size=120), st.integers(3, 80))
def test_a_cut_is_seen(text, most):
    shown = cut(text, most)
    assert len(shown) <= most
    assert shown == text or (shown.endswith(" …") and text.startswith(shown[:-2]))
    assert len(text) > most or shown == text


def test_no_message_is_cut_without_a_word():
    bare = re.compile(r"\{[^{}]+![rs]:\.\d+\}")
    for path in Path(kn.__file__).parent.rglob("*.py"):
        assert not bare.search(path.read_text(encoding="utf-8")), f"{path}: take cut(…) of kane.errors"


def test_in_a_message():
    long = sum(kn.coordinates("x1:40"), start=kn.Rational(0))
    with pytest.raises(kn.ExpressionError, match=r"got an expression: `==` on x1 .* … cannot be decided"):
        assert long == 1


def test_there_is_one_of_every_public_class():
    public = [c for n in kn.__all__ if inspect.isclass(c := getattr(kn, n)) and not issubclass(c, BaseException)]
    assert not [c for c in public if not any(isinstance(thing, c) for thing in things())]


def test_an_unknown_attribute_names_one_that_resembles_it():
    """Of every public class: one letter too many in each attribute, and a word that resembles none."""
    for thing in things():
        known = [n for n in dir(thing) if not n.startswith("_")]
        for name in known:
            with pytest.raises(kn.MissingAttributeError) as caught:
                getattr(thing, f"{name}z")
            assert re.search(rf"Did you mean .*\b{name}\b", str(caught.value)), (thing, name)
        with pytest.raises(AttributeError, match=f"It has {known[0]}"):
            _ = thing.qqqqqqqqqqqq
        assert not hasattr(thing, "_anything")
        assert getattr(thing, "anything", None) is None
    with pytest.raises(
        kn.MissingAttributeError, match=r"^Expected an attribute of Frame N, got 'zz'\. Did you mean z\?$"
    ):
        _ = N.zz


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("plot", "There is a function: kn.plot."),
        ("linearize", "There is a function: kn.linearize."),
        ("latex", "There is a function: kn.to_latex."),
        ("q1", "It is an entry: read it as ['q1']."),
        ("M", "It is called mass_matrix."),
        ("nfev", "It is called evaluations."),
        ("integrate", "There is a function: kn.simulate."),
        ("event", "It is called events."),
    ],
)
def test_what_is_no_attribute_but_a_function_or_an_entry_is_told(name, told):
    eom = kn.derive(load("double_pendulum").system())
    thing = kn.simulate(eom, (0, 0.1), q=[0, 0], u=[0, 0]) if name in ("plot", "q1", "nfev") else eom
    with pytest.raises(kn.MissingAttributeError, match=re.escape(f"got '{name}'. {told}")):
        getattr(thing, name)


def test_names_of_other_tools_lead_to_functions():
    others = " ".join(kn._other_names.values()).split()
    assert len(others) == len(set(others))
    assert not [name for name in (*kn._other_names, *others) if hasattr(kn, name) is not (name in kn._other_names)]
    for place in (kn, kn.joints):
        with pytest.raises(kn.MissingAttributeError, match=r"got 'revolute'\. Did you mean pin\?$"):
            _ = place.revolute


@pytest.mark.parametrize(
    ("name", "meant"),
    [
        ("Spring", "linear_spring"),  # as another tool calls it, but for capitals
        ("Revolute", "pin"),
        ("Capstan", "capstan"),  # of a family
        ("cone", "solid_cone"),  # one of several words
        ("Plate", "rectangular_plate or triangular_plate"),
    ],
)
def test_a_name_that_is_part_of_a_public_one_leads_to_it(name, meant):
    with pytest.raises(kn.MissingAttributeError, match=rf"got '{name}'\. Did you mean {meant}\?$"):
        getattr(kn, name)


def test_an_entry_goes_before_another_name():
    frame, x, v = kn.Frame("N"), kn.coordinate("x", "m"), kn.speed("v", "m/s")
    bob = kn.Particle("P", kn.Point("O", fixed_in=frame).at("P", x * frame.x), 1.0)
    sol = kn.simulate(kn.derive(kn.System(frame, bodies=[bob], speeds={v: x.dt})), (0, 1), q=0, u=[1.0])
    with pytest.raises(kn.MissingAttributeError, match=r"It is an entry: read it as \['x'\]"):
        _ = sol.x


@pytest.mark.parametrize("kind", [t for t in map(type, things()) if getattr(t, "_other_names", None)])
def test_other_names_lead_to_attributes(kind):
    known = set(dir(kind)) | set(getattr(kind, "__annotations__", ()))
    assert kind._other_names
    others = " ".join(kind._other_names.values()).split()
    assert set(kind._other_names) <= known
    assert not set(others) & known
    assert len(others) == len(set(others))


def test_what_an_attribute_raises_itself_is_its_own():
    class Odd(kn.Frame):
        @property
        def odd(self):
            return self.nothing.of_the_kind

    with pytest.raises(kn.MissingAttributeError, match="got 'nothing'"):
        _ = Odd("O").odd


def test_every_object_pickles_or_says_why_not():
    kept = {}
    for thing in things():
        try:
            again = pickle.loads(pickle.dumps(thing))
        except kn.KaneError as error:
            kept[type(thing)] = str(error)
            continue
        assert type(again) is type(thing)
        assert repr(again) == repr(thing)
    assert list(kept) == [kn.Compiled]
    assert "compiled.rhs" in kept[kn.Compiled]


def test_names_in_the_place_of_units():
    """A second name given by itself is no unit, and where it is meant is said; what is a unit stays one."""
    for make, stem in ((kn.coordinates, "q"), (kn.speeds, "u")):
        with pytest.raises(
            kn.UnitError, match=rf"another name, give all names in one text, {make.__name__}\('{stem}1 {stem}2'\)"
        ):
            make(f"{stem}1", f"{stem}2")
        assert [s.unit for s in make("a b", "m/s")] == ["m/s", "m/s"]
    with pytest.raises(
        kn.ExpressionError, match=re.escape("the Input, got 'a b'. Several at once are kn.inputs('a b').")
    ):
        kn.input("a b")
    assert kn.inputs("a b", "N") == (kn.input("a", "N"), kn.input("b", "N"))
    assert [p.default for p in kn.parameters("a b", [2, 3.5])] == [2, 3.5]
    with pytest.raises(kn.ExpressionError, match=re.escape("one default for all of a, b, or 2, got 3: [1, 2, 3]")):
        kn.parameters("a b", [1, 2, 3])
    for names in (("x", "y"), ("alpha", "beta"), ("q1", "q2", "q3"), ("x1:4", "x4")):
        with pytest.raises(kn.UnitError):
            kn.coordinates(*names)
    with pytest.raises(kn.ExpressionError, match="got 'l'"):
        kn.parameters("m", "l")


@given(st.sampled_from([30, 45, 60, 90, 120, 180, 270, 360]), st.sampled_from([1, -1, 0.5]))
def test_angles_in_degrees_are_doubted(degrees, share):
    angle = degrees * share
    for turn in (
        lambda: N.rotate("A", angle, N.z),
        lambda: N.rotate_body("A", (0.1, angle, 0.2), "xyz"),
        lambda: kn.Rotation.from_axis_angle([0, 0, 1], angle),
        lambda: kn.Rotation.from_angles("zxz", (0.1, angle, 0.2)),
    ):
        with pytest.warns(
            kn.KaneWarning, match=rf"angles are in radians. If degrees are meant, write math.radians\({angle:g}\)"
        ):
            turn()


@given(st.floats(-40, 40).filter(lambda x: x != round(x * 1024) / 1024), st.integers(-20, 20), st.floats(-6.28, 6.28))
def test_angles_in_radians_are_not(many, turns, few):
    """Sums of turns, whole or not, and whatever is within one: warnings are errors here."""
    for angle in (
        many,
        few,
        turns * math.pi / 2,
        math.radians(turns * 90),
        turns * kn.pi / 3,
        kn.parameter("a", 90.0, "deg"),
    ):
        N.rotate("A", angle, N.z)


@pytest.mark.parametrize("mixed", [
    lambda s, e: s * e, lambda s, e: e * s, lambda s, e: s + e, lambda s, e: e - s, lambda s, e: s / e, lambda s, e: e / s,
    lambda s, e: e**s, lambda s, e: s * N.x, lambda s, e: kn.sin(s), lambda s, e: kn.Matrix([[s]]),
    lambda s, e: kn.Particle("p", O, s),
    lambda s, e: N.rotate("A", s, N.z),
])  # fmt: skip
def test_what_is_sympy_s_is_translated_first(mixed):
    sympy = pytest.importorskip("sympy")
    for s in (sympy.Symbol("s"), sympy.sin(sympy.Symbol("s")) + 1):
        with pytest.raises(kn.ExpressionError, match=r"kn\.from_sympy\("):
            mixed(s, kn.coordinate("q"))


def test_names_that_resemble_others_are_proposed():
    """Wherever one of some names is asked for."""
    made = {type(thing): thing for thing in things()}
    sol, eom, system = made[kn.Solution], made[kn.Equations], made[kn.System]
    asked = {
        "plate": lambda: system["plat"],
        "gauss16": lambda: kn.simulate(eom, (0, 1), q=[0, 0], u=[0, 0], inputs={"F": 0}, method="gauss61"),
        "lagrange": lambda: eom.by("lagrang"),
        "repeated": lambda: sol.accuracy(method="repeat"),
        "numpy": lambda: eom.compile().emit("numpi"),
        "classical": lambda: kn.derive(system, route="classic"),
        "rates": lambda: made[kn.SpeedComparison]["rate"],
        "kane": lambda: made[kn.MethodComparison]["kan"],
        "rhs": lambda: eom.compile().operations["rh"],
        "pendulum": lambda: load("pendulun"),
        "F": lambda: sol["FF"],
    }
    for name, ask in asked.items():
        with pytest.raises(kn.KaneError, match=rf"Did you mean .*\b{name}\b"):
            ask()


@pytest.mark.parametrize("name", ["pendulum", "pure_rolling_disk", "four_bar"])
@pytest.mark.parametrize("ask", [
    kn.linearize, kn.trim, kn.assemble, lambda eom, **at: kn.simulate(eom, (0, 0.1), **at), lambda eom, **at: kn.linearizer(eom)(**at),
], ids=["linearize", "trim", "assemble", "simulate", "linearizer"])  # fmt: skip
def test_states_of_wrong_length_or_kind_are_named(name, ask):
    eom = EOM[name]
    for key in ("q", "u"):
        count = len(eom.coordinates if key == "q" else eom.speeds)
        for wrong in (
            [0.1] * (count + 1),
            [0.1] * (count - 1),
            0.1,
            "x",
            {"zz": 1},
            [[0.1] * (count + 1)],
            ["x"] * count,
            [1j] * count,
        ):
            with pytest.raises(kn.KaneError, match=r"^Expected .*, got "):
                ask(eom, **{key: wrong})


def test_a_name_but_for_capitals_is_meant():
    N = kn.Frame("N")
    hinge = kn.pin("hinge", kn.Point("O", fixed_in=N), N, axis=N.z)
    bob = kn.Particle("bob", hinge.point.at("P", hinge.frame.x), kn.parameter("m", 1.0))
    eom = kn.derive(kn.System(N, bodies=[bob], joints=[hinge]))
    with pytest.raises(kn.errors.ValueMissingError, match=r"got one for 'M'\. Did you mean m\?"):
        kn.simulate(eom, (0, 1), q=0, u=0, parameters={"M": 2.0})
    with pytest.raises(kn.SimulationError, match=r"got 'rk45'\. Did you mean RK45\?"):
        kn.simulate(eom, (0, 1), q=0, u=0, method="rk45")
