# SPDX-License-Identifier: BSD-3-Clause
"""Programs in C that simulate: compiled by cc alone, clean under the sanitizers, on the trajectory of `simulate`."""

import subprocess

import numpy as np
import pytest

import kane as kn
from kane.gallery import double_pendulum, four_bar, muscle_arm, pendulum_on_cart
from kane.motion.simulator_c import METHODS, emit_simulator
from tests.program.programs import compiler

STRICT = ["-std=c99", "-Wall", "-Wextra", "-Wno-unused-function", "-Wno-unused-parameter", "-Werror"]
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
    program = built(tmp_path, EOM, "tsit5", "-O1", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
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


def test_what_a_motion_looks_after_is_refused():
    with pytest.raises(kn.ProgramError, match=r"nothing to be looked after between steps, got some with constraints"):
        emit_simulator(kn.derive(four_bar.system()).compile())
    with pytest.raises(kn.ProgramError, match=r"Expected an integrator among .*dop853.* got 'gauss16'"):
        emit_simulator(kn.derive(double_pendulum.system()).compile(), "gauss16")
    text = emit_simulator(EOM.compile(name="cart"), "rk4")
    assert "@" not in text
    assert "int main(" in text


@pytest.mark.slow
def test_further_states_begin_at_their_defaults(tmp_path):
    eom = kn.derive(muscle_arm.system())
    program = built(tmp_path, eom, "dop853", "-O1")
    head, table = numbers(ran(program, "1", "11", "q=-0.8", "u=0", "e=0.2").stdout)
    sol = kn.simulate(eom, (0, 1), q=[-0.8], u=[0], inputs={"e": 0.2}, samples=11, method="dop853")
    assert head == ["t", "q", "u", "a"]
    assert np.abs(table[:, 1:] - sol.states).max() < 2e-8
