# SPDX-License-Identifier: BSD-3-Clause
"""Many motions, and prepared ones, whose inputs differ by parameters are those of `kn.simulate`, and one kernel runs them all."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import kane as kn
from kane.gallery import four_bar, pendulum_on_cart
from tests.motion.many.separate import simulated_separately
from tests.motion.test_contact_runner import pushed

KP, KD, W, MOST = kn.parameter("kp", 40.0), kn.parameter("kd", 8.0), kn.parameter("w"), kn.parameter("most", 3.0)
COUNT = 70


@pytest.fixture
def separate(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """The instances that were simulated separately."""
    return simulated_separately(monkeypatch)


def cart() -> tuple[kn.Equations, kn.Expr, kn.Expr]:
    """A driven pendulum on a cart, a law that holds it, and the mass of the cart."""
    eom = kn.derive(pendulum_on_cart.system(force=True))
    (x, theta), (u1, u2) = eom.coordinates, eom.speeds
    return eom, KP * theta + KD * x + 2 * u2 - 3 * u1, eom.parameters[1]


def shaken() -> kn.Equations:
    """A pendulum whose pivot is moved along a given path, so that its kinetic energy contains inputs."""
    N, q, u = kn.Frame("N"), kn.coordinate("q"), kn.speed("u")
    g, l, m, r = kn.parameter("g", 9.81), kn.parameter("l", 0.6), kn.parameter("m", 1.3), kn.input("r", "m")
    O = kn.Point("O", fixed_in=N)
    B = N.rotate("B", q, N.z)
    P = O.at("A", r * N.x).at("P", -l * B.y)
    return kn.derive(kn.System(N, bodies=[kn.Particle("bob", P, m)], speeds={u: q.dt}, loads=[kn.gravity(-g * N.y)]))


def stopped() -> kn.Equations:
    """A mass on a spring, pushed by an input, that is thrown back by a wall."""
    N, x, v = kn.Frame("N"), kn.coordinate("x"), kn.speed("v")
    m, k, F = kn.parameter("m", 2.0), kn.parameter("k", 30.0), kn.input("F")
    P = kn.Point("O", fixed_in=N).at("P", x * N.x)
    wall = kn.Event("wall", x - 0.25, direction=1, then={v: -0.5 * v})
    loads = [kn.Force(P, (F - k * x) * N.x)]
    return kn.derive(kn.System(N, bodies=[kn.Particle("mass", P, m)], speeds={v: x.dt}, loads=loads, events=[wall]))


def driven() -> kn.Equations:
    """A four-bar with a torque on its crank."""
    system: Any = four_bar.system()
    torque = kn.Torque(system.bodies[0].frame, kn.input("T", "N*m") * system.inertial.z)
    return kn.derive(system.replace(loads=[*system.loads, torque]))


def ways(name: str, rng: np.random.Generator) -> tuple[kn.Equations, dict[str, Any], dict[str, Any], dict[Any, Any]]:
    """Equations, start values, inputs, and columns of parameters or inputs."""
    some, other = rng.uniform(20, 60, COUNT), rng.uniform(1, 3, COUNT)
    if name.endswith("path"):
        path = {"r": 0.1 * kn.sin(W * kn.time)} if name.startswith("a prescribed") else {}
        return shaken(), {"q": [0.2], "u": [0.0]}, path, {W: 3 * other} if path else {"r": other}
    if name == "an event":
        eom = stopped()
        law = KP / 5 * kn.cos(W * kn.time) - KD * eom.speeds[0]
        return eom, {"q": [0.0], "u": [0.0]}, {"F": law}, {W: 2 * other, KP: some}
    if name == "constraints":
        eom = driven()
        (turn, *_), (speed, *_) = eom.coordinates, eom.speeds
        return eom, {"q": {turn: 1.0}, "u": {speed: 2.0}}, {"T": -W * speed}, {W: other / 10}
    eom, law, mass = cart()
    start = {"q": {"x": 0.1, "theta": rng.uniform(-0.3, 0.3, COUNT)}, "u": [0, 0]}
    laws: dict[str, tuple[dict[str, Any], dict[Any, Any]]] = {
        "gains": ({"F": law}, {KP: some, KD: other}),
        "a parameter of the model": ({"F": law * mass}, {"M": other}),
        "time": ({"F": KP / 10 * kn.sin(W * kn.time)}, {W: other, KP: some}),
        "columns": ({}, {"F": some / 30}),
        "saturation": ({"F": kn.where(kn.less(law, MOST), law, MOST)}, {MOST: other}),
        "pulses": ({"F": kn.exp(-(((kn.time - W) / 0.02) ** 2)) * KP}, {W: other, KP: some}),
        "steps": ({"F": kn.where(kn.less(kn.time, W), KP / 20, 0.0)}, {W: other, KP: some}),
    }
    return eom, start, *laws[name]


NAMES = (
    "gains",
    "a parameter of the model",
    "time",
    "columns",
    "saturation",
    "pulses",
    "steps",
    "a prescribed path",
    "a constant path",
    "an event",
    "constraints",
)


@pytest.mark.parametrize("lanes", [False, True])
@pytest.mark.parametrize("name", NAMES)
def test_one_kernel_runs_inputs_that_differ(
    name: str, lanes: bool, rng: np.random.Generator, separate: list[Any]
) -> None:
    eom, start, inputs, columns = ways(name, rng)
    given: dict[str, Any] = {"parameters": {s: v for s, v in columns.items() if not is_input(eom, s)}}
    moved = {s: v for s, v in columns.items() if is_input(eom, s)}
    outputs = {str(s): s for s in eom.state} | {"force": eom.inputs[0], "change": eom.accelerations[0]}
    options: dict[str, Any] = {"samples": 9, "method": "vern9", "settings": kn.Settings(contract=False)}
    runs = kn.simulate_many(
        eom, (0, 4), **start, inputs={**inputs, **moved}, outputs=outputs, lanes=lanes, **given, **options
    )
    for k in range(0, COUNT, 10):
        one = kn.simulate(
            eom,
            (0, 4),
            **{kind: at(values, k) for kind, values in start.items()},
            inputs={**inputs, **at(moved, k)},
            parameters=at(given["parameters"], k),
            max_seconds=1e3,
            **options,
        )
        rows = np.searchsorted(one.t, runs["t"].values, side="right") - 1
        for label, what in outputs.items():
            exact = 1e-11 * np.abs(one[what]).max() if name == "constraints" else 0.0
            np.testing.assert_allclose(runs[label].values[k], one[what][rows], rtol=0, atol=exact)
    assert set(runs["status"].values) == {"finished"}
    assert separate == []


def is_input(eom: kn.Equations, key: Any) -> bool:
    return isinstance(key, str) and key in {s.name for s in eom.inputs}


def at(values: Any, k: int) -> Any:
    """The values of an instance."""
    if not isinstance(values, dict):
        return values
    return {s: float(v[k]) if isinstance(v, np.ndarray) else v for s, v in values.items()}


@pytest.mark.parametrize("method", ["auto", "vern9", "radau9"])
def test_prepared_motions_take_parameters_of_inputs(method: str) -> None:
    eom, law, mass = cart()
    inputs = {"F": law * mass + KP * kn.sin(KD * kn.time)}
    run = kn.prepare(eom, (0, 2), inputs=inputs, samples=9, method=method)
    assert run.in_one_call
    for parameters in ({}, {KP: 10.0}, {KP: 10.0, KD: 3.0}, {"M": 2.0, KP: 11.0}, {KP: 10.0}):
        other = kn.derive(eom.system)  # nothing is prepared for these
        wanted = kn.simulate(
            other, (0, 2), q=[0.1, 0.2], u=[0, 0], inputs=inputs, parameters=parameters, samples=9, method=method
        )
        found = run(q=[0.1, 0.2], u=[0, 0], parameters={str(s): v for s, v in parameters.items()})
        assert np.array_equal(found.states, wanted.states)
        assert np.array_equal(found["F"], wanted["F"])
        assert found.steps == wanted.steps
        assert np.array_equal(found[KP * eom.coordinates[0]], parameters.get(KP, 40.0) * found["x"])


def test_a_parameter_that_is_left_out_has_its_default_again() -> None:
    """The energy check and the start read the inputs in Python: a prescribed path, in the kinetic energy and at a constraint."""
    eom, inputs = shaken(), {"r": 0.1 * kn.sin(KD * kn.time + KP / 40)}
    run = kn.prepare(eom, (0, 2), inputs=inputs, samples=9)
    assert run.in_one_call
    for parameters in ({KD: 3.0, KP: 20.0}, {}, {KD: 5.0}, {KP: 10.0}, {}):
        found = run(q=[0.2], u=[0], parameters=parameters)
        wanted = kn.simulate(
            kn.derive(eom.system), (0, 2), q=[0.2], u=[0], inputs=inputs, parameters=parameters, samples=9
        )
        assert np.array_equal(found.states, wanted.states)
        assert np.array_equal(found["r"], wanted["r"])
        assert found.keeps_energy


def slider() -> kn.Equations:
    """A particle on a spring, on a line whose height an input prescribes."""
    N, (x, y), (u, v) = kn.Frame("N"), kn.coordinates("x y", "m"), kn.speeds("u v", "m/s")
    r, k = kn.input("r", "m"), kn.parameter("k", 5.0, "N/m")
    P = kn.Point("O", fixed_in=N).at("P", x * N.x + y * N.y)
    system = kn.System(
        N,
        bodies=[kn.Particle("slider", P, kn.parameter("m", 1.0, "kg"))],
        speeds={u: x.dt, v: y.dt},
        loads=[kn.Force(P, -k * x * N.x)],
        holonomic=[y - r],
    )
    return kn.derive(system)


@pytest.mark.slow
def test_the_start_is_on_a_path_whose_parameters_differ(separate: list[Any]) -> None:
    """Its place at the start follows from the parameters of each instance, and of each call."""
    eom, path = slider(), {"r": KP * kn.cos(KD * kn.time)}
    (x, y), (u, v) = eom.coordinates, eom.speeds
    heights, rates = np.linspace(0.1, 1.5, COUNT), np.linspace(1, 4, COUNT)
    options: dict[str, Any] = {
        "q": {x: 0.3, y: kn.guess(0.0)},
        "u": {u: 0.2, v: kn.guess(0.0)},
        "inputs": path,
        "samples": 5,
    }
    for lanes in (False, True):
        runs = kn.simulate_many(
            eom, (0, 2), parameters={KP: heights, KD: rates}, lanes=lanes, method="vern9", **options
        )
        wanted = heights[:, None] * np.cos(rates[:, None] * runs["t"].values)
        np.testing.assert_allclose(runs["y"].values, wanted, rtol=0, atol=1e-12)
        exact = 0.3 * np.cos(np.sqrt(5) * runs["t"].values) + 0.2 / np.sqrt(5) * np.sin(np.sqrt(5) * runs["t"].values)
        np.testing.assert_allclose(runs["x"].values, np.broadcast_to(exact, (COUNT, 5)), rtol=0, atol=1e-7)
    assert separate == []
    run = kn.prepare(eom, (0, 2), inputs=path, samples=5)
    for height in (2.0, None, 3.0):
        found = run(q=options["q"], u=options["u"], parameters={KD: 2.0} | ({} if height is None else {KP: height}))
        np.testing.assert_allclose(found["y"], (height or 40.0) * np.cos(2 * found.t), rtol=1e-12, atol=1e-11)


def test_a_parameter_of_inputs_without_a_value_is_named() -> None:
    eom, _, _ = cart()
    run = kn.prepare(eom, (0, 1), inputs={"F": W * eom.coordinates[1]}, samples=3)
    assert not run.in_one_call
    with pytest.raises(kn.ValueMissingError, match="none for w"):
        run(q=[0, 0.1], u=[0, 0])
    assert run(q=[0, 0.1], u=[0, 0], parameters={W: 2.0}).status == "finished"


def test_gains_of_motions_with_contacts(separate: list[Any]) -> None:
    """A block on a floor is pushed by a force whose amplitude and feedback differ; no instance is simulated separately."""
    eom = pushed()
    (x, _), (m,), F = eom.coordinates, [s for s in eom.parameters if s.name == "m"], eom.inputs[0]
    laws = {
        "gains": KP / 2 * kn.sin(3 * kn.time) - KD * eom.speeds[0] / 10 - m * x,
        "time": KP / 2 * kn.sin(KD * kn.time),
        "steps": kn.where(kn.less(kn.time, KD / 5), KP / 2, 0.0),
    }
    rng = np.random.default_rng(1)
    columns = {KP: rng.uniform(20, 60, 8), KD: rng.uniform(3, 9, 8), m: rng.uniform(1, 3, 8)}
    for name, law in laws.items():
        options: dict[str, Any] = {"q": [0, 0], "u": [0.3, 0], "inputs": {"F": law, "H": 0.0}, "samples": 9}
        separate.clear()
        runs = kn.simulate_many(eom, (0, 3), **options, parameters=columns, outputs={"x": x, "F": F}, threads=1)
        # those that come to a mode first; inputs that break at other times have kernels of their own
        assert len(separate) <= (8 if name == "steps" else 3)
        run = kn.prepare(eom, (0, 3), **{name: v for name, v in options.items() if name not in "qu"})
        for k in range(8):
            own = {s: float(v[k]) for s, v in columns.items()}
            one = kn.simulate(kn.derive(eom.system), (0, 3), **options, parameters=own)
            rows = np.searchsorted(one.t, runs["t"].values, side="right") - 1
            assert np.array_equal(runs["x"].values[k], one["x"][rows])
            assert np.array_equal(runs["F"].values[k], one["F"][rows])
            again = run(q=[0, 0], u=[0.3, 0], parameters=own)
            assert np.array_equal(again.states, one.states)
            assert np.array_equal(again["F"], one["F"])


def test_derivatives_by_columns_of_inputs() -> None:
    """`by=` names an input that is a number for each instance; beside differences."""
    eom, _, _ = cart()
    forces = np.array([0.5, 1.0, 1.5])
    options: dict[str, Any] = {"q": [0.1, 0.2], "u": [0, 0], "samples": 3, "rtol": 1e-11, "atol": 1e-11}
    runs = kn.simulate_many(eom, (0, 1), inputs={"F": forces}, by=["F"], **options)
    h = 1e-5
    more, less = (kn.simulate_many(eom, (0, 1), inputs={"F": forces + s}, **options) for s in (h, -h))
    wanted = (more["x"].values - less["x"].values) / (2 * h)
    np.testing.assert_allclose(runs["x_by"].values[..., 0], wanted, rtol=1e-7, atol=1e-9)


@pytest.mark.parametrize("name", ["F", "steps", "status", "t"])
def test_an_output_with_the_name_of_another_variable_is_refused(name: str) -> None:
    eom, _, _ = cart()
    with pytest.raises(kn.SimulationError, match=f"got {name}"):
        kn.simulate_many(
            eom, (0, 1), q=[0.1, 0.2], u=[0, 0], inputs={"F": [0.5, 1.0]}, outputs={name: eom.inputs[0]}, samples=3
        )


def test_functions_to_check_are_a_list() -> None:
    eom, _, _ = cart()
    wrong: Any = False
    with pytest.raises(kn.ArgumentError, match="a list of integrals or expressions to check, got False"):
        kn.simulate(eom, (0, 1), q=[0.1, 0.2], u=[0, 0], inputs={"F": 0.5}, check=wrong)


@pytest.mark.parametrize("rate", [2.0, 40.0])
def test_a_path_may_oscillate_many_times(rate: float) -> None:
    """A smooth expression needs no check of its derivative by integrals, which fast oscillations would fail."""
    eom, path = slider(), {"r": KP * kn.cos(KD * kn.time)}
    (x, y), (u, v) = eom.coordinates, eom.speeds
    options: dict[str, Any] = {"q": {x: 0.3, y: kn.guess(0.0)}, "u": {u: 0.2, v: kn.guess(0.0)}}
    parameters = {KP: 0.1, KD: rate}
    found = kn.simulate(eom, (0, 400), inputs=path, samples=9, parameters=parameters, **options)
    np.testing.assert_allclose(found["y"], 0.1 * np.cos(rate * found.t), rtol=0, atol=1e-12)
    other = kn.parameter("r0") * kn.time
    with pytest.raises(kn.SimulationError, match="derivative of the input r to match"):
        kn.simulate(eom, (0, 4), inputs={"r": (lambda t: t, lambda t: 2.0, lambda t: 0.0)}, samples=9, **options)
    run = kn.prepare(eom, (0, 400), inputs={"r": other}, samples=9)
    assert run(parameters={"r0": 0.1}, **options)["y"][-1] == pytest.approx(40, rel=1e-12)


def test_corners_in_the_law_of_a_force_beside_a_prescribed_path() -> None:
    eom = shaken()
    bob = next(p for p in eom.points if p.name == "P")
    pushed = kn.Force(bob, kn.input("F", "N") * eom.system.inertial.x)
    eom = kn.derive(eom.system.replace(loads=[*eom.system.loads, *eom.system.gravities, pushed]))
    (q,), (u,) = eom.coordinates, eom.speeds
    laws: dict[str, Any] = {"r": 0.1 * kn.sin(KD / 4 * kn.time), "F": kn.where(kn.less(u, 0), KP / 40, -KP / 40) - q}
    run = kn.prepare(eom, (0, 2), inputs=laws, samples=9)
    assert run.in_one_call
    for value in (10.0, 20.0, 40.0):
        options: dict[str, Any] = {"q": [0.2], "u": [0], "parameters": {KP: value}}
        wanted = kn.simulate(kn.derive(eom.system), (0, 2), inputs=laws, samples=9, **options)
        assert np.array_equal(run(**options).states, wanted.states)


def test_parameters_of_inputs_are_numbers() -> None:
    eom, law, _ = cart()
    options: dict[str, Any] = {"q": [0.1, 0.2], "u": [0, 0]}
    run = kn.prepare(eom, (0, 1), inputs={"F": law}, samples=3)
    values: list[Any] = ["a", None, [1.0, 2.0], np.nan]
    for wrong in values:
        with pytest.raises(kn.SimulationError, match="value for kp"):
            run(parameters={KP: wrong}, **options)
        with pytest.raises(kn.SimulationError, match="value for kp"):
            kn.simulate(eom, (0, 1), inputs={"F": law}, samples=3, parameters={"kp": wrong}, **options)


def test_laws_of_several_inputs_in_a_list() -> None:
    """As in `kn.simulate`, a tuple of inputs may have a law each."""
    N, x, v = kn.Frame("N"), kn.coordinate("x"), kn.speed("v")
    F, G = kn.inputs("F G")
    P = kn.Point("O", fixed_in=N).at("P", x * N.x)
    system = kn.System(N, bodies=[kn.Particle("mass", P, 2)], speeds={v: x.dt}, loads=[kn.Force(P, (F + G * v) * N.x)])
    eom, columns = kn.derive(system), {KP: np.array([20.0, 50.0, 60.0]), KD: np.array([1.0, 0.0, 4.0])}
    options: dict[str, Any] = {"q": [0.1], "u": [0.2], "inputs": {(F, G): [-KP * x, -KD / 10]}, "samples": 5}
    runs = kn.simulate_many(eom, (0, 1), parameters=columns, lanes=False, **options)
    for k in range(3):
        one = kn.simulate(kn.derive(system), (0, 1), parameters=at(columns, k), **options)
        assert np.array_equal(runs["x"].values[k], one["x"])


def test_parameters_of_inputs_have_names_of_their_own() -> None:
    """A name would stand for two parameters, of which the one in the model may be meant."""
    eom, _, mass = cart()
    theta = eom.coordinates[1]
    for law in (kn.parameter("M", 7.0) * theta, KP * theta - kn.parameter("kp", 7.0) * eom.speeds[1]):
        options: dict[str, Any] = {"q": [0.1, 0.2], "u": [0, 0], "inputs": {"F": law}, "samples": 3}
        for parameters in ({"M": 2.0}, {mass: 2.0}):
            with pytest.raises(kn.ValueMissingError, match=r"names of their own, got kn\.parameter"):
                kn.simulate(eom, (0, 1), parameters=parameters, **options)
            with pytest.raises(kn.ValueMissingError, match=r"names of their own, got kn\.parameter"):
                kn.simulate_many(eom, (0, 1), parameters={s: [v, 3.0] for s, v in parameters.items()}, **options)
