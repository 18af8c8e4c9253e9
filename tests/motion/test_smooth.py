# SPDX-License-Identifier: BSD-3-Clause
"""What prescribes a motion must be smooth: rounding is no jump, jumps are found however short the span, at a cost that is linear."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane import Expr, evaluate
from kane.motion import smooth
from tests.examples import examples

t = kn.time
q, u = kn.coordinate("q", "m"), kn.speed("u", "m/s")


def spin_up(rise: float = 15.0) -> Expr:
    """An angle whose rate rises as t − sin t does: differences of terms that cancel where t is small."""
    a = 2 * np.pi / rise
    ramp = 6 / rise * (t**2 / 2 + (kn.cos(a * t) - 1) / a**2)
    return kn.where(kn.less(t, rise), ramp, 6 * (t - rise / 2))


def equations(angle: Any) -> kn.Equations:
    """A bead on a rod that turns as prescribed."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    A = N.rotate("A", angle, N.z)
    bead = kn.Particle("bead", O.at("P", q * A.x), 1.0)
    return kn.derive(kn.System(N, bodies=[bead], speeds={u: q.dt}))


def check(angle: Expr, span: tuple[float, float]) -> None:
    smooth.check_prescribed(equations(angle), {}, span)


def test_a_short_span_of_a_ramp() -> None:
    for end in (1e-1, 1e-2, 1e-3, 1e-4):
        sol = kn.simulate(equations(spin_up()), (0, end), q=[1.0], u=[0.0], samples=3)
        assert sol.status == "finished"


@examples(0.3)
@given(st.floats(-6, 3), st.floats(0, 1), st.floats(-6, 1))
def test_rounding_is_no_jump(rise: float, start: float, length: float) -> None:
    """Whatever the time of the rise, the start, and the length of the span."""
    begin = 10**rise * start
    check(spin_up(10**rise), (begin, begin + 10 ** (rise + length)))


@examples(0.3)
@given(st.floats(-6, 3), st.floats(0.05, 0.95), st.floats(-2, 2))
def test_jumps_are_found(length: float, share: float, size: float) -> None:
    """In a span of any length, beside a value that changes as much, and in the velocity as in the place."""
    end = 10**length
    at = end * share
    late = t / end - share
    for jump, what in ((10**size, "prescribed"), (10**size * late, "velocity of the prescribed")):
        with pytest.raises(kn.SimulationError, match=f"{what} .* without jumps"):
            check(kn.where(kn.less(t, at), t / end, t / end + jump), (0.0, end))


def test_a_written_input_may_be_short_too() -> None:
    """What is given as an expression is asked at all times at once, and its rounding is known."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    turn = kn.input("turn", "rad")
    A = N.rotate("A", turn, N.z)
    bead = kn.Particle("bead", O.at("P", q * A.x), 1.0)
    eom = kn.derive(kn.System(N, bodies=[bead], speeds={u: q.dt}))
    sol = kn.simulate(eom, (0, 1e-3), q=[1.0], u=[0.0], inputs={turn: spin_up()}, samples=3)
    assert sol.status == "finished"


def test_all_pieces_are_walked_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pieces within each other share what they are made of: one walk for any number of them."""
    walks = []

    def counted(exprs: Any, values: Any) -> Any:
        walks.append(len(exprs) if isinstance(exprs, list) else 1)
        return evaluate(exprs, values)

    monkeypatch.setattr(smooth, "evaluate", counted)
    angle: Expr = 0 * t
    for k in range(1, 31):
        late = t - k / 40
        angle = kn.where(kn.less(t, k / 40), angle, angle + late * late * late)
    check(angle, (0.0, 1.0))
    assert walks == [90]


def test_what_turns_at_the_beginning_is_no_jump_within() -> None:
    """|sin t| from t = 0 to π has one velocity in all of the span; beyond it bends."""
    check(abs(kn.sin(t)), (0.0, 3.0))
    check(abs(kn.sin(t)), (0.0, float(np.pi)))
    with pytest.raises(kn.SimulationError, match=r"velocity of the prescribed abs\(sin\(t\)\) without jumps"):
        check(abs(kn.sin(t)), (0.0, 4.0))


@pytest.mark.slow
@pytest.mark.parametrize("angle", [kn.max(0, t - 1) ** 2, abs(kn.sin(t)) ** 3, abs(t - 1) * (t - 1)])
def test_what_bends_may_stand_in_what_is_smooth(angle: Expr) -> None:
    """It is the angle that must not jump, not a part of it; the motion is that of its own rates."""
    check(angle, (0.0, 4.0))
    sol = kn.simulate(equations(angle), (0, 4), q=[1.0], u=[0.0], samples=5)
    assert not sol.energy_check.exceeds(1e-6)
    with pytest.raises(kn.SimulationError, match="without jumps"):
        check(angle + kn.max(0, t - 2), (0.0, 4.0))


def test_tables_prescribe_motions_where_they_are_smooth() -> None:
    points = [0, 1, 2, 3], [0, 0.2, 1, 0.4]
    for kind, told in (("linear", "velocity of the prescribed table"), ("steps", "the prescribed table")):
        with pytest.raises(kn.SimulationError, match=told):
            check(kn.table(*points, kind)(t), (0.0, 2.5))
    check(kn.table(*points, "cubic")(t), (0.0, 2.5))
    check(kn.table(*points, "linear")(t) * (t - 1) ** 2 * (t - 2) ** 2, (0.0, 2.5))
