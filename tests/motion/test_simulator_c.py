# SPDX-License-Identifier: BSD-3-Clause
"""Programs in C that simulate: compiled by cc alone, clean under the sanitizers, on the trajectory of `simulate`."""

import subprocess

import numpy as np
import pytest

import kane as kn
from kane.gallery import GALLERY, double_pendulum, load, muscle_arm, pendulum_on_cart, rolling_disk
from kane.motion import METHODS, emit_simulator, is_constrained
from tests.motion.test_time_breaks import KINDS, PULSES, L, S, V, wheel
from tests.program.programs import compiler

STRICT = ["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror"]
SANITIZED = ["-O0", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
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
    x, v, k = kn.coordinate("x"), kn.speed("v"), kn.parameter("k", 1.0)
    N = kn.Frame("N")
    P = kn.Point("O", fixed_in=N).at("P", x * N.x)

    def line(force, at=P, **more):
        loads = [kn.Force(at, force * N.x)]
        return kn.System(N, bodies=[kn.Particle("p", at, 1)], speeds={v: x.dt}, loads=loads, **more)

    told = refused(line(-kn.table([-1, 0], [1, 2], "steps")(x)))
    assert "jump by tables of steps, or jump in equations with choices of pivots. Emit only the equations" in told
    for name in ("rtol", "atol", "max_step"):
        told = refused(line(-k * x + kn.parameter(name, 1.0)))
        assert f"the program's settings, rtol, atol, max_step, got {name!r} of the system" in told
    told = refused(line(-k * x, events=[kn.Event("down", x, then=lambda **now: {v: 0.0})]))
    assert "the event 'down' needs decisions that numbers alone do not determine" in told
    for kept in (load("four_bar").system(), line(-x, events=[kn.Event("down", x)])):
        with pytest.raises(kn.ProgramError, match=r"must be satisfied|are watched"):
            emit_simulator(kn.derive(kept).compile(), "midpoint")
    for period in (0.0, -1, np.nan, np.inf, "0.1", True, [0.1]):
        with pytest.raises(kn.ProgramError, match="Expected a period above zero"):
            emit_simulator(EOM.compile(), "rk4", period)
    assert "switches rates and is not a linear function of time" in refused(line(kn.sign(kn.sin(kn.time))))
    for height in (kn.max(kn.time - 1, 0), kn.table([0, 1, 2], [0, 1, 0], "linear")(kn.time)):
        assert "prescribes a motion, which may jump" in refused(line(-x, P.at("Q", height * N.y)))
    with pytest.raises(kn.ProgramError, match=r"Expected an integrator among .*dop853.* got 'gauss16'"):
        emit_simulator(kn.derive(double_pendulum.system()).compile(), "gauss16")
    text = emit_simulator(EOM.compile(name="cart"), "rk4")
    assert "@" not in text
    assert "int main(" in text


@pytest.mark.slow
@pytest.mark.parametrize("name", GALLERY)
def test_every_system_of_the_gallery_runs(tmp_path, name, rng):
    """Compiled with all warnings as errors, run under the sanitizers, on the trajectory of `simulate`."""
    module = load(name)
    eom = kn.derive(module.system())
    if is_constrained(eom) or eom.system.contacts:  # test_c_contacts.py
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


def agrees(program, arguments, sol, tolerance):
    """A program's rows are those of a motion, two of one time where an event changes the state; its events are those too."""
    done = ran(program, f"{sol.t[-1] if sol.status == 'finished' else 9}", *arguments)
    _, table = numbers(done.stdout)
    assert table.shape == (len(sol.t), sol.states.shape[1] + 1)
    assert np.abs(table[:, 0] - sol.t).max() < tolerance
    assert np.abs(table[:, 1:] - sol.states).max() < tolerance * max(1.0, np.abs(sol.states).max())
    noted = [line.rsplit(" at t = ", 1) for line in done.stderr.splitlines()]
    met = [(e.name, t) for e, t in sol.events if not e.name.startswith("dependent speeds")]
    noted = [(name, float(t)) for name, t in noted if name != "other dependent speeds"]
    assert [name for name, _ in noted] == [name for name, _ in met]
    assert np.allclose([t for _, t in noted], [t for _, t in met], rtol=0, atol=tolerance)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["dop853", "tsit5"])
def test_a_ball_bounces(tmp_path, method):
    """Events that set the state, one that is noted, and one that ends the motion; a start on a threshold is refused."""
    N = kn.Frame("N")
    y, v, e = kn.coordinate("y"), kn.speed("v"), kn.parameter("e", 0.8)
    events = [
        kn.Event("bounce", y, direction=-1, then={v: -e * v}),
        kn.Event("top", v, direction=-1, terminal=False),
        kn.Event("low", y + v**2 / 2 / 9.81 - 0.1, direction=-1),
    ]
    P = kn.Point("O", fixed_in=N).at("P", y * N.y)
    eom = kn.derive(
        kn.System(
            N, bodies=[kn.Particle("ball", P, 2)], speeds={v: y.dt}, loads=[kn.gravity(-9.81 * N.y)], events=events
        )
    )
    program = built(tmp_path, eom, method, *SANITIZED)
    sol = kn.simulate(eom, (0, 9), q=[1], u=[0.5], samples=91, method=method)
    assert (sol.status, sol.event.name, len(sol.jumps)) == ("event", "low", 6)
    agrees(program, ("91", "y=1", "v=0.5"), sol, 1e-11)
    assert (
        "Expected a start beside the threshold of the event top" in ran(program, "9", "9", "y=1", "v=0", code=2).stderr
    )


def closing(eom):
    """The closures at a row of a table, by default parameters."""
    rest = {p: p.default for p in eom.parameters}
    closures = [c.expr for c in eom.system.holonomic]

    def at(row):
        state = dict(zip(eom.coordinates, row[1:], strict=False))
        return [kn.evaluate(f, {**rest, **state}) for f in closures]

    return at


@pytest.mark.slow
def test_a_four_bar_turns(tmp_path):
    """Three turns of the crank, for which other speeds become dependent; a start that does not close is refused."""
    module = load("four_bar")
    eom = kn.derive(module.system())
    start = kn.assemble(eom, **module.START)
    program = built(tmp_path, eom, "dop853", *SANITIZED)
    given = [f"{s.name}={float(x)!r}" for part in (start.q, start.u) for s, x in part.items()]
    sol = kn.simulate(eom, (0, 3), q=start.q, u=start.u, samples=31, method="dop853")
    done = ran(program, "3", "31", *given)
    _, table = numbers(done.stdout)
    assert "other dependent speeds at t = " in done.stderr
    assert np.abs(table[:, 1:] - sol.states).max() < 1e-8 * np.abs(sol.states).max()
    closures = closing(eom)
    assert max(abs(f) for row in table for f in closures(row)) < 1e-13
    told = ran(program, "3", "31", *given, f"{eom.coordinates[0].name}=0.3", code=2).stderr
    assert "Expected a start on the constraints" in told


@pytest.mark.slow
def test_a_disk_slides_until_it_rolls(tmp_path):
    """The end of slip, at a share of the largest slip of the motion."""
    eom = kn.derive(rolling_disk.system())
    program = built(tmp_path, eom, "vern9", *SANITIZED)
    q, u = [0, 0, 0.3, 1.2, 0.1], [1.0, -0.5, 3.0, 0.5, 0.2]
    sol = kn.simulate(eom, (0, 9), q=q, u=u, samples=901, method="vern9")
    assert sol.event.name == "onset of rolling (friction)"
    agrees(program, ("901", *(f"{s.name}={x}" for s, x in zip(eom.state, q + u, strict=True))), sol, 1e-8)


@pytest.mark.slow
def test_an_event_ends_a_mechanism_on_its_constraints(tmp_path):
    """The last row is that of `simulate`, and closes as the others do."""
    module = load("four_bar")
    crank = kn.derive(module.system()).coordinates[0]
    eom = kn.derive(module.system().replace(events=[kn.Event("turned", crank - 3)]))
    start = kn.assemble(eom, **module.START)
    program = built(tmp_path, eom, "dop853", *SANITIZED)
    given = [f"{s.name}={float(x)!r}" for part in (start.q, start.u) for s, x in part.items()]
    sol = kn.simulate(eom, (0, 9), q=start.q, u=start.u, samples=901, method="dop853")
    assert sol.event.name == "turned"
    done = ran(program, "9", "901", *given)
    _, table = numbers(done.stdout)
    assert np.abs(table[-1] - [sol.t[-1], *sol.states[-1]]).max() < 1e-9
    assert max(map(abs, closing(eom)(table[-1]))) < 1e-13


CONTROLLER = """
void cart_control(double t, const double *x, double *inputs)
{
    (void)t;
    inputs[0] = 9.0 * x[1] + 2.0 * x[3] + 0.3 * x[0] + 0.6 * x[2];
}
"""


@pytest.mark.slow
def test_a_controller_in_c_is_sampled(tmp_path):
    """The law of another file, asked at each period: the motion of the same law in Python."""
    (tmp_path / "control.c").write_text(CONTROLLER)
    (tmp_path / "cart.c").write_text(emit_simulator(EOM.compile(name="cart"), "dop853", 0.01), encoding="utf-8")
    program = tmp_path / "cart"
    files = [tmp_path / "cart.c", tmp_path / "control.c"]
    subprocess.run([compiler(), *STRICT, *SANITIZED, *files, "-o", program, "-lm"], check=True)
    control = kn.sampled(lambda t, x: 9.0 * x[1] + 2.0 * x[3] + 0.3 * x[0] + 0.6 * x[2], period=0.01)
    sol = kn.simulate(EOM, (0, 3), q=[0.1, 0.2], u=[0, 0], inputs={"F": control}, samples=31, method="dop853")
    _, table = numbers(ran(program, "3", "31", "x=0.1", "theta=0.2", "u_x=0", "u_theta=0").stdout)
    assert np.abs(table[:, 1:] - sol.states).max() < 1e-9 * np.abs(sol.states).max()
