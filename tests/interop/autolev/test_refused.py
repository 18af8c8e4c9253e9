# SPDX-License-Identifier: BSD-3-Clause
"""What is wrong in a text is named, with its line; hostile texts end soon."""

import time
from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from kane import KaneError, ModelError
from kane.exchange import from_autolev
from tests.examples import examples
from tests.interop.autolev import texts
from tests.peer import require

require("lark")

WRONG = {
    "a command": ("Gravity(-g*N2>)", "Gravitas(-g*N2>)", "Gravitas.*column 1.*line 15.*gravity"),
    "a name": ("theta' = omega", "theta' = omge", "omge at column 10.*line 9.*omega"),
    "a fault of the grammar": ("Mass B = m", "Mass B = (m", "a fault at column.*line 13"),
    "brackets": ("Mass B = m", "Mass B = m)", "closes none in line 13"),
    "a unit": ("m = 2 kg", "m = 2 kq", "a unit, got kq.*line 19"),
    "an axis": ("Simprot(N, B, 3, theta)", "Simprot(N, B, 4, theta)", "an axis 1, 2 or 3, got 4.*line 8"),
    "another orientation": ("theta' = omega", "Simprot(N, B, 1, theta)", "one orientation of B in N.*line 9"),
    "a body": ("Mass B = m", "Mass C = m", "a body or particle that has a mass, got c.*line 13"),
    "a scalar as a vector": ("Gravity(-g*N2>)", "Gravity(-g)", "a vector, got a scalar.*line 15"),
    "no velocity": ("P_NO_BO> = L/2*B1>\nV_BO_N> = Dt(P_NO_BO>, N)", "", "a position of BO"),
    "an output in a load": ("T1*N3>", "Ke()*N3>", "a vector of the model, got what ke.*line 16"),
    "another file": ("autoz on", "run other.al", "Run, which reads another file"),
    "a prescribed acceleration": ("theta' = omega", "theta' = omega\nomega' = 3", "got omega"),
    "a ring": ("theta' = omega", "theta' = omega\nVariables a, b\na = b\nb = 2*a", "a cycle"),
    "an exponent": ("Mass B = m", "Mass B = m^999999", "an exponent of at most 100"),
    "no inertial frame": ("Newtonian N\n", "Frames N\n", "Newtonian"),
    "a range": ("Constants g", "Constants x{1:99999999}, g", "a range of at most"),
    "no mass": ("Mass B = m\n", "", "a body or particle with a mass"),
}


@pytest.mark.parametrize("case", WRONG)
def test_faults_are_named_with_their_line(case: str) -> None:
    old, new, message = WRONG[case]
    assert old in texts.PENDULUM
    with pytest.raises(ModelError, match=f"(?s){message}"):
        from_autolev(texts.PENDULUM.replace(old, new))


@pytest.mark.parametrize(
    "text",
    [
        "x = " + "(" * 5000 + "1" + ")" * 5000 + "\n",
        "x = " + "+".join(["1"] * 20_000) + "\n",
        "x = " + "-" * 30_000 + "1\n",
        "x = " + "2^" * 30_000 + "1\n",
        "Constants a\nb0 = a\n" + "".join(f"b{k + 1} = b{k}^2 + b{k}\n" for k in range(2000)),
        "m = [1,2;3,4]\n" * 3000,
        "x = 1e999999999\n",
        "Newtonian N\n" + "\n".join(f"Frames A{k}" for k in range(3000)),
        "x = 1 &\n" * 20_000,
        "x" * 3_000_000 + "\n",
        "\n\n",
    ],
    ids=[
        "brackets",
        "sums",
        "signs",
        "powers",
        "squares",
        "matrices",
        "numbers",
        "frames",
        "lines",
        "letters",
        "nothing",
    ],
)
def test_hostile_texts_are_refused_soon(text: str) -> None:
    begin = time.monotonic()
    with pytest.raises(KaneError):
        from_autolev(text)
    assert time.monotonic() - begin < 20


LINES = [line for name in dir(texts) if name.isupper() for line in getattr(texts, name).splitlines()]
WORDS = st.sampled_from(
    ["N", "B", "q1", "u1'", "=", "(", ")", ">", "3", "*", "^", "[", "]", ",", "{2}", "0>", ";", "&", "'", "é", "\x00"]
)


@examples(2)
@given(st.data())
def test_mixed_lines_give_a_model_or_a_named_error(data: st.DataObject) -> None:
    lines = data.draw(st.lists(st.sampled_from(LINES), max_size=25))
    for _ in range(data.draw(st.integers(0, 3))):
        at = data.draw(st.integers(0, len(lines)))
        lines.insert(at, " ".join(data.draw(st.lists(WORDS, max_size=8))))
    with suppress(KaneError):  # anything else fails the test
        from_autolev("\n".join([*lines, ""]) + "\n")


@pytest.mark.parametrize(
    ("statement", "message"),
    [
        ("zz = dot(N1>)", "at least 2 arguments, got 1"),
        ("zz> = cross(N1>)", "at least 2 arguments, got 1"),
        ("zz = dot(N1>, N2>, N3>)", "2 arguments, got 3"),
        ("zz> = cross(N1>, N2>, N3>)", "2 arguments, got 3"),
        ("zz> = express(N1>)", "at least 2 arguments, got 1"),
        ("zz = mag()", "at least 1 argument, got none"),
        ("zz = sin()", "1 argument, got none"),
        ("zz = sin(theta, 2)", "1 argument, got 2"),
        ("zz = log10()", "1 argument, got none"),
        ("zz = max(1, 2, 3)", "2 arguments, got 3"),
        ("angvel(N)", "at least 2 arguments, got 1"),
        ("Gravity()", "at least 1 argument, got none"),
        ("B.AddTorque()", "at least 2 arguments, got 1"),
        ("BO.AddForceSpring(NO, 3)", "at least 4 arguments, got 3"),
        ("zz> = B.GetAngularVelocity()", "at least 2 arguments, got 1"),
        ("zz = Mass(N)", "bodies and particles that have a mass, got N"),
        ("Inertia I_B() = 3", "at least 1 argument, got none"),
    ],
)
def test_arguments_that_are_missing_are_named_with_their_line(statement: str, message: str) -> None:
    at = "Gravity(-g*N2>)"
    with pytest.raises(ModelError, match=f"(?s){message}.*line 15"):
        from_autolev(texts.PENDULUM.replace(at, statement))


def test_functions_of_angles_are_those_of_each_entry_of_a_matrix() -> None:
    text = texts.PENDULUM.replace("Gravity(-g*N2>)", "zz = sin([30, theta])\nGravity(-g*zz[1]*N2>)")
    half = texts.PENDULUM.replace("Gravity(-g*N2>)", "Gravity(-g/2*N2>)")
    assert from_autolev(text).eom.forcing is not None
    assert str(from_autolev(text).eom.accelerations[0]) == str(from_autolev(half).eom.accelerations[0])


def test_a_function_of_a_matrix_of_one_entry_is_a_matrix() -> None:
    text = texts.PENDULUM.replace("Gravity(-g*N2>)", "zz = sqrt([4])\nGravity(-g*zz[1]*N2>)")
    twice = texts.PENDULUM.replace("Gravity(-g*N2>)", "Gravity(-g*2*N2>)")
    assert str(from_autolev(text).eom.accelerations[0]) == str(from_autolev(twice).eom.accelerations[0])
