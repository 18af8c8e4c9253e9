# SPDX-License-Identifier: BSD-3-Clause
"""Units in fmpy: valid, on the motion of `kn.simulate`, with events at their times, in both versions and for both purposes."""

import ctypes
import subprocess
import zipfile
from functools import lru_cache

import numpy as np
import pytest

import kane as kn
from kane.gallery import GALLERY, load
from tests.interop.fmu.units import MODELS, TIGHT, far, instantiated, integrated, model, reference, states_of, written
from tests.motion.test_time_breaks import KINDS, PULSES, S, V, wheel
from tests.peer import require

fmpy = require("fmpy")
validation = require("fmpy.validation")

PURPOSES = ("ModelExchange", "CoSimulation")
CONTACTS = {name for name in GALLERY if load(name).system().contacts}
"""Those with contacts, of which units are for co-simulation alone: `test_contact_units.py`."""

FAST = {
    "flap_lag_blade",
    "flexible_arm",
    "flexible_four_bar",
    "flexible_pendulum",
    "flexible_slider_crank",
    "rattleback",
}
"""Vibrations: CVODE of fmpy takes 500 steps at most from one output to the next, so that there are more of them, and is less exact."""


def ran(unit, purpose, end, samples, tolerance=TIGHT, **more):
    """What fmpy records at `samples` times; model exchange by CVODE."""
    step = {"step_size": end / (samples - 1)} if purpose == "CoSimulation" else {}
    return fmpy.simulate_fmu(
        str(unit.path), fmi_type=purpose, stop_time=end, output_interval=end / (samples - 1), relative_tolerance=tolerance,
        record_events=False, timeout=60, **step, **more,
    )  # fmt: skip


@lru_cache(maxsize=1)
def moved(name, end):
    """Equations, start values and motion by `kn.simulate` of a system, once for its units of both versions."""
    eom, given = model(name)
    return eom, given, reference(eom, end, 6, given)


def agrees(folder, name, version, end=0.5):
    """A unit is valid and runs as `kn.simulate` does."""
    eom, given, sol = moved(name, end)
    unit = written(folder, name, eom, given, version=version)
    assert validation.validate_fmu(str(unit.path)) == []
    expected = sol.states[[np.flatnonzero(sol.t <= t + 1e-12)[-1] for t in np.linspace(0, end, 6)]]  # after an event
    for purpose in PURPOSES:
        between, tolerance = (100, TIGHT / 10) if name in FAST and purpose == "ModelExchange" else (1, TIGHT)
        rows = ran(unit, purpose, end, 5 * between + 1, tolerance, output=[s.name for s in eom.state])
        assert far(states_of(rows, eom)[::between], expected) < 1e-8, purpose


@pytest.mark.parametrize(("name", "version"), [("double_pendulum", "2.0"), ("slider_crank", "3.0")])
def test_the_motion_is_that_of_simulate(tmp_path, name, version):
    agrees(tmp_path, name, version)


@pytest.mark.slow
@pytest.mark.parametrize("version", ["2.0", "3.0"])
@pytest.mark.parametrize("name", sorted({*GALLERY, *MODELS} - CONTACTS))
def test_all_that_a_program_in_c_looks_after(tmp_path, name, version):
    agrees(tmp_path, name, version, {"andrews_squeezer": 0.005, "flexible_arm": 0.05}.get(name, 0.25))


# ------------------------------------------------------------------------------------------------------------ events


def times(logged):
    """Names and times of the events that a unit told of."""
    lines = [text if isinstance(text, str) else text.decode() for text in logged]
    return [(name, float(t)) for name, _, t in (line.partition(" at t = ") for line in lines) if t]


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_events_are_at_their_times(tmp_path, version):
    eom, given = model("ball")
    unit = written(tmp_path, "ball", eom, given, version=version)
    sol = reference(eom, 1.5, 16, given)
    expected = [(one.name, t) for one, t in sol.events]
    assert [name for name, _ in expected].count("bounce") == 2
    modes = [{}, {"use_event_mode": True, "early_return_allowed": True}] if version == "3.0" else [{}]
    for purpose, more in [("ModelExchange", {}), *(("CoSimulation", mode) for mode in modes)]:
        logged = []
        rows = ran(
            unit,
            purpose,
            1.5,
            16,
            debug_logging=True,
            logger=lambda *a, to=logged: to.append(a[-1]),
            output=["y", "v"],
            **more,
        )
        assert far(np.array([rows["y"][-1], rows["v"][-1]]), sol.states[-1]) < 1e-8
        found = times(logged)
        assert [name for name, _ in found] == [name for name, _ in expected]
        assert max(abs(a - b) for (_, a), (_, b) in zip(found, expected, strict=True)) < 1e-8
        if "use_event_mode" in more:  # a row before and after, at the instant
            at = next(k for k in range(1, len(rows)) if rows["v"][k] > 0 > rows["v"][k - 1])
            (first, *_) = (t for name, t in expected if name == "bounce")
            assert rows["time"][at] == rows["time"][at - 1] == pytest.approx(first, abs=1e-8)
            assert rows["v"][at] == pytest.approx(-0.8 * rows["v"][at - 1], rel=1e-12)


def test_a_terminal_event_ends_the_motion(tmp_path):
    eom, _ = model("ball")
    given = {"q": {"y": 0.2}, "u": {"v": 0.0}}
    unit = written(tmp_path, "ball", eom, given)
    sol = reference(eom, 5.0, 501, given)
    assert sol.t[-1] < 5.0
    for purpose in PURPOSES:
        rows = ran(unit, purpose, 5.0, 501)
        assert rows["time"][-1] == pytest.approx(sol.t[-1], abs=0.011)


@pytest.mark.parametrize(("kind", "speed"), [("sign", 2.0), ("max", 2.1)])
def test_times_at_which_rates_turn_are_met(tmp_path, kind, speed):
    """At a speed of 2 the step of the road is at a communication point."""
    eom = wheel(KINDS[kind][0])
    given = {"q": [0.0], "u": [0.0], "parameters": {V: speed, S: 1.0}}
    unit = written(tmp_path, "road", eom, given)
    expected = reference(eom, 2.0, 9, given).states
    for purpose in PURPOSES:
        assert far(states_of(ran(unit, purpose, 2.0, 9), eom), expected) < 1e-8


# ------------------------------------------------------------------------------------- inputs, outputs, parameters


def test_inputs_parameters_and_outputs(tmp_path):
    eom, _ = model("pendulum_on_cart")
    given = {"q": {"x": 0.1, "theta": 1.0}, "u": {"u_x": 0.0, "u_theta": 2.0}}
    x, theta = eom.coordinates
    outputs = {"tip": x + kn.sin(theta), "energy": eom.kinetic_energy}
    unit = written(tmp_path, "cart", eom, given, outputs=outputs)
    assert unit.outputs == ("tip", "energy")
    assert unit.inputs == ("F",)
    force = np.array([(0.0, 0.0), (1.0, 2.0)], dtype=[("time", float), ("F", float)])
    sol = reference(eom, 1.0, 6, given, inputs={"F": 2.0 * kn.time}, parameters={"m": 0.7})
    rows, put = integrated(tmp_path / "run", unit, 1.0, 6, {"F": lambda t: 2.0 * t}, {"m": 0.7})
    assert far(rows, sol.states) < 1e-8
    own = eom.compile(outputs=outputs, parameters={"m": 0.7}).outputs(sol.t, sol.states, None, 2.0 * sol.t[:, None])
    for k, name in enumerate(outputs):
        assert far(put[:, k], own[name]) < 1e-8
    pieces = given
    for k in range(5):  # co-simulation holds inputs from one communication point to the next
        part = kn.simulate(
            eom, (0, 0.2), **pieces, inputs={"F": 0.4 * k}, parameters={"m": 0.7}, rtol=1e-12, atol=1e-12, samples=2
        )
        pieces = {"q": part.q[-1], "u": part.u[-1]}
    rows = ran(unit, "CoSimulation", 1.0, 6, input=force, start_values={"m": 0.7})
    assert far(states_of(rows, eom)[-1], part.states[-1]) < 1e-8


def test_dependent_start_values_follow(tmp_path):
    eom, given = model("four_bar")
    unit = written(tmp_path, "four_bar", eom, given)
    q = {"q1": 1.0, "q2": kn.guess(0.5), "q3": kn.guess(-1.4)}
    expected = reference(eom, 0.2, 3, {"q": q, "u": {"u1": 4.0}}).states
    for purpose in PURPOSES:
        rows = ran(unit, purpose, 0.2, 3, start_values={"q1": 1.0, "u1": 4.0})
        assert far(states_of(rows, eom), expected) < 1e-8
    with pytest.raises(fmpy.fmi1.FMICallException, match="fmi3ExitInitializationMode failed with status 3"):
        ran(unit, "CoSimulation", 0.2, 3, start_values={"a": 1e3})  # no linkage closes


# ---------------------------------------------------------------------------------------------------- one instance


@pytest.fixture
def instance(tmp_path):
    """Makes an instance of a unit, behind the functions of FMI 3."""
    made = []

    def make(unit, purpose):
        made.append(instantiated(tmp_path / f"run{len(made)}", unit, purpose))
        return made[-1]

    yield make
    for one, _ in made:
        one.freeInstance()


def test_directional_derivatives_are_those_of_the_equations(tmp_path, instance, rng):
    eom, _ = model("pendulum_on_cart")
    given = {"q": [0.1, 1.0], "u": [0.3, 2.0], "inputs": {"F": 0.7}}
    x, theta = eom.coordinates
    unit = written(tmp_path, "cart", eom, given, outputs={"tip": x * kn.sin(theta)})
    one, at = instance(unit, "ModelExchange")
    one.enterInitializationMode()
    one.exitInitializationMode()
    state = [s.name for s in eom.state]
    seed = rng.normal(size=5)
    found = one.getDirectionalDerivative(
        [at[f"der({s})"] for s in state] + [at["tip"]], [at[s] for s in state] + [at["F"]], list(seed)
    )
    compiled = eom.compile()
    values = np.array([0.1, 1.0, 0.3, 2.0]), None, np.array([0.7])
    expected = compiled.jac(0.0, *values) @ seed[:4] + compiled.jac_inputs(0.0, *values) @ seed[4:]
    assert far(np.array(found[:4]), expected) < 1e-13
    assert found[4] == pytest.approx(np.sin(1.0) * seed[0] + 0.1 * np.cos(1.0) * seed[1], rel=1e-13)
    back = one.getAdjointDerivative([at[f"der({s})"] for s in state], [at[s] for s in state], list(seed[:4]))
    assert far(np.array(back), seed[:4] @ compiled.jac(0.0, *values)) < 1e-13


def test_a_state_that_was_kept_goes_on_as_before(tmp_path, instance):
    eom, given = model("ball")
    unit = written(tmp_path, "ball", eom, given)
    one, at = instance(unit, "CoSimulation")
    other, _ = instance(unit, "CoSimulation")
    for i in (one, other):
        i.enterInitializationMode()
        i.exitInitializationMode()
    one.doStep(0.0, 0.3)
    kept = one.getFMUState()
    content = one.serializeFMUState(kept)
    one.doStep(0.3, 0.7)
    first = one.getFloat64([at["y"], at["v"]])
    one.setFMUState(kept)
    one.doStep(0.3, 0.7)
    assert one.getFloat64([at["y"], at["v"]]) == first
    other.doStep(0.0, 0.1)  # another instance has a motion of its own
    other.setFMUState(other.deserializeFMUState(content))
    other.doStep(0.3, 0.7)
    assert other.getFloat64([at["y"], at["v"]]) == first
    one.freeFMUState(kept)
    one.reset()
    assert one.getFloat64([at["y"], at["v"]]) == [1.0, 0.1]
    one.enterInitializationMode(startTime=2.0)  # time is not in these equations
    one.exitInitializationMode()
    one.doStep(2.0, 0.3)
    one.doStep(2.3, 0.7)
    assert np.allclose(one.getFloat64([at["y"], at["v"]]), first, rtol=0, atol=1e-9)


def test_communication_points_at_impacts(tmp_path, instance):
    """A step of co-simulation ends where an event acts, but for rounding to either side: the motion goes on as in one step."""
    eom, given = model("ball")
    sol = reference(eom, 1.3, 2, given)
    one, at = instance(written(tmp_path, "ball", eom, given), "CoSimulation")
    for _, t in sol.events:
        for beside in (0, 1, -1, 2, -4, 9, -20, 40, -100, 1e4, -1e4):
            there = t + beside * np.spacing(t)
            one.reset()
            one.enterInitializationMode(stopTime=1.3)
            one.exitInitializationMode()
            one.doStep(0.0, there)
            one.doStep(there, 1.3 - there)
            assert far(np.array(one.getFloat64([at["y"], at["v"]])), sol.states[-1]) < 1e-8


@pytest.mark.parametrize("stop", [10.0, None])
def test_a_pulse_is_where_a_parameter_puts_it_on_the_way(tmp_path, instance, stop):
    """A parameter that is set after the start moves the times at which rates turn, at which steps end."""
    N = kn.Frame("N")
    x, v, at = kn.coordinate("x"), kn.speed("v"), kn.parameter("at", 1.0)
    P = kn.Point("O", fixed_in=N).at("P", x * N.x)
    form, whole = PULSES["where"]
    loads = [kn.Force(P, form(kn.time - at) * N.x)]
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("p", P, 1)], speeds={v: x.dt}, loads=loads))
    one, refers = instance(written(tmp_path, "pulse", eom, {"q": [0.0], "u": [0.0]}), "CoSimulation")
    for start in (0.0, -50.0):
        one.reset()
        one.setFloat64([refers["at"]], [start + 1.0])
        one.enterInitializationMode(startTime=start, stopTime=None if stop is None else start + stop)
        one.exitInitializationMode()
        one.doStep(start, 0.5)
        one.setFloat64([refers["at"]], [start + 5.77])
        for k in range(1, 20):
            one.doStep(start + 0.5 * k, 0.5)
        assert one.getFloat64([refers["v"]])[0] == pytest.approx(whole, rel=1e-9)


# ------------------------------------------------------------------------------------------------------- the archive


def test_the_archive_is_the_same_each_time_and_needs_no_python(tmp_path):
    eom, given = model("pendulum")
    first = written(tmp_path, "pendulum", eom, given)
    library = ctypes.CDLL(str(tmp_path / "pendulum_sources" / "pendulum.so"))
    library.fmi3GetVersion.restype = ctypes.c_char_p
    assert library.fmi3GetVersion() == b"3.0"
    done = subprocess.run(
        ["nm", "-D", "--undefined-only", tmp_path / "pendulum_sources" / "pendulum.so"],
        capture_output=True,
        text=True,
        check=True,
    )
    wanted = {line.split()[-1].partition("@")[0] for line in done.stdout.splitlines() if line.split()[0] == "U"}
    known = {"calloc", "free", "malloc", "memcpy", "memset", "snprintf", "strcmp", "__stack_chk_fail", "sin", "cos", "sqrt", "pow",
             "fmax", "fmin", "nextafter", "floor", "sincos", "fabs", "log2", "exp2", "frexp", "ldexp", "__memcpy_chk"}  # fmt: skip
    assert wanted <= known
    (tmp_path / "again").mkdir()
    again = kn.exchange.to_fmu(
        eom, tmp_path / "again" / "pendulum.fmu", binary=False, tolerance=TIGHT, method="tsit5", **given
    )
    assert again.token == first.token
    with zipfile.ZipFile(again.path) as archive:
        assert set(archive.namelist()) == {"modelDescription.xml", "sources/pendulum.c", "sources/buildDescription.xml"}
        assert again.token in archive.read("sources/pendulum.c").decode()


def test_a_library_is_inside_where_there_is_a_compiler(tmp_path, monkeypatch):
    eom, given = model("pendulum")
    unit = kn.to_fmu(eom, tmp_path / "pendulum.fmu", method="tsit5", title="a <swing> & more", **given)
    with zipfile.ZipFile(unit.path) as archive:
        assert unit.binary in archive.namelist()
    assert validation.validate_fmu(str(unit.path)) == []
    assert fmpy.read_model_description(str(unit.path)).description == "a <swing> & more"
    rows = ran(unit, "CoSimulation", 0.5, 3)
    assert far(states_of(rows, eom), reference(eom, 0.5, 3, given).states) < 1e-8
    monkeypatch.setenv("PATH", str(tmp_path))
    assert kn.to_fmu(eom, tmp_path / "bare.fmu", method="tsit5", **given).binary == ""


def test_units_of_measurement(tmp_path):
    N = kn.Frame("N")
    q, u = kn.coordinate("q", unit="m"), kn.speed("u", unit="m/s")
    m, g, k = (
        kn.parameter("m", 2.0, unit="kg"),
        kn.parameter("g", 9.81, unit="m/s^2"),
        kn.parameter("k", 1.0, unit="N/m"),
    )
    P = kn.Point("O", fixed_in=N).at("P", q * N.x)
    loads = [kn.Force(P, -(m * g + k * q) * N.x)]
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("p", P, m)], speeds={u: q.dt}, loads=loads))
    unit = kn.exchange.to_fmu(eom, tmp_path / "line.fmu", binary=False, q=[0], u=[0])
    units = {one.name: one.baseUnit for one in fmpy.read_model_description(str(unit.path)).unitDefinitions}
    assert (units["m/s^2"].m, units["m/s^2"].s, units["m/s^2"].kg) == (1, -2, 0)
    assert units["kg"].kg == 1
    assert (units["N/m"].kg, units["N/m"].m, units["N/m"].s, units["N/m"].factor) == (1, 0, -2, 1)


@pytest.mark.parametrize(
    ("file", "name"), [("arm", "model_arm"), ("my arm-2", "my_arm_2"), ("θ", "theta"), ("7", "model_7")]
)
def test_a_unit_is_called_after_any_file(file, name, tmp_path):
    eom, given = model("pendulum")
    unit = kn.exchange.to_fmu(eom, tmp_path / f"{file}.fmu", binary=False, **given)
    told = fmpy.read_model_description(str(unit.path))
    assert told.coSimulation.modelIdentifier == name


def test_bad_input_is_named(tmp_path):
    eom, given = model("pendulum")
    for more, said in (
        ({"version": "1.0"}, "a version of FMI"),
        ({"method": "rk4"}, "an adaptive integrator"),
        ({"name": "a b"}, "a model identifier"),
        ({"name": "double"}, "a model identifier"),
        ({"name": 3}, "a model identifier"),
        ({"title": 3}, "title= a text, got 3"),
        ({"title": "form\x0cfeed"}, r"letters that XML has in names and descriptions, got '\\x0c'"),
        ({"tolerance": 0.0}, "a tolerance between 0 and 1"),
        ({"outputs": {eom.state[0].name: eom.state[0]}}, "different names of all variables"),
    ):
        with pytest.raises(kn.KaneError, match=said):
            kn.exchange.to_fmu(eom, tmp_path / "p.fmu", **more, **given)
    with pytest.raises(kn.ArgumentError, match=r"ends in \.fmu"):
        kn.exchange.to_fmu(eom, tmp_path / "p.zip", **given)
    with pytest.raises(kn.ValueMissingError):
        kn.exchange.to_fmu(eom, tmp_path / "p.fmu", q=given["q"])
    (tmp_path / "p.fmu").write_text("something else", encoding="utf-8")
    with pytest.raises(kn.KaneError, match="other contents"):
        kn.exchange.to_fmu(eom, tmp_path / "p.fmu", binary=False, **given)
