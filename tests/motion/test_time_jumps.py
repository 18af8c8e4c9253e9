# SPDX-License-Identifier: BSD-3-Clause
"""Functions of time that jump are warned of, with the times; what is steep is not."""

import math
import warnings

import pytest

import kane as kn
from kane.motion import Asked, jumps

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
x, v, F = kn.coordinate("x"), kn.speed("v"), kn.input("F")
P = O.at("P", x * N.x)
EOM = kn.derive(kn.System(N, bodies=[kn.Particle("P", P, 2)], speeds={v: x.dt}, loads=[kn.Force(P, F * N.x)]))


@pytest.mark.parametrize(
    ("function", "wanted"),
    [
        (lambda t: float(t >= 1.3), [1.3]),
        (lambda t: 1e6 * (0.31 < t < 2.7), [0.31, 2.7]),
        (lambda t: 1e-6 * math.floor(t / 1.7), [1.7, 3.4]),
        (lambda t: math.sin(t) + (t > 2) * 1e-2, [2.0]),
        (lambda t: math.tanh((t - 2) / 1e-4), []),
        (lambda t: abs(t - 1.3), []),
        (lambda t: math.sqrt(abs(t - 1.3)), []),
        (lambda t: math.sin(40 * t), []),
        (lambda t: math.exp(10 * t), []),
        (lambda t: 3.0, []),
    ],
)
@pytest.mark.parametrize(("scale", "shift"), [(1.0, 0.0), (1e-3, 5.0), (1e4, -1e5)])
def test_jumps_are_found_in_any_unit_of_time(function, wanted, scale, shift):
    f = Asked("F", lambda t: function((t - shift) / scale))
    found = jumps(f, (shift, shift + 4 * scale))
    assert found == pytest.approx([shift + scale * t for t in wanted], rel=1e-9)


def test_a_jump_is_warned_of_unless_a_step_ends_there():
    given = {"q": [0], "u": [0], "inputs": {F: lambda t: 7.0 * (t >= 1.3)}}
    with pytest.warns(
        kn.KaneWarning, match=r"input F, got one that jumps at t = 1\.3, where .* breakpoints=\[1\.3\], or give"
    ):
        kn.simulate(EOM, (0, 4), **given)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sol = kn.simulate(EOM, (0, 4), breakpoints=[1.3], **given)
    assert sol.u[-1, 0] == pytest.approx(7 * 2.7 / 2, rel=1e-9)


@pytest.mark.parametrize("begin", [5.0, 5.013, 5.0195, 3.3333, 7.77])
def test_a_short_pulse_of_a_function_is_not_leapt_over(begin):
    """A five-hundredth of the span, wherever it lies, gives its impulse, and a warning."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, v = kn.coordinate("x"), kn.speed("v")
    F = kn.input("F")
    P = O.at("P", x * N.x)
    system = kn.System(N, bodies=[kn.Particle("P", P, 1)], speeds={v: x.dt}, loads=[kn.Force(P, F * N.x)])
    with pytest.warns(kn.KaneWarning, match="jumps at t = "):
        sol = kn.simulate(
            kn.derive(system), (0, 10), q=[0], u=[0], inputs={F: lambda t: 7.0 * (begin <= t < begin + 0.02)}
        )
    assert sol[v][-1] == pytest.approx(0.14, rel=1e-6)
    assert sol.steps >= 256
