# SPDX-License-Identifier: BSD-3-Clause
"""Programs in C that simulate: compiled by cc alone, clean under the sanitizers, on the trajectory of `simulate`."""

import subprocess

import numpy as np
import pytest

import kane as kn
from kane.gallery import GALLERY, double_pendulum, load, muscle_arm, pendulum_on_cart
from kane.motion import METHODS, emit_simulator, is_constrained
from tests.motion.test_time_breaks import KINDS, PULSES, L, S, V, wheel
from tests.program.programs import compiler

STRICT = ["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror"]
SANITIZED = ["-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
EOM = kn.derive(pendulum_on_cart.system(force=True))


def built(folder, eom, method, *options):
    (folder / "cart.c").write_text(emit_simulator(eom.compile(name="cart"), method), encoding="utf-8")
    subprocess.run(
        [compiler(), *STRICT, *options, folder / "cart.c", "-o", folder / "cart", "-lm"],
        check=True,
        capture_output=True,
        text=True,
    )
    return folder / "cart"


def ran(program, *arguments, code=0):
    done = subprocess.run([program, *arguments], capture_output=True, text=True, check=False)
    assert done.returncode == code, done.stderr
    return done


def numbers(text):
    head, *lines = text.split()
    return head.split(","), np.array([[float(x) for x in line.split(",")] for line in lines])


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_the_trajectory_is_that_of_simulate(tmp_path, method):
    program = built(tmp_path, EOM, method, "-O1" if method == "dop853" else "-O2")
    step = {"max_step": 0.001} if method in ("rk4", "midpoint") else {}
    given = [
        "3",
        "31",
        "x=0.1",
        "theta=1",
        "u_x=0",
        "u_theta=2",
        "F=0.5",
        "m=0.7",
        *(f"{k}={v}" for k, v in step.items()),
    ]
    head, table = numbers(ran(program, *given).stdout)
    assert head == ["t", "x", "theta", "u_x", "u_theta"]
    sol = kn.simulate(
        EOM, (0, 3), q=[0.1, 1], u=[0, 2], inputs={"F": 0.5}, parameters={"m": 0.7}, samples=31, method=method, **step
    )
    assert np.allclose(table[:, 0], sol.t, rtol=1e-15)
    assert np.abs(table[:, 1:] - sol.states).max() < (1e-12 if step else 2e-8)


@pytest.mark.slow
def test_it_is_clean_under_the_sanitizers(tmp_path):
    program = built(tmp_path, EOM, "tsit5", *SANITIZED)
    ran(program, "2", "50", "x=0", "theta=1", "u_x=0", "u_theta=2", "F=0")
    for arguments, said in (
        ((), "Expected the time END > 0 and how many SAMPLES"),
        (("-1", "5"), "Expected the time END > 0"),
        (("1", "1"), "Expected the time END > 0"),
        (("1", "5", "x=0"), "Expected a value for theta, got none: pass theta=value"),
        (("1", "5", "y=0"), "Expected a name of the state, the parameters or the inputs, got y=0"),
        (("1", "5", "x"), "Expected name=value with a finite number, got x"),
        (("1", "5", "x=nan"), "Expected name=value with a finite number, got x=nan"),
        (
            ("1", "5", "x=0", "theta=0", "u_x=0", "u_theta=0", "F=0", "rtol=0"),
            "Expected rtol, atol and max_step above zero",
        ),
    ):
        assert said in ran(program, *arguments, code=2).stderr


def refused(system):
    with pytest.raises(kn.ProgramError) as told:
        emit_simulator(kn.derive(system).compile())
    return str(told.value)


def test_what_a_program_cannot_look_after_is_refused():
    x, v = kn.coordinate("x"), kn.speed("v")
    N = kn.Frame("N")
    P = kn.Point("O", fixed_in=N).at("P", x * N.x)

    def line(force, at=P, **more):
        loads = [kn.Force(at, force * N.x)]
        return kn.System(N, bodies=[kn.Particle("p", at, 1)], speeds={v: x.dt}, loads=loads, **more)

    told = refused(load("four_bar").system())
    assert "in which constraints or Euler parameters are kept. Emit the equations alone" in told
    assert "loads or inputs jump" in refused(line(-kn.sign(v)))
    assert "events are watched" in refused(line(-x, events=[kn.Event("down", x)]))
    assert "turns rates at times that no line gives" in refused(line(kn.sign(kn.sin(kn.time))))
    for height in (kn.max(kn.time - 1, 0), kn.table([0, 1, 2], [0, 1, 0], "linear")(kn.time)):
        assert "prescribes a motion, which may jump" in refused(line(-x, P.at("Q", height * N.y)))
    with pytest.raises(kn.ProgramError, match=r"Expected an integrator among .*dop853.* got 'gauss16'"):
        emit_simulator(kn.derive(double_pendulum.system()).compile(), "gauss16")
    text = emit_simulator(EOM.compile(name="cart"), "rk4")
    assert "@" not in text
    assert "int main(" in text


@pytest.mark.slow
@pytest.mark.parametrize("name", GALLERY)
def test_every_system_of_the_gallery_runs_or_is_refused(tmp_path, name, rng):
    """Compiled with all warnings as errors, run under the sanitizers, on the trajectory of `simulate`."""
    module = load(name)
    eom = kn.derive(module.system())
    if is_constrained(eom) or eom.events:
        assert "are kept" in refused(module.system()) or "are watched" in refused(module.system())
        return
    program = built(tmp_path, eom, "tsit5", *SANITIZED)
    start = getattr(module, "START", {})
    q, u = (
        {s.name: start.get(kind, {}).get(s.name, 0.5) + 1e-4 * float(rng.normal()) for s in symbols}
        for kind, symbols in (("q", eom.coordinates), ("u", eom.speeds))
    )
    inputs = {s.name: 0.1 for s in eom.inputs}
    values = {**q, **u, **inputs, **start.get("parameters", {})}
    head, table = numbers(ran(program, "0.5", "6", *(f"{k}={float(x)!r}" for k, x in values.items())).stdout)
    sol = kn.simulate(
        eom, (0, 0.5), q=q, u=u, inputs=inputs, parameters=start.get("parameters"), samples=6, method="tsit5"
    )
    assert head == ["t", *(s.name for s in eom.state)]
    assert np.abs(table[:, 1:] - sol.states).max() < 1e-6 * np.abs(sol.states).max()


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_roads_at_any_speed_are_felt(tmp_path, kind, rng):
    """Tables, corners and steps of V t, whose corners lie at times that the program finds: on the trajectory of `simulate`."""
    height = KINDS[kind][0]
    if isinstance(height, str):
        heights = rng.normal(size=9)
        heights[-1] = heights[0]
        places = np.cumsum(rng.uniform(0.01, 1, 9)).tolist()
        height = kn.table(places, heights.tolist(), height)((V * kn.time - S) / L)
    eom = wheel(height)
    program = built(tmp_path, eom, "tsit5", *SANITIZED)
    for _ in range(10):
        values = {"V": float(rng.uniform(0.5, 20)), "S": float(rng.uniform(-2, 5))}
        given = ["2", "5", "x=0", "v=0", *(f"{k}={x!r}" for k, x in values.items())]
        _, table = numbers(ran(program, *given).stdout)
        sol = kn.simulate(eom, (0, 2), q=[0], u=[0], parameters=values, samples=5, method="tsit5")
        assert np.abs(table[:, 1:] - sol.states).max() < 1e-7 * max(1, np.abs(sol.states).max())


@pytest.mark.slow
@pytest.mark.parametrize("method", ["dop853", "tsit5"])
def test_no_pulse_is_leapt_over(tmp_path, method):
    """Pulses of two hundredths of a second in five forms, each at a time of its own, in a load and in rates of further states."""
    x, v = kn.coordinate("x"), kn.speed("v")
    N = kn.Frame("N")
    P = kn.Point("O", fixed_in=N).at("P", x * N.x)
    places = {name: 0.9 + 1.7 * k for k, name in enumerate(("load", *PULSES))}
    at = {name: kn.parameter(f"at_{name}") for name in places}
    states = {kn.state(name, 0.0): form(kn.time - at[name]) for name, (form, _) in PULSES.items()}
    loads = [kn.Force(P, PULSES["where"][0](kn.time - at["load"]) * N.x)]
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("p", P, 1)], speeds={v: x.dt}, loads=loads, states=states))
    program = built(tmp_path, eom, method, "-O1")
    for moved in (0.0, 0.31):
        values = [f"at_{name}={place + moved}" for name, place in places.items()]
        head, table = numbers(ran(program, "12", "2", "x=0", "v=0", *values).stdout)
        last = dict(zip(head, table[-1], strict=True))
        assert last["v"] == pytest.approx(PULSES["where"][1], rel=1e-9)
        for name, (_, whole) in PULSES.items():
            assert last[name] == pytest.approx(whole, rel=1e-6), name


@pytest.mark.slow
def test_further_states_begin_at_their_defaults(tmp_path):
    eom = kn.derive(muscle_arm.system())
    program = built(tmp_path, eom, "dop853", "-O1")
    head, table = numbers(ran(program, "1", "11", "q=-0.8", "u=0", "e=0.2").stdout)
    sol = kn.simulate(eom, (0, 1), q=[-0.8], u=[0], inputs={"e": 0.2}, samples=11, method="dop853")
    assert head == ["t", "q", "u", "a"]
    assert np.abs(table[:, 1:] - sol.states).max() < 2e-8
