# SPDX-License-Identifier: BSD-3-Clause
"""Units with contacts, for co-simulation: valid, on the motion of `kn.simulate`, from mode to mode within steps."""

import numpy as np
import pytest

import kane as kn
from tests.interop.fmu.units import TIGHT, far, instantiated, model, reference, states_of, written
from tests.motion.emitted import block
from tests.peer import require

fmpy = require("fmpy")
validation = require("fmpy.validation")


def ran(unit, end, samples, **more):
    """What fmpy records at `samples` communication points."""
    return fmpy.simulate_fmu(
        str(unit.path), fmi_type="CoSimulation", stop_time=end, step_size=end / (samples - 1), relative_tolerance=TIGHT,
        output_interval=end / (samples - 1), record_events=False, timeout=60, **more,
    )  # fmt: skip


ENDS = {"bouncing_ball": 2.0, "mass_on_belt": 5.0, "rocking_block": 3.0, "stacked_blocks": 2.0, "pool_ball": 1.0}


@pytest.mark.slow
@pytest.mark.parametrize("version", ["2.0", "3.0"])
@pytest.mark.parametrize("name", sorted(ENDS))
def test_the_motion_is_that_of_simulate(tmp_path, name, version):
    """Impacts, stick and slip between communication points."""
    end = ENDS[name]
    eom, given = model(name)
    unit = written(tmp_path, name, eom, given, version=version)
    assert validation.validate_fmu(str(unit.path)) == []
    sol = reference(eom, end, 21, given)
    expected = sol.states[[np.flatnonzero(sol.t <= t + 1e-12)[-1] for t in np.linspace(0, end, 21)]]
    found = states_of(ran(unit, end, 21, output=[s.name for s in eom.state]), eom)
    assert far(found, expected) < 1e-8


def slave(folder, unit, end):
    """An instance that is ready to step, and value references by name."""
    one, at = instantiated(folder, unit, "CoSimulation")
    one.enterInitializationMode(tolerance=TIGHT, stopTime=end)
    one.exitInitializationMode()
    return one, at


@pytest.mark.slow
def test_inputs_push_what_sticks_until_it_slips(tmp_path):
    """Of a block on a table: outputs are those of the mode, a kept state goes on as before, a parameter changes what slips."""
    eom = block()
    (table,) = eom.system.contacts
    outputs = {"friction": table.friction_forces[0], "acceleration": eom.speeds[0].dt}
    given = {"q": {"x": 0.0}, "u": {"u_x": 0.0}}
    unit = written(tmp_path, "block", eom, given, outputs=outputs)
    assert validation.validate_fmu(str(unit.path)) == []
    one, at = slave(tmp_path / "run", unit, 3.0)

    def went(force, first, steps):
        one.setFloat64([at["F"]], [force])
        for k in range(steps):
            one.doStep(first + 0.1 * k, 0.1)
        return one.getFloat64([at[name] for name in ("x", "u_x", "friction", "acceleration")])

    most, slides = 0.3 * 2 * 9.81, 0.2 * 2 * 9.81
    assert went(most - 0.01, 0.0, 5) == pytest.approx([0, 0, 0.01 - most, 0], abs=1e-12)
    gained = (most + 0.01 - slides) / 2
    v = 0.5 * gained
    assert went(most + 0.01, 0.5, 5) == pytest.approx([0.25 * v, v, -slides, gained], abs=1e-9)
    kept = one.getFMUState()
    after = went(0.0, 1.0, 10)
    assert after == pytest.approx([0.25 * v + v**2 / (2 * 0.2 * 9.81), 0, 0, 0], abs=1e-9)
    one.setFMUState(kept)
    assert went(0.0, 1.0, 10) == after
    one.freeInstance()


@pytest.mark.slow
def test_importers_with_event_mode_are_asked_where_modes_change(tmp_path):
    """A row before and after an impact, at its instant, which the log names; all other hosts step on."""
    eom, given = model("bouncing_ball")
    unit = written(tmp_path, "ball", eom, given)
    sol, logged = reference(eom, 1.0, 11, given), []
    rows = ran(
        unit, 1.0, 11, use_event_mode=True, early_return_allowed=True, output=["y", "u_y"], debug_logging=True,
        logger=lambda *a: logged.append(a[-1] if isinstance(a[-1], str) else a[-1].decode()),
    )  # fmt: skip
    ((event, t),) = sol.events
    at = next(k for k in range(1, len(rows)) if rows["u_y"][k] > 0 > rows["u_y"][k - 1])
    assert rows["time"][at] == rows["time"][at - 1] == pytest.approx(t, abs=1e-9)
    before, after = sol.states[sol.t == t]
    assert [rows["u_y"][at - 1], rows["u_y"][at]] == pytest.approx([before[1], after[1]], abs=1e-8)
    assert far(np.array([rows["y"][-1], rows["u_y"][-1]]), sol.states[-1]) < 1e-8
    assert any(line.startswith(f"{event.name} at t = ") for line in logged)
    assert sum("floor: separated" in line for line in logged) == 2


@pytest.mark.slow
def test_they_are_for_co_simulation_alone(tmp_path):
    """Of model exchange neither the description nor the library knows anything; too many modes are refused."""
    eom, given = model("bouncing_ball")
    for version in ("2.0", "3.0"):
        unit = written(tmp_path, "ball", eom, given, version=version)
        description = fmpy.read_model_description(str(unit.path))
        assert description.modelExchange is None
        assert description.coSimulation is not None
        with pytest.raises(Exception, match=r"[Mm]odel [Ee]xchange|ModelExchange"):
            fmpy.simulate_fmu(str(unit.path), fmi_type="ModelExchange")
    with pytest.raises(kn.ProgramError, match="a unit supports, got 64 modes of contacts, too many to include all"):
        kn.exchange.to_fmu(model("skidding_bicycle")[0], tmp_path / "refused.fmu", **model("skidding_bicycle")[1])
