# SPDX-License-Identifier: BSD-3-Clause
"""Programs in C go from mode to mode of contacts: the bits of `simulate`, of the gallery and under the sanitizers."""

import subprocess
import warnings

import numpy as np
import pytest

import kane as kn
from kane.gallery import load
from kane.motion import emit_simulator
from tests.motion.emitted import EXACT, SANITIZED, bits, block, compiled, rows
from tests.motion.test_simulator_wasm import BRIEF, CONTACTS, OWN_MODES, sol_start
from tests.motion.test_standing import table, thrown

GIVEN = {"settings": EXACT, "rtol": 1e-9, "atol": 1e-9, "samples": 31}
ENDS = {"bouncing_ball": 5.0, "mass_on_belt": 10.0, "rocking_block": 5.0, "clutch": 3.0, "thrown_disk": 3.0, **BRIEF}
"""Ends of motions (s) other than 1 s."""


def known(eom, start, end, method="dop853", **more):
    """The motion of a runner that has taken up the modes: the second one."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for _ in range(2):
            sol = kn.simulate(eom, (0, end), method=method, **start, **GIVEN, **more)
    return sol


def values(eom, sol, start, **more):
    """What a program is given to begin where a motion began."""
    found = dict(zip((s.name for s in eom.state), sol_start(eom, start), strict=True))
    found |= {s.name: float(v) for s, v in sol.parameters.items() if s in set(eom.parameters)}
    return found | {s.name: float(sol.inputs[s](0.0)) for s in eom.inputs} | more


def same(eom, program, sol, start, end, **more):
    """The rows of a program are those of a motion, bit by bit."""
    table = rows(program, end, GIVEN["samples"], values(eom, sol, start, **more))
    expected = np.column_stack([sol.t, sol.states])
    assert table.shape == expected.shape
    assert np.array_equal(bits(table), bits(expected))


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(n, marks=() if n == "bouncing_ball" else pytest.mark.slow)
        for n in sorted(CONTACTS - set(OWN_MODES))
    ],
)
def test_contacts_of_the_gallery_are_those_of_simulate(tmp_path, name):
    """Impacts, stick and slip, mode after mode."""
    eom, start, end = kn.derive(load(name).system()), load(name).START, ENDS.get(name, 1.0)
    text = emit_simulator(eom.compile(name="model", contract=False))
    same(eom, compiled(tmp_path, "model", text, "-O0"), known(eom, start, end), start, end)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["rocking_block", "stacked_blocks"])
def test_it_is_clean_under_the_sanitizers(tmp_path, name):
    eom, start = kn.derive(load(name).system()), load(name).START
    program = compiled(tmp_path, "model", emit_simulator(eom.compile(name="model", contract=False)), *SANITIZED)
    same(eom, program, known(eom, start, 2.0), start, 2.0)


@pytest.mark.slow
def test_steps_of_one_length_are_more_than_a_call_takes(tmp_path):
    """A mode of 4,500 steps is gone on with."""
    eom, start = kn.derive(load("bouncing_ball").system()), load("bouncing_ball").START
    text = emit_simulator(eom.compile(name="model", contract=False), "rk4")
    sol = known(eom, start, 1.0, "rk4", max_step=1e-4)
    same(eom, compiled(tmp_path, "model", text, "-O0"), sol, start, 1.0, max_step=1e-4)


@pytest.mark.slow
def test_a_mode_that_there_is_not_is_named(tmp_path):
    """A program with the mode of the start alone ends where the next one begins."""
    eom, start = kn.derive(load("mass_on_belt").system()), load("mass_on_belt").START
    text = emit_simulator(eom.compile(name="model", contract=False), modes=[(kn.ContactMode.STICK,)])
    program, sol = compiled(tmp_path, "model", text, "-O0"), known(eom, start, 2.0)
    given = [f"{name}={x!r}" for name, x in values(eom, sol, start).items()]
    done = subprocess.run([program, "2", "31", *given], capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "at t = 0: belt: stick" in done.stderr
    assert (
        "t = 0.7848: the next mode of the contacts is not in the program: belt: slip. Emit the program with this mode"
        in done.stderr
    )
    assert float(done.stdout.split()[-1].split(",")[0]) == sol.events[0][1]


@pytest.mark.slow
def test_where_a_mode_breaks_off_its_rows_are_there(tmp_path):
    """A force that is infinite at t = 1.2 s, in flight: what was reached is printed, and no more."""
    system, start = load("bouncing_ball").system(), load("bouncing_ball").START
    (ball,) = system.bodies
    push = kn.Force(ball.point, 1e-3 / (1.2 - kn.time) ** 3 * system.inertial.y)
    eom = kn.derive(system.replace(loads=[*system.loads, push]))
    program = compiled(tmp_path, "model", emit_simulator(eom.compile(name="model", contract=False)), "-O0")
    done = subprocess.run([program, "3", "31", "y=1", "u_y=0"], capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "stopped at t = 1.2: no step is short enough" in done.stderr
    table = np.array([[float(x) for x in line.split(",")] for line in done.stdout.split()[1:]])
    sol = kn.simulate(eom, (0, 1.15), method="dop853", samples=np.linspace(0, 1.1, 12), rtol=1e-9, atol=1e-9, **start)
    np.testing.assert_allclose(table, np.column_stack([sol.t, sol.states])[: len(table)], rtol=1e-7)
    assert len(table) == 12


@pytest.mark.slow
def test_a_table_on_four_feet_is_led_until_its_forces_are_not_determined(tmp_path):
    """The bits of `simulate` as long as one foot is on the floor at a time; then the program says so, whatever modes it has."""
    eom, mode = table(4), kn.ContactMode
    one = [tuple(m if k == i else mode.SEPARATED for k in range(4)) for i in range(4) for m in (1, 2, 3)]
    every = [tuple(map(mode, m)) for m in ((0,) * 4, *one, (1,) * 4, (2,) * 4, (3,) * 4, (0, 3, 3, 0))]
    text = emit_simulator(eom.compile(name="model", contract=False), modes=every)
    program = compiled(tmp_path, "model", text, "-O0")
    for seed in range(3):
        given, q, u = thrown(seed, 4)
        sol = known(eom, {"q": q, "u": u}, 0.5, parameters=given)
        start = dict(zip((s.name for s in eom.state), [*q, *u], strict=True))
        numbers = [f"{name}={float(x)!r}" for name, x in (start | given).items()]
        done = subprocess.run([program, "0.5", "31", *numbers], capture_output=True, text=True, check=False)
        assert done.returncode == 1
        assert "numbers alone do not determine how it continues. Simulate it with kane." in done.stderr
        found = np.array([[float(x) for x in line.split(",")] for line in done.stdout.split()[1:]])
        expected = np.column_stack([sol.t, sol.states])[: len(found)]
        assert np.array_equal(bits(found), bits(expected))
        feet = np.array([sol.modes[f"f{k}"] != "separated" for k in range(4)])[:, : len(found)]
        assert feet.any()
        assert (feet.sum(axis=0) <= 1).all()
        for c in eom.system.contacts:
            assert sol[c.gap.expr][: len(found)].min() > -1e-12
            assert sol[c.normal_force][: len(found)].min() >= 0


CONTROLLER = """
void model_control(double t, const double *x, double *inputs);

void model_control(double t, const double *x, double *inputs)
{
    (void)x;
    inputs[0] = 4.0 * t;
}
"""


@pytest.mark.slow
def test_a_sampled_controller_pushes_until_it_slips(tmp_path):
    """The force goes up by 0.2 N each 0.05 s; where the next one is more than friction holds, it slips from then on."""
    eom = block()
    text = emit_simulator(eom.compile(name="model", contract=False), period=0.05)
    program = compiled(tmp_path, "model", text, "-O0", control=CONTROLLER)
    table = rows(program, 2.0, 41, {"x": 0.0, "u_x": 0.0})
    limit = 0.3 * 2 * 9.81
    first = np.ceil(limit / 4.0 / 0.05) * 0.05
    assert np.all(table[table[:, 0] <= first, 1:] == 0.0)
    v = sum((4.0 * 0.05 * k - 0.2 * 2 * 9.81) / 2 * 0.05 for k in range(round(first / 0.05), 40))
    assert table[-1, 2] == pytest.approx(v, abs=1e-9)


def rod():
    """A bead on a rigid rod without mass, which strikes a wall: a constraint holds in all modes."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, y = kn.coordinates("x y")
    P = O.at("P", x * N.x + y * N.y)
    place = kn.joints.point_on_plane("wall", P, O.at("W", -0.1 * N.x), normal=N.x)
    loads, bodies = [kn.gravity(-9.81 * N.y)], [kn.Particle("bead", P, 2)]
    contacts = [kn.contact(place, 0.1, restitution=0.6)]
    system = kn.System(N, bodies=bodies, speeds="rates", loads=loads, contacts=contacts, holonomic=[x**2 + y**2 - 1])
    return kn.derive(system)


@pytest.mark.slow
def test_constraints_that_hold_in_all_modes(tmp_path):
    """Other dependent speeds follow on the way, which Python chooses elsewhere: the motion is as near; a start off them is named."""
    eom, given = rod(), ({"x": 0.6, "y": -0.8}, {"u_x": 0.0, "u_y": 0.0})
    start = dict(zip("qu", given, strict=True))
    program = compiled(tmp_path, "model", emit_simulator(eom.compile(name="model", contract=False)), *SANITIZED)
    sol = known(eom, start, 3.0)
    assert {e.name for e, _ in sol.events} == {"wall closes", "dependent speeds u_y"}
    table = rows(program, 3.0, GIVEN["samples"], values(eom, sol, start))
    np.testing.assert_allclose(table, np.column_stack([sol.t, sol.states]), rtol=0, atol=1e-11)
    off = [f"{name}={x!r}" for name, x in ({**given[0], **given[1], "x": 0.61}).items()]
    done = subprocess.run([program, "1", "3", *off], capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "Expected a start on the constraints" in done.stderr


def test_what_is_refused():
    """Modes that hold one body together, more modes than a program has, events that act."""
    ball = kn.derive(load("bouncing_ball").system()).compile()
    with pytest.raises(
        kn.KaneError, match="a program in C supports, got modes with redundant contacts of one rigid body"
    ):
        emit_simulator(ball, modes=[(kn.ContactMode.ACROSS,)])
    with pytest.raises(kn.KaneError, match="got 64 modes of contacts, too many to include all"):
        emit_simulator(kn.derive(load("skidding_bicycle").system()).compile())
    with pytest.raises(kn.KaneError, match=r"for a program in C, got 'gauss16'"):
        emit_simulator(ball, "gauss16")
