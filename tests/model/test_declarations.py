# SPDX-License-Identifier: BSD-3-Clause
"""Events that cannot be meant are refused where they are declared."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane.gallery import pendulum

q = kn.coordinate("q")


@pytest.mark.parametrize(
    ("argument", "value"),
    [
        *(("threshold", x) for x in (np.nan, np.inf, "1", None, q, [1], 1j)),
        *(("direction", x) for x in (7, 0.5, "up", True, None, np.nan, [1])),
        *(("terminal", x) for x in ("no", 1)),
        *(("quantity", x) for x in ("q", 3.0, None, kn.Frame("N").x, [q])),
        *(("name", x) for x in ("", 3, None)),
        ("message", 3),
    ],
)
def test_what_is_said(argument: str, value: Any):
    arguments: dict[str, Any] = {"name": "e", "quantity": q, argument: value}
    with pytest.raises(kn.ModelError, match=f"^Expected {argument} of the event .*See kn.Event"):
        kn.Event(**arguments)


@given(st.floats(allow_nan=False, allow_infinity=False), st.sampled_from([-1, 0, 1, -1.0, np.int64(1)]), st.booleans())
def test_all_others_pass(threshold, direction, terminal):
    event = kn.Event("e", q, threshold, direction, terminal)
    assert (event.threshold, event.direction, event.terminal) == (threshold, direction, terminal)


def test_a_condition_is_never_met_at_its_own_values():
    condition = kn.less(q, 0)
    for threshold in (0.0, 1.0, 2.0):
        with pytest.raises(
            kn.ModelError, match=r"threshold of the event 'e', got the condition q < 0, .* threshold=0\.5\.$"
        ):
            kn.Event("e", condition, threshold)
    x, v = kn.coordinate("x"), kn.speed("v")
    frame = kn.Frame("N")
    bob = kn.Particle("P", kn.Point("O", fixed_in=frame).at("P", x * frame.x), 1.0)
    fallen = kn.Event("fallen", kn.less(x, 0), threshold=0.5, direction=1)
    eom = kn.derive(kn.System(frame, bodies=[bob], speeds={v: x.dt}, events=[fallen]))
    assert kn.simulate(eom, (0, 3), q=[1.0], u=[-1.0]).t[-1] == pytest.approx(1.0)


def test_a_system_s_events():
    system = pendulum.system()
    q = system.coordinates[0]
    with pytest.raises(kn.ModelError, match="events of different names, got 'e' more than once"):
        system.replace(events=[kn.Event("e", q), kn.Event("e", q, 1.0)])
    with pytest.raises(kn.ModelError, match=r"events= made by kn.Event.name, quantity., got 'e'"):
        system.replace(events=["e"])


def test_an_event_shows_what_it_waits_for_in_a_line():
    x, v = kn.coordinate("x"), kn.speed("v")
    assert repr(kn.Event("floor", x, direction=-1, then={v: -v})) == "Event('floor', x falls below 0: v := -v)"
    assert repr(kn.Event("far", x, threshold=2)) == "Event('far', x crosses 2: ends the simulation)"
    assert len(repr(kn.Event("long", sum((k * kn.cos(k * x) for k in range(40)), x), direction=1))) < 200
